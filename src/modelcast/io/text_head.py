"""The beginning of a file of text: its encoding, its first lines, their fields."""

from pathlib import Path

from modelcast.core.exceptions import DataFormatError
from modelcast.io.packed import is_packed, open_octets

__all__ = [
    "BOM",
    "as_utf8",
    "complete_lines",
    "file_head",
    "first_lines",
    "is_utf8",
    "refuse_utf16",
    "rows_expected",
    "split_fields",
]

BOM = b"\xef\xbb\xbf"
"""The byte order mark of UTF-8."""

_UTF16_BOMS = (b"\xff\xfe", b"\xfe\xff")
_HEAD_BYTES = 65536


def refuse_utf16(path: str, head: bytes) -> None:
    """Raise `DataFormatError` where a file begins with the byte order mark of UTF-16."""
    if head.startswith(_UTF16_BOMS):
        raise DataFormatError(
            path, "is UTF-16 text, as some Windows programs write it", remedy="Save it as UTF-8."
        )


def file_head(path: str) -> bytes:
    """Return the first bytes of a file of text, enough for its header.

    Raises
    ------
    DataFormatError
        Where it is UTF-16.
    """
    with open_octets(path) as file:
        head = file.read(_HEAD_BYTES)
    refuse_utf16(path, head)
    return head


def rows_expected(path: str) -> int | None:
    """Return about how many lines a file of text has, by its size and first lines; None for a packed one.

    Parameters
    ----------
    path
        The file.
    """
    if is_packed(path):
        return None
    head = file_head(path)
    lines = max(head.count(b"\n"), head.count(b"\r"), 1)
    return Path(path).stat().st_size * lines // max(len(head), 1)


def first_lines(head: bytes) -> list[str]:
    r"""Return the complete lines at the start of a file, without byte order mark and line ends.

    Examples
    --------
    >>> first_lines(b"t,x\r1,2\r3,")
    ['t,x', '1,2']
    """
    return [as_utf8(line).decode("utf-8") for line in complete_lines(head).splitlines()]


def complete_lines(head: bytes) -> bytes:
    """Return the start of a file up to its last line end (all of it without one), without byte order mark."""
    text = head.removeprefix(BOM)
    end = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
    return text[:end] or text


def as_utf8(text: bytes) -> bytes:
    r"""Return text in UTF-8; what is none is taken for Windows-1252, which has Latin-1 in it.

    Examples
    --------
    >>> as_utf8(b"L\xe4nge").decode(), as_utf8("Länge".encode()).decode()
    ('Länge', 'Länge')
    """
    if is_utf8(text):
        return text
    return text.decode("cp1252", "replace").encode()


def is_utf8(text: bytes) -> bool:
    r"""Return whether octets are text in UTF-8.

    Examples
    --------
    >>> is_utf8(b"t,x"), is_utf8(b"L\xe4nge")
    (True, False)
    """
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def split_fields(line: str, separator: str = ",") -> list[str]:
    """Return the fields of one line, stripped of blanks and quotes; a blank stands for any run of them."""
    text = line.rstrip("\r\n")
    fields = text.split() if separator == " " else text.split(separator)
    return [field.strip(' \t\r"') for field in fields]

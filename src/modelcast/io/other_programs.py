"""Files of other programs that are often taken for tables, told by their first octets."""

from modelcast.core.exceptions import DataFormatError
from modelcast.io.table_layout import is_number, table_layout
from modelcast.io.text_head import first_lines

__all__ = ["refuse_other_program"]

_AS_CSV = "Save the sheet as CSV (UTF-8) there, and name that file."
_BEGINNINGS = (
    (
        b"PK\x03\x04",
        "is a workbook (Excel, LibreOffice) or another zip archive, not text",
        _AS_CSV,
    ),
    (b"\xd0\xcf\x11\xe0", "is a workbook of an old Excel, not a table of text", _AS_CSV),
    (b"%PDF", "is a PDF", "Get the table itself, as CSV."),
    (b"{\\rtf", "is formatted text (RTF)", "Save it as plain text in UTF-8."),
    (b"<!doctype html", "is a page of the web", "Get the file that it shows or links to."),
    (b"<html", "is a page of the web", "Get the file that it shows or links to."),
)


def refuse_other_program(path: str, head: bytes) -> None:
    """Refuse a file that no reader knows, by what it is, where that shows.

    Parameters
    ----------
    path
        The file.
    head
        Its first octets.

    Raises
    ------
    DataFormatError
        Where it is a workbook, a PDF, a web page or other octets that are no text, or a table without a line
        that names its columns, or with two columns of one name.
    """
    for beginning, problem, remedy in _BEGINNINGS:
        if head.lstrip()[: len(beginning)].lower() == beginning.lower():
            raise DataFormatError(path, problem, remedy=remedy)
    if b"\0" in head:
        raise DataFormatError(
            path,
            "holds octets that are no text, and no reader knows them",
            remedy="Write it as CSV, or name its format by --format.",
        )
    layout = table_layout(first_lines(head), lambda names: len(names) > 2)
    if layout is None or len(layout.names) < 3 or layout.separator == " ":
        return
    if all(map(is_number, layout.names)):
        raise DataFormatError(
            path, "has numbers where the header row should be", row=layout.lines,
            remedy="Add a first line that names the columns, for example t_s,east_m,north_m.",
        )  # fmt: skip
    twice = next((name for name in layout.names if name and layout.names.count(name) > 1), None)
    if twice is not None:
        raise DataFormatError(
            path, f"column {twice!r} occurs more than once", row=layout.lines,
            remedy="Rename all but the one that is meant.",
        )  # fmt: skip

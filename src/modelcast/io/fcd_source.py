"""Files of floating-car data as bytes: what format they are, and compressed ones unpacked as they are read.

SUMO compresses XML and CSV where the name ends in ``.gz``; the content tells here, whatever the name. Parquet
has a compression of its own; a Parquet file inside gzip is unpacked into a temporary file, since it is read
from its end.
"""

import io
import shutil
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from typing import IO, Literal

from modelcast.core.exceptions import DataFormatError
from modelcast.io.packed import is_packed, open_octets

__all__ = ["FcdKind", "fcd_kind", "opened", "seekable", "text"]

FcdKind = Literal["csv", "parquet", "xml"]

_UNREAD = {b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"\x28\xb5\x2f\xfd": "zstd", b"PK\x03\x04": "zip"}
_MARK = b"\xef\xbb\xbf"
_IN_MEMORY = 64 * 2**20


@contextmanager
def opened(path: str) -> Generator[IO[bytes]]:
    """Yield a file's bytes, unpacked where it is packed (`modelcast.io.packed`).

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it cannot be read or unpacked, also while it is being read.
    """
    try:
        with open_octets(path) as file:
            yield file
    except OSError as error:
        raise DataFormatError(path, f"cannot be read: {error.strerror or error}") from error


@contextmanager
def seekable(path: str) -> Generator[IO[bytes]]:
    """Yield a file's bytes as `opened` does, to be read in any order.

    Parameters
    ----------
    path
        The file.
    """
    with opened(path) as file:
        if not is_packed(path):
            yield file
            return
        with tempfile.SpooledTemporaryFile(_IN_MEMORY) as whole:
            shutil.copyfileobj(file, whole)
            whole.seek(0)
            yield whole


@contextmanager
def text(path: str) -> Generator[io.TextIOWrapper]:
    """Yield a file's text, whatever is not UTF-8 replaced.

    Parameters
    ----------
    path
        The file.
    """
    with opened(path) as file, io.TextIOWrapper(file, "utf-8-sig", errors="replace", newline="") as lines:
        yield lines


def fcd_kind(path: str) -> FcdKind:
    """Return a file's format, by its content.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is empty, cannot be read, or is compressed in a way that is not read here.
    """
    with opened(path) as file:
        head = file.read(4096).removeprefix(_MARK)
    if not head.strip():
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    for mark, name in _UNREAD.items():
        if head.startswith(mark):
            raise DataFormatError(path, f"is compressed by {name}", remedy="Unpack it, or use gzip.")
    if head.startswith(b"PAR1"):
        return "parquet"
    return "xml" if head.lstrip().startswith(b"<") else "csv"

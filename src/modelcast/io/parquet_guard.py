"""What a Parquet file would take to read, looked at before a page of it is unpacked.

A few hundred octets of Parquet may stand for gigabytes: a page of equal values, a dictionary of one long
text, a footer of a million columns. Readers of Parquet believe what the file says of itself and allocate it.
So the footer, and the head of every page of the columns that are wanted, are looked at first. How many rows a
run stands for does not matter, because rows are decoded some at a time.

References
----------
Apache Parquet format 2.11: file metadata, PageHeader; Thrift compact protocol.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Sequence
from typing import Any, BinaryIO

from modelcast.core.exceptions import DataFormatError

__all__ = [
    "MOST_COLUMNS",
    "MOST_FOOTER_BYTES",
    "MOST_PAGE_BYTES",
    "require_modest_footer",
    "require_modest_pages",
]

MOST_FOOTER_BYTES = 32 * 2**20
"""Longest footer; the metadata take several times as much in memory."""

MOST_COLUMNS = 10_000
"""Columns of a table of trips, wanted or not."""

MOST_PAGE_BYTES = 256 * 2**20
"""What the largest pages and dictionaries of the wanted columns of one row group may be together."""

_TAIL_BYTES = 8
_MAGIC = b"PAR1"
_HEAD_BYTES = 512
_MOST_HEAD_BYTES = 2**20
_DELTA_OF_TEXT = frozenset({6, 7})
"""Encodings (DELTA_LENGTH_BYTE_ARRAY, DELTA_BYTE_ARRAY) whose lengths are decoded for a whole page."""
_REMEDY = "Write it anew with smaller row groups and pages, as pyarrow, Polars and DuckDB do by themselves."


def require_modest_footer(path: str, file: BinaryIO) -> None:
    """Refuse a file whose footer is longer than any table of trips has.

    Parameters
    ----------
    path
        What errors call it.
    file
        The file, open for reading.

    Raises
    ------
    DataFormatError
        Where it is, or where there is no footer.
    """
    size = file.seek(0, 2)
    file.seek(max(size - _TAIL_BYTES, 0))
    tail = file.read(_TAIL_BYTES)
    length = int.from_bytes(tail[:4], "little")
    if tail[4:] != _MAGIC or length + 2 * len(_MAGIC) + 4 > size:
        raise DataFormatError(
            path, "is not readable as Parquet: it has no footer", remedy="Check that it is complete."
        )
    if length > MOST_FOOTER_BYTES:
        raise DataFormatError(
            path,
            f"has a footer of {length:,} octets, more than {MOST_FOOTER_BYTES:,}",
            remedy="Write it anew with fewer columns and larger row groups, or into several files.",
        )


def require_modest_pages(path: str, file: BinaryIO, metadata: Any, wanted: Sequence[str]) -> None:
    """Refuse a file whose pages unpack to more than any table of trips needs.

    Parameters
    ----------
    path
        What errors call it.
    file
        The file, open for reading.
    metadata
        Its ``pyarrow.parquet.FileMetaData``.
    wanted
        The columns that will be read.

    Raises
    ------
    DataFormatError
        Where they do, where there are too many columns, or where a page is not where the footer says.
    """
    if metadata.num_columns > MOST_COLUMNS:
        raise DataFormatError(
            path, f"has {metadata.num_columns:,} columns, more than {MOST_COLUMNS:,}",
            remedy="Write the columns of the trips alone.",
        )  # fmt: skip
    schema = metadata.schema
    places = [at for at in range(metadata.num_columns) if schema.column(at).path in wanted]
    size = file.seek(0, 2)
    for number in range(metadata.num_row_groups):
        group = metadata.row_group(number)
        together = sum(_largest(path, file, group.column(at), size) for at in places)
        if together > MOST_PAGE_BYTES:
            raise DataFormatError(
                path,
                f"unpacks to pages of {together / 2**20:,.0f} MiB in row group {number}, more than "
                f"{MOST_PAGE_BYTES / 2**20:,.0f}",
                remedy=_REMEDY,
            )


def _largest(path: str, file: BinaryIO, chunk: Any, size: int) -> int:
    """Return the octets of a column's largest page and of its dictionary, unpacked."""
    at = int(chunk.data_page_offset)
    if chunk.has_dictionary_page and 0 < chunk.dictionary_page_offset < at:
        at = int(chunk.dictionary_page_offset)
    end = at + int(chunk.total_compressed_size)
    if not 0 <= at <= end <= size:
        raise _misplaced(path)
    dictionary = largest = 0
    while at < end:
        page, head = _page_head(path, file, at)
        packed = page.get((3,), -1)
        if packed < 0:
            raise _misplaced(path)
        octets = page.get((2,), 0)
        if (7,) in page:
            dictionary = max(dictionary, octets)
        else:
            texts = page.get((5, 1), page.get((8, 1), 0))
            delta = page.get((5, 2), page.get((8, 4), 0)) in _DELTA_OF_TEXT
            largest = max(largest, octets + (4 * texts if delta else 0))
        at += head + packed
    return dictionary + largest


def _misplaced(path: str) -> DataFormatError:
    return DataFormatError(
        path, "is not readable as Parquet: a page is not where the footer says",
        remedy="Check that it is complete.",
    )  # fmt: skip


def _page_head(path: str, file: BinaryIO, at: int) -> tuple[dict[tuple[int, ...], int], int]:
    """Return the whole numbers of a page's head, by the path of their fields, and its length."""
    octets = _HEAD_BYTES
    while octets <= _MOST_HEAD_BYTES:
        file.seek(at)
        head = _Compact(file.read(octets))
        try:
            return head.fields(), head.at
        except (IndexError, ValueError):
            octets *= 16
    raise _misplaced(path)


class _Compact:
    """Reads one struct of Thrift's compact protocol; IndexError where the octets end within it."""

    def __init__(self, octets: bytes) -> None:
        self._octets = octets
        self.at = 0

    def fields(self, deeper: int = 8) -> dict[tuple[int, ...], int]:
        """Return the whole numbers of a struct; those of structs within it by longer paths."""
        if not deeper:
            raise ValueError("structs within structs within structs")
        found: dict[tuple[int, ...], int] = {}
        number = 0
        while octet := self._octet():
            kind, step = octet & 0x0F, octet >> 4
            number = number + step if step else self._whole()
            if kind == 12:
                found[(number,)] = 0
                found |= {(number, *path): value for path, value in self.fields(deeper - 1).items()}
            elif kind in {4, 5, 6}:
                found[(number,)] = self._whole()
            else:
                self._skip(kind, deeper)
        return found

    def _octet(self) -> int:
        octet = self._octets[self.at]
        self.at += 1
        return octet

    def _size(self) -> int:
        value = shift = 0
        while True:
            octet = self._octet()
            value |= (octet & 0x7F) << shift
            if octet < 0x80:
                return value
            shift += 7
            if shift > 63:
                raise ValueError("no whole number is that long")

    def _whole(self) -> int:
        size = self._size()
        return (size >> 1) ^ -(size & 1)

    def _skip(self, kind: int, deeper: int) -> None:
        """Pass over a value that is neither a whole number nor a struct; in fields truth takes no octet."""
        if kind in {1, 2}:
            return
        if kind == 3:
            self.at += 1
        elif kind == 7:
            self.at += 8
        elif kind == 8:
            octets = self._size()  # which moves on itself
            self.at += octets
        elif kind in {9, 10}:
            head = self._octet()
            count = head >> 4 if head >> 4 < 15 else self._size()
            for _ in range(min(count, _MOST_HEAD_BYTES)):
                self._element(head & 0x0F, deeper)
        else:
            raise ValueError(f"no kind of value: {kind}")

    def _element(self, kind: int, deeper: int) -> None:
        if kind in {1, 2}:
            self.at += 1
        elif kind in {4, 5, 6}:
            self._whole()
        elif kind == 12:
            self.fields(deeper - 1)
        else:
            self._skip(kind, deeper)

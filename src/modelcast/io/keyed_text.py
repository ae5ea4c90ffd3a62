"""Tables of text in which some columns name the trip of a row: as blocks that can be gathered.

Fields are parted by one separator and quotes have no separator inside (`modelcast.io.text_blocks`).
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, numbered
from modelcast.io.packed import recording_stem
from modelcast.io.rows import Rows
from modelcast.io.text_blocks import Block, number_column, read_blocks, text_column
from modelcast.io.text_head import rows_expected

__all__ = ["KeyedText", "TextKey", "block_keys"]

TextKey = tuple[str, ...]
"""Values of the columns that name a trip."""


@dataclass(frozen=True, slots=True)
class KeyedText(AbstractKeyedRows[TextKey]):
    """The rows of a file.

    Parameters
    ----------
    path
        The file.
    place
        Number of each column that is read, from 0, by our name for it.
    keys
        Those that name a trip.
    numbers
        Those that are numbers.
    counts
        Numbers of fields a row may have.
    skip_lines
        Lines before the first row.
    separator
        What parts the fields.
    name_of
        The vehicle part of a trip's identifier.
    """

    path: str
    _: KW_ONLY
    place: Mapping[str, int]
    keys: Sequence[str]
    numbers: Sequence[str]
    counts: Collection[int]
    skip_lines: int
    name_of: Callable[[TextKey], str]
    separator: str = ","

    @property
    def columns(self) -> int:
        """The numbers."""
        return len(self.numbers)

    @property
    def rows_expected(self) -> int | None:
        """By the size of the file."""
        return rows_expected(self.path)

    def called(self, key: TextKey) -> str:
        """``<stem>/<vehicle>``."""
        return f"{recording_stem(self.path)}/{self.name_of(key)}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[TextKey]]:
        """Yield the file's blocks."""
        names = [*self.keys, *(self.numbers if rows else ())]
        fields = [self.place[name] for name in names]
        for block in read_blocks(
            self.path, counts=self.counts, fields=fields, skip_lines=self.skip_lines,
            numbers=[self.place[name] for name in self.numbers if name in names], separator=self.separator,
        ):  # fmt: skip
            keys, number = block_keys(self.path, block, {name: self.place[name] for name in self.keys})
            found = self._numbers(block) if rows else None
            yield KeyedBlock(block.index, keys, number, found, partial=block.partial > 0)

    def _numbers(self, block: Block) -> Rows:
        columns = {name: number_column(self.path, block, self.place[name], name) for name in self.numbers}
        return Rows(block.line, columns)


def block_keys(path: str, block: Block, places: Mapping[str, int]) -> tuple[list[TextKey], IntArray]:
    """Return the keys of a block in order of appearance, and each row's key by number, (R,).

    Parameters
    ----------
    path
        The file, for errors.
    block
        One that has the columns of the keys.
    places
        Where each of them is, by its name.

    Raises
    ------
    DataFormatError
        Where one of them is blank.
    """
    columns = [text_column(block, at).alias(name) for name, at in places.items()]
    for column in columns:
        if column.null_count():
            at = int(column.is_null().arg_true()[0])
            raise DataFormatError(
                path, f"{column.name} is blank", row=int(block.line[at]),
                remedy="Every row needs it: it names the trip.",
            )  # fmt: skip
    return numbered(columns)

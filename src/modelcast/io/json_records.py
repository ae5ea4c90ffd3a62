"""JSON objects one after another, in a file of any size: one a line, with line breaks inside, or in an array.

Blanks, line ends, commas and the array's brackets may stand between objects. A file is read in parts of
`PART_CHARACTERS`; an object of more than `MOST_CHARACTERS` is an error, and so is anything that is no object.
``NaN`` and ``Infinity`` are no JSON, and are refused.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import TextIOWrapper
from typing import Any, TextIO, cast

from modelcast.core.exceptions import DataFormatError
from modelcast.io.packed import open_octets

__all__ = ["MOST_CHARACTERS", "PART_CHARACTERS", "JsonRecords"]

PART_CHARACTERS = 1 << 20
"""Text read at a time."""

MOST_CHARACTERS = 1 << 20
"""Of one object; a basic safety message with all its extensions has about ten thousand."""

_BETWEEN = re.compile(r"[\s,\[\]]*")


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no JSON")


_DECODER = json.JSONDecoder(parse_constant=_refuse)


@dataclass(slots=True)
class JsonRecords:
    """The objects of a file.

    Parameters
    ----------
    path
        The file, UTF-8.
    cut
        Whether the last object was cut off and passed over, known once all were read.
    """

    path: str
    cut: bool = False

    def objects(self) -> Iterator[dict[str, Any]]:
        """Yield them in order.

        Raises
        ------
        DataFormatError
            Where something is no object, or too long; `row` counts objects from 1.
        """
        self.cut = False
        number = 0
        with open_octets(self.path) as octets, TextIOWrapper(octets, "utf-8-sig", newline=None) as file:
            text, at, ended = "", 0, False
            while True:
                at = self._begin(text, at)
                if at == len(text):
                    if ended:
                        return
                    text, at, ended = self._more(file, "")
                    continue
                try:
                    value, end = _DECODER.raw_decode(text, at)
                except (ValueError, RecursionError) as error:
                    short = isinstance(error, json.JSONDecodeError)
                    if short and not ended and len(text) - at <= MOST_CHARACTERS:
                        text, at, ended = self._more(file, text[at:])
                        continue
                    if short and ended and "\n" not in text[at:].strip() and text[at] == "{":
                        self.cut = True
                        return
                    raise self._wrong(number + 1, f"is no JSON, or not complete: {error}") from error
                number += 1
                if not isinstance(value, dict):
                    raise self._wrong(number, f"is no JSON object: {text[at : at + 40]!r}")
                yield cast("dict[str, Any]", value)
                at = end

    @staticmethod
    def _begin(text: str, at: int) -> int:
        """Where the next object begins."""
        between = _BETWEEN.match(text, at)
        return at if between is None else between.end()

    @staticmethod
    def _more(file: TextIO, rest: str) -> tuple[str, int, bool]:
        """What is left and the next part, from its beginning, and whether that was the last."""
        part = file.read(PART_CHARACTERS)
        return rest + part, 0, len(part) < PART_CHARACTERS

    def _wrong(self, number: int, problem: str) -> DataFormatError:
        return DataFormatError(
            self.path,
            problem,
            row=number,
            remedy="Rows count the objects of the file; correct or remove this one.",
        )

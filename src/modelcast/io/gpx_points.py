"""The track points of a GPX file as text, one after another, with what stands beside them counted."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.parsers import expat

from modelcast.core.exceptions import DataFormatError
from modelcast.io.xml_stream import fed, require_shallow

__all__ = ["CELLS", "GpxPoint", "GpxPoints"]

CELLS = ("lat", "lon", "ele", "time", "fix", "speed", "course")
"""Attributes and elements of a point that are taken, by their names."""

_NAMES = {**{name: CELLS.index(name) for name in CELLS[2:]}, "cog": CELLS.index("course")}
_EXTENDED = ("speed", "course", "cog")
_LONGEST_TEXT = 200


class GpxPoint(NamedTuple):
    """One track point.

    Parameters
    ----------
    row
        Line of its ``trkpt``.
    track, piece
        Its track and the track's segment, counted in the file from 1.
    cells
        Text by `CELLS`, None where there is none.
    """

    row: int
    track: int
    piece: int
    cells: tuple[str | None, ...]


@dataclass(slots=True)
class GpxPoints:
    """Reads one file.

    Parameters
    ----------
    path
        The file.
    others
        Way points and points of routes so far.
    tracks
        Tracks so far.
    """

    path: str
    others: int = 0
    tracks: int = 0
    _piece: int = 0
    _open: list[str] = field(default_factory=list[str])
    _found: list[GpxPoint] = field(default_factory=list[GpxPoint])
    _row: int = 0
    _cells: list[str | None] = field(default_factory=list[str | None])
    _text: str | None = None

    def __iter__(self) -> Iterator[GpxPoint]:
        """Yield the points of all tracks in the file's order.

        Raises
        ------
        DataFormatError
            Where the file is no GPX, or a point stands outside a track.
        """
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._character
        for _ in fed(self.path, self._parser):
            yield from self._found
            self._found.clear()

    _parser: expat.XMLParserType = field(init=False, repr=False)

    def _begin(self, tag: str, attributes: dict[str, str]) -> None:
        name = tag.rpartition(":")[2]
        line = self._parser.CurrentLineNumber
        if not self._open and name != "gpx":
            raise DataFormatError(self.path, f"the root is {name[:40]!r}, not gpx", row=line)
        self._open.append(name)
        require_shallow(self.path, len(self._open), line)
        if self._in_point():
            self._text = "" if self._is_taken(name) else None
        elif name == "trk":
            self.tracks += 1
        elif name == "trkseg":
            self._piece += 1
        elif name in {"wpt", "rtept"}:
            self.others += 1
        elif name == "trkpt":
            if "trk" not in self._open:
                raise DataFormatError(
                    self.path, "a track point (trkpt) outside a track (trk)", row=line,
                    remedy="Put it into one.",
                )  # fmt: skip
            self._row = line
            self._cells = [attributes.get("lat"), attributes.get("lon"), *[None] * (len(CELLS) - 2)]

    def _in_point(self) -> bool:
        return "trkpt" in self._open[:-1]

    def _is_taken(self, name: str) -> bool:
        """Return whether an element that has just begun in a point is one of ours."""
        if self._open[-2] == "trkpt":
            return name in _NAMES
        return "extensions" in self._open and name.lower() in _EXTENDED

    def _character(self, text: str) -> None:
        if self._text is not None:
            self._text += text
            if len(self._text) > _LONGEST_TEXT:
                raise DataFormatError(
                    self.path,
                    f"{self._open[-1]} holds over {_LONGEST_TEXT} characters",
                    row=self._parser.CurrentLineNumber,
                    remedy="Correct the value.",
                )

    def _end(self, tag: str) -> None:
        name = tag.rpartition(":")[2]
        if self._text is not None:
            cell = _NAMES[name.lower()]
            # A point's own element goes before an extension that says the same.
            if self._cells[cell] is None or self._open[-2] == "trkpt":
                self._cells[cell] = self._text.strip() or None
            self._text = None
        elif name == "trkpt" and not self._in_point():
            self._found.append(GpxPoint(self._row, self.tracks, self._piece, tuple(self._cells)))
        self._open.pop()

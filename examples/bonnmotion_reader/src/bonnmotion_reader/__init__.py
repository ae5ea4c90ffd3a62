"""Movement traces of BonnMotion: one line a node, with a time and a place after another."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast import (
    AbstractTripReader,
    DataFormatError,
    Tally,
    Trajectory,
    build_trajectory,
    ignore_skipped,
)

__all__ = ["BonnMotionReader"]


class BonnMotionReader(AbstractTripReader):
    """Reads ``*.movements``: of each node a line ``t x y t x y ...``, in seconds and metres.

    A place at the same time as the one before is skipped and counted. A node with fewer than two places gives
    no trip. Anything else that is wrong with a line is an error.
    """

    name: ClassVar[str] = "bonnmotion"

    def matches(self, path: Path, head: bytes) -> bool:
        """Whether the name ends as BonnMotion's does."""
        return path.suffix == ".movements"

    def read(
        self, path: str, on_skipped: Callable[[str, str], None] = ignore_skipped
    ) -> Iterator[Trajectory]:
        """Yield a trip a line, named by the file and the line's number."""
        with Path(path).open(encoding="ascii", errors="replace") as lines:
            for row, line in enumerate(lines, start=1):
                trip_id = f"{Path(path).stem}/{row}"
                places = self._places(path, row, line)
                tally, kept = Tally(), np.diff(places[:, 0], prepend=-np.inf) > 0.0
                tally.skip("time repeated", int((~kept).sum()))
                if kept.sum() < 2:
                    on_skipped(trip_id, tally.why_empty())
                    continue
                yield build_trajectory(
                    trip_id,
                    places[kept, 0],
                    places[kept, 1:],
                    source=self.name,
                    reading=tally.reading(rows=len(places), samples=int(kept.sum())),
                )

    @staticmethod
    def _places(path: str, row: int, line: str) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """Times and places of a line, (N, 3)."""
        try:
            numbers = np.array([float(word) for word in line.split()])
        except ValueError as error:
            raise DataFormatError(path, str(error), row=row, remedy="Write numbers alone.") from error
        if numbers.size % 3 or not np.isfinite(numbers).all():
            problem = f"{numbers.size} numbers are no times and places, t x y each and finite"
            raise DataFormatError(path, problem, row=row, remedy="Write three numbers a place.")
        places = numbers.reshape(-1, 3)
        if (np.diff(places[:, 0]) < 0.0).any():
            raise DataFormatError(path, "times fall", row=row, remedy="Sort the places by time.")
        return places

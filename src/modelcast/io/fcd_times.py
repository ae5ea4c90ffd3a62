"""Rows of floating-car data by time, and their positions in metres."""

from collections.abc import Iterator, Sequence

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, geodetic_to_enu
from modelcast.io.fcd_columns import FcdRow
from modelcast.io.fcd_rows import read_rows

__all__ = ["by_time", "in_metres"]


def by_time(path: str, *, people: bool = False) -> Iterator[Sequence[FcdRow]]:
    """Yield the rows of each time, checked for order; each vehicle once.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where time runs back, or a vehicle occurs twice at one time.
    """
    gathered: list[FcdRow] = []
    seen: dict[str, int] = {}
    for row in read_rows(path, people=people):
        if gathered and row.t_s != gathered[0].t_s:
            if row.t_s < gathered[0].t_s:
                raise DataFormatError(
                    path,
                    f"time runs back from {gathered[0].t_s} to {row.t_s}",
                    row=row.row,
                    remedy="Sort the file by time.",
                )
            yield gathered
            gathered, seen = [], {}
        if not row.skipped:
            if row.vehicle in seen:
                raise DataFormatError(
                    path,
                    f"vehicle {row.vehicle} occurs twice at {row.t_s} s, also in row {seen[row.vehicle]}",
                    row=row.row,
                    remedy="Leave one row a vehicle and time.",
                )
            seen[row.vehicle] = row.row
        gathered.append(row)
    if gathered:
        yield gathered


def in_metres(numbers: FloatArray, origin: Origin | None) -> FloatArray:
    """Return positions as east and north, (V, 2) [m].

    Parameters
    ----------
    numbers
        Rows whose first two columns are x and y, (V, ...).
    origin
        Where these are longitude and latitude: what they are laid out about. None for metres.
    """
    if origin is None:
        return numbers[:, :2]
    return geodetic_to_enu(numbers[:, 1], numbers[:, 0], np.zeros(len(numbers)), origin)[:, :2]

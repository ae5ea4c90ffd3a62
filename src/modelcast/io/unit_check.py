"""Whether positions move as the speeds of the same rows say, where a unit is only assumed.

A column ``t`` may hold milliseconds from the start, and then every speed that is computed from it is 1000
times too low. Nothing in the column tells; the reported speeds do. The same ratio finds degrees or kilometres
taken for metres, and a plain ``speed`` that holds km/h.
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.rows import Rows
from modelcast.trips.trajectory import GAP_STEPS

__all__ = [
    "LEAST_WAY_M",
    "LONGEST_STEP_S",
    "refuse_feet",
    "refuse_long_steps",
    "refuse_other_speed",
    "refuse_other_unit",
    "refuse_short_steps",
    "speed_unit",
    "steps_m",
    "ways_m",
]

_LARGEST_RATIO = 300.0
"""No error of a receiver or a vehicle is that large over a trip; the next unit is 1000 times off."""
_MOVING_MPS = 1.0
_FEWEST_STEPS = 20
LONGEST_STEP_S = 10.0
"""No motion of a vehicle can be told from fixes that are further apart; milliseconds of 10 ms to 10 s are."""
SHORTEST_STEP_S = 5e-4
"""No receiver of positions is faster than 2,000 a second; days of 40 ms to 40 s are."""
_FEET_PER_M = 1 / 0.3048
_SPEEDS = {
    "speed_kmh": 3.6,
    "speed_mph": 3600.0 / 1609.344,
    "speed_kn": 3600.0 / 1852.0,
    "speed_ftps": _FEET_PER_M,
}
"""Numbers in other units over those in m/s, by what a column map calls them."""
_SPEED_TOLERANCE = 0.03
"""Positions and speeds of good recordings agree to 1 % over a trip; the units are 9 % apart at least."""
LEAST_WAY_M = 50.0
_PIECE_S = 5.0
"""Way over which noise of positions counts for little beside the motion."""
_FEET_AT_LEAST = 2.0
"""From one end of such a piece to the other what is in feet moves more than this times what speeds say."""


def refuse_other_unit(path: str, rows: Rows, time: str) -> None:
    """Raise `DataFormatError` where positions move hundreds of times slower or faster than the speeds say.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m``; without ``speed_mps`` nothing is told.
    time
        Name of the time column where seconds are only assumed, else empty.
    """
    moved_m, said_m = ways_m(rows) if time else _usual_steps_m(rows)
    if moved_m > 0 and said_m > 0 and not 1 / _LARGEST_RATIO < moved_m / said_m < _LARGEST_RATIO:
        slower = "slower" if moved_m < said_m else "faster"
        ratio = max(moved_m / said_m, said_m / moved_m)
        mapped = f"Map the time by its unit ({_unit(moved_m / said_m)}={time}), or check" if time else "Check"
        raise DataFormatError(
            path,
            f"positions move {ratio:.0f} times {slower} than the speeds say",
            row=int(rows.line[0]),
            remedy=f"{mapped} the units of the positions and speeds.",
        )


def refuse_long_steps(path: str, rows: Rows, time: str) -> None:
    """Raise `DataFormatError` where times without a stated unit are so far apart that they are no seconds.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``; with a ``speed_mps`` that is not all zero, `refuse_other_unit` tells
        more.
    time
        Name of the time column.
    """
    steps_s = np.diff(rows.columns["t_s"])
    told = "speed_mps" in rows.columns and bool(np.nan_to_num(rows.columns["speed_mps"]).any())
    if told or not steps_s.size or not np.median(steps_s) >= LONGEST_STEP_S:
        return
    raise DataFormatError(
        path,
        f"{time} grows by {np.median(steps_s):g} from row to row, too much for seconds",
        row=int(rows.line[0]),
        remedy=f"Map the time by its unit, for example t_ms={time}; t_s={time} where it does hold seconds.",
    )


def refuse_short_steps(path: str, rows: Rows, time: str) -> None:
    """Raise `DataFormatError` where times without a stated unit are days, as spreadsheets count.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s`` as if it were in seconds.
    time
        Name of the time column.
    """
    steps_s = np.diff(rows.columns["t_s"])
    if not steps_s.size or not 0 < np.median(steps_s) < SHORTEST_STEP_S:
        return
    raise DataFormatError(
        path,
        f"{time} grows by {np.median(steps_s):.3g} from row to row, too little for seconds",
        row=int(rows.line[0]),
        remedy=f"Days, as a spreadsheet has dates: --columns t_days={time}. "
        f"Where it does hold seconds: --columns t_s={time}.",
    )


def refuse_other_speed(path: str, rows: Rows, speed: str) -> None:
    """Raise `DataFormatError` where speeds without a stated unit fit the positions in another unit than m/s.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m`` and ``speed_mps``.
    speed
        Name of the speed column.
    """
    told = speed_unit(rows)
    if told is not None:
        meaning, ratio = told
        raise DataFormatError(
            path,
            f"{speed} is {ratio:.2f} times what the positions move in m/s",
            row=int(rows.line[0]),
            remedy=f"Map it by its unit: {meaning}={speed}. Where it does hold m/s: speed_mps={speed}.",
        )


def refuse_feet(path: str, rows: Rows, names: tuple[str, str]) -> bool:
    """Return whether positions without a stated unit fit the speeds as metres.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m`` and ``north_m``; without ``speed_mps`` nothing is told.
    names
        Columns of east and north.

    Raises
    ------
    DataFormatError
        Where they fit them as feet.

    Notes
    -----
    From row to row noise makes positions move farther than the vehicle does, by any factor. From one end of
    some seconds to the other it does not.
    """
    moved_m, said_m = ways_m(rows)
    if not moved_m > LEAST_WAY_M:
        return False
    if not abs(said_m / moved_m * _FEET_PER_M - 1.0) <= _SPEED_TOLERANCE:
        return abs(said_m / moved_m - 1.0) <= _SPEED_TOLERANCE
    if not _far_apart(rows):
        return False
    x, y = names
    raise DataFormatError(
        path,
        f"{x} and {y} move {_FEET_PER_M:.2f} times as fast as the speeds say",
        row=int(rows.line[0]),
        remedy=f"Feet: --columns east_ft={x},north_ft={y}. "
        f"Where they are metres: --columns east_m={x},north_m={y}.",
    )


def _far_apart(rows: Rows) -> bool:
    """Return whether pieces of some seconds end farther from where they begin than a way in metres can."""
    t_s, speed_mps = rows.columns["t_s"], rows.columns["speed_mps"]
    ends = np.searchsorted(t_s, np.arange(t_s[0], t_s[-1] + _PIECE_S, _PIECE_S))
    ends = np.unique(np.minimum(ends, t_s.size - 1))
    said_m = np.add.reduceat(0.5 * (speed_mps[1:] + speed_mps[:-1]) * np.diff(t_s), ends[:-1])
    apart_m = np.hypot(np.diff(rows.columns["east_m"][ends]), np.diff(rows.columns["north_m"][ends]))
    used = said_m > _MOVING_MPS * np.diff(t_s[ends])
    return float(apart_m[used].sum()) > _FEET_AT_LEAST * float(said_m[used].sum())


def speed_unit(rows: Rows) -> tuple[str, float] | None:
    """Return what a column map calls speeds in another unit than m/s, and their ratio to the positions.

    None where no unit fits, or the way is too short to tell.

    Parameters
    ----------
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m`` and ``speed_mps``, as if that were in m/s.
    """
    moved_m, said_m = ways_m(rows)
    if not moved_m > LEAST_WAY_M:
        return None
    ratio = said_m / moved_m
    for meaning, factor in _SPEEDS.items():
        if abs(ratio / factor - 1.0) <= _SPEED_TOLERANCE:
            return meaning, ratio
    return None


def ways_m(rows: Rows) -> tuple[float, float]:
    """Return the way that positions move and that speeds say, in motion [m]; zeros where unknown.

    Parameters
    ----------
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m`` and, where it is known, ``speed_mps``.
    """
    moved_m, said_m = steps_m(rows)
    return float(moved_m.sum()), float(said_m.sum())


def _usual_steps_m(rows: Rows) -> tuple[float, float]:
    """Return the median steps of positions and speeds in motion [m]; zeros where there are few."""
    moved_m, said_m = steps_m(rows)
    return (
        (float(np.median(moved_m)), float(np.median(said_m))) if moved_m.size >= _FEWEST_STEPS else (0.0, 0.0)
    )


def steps_m(rows: Rows) -> tuple[FloatArray, FloatArray]:
    """Return the steps that positions move and that speeds say, where in motion and known, (S,) [m].

    Parameters
    ----------
    rows
        As for `ways_m`.
    """
    columns = rows.columns
    steps_s = np.diff(columns["t_s"])
    if "speed_mps" not in columns or not steps_s.size or not (steps_s > 0).all():
        return np.zeros(0), np.zeros(0)
    speed_mps = 0.5 * (columns["speed_mps"][1:] + columns["speed_mps"][:-1])
    used = (speed_mps > _MOVING_MPS) & (steps_s <= GAP_STEPS * np.median(steps_s))
    moved_m = np.hypot(np.diff(columns["east_m"]), np.diff(columns["north_m"]))
    return moved_m[used], (speed_mps * steps_s)[used]


def _unit(ratio: float) -> str:
    """Return the unit of time that would explain a ratio."""
    names = {1: "t_ms", 2: "t_us", 3: "t_ns"}
    return names.get(round(-np.log10(ratio) / 3.0), "t_s")

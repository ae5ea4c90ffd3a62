"""Whether positions move as the speeds of the same rows say, where the unit of time is only assumed.

A column ``t`` may hold milliseconds from the start, and then every speed that is computed from it is 1000
times too low. Nothing in the column tells; the reported speeds do. The same ratio finds degrees or kilometres
taken for metres.
"""

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.io.rows import Rows
from modelcast.trips.trajectory import GAP_STEPS

__all__ = ["refuse_long_steps", "refuse_other_unit"]

_LARGEST_RATIO = 300.0
"""No error of a receiver or a vehicle is that large over a trip; the next unit is 1000 times off."""
_MOVING_MPS = 1.0
_LONGEST_STEP_S = 15.0
"""Steps of milliseconds at 50 Hz and less, taken for seconds, are longer; nobody sees a turn by such."""
_FEWEST_ROWS = 10


def refuse_long_steps(path: str, rows: Rows) -> None:
    """Raise `DataFormatError` where the usual step is too long for any recording of a motion.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``.
    """
    if len(rows) < _FEWEST_ROWS:
        return
    step_s = float(np.median(np.diff(rows.columns["t_s"])))
    if step_s > _LONGEST_STEP_S:
        raise DataFormatError(
            path,
            f"its rows are {step_s:g} s apart, too far to follow a vehicle's motion",
            row=int(rows.line[0]),
            remedy="If the times are in milliseconds or microseconds, map the column by its unit: "
            "--columns with t_ms=NAME or t_us=NAME.",
        )


def refuse_other_unit(path: str, rows: Rows, time: str) -> None:
    """Raise `DataFormatError` where positions move hundreds of times slower or faster than the speeds say.

    Parameters
    ----------
    path
        The file.
    rows
        One vehicle's rows with ``t_s``, ``east_m``, ``north_m``; without ``speed_mps`` nothing is told.
    time
        Name of the time column.
    """
    columns = rows.columns
    steps_s = np.diff(columns["t_s"])
    if "speed_mps" not in columns or not steps_s.size or not (steps_s > 0).all():
        return
    speed_mps = 0.5 * (columns["speed_mps"][1:] + columns["speed_mps"][:-1])
    used = (speed_mps > _MOVING_MPS) & (steps_s <= GAP_STEPS * np.median(steps_s))
    moved_m = np.hypot(np.diff(columns["east_m"]), np.diff(columns["north_m"]))[used].sum()
    said_m = (speed_mps * steps_s)[used].sum()
    if moved_m > 0 and said_m > 0 and not 1 / _LARGEST_RATIO < moved_m / said_m < _LARGEST_RATIO:
        slower = "slower" if moved_m < said_m else "faster"
        ratio = max(moved_m / said_m, said_m / moved_m)
        raise DataFormatError(
            path,
            f"positions move {ratio:.0f} times {slower} than the speeds say",
            row=int(rows.line[0]),
            remedy=f"Map the time by its unit ({_unit(moved_m / said_m)}={time}), or check the units of the "
            "positions and speeds.",
        )


def _unit(ratio: float) -> str:
    """Return the unit of time that would explain a ratio."""
    names = {1: "t_ms", 2: "t_us", 3: "t_ns"}
    return names.get(round(-np.log10(ratio) / 3.0), "t_s")

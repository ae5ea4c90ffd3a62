"""What `modelcast trips` says of a table: which column was taken for what, and what its cells alone told."""

from collections.abc import Mapping, Sequence

from modelcast.core.arrays import FloatArray
from modelcast.io.column_guess import suggested_columns
from modelcast.io.column_map import ColumnMap
from modelcast.io.column_meanings import GEODETIC, LOCAL
from modelcast.io.header_names import stated_unit
from modelcast.io.time_column import TimeUnit
from modelcast.trips.understood import Understood

__all__ = ["FIRST_ROWS", "understood"]

FIRST_ROWS = 200
"""Rows that are looked at to say what a column may mean."""

_UNITS = {1.0: "seconds", 1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds", 86400.0: "days"}


def understood(
    found: ColumnMap,
    cells: Mapping[str, Sequence[str]],
    time: TimeUnit,
    *,
    written: str = "",
    far_m: FloatArray | None = None,
) -> Understood:
    """Return what a table was taken for.

    Parameters
    ----------
    found
        What its columns mean.
    cells
        Its first rows, by column; columns that are not in it are not guessed at.
    time
        What its times mean, once one was read.
    written
        How its text is written.
    far_m
        The point that its positions are counted from, (2,) [m], where they are far from their zero.
    """
    assumed = [f"{time.assumed} in seconds"] if time.assumed else []
    assumed += [f"{found.speed_assumed} in m/s"] if found.speed_assumed else []
    if found.geodetic and not found.degrees_stated:
        assumed.append(f"{' and '.join(found.numbers[name][0] for name in GEODETIC)} in degrees")
    if not found.geodetic and found.numbers[LOCAL[0]][1] == 1.0:
        loose = [name for name in (found.numbers[axis][0] for axis in LOCAL) if stated_unit(name) != "m"]
        assumed += [f"{' and '.join(loose)} in metres"] if loose else []
    notes = {
        "text": written,
        "time": _time(time),
        "position": "" if far_m is None else _on_grid(far_m),
        "assumed": "; ".join(assumed),
    }
    return Understood(
        dict(found.meanings),
        found.unused,
        suggested_columns(found.meanings, found.unused, cells) if found.unused else {},
        {subject: text for subject, text in notes.items() if text},
    )


def _time(time: TimeUnit) -> str:
    """What the times are, in words."""
    if time.text:
        return time.text
    unit = _UNITS.get(time.unit_s, f"units of {time.unit_s:g} s")
    if time.told:
        return f"Unix {unit}, told by their size"
    return f"{unit} from the first" if time.start or time.unit_s != 1.0 else unit


def _on_grid(far_m: FloatArray) -> str:
    east, north = far_m
    return (
        f"a grid of a map (as UTM; its zone is not known), counted from ({east:.0f}, {north:.0f}); north is "
        "the grid's"
    )

"""What columns may mean whose names do not say it for certain: for a person to check, never for reading.

An error shows such a guess as a whole column map, `modelcast trips` as what could be added to what was read.
Names tell first (`_LIKELY`), then the numbers of the first rows (`modelcast.io.map_guess`).
"""

import re
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.io.column_meanings import MEANINGS, PLACED, filled
from modelcast.io.header_names import told_meanings

__all__ = ["example_map", "suggested_columns"]

_LIKELY: Mapping[str, str] = MappingProxyType(
    {
        "t_ns": r"(time|stamp|^t)[^a-z]*(ns|nano\w*)\b",
        "t_us": r"(time|stamp|^t)[^a-z]*(us|µs|micro\w*)\b",
        "t_ms": r"(time|stamp|^t)[^a-z]*(ms|milli\w*)\b",
        "t": r"time|stamp|date|^t\b|^sec|clock|utc|zeit|temps|hora|fecha",
        "lat": r"lat|breite",
        "lon": r"lon|lng|länge|laenge",
        "east_ft": r"(east|^x|_x\b).*(ft|feet)",
        "north_ft": r"(north|^y(?!aw)|_y\b).*(ft|feet)",
        "east": r"east|^x|[^a-z]x\b|_x\b|^e\d*$|pos_?x",
        "north": r"north|^y(?!aw)|[^a-z]y\b|_y\b|^n\d*$|pos_?y",
        "speed_kmh": r"(speed|vel|geschw|^v\d*_).*(km/?h|kph)",
        "speed_mph": r"(speed|vel|geschw|^v\d*_).*(mph|mi/?h|miles)",
        "speed_kn": r"(speed|vel|geschw|^v\d*_).*(knot|kn\b|kts?\b)",
        "speed_ftps": r"(speed|vel|geschw|^v\d*_).*(ft|feet)",
        "speed": r"speed|veloc|geschw|^v\b|^v_?(mps|ms|ego|gps|veh)?$|^vel\b",
        "vehicle": r"veh|kennzeich|^id$|track|^car|agent|^device",
    }
)
"""What a column may mean, by its name in lower case."""

_HEADING = r"head|hdg|^cog\b|course|bearing|kurs|^psi\b|^yaw(?!.*rate)"

_PAIRS = (("lat", "lon"), ("east_ft", "north_ft"), ("east", "north"))
_SHOWN = {*PLACED, "speed_mps", "heading_rad", "vehicle"}
"""What an example of a column map shows."""
_MARKS = set(",='")
"""What a name may not hold to stand in a column map."""


def example_map(
    names: Collection[str],
    chosen: Mapping[str, str] = MappingProxyType({}),
    *,
    cells: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """Return an example of a column map made of a table's own columns, for an error.

    A needed column that no name tells is shown as ``?``: a guess would be read without a word.

    Parameters
    ----------
    names
        The table's columns.
    chosen
        Columns by meaning that the user gave already.
    cells
        The table's first rows, by column, where they are known: they tell the vehicle and units of speeds.

    Examples
    --------
    >>> example_map(["Stamp_ns", "Position Lat", "Position Lon", "v [km/h]", "id"])
    "--columns 't_ns=Stamp_ns,lat=Position Lat,lon=Position Lon,speed_kmh=v [km/h],vehicle=id'"
    >>> example_map(["time", "b", "c"])
    "--columns 't=time,east=?,north=?' (put a column in place of each ?)"
    """
    guess = _guessed(names, chosen, cells)
    time = next((meaning for meaning in guess if MEANINGS[meaning].fills == "t_s"), "t")
    pair = min(_PAIRS[::-1], key=lambda pair: (-len({*pair} & chosen.keys()), not {*pair} <= guess.keys()))
    others = [
        meaning
        for meaning in guess
        if MEANINGS[meaning].fills not in PLACED and (meaning in chosen or MEANINGS[meaning].fills in _SHOWN)
    ]
    shown = ",".join(f"{meaning}={guess.get(meaning, '?')}" for meaning in (time, *pair, *others))
    return f"--columns '{shown}'" + (" (put a column in place of each ?)" if "=?" in shown else "")


def suggested_columns(
    meanings: Mapping[str, str], unused: Collection[str], cells: Mapping[str, Sequence[str]]
) -> dict[str, str]:
    """Return what columns that are not read may mean, by meaning.

    Parameters
    ----------
    meanings
        The column of each meaning that is read.
    unused
        The others.
    cells
        The table's first rows, by column; nothing is guessed where a column that is read is not among them.

    Examples
    --------
    >>> read = {"t": "t", "east": "x", "north": "y"}
    >>> cells = {"t": ["0", "1", "2"], "x": ["0", "9", "18"], "y": ["0", "0", "0"], "hdg": ["90"] * 3}
    >>> suggested_columns(read, ["hdg"], cells)
    {'heading_deg': 'hdg'}
    """
    if not cells.keys() >= set(meanings.values()):
        return {}
    known = filled(meanings) | PLACED
    guess = _guessed([name for name in unused if name in cells], meanings, cells)
    return {meaning: name for meaning, name in guess.items() if MEANINGS[meaning].fills not in known}


def _guessed(
    names: Collection[str], chosen: Mapping[str, str], cells: Mapping[str, Sequence[str]] | None
) -> dict[str, str]:
    """Return the column of each meaning, those chosen among them."""
    free = [name for name in dict.fromkeys(names) if name and not set(name) & _MARKS]
    free = [name for name in free if name not in chosen.values()]
    given = filled(chosen)
    told = told_meanings(free)
    guess = {meaning: name for meaning, name in told.items() if MEANINGS[meaning].fills in _SHOWN - given}
    guess |= chosen
    for meaning, pattern in _LIKELY.items():
        left = [name for name in free if name not in guess.values()]
        name = next((name for name in left if re.search(pattern, name.lower())), None)
        if name is not None and MEANINGS[meaning].fills not in filled(guess):
            guess[meaning] = name
    if cells is None:
        return guess
    return _told_by_rows(guess, chosen, cells, [name for name in free if name not in guess.values()])


def _told_by_rows(
    guess: Mapping[str, str],
    chosen: Mapping[str, str],
    cells: Mapping[str, Sequence[str]],
    free: Sequence[str],
) -> dict[str, str]:
    """Return a guess with the vehicle, the unit of the speed and a heading, as first rows tell them."""
    from modelcast.io.map_guess import (  # noqa: PLC0415 - loads polars, which examples alone need
        guessed_heading,
        guessed_speed,
        guessed_vehicle,
        placed_rows,
        sampled_times,
    )

    found = dict(guess)
    heading = None
    if "heading_rad" not in filled(found):
        heading = next((name for name in free if re.search(_HEADING, name.lower())), None)
    values = None if heading is None else _numbers(cells[heading])
    time = next((meaning for meaning in found if MEANINGS[meaning].fills == "t_s"), None)
    t_s = None if time is None else sampled_times(cells[found[time]], time, found[time])
    if t_s is None:
        if heading is not None and values is not None:
            found[guessed_heading(values)] = heading
        return found
    if "vehicle" not in chosen and "trip" not in chosen:
        vehicle = guessed_vehicle(t_s, cells, [name for name in free if name != heading])
        if vehicle is not None:
            found.setdefault("vehicle", vehicle)
        elif "t_s" in filled(chosen):
            found.pop("vehicle", None)
    columns = {
        MEANINGS[meaning].fills: numbers * abs(MEANINGS[meaning].factor)
        for meaning, name in found.items()
        if MEANINGS[meaning].fills in PLACED - {"t_s"} | {"speed_mps"}
        and (numbers := _numbers(cells[name])) is not None
    }
    label = found.get("trip", found.get("vehicle"))
    extra = {} if values is None else {"angle": values}
    rows = placed_rows(t_s, columns | extra, None if label is None else cells[label])
    if heading is not None and values is not None:
        found[guessed_heading(values, rows)] = heading
    if rows is not None and "speed" in found and "speed" not in chosen and "speed_mps" in columns:
        unit = guessed_speed(rows)
        found = {unit if unit and word == "speed" else word: name for word, name in found.items()}
    return found


def _numbers(cells: Sequence[str]) -> FloatArray | None:
    """Return a column's cells as numbers, None where one is none."""
    try:
        return np.array([float(cell.replace(",", ".")) for cell in cells])
    except ValueError:
        return None

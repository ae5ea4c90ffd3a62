"""Which column of a table means what: the map that the csv and parquet readers share.

===================  ==========================  =====================================================
Meaning              Unit                        Names found without a map
===================  ==========================  =====================================================
t                    s, or told by the values    t_s, time_s (seconds for certain), t, time
t_ms, t_us, t_ns     ms, µs, ns                  t_ms, time_ms; t_us, time_us; t_ns, time_ns
east, north, up      m                           east_m, east, x; north_m, north, y; up_m, up, z
east_ft, north_ft,   ft                          east_ft; north_ft; up_ft
up_ft
lat, lon, alt        deg, deg, m                 latitude_deg, latitude, lat; longitude_deg, longitude,
                                                 lon; altitude_m, altitude, alt
alt_ft               ft                          altitude_ft, alt_ft
speed, speed_kmh     m/s, km/h                   speed_mps, speed; speed_kmh
speed_mph, speed_kn, mile/h, knot, ft/s          speed_mph; speed_kn, speed_knots; speed_ftps
speed_ftps
heading_rad, _deg    from north, clockwise       heading_rad; heading_deg
yaw_rate_radps,      rad/s, deg/s, clockwise     yaw_rate_radps; yaw_rate_degps
yaw_rate_degps
acceleration         m/s²                        acceleration_mps2
acceleration_ftps2   ft/s²                       acceleration_ftps2
vehicle              name of the vehicle         vehicle, vehicle_id
trip                 complete identifier         trip
origin_lat, _lon,    deg, deg, m; constant in a  origin_latitude_deg, origin_longitude_deg,
_alt                 trip, with east and north   origin_altitude_m
start_unix           s, Unix time of t = 0;      start_unix_s
                     constant in a trip
===================  ==========================  =====================================================

These names are case-sensitive. What they leave open, names that others use tell (``GPS Time``,
``Speed (km/h)``: `modelcast.io.header_names`). Needed are a time and east with north, or lat with lon; east
and north win where both are there. Angles have no default unit: a plain ``heading`` has to be mapped.
`modelcast.io.time_column` says how the values of a time column tell their unit.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.header_names import (
    states_degrees,
    states_metres_a_second,
    states_seconds,
    told_meanings,
)

__all__ = ["ColumnMap", "Meaning", "detected_map", "example_map", "known_map", "names_its_own", "user_map"]

_DEG = 0.017453292519943295
_FOOT_M = 0.3048
"""The international foot; that of the United States' surveys is 2 millionths longer."""
_MILE_M = 5280 * _FOOT_M
_NAUTICAL_MILE_M = 1852.0


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column holds: the SI column it fills, the factor to SI, the names it is found under."""

    fills: str
    factor: float
    names: tuple[str, ...]


MEANINGS: Mapping[str, Meaning] = {
    "t": Meaning("t_s", 1.0, ("t_s", "time_s", "t", "time")),
    "t_ms": Meaning("t_s", 1e-3, ("t_ms", "time_ms")),
    "t_us": Meaning("t_s", 1e-6, ("t_us", "time_us")),
    "t_ns": Meaning("t_s", 1e-9, ("t_ns", "time_ns")),
    "east": Meaning("east_m", 1.0, ("east_m", "east", "x")),
    "north": Meaning("north_m", 1.0, ("north_m", "north", "y")),
    "up": Meaning("up_m", 1.0, ("up_m", "up", "z")),
    "east_ft": Meaning("east_m", _FOOT_M, ("east_ft",)),
    "north_ft": Meaning("north_m", _FOOT_M, ("north_ft",)),
    "up_ft": Meaning("up_m", _FOOT_M, ("up_ft",)),
    "lat": Meaning("latitude_deg", 1.0, ("latitude_deg", "latitude", "lat")),
    "lon": Meaning("longitude_deg", 1.0, ("longitude_deg", "longitude", "lon")),
    "alt": Meaning("altitude_m", 1.0, ("altitude_m", "altitude", "alt")),
    "alt_ft": Meaning("altitude_m", _FOOT_M, ("altitude_ft", "alt_ft")),
    "speed": Meaning("speed_mps", 1.0, ("speed_mps", "speed")),
    "speed_kmh": Meaning("speed_mps", 1.0 / 3.6, ("speed_kmh",)),
    "speed_mph": Meaning("speed_mps", _MILE_M / 3600.0, ("speed_mph",)),
    "speed_kn": Meaning("speed_mps", _NAUTICAL_MILE_M / 3600.0, ("speed_kn", "speed_knots")),
    "speed_ftps": Meaning("speed_mps", _FOOT_M, ("speed_ftps",)),
    "heading_rad": Meaning("heading_rad", 1.0, ("heading_rad",)),
    "heading_deg": Meaning("heading_rad", _DEG, ("heading_deg",)),
    "yaw_rate_radps": Meaning("yaw_rate_radps", 1.0, ("yaw_rate_radps",)),
    "yaw_rate_degps": Meaning("yaw_rate_radps", _DEG, ("yaw_rate_degps",)),
    "acceleration": Meaning("acceleration_mps2", 1.0, ("acceleration_mps2",)),
    "acceleration_ftps2": Meaning("acceleration_mps2", _FOOT_M, ("acceleration_ftps2",)),
    "origin_lat": Meaning("origin_latitude_deg", 1.0, ("origin_latitude_deg",)),
    "origin_lon": Meaning("origin_longitude_deg", 1.0, ("origin_longitude_deg",)),
    "origin_alt": Meaning("origin_altitude_m", 1.0, ("origin_altitude_m",)),
    "start_unix": Meaning("start_unix_s", 1.0, ("start_unix_s",)),
    "vehicle": Meaning("vehicle", 1.0, ("vehicle", "vehicle_id")),
    "trip": Meaning("trip", 1.0, ("trip",)),
}
_SECONDS = {"t_s", "time_s"}
"""Names that say seconds; the other names of ``t`` leave the unit to the values."""

_LIKELY: Mapping[str, str] = {
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
    "speed": r"speed|veloc|geschw|^v\b|^v_?(mps|ms)?$|^vel\b",
    "vehicle": r"veh|kennzeich|^id$|track|^car|agent|^device",
}
"""What a column may mean, by its name in lower case: for examples only, never for reading."""

_HEADING = r"head|hdg|^cog\b|course|bearing|kurs|^psi\b|^yaw(?!.*rate)"

_PAIRS = (("lat", "lon"), ("east_ft", "north_ft"), ("east", "north"))
_LOCAL = ("east_m", "north_m")
_GEODETIC = ("latitude_deg", "longitude_deg")
_PLACED = {"t_s", *_LOCAL, *_GEODETIC}
_SHOWN = {*_PLACED, "speed_mps", "heading_rad", "vehicle"}
"""What an example of a column map shows."""


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """Columns of one table.

    Parameters
    ----------
    numbers
        For each SI column: the table's column and the factor to SI.
    label
        The column that names the vehicle or trip, if any.
    whole_id
        Whether `label` holds complete trip identifiers.
    time_stated
        Whether the name of the time column, or the map, states its unit.
    speed_assumed
        The speed column whose name only lets m/s be assumed, else empty.
    degrees_stated
        Whether the name of the latitude's column, or the map, states that it holds degrees.
    """

    numbers: Mapping[str, tuple[str, float]]
    label: str | None
    whole_id: bool
    time_stated: bool
    speed_assumed: str = ""
    degrees_stated: bool = False

    @property
    def geodetic(self) -> bool:
        """Whether positions are latitudes and longitudes."""
        return _LOCAL[0] not in self.numbers


def known_map(
    path: str, columns: Mapping[str, str] | None, names: Sequence[str], *, row: int | None = None
) -> ColumnMap:
    """Return what a table's columns mean, by the user's map or by their names.

    Parameters
    ----------
    path
        The file, for errors.
    columns
        The user's map, if any.
    names
        The table's columns, in order.
    row
        The line of the header, where there is one.

    Raises
    ------
    ConfigError, DataFormatError
        As `user_map`; where the names say too little; where a column that is needed occurs twice; where the
        two of a position have different units.
    """
    found = user_map(path, columns, names) if columns else detected_map(names)
    if found is None:
        raise DataFormatError(
            path,
            f"no known names of time and position among the columns {', '.join(names)}",
            row=row,
            remedy=f"Give a column map, for example {example_map(names)}.",
        )
    if not found.geodetic and len({found.numbers[name][1] for name in _LOCAL}) > 1:
        both = " and ".join(found.numbers[name][0] for name in _LOCAL)
        raise DataFormatError(
            path,
            f"columns {both} give east and north in different units",
            row=row,
            remedy="Map both in one: east with north, or east_ft with north_ft.",
        )
    used = [name for name, _ in found.numbers.values()] + ([found.label] if found.label else [])
    twice = next((name for name in used if list(names).count(name) > 1), None)
    if twice is not None:
        places = ", ".join(str(at) for at, name in enumerate(names, start=1) if name == twice)
        raise DataFormatError(
            path, f"column {twice!r} occurs more than once (columns {places})", row=row,
            remedy="Rename all but the one that is meant.",
        )  # fmt: skip
    return found


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
    free = [name for name in dict.fromkeys(names) if name and not set(name) & set(",='")]
    told = told_meanings([name for name in free if name not in chosen.values()])
    given = {MEANINGS[meaning].fills for meaning in chosen}
    guess = {meaning: name for meaning, name in told.items() if MEANINGS[meaning].fills in _SHOWN - given}
    guess |= chosen
    for meaning, pattern in _LIKELY.items():
        filled = {MEANINGS[known].fills for known in guess}
        left = [name for name in free if name not in guess.values()]
        name = next((name for name in left if re.search(pattern, name.lower())), None)
        if name is not None and MEANINGS[meaning].fills not in filled:
            guess[meaning] = name
    if cells is not None:
        guess = _told_by_rows(guess, cells, [name for name in free if name not in guess.values()])
    time = next((meaning for meaning in guess if MEANINGS[meaning].fills == "t_s"), "t")
    pair = min(_PAIRS[::-1], key=lambda pair: (-len({*pair} & chosen.keys()), not {*pair} <= guess.keys()))
    others = [
        meaning
        for meaning in guess
        if MEANINGS[meaning].fills not in _PLACED and (meaning in chosen or MEANINGS[meaning].fills in _SHOWN)
    ]
    shown = ",".join(f"{meaning}={guess.get(meaning, '?')}" for meaning in (time, *pair, *others))
    return f"--columns '{shown}'" + (" (put a column in place of each ?)" if "=?" in shown else "")


def _told_by_rows(
    guess: Mapping[str, str], cells: Mapping[str, Sequence[str]], free: Sequence[str]
) -> dict[str, str]:
    """Return a guess with the vehicle, the unit of the speed and a heading, as first rows tell them."""
    from modelcast.io.map_guess import (  # noqa: PLC0415 - loads polars, for an error alone
        guessed_heading,
        guessed_speed,
        guessed_vehicle,
        sampled_times,
    )

    found = dict(guess)
    heading = next((name for name in free if re.search(_HEADING, name.lower())), None)
    values = None if heading is None else _numbers(cells[heading])
    if heading is not None and values is not None and "heading_rad" not in _fills(found):
        found[guessed_heading(values)] = heading
    time = next((meaning for meaning in found if MEANINGS[meaning].fills == "t_s"), None)
    t_s = None if time is None else sampled_times(cells[found[time]], found[time], MEANINGS[time].factor)
    if t_s is None:
        return found
    vehicle = guessed_vehicle(t_s, cells, [name for name in free if name != heading])
    if vehicle is not None and "vehicle" not in found:
        found["vehicle"] = vehicle
    si: dict[str, FloatArray] = {}
    for meaning, name in found.items():
        numbers = _numbers(cells[name]) if MEANINGS[meaning].fills in _PLACED | {"speed_mps"} else None
        if numbers is not None:
            si[MEANINGS[meaning].fills] = numbers * MEANINGS[meaning].factor
    placed = si.keys() >= {*_LOCAL} or si.keys() >= {*_GEODETIC}
    if "speed" in found and "speed_mps" in si and placed:
        label = found.get("vehicle")
        unit = guessed_speed(t_s, si, None if label is None else cells[label])
        found = {unit if unit and word == "speed" else word: name for word, name in found.items()}
    return found


def _numbers(cells: Sequence[str]) -> FloatArray | None:
    """Return a column's cells as numbers, None where one is none."""
    try:
        return np.array([float(cell.replace(",", ".")) for cell in cells])
    except ValueError:
        return None


def detected_map(names: Collection[str]) -> ColumnMap | None:
    """Return the map of a table whose columns have default names, or None where too few have.

    Examples
    --------
    >>> detected_map(["t", "x", "y", "colour"]).numbers["east_m"]
    ('x', 1.0)
    >>> detected_map(["Timestamp", "LAT", "Lng", "Speed (km/h)"]).numbers["speed_mps"]
    ('Speed (km/h)', 0.2777777777777778)
    >>> detected_map(["a", "b"]) is None
    True
    """
    return _mapped(_found(names))


def user_map(path: str, columns: Mapping[str, str], names: Collection[str]) -> ColumnMap:
    """Return the map a user gave, checked against a table's columns.

    A map that leaves out time or position says how single columns are meant: names tell the others.

    Raises
    ------
    ConfigError
        Where a meaning is unknown, two say the same, or time or position are neither given nor told.
    DataFormatError
        Where the table has no such column.
    """
    chosen: dict[str, str] = {}
    by_found_name = {name: meaning for meaning, entry in MEANINGS.items() for name in entry.names}
    for word, name in columns.items():
        meaning = word if word in MEANINGS else by_found_name.get(word, word)
        if meaning not in MEANINGS:
            hint = f" Say {word}_rad or {word}_deg." if word == "heading" else ""
            hint = " Say yaw_rate_radps or yaw_rate_degps." if word == "yaw_rate" else hint
            raise ConfigError(
                f"Unknown meaning {word!r} in the column map.{hint} Known: {', '.join(MEANINGS)}."
            )
        if name not in names:
            raise DataFormatError(
                path, f"has no column {name!r} for {word}", remedy=f"Its columns: {', '.join(names)}."
            )
        chosen[meaning] = name
    fills = [MEANINGS[meaning].fills for meaning in chosen]
    if len(set(fills)) != len(fills):
        raise ConfigError(f"The column map {dict(columns)} names a quantity twice, in two units.")
    found = _mapped(chosen)
    rest: dict[str, str] = {}
    if found is None:
        left = [name for name in names if name not in chosen.values()]
        barred = {*fills}
        for pair, other in ((_LOCAL, _GEODETIC), (_GEODETIC, _LOCAL)):
            barred |= {*other} if {*fills} & {*pair} else set()
        rest |= {word: name for word, name in _found(left).items() if MEANINGS[word].fills not in barred}
        found = _mapped(rest | chosen)
    if found is None:
        given = ", ".join(f"{word}={name}" for word, name in columns.items())
        raise ConfigError(
            f"{path}: {given} is taken, but {_not_told({*fills} | _fills(rest))} not found: "
            f"it needs t, and east with north or lat with lon. The whole map: {example_map(names, chosen)}."
        )
    return replace(
        found,
        time_stated=found.time_stated or "t_s" in columns,
        speed_assumed="" if "speed_mps" in columns else found.speed_assumed,
        degrees_stated=found.degrees_stated or not {*_GEODETIC}.isdisjoint(columns),
    )


def _fills(meanings: Collection[str]) -> set[str]:
    return {MEANINGS[meaning].fills for meaning in meanings}


def _not_told(filled: set[str]) -> str:
    """Return which of time and position are not among SI columns, with the verb."""
    placed = filled >= {*_LOCAL} or filled >= {*_GEODETIC}
    missing = ["time"] * ("t_s" not in filled) + ["position"] * (not placed)
    return " and ".join(missing) + (" are" if len(missing) > 1 else " is")


def names_its_own(names: Collection[str]) -> bool:
    """Return whether names that this module lists tell time and position, without words of others.

    Parameters
    ----------
    names
        The table's columns.

    Examples
    --------
    >>> names_its_own(["t", "x", "y"]), names_its_own(["Time", "X [m]", "Y [m]"])
    (True, False)
    """
    own = {entry.fills for entry in MEANINGS.values() if not {*entry.names}.isdisjoint(names)}
    return "t_s" in own and (own >= {*_LOCAL} or own >= {*_GEODETIC})


def _found(names: Collection[str]) -> dict[str, str]:
    """Return the column of each meaning that names tell."""
    found: dict[str, str] = {}
    for meaning, entry in MEANINGS.items():
        name = next((name for name in entry.names if name in names), None)
        if name is not None:
            found[meaning] = name
    filled = {MEANINGS[meaning].fills for meaning in found}
    if filled >= {*_GEODETIC}:
        filled |= {*_LOCAL}
    told = told_meanings(names)
    return found | {meaning: name for meaning, name in told.items() if MEANINGS[meaning].fills not in filled}


def _mapped(found: Mapping[str, str]) -> ColumnMap | None:
    """Return the map of meanings to names, the first unit of each quantity; None where it is too little."""
    numbers: dict[str, tuple[str, float]] = {}
    for meaning, name in found.items():
        entry = MEANINGS[meaning]
        if meaning not in {"vehicle", "trip"}:
            numbers.setdefault(entry.fills, (name, entry.factor))
    local = all(name in numbers for name in _LOCAL)
    geodetic = all(name in numbers for name in _GEODETIC)
    if "t_s" not in numbers or not (local or geodetic):
        return None
    unused = (*_GEODETIC, "altitude_m") if local else (*_LOCAL, "up_m")
    kept = {fills: entry for fills, entry in numbers.items() if fills not in unused}
    label = found.get("trip", found.get("vehicle"))
    stated = "t" not in found or found["t"] in _SECONDS or states_seconds(found["t"])
    speed, factor = kept.get("speed_mps", ("", 0.0))
    assumed = speed if factor == 1.0 and not states_metres_a_second(speed) else ""
    degrees = states_degrees(kept.get(_GEODETIC[0], ("", 0.0))[0])
    return ColumnMap(kept, label, "trip" in found, stated, assumed, degrees)

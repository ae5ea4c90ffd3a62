"""Which column of a table means what: the map that csv, Parquet and data frames share.

`modelcast.io.column_meanings` has the meanings and the names that are found without a map. Needed are a time
and east with north, or lat with lon; east and north win where both are there.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.column_guess import example_map
from modelcast.io.column_meanings import GEODETIC, LABELS, LOCAL, MEANINGS, filled
from modelcast.io.header_names import stated_unit, told_meanings

__all__ = ["ColumnMap", "detected_map", "known_map", "names_its_own", "user_map"]

_SECONDS = {"t_s", "time_s"}
"""Names that say seconds; the other names of ``t`` leave the unit to the values."""

_PAIRS = {
    False: ("east and north", "east with north, or east_ft with north_ft"),
    True: ("latitude and longitude", "lat with lon, lat_e7 with lon_e7, or lat_rad with lon_rad"),
}
"""What a position is made of in words, and how its units are mapped, by whether it is on the Earth."""


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
        Whether the name of the latitude's column, or the map, states the unit that it holds.
    meanings
        The column of each meaning that is read.
    unused
        The table's other columns, in order.
    words
        Words of the user's map; one that is a full name with its unit (``east_m``) is taken at its word.
    """

    numbers: Mapping[str, tuple[str, float]]
    label: str | None
    whole_id: bool
    time_stated: bool
    speed_assumed: str = ""
    degrees_stated: bool = False
    meanings: Mapping[str, str] = field(default_factory=dict[str, str])
    unused: tuple[str, ...] = ()
    words: frozenset[str] = frozenset()

    @property
    def geodetic(self) -> bool:
        """Whether positions are latitudes and longitudes."""
        return LOCAL[0] not in self.numbers

    @property
    def day_first(self) -> bool | None:
        """Whether the map says that dates begin with the day, or the month; None where it says neither."""
        orders = {"t_dmy": True, "t_mdy": False}
        return next((first for word, first in orders.items() if word in self.meanings), None)


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
    pair = GEODETIC if found.geodetic else LOCAL
    if len({found.numbers[name][1] for name in pair}) > 1:
        both = " and ".join(found.numbers[name][0] for name in pair)
        axes, pairs = _PAIRS[found.geodetic]
        raise DataFormatError(
            path,
            f"columns {both} give {axes} in different units",
            row=row,
            remedy=f"Map both in one: {pairs}.",
        )
    used = found.meanings.values()
    twice = next((name for name in used if list(names).count(name) > 1), None)
    if twice is not None:
        places = ", ".join(str(at) for at, name in enumerate(names, start=1) if name == twice)
        raise DataFormatError(
            path, f"column {twice!r} occurs more than once (columns {places})", row=row,
            remedy="Rename all but the one that is meant.",
        )  # fmt: skip
    return replace(found, unused=tuple(name for name in names if name and name not in used))


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
            hint = (
                f" Say {word}_radps, {word}_degps, {word}_left_radps or {word}_left_degps."
                if word == "yaw_rate"
                else hint
            )
            raise ConfigError(
                f"Unknown meaning {word!r} in the column map.{hint} Known: {', '.join(MEANINGS)}."
            )
        if name not in names:
            raise DataFormatError(
                path, f"has no column {name!r} for {word}", remedy=f"Its columns: {', '.join(names)}."
            )
        chosen[meaning] = name
    fills = filled(chosen)
    if len(fills) != len(chosen):
        raise ConfigError(f"The column map {dict(columns)} names a quantity twice, in two units.")
    found = _mapped(chosen)
    rest: dict[str, str] = {}
    if found is None:
        left = [name for name in names if name not in chosen.values()]
        barred = set(fills)
        for pair, other in ((LOCAL, GEODETIC), (GEODETIC, LOCAL)):
            barred |= {*other} if fills & {*pair} else set()
        rest |= {word: name for word, name in _found(left).items() if MEANINGS[word].fills not in barred}
        found = _mapped(rest | chosen)
    if found is None:
        given = ", ".join(f"{word}={name}" for word, name in columns.items())
        raise ConfigError(
            f"{path}: {given} is taken, but {_not_told(fills | filled(rest))} not found: "
            f"it needs t, and east with north or lat with lon. The whole map: {example_map(names, chosen)}."
        )
    return replace(
        found,
        time_stated=found.time_stated or "t_s" in columns,
        speed_assumed="" if "speed_mps" in columns else found.speed_assumed,
        degrees_stated=found.degrees_stated or not {*GEODETIC}.isdisjoint(columns),
        words=frozenset(columns),
    )


def _not_told(fills: set[str]) -> str:
    """Return which of time and position are not among SI columns, with the verb."""
    placed = fills >= {*LOCAL} or fills >= {*GEODETIC}
    missing = ["time"] * ("t_s" not in fills) + ["position"] * (not placed)
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
    return "t_s" in own and (own >= {*LOCAL} or own >= {*GEODETIC})


def _found(names: Collection[str]) -> dict[str, str]:
    """Return the column of each meaning that names tell."""
    found: dict[str, str] = {}
    for meaning, entry in MEANINGS.items():
        name = next((name for name in entry.names if name in names), None)
        if name is not None:
            found[meaning] = name
    known = filled(found)
    if known >= {*GEODETIC}:
        known |= {*LOCAL}
    told = told_meanings(names)
    return found | {meaning: name for meaning, name in told.items() if MEANINGS[meaning].fills not in known}


def _mapped(found: Mapping[str, str]) -> ColumnMap | None:
    """Return the map of meanings to names, the first unit of each quantity; None where it is too little."""
    first: dict[str, str] = {}
    for meaning in found:
        if meaning not in LABELS:
            first.setdefault(MEANINGS[meaning].fills, meaning)
    local = all(fills in first for fills in LOCAL)
    geodetic = all(fills in first for fills in GEODETIC)
    if "t_s" not in first or not (local or geodetic):
        return None
    unused = (*GEODETIC, "altitude_m") if local else (*LOCAL, "up_m")
    kept = {fills: meaning for fills, meaning in first.items() if fills not in unused}
    numbers = {fills: (found[meaning], MEANINGS[meaning].factor) for fills, meaning in kept.items()}
    label = next((meaning for meaning in LABELS if meaning in found), None)
    read = {*kept.values(), label}
    speed, factor = numbers.get("speed_mps", ("", 0.0))
    latitude = kept.get(GEODETIC[0], "")
    return ColumnMap(
        numbers,
        None if label is None else found[label],
        label == "trip",
        kept["t_s"] != "t" or found["t"] in _SECONDS or stated_unit(found["t"]) == "s",
        speed if factor == 1.0 and stated_unit(speed) != "mps" else "",
        latitude not in {"", "lat"} or stated_unit(found.get(latitude, "")) == "deg",
        {meaning: found[meaning] for meaning in MEANINGS if meaning in read},
    )

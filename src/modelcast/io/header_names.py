"""What a column's name says in words of others: its quantity, and its unit where the name states one.

``Speed (km/h)``, ``vehicle_speed [kmh]`` and ``GPS Speed km/h`` say the same. A name is told by two things:

- its **unit**, in brackets or behind the last blank or underscore (``[m/s]``, ``_ms``, `` deg``);
- its **quantity**: what is left, in lower case and without marks, nor a word in front that says whose it
  is (``gps``, ``vehicle``, ``pos``).

A quantity that is not in the list, or an angle without a unit, says nothing. Nor does a yaw rate: names do
not tell which way round it is. `told_meanings` gives a meaning only where one column has it: of two that say
the same neither is taken.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

__all__ = ["are_units", "stated_unit", "told_meanings"]

_UNITS = MappingProxyType(
    {
        "s": "s sec secs second seconds",
        "ms": "ms msec millis millisecond milliseconds",
        "us": "us µs μs micros microsecond microseconds",
        "ns": "ns nanos nanosecond nanoseconds",
        "m": "m meter meters metre metres",
        "ft": "ft feet",
        "deg": "deg degs degree degrees °",
        "rad": "rad rads radian radians",
        "mps": "m/s mps ms-1 m/sec",
        "kmh": "km/h kmh kph kmph",
        "mph": "mph mi/h miles/h",
        "kn": "kn kt kts knot knots",
        "ftps": "ft/s ftps fps",
        "g": "g",
        "mps2": "m/s2 m/s² m/s^2 mps2 ms-2",
    }
)
"""Ways to write a unit, by its short name."""

_TIME = (
    "t time timestamp stamp time_stamp datetime date_time utc utc_time time_utc unix_time unixtime epoch ts"
)
_QUANTITIES = MappingProxyType(
    {
        "time": _TIME,
        "latitude": "lat latitude",
        "longitude": "lon lng long longitude",
        "east": "x east easting",
        "north": "y north northing",
        "speed": "v speed velocity vel speed_over_ground sog",
        "heading": "heading hdg course course_over_ground cog bearing",
        "acceleration": "acceleration accel longitudinal_acceleration",
        "vehicle": "vehicle vehicle_id vehicleid veh veh_id vehid car_id carid track_id trackid agent_id",
    }
)
"""Ways to write a quantity, by its name."""

_MEANINGS: Mapping[tuple[str, str], str] = MappingProxyType(
    {
        ("time", ""): "t",
        ("time", "s"): "t",
        ("time", "ms"): "t_ms",
        ("time", "us"): "t_us",
        ("time", "ns"): "t_ns",
        ("latitude", ""): "lat",
        ("latitude", "deg"): "lat",
        ("latitude", "rad"): "lat_rad",
        ("longitude", ""): "lon",
        ("longitude", "deg"): "lon",
        ("longitude", "rad"): "lon_rad",
        ("east", ""): "east",
        ("east", "m"): "east",
        ("east", "ft"): "east_ft",
        ("north", ""): "north",
        ("north", "m"): "north",
        ("north", "ft"): "north_ft",
        ("speed", ""): "speed",
        ("speed", "mps"): "speed",
        ("speed", "kmh"): "speed_kmh",
        ("speed", "mph"): "speed_mph",
        ("speed", "kn"): "speed_kn",
        ("speed", "ftps"): "speed_ftps",
        ("heading", "deg"): "heading_deg",
        ("heading", "rad"): "heading_rad",
        ("acceleration", "mps2"): "acceleration",
        ("acceleration", "g"): "acceleration_g",
        ("vehicle", ""): "vehicle",
    }
)
"""What a quantity in a unit means to a column map (`modelcast.io.column_map`)."""

_OWNERS = r"^(?:(?:gps|gnss|veh|vehicle|ego|pos|position)_)+(?=.)"
_NO_UNIT = {"", "-", "--", "1", "n/a", "none", "text", "string"}
"""What stands in a row of units for a column that has none."""
_UNIT_OF = {way: unit for unit, ways in _UNITS.items() for way in ways.split()}
_QUANTITY_OF = {way: quantity for quantity, ways in _QUANTITIES.items() for way in ways.split()}


def told_meanings(names: Collection[str]) -> dict[str, str]:
    """Return the column of each meaning that exactly one column's name tells.

    Parameters
    ----------
    names
        The table's columns.

    Examples
    --------
    >>> told_meanings(["GPS Time", "Latitude [deg]", "LNG", "Speed (km/h)", "heading"])
    {'t': 'GPS Time', 'lat': 'Latitude [deg]', 'lon': 'LNG', 'speed_kmh': 'Speed (km/h)'}
    >>> told_meanings(["speed_kmh", "Speed [m/s]"])
    {}
    >>> told_meanings(["Time", "GpsTime", "Latitude", "vehicleId"])
    {'lat': 'Latitude', 'vehicle': 'vehicleId'}
    """
    found: dict[str, list[tuple[str, str]]] = {}
    for name in names:
        quantity, unit = _parts(name)
        meaning = _MEANINGS.get((quantity, unit))
        if meaning is not None:
            found.setdefault(quantity, []).append((meaning, name))
    return dict(ways[0] for ways in found.values() if len(ways) == 1)


def are_units(cells: Sequence[str]) -> bool:
    """Return whether a row of a table holds units, blanks and dashes, and two units at least.

    Examples
    --------
    >>> are_units(["[s]", "deg", "", "km/h"]), are_units(["0", "1", "2"]), are_units(["s", "x"])
    (True, False, False)
    """
    plain = [cell.strip().strip("[](){}").replace(" ", "").lower() for cell in cells]
    return sum(cell in _UNIT_OF for cell in plain) > 1 and all(
        cell in _UNIT_OF or cell in _NO_UNIT for cell in plain
    )


def stated_unit(name: str) -> str:
    """Return the short name of the unit that a known quantity's name states, empty where it states none.

    Examples
    --------
    >>> stated_unit("Time [s]"), stated_unit("time"), stated_unit("speed_mps"), stated_unit("colour_m")
    ('s', '', 'mps', '')
    """
    quantity, unit = _parts(name)
    return unit if quantity else ""


def _parts(name: str) -> tuple[str, str]:
    """Return a name's quantity and its unit, each empty where it is not known."""
    bracket = re.fullmatch(r"(.+?)\s*[\[({]\s*(.*?)\s*[\])}]", name.strip())
    if bracket is not None:
        unit = _UNIT_OF.get(bracket[2].replace(" ", "").lower())
        return ("", "") if unit is None else (_quantity(_spaced(bracket[1])), unit)
    words = _spaced(name.strip())
    whole = _quantity(words)
    if whole:
        return whole, ""
    behind = re.fullmatch(r"(.+)[\s_]+([^\s_]+)", words)
    unit = None if behind is None else _UNIT_OF.get(behind[2])
    return ("", "") if behind is None or unit is None else (_quantity(behind[1]), unit)


def _spaced(name: str) -> str:
    """A name in lower case, its words apart where capitals tell them: ``GpsTime`` is ``gps_time``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def _quantity(words: str) -> str:
    plain = re.sub(r"[^0-9a-zµ]+", "_", words).strip("_")
    return _QUANTITY_OF.get(plain, _QUANTITY_OF.get(re.sub(_OWNERS, "", plain), ""))

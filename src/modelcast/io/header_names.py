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
from collections.abc import Collection, Mapping
from types import MappingProxyType

__all__ = ["states_degrees", "states_metres_a_second", "states_seconds", "told_meanings"]

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
        "speed": "v speed velocity vel speed_over_ground",
        "heading": "heading course course_over_ground bearing",
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
        ("longitude", ""): "lon",
        ("longitude", "deg"): "lon",
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
        ("vehicle", ""): "vehicle",
    }
)
"""What a quantity in a unit means to a column map (`modelcast.io.column_map`)."""

_OWNERS = r"^(?:(?:gps|gnss|veh|vehicle|ego|pos|position)_)+(?=.)"
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


def states_seconds(name: str) -> bool:
    """Return whether a time column's name says that it holds seconds.

    Examples
    --------
    >>> states_seconds("Time [s]"), states_seconds("time")
    (True, False)
    """
    return _parts(name) == ("time", "s")


def states_degrees(name: str) -> bool:
    """Return whether a latitude column's name says that it holds degrees.

    Examples
    --------
    >>> states_degrees("Latitude [deg]"), states_degrees("lat")
    (True, False)
    """
    return _parts(name) == ("latitude", "deg")


def states_metres_a_second(name: str) -> bool:
    """Return whether a speed column's name says that it holds metres a second.

    Examples
    --------
    >>> states_metres_a_second("speed_mps"), states_metres_a_second("speed")
    (True, False)
    """
    return _parts(name) == ("speed", "mps")


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

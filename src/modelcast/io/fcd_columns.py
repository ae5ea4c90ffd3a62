"""What the columns of floating-car data are called, which rows are vehicles, and what their values mean.

=================  =======================  ========================================================
Meaning            Unit                     Names, the first that is there
=================  =======================  ========================================================
time               s, or SUMO's h:m:s       timestep_time, t_s, time_s, t, time
vehicle            text                     vehicle_id, vehicle, id
east, north        m                        vehicle_x, east_m, east, x; vehicle_y, north_m, north, y
longitude,         deg, in place of east    longitude_deg, longitude, lon; latitude_deg, latitude, lat
latitude           and north
speed              m/s, optional            vehicle_speed, speed_mps, speed
heading            deg clockwise from       vehicle_angle, heading_deg, angle; in rad: heading_rad
                   north, optional
acceleration       m/s², optional           vehicle_acceleration, acceleration_mps2, acceleration
yaw rate           rad/s clockwise, opt.    yaw_rate_radps
length             m, optional              vehicle_length, length_m, length
=================  =======================  ========================================================

The names ``vehicle_...`` are those of SUMO's tables (``timestep_vehicle_...`` with full headers), the plain
ones those of its XML and of tables with plain headers. Other columns are left alone, but for those of SUMO
that say what a row is: tag, lane, edge, type and pos.

Where people are asked for, persons are rows of pedestrians, under a name of their own (``person <id>``), but
for those who ride in a vehicle, which SUMO names in the attribute vehicle. A vehicle is a cyclist where its
type says so: its name holds ``bike`` or ``bicycle``, as SUMO's DEFAULT_BIKETYPE.

Other rows are counted by what they are: persons, containers, vehicles off the road (SUMO writes -1073741824
for what it does not know of them), time steps without vehicles.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, nan, pi
from typing import Any, NamedTuple

from modelcast.core.exceptions import DataFormatError
from modelcast.core.kinds import Kind
from modelcast.io.rows import LARGEST

__all__ = [
    "EMPTY",
    "INVALID",
    "OFF_ROAD",
    "OTHER",
    "PERSON",
    "RIDES",
    "FcdColumns",
    "FcdRow",
    "fcd_columns",
    "fcd_row",
    "table_kind",
    "xml_columns",
]

EMPTY = "time step without vehicles"
OTHER = "other element"
"""What a row without a vehicle, and an element that is none of the traffic's, are counted as."""

OFF_ROAD = "vehicle off the road"
RIDES = "person in a vehicle"
"""What SUMO's road users that are nowhere of their own are counted as."""

_BIKES = ("bike", "bicycle")
PERSON, _CONTAINER = "person", "container"
"""Tags of SUMO's road users that are no vehicles."""

_EITHER = "person or container"
_NO_LANE = f"{_EITHER}, or off the road: no lane"
_TAGS = {"vehicle": "", PERSON: PERSON, _CONTAINER: _CONTAINER}
INVALID = -1073741824.0
"""What SUMO writes for what it does not know."""

_OFF_ROAD_BY = ("east", "north", "speed", "heading_deg", "pos")


_NAMES: Mapping[str, tuple[str, ...]] = {
    "time": ("timestep_time", "t_s", "time_s", "t", "time"),
    "vehicle": ("vehicle_id", "vehicle", "id"),
    "east": ("vehicle_x", "east_m", "east", "x"),
    "north": ("vehicle_y", "north_m", "north", "y"),
    "longitude": ("longitude_deg", "longitude", "lon"),
    "latitude": ("latitude_deg", "latitude", "lat"),
    "speed": ("vehicle_speed", "speed_mps", "speed"),
    "heading_deg": ("vehicle_angle", "heading_deg", "angle"),
    "heading_rad": ("heading_rad",),
    "acceleration": ("vehicle_acceleration", "acceleration_mps2", "acceleration"),
    "yaw_rate": ("yaw_rate_radps",),
    "length": ("vehicle_length", "length_m", "length"),
    "tag": ("vehicle_tag", "tag"),
    "lane": ("vehicle_lane", "lane"),
    "edge": ("vehicle_edge", "edge"),
    "type": ("vehicle_type", "type"),
    "pos": ("vehicle_pos", "pos"),
    "person": ("person_id",),
    "container": ("container_id",),
}
_ATTRIBUTES = {"time": "time", "vehicle": "id", "east": "x", "north": "y"}
_SUMO_ONLY = frozenset({"angle", "lane", "edge", "pos", "slope"})
_SUMO_ALL = _SUMO_ONLY | frozenset(
    {
        *("time", "id", "x", "y", "z", "type", "speed", "tag", "signals", "distance", "odometer", "route"),
        *("acceleration", "accelerationLat", "posLat", "speedLat", "speedRelative", "vehicle"),
    }
)
_FULL = "timestep_vehicle_"


class FcdRow(NamedTuple):
    """One row: a vehicle or person at one time, its unknown numbers NaN; or, where `skipped` says why, none.

    Numbers are east, north (or longitude, latitude), speed, heading, acceleration, yaw rate, length.
    """

    row: int
    t_s: float
    vehicle: str
    numbers: tuple[float, float, float, float, float, float, float]
    skipped: str = ""
    kind: Kind = Kind.VEHICLE


_NOTHING = (nan, nan, nan, nan, nan, nan, nan)


@dataclass(frozen=True, slots=True)
class FcdColumns:
    """The columns of one file.

    Parameters
    ----------
    found
        Column names by meaning.
    is_sumo
        Whether the names are SUMO's own.
    is_geographic
        Whether the names say longitude and latitude.
    """

    found: Mapping[str, str]
    is_sumo: bool
    is_geographic: bool

    @property
    def tells_vehicles(self) -> bool:
        """Whether a table of SUMO says which rows are vehicles and which persons or containers."""
        return not self.is_sumo or not {"tag", "lane", "edge"}.isdisjoint(self.found)


def fcd_columns(path: str, names: Sequence[str]) -> FcdColumns:
    """Return the columns of a table.

    Parameters
    ----------
    path
        The file.
    names
        Its column names.

    Raises
    ------
    DataFormatError
        Where a needed column is missing.
    """
    plain = {name.replace(_FULL, "vehicle_", 1) if name.startswith(_FULL) else name: name for name in names}
    found: dict[str, str] = {}
    for meaning, known in _NAMES.items():
        name = next((name for name in known if name in plain), None)
        if name is not None:
            found[meaning] = plain[name]
    geographic = "longitude" in found and "latitude" in found and "east" not in found
    if geographic:
        found["east"], found["north"] = found.pop("longitude"), found.pop("latitude")
    twice = [name for name in found.values() if list(names).count(name) > 1]
    if twice:
        raise DataFormatError(path, f"two columns are called {twice[0]}", row=1, remedy="Rename one.")
    missing = [meaning for meaning in _ATTRIBUTES if meaning not in found]
    if missing:
        raise DataFormatError(
            path,
            f"no column of {missing[0]} (attribute {_ATTRIBUTES[missing[0]]} of SUMO) among "
            f"{', '.join(names)}",
            row=1,
            remedy=f"It may be called {', '.join(_NAMES[missing[0]])}; SUMO writes what "
            "--fcd-output.attributes names.",
        )
    sumo = ("timestep_time" in plain and "vehicle_x" in plain) or (
        {"time", "id", "x", "y"} <= plain.keys()
        and plain.keys() <= _SUMO_ALL
        and not _SUMO_ONLY.isdisjoint(plain)
    )
    return FcdColumns(found, sumo, geographic)


def xml_columns(attributes: Collection[str]) -> dict[str, str]:
    """Return which attribute of an element of SUMO's XML has which meaning.

    Parameters
    ----------
    attributes
        Names of the element's attributes.
    """
    found = {
        meaning: name
        for meaning, known in _NAMES.items()
        for name in known[-1:]
        if name in attributes and meaning not in {"time", "heading_rad"}
    }
    return {**found, "rides_in": "vehicle"} if "vehicle" in attributes else found


def table_kind(columns: FcdColumns) -> Callable[[Mapping[str, Any]], str]:
    """Return what tells of the values of a table's row why it is no vehicle, or nothing where it is one.

    Parameters
    ----------
    columns
        Of the table. Where SUMO gives no tag, vehicles have a lane and no edge, persons and containers an
        edge and no lane.
    """
    lane, edge, tag = (name in columns.found and columns.is_sumo for name in ("lane", "edge", "tag"))

    def kind(values: Mapping[str, Any]) -> str:
        named = _named_kind(values)
        if tag and values["tag"]:
            return _TAGS.get(values["tag"], OTHER)
        if not named and edge and values["edge"] and not (lane and values["lane"]):
            return _EITHER
        if not named and lane and not edge and not values["lane"]:
            return _NO_LANE if values["vehicle"] else ""
        return named

    return kind


def _named_kind(values: Mapping[str, Any]) -> str:
    """Return what the columns of persons and containers, or SUMO's own types, say that a row is."""
    named = str(values.get("type") or "")
    if values.get("person") or named == "DEFAULT_PEDTYPE":
        return PERSON
    return _CONTAINER if values.get("container") or named == "DEFAULT_CONTAINERTYPE" else ""


def fcd_row(
    path: str, row: int, values: Mapping[str, Any], kind: str = "", *, people: bool = False
) -> FcdRow:
    """Return a row of values by meaning.

    Parameters
    ----------
    path, row
        Where they stand.
    values
        By meaning; None, blank or absent where not known.
    kind
        Why it is no vehicle; empty where it is one.
    people
        Whether persons are wanted.

    Raises
    ------
    DataFormatError
        Where a needed value is missing, or a value is not a finite number or negative.
    """
    time = _time(path, row, values.get("time"))
    walks = people and kind == PERSON and bool(values.get("vehicle"))
    if walks and values.get("rides_in"):
        return FcdRow(row, time, "", _NOTHING, RIDES)
    if kind and not walks:
        return FcdRow(row, time, "", _NOTHING, kind)
    vehicle = values.get("vehicle")
    if vehicle is None or vehicle == "":
        raise DataFormatError(path, "the vehicle is blank", row=row, remedy="Name it.")
    if _is_off_road(values):
        return FcdRow(row, time, "", _NOTHING, OFF_ROAD)
    east, north = (
        _number(path, row, "east", values.get("east")),
        _number(path, row, "north", values.get("north")),
    )
    for name, value in (("east", east), ("north", north)):
        if value != value:  # noqa: PLR0124 - NaN
            raise DataFormatError(
                path,
                f"{name} (attribute {_ATTRIBUTES[name]} of SUMO) is blank",
                row=row,
                remedy="Leave the row out; SUMO writes what --fcd-output.attributes names.",
            )
    heading = _number(path, row, "heading_deg", values.get("heading_deg")) * pi / 180.0
    if heading != heading:  # noqa: PLR0124 - NaN
        heading = _number(path, row, "heading_rad", values.get("heading_rad"))
    speed = _number(path, row, "speed", values.get("speed"))
    acceleration = _number(path, row, "acceleration", values.get("acceleration"))
    yaw_rate = _number(path, row, "yaw_rate", values.get("yaw_rate"))
    length = _number(path, row, "length", values.get("length"))
    if speed < 0.0 or length < 0.0:
        name, value = ("speed", speed) if speed < 0.0 else ("length", length)
        raise DataFormatError(path, f"{name} is {value}, negative", row=row, remedy="Correct the value.")
    numbers = (east, north, speed, heading, acceleration, yaw_rate, length)
    if walks:
        return FcdRow(row, time, f"person {vehicle}", numbers, kind=Kind.PEDESTRIAN)
    return FcdRow(row, time, str(vehicle), numbers, kind=_kind_of_type(values.get("type") or ""))


@lru_cache(maxsize=256)
def _kind_of_type(name: object) -> Kind:
    """Return what vehicles of a type are."""
    named = str(name).lower()
    rides = any(bike in named for bike in _BIKES) and "motorbike" not in named
    return Kind.CYCLIST if rides else Kind.VEHICLE


def _is_off_road(values: Mapping[str, Any]) -> bool:
    """Return whether SUMO's INVALID_DOUBLE_VALUE stands for what a vehicle on the road has."""
    for name in _OFF_ROAD_BY:
        value = values.get(name)
        if value == INVALID or (isinstance(value, str) and value.startswith("-1073741824")):
            return True
    return False


def _time(path: str, row: int, value: Any) -> float:
    """Return a time, a number or SUMO's h:m:s (--human-readable-time) [s]."""
    parts = value.strip().split(":") if isinstance(value, str) else []
    if not 3 <= len(parts) <= 4:
        number = _number(path, row, "time", value)
        if number != number:  # noqa: PLR0124 - NaN
            raise DataFormatError(path, "time is blank", row=row, remedy="Leave the row out.")
        return number
    *days, hours, minutes, seconds = (_number(path, row, "time", part) for part in parts)
    total = 86400.0 * sum(days) + 3600.0 * hours + 60.0 * minutes + seconds
    if not (0.0 <= minutes < 60.0 and 0.0 <= seconds < 60.0 and total == total):  # noqa: PLR0124 - NaN
        raise DataFormatError(path, f"time is {value!r}, not h:m:s", row=row, remedy="Correct the value.")
    return total


def _number(path: str, row: int, name: str, value: Any) -> float:
    """Return a number, NaN where there is none."""
    if value is None or value == "":
        return nan
    try:
        number = inf if isinstance(value, str) and "_" in value else float(value)
    except (TypeError, ValueError, OverflowError):
        number = inf
    if not abs(number) <= LARGEST:
        raise DataFormatError(
            path, f"{name} is {value!r}, not a finite number", row=row, remedy="Correct the value."
        )
    return number

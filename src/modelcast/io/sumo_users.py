"""Who is on the roads of a running SUMO: rows of vehicles and persons, at one of its steps.

What a vehicle is follows from its vehicle class: a bicycle is a cyclist. Trains, ships and what flies are no
traffic of the road; they are skipped and counted, as are persons who ride in a vehicle.
"""

# libsumo's stubs leave most results open.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections import Counter
from dataclasses import dataclass
from math import cos, inf, nan, radians, sin
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.io.base import Tally
from modelcast.io.fcd_columns import INVALID, OFF_ROAD, PERSON, RIDES
from modelcast.io.fleet_slots import RAW_COLUMNS, Jumps

__all__ = ["RoadUsers", "UserCounts", "Users"]

_OFF_THE_ROADS = frozenset(
    {
        *("rail", "rail_electric", "rail_fast", "subway", "cable_car"),
        *("ship", "aircraft", "drone", "container"),
    }
)
"""Vehicle classes that are no traffic of the road; trams and light rail (rail_urban) are."""

_PEDESTRIANS = frozenset({"pedestrian", "wheelchair"})


@dataclass(frozen=True, slots=True)
class RoadUsers:
    """Road users at one time.

    Parameters
    ----------
    t_s
        SUMO's time [s].
    labels
        Names, each once; a person's is ``person <id>``.
    rows
        (N, 7), in the order of `modelcast.io.fleet_slots.RAW_COLUMNS`; positions are middles.
    kinds, widths_m
        Of each.
    """

    t_s: float
    labels: list[str]
    rows: FloatArray
    kinds: list[Kind]
    widths_m: list[float]


@dataclass(frozen=True, slots=True)
class _Form:
    """What does not change of a vehicle: its kind and size, or why it is skipped."""

    kind: Kind
    length_m: float
    width_m: float
    skipped: str = ""


class UserCounts:
    """Counts what was found on the roads.

    Parameters
    ----------
    jumps
        Those of the same traffic.
    """

    def __init__(self, jumps: Jumps) -> None:
        self.tally = Tally()
        self.rows = self.most = self.teleports = self.collisions = 0
        self.times = list[float]()
        self.names: dict[str, Kind] = {}
        self._jumps = jumps

    @property
    def jumps(self) -> int:
        """Jumps that no vehicle makes."""
        return self._jumps.count

    def add(self, found: RoadUsers) -> None:
        """Take in who is there at one time.

        Parameters
        ----------
        found
            They.
        """
        self.rows += len(found.labels)
        self.most = max(self.most, len(found.labels))
        self.times.append(found.t_s)
        self.names.update(zip(found.labels, found.kinds, strict=True))

    def skip(self, reason: str) -> None:
        """Count a row that is none of the traffic's.

        Parameters
        ----------
        reason
            Why.
        """
        self.rows += 1
        self.tally.skip(reason, 1)

    def of(self, kind: Kind) -> int:
        """How many road users of a kind there were.

        Parameters
        ----------
        kind
            The kind.
        """
        return Counter(self.names.values())[kind]


class Users:
    """Reads the road users of a running SUMO.

    Parameters
    ----------
    library
        libsumo, running.
    people
        Whether persons are taken; else they are skipped.
    """

    def __init__(self, library: Any, *, people: bool) -> None:
        jumps = Jumps()
        self.counts = UserCounts(jumps)
        self._library, self._people, self._jumps = library, people, jumps
        self._forms: dict[str, _Form] = {}
        self._last_s = inf

    def look(self) -> RoadUsers:
        """Return who is on the roads now, and count them."""
        now_s = float(self._library.simulation.getTime())
        labels, kinds, widths, numbers = list[str](), list[Kind](), list[float](), list[tuple[float, ...]]()
        for label in self._library.vehicle.getIDList():
            form = self._form(label)
            east, north = self._library.vehicle.getPosition(label)
            skipped = form.skipped or (OFF_ROAD if INVALID in {east, north} else "")
            if skipped:
                self.counts.skip(skipped)
                continue
            labels.append(label)
            kinds.append(form.kind)
            widths.append(form.width_m)
            numbers.append(_vehicle(self._library.vehicle, label, east, north, form.length_m))
        self._persons(labels, kinds, widths, numbers)
        rows = np.array(numbers, dtype=np.float64).reshape(-1, len(RAW_COLUMNS))
        rows[:, 3] = wrap_angle_rad(rows[:, 3])
        named = self._jumps.labels(labels, rows, now_s - self._last_s)
        self._last_s = now_s
        found = RoadUsers(now_s, named, rows, kinds, widths)
        self.counts.add(found)
        self.counts.teleports += int(self._library.simulation.getStartingTeleportNumber())
        self.counts.collisions += int(self._library.simulation.getCollidingVehiclesNumber())
        return found

    def _persons(
        self, labels: list[str], kinds: list[Kind], widths: list[float], numbers: list[tuple[float, ...]]
    ) -> None:
        """Add the persons: points, as SUMO has them."""
        person = self._library.person
        length_m, width_m = SIZES_M[Kind.PEDESTRIAN]
        for label in person.getIDList():
            east, north = person.getPosition(label)
            rides = bool(person.getVehicle(label))
            if not self._people or rides or INVALID in {east, north}:
                self.counts.skip(PERSON if not self._people else RIDES if rides else OFF_ROAD)
                continue
            labels.append(f"person {label}")
            kinds.append(Kind.PEDESTRIAN)
            widths.append(width_m)
            speed = max(float(person.getSpeed(label)), 0.0)
            numbers.append((east, north, speed, radians(person.getAngle(label)), nan, nan, length_m))

    def _form(self, label: str) -> _Form:
        found = self._forms.get(label)
        if found is None:
            vehicle = self._library.vehicle
            name = str(vehicle.getVehicleClass(label))
            kind = Kind.CYCLIST if name == "bicycle" else Kind.VEHICLE
            kind = Kind.PEDESTRIAN if name in _PEDESTRIANS else kind
            skipped = f"not on roads: {name}" if name in _OFF_THE_ROADS else ""
            found = _Form(kind, float(vehicle.getLength(label)), float(vehicle.getWidth(label)), skipped)
            self._forms[label] = found
        return found


def _vehicle(vehicle: Any, label: str, east: float, north: float, length_m: float) -> tuple[float, ...]:
    """Return a vehicle's numbers, in the order of `RAW_COLUMNS`."""
    heading = radians(vehicle.getAngle(label))
    return (
        east - 0.5 * length_m * sin(heading),
        north - 0.5 * length_m * cos(heading),
        max(float(vehicle.getSpeed(label)), 0.0),
        heading,
        float(vehicle.getAcceleration(label)),
        nan,
        length_m,
    )

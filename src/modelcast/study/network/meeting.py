"""One meeting up close: somebody comes from behind a building, and what a vehicle's host believes of them.

The traffic of a run is the same whatever is sent, so that a meeting is found in its frames alone, and filmed
in several runs: without roadside units, say, and with them.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import final

import numpy as np

from modelcast.channel.propagation import Propagation
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.study.table import TableSchema, flag, quantity, text
from modelcast.world.scenario.base import FleetFrame

__all__ = ["AFTER_S", "BEFORE_S", "FILM", "Meeting", "MeetingObserver", "Seen", "hidden_meeting"]

BEFORE_S, AFTER_S = 7.0, 1.0
"""Time that a film shows before two are nearest, and after [s]."""

_NEAR_M = 12.0
"""Who comes no nearer does not meet [m]."""

_FAST_MPS = 4.0
"""A vehicle that drives no faster 2 s before has seen the other, or waits [m/s]."""

_STEPS_M = 2.0
"""Who has come no farther in the 2 s before stands there [m]."""

_LEAD_S = 2.0
_SLACK_S = 1e-6


@dataclass(frozen=True, slots=True)
class Meeting:
    """A vehicle and a person who are near each other shortly after they could first see each other.

    Parameters
    ----------
    vehicle, person
        Their identifiers.
    kind
        Of the person.
    nearest_s, nearest_m
        When they are nearest, and how far apart [s], [m].
    sight_s
        How long before that they had been in line of sight [s].
    """

    vehicle: int
    person: int
    _: KW_ONLY
    kind: Kind
    nearest_s: float
    nearest_m: float
    sight_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What one run shows of a meeting, at N instants.

    Parameters
    ----------
    t_s
        Instants, from the nearest on, (N,) [s].
    vehicle, person
        Where both are, and their courses: east, north [m], clockwise from north [rad], (N, 3).
    sizes_m
        Length and width of both, (2, 2) [m].
    in_sight
        Whether no building is between them, (N,).
    believed
        Where the vehicle's host believes the person, NaN where it knows of none, (N, 2) [m].
    age_s
        Of what it believes by, (N,) [s].
    """

    t_s: FloatArray
    _: KW_ONLY
    vehicle: FloatArray
    person: FloatArray
    sizes_m: FloatArray
    in_sight: BoolArray
    believed: FloatArray
    age_s: FloatArray

    @property
    def error_m(self) -> FloatArray:
        """How far from the truth the person is believed, NaN where unknown, (N,) [m]."""
        way_m = self.believed - self.person[:, :2]
        return np.hypot(way_m[:, 0], way_m[:, 1])

    @property
    def distance_m(self) -> FloatArray:
        """Between both, (N,) [m]."""
        way_m = self.person[:, :2] - self.vehicle[:, :2]
        return np.hypot(way_m[:, 0], way_m[:, 1])


FILM = TableSchema(
    "film",
    "One instant of one run of a meeting; what the host believes is NaN while it does not know the person.",
    (
        text("run", "Which run."),
        quantity("t_s", "s", "Time from where both are nearest."),
        quantity("vehicle_east_m", "m", "Where the vehicle is, east."),
        quantity("vehicle_north_m", "m", "Where the vehicle is, north."),
        quantity("person_east_m", "m", "Where the person is, east."),
        quantity("person_north_m", "m", "Where the person is, north."),
        flag("in_sight", "Whether no building is between them."),
        quantity("distance_m", "m", "Distance between both."),
        quantity("believed_east_m", "m", "Where the host believes the person, east."),
        quantity("believed_north_m", "m", "Where the host believes the person, north."),
        quantity("error_m", "m", "How far from the truth that is."),
        quantity("age_s", "s", "Age of what it believes by."),
    ),
)
"""The film of a meeting: a row a run and instant."""


def hidden_meeting(
    frames: Sequence[FleetFrame], propagation: Propagation, *, since_s: float = 0.0
) -> Meeting | None:
    """The meeting with the least time in sight; one with a cyclist before any other.

    Parameters
    ----------
    frames
        Of a run, in which who is in a slot stays there.
    propagation
        It knows where buildings are.
    since_s
        No film begins before this [s].

    Returns
    -------
    Meeting or None
        None where nobody comes from behind a building so near to a vehicle that drives.
    """
    first = frames[0]
    if first.kind is None:
        return None
    person = np.flatnonzero(first.active & np.isin(first.kind, PEOPLE))
    vehicle = np.flatnonzero(first.active & (first.kind == Kind.VEHICLE))
    t_s: FloatArray = np.array([one.t_s for one in frames])
    place_m: np.ndarray[tuple[int, int, int], np.dtype[np.float64]] = np.array(
        [np.where(one.active[:, None], one.position_m, np.nan) for one in frames]
    )
    begun = int(np.searchsorted(t_s, since_s + BEFORE_S - _SLACK_S))
    end = int(np.searchsorted(t_s, float(t_s[-1]) - AFTER_S + _SLACK_S))
    lead = round(_LEAD_S / max(float(t_s[1] - t_s[0]), _SLACK_S)) if len(t_s) > 1 else 0
    found: list[Meeting] = []
    for one in person.tolist():
        way_m = place_m[:, vehicle] - place_m[:, one][:, None]
        apart_m = np.nan_to_num(np.hypot(way_m[..., 0], way_m[..., 1]), nan=np.inf)
        nearest = apart_m.argmin(axis=0)
        for column, at in enumerate(nearest.tolist()):
            other = int(vehicle[column])
            if not (begun <= at < end and apart_m[at, column] <= _NEAR_M):
                continue
            came_m: FloatArray = place_m[at, one] - place_m[at - lead, one]
            if frames[at - lead].speed_mps[other] < _FAST_MPS or np.hypot(came_m[0], came_m[1]) < _STEPS_M:
                continue
            sight_s = _sight_s(t_s, place_m[:, one], place_m[:, other], at, propagation)
            if sight_s < BEFORE_S:
                found.append(
                    Meeting(
                        int(first.vehicle_id[other]),
                        int(first.vehicle_id[one]),
                        kind=Kind(int(first.kind[one])),
                        nearest_s=float(t_s[at]),
                        nearest_m=float(apart_m[at, column]),
                        sight_s=sight_s,
                    )
                )
    return min(found, key=_rank, default=None)


def _rank(meeting: Meeting) -> tuple[bool, float, float]:
    """The least comes first."""
    return meeting.kind != Kind.CYCLIST, meeting.sight_s, meeting.nearest_m


def _sight_s(
    t_s: FloatArray, one_m: FloatArray, other_m: FloatArray, at: int, propagation: Propagation
) -> float:
    """How long before an instant two have been in sight without a break; infinite where always [s]."""
    hidden: IntArray = np.flatnonzero(~propagation.line_of_sight(one_m[: at + 1], other_m[: at + 1]))
    return float(t_s[at] - t_s[hidden[-1]]) if hidden.size else np.inf


@final
class MeetingObserver(AbstractObserver):
    """Looks at one meeting.

    Parameters
    ----------
    meeting
        Which.
    propagation
        It knows where buildings are.
    """

    def __init__(self, meeting: Meeting, propagation: Propagation) -> None:
        self._meeting, self._propagation = meeting, propagation
        self._rows: list[FloatArray] = []
        self._sizes_m: FloatArray = np.zeros((2, 2))

    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Take what the vehicle's host believes of the person, and where both are."""
        from_s = frame.t_s - self._meeting.nearest_s
        if not -BEFORE_S - _SLACK_S <= from_s <= AFTER_S + _SLACK_S:
            return
        slots = np.array([self._slot(frame, one) for one in (self._meeting.vehicle, self._meeting.person)])
        believed = loop.believed(slots[:1], slots[1:], t_s=frame.t_s)
        held = bool(believed.held[0])
        place = np.column_stack([frame.position_m, frame.heading_rad])[slots]
        width_m = np.full(len(frame), np.nan) if frame.width_m is None else frame.width_m
        self._sizes_m = np.column_stack([frame.length_m, width_m])[slots]
        self._rows.append(
            np.concatenate(
                [
                    [from_s],
                    place.ravel(),
                    believed.motion[0, :2] if held else [np.nan, np.nan],
                    [believed.age_s[0] if held else np.nan],
                ]
            )
        )

    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Nothing is looked at after a step."""

    def seen(self) -> Seen:
        """What was seen.

        Raises
        ------
        ValueError
            Where the run ended before the film began.
        """
        if not self._rows:
            raise ValueError(f"no frame within {BEFORE_S} s before {self._meeting.nearest_s} s")
        rows = np.array(self._rows)
        return Seen(
            rows[:, 0],
            vehicle=rows[:, 1:4],
            person=rows[:, 4:7],
            sizes_m=self._sizes_m,
            in_sight=self._propagation.line_of_sight(rows[:, 1:3], rows[:, 4:6]),
            believed=rows[:, 7:9],
            age_s=rows[:, 9],
        )

    def _slot(self, frame: FleetFrame, who: int) -> int:
        return int(np.flatnonzero(frame.active & (frame.vehicle_id == who))[0])

"""What a manoeuvre is, and how many of each kind a trip holds."""

from collections import Counter
from dataclasses import KW_ONLY, dataclass
from enum import StrEnum
from typing import Literal

__all__ = ["KINDS", "FoundManoeuvre", "ManoeuvreCounts", "ManoeuvreKind", "Side"]

Side = Literal["left", "right", ""]
"""To which side a manoeuvre goes; empty where it has none."""


class ManoeuvreKind(StrEnum):
    """The kinds that are counted; the unit of a manoeuvre's size follows from its kind.

    Members
    -------
    LANE_CHANGE
        A shift across the smoothed course; size is the shift [m].
    TURN
        A tight bend as at a junction; size is the change of course [rad].
    U_TURN
        A tight bend back to where the vehicle came from; size is the change of course [rad].
    ROUNDABOUT
        Entry, circulation and exit, or full circles; size is the change of course while circulating [rad].
    STOP
        Standing after motion; size is the time stood [s].
    HARD_BRAKE
        Braking over 0.4 g; size is the largest deceleration over one second [m/s²].
    """

    LANE_CHANGE = "lane change"
    TURN = "turn"
    U_TURN = "U-turn"
    ROUNDABOUT = "roundabout"
    STOP = "stop"
    HARD_BRAKE = "hard brake"

    @property
    def unit(self) -> str:
        """Unit of a manoeuvre's size."""
        return _UNITS[self]


_UNITS = {
    ManoeuvreKind.LANE_CHANGE: "m",
    ManoeuvreKind.TURN: "rad",
    ManoeuvreKind.U_TURN: "rad",
    ManoeuvreKind.ROUNDABOUT: "rad",
    ManoeuvreKind.STOP: "s",
    ManoeuvreKind.HARD_BRAKE: "m/s²",
}

KINDS = tuple(ManoeuvreKind)
"""All kinds, in the order of tables."""


@dataclass(frozen=True, slots=True)
class FoundManoeuvre:
    """One manoeuvre of a trip.

    Parameters
    ----------
    kind
        What it is.
    start_s, end_s
        When it begins and ends, in the trip's time [s].
    size
        How large it is, never negative, in the unit of its kind.
    side
        To which side: of a roundabout, the side of its island.

    Raises
    ------
    ValueError
        Where it ends before it begins or its size is negative.
    """

    kind: ManoeuvreKind
    start_s: float
    end_s: float
    _: KW_ONLY
    size: float
    side: Side = ""

    def __post_init__(self) -> None:
        if not self.end_s >= self.start_s:
            raise ValueError(f"{self.kind}: end_s {self.end_s} lies before start_s {self.start_s}")
        if not self.size >= 0.0:
            raise ValueError(f"{self.kind}: size must be at least 0, got {self.size}")

    def overlaps(self, other: "FoundManoeuvre") -> bool:
        """Whether the two have time in common."""
        return self.start_s < other.end_s and other.start_s < self.end_s


@dataclass(frozen=True, slots=True)
class ManoeuvreCounts:
    """The manoeuvres of one trip, and what they are ranked by.

    Parameters
    ----------
    trip_id
        The trip's name.
    duration_s, distance_m
        Time observed, gaps left out [s]; way gone in it [m].
    manoeuvres
        What was found, in order of time.
    """

    trip_id: str
    duration_s: float
    _: KW_ONLY
    distance_m: float
    manoeuvres: tuple[FoundManoeuvre, ...]

    @property
    def by_kind(self) -> dict[ManoeuvreKind, int]:
        """Number of manoeuvres of every kind, zero included."""
        counted = Counter(one.kind for one in self.manoeuvres)
        return {kind: counted[kind] for kind in KINDS}

    @property
    def total(self) -> int:
        """Number of manoeuvres: what trips are ranked by."""
        return len(self.manoeuvres)

    @property
    def kinds(self) -> int:
        """Number of kinds met: what decides between equal totals."""
        return len({one.kind for one in self.manoeuvres})

    @property
    def per_km(self) -> float:
        """Manoeuvres a kilometre, 0 for a trip that went nowhere: what decides next [1/km]."""
        return 1000.0 * self.total / self.distance_m if self.distance_m > 0.0 else 0.0

    @property
    def merit(self) -> tuple[int, int, float]:
        """Total, kinds, manoeuvres a kilometre: the larger, the richer the trip."""
        return self.total, self.kinds, self.per_km

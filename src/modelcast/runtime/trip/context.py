"""The context of recorded trips: the road as driven before, and the vehicle ahead, both causal.

Trips of one recording know of each other what vehicles on the road would. The vehicle ahead is one whose
*messages* were heard: each companion sends its own, of a bank without context, and the host's local dynamic
map believes them, late and lost as they are. The road is what was driven before: by the trip itself, by trips
that ended before it began, or by those that a road file was made of.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal

import numpy as np

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure import IndependentErasure
from modelcast.core.arrays import FloatArray, owned
from modelcast.core.chance import child_generator
from modelcast.models.bank import Bank
from modelcast.models.context_columns import CONTEXT_COLUMNS, ROAD_TURN
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.runtime.trip.companions import Told, hearing, tell
from modelcast.runtime.trip.together import begins_after_s, placed
from modelcast.station.banks import free_bank
from modelcast.station.context.road import (
    NO_ROADS,
    RoadCells,
    joined,
    road_cells,
    road_columns,
    roads_of,
)
from modelcast.station.context.road_kernels import Roads
from modelcast.station.context.survey import RoadSurvey
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import VelocityEstimator, velocity_estimator_for
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory

__all__ = ["ContextSettings", "TripContexts", "trip_context"]


@dataclass(frozen=True, slots=True)
class ContextSettings:
    """What a sender of a recorded trip is let know beside its own motion.

    Parameters
    ----------
    road
        Which road is remembered: of the ``own`` earlier drive and of trips that ended before on the same
        clock, these and what a survey holds of other trips, or ``none``.
    leader
        Whether the vehicle ahead is known from the messages of companions.
    bank
        What companions send, by default the best free sub-model; it reads no context itself.
    threshold_m
        Tracking error at which they send [m].
    keep_alive_s
        Their longest silence [s].
    delay_s
        From the instant that a message states to when it is heard [s].
    channel
        Which of their messages are lost; none where None.
    seed
        Of the losses.

    Raises
    ------
    ValueError
        Where a number is out of its range, or the road is another.
    """

    road: Literal["own", "none"] | RoadSurvey = "own"
    leader: bool = True
    _: KW_ONLY
    bank: Bank = field(default_factory=free_bank)
    threshold_m: float = 0.5
    keep_alive_s: float = 1.0
    delay_s: float = 0.1
    channel: AbstractChannel = field(default_factory=lambda: IndependentErasure(0.0))
    seed: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.road, RoadSurvey) and self.road not in ("own", "none"):
            raise ValueError(f"road must be own, none or a survey, got {self.road!r}")
        for name in ("threshold_m", "keep_alive_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not (np.isfinite(self.delay_s) and self.delay_s >= 0):
            raise ValueError(f"delay_s must be finite and not negative, got {self.delay_s}")

    def as_plain(self) -> Mapping[str, Any]:
        """What is let known as plain values, for summaries."""
        return {
            "road": self.road if isinstance(self.road, str) else f"survey {self.road.digest}",
            "leader": self.leader,
            "sub_models": [repr(member) for member in self.bank.members],
            "threshold_m": self.threshold_m,
            "keep_alive_s": self.keep_alive_s,
            "delay_s": self.delay_s,
        }


class TripContexts:
    """The contexts of trips that may have been recorded together; what companions say is found out once.

    Parameters
    ----------
    trips
        What each sender sees of its own motion; their identifiers differ.
    settings
        What is let known.
    estimators
        Of each trip's velocity; None for the one that fits its columns.
    recorded
        The trips as they were recorded, where their senders see them otherwise: by these a survey knows which
        of its cells were driven on the trip itself.

    Raises
    ------
    ValueError
        Where there is not one estimator or recording a trip.
    """

    def __init__(
        self,
        trips: Sequence[Trajectory],
        settings: ContextSettings | None = None,
        *,
        estimators: Sequence[VelocityEstimator] | None = None,
        recorded: Sequence[Trajectory] | None = None,
    ) -> None:
        self.trips = tuple(trips)
        self.settings = ContextSettings() if settings is None else settings
        given = [velocity_estimator_for(trip) for trip in trips] if estimators is None else list(estimators)
        if len(given) != len(self.trips):
            raise ValueError(f"estimators must be one a trip: {len(self.trips)}, got {len(given)}")
        self._recorded = self.trips if recorded is None else tuple(recorded)
        if len(self._recorded) != len(self.trips):
            raise ValueError(f"recorded must be one a trip: {len(self.trips)}, got {len(self._recorded)}")
        self._estimators = given
        self._samples: dict[int, FloatArray] = {}
        self._roads: dict[int, FloatArray] = {}
        self._cells: dict[int, RoadCells] = {}
        self._told: dict[int, Told] = {}

    def of(self, which: int, channel: AbstractChannel | None = None) -> FloatArray:
        """Context of one trip at each of its samples, (T, 13), as `modelcast.models.context_columns` has it.

        Parameters
        ----------
        which
            Its place among the trips.
        channel
            Which messages are lost; None for that of the settings.

        Raises
        ------
        IndexError
            Where there is no such trip.
        """
        own = self.trips[which]
        out = np.zeros((len(own), CONTEXT_COLUMNS))
        if self.settings.road != "none":
            out[:, ROAD_TURN:] = self._road(which)[:, ROAD_TURN:]
        if self.settings.leader:
            self._follow(which, self.settings.channel if channel is None else channel, out)
        return out

    def _sampled(self, which: int) -> FloatArray:
        """Samples of a trip, (T, 9)."""
        if which not in self._samples:
            found = sample_matrix(self.trips[which], self._estimators[which])
            self._samples[which] = owned(found[:, :SAMPLE_COLUMNS])
        return self._samples[which]

    def _road(self, which: int) -> FloatArray:
        """Context of a trip with the road's columns alone."""
        if which not in self._roads:
            self._roads[which] = road_columns(
                self.trips[which].t_s, self._sampled(which), shared=self._earlier(which)
            )
        return self._roads[which]

    def _earlier(self, which: int) -> Roads:
        """Roads of the trips that ended before one began, in its frame."""
        own, survey = self.trips[which], self.settings.road
        parts: list[RoadCells] = []
        if isinstance(survey, RoadSurvey):
            told = survey.cells(own.origin, (fingerprint(self._recorded[which]),))
            parts += [] if told is None else [told]
        for at, other in enumerate(self.trips):
            start_s = begins_after_s(other, own)
            if at == which or start_s is None or start_s + own.t_s[0] <= other.t_s[-1]:
                continue
            if at not in self._cells:
                self._cells[at] = road_cells(other.t_s, self._sampled(at))
            cells = self._cells[at]
            parts.append(RoadCells(placed(cells.numbers, other, own), cells.passes))
        return roads_of(joined(parts)) if parts else NO_ROADS

    def _follow(self, which: int, channel: AbstractChannel, out: FloatArray) -> None:
        """Write the leader's columns of a trip."""
        own, settings = self.trips[which], self.settings
        told: list[Told] = []
        for at, other in enumerate(self.trips):
            later_s = begins_after_s(own, other)
            if at == which or later_s is None:
                continue
            if later_s + other.t_s[0] > own.t_s[-1] or later_s + other.t_s[-1] < own.t_s[0]:
                continue
            if at not in self._told:
                self._told[at] = tell(
                    other, self._estimators[at], settings.bank,
                    vehicle=at, threshold_m=settings.threshold_m, keep_alive_s=settings.keep_alive_s,
                )  # fmt: skip
            one = self._told[at]
            rng = child_generator(settings.seed, own.trip_id, other.trip_id, "ahead")
            lost = channel.losses(other.t_s, rng)[one.sample]
            told.append(one.heard_by(placed(one.stated_m, other, own), later_s, lost))
        if told:
            hearing(told, own, self._sampled(which), settings.bank, delay_s=settings.delay_s, out=out)


def trip_context(
    trips: Sequence[Trajectory], which: int, settings: ContextSettings | None = None
) -> FloatArray:
    """Context of one of several trips at each of its samples, (T, 13), causal.

    Parameters
    ----------
    trips
        Trips that may have been recorded together, as their senders see them: companions are found by the
        clock they share, earlier drives too.
    which
        Place of the trip among them.
    settings
        What is let known; all of it where None.

    Notes
    -----
    For several trips of one recording `TripContexts` finds out once what each says.
    """
    return TripContexts(trips, settings).of(which)

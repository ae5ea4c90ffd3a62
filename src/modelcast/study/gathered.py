"""What an evaluation has found so far: of one trip, of some, or of all. Parts merge in the order of trips."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field

from modelcast.core.exceptions import ConfigError
from modelcast.study.playback import Playback
from modelcast.study.pooling import TrackingPool, pool_ecdf, pool_row
from modelcast.study.rate import RateCount, pooled_rates, rate_row
from modelcast.study.recording import HeldRecords
from modelcast.study.reference import pooled_references
from modelcast.study.result import (
    POOLED,
    RATES,
    REFERENCES,
    TRACKING,
    EvaluationResult,
    Manoeuvre,
    Timeline,
    TripRow,
)
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.study.tracking import Contender

__all__ = ["Gathered", "Illustration", "TripCount"]


@dataclass(frozen=True, slots=True)
class Illustration:
    """How sharp the sharpest manoeuvre is, in which trip, and its drawings where they were made.

    Parameters
    ----------
    trip, acceleration_mps2
        Which trip, and the size of the acceleration across the course [m/s²].
    timeline, manoeuvre, playback
        What the figures and the report draw; None where they are not drawn.
    """

    trip: str
    acceleration_mps2: float
    _: KW_ONLY
    timeline: Timeline | None = None
    manoeuvre: Manoeuvre | None = None
    playback: Playback | None = None


@dataclass(frozen=True, slots=True)
class TripCount:
    """The messages of one walk over a trip.

    Parameters
    ----------
    trip, count
        Which trip, and how many.
    """

    trip: str
    count: RateCount


@dataclass(slots=True)
class Gathered:
    """What was found of some trips: a few rows a trip, and pools that do not grow with them.

    Parameters
    ----------
    trips, counts, references, tracking
        Rows in the order of the trips.
    pools
        Tracking errors over the trips, by contender and loss ratio.
    failures
        Trips that could not be evaluated, with the reason.
    illustration
        The sharpest manoeuvre, the first of several alike.
    """

    trips: list[TripRow] = field(default_factory=list[TripRow])
    counts: list[TripCount] = field(default_factory=list[TripCount])
    references: list[Row] = field(default_factory=list[Row])
    tracking: list[Row] = field(default_factory=list[Row])
    pools: dict[tuple[Contender, float], TrackingPool] = field(
        default_factory=dict[tuple[Contender, float], TrackingPool]
    )
    failures: dict[str, str] = field(default_factory=dict[str, str])
    illustration: Illustration | None = None
    _names: set[str] = field(default_factory=set[str], repr=False)

    def merge(self, other: "Gathered") -> None:
        """Add what was found of other trips, which come behind these.

        Parameters
        ----------
        other
            It stays as it is.

        Raises
        ------
        ConfigError
            Where a trip is among these already; then nothing is added.
        """
        names = {row.id for row in other.trips} | set(other.failures)
        for name in sorted(names & self._names):
            raise ConfigError(f"two trips are named {name}: rename one of their files")
        self._names |= names
        self.trips += other.trips
        self.counts += other.counts
        self.references += other.references
        self.tracking += other.tracking
        for key, pool in other.pools.items():
            self.pools.setdefault(key, TrackingPool(*key)).merge(pool)
        self.failures |= other.failures
        if self.sharpness < other.sharpness:
            self.illustration = other.illustration

    def in_order(self) -> "Gathered":
        """The same with all rows in order of the trips' names, whatever the order they were found in."""
        return Gathered(
            sorted(self.trips, key=lambda row: row.id),
            sorted(self.counts, key=lambda one: one.trip),
            sorted(self.references, key=lambda row: row.trip),
            sorted(self.tracking, key=lambda row: row.trip),
            self.pools,
            dict(sorted(self.failures.items())),
            self.illustration,
        )

    @property
    def sharpness(self) -> float:
        """Acceleration of the sharpest manoeuvre so far [m/s²]; -1 where there is none."""
        return -1.0 if self.illustration is None else self.illustration.acceleration_mps2

    def result(
        self,
        settings: EvaluationSettings,
        records: HeldRecords | None = None,
        *,
        skipped: Mapping[str, str] | None = None,
        each_trip: bool = True,
    ) -> EvaluationResult:
        """All of it as a result.

        Parameters
        ----------
        settings
            What was asked for.
        records
            Messages and samples, where they were kept.
        skipped
            Files and vehicles that held no trip, with the reason.
        each_trip
            Whether the tables hold the rows of single trips beside the pooled ones.

        Raises
        ------
        ConfigError
            Where no trip could be evaluated, or none has the name to draw the map of.
        """
        if not self.trips:
            reasons = "; ".join(f"{trip}: {reason}" for trip, reason in self.failures.items())
            raise ConfigError("no usable trip" + (f" ({reasons})" if reasons else ""))
        drawn = self.illustration or Illustration("", -1.0)
        if settings.map_at is not None and drawn.manoeuvre is None:
            raise ConfigError(f"no trip named {settings.map_at[0]} to draw the map of")
        held = HeldRecords() if records is None else records
        rates = [rate_row(one.trip, one.count) for one in self.counts] if each_trip else []
        tracking, references = (self.tracking, self.references) if each_trip else ([], [])
        return EvaluationResult(
            settings.as_plain(),
            trips=tuple(self.trips),
            rates=RATES.table([*pooled_rates(one.count for one in self.counts), *rates]),
            tracking=TRACKING.table([*(pool_row(POOLED, pool) for pool in self.pools.values()), *tracking]),
            ecdfs=tuple(pool_ecdf(pool) for pool in self.pools.values()),
            timeline=drawn.timeline,
            manoeuvre=drawn.manoeuvre,
            playback=drawn.playback,
            events=held.events,
            samples=held.samples,
            failures=dict(self.failures),
            skipped=dict(skipped or {}),
            references=REFERENCES.table([*pooled_references(self.references), *references]),
        )

"""What switching models learn from: acceleration along the course and yaw rate of moving cars, by step."""

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.training.windows import at_commonest_interval
from modelcast.trips.trajectory import Trajectory

__all__ = ["Sequences", "sequences_of"]

_SHORTEST = 10


@dataclass(frozen=True, slots=True)
class Sequences:
    """Steps of several gapless sequences, one after another.

    Parameters
    ----------
    before, after
        Acceleration along the course and yaw rate at both ends of a step, (N, 2) [m/s², rad/s].
    begins
        Whether a step is the first of its sequence, (N,).
    step_s
        How long a step lasts [s].
    left_out
        Identifiers of the trips that are sampled at another interval.

    Raises
    ------
    ValueError
        Where the shapes differ, there is no step, a value is no number, or the first step does not begin a
        sequence.
    """

    before: FloatArray
    after: FloatArray
    _: KW_ONLY
    begins: BoolArray
    step_s: float
    left_out: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.begins)
        if self.before.shape != (count, 2) or self.after.shape != (count, 2):
            raise ValueError(
                f"before and after must be ({count}, 2), got {self.before.shape} and {self.after.shape}"
            )
        if not count or not self.begins[0]:
            raise ValueError("sequences need at least one step, and the first begins one")
        if not (np.isfinite(self.before).all() and np.isfinite(self.after).all()):
            raise ValueError("acceleration and yaw rate must be finite")

    def __len__(self) -> int:
        return len(self.begins)

    @classmethod
    def of(
        cls, values: Iterable[FloatArray], *, step_s: float, left_out: tuple[str, ...] = ()
    ) -> "Sequences":
        """Join sequences of values.

        Parameters
        ----------
        values
            (T, 2) each, at least two rows.
        step_s, left_out
            As above.

        Raises
        ------
        ValueError
            Where no sequence has two rows.
        """
        kept = [one for one in values if len(one) > 1]
        if not kept:
            raise ValueError("there is no sequence of at least two samples to learn modes from")
        begins = [np.arange(len(one) - 1) == 0 for one in kept]
        return cls(
            np.concatenate([one[:-1] for one in kept]),
            np.concatenate([one[1:] for one in kept]),
            begins=np.concatenate(begins),
            step_s=step_s,
            left_out=left_out,
        )

    @property
    def regressors(self) -> FloatArray:
        """Acceleration, yaw rate and 1 before each step, (N, 3)."""
        return np.column_stack([self.before, np.ones(len(self))])


def sequences_of(trips: Sequence[Trajectory]) -> Sequences:
    """Cut the sequences of trips: gapless, and while the car is fast enough to have rates.

    Parameters
    ----------
    trips
        What senders see; those not sampled at the commonest interval are left out and named.

    Raises
    ------
    ValueError
        Where nothing is left.
    """
    if not trips:
        raise ValueError("there is no trip to learn modes from")
    step_s, chosen = at_commonest_interval(trips)
    cut: list[FloatArray] = []
    for trip in chosen:
        samples = sample_matrix(trip, velocity_estimator_for(trip))
        values = np.ascontiguousarray(samples[:, [ACCELERATION, YAW_RATE]])
        stands = np.hypot(samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]) < NO_RATES_BELOW_MPS
        for first, end in pairwise(trip.segments):
            # The first two samples of a part have no rates yet where those come from velocities.
            start = int(first) + 1
            edges = [start, *(start + 1 + np.flatnonzero(stands[start + 1 : end])).tolist(), int(end)]
            cut += [values[a + 1 : b] for a, b in pairwise(edges) if b - a > _SHORTEST]
    kept = {id(trip) for trip in chosen}
    left_out = tuple(trip.trip_id for trip in trips if id(trip) not in kept)
    return Sequences.of(cut, step_s=step_s, left_out=left_out)

"""The one causal estimate of how noisy a vehicle's positions are.

Receivers differ: the white noise of recorded positions runs from under a millimetre to half a metre. A
motion model that knows it can trust good positions and mistrust bad ones. `DEFAULT_NOISE` reads it from the
vehicle's own past positions only: a difference of fourth order has nothing left of any smooth motion, but is
full of noise (``docs/decisions/009-position-noise.md`` has the alternatives and the figures).
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.sensing.noise_kernels import difference_variances, settle
from modelcast.trips.trajectory import Trajectory

__all__ = ["DEFAULT_NOISE", "NoiseEstimator", "clipped_share"]

_FREE = 10
"""First differences that are not clipped: the prior may be far off."""


@dataclass(frozen=True, slots=True)
class NoiseEstimator:
    """A named causal estimate of the white position noise.

    Parameters
    ----------
    name
        As in tables.
    order
        Order of the differences, 2 to 6: what a polynomial of a lower degree does in ``order`` steps leaves
        no trace.
    span_s
        Time over which their squares are averaged, exponentially [s].
    clip
        A square counts for at most this multiple of the mean so far, so that a jerk or a jump of the receiver
        passes. Noise that really grows is followed by at most a share of ``(clip - 1)·dt/span`` a sample.
    prior_m
        Estimate before the first difference, standard deviation an axis [m].
    prior_samples
        How many squares it weighs as much as.

    Raises
    ------
    ValueError
        Where a field is out of its range.

    Notes
    -----
    White noise of variance v gives a difference of order k the variance ``C(2k, k)·v`` an axis, 70·v for the
    fourth. Both axes share one v, so the estimate does not depend on the frame. Clipping a mean of
    two squares of normal numbers at ``c`` times its own mean leaves the share s that solves
    ``s = 1 - exp(-c·s)``, which is divided out.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> circle = 50.0 * np.stack([np.sin(0.3 * t), np.cos(0.3 * t)], axis=1)
    >>> noise = 0.05 * np.random.default_rng(1).standard_normal(circle.shape)
    >>> trip = build_trajectory("made/1", t, circle + noise)
    >>> DEFAULT_NOISE.standard_deviation_m(trip)[[0, 100, -1]].round(2)
    array([0.01, 0.05, 0.05])
    """

    name: str
    _: KW_ONLY
    order: int = 4
    span_s: float = 4.0
    clip: float = 4.0
    prior_m: float = 0.01
    prior_samples: float = 2.0

    def __post_init__(self) -> None:
        if not 2 <= self.order <= 6:
            raise ValueError(f"order must be 2 to 6, got {self.order}")
        for name in ("span_s", "prior_m", "prior_samples"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not (np.isfinite(self.clip) and self.clip > 1.0):
            raise ValueError(f"clip must be finite and exceed 1, got {self.clip}")

    def standard_deviation_m(self, trip: Trajectory) -> FloatArray:
        """Noise of the positions at every sample, from that sample and earlier ones, (T,) [m].

        The mean lasts through gaps; only differences start afresh behind one. A receiver that repeats its
        position exactly tells nothing, and the estimate stays.

        Parameters
        ----------
        trip
            What the sender sees.
        """
        squares = np.empty(len(trip))
        difference_variances(trip.t_s, trip.position_m, trip.segment_start, self.order, squares)
        out = np.empty(len(trip))
        count, clip, share, prior_samples, free = self.step_constants(trip.dt_s)
        settle(squares, count, clip, share, self.prior_m, prior_samples, free, out)
        return out

    def step_constants(self, dt_s: float) -> tuple[float, float, float, float, int]:
        """The trailing arguments of `noise_kernels.settled`, for who takes one sample at a time.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        count = max(self.span_s / dt_s, 1.0)
        return count, self.clip, clipped_share(self.clip), self.prior_samples, _FREE


def clipped_share(clip: float) -> float:
    """Share s of an exponential variable's mean that is left where it is clipped at ``clip·s``.

    Parameters
    ----------
    clip
        Over 1.

    Examples
    --------
    >>> round(clipped_share(4.0), 3)
    0.98
    """
    share = 1.0
    for _ in range(200):
        share = 1.0 - float(np.exp(-clip * share))
    return share


DEFAULT_NOISE = NoiseEstimator("difference-4")
"""Fourth differences, averaged over 4 s, clipped at four times their mean, from a prior of 1 cm."""

"""The one causal estimate of how noisy a vehicle's positions are.

Receivers differ: the white noise of recorded positions runs from under a millimetre to half a metre. A
motion model that knows it can trust good positions and mistrust bad ones. `DEFAULT_NOISE` reads it from the
vehicle's own past positions only: a difference of fourth order has nothing left of any smooth motion, but is
full of noise (``docs/decisions/009-position-noise.md`` has the alternatives and the figures).
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.station.sensing.sensing_kernels import NoiseNumbers

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

    The mean lasts through gaps; only differences start afresh behind one. A receiver that repeats its
    position exactly tells nothing, and the estimate stays.
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

    def numbers(self, dt_s: float) -> NoiseNumbers:
        """Numbers that compiled sensing takes, at a sampling interval [s].

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        share = clipped_share(self.clip)
        return NoiseNumbers(
            max(self.span_s / dt_s, 1.0),
            self.clip,
            share,
            self.prior_samples,
            float(_FREE),
            self.order,
            share * self.prior_m * self.prior_m,
        )


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

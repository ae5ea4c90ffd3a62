"""Channels without contention: ideal, independent losses, and Gilbert-Elliott bursts.

Use `IndependentErasure` for the paper's packet-error sweep and `GilbertElliott` where losses come in bursts
(shadowing, a truck in between) with the same mean. Drawn from the same generator, a higher packet error ratio
loses every message that a lower one loses (`IndependentErasure`), so curves over it are smooth.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure_kernels import burst_losses
from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["GilbertElliott", "Ideal", "IndependentErasure"]


def _check_ratio(ratio: float) -> None:
    if not 0.0 <= ratio <= 1.0:
        percent = f": {ratio:g} % is {ratio / 100.0:g}" if 1.0 < ratio <= 100.0 else ""
        raise ValueError(f"packet error ratio must lie in 0..1, got {ratio}{percent}")


@dataclass(frozen=True, slots=True)
class Ideal(AbstractChannel):
    """Everything arrives."""

    @property
    def packet_error_ratio(self) -> float:
        """Zero."""
        return 0.0

    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:  # noqa: ARG002 - nothing drawn
        """Nowhere, (T,)."""
        return np.zeros(t_s.size, dtype=np.bool_)


@dataclass(frozen=True, slots=True)
class IndependentErasure(AbstractChannel):
    """Every message is lost with the same probability, independently.

    Parameters
    ----------
    ratio
        Packet error ratio, 0..1.

    Examples
    --------
    >>> import numpy as np
    >>> lost = IndependentErasure(0.4).losses(np.arange(10_000) * 0.1, np.random.default_rng(1))
    >>> round(float(lost.mean()), 1)
    0.4
    """

    ratio: float

    def __post_init__(self) -> None:
        _check_ratio(self.ratio)

    @property
    def packet_error_ratio(self) -> float:
        """The ratio."""
        return self.ratio

    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:
        """One draw an instant, (T,)."""
        return rng.random(t_s.size) < self.ratio


@dataclass(frozen=True, slots=True)
class GilbertElliott(AbstractChannel):
    """A two-state channel in continuous time: all is lost in the bad state, nothing in the good one.

    The chain starts in its stationary distribution, so the mean loss equals the ratio at every instant.

    Parameters
    ----------
    ratio
        Packet error ratio, 0..1: the share of time spent in the bad state.
    mean_burst_s
        Mean time spent in the bad state at a visit [s].

    References
    ----------
    E. N. Gilbert, "Capacity of a burst-noise channel", 1960, DOI 10.1002/j.1538-7305.1960.tb03959.x.
    """

    ratio: float
    mean_burst_s: float = 0.5

    def __post_init__(self) -> None:
        _check_ratio(self.ratio)
        if not (np.isfinite(self.mean_burst_s) and self.mean_burst_s > 0):
            raise ValueError(f"mean_burst_s must be positive and finite, got {self.mean_burst_s}")

    @property
    def packet_error_ratio(self) -> float:
        """The ratio."""
        return self.ratio

    @property
    def relaxation_s(self) -> float:
        """Time in which the chain forgets its state, to a share of 1/e; 0 where all is lost anyway [s]."""
        if self.ratio == 1.0:
            return 0.0
        leave_rate = 1.0 / self.mean_burst_s
        return 1.0 / (leave_rate + leave_rate * self.ratio / (1.0 - self.ratio))

    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:
        """The chain's state at every instant, (T,)."""
        if self.ratio in (0.0, 1.0):
            return np.full(t_s.size, self.ratio == 1.0)
        return burst_losses(t_s, rng.random(t_s.size), self.ratio, self.relaxation_s)

"""Send at a fixed rate, whatever the error: the other reading of the paper's equal-rate baseline."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.station.policy import dcc_kernels, periodic_kernels
from modelcast.station.policy import error_driven_kernels as kernels
from modelcast.station.policy.base import AbstractTransmitPolicy, Decisions, TransmitInputs
from modelcast.station.policy.policy_numbers import RULE_PERIODIC, PolicyNumbers

__all__ = ["Periodic"]

_TIME_SLACK_S = 1e-9
"""Sums of periods may pass a sample time by rounding."""


@dataclass(frozen=True, slots=True)
class Periodic(AbstractTransmitPolicy[FloatArray]):
    """Model updates at a mean rate, each vehicle with a random phase.

    Messages fall due every ``1 / rate_hz`` and leave at the first sample at or after that; the first sample
    is always sent. What falls due between two samples leaves as one message. The state is the time the next
    message falls due, (B,) [s]; infinitely early at first.

    Parameters
    ----------
    rate_hz
        Mean rate [Hz].

    Raises
    ------
    ValueError
        Where the rate is not positive.
    """

    rate_hz: float

    def __post_init__(self) -> None:
        if not (self.rate_hz > 0 and np.isfinite(self.rate_hz)):
            raise ValueError(f"rate_hz must be positive, got {self.rate_hz}")

    @property
    def numbers(self) -> PolicyNumbers:
        """One interval."""
        nothing = np.zeros(1)
        return PolicyNumbers(
            RULE_PERIODIC, nothing, dcc_kernels.NONE, nothing, 0.0, 1.0 / self.rate_hz, np.inf
        )

    @property
    def longest_silence_s(self) -> float:
        """One interval [s]."""
        return 1.0 / self.rate_hz

    def init(self, vehicles: int, sub_models: int) -> FloatArray:  # noqa: ARG002 - any bank will do
        """Every vehicle is due at once."""
        return np.full(vehicles, -np.inf)

    def decide(
        self, state: FloatArray, inputs: TransmitInputs, rng: np.random.Generator
    ) -> tuple[Decisions, FloatArray]:
        """Send where due, at once; the phase is drawn with the first message."""
        due = np.empty(state.size, dtype=np.bool_)
        later = np.empty(state.size)
        t_s = owned(inputs.t_s)
        periodic_kernels.step_each(state, t_s, 1.0 / self.rate_hz, owned(rng.random(state.size)), due, later)
        kind = np.where(due, kernels.UPDATE, kernels.NOTHING).astype(np.int64)
        return Decisions.at_once(kind, np.zeros_like(kind), inputs.t_s), later

    def transmit_indices(self, t_s: FloatArray, rng: np.random.Generator) -> IntArray:
        """Indices of the samples of one trip at which messages leave, the first sample among them.

        Parameters
        ----------
        t_s
            Sample times, (T,) rising [s].
        rng
            Draws the phase.
        """
        period_s = 1.0 / self.rate_hz
        first_due = t_s[0] + period_s * (1.0 - rng.random())
        due = np.arange(first_due, t_s[-1] + _TIME_SLACK_S, period_s)
        at = np.searchsorted(t_s, due - _TIME_SLACK_S)
        return np.unique(np.concatenate([[0], at[at < t_s.size]])).astype(np.int64)

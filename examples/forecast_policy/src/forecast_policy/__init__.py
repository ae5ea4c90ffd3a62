"""A policy that sends before the tracking error passes the threshold, not once it has."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelcast import AbstractTransmitPolicy, Decisions, MessageKind, TransmitInputs

__all__ = ["Forecast"]

_SLACK_S = 1e-9


@dataclass(frozen=True, slots=True)
class Forecast(AbstractTransmitPolicy[NDArray[np.float64]]):
    """Draws a line through the last two tracking errors; a message is due where it crosses the threshold.

    The state is the last error and when it was measured, (B, 2).

    Parameters
    ----------
    threshold_m
        Tracking error that is to stay uncrossed [m].
    ahead_s
        How far the line is drawn [s].
    longest_s
        Longest silence [s].
    """

    threshold_m: float = 0.2
    ahead_s: float = 0.2
    longest_s: float = 1.0

    def __post_init__(self) -> None:
        if not (self.threshold_m > 0.0 and self.ahead_s >= 0.0 and self.longest_s > 0.0):
            raise ValueError(f"settings must be positive, got {self}")

    @property
    def longest_silence_s(self) -> float:
        """Longest time between two messages [s]."""
        return self.longest_s

    def init(self, vehicles: int, sub_models: int) -> NDArray[np.float64]:  # noqa: ARG002 - any bank will do
        """No error yet."""
        return np.full((vehicles, 2), np.nan)

    def decide(
        self,
        state: NDArray[np.float64],
        inputs: TransmitInputs,
        rng: np.random.Generator,  # noqa: ARG002 - nothing is drawn
    ) -> tuple[Decisions, NDArray[np.float64]]:
        """Decide for B vehicles; which sub-model is sent is left to the station."""
        error_m, (before_m, before_s) = inputs.error_in_use_m, state.T
        growth_mps = np.fmax((error_m - before_m) / (inputs.t_s - before_s), 0.0)
        fails = ~(error_m + growth_mps * self.ahead_s < self.threshold_m)
        silent = inputs.silence_s >= self.longest_s - _SLACK_S
        kind = np.where(fails, MessageKind.UPDATE, np.where(silent, MessageKind.KEEP_ALIVE, 0))
        measured_m = np.where(kind == MessageKind.NOTHING, error_m, 0.0)
        anything = np.full(kind.shape, -1)
        after = np.column_stack([measured_m, inputs.t_s])
        return Decisions.at_once(kind, anything, inputs.t_s), after

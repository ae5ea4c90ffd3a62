"""A radio that knows distance alone: all is heard near, less farther away, nothing beyond a range."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelcast import AbstractRadio, Receptions, Transmissions

__all__ = ["DiscRadio", "DiscState"]

_AIRTIME_S_PER_BYTE = 8.0 / 6e6
"""At 6 Mb/s."""


@dataclass(frozen=True, slots=True)
class DiscState:
    """The radio between two intervals.

    Parameters
    ----------
    t_s
        Now [s].
    seed
        Of all losses.
    interval
        How many intervals were carried.
    busy_ratio
        Share of the last interval in which somebody else in range was sending, (V,).
    """

    t_s: float
    seed: int
    interval: int
    busy_ratio: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DiscRadio(AbstractRadio[DiscState]):
    """Every message reaches whom it reaches by chance, whatever else is on the air.

    Parameters
    ----------
    sure_m
        Up to this distance everything is heard [m].
    range_m
        From there the chance falls evenly, to nothing at this distance [m].
    """

    sure_m: float = 200.0
    range_m: float = 400.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.sure_m < self.range_m:
            raise ValueError(f"sure_m must be below range_m, got {self.sure_m} and {self.range_m}")

    def init(self, vehicles: int, rng: np.random.Generator) -> DiscState:
        """State of a silent channel at time 0."""
        return DiscState(0.0, int(rng.integers(2**63)), 0, np.zeros(vehicles))

    def step(
        self,
        state: DiscState,
        transmissions: Transmissions,
        position_m: NDArray[np.float64],
        until_t_s: float,
    ) -> tuple[Receptions, DiscState]:
        """Carry one interval; the given state is left alone."""
        transmissions.check(state.t_s, until_t_s, position_m, state.busy_ratio.size, np.inf)
        sender, airtime_s = transmissions.sender, _AIRTIME_S_PER_BYTE * transmissions.size_bytes
        distance_m = np.linalg.norm(position_m[sender, None] - position_m[None], axis=2)
        distance_m[np.arange(sender.size), sender] = np.nan
        chance = (self.range_m - distance_m) / (self.range_m - self.sure_m)
        rng = np.random.default_rng([state.seed, state.interval])
        draws = rng.random((sender.size, state.busy_ratio.size))
        receptions = Receptions.of_pairs(
            transmissions,
            draws < chance,
            distance_m=distance_m,
            range_m=self.range_m,
            end_s=transmissions.ready_s + airtime_s,
            bin_m=self.bin_m,
        )
        busy_s = (distance_m <= self.range_m).T @ airtime_s
        busy_ratio = np.minimum(busy_s / (until_t_s - state.t_s), 1.0)
        return receptions, DiscState(until_t_s, state.seed, state.interval + 1, busy_ratio)

    def channel_busy_ratio(self, state: DiscState) -> NDArray[np.float64]:
        """Share of the last interval in which somebody else in range was sending, (V,)."""
        return state.busy_ratio

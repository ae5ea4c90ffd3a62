"""A radio that loses by a given law and knows no distance: the packet error ratio of a study, over a fleet.

`ErasureRadio` puts one of the channels of `erasure.py` on every directed link of a fleet. Use it where loss
is the question and the radio is not; a table over distance and load is `TabulatedRadio`.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["ErasureRadio", "ErasureState"]

_PREAMBLE_S, _RATE_BPS = 40e-6, 6e6
"""Of IEEE 802.11p at 6 Mb/s."""


@dataclass(frozen=True, slots=True)
class ErasureState:
    """A channel at one instant.

    Parameters
    ----------
    t_s
        Now [s].
    random
        Seed of all losses, (1,).
    steps
        Intervals carried.
    lost
        Links that lost what was sent on them in the last interval, from row to column, (V, V).
    busy_ratio
        Airtime of all in range over the last interval, (V,).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    steps: int
    lost: BoolArray
    busy_ratio: FloatArray


@dataclass(frozen=True, slots=True)
class ErasureRadio(AbstractRadio[ErasureState]):
    """One erasure channel on every directed link, each with its own losses.

    Parameters
    ----------
    channel
        The law of each link.
    range_m
        Beyond it nothing is heard [m].

    Raises
    ------
    ValueError
        Where the range is not positive.

    Notes
    -----
    Whether a link loses is decided once an interval, whoever sends, with as many random numbers whatever
    happens: different policies meet the same losses. What a vehicle sends twice within one interval shares
    its fate on a link. Bursts are those of the two-state chain, seen at the ends of the intervals. There is
    no medium access and no power: ``rssi_dbm`` is NaN, and a loss counts as ``below-sensitivity``.

    Examples
    --------
    >>> radio = ErasureRadio(IndependentErasure(0.5))
    >>> state = radio.init(3, np.random.default_rng(5))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([20.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [9.0, 0.0], [18.0, 0.0]]), 0.1)
    >>> heard.receiver.tolist(), heard.outcomes[0].tolist()
    ([1], [1, 0, 1, 0, 0])
    """

    channel: Ideal | IndependentErasure | GilbertElliott = field(default_factory=Ideal)
    range_m: float = 1000.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.range_m) and self.range_m > 0.0):
            raise ValueError(f"range_m must be positive and finite, got {self.range_m}")

    def init(self, vehicles: int, rng: np.random.Generator) -> ErasureState:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        return ErasureState(
            0.0,
            rng.integers(0, 2**64, size=1, dtype=np.uint64),
            0,
            np.zeros((vehicles, vehicles), dtype=np.bool_),
            np.zeros(vehicles),
        )

    def step(
        self, state: ErasureState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, ErasureState]:
        """Carry one interval; the given state is left alone."""
        transmissions.check(state.t_s, until_t_s, position_m, state.busy_ratio.size, np.inf)
        lost = self._lost(state, until_t_s)
        sender = transmissions.sender
        apart = position_m[sender, None] - position_m[None]
        distance_m = np.hypot(apart[..., 0], apart[..., 1])
        # A vehicle at NaN is no distance from anybody: comparisons with it fail.
        distance_m[np.arange(sender.size), sender] = np.nan
        near = distance_m <= self.range_m
        airtime_s = _PREAMBLE_S + 8.0 * transmissions.size_bytes / _RATE_BPS
        there = np.isfinite(position_m[sender]).all(axis=1)
        receptions = Receptions.of_pairs(
            transmissions,
            ~lost[sender],
            distance_m=distance_m,
            range_m=self.range_m,
            end_s=transmissions.ready_s + airtime_s,
            bin_m=self.bin_m,
        )
        receptions = replace(receptions, expired=transmissions.message_id[~there])
        interval_s = until_t_s - state.t_s
        on_air = near.astype(np.float64).T @ airtime_s
        on_air += np.bincount(sender, weights=airtime_s * there, minlength=on_air.size)
        busy = np.minimum(on_air / interval_s, 1.0) if interval_s > 0.0 else state.busy_ratio
        return receptions, ErasureState(until_t_s, state.random, state.steps + 1, lost, busy)

    def _lost(self, state: ErasureState, until_t_s: float) -> BoolArray:
        """Links that lose in this interval, (V, V): an exact step of each link's chain."""
        seed = np.random.SeedSequence([int(state.random[0]), state.steps])
        uniform = np.random.Generator(np.random.PCG64(seed)).random(state.lost.shape)
        ratio, memory = self.channel.packet_error_ratio, 0.0
        if state.steps > 0 and isinstance(self.channel, GilbertElliott):
            relaxation_s = self.channel.relaxation_s
            memory = np.exp(-(until_t_s - state.t_s) / relaxation_s) if relaxation_s > 0.0 else 0.0
        return uniform < ratio + (state.lost - ratio) * memory

    def channel_busy_ratio(self, state: ErasureState) -> FloatArray:
        """Airtime of all in range over the last interval, 0..1, (V,)."""
        return state.busy_ratio.copy()

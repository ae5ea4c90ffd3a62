"""The abstract radio: chance of reception by distance and load, and nothing else.

`TabulatedRadio` knows no medium access. Use it where thousands of vehicles must be fast, with a table made
from a detailed radio (`ReceptionTable.from_outcomes`) or from a publication. Losses are independent of each
other; the bursts and the fairness of a real channel are lost.
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.channel.tabulated_kernels import advance
from modelcast.core.arrays import FloatArray, IntArray

__all__ = ["ReceptionTable", "TabulatedRadio", "TabulatedState", "measured_table"]


@dataclass(frozen=True, slots=True)
class ReceptionTable:
    """Chance of reception by load and distance.

    Parameters
    ----------
    load_ratios
        Channel load of the rows, rising within 0..1, (L,).
    reception_ratios
        Chance of reception in bins of distance, (L, bins).
    bin_m
        Width of a bin; beyond the last nothing is received [m].
    """

    load_ratios: FloatArray
    reception_ratios: FloatArray
    _: KW_ONLY
    bin_m: float = 50.0

    def __post_init__(self) -> None:
        if self.reception_ratios.ndim != 2 or self.reception_ratios.shape[0] != self.load_ratios.size:
            raise ValueError(
                f"reception_ratios must be ({self.load_ratios.size}, bins), got {self.reception_ratios.shape}"
            )
        if self.load_ratios.size == 0 or not np.all(np.diff(self.load_ratios) > 0):
            raise ValueError("load_ratios must rise and must not be empty")
        if not (np.all(self.reception_ratios >= 0) and np.all(self.reception_ratios <= 1)):
            raise ValueError("reception_ratios must lie within 0..1")
        if not self.bin_m > 0:
            raise ValueError(f"bin_m must be positive, got {self.bin_m}")

    @classmethod
    def from_outcomes(cls, load_ratios: FloatArray, outcomes: IntArray, *, bin_m: float) -> Self:
        """Table from the counts of a detailed radio.

        Parameters
        ----------
        load_ratios
            Channel busy ratio of each run, rising, (L,).
        outcomes
            `Receptions.outcomes`, summed over each run, (L, bins, causes).
        bin_m
            Width of its bins [m].

        Raises
        ------
        ValueError
            Where a bin is empty.
        """
        pairs = outcomes.sum(axis=2)
        if np.any(pairs == 0):
            raise ValueError(
                "every bin of outcomes must hold at least one pair: use fewer bins or longer runs"
            )
        return cls(np.asarray(load_ratios, dtype=np.float64), outcomes[:, :, 0] / pairs, bin_m=bin_m)


_LOAD_RATIOS = (0.017, 0.076, 0.156, 0.319, 0.641, 0.948)
_RECEPTION_RATIOS = (
    (0.995, 0.985, 0.891, 0.538, 0.262, 0.049, 0.005),
    (0.984, 0.962, 0.838, 0.470, 0.223, 0.055, 0.017),
    (0.963, 0.924, 0.776, 0.438, 0.191, 0.058, 0.013),
    (0.930, 0.858, 0.676, 0.356, 0.148, 0.043, 0.010),
    (0.867, 0.732, 0.498, 0.231, 0.086, 0.023, 0.005),
    (0.812, 0.616, 0.354, 0.142, 0.046, 0.011, 0.002),
)


def measured_table() -> ReceptionTable:
    """Table of the 802.11p radio `Dsrc` with its defaults at 20 dBm and 168 bytes, up to 350 m.

    Made on 2026-11-25 by ``benchmarks/reception_table.py``: 10 to 600 vehicles a kilometre of straight road
    send 10 times a second. One seed; the rows of few vehicles are uncertain by some hundredths.

    Examples
    --------
    >>> measured_table().reception_ratios.shape
    (6, 7)
    """
    return ReceptionTable(np.array(_LOAD_RATIOS), np.array(_RECEPTION_RATIOS))


@dataclass(frozen=True, slots=True)
class TabulatedState:
    """A channel at one instant.

    Parameters
    ----------
    t_s
        Now [s].
    random
        Word of the random generator, (1,).
    busy_ratio
        Load that every vehicle met in the last step, (V,).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    busy_ratio: FloatArray


@dataclass(frozen=True, slots=True)
class TabulatedRadio(AbstractRadio[TabulatedState]):
    """Reception by chance, from a table over distance and load.

    Parameters
    ----------
    table
        Chance of reception; the measured one where not given.
    load_range_m
        A vehicle's load is the airtime of all senders within this distance, over the interval of the step
        [m].
    preamble_s, rate_mbps
        Airtime of a message [s], [Mb/s].

    Notes
    -----
    Transmit power does not matter, and received power is unknown: ``rssi_dbm`` is NaN. Losses that would have
    happened without load count as ``below-sensitivity``, the others as ``hidden``. Steps should last about
    100 ms, since the load is measured over each.

    Examples
    --------
    >>> import numpy as np
    >>> table = ReceptionTable(np.array([0.0, 1.0]), np.array([[1.0, 0.5], [0.5, 0.0]]))
    >>> radio = TabulatedRadio(table)
    >>> state = radio.init(2, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([20.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [30.0, 0.0]]), 0.1)
    >>> heard.receiver.tolist(), radio.channel_busy_ratio(state).round(4).tolist()
    ([1], [0.0044, 0.0044])
    """

    table: ReceptionTable = field(default_factory=measured_table)
    load_range_m: float = 300.0
    _: KW_ONLY
    preamble_s: float = 40e-6
    rate_mbps: float = 6.0

    def __post_init__(self) -> None:
        for name in ("load_range_m", "rate_mbps"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not self.preamble_s >= 0:
            raise ValueError(f"preamble_s must not be negative, got {self.preamble_s}")

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.table.bin_m

    def init(self, vehicles: int, rng: np.random.Generator) -> TabulatedState:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        return TabulatedState(0.0, rng.integers(0, 2**64, size=1, dtype=np.uint64), np.zeros(vehicles))

    def step(
        self, state: TabulatedState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, TabulatedState]:
        """Carry one interval; the given state is left alone."""
        transmissions.check(state.t_s, until_t_s, position_m, state.busy_ratio.size, np.inf)
        if until_t_s == state.t_s:
            raise ValueError(
                f"until_t_s must lie after the state's {state.t_s} s: load is measured over the step"
            )
        random = state.random.copy()
        bits = 8e-6 * transmissions.size_bytes.astype(np.float64)
        airtime_s: FloatArray = self.preamble_s + bits / self.rate_mbps
        who, when, outcomes, expired, load = advance(
            random,
            transmissions.sender,
            transmissions.ready_s,
            airtime_s,
            transmissions.message_id,
            np.ascontiguousarray(position_m, dtype=np.float64),
            until_t_s - state.t_s,
            self.load_range_m,
            self.table.bin_m,
            self.table.load_ratios,
            self.table.reception_ratios,
        )
        order = np.argsort(when, kind="stable")
        receptions = Receptions(
            who[order, 0],
            who[order, 1],
            receiver=who[order, 2],
            t_s=when[order],
            rssi_dbm=np.full(order.size, np.nan),
            outcomes=outcomes,
            expired=expired,
        )
        return receptions, replace(state, t_s=until_t_s, random=random, busy_ratio=load)

    def channel_busy_ratio(self, state: TabulatedState) -> FloatArray:
        """Load that every vehicle met in the last step, 0..1, (V,)."""
        return state.busy_ratio.copy()

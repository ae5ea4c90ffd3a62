"""The abstract radio: chance of reception by distance and load, and nothing else.

`TabulatedRadio` knows no medium access. Use it where thousands of vehicles must be fast, with a table made
from a detailed radio (`ReceptionTable.from_outcomes`) or from a publication. Losses are independent of each
other; the bursts and the fairness of a real channel are lost.

A vehicle's *load* is the airtime of all frames it senses, each by its chance to be above `load_dbm`. Frames
overlap, so it finds the channel busy for less than that: the *busy ratio*.
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from modelcast.channel.airtime_kernels import SERVICE_TAIL_BITS, frame_airtimes
from modelcast.channel.parameter_bounds import check_decibels
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.channel.sensed_share import MARGIN_DB, sensed_shares
from modelcast.channel.tabulated_kernels import Sensed, advance
from modelcast.core.arrays import FloatArray, IntArray, owned

__all__ = ["ReceptionTable", "TabulatedRadio", "TabulatedState", "measured_table"]

_FASTEST_MBPS = 1e6
_LONGEST_S = 1.0
"""Bounds of what an airtime is made of; beyond them the bits of a symbol are no whole number of 64 bits."""

_LOUDEST_DBM = 33.0
"""Powers above this are sensed no farther than this one."""

_UNSENSED_DB = 10.0
"""A median so far below the bound is passed over: of Rayleigh fading exp(-10) is left."""


@dataclass(frozen=True, slots=True)
class ReceptionTable:
    """Chance of reception by load and distance.

    Parameters
    ----------
    load_ratios
        Load of the rows: airtime sensed over time, rising, (L,). Frames overlap, so it may be above 1.
    reception_ratios
        Chance of reception in bins of distance, (L, bins).
    bin_m
        Width of a bin; beyond the last nothing is received [m].
    busy_ratios
        Channel busy ratio at each load, not falling within 0..1, (L,). None where it was not measured: then a
        load of x is taken for 1 - exp(-x), as if frames began at random.
    """

    load_ratios: FloatArray
    reception_ratios: FloatArray
    _: KW_ONLY
    bin_m: float = 50.0
    busy_ratios: FloatArray | None = None

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
        busy = self.busy_ratios
        if busy is None:
            return
        if busy.shape != self.load_ratios.shape:
            raise ValueError(f"busy_ratios must be ({self.load_ratios.size},), got {busy.shape}")
        if not (busy.min() >= 0 and busy.max() <= 1 and np.all(np.diff(busy) >= 0)):
            raise ValueError(f"busy_ratios must lie within 0..1 and must not fall, got {busy}")

    def busy_ratio(self, load: FloatArray) -> FloatArray:
        """Channel busy ratio at loads, any shape.

        Parameters
        ----------
        load
            Airtime sensed over time.

        Notes
        -----
        Below the first row it falls to 0 with the load. Beyond the last, the share that is still idle falls
        exponentially, as for frames that begin at random.

        Examples
        --------
        >>> table = ReceptionTable(np.array([0.5]), np.ones((1, 1)), busy_ratios=np.array([0.4]))
        >>> table.busy_ratio(np.array([0.25, 0.5, 1.5])).round(3).tolist()
        [0.2, 0.4, 0.779]
        """
        if self.busy_ratios is None:
            return np.asarray(-np.expm1(-load), dtype=np.float64)
        loads = np.concatenate(([0.0], self.load_ratios))
        busy = np.interp(load, loads, np.concatenate(([0.0], self.busy_ratios)))
        beyond = np.maximum(load - loads[-1], 0.0)
        return np.asarray(1.0 - (1.0 - busy) * np.exp(-beyond), dtype=np.float64)

    @classmethod
    def from_outcomes(cls, load_ratios: FloatArray, outcomes: IntArray, *, bin_m: float) -> Self:
        """Table from the counts of a detailed radio.

        Parameters
        ----------
        load_ratios
            Load of each run, rising, (L,).
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


_LOAD_RATIOS = (0.009, 0.035, 0.070, 0.141, 0.280, 0.414, 0.619, 0.824)
_BUSY_RATIOS = (0.009, 0.035, 0.069, 0.138, 0.264, 0.376, 0.523, 0.640)
_RECEPTION_RATIOS = (
    (0.995, 0.988, 0.880, 0.505, 0.302, 0.065, 0.024),
    (0.984, 0.959, 0.829, 0.483, 0.212, 0.068, 0.017),
    (0.965, 0.925, 0.776, 0.439, 0.189, 0.058, 0.014),
    (0.932, 0.863, 0.679, 0.359, 0.144, 0.043, 0.010),
    (0.866, 0.732, 0.497, 0.231, 0.084, 0.023, 0.005),
    (0.810, 0.614, 0.355, 0.142, 0.046, 0.011, 0.002),
    (0.736, 0.453, 0.194, 0.060, 0.016, 0.003, 0.001),
    (0.677, 0.320, 0.099, 0.024, 0.005, 0.001, 0.000),
)


def measured_table() -> ReceptionTable:
    """Table of the 802.11p radio `Dsrc` with its defaults at 20 dBm and 168 bytes, up to 350 m.

    Made on 2026-11-29 by ``benchmarks/reception_table.py``: 10 to 1200 vehicles a kilometre of straight road
    send 10 times a second. Three placements; the rows of few vehicles are uncertain by some hundredths. How
    busy a load is found to be holds at other powers and sizes too; reception does not: longer frames are lost
    more often.

    Examples
    --------
    >>> measured_table().reception_ratios.shape
    (8, 7)
    """
    return ReceptionTable(
        np.array(_LOAD_RATIOS), np.array(_RECEPTION_RATIOS), busy_ratios=np.array(_BUSY_RATIOS)
    )


@dataclass(frozen=True, slots=True)
class TabulatedState:
    """A channel at one instant.

    Parameters
    ----------
    t_s
        Now [s].
    random
        Word of the random generator, (1,).
    load_ratio
        Load that every vehicle met in the last step, (V,).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    load_ratio: FloatArray


@dataclass(frozen=True, slots=True)
class TabulatedRadio(AbstractRadio[TabulatedState]):
    """Reception by chance, from a table over distance and load.

    Parameters
    ----------
    table
        Chance of reception; the measured one where not given.
    propagation
        What frames are sensed by. It changes the load, and reception by it alone: the table knows no walls.
    load_dbm
        A frame counts to the load of those who get it with this power or more; TS 102 687: -85 dBm [dBm].
    antenna_gain_db
        Of either end, in the power that frames arrive with [dB].
    preamble_s, rate_mbps, symbol_s
        Airtime of a message: preamble, then whole symbols as of IEEE 802.11 at 10 MHz [s], [Mb/s], [s].

    Notes
    -----
    A vehicle's load is the airtime of its own frames, and that of all others by the chance that they reach it
    with `load_dbm` (`modelcast.channel.sensed_share.sensed_shares`), over the interval of the step. Reception
    and `channel_busy_ratio` follow from it by the table. So a louder frame is received no better, but loads
    more vehicles. Received power is unknown: ``rssi_dbm`` is NaN. Losses that would have
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
    ([1], [0.0045, 0.0045])
    """

    table: ReceptionTable = field(default_factory=measured_table)
    propagation: Propagation = field(default_factory=Propagation)
    _: KW_ONLY
    load_dbm: float = -85.0
    antenna_gain_db: float = 0.0
    preamble_s: float = 40e-6
    rate_mbps: float = 6.0
    symbol_s: float = 8e-6
    tables: PropagationTables = field(init=False, repr=False, compare=False)
    shares: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, most in (("rate_mbps", _FASTEST_MBPS), ("symbol_s", _LONGEST_S)):
            if not 0 < getattr(self, name) <= most:
                raise ValueError(f"{name} must be positive, at most {most:g}, got {getattr(self, name)}")
        if not self._bits_per_symbol >= 1:
            raise ValueError(f"a symbol must hold a bit, got {self.rate_mbps} Mb/s and {self.symbol_s} s")
        if not 0 <= self.preamble_s <= _LONGEST_S:
            raise ValueError(
                f"preamble_s must not be negative, at most {_LONGEST_S:g}, got {self.preamble_s}"
            )
        check_decibels(self)
        object.__setattr__(self, "tables", self.propagation.tables(self._sensed_m(_LOUDEST_DBM)))
        object.__setattr__(self, "shares", sensed_shares(self.propagation))

    @property
    def _bits_per_symbol(self) -> int:
        return round(1e6 * self.rate_mbps * self.symbol_s)

    def _sensed_m(self, power_dbm: float) -> float:
        """How far a frame of that power is sensed [m]."""
        over_db = min(power_dbm, _LOUDEST_DBM) - self._least_dbm
        return self.propagation.range_m(over_db + _UNSENSED_DB)

    @property
    def _least_dbm(self) -> float:
        """Power less path loss from which a frame counts [dBm]."""
        return self.load_dbm - 2.0 * self.antenna_gain_db

    @property
    def bin_m(self) -> float:
        """Width of the bins of distance of its outcomes [m]."""
        return self.table.bin_m

    def within(self, propagation: Propagation) -> Self:
        """The radio with this propagation."""
        return replace(self, propagation=propagation)

    def airtime_s(self, size_bytes: IntArray) -> FloatArray:
        """Duration of frames, (N,) [s].

        Parameters
        ----------
        size_bytes
            Bytes handed to the physical layer, (N,).
        """
        sizes: IntArray = owned(size_bytes, np.int64)
        return frame_airtimes(sizes, self.preamble_s, self.symbol_s, SERVICE_TAIL_BITS, self._bits_per_symbol)

    def init(self, vehicles: int, rng: np.random.Generator) -> TabulatedState:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        return TabulatedState(0.0, rng.integers(0, 2**64, size=1, dtype=np.uint64), np.zeros(vehicles))

    def step(
        self, state: TabulatedState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, TabulatedState]:
        """Carry one interval; the given state is left alone."""
        transmissions.check(state.t_s, until_t_s, position_m, state.load_ratio.size, np.inf)
        if until_t_s == state.t_s:
            raise ValueError(
                f"until_t_s must lie after the state's {state.t_s} s: load is measured over the step"
            )
        random = state.random.copy()
        loudest_dbm = float(transmissions.power_dbm.max(initial=-np.inf))
        who, when, outcomes, expired, load = advance(
            random,
            transmissions.sender,
            transmissions.ready_s,
            self.airtime_s(transmissions.size_bytes),
            transmissions.message_id,
            np.ascontiguousarray(position_m, dtype=np.float64),
            until_t_s - state.t_s,
            Sensed(
                owned(transmissions.power_dbm - self._least_dbm),
                self._sensed_m(loudest_dbm) if transmissions.size else 0.0,
                MARGIN_DB,
                self.shares,
                self.tables,
            ),
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
        return receptions, replace(state, t_s=until_t_s, random=random, load_ratio=load)

    def channel_busy_ratio(self, state: TabulatedState) -> FloatArray:
        """How busy every vehicle found the channel in the last step, 0..1, (V,)."""
        return self.table.busy_ratio(state.load_ratio)

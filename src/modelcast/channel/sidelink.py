"""LTE-V2X mode 4: vehicles that listen for a second, reserve a resource, and come back to it.

`Sidelink` simulates sensing-based semi-persistent scheduling of one pool of sub-channels. A vehicle holds one
message at most; a newer one takes its place. Periodic traffic suits it; for messages at uneven times there
is the one-shot grant (`SidelinkParameters.one_shot`), chosen by the same sensing and never announced.
"""

from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.channel.dsrc import thermal_noise_dbm
from modelcast.channel.error_models import AbstractErrorModel, TabulatedErrorModel
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables, empty_pairs
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.channel.sidelink_kernels import (
    BAND,
    GRANT_COLUMNS,
    MEMORY,
    MESSAGE,
    SidelinkConstants,
    advance,
)
from modelcast.core.arrays import FloatArray, IntArray, SingleArray

__all__ = ["BITS_PER_BLOCK", "Sidelink", "SidelinkParameters", "SidelinkState", "in_band_emission"]

BITS_PER_BLOCK: dict[int, float] = {
    0: 26.8,
    1: 35.6,
    2: 43.6,
    3: 58.0,
    4: 70.8,
    5: 86.8,
    6: 104.4,
    7: 123.6,
    8: 139.6,
    9: 155.6,
    10: 174.8,
}
"""Bits a resource-block pair by MCS: transport block of 20 pairs over 20; TS 36.213, table 7.1.7.2.1-1.

From memory. Other sizes differ by a few per cent."""

_BLOCK_HZ = 180e3
_BLOCK_ELEMENTS = 12
_COUNTERS = {20: (25, 75), 50: (10, 30)}
_COUNTER = (5, 15)


@dataclass(frozen=True, slots=True)
class SidelinkParameters:
    """Constants of the radio, by document.

    Parameters
    ----------
    mcs
        A key of `BITS_PER_BLOCK`. The error model must be for it.
    sub_channels, blocks
        Sub-channels of the pool, and resource-block pairs in each; 10 MHz has 50 pairs.
    control_blocks
        Pairs for the control part, adjacent to the data: 2.
    overlapping
        Whether a resource may begin at every sub-channel (TS 36.213); else only at multiples of its length.
    interval_ms
        Resource reservation interval: 20, 50, or a multiple of 100 up to 1000 [ms].
    first_ms, last_ms
        T1 <= 4 and T2 in 20..100: a message goes out so many subframes after it is ready [ms].
    keep_ratio
        Chance to keep the resource when the counter runs out; 0, .2, .4, .6 or .8.
    one_shot
        Choose a resource for every message and reserve nothing.
    reselect_after
        A resource is given up after so many turns in a row without a message (sl-ReselectAfter, 1..9).
    best_ratio
        Share of the resources among which chance decides: 0.2.
    reserved_dbm
        A reservation counts where its reference signal is stronger, an element; raised by 3 dB until enough
        resources are left [dBm].
    control_db
        Least SINR at which a reservation is understood; common in simulators, from memory [dB].
    noise_figure_db
        9 dB in TR 36.885 [dB].
    sensitivity_dbm
        Weakest frame that is received [dBm]. The error model decides before that, save with good luck.
    load_dbm
        The channel busy ratio counts sub-channels with more; TS 36.214, 5.1.30, with the -94 dBm of ETSI TS
        103 574 [dBm].
    busy_window_ms
        100 subframes.
    antenna_gain_db
        Of either end [dB].
    max_power_dbm, margin_db, bin_m, bins
        As in `DsrcParameters`.

    References
    ----------
    3GPP TS 36.213, clause 14; TS 36.321, 5.14.1.1; TS 36.214, 5.1.28 to 5.1.30; R. Molina-Masegosa and J.
    Gozalvez, "LTE-V for sidelink 5G V2X vehicular communications", 2017, DOI 10.1109/MVT.2017.2752798.
    """

    mcs: int = 5
    sub_channels: int = 5
    _: KW_ONLY
    blocks: int = 10
    control_blocks: int = 2
    overlapping: bool = True
    interval_ms: int = 100
    first_ms: int = 1
    last_ms: int = 100
    keep_ratio: float = 0.8
    one_shot: bool = False
    reselect_after: int = 1
    best_ratio: float = 0.2
    reserved_dbm: float = -110.0
    control_db: float = 0.0
    noise_figure_db: float = 9.0
    sensitivity_dbm: float = -105.0
    load_dbm: float = -94.0
    busy_window_ms: int = 100
    antenna_gain_db: float = 0.0
    max_power_dbm: float = 23.0
    margin_db: float = 10.0
    bin_m: float = 50.0
    bins: int = 10

    def __post_init__(self) -> None:
        if self.mcs not in BITS_PER_BLOCK:
            raise ValueError(f"mcs must be one of {sorted(BITS_PER_BLOCK)}, got {self.mcs}")
        for name in ("sub_channels", "blocks", "reselect_after", "busy_window_ms", "bins"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)}")
        if self.interval_ms not in (20, 50, *range(100, 1001, 100)):
            raise ValueError(f"interval_ms must be 20, 50 or 100, 200, ... 1000, got {self.interval_ms}")
        if not 1 <= self.first_ms <= 4 or not 20 <= self.last_ms <= 100:
            raise ValueError(
                f"first_ms must lie within 1..4, last_ms within 20..100, got {self.first_ms}, {self.last_ms}"
            )
        for name in ("keep_ratio", "best_ratio"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie within 0..1, got {getattr(self, name)}")
        if not self.bin_m > 0:
            raise ValueError(f"bin_m must be positive, got {self.bin_m}")

    @property
    def sub_channel_hz(self) -> float:
        """Width of a sub-channel [Hz]."""
        return self.blocks * _BLOCK_HZ

    def length(self, size_bytes: IntArray) -> IntArray:
        """Sub-channels that messages take, (N,).

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).

        Examples
        --------
        >>> import numpy as np
        >>> SidelinkParameters(mcs=7).length(np.array([100, 190, 300])).tolist()
        [1, 2, 3]
        """
        data = np.ceil(8.0 * np.asarray(size_bytes) / BITS_PER_BLOCK[self.mcs]).astype(np.int64)
        return -(-(data + self.control_blocks) // self.blocks)


def in_band_emission(sub_channels: int, blocks: int) -> FloatArray:
    """Power that a sender leaks into each sub-channel, over its own there, (lengths, firsts, sub-channels).

    Parameters
    ----------
    sub_channels
        Sub-channels of the pool; row k is for messages of k + 1 of them.
    blocks
        Resource-block pairs in each.

    Notes
    -----
    The mask of 3GPP TS 36.101, table 6.5.2A.3.1-1, for QPSK (EVM 17.5 %) with {W, X, Y, Z} = {3, 6, 3, 3} dB
    (TR 36.885): the larger of -25 - 10 log(N/L) - X and 20 log EVM - 3 - 5(d - 1)/L - W for a block d blocks
    away, and -25 - Y more on the image of the used blocks. Carrier leakage (-25 - Z) falls on the two middle
    blocks. Averaged over the blocks of a sub-channel.
    """
    total = sub_channels * blocks
    block = np.arange(total)
    table = np.zeros((sub_channels, sub_channels, sub_channels))
    for length in range(1, sub_channels + 1):
        for first in range(sub_channels - length + 1):
            start, stop, width = first * blocks, (first + length) * blocks - 1, length * blocks
            away = np.maximum(start - block, block - stop)
            general = -25.0 - 10.0 * np.log10(total / width) - 6.0
            slope = 20.0 * np.log10(0.175) - 3.0 - 5.0 * (away - 1) / width - 3.0
            leak = 10.0 ** (0.1 * np.maximum(general, slope))
            image = total - 1 - block
            leak = leak + np.where((image >= start) & (image <= stop), 10.0**-2.8, 0.0)
            middle = (block == (total - 1) // 2) | (block == total // 2)
            leak = np.where(away <= 0, 1.0, leak + np.where(middle, 10.0**-2.8, 0.0))
            table[length - 1, first] = leak.reshape(sub_channels, blocks).mean(axis=1)
    return table


@dataclass(frozen=True, slots=True)
class SidelinkState:
    """A pool at one instant: plain arrays.

    Parameters
    ----------
    t_s
        Now; a whole millisecond [s].
    random
        Word of the random generator, (1,).
    grant
        Resource and waiting message of every vehicle, (V, GRANT_COLUMNS).
    power_dbm
        Power of the waiting message, (V,) [dBm].
    sensed
        S-RSSI of the last 1000 subframes, infinite where the vehicle sent, (V, 1000, sub-channels) [mW].
    reserved
        Power of an element of the strongest reservation by phase of the interval, (V, interval, sub-channels)
        [mW].
    busy_ratio
        Of the last full window, (V,).
    pairs, pair_count
        Shadowing of pairs: open addressing, (C, 4), (1,).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    _: KW_ONLY
    grant: IntArray
    power_dbm: FloatArray
    sensed: SingleArray
    reserved: SingleArray
    busy_ratio: FloatArray
    pairs: FloatArray
    pair_count: IntArray

    @property
    def vehicles(self) -> int:
        """Number of vehicles V."""
        return self.grant.shape[0]

    def copy(self) -> "SidelinkState":
        """Same state in arrays of its own."""
        return replace(
            self,
            random=self.random.copy(),
            grant=self.grant.copy(),
            power_dbm=self.power_dbm.copy(),
            sensed=self.sensed.copy(),
            reserved=self.reserved.copy(),
            busy_ratio=self.busy_ratio.copy(),
            pairs=self.pairs.copy(),
            pair_count=self.pair_count.copy(),
        )


@dataclass(frozen=True, slots=True)
class Sidelink(AbstractRadio[SidelinkState]):
    """LTE-V2X mode 4 of a fleet on one pool.

    Parameters
    ----------
    parameters
        Constants of the radio.
    propagation
        What becomes of the power. The default has no fast fading: the error curve holds it.
    error_model
        Packet error against SINR.

    Notes
    -----
    Time runs in subframes of 1 ms; steps must end on one. A message ready in subframe n is looked at in n
    and sent in n + T1 to n + T2. All have one reservation interval. Of lost frames, ``concurrent`` means
    that the strongest interferer was near enough to hear the sender's reservations (median power),
    ``hidden`` that it was not.

    Examples
    --------
    >>> import numpy as np
    >>> radio = Sidelink()
    >>> state = radio.init(2, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([23.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [50.0, 0.0]]), 0.2)
    >>> heard.message_id.tolist(), bool(0.012 <= heard.t_s[0] <= 0.111)
    ([7], True)
    """

    parameters: SidelinkParameters = field(default_factory=SidelinkParameters)
    propagation: Propagation = field(default_factory=lambda: Propagation(fading=None))
    error_model: AbstractErrorModel = field(default_factory=TabulatedErrorModel.sidelink_mcs5)
    constants: SidelinkConstants = field(init=False, repr=False, compare=False)
    hazard: FloatArray = field(init=False, repr=False, compare=False)
    leak: FloatArray = field(init=False, repr=False, compare=False)
    tables: PropagationTables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        constants = self._constants()
        object.__setattr__(self, "constants", constants)
        object.__setattr__(self, "hazard", np.ascontiguousarray(self.error_model.hazards()))
        object.__setattr__(
            self, "leak", in_band_emission(self.parameters.sub_channels, self.parameters.blocks)
        )
        object.__setattr__(self, "tables", self.propagation.tables(constants.range_m))

    @property
    def range_m(self) -> float:
        """Distance beyond which nothing is heard or disturbed [m]."""
        return self.constants.range_m

    def _constants(self) -> SidelinkConstants:
        p = self.parameters
        noise_dbm = thermal_noise_dbm(p.sub_channel_hz) + p.noise_figure_db
        loudest_dbm = p.max_power_dbm + 2.0 * p.antenna_gain_db
        elements = float(p.blocks * _BLOCK_ELEMENTS)
        reserved_dbm = p.reserved_dbm + 10.0 * np.log10(elements)  # over one sub-channel
        units_fixed = float(self.error_model.units(np.array([0.0]))[0])
        units_per_byte = float(self.error_model.units(np.array([1.0]))[0]) - units_fixed
        shadowing = self.propagation.shadowing
        low, high = _COUNTERS.get(p.interval_ms, _COUNTER)
        return SidelinkConstants(
            sub_channels=p.sub_channels,
            overlapping=p.overlapping,
            first=p.first_ms,
            last=min(p.last_ms, p.interval_ms),
            interval=p.interval_ms,
            one_shot=p.one_shot,
            counter_low=low,
            counter_high=high,
            keep_ratio=p.keep_ratio,
            reselect_after=p.reselect_after,
            best_ratio=p.best_ratio,
            reserved_mw=_ratio(p.reserved_dbm),
            elements=float(_BLOCK_ELEMENTS),
            noise_mw=_ratio(noise_dbm),
            sensitivity_mw=_ratio(p.sensitivity_dbm),
            control_ratio=_ratio(p.control_db),
            load_mw=_ratio(p.load_dbm),
            window=p.busy_window_ms,
            gain_db=2.0 * p.antenna_gain_db,
            range_m=self.propagation.range_m(loudest_dbm - noise_dbm + p.margin_db),
            sensing_range_m=self.propagation.range_m(loudest_dbm - reserved_dbm),
            bin_m=p.bin_m,
            bins=p.bins,
            blocks=p.blocks,
            bits_per_block=BITS_PER_BLOCK[p.mcs],
            control_blocks=p.control_blocks,
            units_fixed=units_fixed,
            units_per_byte=units_per_byte,
            shadowed=shadowing is not None and (shadowing.los_db > 0 or shadowing.nlos_db > 0),
        )

    def init(self, vehicles: int, rng: np.random.Generator) -> SidelinkState:
        """State of a silent pool at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        p = self.parameters
        grant = np.zeros((vehicles, GRANT_COLUMNS), dtype=np.int64)
        grant[:, BAND] = grant[:, MESSAGE] = -1
        pairs, pair_count = empty_pairs(1024)
        return SidelinkState(
            0.0,
            rng.integers(0, 2**64, size=1, dtype=np.uint64),
            grant=grant,
            power_dbm=np.zeros(vehicles),
            sensed=np.full((vehicles, MEMORY, p.sub_channels), self.constants.noise_mw, dtype=np.float32),
            reserved=np.zeros((vehicles, p.interval_ms, p.sub_channels), dtype=np.float32),
            busy_ratio=np.zeros(vehicles),
            pairs=pairs,
            pair_count=pair_count,
        )

    def step(
        self, state: SidelinkState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, SidelinkState]:
        """Carry one interval; the given state is left alone."""
        return self.carry(state.copy(), transmissions, position_m, until_t_s)

    def carry(
        self, state: SidelinkState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, SidelinkState]:
        """Carry one interval and use the given state up: faster than `step`, for a loop that owns its state.

        Parameters
        ----------
        state
            Its arrays are written into; do not use it again.
        transmissions, position_m, until_t_s
            As for `step`.
        """
        self._check(state, transmissions, position_m, until_t_s)
        who, when, outcomes, expired, pairs, pair_count = advance(
            round(state.t_s * 1e3),
            round(until_t_s * 1e3),
            state.random,
            state.grant,
            state.power_dbm,
            state.sensed,
            state.reserved,
            state.busy_ratio,
            state.pairs,
            state.pair_count,
            transmissions.sender,
            np.floor(transmissions.ready_s * 1e3 + 1e-6).astype(np.int64),
            transmissions.size_bytes,
            transmissions.power_dbm,
            transmissions.message_id,
            np.ascontiguousarray(position_m, dtype=np.float64),
            self.hazard,
            self.leak,
            self.tables,
            self.constants,
        )
        receptions = Receptions(
            who[:, 0],
            who[:, 1],
            receiver=who[:, 2],
            t_s=when[:, 0],
            rssi_dbm=10.0 * np.log10(when[:, 1]),
            outcomes=outcomes,
            expired=expired,
        )
        return receptions, replace(state, t_s=until_t_s, pairs=pairs, pair_count=pair_count)

    def channel_busy_ratio(self, state: SidelinkState) -> FloatArray:
        """Share of sub-channels above -94 dBm in the last full 100 subframes of every vehicle, 0..1, (V,)."""
        return state.busy_ratio.copy()

    def _check(
        self, state: SidelinkState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> None:
        if abs(until_t_s * 1e3 - round(until_t_s * 1e3)) > 1e-6:
            raise ValueError(f"until_t_s must be a whole number of milliseconds, got {until_t_s} s")
        transmissions.check(state.t_s, until_t_s, position_m, state.vehicles, self.parameters.max_power_dbm)
        if transmissions.size > 0:
            longest = int(self.parameters.length(transmissions.size_bytes).max())
            if longest > self.parameters.sub_channels:
                raise ValueError(
                    f"size_bytes must fit into {self.parameters.sub_channels} sub-channels, "
                    f"got {int(transmissions.size_bytes.max())} bytes, which take {longest}"
                )


def _ratio(decibels: float) -> float:
    return float(10.0 ** (0.1 * decibels))

"""IEEE 802.11p broadcast: senders that listen first, count down in slots, and still collide.

`Dsrc` simulates EDCA of one channel event by event for a whole fleet. A vehicle holds one message at most; a
newer one takes its place (awareness messages age). There is no acknowledgement, no retry and no window
growth.
"""

from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.channel.dsrc_kernels import BUSY_RATIO, DsrcConstants, advance, silent_station
from modelcast.channel.error_models import AbstractErrorModel, NistErrorModel
from modelcast.channel.propagation import Propagation
from modelcast.channel.propagation_kernels import PropagationTables, empty_pairs
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import FloatArray, IntArray

__all__ = [
    "ACCESS_CATEGORIES",
    "BIT_RATES",
    "AccessCategory",
    "BitRate",
    "Dsrc",
    "DsrcParameters",
    "DsrcState",
    "thermal_noise_dbm",
]


@dataclass(frozen=True, slots=True)
class BitRate:
    """One modulation and coding scheme in a 10 MHz channel.

    Parameters
    ----------
    bits_per_subcarrier
        Coded bits a subcarrier: 1, 2, 4 or 6.
    code_rate
        1/2, 2/3 or 3/4.
    bits_per_symbol
        N_DBPS, data bits an OFDM symbol.
    """

    bits_per_subcarrier: int
    code_rate: float
    bits_per_symbol: int


BIT_RATES: dict[float, BitRate] = {
    3.0: BitRate(1, 1 / 2, 24),
    4.5: BitRate(1, 3 / 4, 36),
    6.0: BitRate(2, 1 / 2, 48),
    9.0: BitRate(2, 3 / 4, 72),
    12.0: BitRate(4, 1 / 2, 96),
    18.0: BitRate(4, 3 / 4, 144),
    24.0: BitRate(6, 2 / 3, 192),
    27.0: BitRate(6, 3 / 4, 216),
}
"""Rates of a 10 MHz channel by Mb/s; IEEE Std 802.11-2020, table 17-4."""


@dataclass(frozen=True, slots=True)
class AccessCategory:
    """Two numbers of EDCA.

    Parameters
    ----------
    aifsn
        Slots of the interframe space beyond SIFS.
    window
        CWmin: the countdown starts in 0..window.
    """

    aifsn: int
    window: int

    def __post_init__(self) -> None:
        if self.aifsn < 1 or self.window < 0:
            raise ValueError(f"aifsn must be at least 1 and window not negative, got {self}")


ACCESS_CATEGORIES: dict[str, AccessCategory] = {
    "voice": AccessCategory(2, 3),
    "video": AccessCategory(3, 7),
    "best effort": AccessCategory(6, 15),
    "background": AccessCategory(9, 15),
}
"""EDCA outside the context of a BSS; IEEE Std 802.11-2020, table 9-156. The windows are from memory."""


@dataclass(frozen=True, slots=True)
class DsrcParameters:
    """Constants of the radio, by document.

    Parameters
    ----------
    rate_mbps
        A key of `BIT_RATES` [Mb/s].
    access
        EDCA parameters. The default is the category of ordinary awareness messages in Europe (EN 302 663, DP2
        and below); American profiles put the BSM into "video" or "best effort": name it in what you publish.
    slot_s, sifs_s, preamble_s, symbol_s
        IEEE 802.11, table 17-21, 10 MHz; ``preamble_s`` is preamble 32 us and SIGNAL 8 us [s].
    sensing_s
        aCCATime: a frame is noticed this long after it begins. Who reaches the end of the countdown before
        that sends too; table 17-21, below 8 us at 10 MHz [s].
    immediate_access
        Whether a message that finds the medium idle for AIFS goes out at once (10.23.2.4); else every message
        counts down first.
    noise_figure_db, bandwidth_hz
        The receiver's noise, at 290 K [dB], [Hz].
    sensitivity_dbm
        Weakest frame a receiver locks on to; vRxSens of SAE J2945/1 is -92 dBm. The standard demands -85 dBm
        at 6 Mb/s [dBm].
    decodable_dbm
        A frame that is being received holds the medium busy from this power on; 17.3.10.6: -85 dBm [dBm].
    energy_dbm
        Power of any kind that holds the medium busy; 17.3.10.6: 20 dB above, -65 dBm [dBm].
    load_dbm
        The channel busy ratio counts the time with this power or more, and that of own frames; TS 102 687:
        -85 dBm [dBm].
    busy_window_s
        vCBPMeasInt of J2945/1 and T_CBR of TS 102 687: 100 ms [s].
    preamble_db
        Least SINR at which a preamble is found; 4 dB in ns-3 and in the 802.11 extension of ns-2 [dB].
    capture_s, capture_db
        A frame that begins within ``capture_s`` after the one a receiver is locked on to, and is stronger
        than everything else by ``capture_db``, takes the receiver over; later ones never do. The preamble
        and 4 dB, as in the extension of ns-2 [s], [dB].
    antenna_gain_db
        Of either end [dB].
    max_power_dbm
        No transmission may exceed it; it sets the range [dBm].
    margin_db
        Links whose median power at ``max_power_dbm`` is this much below the noise are out of range: they
        count neither as reception nor as interference. Twice as much below, a single signal is left out [dB].
    bin_m, bins
        Distance bins of `Receptions.outcomes` [m].

    References
    ----------
    IEEE Std 802.11-2020, clauses 10.23 and 17; SAE J2945/1; ETSI EN 302 663, TS 102 687.
    """

    rate_mbps: float = 6.0
    access: AccessCategory = ACCESS_CATEGORIES["best effort"]
    _: KW_ONLY
    slot_s: float = 13e-6
    sifs_s: float = 32e-6
    preamble_s: float = 40e-6
    symbol_s: float = 8e-6
    sensing_s: float = 8e-6
    immediate_access: bool = True
    noise_figure_db: float = 6.0
    bandwidth_hz: float = 10e6
    sensitivity_dbm: float = -92.0
    decodable_dbm: float = -85.0
    energy_dbm: float = -65.0
    load_dbm: float = -85.0
    busy_window_s: float = 0.1
    preamble_db: float = 4.0
    capture_s: float = 32e-6
    capture_db: float = 4.0
    antenna_gain_db: float = 0.0
    max_power_dbm: float = 23.0
    margin_db: float = 10.0
    bin_m: float = 50.0
    bins: int = 10

    def __post_init__(self) -> None:
        if self.rate_mbps not in BIT_RATES:
            raise ValueError(f"rate_mbps must be one of {sorted(BIT_RATES)}, got {self.rate_mbps}")
        for name in ("slot_s", "sifs_s", "preamble_s", "symbol_s", "bandwidth_hz", "busy_window_s", "bin_m"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not 0 <= self.sensing_s <= self.slot_s:
            raise ValueError(f"sensing_s must lie within 0..{self.slot_s} (a slot), got {self.sensing_s}")
        if self.bins < 1:
            raise ValueError(f"bins must be at least 1, got {self.bins}")

    @property
    def bit_rate(self) -> BitRate:
        """Modulation and coding of the rate."""
        return BIT_RATES[self.rate_mbps]

    @property
    def aifs_s(self) -> float:
        """Interframe space before a countdown [s]."""
        return self.sifs_s + self.access.aifsn * self.slot_s

    @property
    def noise_dbm(self) -> float:
        """Noise of the receiver [dBm]."""
        return thermal_noise_dbm(self.bandwidth_hz) + self.noise_figure_db

    def airtime_s(self, size_bytes: IntArray) -> FloatArray:
        """Duration of frames, (N,) [s].

        Parameters
        ----------
        size_bytes
            Bytes handed to the physical layer, (N,).

        Examples
        --------
        >>> import numpy as np
        >>> (1e6 * DsrcParameters().airtime_s(np.array([180, 250, 350]))).round(3).tolist()
        [288.0, 384.0, 512.0]
        """
        bits = 22 + 8 * np.asarray(size_bytes, dtype=np.int64)
        return self.preamble_s + self.symbol_s * np.ceil(bits / self.bit_rate.bits_per_symbol)


def thermal_noise_dbm(bandwidth_hz: float) -> float:
    """Thermal noise at 290 K [dBm]."""
    return float(10.0 * np.log10(1.380649e-23 * 290.0 * bandwidth_hz * 1e3))


@dataclass(frozen=True, slots=True)
class DsrcState:
    """A channel at one instant: plain arrays, whose columns are named in ``dsrc_kernels``.

    Parameters
    ----------
    t_s
        Now [s].
    random
        Word of the random generator, (1,).
    station
        Receiver, medium access and frame of every vehicle, (V, COLUMNS).
    message
        Messages that wait and that are on the air, (V, 2).
    air_receiver, air_mw, air_flag
        Links of the frames on the air, (L,), (L,), (L, 2).
    pairs, pair_count
        Shadowing of pairs: open addressing, (C, 4), (1,).
    """

    t_s: float
    random: np.ndarray[tuple[int], np.dtype[np.uint64]]
    _: KW_ONLY
    station: FloatArray
    message: IntArray
    air_receiver: np.ndarray[tuple[int], np.dtype[np.int32]]
    air_mw: FloatArray
    air_flag: np.ndarray[tuple[int, int], np.dtype[np.int16]]
    pairs: FloatArray
    pair_count: IntArray

    @property
    def vehicles(self) -> int:
        """Number of vehicles V."""
        return self.station.shape[0]

    def copy(self) -> "DsrcState":
        """Same state in arrays of its own."""
        return replace(
            self,
            random=self.random.copy(),
            station=self.station.copy(),
            message=self.message.copy(),
            pairs=self.pairs.copy(),
            pair_count=self.pair_count.copy(),
        )


@dataclass(frozen=True, slots=True)
class Dsrc(AbstractRadio[DsrcState]):
    """IEEE 802.11p broadcast of a fleet on one channel.

    Parameters
    ----------
    parameters
        Constants of the radio.
    propagation
        What becomes of the power.
    error_model
        Packet error against SINR; None for the NIST model of the bit rate.

    Notes
    -----
    A receiver locks on to a frame that is strong enough and stands out of what is on the air at its
    beginning. It stays locked to the end, save for capture in the preamble, or its own countdown ending
    before it has sensed the frame. Interference is all other power in range, over the payload. Preamble and
    SIGNAL fail only at their beginning. A vehicle's queue holds one message.

    Examples
    --------
    >>> import numpy as np
    >>> radio = Dsrc()
    >>> state = radio.init(2, np.random.default_rng(1))
    >>> one = Transmissions(
    ...     np.array([0]),
    ...     np.array([0.01]),
    ...     size_bytes=np.array([300]),
    ...     power_dbm=np.array([20.0]),
    ...     message_id=np.array([7]),
    ... )
    >>> heard, state = radio.step(state, one, np.array([[0.0, 0.0], [50.0, 0.0]]), 0.1)
    >>> heard.message_id.tolist(), heard.receiver.tolist(), heard.t_s.round(6).tolist()
    ([7], [1], [0.010448])
    """

    parameters: DsrcParameters = field(default_factory=DsrcParameters)
    propagation: Propagation = field(default_factory=Propagation)
    error_model: AbstractErrorModel | None = None
    constants: DsrcConstants = field(init=False, repr=False, compare=False)
    hazard: FloatArray = field(init=False, repr=False, compare=False)
    tables: PropagationTables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        error_model = self.error_model
        if error_model is None:
            rate = self.parameters.bit_rate
            error_model = NistErrorModel(rate.bits_per_subcarrier, rate.code_rate)
        constants = self._constants(error_model)
        object.__setattr__(self, "constants", constants)
        object.__setattr__(self, "hazard", np.ascontiguousarray(error_model.hazards()))
        object.__setattr__(self, "tables", self.propagation.tables(constants.range_m))

    @property
    def range_m(self) -> float:
        """Distance beyond which nothing is heard or disturbed [m]."""
        return self.constants.range_m

    def _constants(self, error_model: AbstractErrorModel) -> DsrcConstants:
        p = self.parameters
        loudest_dbm = p.max_power_dbm + 2.0 * p.antenna_gain_db
        range_m = self.propagation.range_m(loudest_dbm - (p.noise_dbm - p.margin_db))
        units_fixed = float(error_model.units(np.array([0.0]))[0])
        units_per_byte = float(error_model.units(np.array([1.0]))[0]) - units_fixed
        shadowing = self.propagation.shadowing
        return DsrcConstants(
            slot_s=p.slot_s,
            aifs_s=p.aifs_s,
            window=p.access.window,
            sensing_s=p.sensing_s,
            immediate=p.immediate_access,
            preamble_s=p.preamble_s,
            symbol_s=p.symbol_s,
            bits_per_symbol=p.bit_rate.bits_per_symbol,
            capture_s=p.capture_s,
            capture_ratio=_ratio(p.capture_db),
            preamble_ratio=_ratio(p.preamble_db),
            noise_mw=_ratio(p.noise_dbm),
            sensitivity_mw=_ratio(p.sensitivity_dbm),
            decodable_mw=_ratio(p.decodable_dbm),
            energy_mw=_ratio(p.energy_dbm),
            load_mw=_ratio(p.load_dbm),
            floor_mw=_ratio(p.noise_dbm - 2.0 * p.margin_db),
            gain_db=2.0 * p.antenna_gain_db,
            range_m=range_m,
            bin_m=p.bin_m,
            bins=p.bins,
            window_s=p.busy_window_s,
            by_stretch=error_model.by_stretch,
            units_fixed=units_fixed,
            units_per_byte=units_per_byte,
            shadowed=shadowing is not None and (shadowing.los_db > 0 or shadowing.nlos_db > 0),
        )

    def init(self, vehicles: int, rng: np.random.Generator) -> DsrcState:
        """State of a silent channel at time 0."""
        if vehicles < 1:
            raise ValueError(f"vehicles must be at least 1, got {vehicles}")
        pairs, pair_count = empty_pairs(1024)
        return DsrcState(
            0.0,
            rng.integers(0, 2**64, size=1, dtype=np.uint64),
            station=silent_station(vehicles),
            message=np.full((vehicles, 2), -1, dtype=np.int64),
            air_receiver=np.empty(0, dtype=np.int32),
            air_mw=np.empty(0),
            air_flag=np.empty((0, 2), dtype=np.int16),
            pairs=pairs,
            pair_count=pair_count,
        )

    def step(
        self, state: DsrcState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, DsrcState]:
        """Carry one interval; the given state is left alone."""
        return self.carry(state.copy(), transmissions, position_m, until_t_s)

    def carry(
        self, state: DsrcState, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, DsrcState]:
        """Carry one interval and use the given state up: faster than `step`, for a loop that owns its state.

        Parameters
        ----------
        state
            Its arrays are written into; do not use it again.
        transmissions, position_m, until_t_s
            As for `step`.
        """
        transmissions.check(state.t_s, until_t_s, position_m, state.vehicles, self.parameters.max_power_dbm)
        who, when, outcomes, expired, receiver, mw, flag, pairs, count = advance(
            state.t_s,
            until_t_s,
            state.random,
            state.station,
            state.message,
            state.air_receiver,
            state.air_mw,
            state.air_flag,
            state.pairs,
            state.pair_count,
            transmissions.sender,
            transmissions.ready_s,
            transmissions.size_bytes,
            transmissions.power_dbm,
            transmissions.message_id,
            np.ascontiguousarray(position_m, dtype=np.float64),
            self.hazard,
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
        after = replace(
            state,
            t_s=until_t_s,
            air_receiver=receiver,
            air_mw=mw,
            air_flag=flag,
            pairs=pairs,
            pair_count=count,
        )
        return receptions, after

    def channel_busy_ratio(self, state: DsrcState) -> FloatArray:
        """Busy share of the last full 100 ms of every vehicle, 0..1, (V,)."""
        return state.station[:, BUSY_RATIO].copy()


def _ratio(decibels: float) -> float:
    return float(10.0 ** (0.1 * decibels))

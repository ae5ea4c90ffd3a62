"""Constants of IEEE 802.11p, by document: rates, access categories, thresholds."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.airtime_kernels import SERVICE_TAIL_BITS, frame_airtimes
from modelcast.channel.parameter_bounds import check_bins, check_decibels
from modelcast.core.arrays import FloatArray, IntArray, owned

__all__ = [
    "ACCESS_CATEGORIES",
    "BIT_RATES",
    "AccessCategory",
    "BitRate",
    "DsrcParameters",
    "power_ratio",
    "thermal_noise_dbm",
]


_MOST_AIFSN, _MOST_WINDOW = 15, 32_767
"""AIFSN has four bits, and so has the exponent of CWmin (from memory)."""

_LEAST_WINDOW_S = 1e-3
"""Every window of the busy ratio costs a turn of the compiled loop."""

_LONGEST_S = 10.0
"""Spaces and windows of time are at most this long."""


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
        if self.aifsn > _MOST_AIFSN or self.window > _MOST_WINDOW:
            raise ValueError(f"aifsn must be at most {_MOST_AIFSN}, window {_MOST_WINDOW}, got {self}")


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
    aifs_on_arrival
        Whether a message that counts down first waits for AIFS from when it became ready; else idle time
        before counts. Only without ``immediate_access``.
    extended_s
        After a frame it could not decode, a vehicle waits this long more before it counts (EIFS, 10.3.2.3.7):
        SIFS and an acknowledgement at 3 Mb/s, 32 + 88 us [s].
    noise_figure_db, bandwidth_hz
        The receiver's noise, at 290 K [dB], [Hz].
    sensitivity_dbm
        Weakest frame a receiver locks on to; vRxSens of SAE J2945/1 is -92 dBm. The standard demands -85 dBm
        at 6 Mb/s [dBm].
    decodable_dbm
        A frame that is being received holds the medium busy from this power on; 17.3.10.6: -85 dBm [dBm].
    energy_dbm
        Power of any kind, all together, that holds the medium busy; 17.3.10.6: 20 dB above, -65 dBm. ns-3
        3.44 asks for -82 dBm where a frame begins that is not received (CcaSensitivity) [dBm].
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
    ties_spoil
        Whether a frame is lost wherever another begins in the same instant and does not take the receiver
        over, however weak that is. So it is in WiLabV2Xsim: its mean over no time at all is not a number. No
        receiver does so.
    antenna_gain_db
        Of either end [dB].
    max_power_dbm
        No transmission may exceed it; it sets the range [dBm].
    margin_db
        Signals this much below the noise are left out: whoever is so far that the median power is below, and
        single signals that shadowing and fading bring below. They count as below sensitivity [dB].
    weak_margin_db
        Of links of which one end has a weak antenna (`modelcast.channel.antennas`): who is so far that the
        median power is this much below the noise is left out [dB].
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
    aifs_on_arrival: bool = False
    extended_s: float = 120e-6
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
    ties_spoil: bool = False
    antenna_gain_db: float = 0.0
    max_power_dbm: float = 23.0
    margin_db: float = 10.0
    weak_margin_db: float = 0.0
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
        if self.aifs_on_arrival and self.immediate_access:
            raise ValueError("aifs_on_arrival needs immediate_access=False: else a message goes out at once")
        for name in (
            "slot_s",
            "sifs_s",
            "preamble_s",
            "symbol_s",
            "busy_window_s",
            "extended_s",
            "capture_s",
        ):
            if not 0 <= getattr(self, name) <= _LONGEST_S:
                raise ValueError(f"{name} must lie within 0..{_LONGEST_S:g} s, got {getattr(self, name)}")
        if self.busy_window_s < _LEAST_WINDOW_S:
            raise ValueError(
                f"busy_window_s must be at least {_LEAST_WINDOW_S:g} s, got {self.busy_window_s}"
            )
        check_decibels(self)
        if not self.margin_db >= 0:
            raise ValueError(f"margin_db must not be negative, got {self.margin_db}")
        check_bins(self.bins, self.bin_m)
        if not 1e3 <= self.bandwidth_hz <= 1e12:
            raise ValueError(f"bandwidth_hz must lie within 1e3..1e12, got {self.bandwidth_hz}")

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
        sizes: IntArray = owned(size_bytes, np.int64)
        per_symbol = self.bit_rate.bits_per_symbol
        return frame_airtimes(sizes, self.preamble_s, self.symbol_s, SERVICE_TAIL_BITS, per_symbol)


def thermal_noise_dbm(bandwidth_hz: float) -> float:
    """Thermal noise at 290 K [dBm]."""
    return float(10.0 * np.log10(1.380649e-23 * 290.0 * bandwidth_hz * 1e3))


def power_ratio(decibels: float) -> float:
    """Ratio of powers, or power in mW from dBm."""
    return float(10.0 ** (0.1 * decibels))

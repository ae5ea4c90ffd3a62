"""Packet error against SINR: three kinds of error model, one form.

`NistErrorModel` knows coded bit errors in white noise; every stretch of the frame counts by its own SINR. Use
it where fading is drawn apart (`NakagamiFading`); ns-3 does the same. `TabulatedErrorModel` is a curve for
whole frames, fading included: use it with propagation that has no fast fading. `ThresholdErrorModel` receives
above a SINR and loses below, as some simulators do. `modelcast.channel.table_error_model` has ns-3's default.

The common form: a frame has a number of units (bits, or reference frames). Success is exp(-units·h), where h
is a table over SINR, the hazard of a unit.
"""

import abc
from dataclasses import KW_ONLY, dataclass
from typing import Self

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.scientific import scientific

__all__ = [
    "HAZARD_MIN_DB",
    "HAZARD_PER_DB",
    "HAZARD_SIZE",
    "MOST_HAZARD",
    "SINR_DB",
    "AbstractErrorModel",
    "NistErrorModel",
    "TabulatedErrorModel",
    "ThresholdErrorModel",
    "safe_ratio",
]

HAZARD_MIN_DB = -30.0
HAZARD_PER_DB = 20.0
HAZARD_SIZE = 1601
"""The table of hazards reaches from -30 dB to 50 dB in steps of 0.05 dB."""

MOST_HAZARD = 60.0
"""A hazard that no frame survives."""

NO_HAZARD = 1e-22
"""A hazard that all units of a frame together survive, however chance falls: it has 53 bits."""

SINR_DB = HAZARD_MIN_DB + np.arange(HAZARD_SIZE) / HAZARD_PER_DB
"""Where the table of hazards has its values, (HAZARD_SIZE,) [dB]."""

_HIGHWAY_LOS = {0: 0.766, 1: 0.508, 2: 0.264, 3: 0.111, 4: 0.040, 5: 0.013, 6: 0.003, 7: 0.001}
_HIGHWAY_NLOS = {1: 0.996, 2: 0.971, 3: 0.893, 4: 0.689, 5: 0.433, 6: 0.201, 7: 0.071}
_URBAN_LOS = {0: 0.919, 1: 0.726, 2: 0.460, 3: 0.220, 4: 0.080, 5: 0.029, 6: 0.005, 7: 0.002}
_CROSSING_NLOS = {1: 0.990, 2: 0.933, 3: 0.766, 4: 0.501, 5: 0.241, 6: 0.087, 7: 0.024}
_NR_MCS7 = {3: 0.951, 5: 0.878, 7: 0.748, 9: 0.522, 11: 0.289, 13: 0.130, 15: 0.042, 17: 0.011, 19: 0.0022}
_NR_MCS21 = {
    11: 0.990,
    13: 0.941,
    15: 0.818,
    17: 0.663,
    19: 0.511,
    21: 0.371,
    23: 0.259,
    25: 0.192,
    27: 0.138,
    29: 0.098,
    31: 0.076,
    35: 0.038,
    37: 0.027,
    39: 0.020,
    41: 0.016,
    43: 0.013,
}
_MODE4_MCS5 = {-2: 0.860, -1: 0.596, 0: 0.314, 1: 0.121, 2: 0.035, 3: 0.008}


class AbstractErrorModel(abc.ABC):
    """Chance of a frame to be lost, from its SINR."""

    @property
    @abc.abstractmethod
    def by_stretch(self) -> bool:
        """Whether every stretch of a frame counts by its own SINR (else: the mean interference counts)."""

    @property
    def holds_fading(self) -> bool:
        """Whether the chance is over fast fading already: none is to be drawn beside."""
        return False

    @abc.abstractmethod
    def hazards(self) -> FloatArray:
        """Hazard of a unit at -30 dB, -29.95 dB, ... 50 dB, (HAZARD_SIZE,)."""

    @abc.abstractmethod
    def units(self, size_bytes: FloatArray) -> FloatArray:
        """Units of frames of these sizes, (N,)."""

    def packet_error_ratio(self, sinr_db: FloatArray, size_bytes: int) -> FloatArray:
        """Chance to lose a frame whose SINR is the same throughout, (N,).

        Parameters
        ----------
        sinr_db
            Signal to interference and noise, (N,) [dB].
        size_bytes
            Size of the frame.
        """
        hazard = np.interp(sinr_db, SINR_DB, self.hazards())
        return -np.expm1(-hazard * self.units(np.array([float(size_bytes)])))


def safe_ratio(hazards: FloatArray) -> float:
    """Power ratio from which on a table has no hazard above `NO_HAZARD`; infinite where there is none.

    Parameters
    ----------
    hazards
        As `AbstractErrorModel.hazards` gives them, (HAZARD_SIZE,).
    """
    at = int(np.max(np.flatnonzero(hazards > NO_HAZARD), initial=-1)) + 1
    return 10.0 ** (0.1 * float(SINR_DB[at])) if at < HAZARD_SIZE else float("inf")


@dataclass(frozen=True, slots=True)
class NistErrorModel(AbstractErrorModel):
    """Convolutional code in white noise: union bound over the code's distance spectrum.

    Parameters
    ----------
    bits_per_symbol
        1, 2, 4 or 6 coded bits a subcarrier: BPSK, QPSK, 16-QAM, 64-QAM.
    code_rate
        One of 1/2, 2/3 and 3/4.
    loss_db
        Implementation loss; hardware was measured about 5 dB worse than the bound (second-hand) [dB].

    Notes
    -----
    A frame has 22 + 8·bytes bits (service and tail included). For BPSK and QPSK the bit error before decoding
    is p = erfc(sqrt(SNR/b))/2 with b bits a symbol; D = sqrt(4p(1-p)); the error of a decoded bit is at most
    sum(c_d·D^d)/(2k), capped at 1; success of the frame is (1 - P)^bits.

    References
    ----------
    G. Pei and T. Henderson, "Validation of OFDM error rate model in ns-3", 2010. Spectra of the punctured
    codes: D. Haccoun and G. Begin, 1989, DOI 10.1109/26.46523.

    Examples
    --------
    >>> import numpy as np
    >>> NistErrorModel().packet_error_ratio(np.array([5.0, 6.0, 7.0]), 300).round(2).tolist()
    [1.0, 0.46, 0.02]
    """

    bits_per_symbol: int = 2
    code_rate: float = 0.5
    _: KW_ONLY
    loss_db: float = 0.0

    def __post_init__(self) -> None:
        if self.bits_per_symbol not in (1, 2, 4, 6):
            raise ValueError(f"bits_per_symbol must be 1, 2, 4 or 6, got {self.bits_per_symbol}")
        if not any(np.isclose(self.code_rate, rate) for rate in _SPECTRA):
            raise ValueError(f"code_rate must be 1/2, 2/3 or 3/4, got {self.code_rate}")
        if not np.isfinite(self.loss_db):
            raise ValueError(f"loss_db must be finite, got {self.loss_db}")

    @property
    def by_stretch(self) -> bool:
        """Yes: a bit fails by the noise of its own time."""
        return True

    def hazards(self) -> FloatArray:
        """Hazard of a bit, (HAZARD_SIZE,)."""
        snr = 10.0 ** (0.1 * (SINR_DB - self.loss_db))
        side = 2.0 ** (self.bits_per_symbol / 2.0)
        if self.bits_per_symbol <= 2:
            scale, argument = 0.5, np.sqrt(snr / self.bits_per_symbol)
        else:
            scale = (1.0 - 1.0 / side) / np.log2(side)
            argument = np.sqrt(1.5 * snr / (side**2 - 1.0))
        special = scientific("special", "802.11p")
        raw = scale * np.asarray(special.erfc(argument), dtype=np.float64)
        distance = np.sqrt(4.0 * raw * (1.0 - raw))
        first, step, branches, weights = next(
            spectrum for rate, spectrum in _SPECTRA.items() if np.isclose(self.code_rate, rate)
        )
        exponents = first + step * np.arange(len(weights))
        bound = (np.asarray(weights) * distance[:, None] ** exponents).sum(axis=1) / (2.0 * branches)
        with np.errstate(divide="ignore"):
            return np.minimum(-np.log1p(-np.minimum(bound, 1.0)), MOST_HAZARD)

    def units(self, size_bytes: FloatArray) -> FloatArray:
        """Bits, (N,)."""
        return 22.0 + 8.0 * size_bytes


_SPECTRA = {
    1 / 2: (10, 2, 1, (36.0, 211.0, 1404.0, 11633.0, 77433.0, 502690.0, 3322763.0, 21292910.0, 134365911.0)),
    2 / 3: (6, 1, 2, (3.0, 70.0, 285.0, 1276.0, 6160.0, 27128.0, 117019.0, 498860.0, 2103891.0, 8784123.0)),
    3 / 4: (5, 1, 3, (42.0, 201.0, 1492.0, 10469.0, 62935.0, 379644.0, 2253373.0, 13073811.0, 75152755.0)),
}
"""Least distance, its step, information bits a branch, and weights of the code's distance spectrum."""


@dataclass(frozen=True, slots=True)
class TabulatedErrorModel(AbstractErrorModel):
    """A curve of packet error against SINR for frames of one size.

    Parameters
    ----------
    sinr_db, packet_error_ratio
        The curve; SINR rising, ratio falling within 0..1.
    reference_bytes
        Size of the frames it was made with. A frame of n bytes counts as n/reference of them.
    faded
        Whether the curve was made over a channel that fades, as the named ones were.

    Notes
    -----
    Between points the hazard -ln(1 - PER) is interpolated in its logarithm; beyond the ends it follows the
    slope of the last two points. The interference is averaged over the frame.

    References
    ----------
    The named curves are those of ETSI TR 103 257-1 channels at 5.9 GHz, 350 bytes (NR: 100 bytes), as
    published with WiLabV2Xsim (second-hand).
    """

    sinr_db: tuple[float, ...]
    packet_errors: tuple[float, ...]
    _: KW_ONLY
    reference_bytes: int = 350
    faded: bool = True

    def __post_init__(self) -> None:
        if len(self.sinr_db) != len(self.packet_errors) or len(self.sinr_db) < 2:
            raise ValueError("sinr_db and packet_errors must be equally long, at least 2")
        if not (np.all(np.diff(self.sinr_db) > 0) and np.all(np.diff(self.packet_errors) < 0)):
            raise ValueError("sinr_db must rise and packet_errors must fall")
        if not (self.packet_errors[-1] > 0 and self.packet_errors[0] < 1):
            raise ValueError("packet_errors must lie within 0..1, both excluded")
        if self.reference_bytes < 1:
            raise ValueError(f"reference_bytes must be at least 1, got {self.reference_bytes}")

    @classmethod
    def _of(cls, curve: dict[int, float], reference_bytes: int = 350) -> Self:
        at = tuple(float(sinr_db) for sinr_db in curve)
        return cls(at, tuple(curve.values()), reference_bytes=reference_bytes)

    @classmethod
    def highway_los(cls) -> Self:
        """IEEE 802.11p, MCS 2, highway with line of sight."""
        return cls._of(_HIGHWAY_LOS)

    @classmethod
    def highway_nlos(cls) -> Self:
        """IEEE 802.11p, MCS 2, highway behind a vehicle."""
        return cls._of(_HIGHWAY_NLOS)

    @classmethod
    def urban_los(cls) -> Self:
        """IEEE 802.11p, MCS 2, street with line of sight."""
        return cls._of(_URBAN_LOS)

    @classmethod
    def crossing_nlos(cls) -> Self:
        """IEEE 802.11p, MCS 2, round a corner."""
        return cls._of(_CROSSING_NLOS)

    @classmethod
    def sidelink_mcs5(cls) -> Self:
        """LTE-V2X, MCS 5, highway with line of sight."""
        return cls._of(_MODE4_MCS5)

    @classmethod
    def nr_mcs7(cls) -> Self:
        """NR-V2X, MCS 7, street behind buildings, 100 bytes."""
        return cls._of(_NR_MCS7, 100)

    @classmethod
    def nr_mcs21(cls) -> Self:
        """NR-V2X, MCS 21, street behind buildings, 100 bytes."""
        return cls._of(_NR_MCS21, 100)

    @property
    def by_stretch(self) -> bool:
        """No: the curve knows whole frames."""
        return False

    @property
    def holds_fading(self) -> bool:
        """As the curve was made."""
        return self.faded

    def hazards(self) -> FloatArray:
        """Hazard of a reference frame, (HAZARD_SIZE,)."""
        ln = np.log(-np.log1p(-np.asarray(self.packet_errors)))
        at = np.asarray(self.sinr_db)
        inner = np.interp(SINR_DB, at, ln)
        low = ln[0] + (ln[1] - ln[0]) / (at[1] - at[0]) * (SINR_DB - at[0])
        high = ln[-1] + (ln[-1] - ln[-2]) / (at[-1] - at[-2]) * (SINR_DB - at[-1])
        whole = np.where(at[0] > SINR_DB, low, np.where(at[-1] < SINR_DB, high, inner))
        return np.minimum(np.exp(np.minimum(whole, np.log(MOST_HAZARD))), MOST_HAZARD)

    def units(self, size_bytes: FloatArray) -> FloatArray:
        """Reference frames, (N,)."""
        return np.asarray(size_bytes) / self.reference_bytes


@dataclass(frozen=True, slots=True)
class ThresholdErrorModel(AbstractErrorModel):
    """Received where the SINR reaches a bound, lost below.

    Parameters
    ----------
    threshold_db
        The bound, met to 0.05 dB [dB].
    """

    threshold_db: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.threshold_db) and abs(self.threshold_db) < 30):
            raise ValueError(f"threshold_db must lie within -30..30, got {self.threshold_db}")

    @property
    def by_stretch(self) -> bool:
        """No: the bound is on the frame's mean."""
        return False

    def hazards(self) -> FloatArray:
        """Nothing above the bound, certain loss below, (HAZARD_SIZE,)."""
        return np.where(self.threshold_db - 1e-9 <= SINR_DB, 0.0, MOST_HAZARD)

    def units(self, size_bytes: FloatArray) -> FloatArray:
        """One, whatever the size, (N,)."""
        return np.ones_like(np.asarray(size_bytes, dtype=np.float64))

"""Packet error by tables over SINR, a rate and a size each: ns-3's default error model.

`TableErrorModel` holds what `ns3::TableBasedErrorRateModel` of ns-3 3.44 answers in white noise, measured by
``validation/ns3_error_tables.py``. At 6 Mb/s it is about 3 dB more sensitive than `NistErrorModel`.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.error_models import MOST_HAZARD, SINR_DB, AbstractErrorModel
from modelcast.core.arrays import FloatArray

__all__ = ["ERROR_TABLES", "TABLE_STEP_DB", "TableErrorModel"]

TABLE_STEP_DB = 0.5
"""Between the entries of a table; packet error is linear in between [dB]."""

ERROR_TABLES: dict[tuple[float, int], tuple[float, tuple[float, ...]]] = {
    (3.0, 32): (
        -3.0,
        (0.995, 0.9408, 0.8259, 0.5895, 0.3083, 0.1254, 0.0344, 0.0085, 0.0015, 0.00024, 9e-05),
    ),
    (3.0, 1458): (-0.5, (0.994, 0.8185, 0.2908, 0.0663, 0.0112, 0.0015, 0.00015, 1e-05)),
    (6.0, 32): (
        0.0,
        (0.9921, 0.9671, 0.8349, 0.5874, 0.3169, 0.1182, 0.0364, 0.0085, 0.0016, 0.00026, 3e-05),
    ),
    (6.0, 1458): (2.5, (0.997, 0.7944, 0.3008, 0.0728, 0.012, 0.0015, 0.00023)),
    (9.0, 32): (2.5, (0.994, 0.9588, 0.8512, 0.599, 0.3125, 0.1171, 0.0339, 0.0078, 0.0016, 0.00028, 8e-05)),
    (9.0, 1458): (5.0, (0.998, 0.7578, 0.301, 0.0676, 0.0122, 0.0023, 0.00035, 4e-05)),
    (12.0, 32): (
        4.5,
        (
            0.999,
            0.998,
            0.969,
            0.8843,
            0.7409,
            0.4651,
            0.2571,
            0.108,
            0.0381,
            0.0119,
            0.0032,
            0.00076,
            0.00017,
            3e-05,
        ),
    ),
    (12.0, 1458): (8.0, (0.994, 0.8405, 0.4341, 0.1419, 0.0374, 0.0086, 0.0019, 0.00036, 5e-05)),
    (18.0, 32): (
        8.5,
        (0.999, 0.9479, 0.7989, 0.5923, 0.337, 0.1572, 0.0542, 0.0158, 0.004, 0.0011, 0.00027, 9e-05),
    ),
    (18.0, 1458): (11.5, (0.9269, 0.5139, 0.1826, 0.0465, 0.011, 0.0026, 0.00041, 0.0001)),
    (24.0, 32): (
        12.0,
        (
            0.998,
            0.9653,
            0.897,
            0.7301,
            0.5257,
            0.3058,
            0.1575,
            0.0646,
            0.0241,
            0.0079,
            0.0023,
            0.00069,
            0.00018,
            4e-05,
            2e-05,
        ),
    ),
    (24.0, 1458): (
        15.0,
        (0.999, 0.9479, 0.6625, 0.2978, 0.1058, 0.0334, 0.0091, 0.0023, 0.00064, 0.00017, 2e-05),
    ),
    (27.0, 32): (
        13.5,
        (
            0.9901,
            0.9625,
            0.8398,
            0.6866,
            0.4634,
            0.252,
            0.1145,
            0.0461,
            0.0158,
            0.0049,
            0.0016,
            0.00039,
            0.00011,
            2e-05,
        ),
    ),
    (27.0, 1458): (16.5, (0.995, 0.8796, 0.5139, 0.2091, 0.0639, 0.0186, 0.0046, 0.0013, 0.00023, 2e-05)),
}
"""By Mb/s of a 10 MHz channel and bytes of a frame: SINR of the first entry, and packet errors from there on.
A step before the first all frames are lost, a step after the last none. There is none of 4.5 Mb/s: ns-3 has
no table of it."""


@dataclass(frozen=True, slots=True)
class TableErrorModel(AbstractErrorModel):
    """Convolutional code in white noise, by tables of simulated packet errors.

    Parameters
    ----------
    rate_mbps
        Rate of a 10 MHz channel with a table: 3, 6, 9, 12, 18, 24 or 27 [Mb/s].
    table_bytes
        Which table: 32, ns-3's for frames (or stretches of them) below 400 bytes; 1458, for longer ones.
    loss_db
        Implementation loss: the tables hold at so much more SINR [dB].

    Notes
    -----
    A frame of n bytes counts as n / table_bytes of the table's, its success as that power. Service and tail
    bits count with it. ns-3 changes tables by the length of the stretch between two changes of interference;
    here all frames have the one that is set. The two differ by less than 0.15 dB at 400 bytes and 6 Mb/s.

    References
    ----------
    R. Patidar, S. Roy, T. R. Henderson and A. Chandramohan, "Link-to-system mapping for ns-3 Wi-Fi OFDM
    error models", 2017 (from memory); the numbers were measured on ns-3 3.44.

    Examples
    --------
    >>> import numpy as np
    >>> TableErrorModel().packet_error_ratio(np.array([2.0, 3.0, 4.0]), 300).round(2).tolist()
    [0.97, 0.3, 0.02]
    """

    rate_mbps: float = 6.0
    _: KW_ONLY
    table_bytes: int = 32
    loss_db: float = 0.0

    def __post_init__(self) -> None:
        if (self.rate_mbps, self.table_bytes) not in ERROR_TABLES:
            rates, sizes = ({key[k] for key in ERROR_TABLES} for k in range(2))
            raise ValueError(
                f"there are tables of {sorted(rates)} Mb/s and of {sorted(sizes)} bytes, "
                f"got {self.rate_mbps} and {self.table_bytes}"
            )
        if not np.isfinite(self.loss_db):
            raise ValueError(f"loss_db must be finite, got {self.loss_db}")

    @property
    def by_stretch(self) -> bool:
        """Yes: as ns-3 does, every stretch between two changes of interference counts by itself."""
        return True

    def hazards(self) -> FloatArray:
        """Hazard of a frame of the table's size, (HAZARD_SIZE,)."""
        first_db, errors = ERROR_TABLES[self.rate_mbps, self.table_bytes]
        at_db = first_db + TABLE_STEP_DB * np.arange(-1, len(errors) + 1)
        lost = np.interp(SINR_DB - self.loss_db, at_db, (1.0, *errors, 0.0))
        with np.errstate(divide="ignore"):
            return np.minimum(-np.log1p(-lost), MOST_HAZARD * self.table_bytes)

    def units(self, size_bytes: FloatArray) -> FloatArray:
        """Frames of the table's size, (N,)."""
        return np.asarray((22.0 + 8.0 * np.asarray(size_bytes)) / (8.0 * self.table_bytes), dtype=np.float64)

"""Antennas that are weaker than a vehicle's, as those of phones are: a gain for every station of a radio."""

from typing import NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.kernel_types import BoolVector, FloatVector

__all__ = ["Antennas", "antennas", "checked_gains"]


class Antennas(NamedTuple):
    """Gains beside a vehicle's, in logarithms: ``gain_ln`` (V,), none above 0.

    ``weak`` (V,) says whose is below 0, ``weak_ln`` is the greatest of these.
    """

    gain_ln: FloatVector
    weak: BoolVector
    weak_ln: float


def checked_gains(gain_db: FloatArray, stations: int) -> FloatArray:
    """Gains of all stations, as radios keep them, (V,) [dB].

    Parameters
    ----------
    gain_db
        What each antenna adds to a vehicle's, as it hears and as it sends, (V,) [dB].
    stations
        V.

    Raises
    ------
    ValueError
        Where it is not one a station, not finite, or above 0: ranges are those of vehicles.
    """
    if gain_db.shape != (stations,):
        raise ValueError(f"gain_db must be ({stations},), got {gain_db.shape}")
    if not np.isfinite(gain_db).all() or gain_db.max(initial=0.0) > 0.0:
        raise ValueError("gain_db must be finite and not above 0 dB, a vehicle's antenna")
    return np.ascontiguousarray(gain_db, dtype=np.float64)


def antennas(gain_db: FloatArray) -> Antennas:
    """Gains as compiled loops take them.

    Parameters
    ----------
    gain_db
        As `checked_gains` gives them, (V,) [dB].

    Examples
    --------
    >>> import numpy as np
    >>> found = antennas(np.array([0.0, -10.0, -20.0]))
    >>> found.weak.tolist(), round(found.weak_ln, 3)
    ([False, True, True], -2.303)
    """
    gain_ln = gain_db * np.log(10.0) / 10.0
    weak = gain_ln < 0.0
    return Antennas(gain_ln, weak, float(gain_ln[weak].max(initial=-np.inf)) if weak.any() else 0.0)

"""Bounds that the parameters of every radio keep: decibels, and bins of distance."""

from dataclasses import fields
from math import inf
from typing import Any

__all__ = ["check_bins", "check_decibels"]

_DECIBELS = 300.0
"""Beyond, floats cannot hold ratios of powers and their products."""

_MOST_BINS = 100_000
_LEAST_BIN_M = 0.1


def check_decibels(holder: Any) -> None:
    """Refuse gains, ratios and powers that are beyond plus or minus 300 dB or dBm.

    Parameters
    ----------
    holder
        A dataclass. Its fields in decibels have names that end in ``_db`` or ``_dbm``.

    Raises
    ------
    ValueError
        Where one is beyond, or not a number.
    """
    for one in fields(holder):
        if one.init and one.name.endswith(("_db", "_dbm")):
            value = getattr(holder, one.name)
            if not abs(value) <= _DECIBELS:
                raise ValueError(f"{one.name} must lie within {-_DECIBELS:g}..{_DECIBELS:g}, got {value}")


def check_bins(bins: int, bin_m: float) -> None:
    """Refuse bins of distance that are too many or too narrow.

    Parameters
    ----------
    bins
        How many.
    bin_m
        Width of one [m].

    Raises
    ------
    ValueError
        Where there is none, more than 100 000, or one is below 0.1 m wide or without end.
    """
    if not 1 <= bins <= _MOST_BINS:
        raise ValueError(f"bins must lie within 1..{_MOST_BINS}, got {bins}")
    if not _LEAST_BIN_M <= bin_m < inf:
        raise ValueError(f"bin_m must be finite and at least {_LEAST_BIN_M}, got {bin_m}")

"""Bounds that the parameters of every radio keep: decibels, and bins of distance."""

from dataclasses import fields
from math import inf
from typing import Any

__all__ = ["check_bounds"]

_DECIBELS = 300.0
"""Beyond, floats cannot hold ratios of powers and their products."""

_MOST_BINS = 100_000
_LEAST_BIN_M = 0.1


def check_bounds(holder: Any) -> None:
    """Refuse levels beyond plus or minus 300 dB, and bins of distance that are too many or too narrow.

    Parameters
    ----------
    holder
        A dataclass. Its fields in decibels end in ``_db`` or ``_dbm``; `margin_db`, `bins` and
        `bin_m` are looked at where it has them.

    Raises
    ------
    ValueError
        Where a level is beyond, a margin negative, or bins are none, over 100 000, narrower than 0.1 m or
        without end.
    """
    held = {one.name: getattr(holder, one.name) for one in fields(holder) if one.init}
    for name, value in held.items():
        if name.endswith(("_db", "_dbm")) and not abs(value) <= _DECIBELS:
            raise ValueError(f"{name} must lie within {-_DECIBELS:g}..{_DECIBELS:g}, got {value}")
    if not held.get("margin_db", 0.0) >= 0.0:
        raise ValueError(f"margin_db must not be negative, got {held['margin_db']}")
    if not 1 <= held.get("bins", 1) <= _MOST_BINS:
        raise ValueError(f"bins must lie within 1..{_MOST_BINS}, got {held['bins']}")
    if not _LEAST_BIN_M <= held.get("bin_m", 1.0) < inf:
        raise ValueError(f"bin_m must be finite and at least {_LEAST_BIN_M}, got {held['bin_m']}")

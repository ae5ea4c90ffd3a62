"""What equal-rate baselines may be equal to, for options that must not import what they name."""

from typing import Literal, get_args

__all__ = ["RATE_BASES", "RateBasis"]

RateBasis = Literal["update", "total"]
"""Which of MBC's messages an equal-rate baseline is given the count of: its updates (the paper's), or all."""

RATE_BASES: tuple[RateBasis, ...] = get_args(RateBasis)

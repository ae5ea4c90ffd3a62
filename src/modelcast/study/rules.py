"""Words of results and options, for modules that must not import what they name."""

from typing import Literal, get_args

__all__ = ["BASELINES", "MODEL_SENDER", "RATE_BASES", "RateBasis"]

MODEL_SENDER = "mbc"
"""What rows call the model-based sender where the error-driven policy decides."""

BASELINES = ("baseline", "baseline-matched", "baseline-periodic")
"""What rows call the baselines."""


RateBasis = Literal["update", "total"]
"""Which of MBC's messages an equal-rate baseline is given the count of: its updates (the paper's), or all."""

RATE_BASES: tuple[RateBasis, ...] = get_args(RateBasis)

"""Words of results and options, for modules that must not import what they name."""

from typing import Literal, get_args

__all__ = [
    "BASELINES",
    "FREE_MATCHED",
    "FREE_RECEIVER",
    "MODEL_SENDER",
    "RATE_BASES",
    "RIVALS",
    "RateBasis",
]

MODEL_SENDER = "mbc"
"""What rows call the model-based sender where the error-driven policy decides."""

BASELINES = ("baseline", "baseline-matched", "baseline-periodic")
"""What rows call the baselines."""

FREE_RECEIVER = "free"
"""What rows call plain messages whose receiver extrapolates well, sent by MBC's rules at its threshold."""

FREE_MATCHED = "free-matched"
"""The same at MBC's rate, with a threshold of its own."""

RIVALS = (*BASELINES, FREE_RECEIVER, FREE_MATCHED)
"""All that MBC is held against."""


RateBasis = Literal["update", "total"]
"""Which of MBC's messages an equal-rate baseline is given the count of: its updates (the paper's), or all."""

RATE_BASES: tuple[RateBasis, ...] = get_args(RateBasis)

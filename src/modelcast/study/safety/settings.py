"""What an evaluation of a safety application is asked to do."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, get_args

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import BoolArray
from modelcast.study.safety.rules import BASES, Basis, Truth
from modelcast.study.settings import EvaluationSettings

__all__ = ["NEAR_M", "SafetySettings"]

NEAR_M = 20.0
"""Decisions count where the true margin is smaller than this [m]: far from it nobody errs."""


@dataclass(frozen=True, slots=True)
class SafetySettings:
    """What an evaluation of a safety application over recorded pairs is asked to do.

    Parameters
    ----------
    evaluation
        Thresholds, losses, seeds, sensor, sizes; its protocol is ``sensor``. Bank and rules play no part.
        A policy in NumPy decides for all candidates but one of the baseline's bank.
    application
        What warns.
    bases
        At equal what the senders are held against each other.
    budget
        Name of the candidate whose messages and airtime the others get; None for the last.
    against
        Name of the candidate whose missed warnings are the measure; None for the first.
    truth
        What is held to be right, a `Truth`.
    near_m
        As `NEAR_M` [m].
    later_m
        Hosts warn where their margin is below zero by this much: later, and less often wrongly [m].
    merge_s
        Warnings that stop for less than this are one [s].
    grace_s
        A warning this long after the true one has ended is late, after that it is missed [s].
    resamples
        Bootstrap resamples behind every interval.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    evaluation: EvaluationSettings
    application: AbstractApplication = field(default_factory=ForwardCollisionWarning)
    _: KW_ONLY
    bases: tuple[Basis, ...] = BASES
    budget: str | None = None
    against: str | None = None
    truth: Truth = "knowledge"
    near_m: float = NEAR_M
    later_m: float = 0.0
    merge_s: float = 1.0
    grace_s: float = 1.0
    resamples: int = 2000

    def __post_init__(self) -> None:
        if not self.bases or len(set(self.bases)) != len(self.bases):
            raise ValueError(f"bases must be one or more, each once, got {self.bases}")
        for basis in self.bases:
            if basis not in BASES:
                raise ValueError(f"bases must be of {', '.join(BASES)}, got {basis!r}")
        if self.truth not in get_args(Truth):
            raise ValueError(f"truth must be one of {', '.join(get_args(Truth))}, got {self.truth!r}")
        for name in ("near_m", "merge_s", "grace_s"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not (np.isfinite(self.later_m) and self.later_m >= 0.0):
            raise ValueError(f"later_m must be finite and not negative, got {self.later_m}")
        if self.resamples < 1:
            raise ValueError(f"resamples must be >= 1, got {self.resamples}")
        if self.evaluation.protocol != "sensor":
            raise ValueError(f"the protocol must be sensor, got {self.evaluation.protocol!r}")

    def warned(self, found: Warnings) -> BoolArray:
        """Where a host warns whose application says this, of the same shape.

        Parameters
        ----------
        found
            What its application says of what it believes.
        """
        return found.warned & (found.margin_m <= -self.later_m)

    def as_plain(self) -> Mapping[str, Any]:
        """The settings as plain values; what differs between candidates is not among them."""
        own = {"bank", "sub_models", "start", "identify", "selector", "costs", "keep_samples", "references"}
        shared = {key: value for key, value in self.evaluation.as_plain().items() if key not in own}
        return {
            **shared,
            "application": repr(self.application),
            "bases": list(self.bases),
            "budget": self.budget,
            "against": self.against,
            "truth": self.truth,
            "near_m": self.near_m,
            "later_m": self.later_m,
            "merge_s": self.merge_s,
            "grace_s": self.grace_s,
            "resamples": self.resamples,
        }

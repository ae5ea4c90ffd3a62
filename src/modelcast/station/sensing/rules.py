"""Names of the velocity estimators, for options that must not import what they name."""

from typing import Literal

__all__ = ["VelocityRule"]

VelocityRule = Literal["auto", "reported", "slope-2", "quadratic-4"]
"""An estimator by name, or ``auto``: the one that `velocity_estimator_for` takes where nobody names one."""

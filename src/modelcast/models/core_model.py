"""Sub-models of what a core basic safety message carries: one sample, no tables, no payload."""

import abc
from typing import Any, ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Number, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions

__all__ = ["SPREAD_MPS2", "SPREAD_MPS3", "SPREAD_RADPS2", "AbstractCoreModel"]

SPREAD_MPS2 = Number(0.0, 100.0)
"""Unmodelled acceleration [m/s²]: up to ten times that of gravity, a crash."""

SPREAD_MPS3 = Number(0.0, 1000.0)
"""Unmodelled jerk [m/s³]: that acceleration within a tenth of a second."""

SPREAD_RADPS2 = Number(0.0, 100.0)
"""Unmodelled yaw acceleration [rad/s²]: a spin of ten radians a second within a tenth of a second."""


class AbstractCoreModel(AbstractSubModel):
    """A closed form of the newest sample: position, velocity, acceleration along the course, yaw rate.

    A core basic safety message carries all of them (SAE J2735: speed, heading, and ``accelSet`` with
    longitudinal acceleration and yaw rate), so none of these models adds a byte to it. Models are frozen
    dataclasses whose fields are checked by their rules.
    """

    short_name: ClassVar[str]
    """As in tables and on the command line."""
    numbers: ClassVar[tuple[str, ...]]
    """Names of its parameters."""
    functions: ClassVar[tuple[Any, Any]]
    """The compiled ``fit`` and ``predict`` of `PointFunctions`."""

    def __post_init__(self) -> None:
        check_fields(self)

    @abc.abstractmethod
    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Covariance of the displacement, (B, H, 2, 2) [m²], which knows no sampling interval.

        Parameters
        ----------
        parameters
            (B, P), as `fit` returned them.
        horizons_s
            Times after the last sample, (H,) [s].
        """

    @property
    def name(self) -> str:
        """Short name."""
        return self.short_name

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Its numbers."""
        return self.numbers

    @property
    def window(self) -> int:
        """One sample."""
        return 1

    @property
    def payload_parameters(self) -> int:
        """None: the core message has them all."""
        return 0

    @property
    def predicts_by_parameters(self) -> bool:
        """There are no tables."""
        return True

    def point_functions(self, dt_s: float) -> PointFunctions:  # noqa: ARG002 - no table depends on it
        """Return the compiled functions; there are no tables."""
        fit, predict = self.functions
        return PointFunctions(fit, predict, np.empty(0))

    def covariance(
        self,
        parameters: FloatArray,
        horizons_s: FloatArray,
        *,
        dt_s: float,  # noqa: ARG002 - no table depends on it
    ) -> FloatArray:
        """Predictive covariance of the displacement, (B, H, 2, 2) [m²]."""
        return self.spread_m2(parameters, horizons_s)

"""Constant velocity: what a receiver does with a raw basic safety message.

The velocity is the one that the trip's named causal estimator gives (`modelcast.station.sensing.velocity`);
sub-model and baseline share it.
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models import constant_velocity_kernels
from modelcast.models.core_model import SPREAD_MPS2, AbstractCoreModel

__all__ = ["ConstantVelocity"]


@dataclass(frozen=True, slots=True)
class ConstantVelocity(AbstractCoreModel):
    """Coast from the last position at the last velocity.

    Parameters
    ----------
    acceleration_spread_mps2
        Standard deviation of the unmodelled acceleration on each axis [m/s²], for the covariance: a
        displacement spread of ``½·a·t²``.

    Raises
    ------
    ValueError
        Where it is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> model = ConstantVelocity()
    >>> parameters = model.fit(Windows(np.array([[[0.0, 0.0, 10.0, -1.0, 0.0, 0.0, 0.0]]]), dt_s=0.1))
    >>> model.predict(parameters, np.array([0.5, 2.0]), dt_s=0.1)
    array([[[ 5. , -0.5],
            [20. , -2. ]]])
    """

    short_name: ClassVar[str] = "cv"
    numbers: ClassVar[tuple[str, ...]] = ("velocity_east_mps", "velocity_north_mps")
    functions: ClassVar[tuple[Any, Any]] = (constant_velocity_kernels.fit, constant_velocity_kernels.predict)
    acceleration_spread_mps2: Annotated[float, SPREAD_MPS2] = 1.0

    def spread_m2(self, parameters: FloatArray, horizons_s: FloatArray) -> FloatArray:
        """Spread of an unmodelled constant acceleration."""
        spread_m = 0.5 * self.acceleration_spread_mps2 * horizons_s**2
        one = spread_m[:, None, None] ** 2 * np.eye(2)
        return np.broadcast_to(one, (parameters.shape[0], *one.shape)).copy()

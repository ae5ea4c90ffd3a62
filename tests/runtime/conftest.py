"""A sub-model that reads context, and banks with it."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models import kinematic_kernels
from modelcast.models.bank import Bank
from modelcast.models.base import PointFunctions
from modelcast.models.context_columns import LEADER_ACCELERATION, LEADER_KNOWN, ROAD_KNOWN, ROAD_TURN
from modelcast.models.core_model import AbstractCoreModel


@kernel
def _fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """CTRA with the road's turn over the next second and the leader's acceleration, where they are known."""
    kinematic_kernels.fit_acceleration_and_turn(window, constants, out)
    at = int(constants[0])
    if at == 0:
        return
    if window[-1, at + ROAD_KNOWN] > 0.0:
        out[3] = window[-1, at + ROAD_TURN]
    if window[-1, at + LEADER_KNOWN] > 0.0:
        out[2] = window[-1, at + LEADER_ACCELERATION]


@dataclass(frozen=True, slots=True)
class Reader(AbstractCoreModel):
    """Goes on as the road and the leader tell."""

    short_name: ClassVar[str] = "reader"
    numbers: ClassVar[tuple[str, ...]] = (
        "velocity_east_mps",
        "velocity_north_mps",
        "acceleration_mps2",
        "yaw_rate_radps",
    )
    functions: ClassVar[tuple[Any, Any]] = (_fit, kinematic_kernels.predict_acceleration_and_turn)

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Constants hold the place of the context alone."""
        del dt_s
        fit, predict = self.functions
        return PointFunctions(fit, predict, np.zeros(1), context_at=0)

    def spread_m2(self, parameters: np.ndarray, horizons_s: np.ndarray) -> np.ndarray:
        """None: nobody asks."""
        return np.zeros((parameters.shape[0], horizons_s.size, 2, 2))


@pytest.fixture(scope="session")
def reader() -> Bank:
    """A bank of the one sub-model that reads context."""
    return Bank((Reader(),))

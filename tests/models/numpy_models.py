"""Sub-models in plain NumPy for tests: each says what one claim needs."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.base import Windows
from modelcast.models.context_columns import LEADER_GAP
from modelcast.models.numpy_model import AbstractNumpySubModel
from modelcast.models.payload import PayloadLayout
from modelcast.models.point_kernels import SAMPLE_COLUMNS

CALLS: list[int] = []
"""Rows of every call of `Coasting.fit_batch`."""


@dataclass(frozen=True, slots=True)
class Coasting(AbstractNumpySubModel):
    """Constant velocity once more; ``fault`` is what goes wrong."""

    fault: str = ""

    name = "coasting"
    window = 1
    parameter_names = ("velocity_east_mps", "velocity_north_mps")
    payload_layout = PayloadLayout()

    def fit_batch(self, windows: Windows) -> FloatArray:
        """Newest velocities."""
        CALLS.append(len(windows.samples))
        found = windows.velocities_mps[:, -1]
        if self.fault == "raises":
            raise ZeroDivisionError("nothing moves")
        if self.fault == "stops":
            raise KeyboardInterrupt("enough")
        if self.fault == "leaves":
            raise SystemExit(3)
        if self.fault == "nan":
            return np.where([True, False], found, np.nan)
        if self.fault == "shape":
            return found[:, :1]
        if self.fault == "text":
            return np.full(found.shape, "fast")
        if self.fault == "rows":
            return found - found.mean(axis=0)
        return found

    def predict_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:  # noqa: ARG002
        """Straight on."""
        found = parameters[:, None, :] * horizons_s[:, None]
        return found / 0.0 if self.fault == "infinite" else found

    def covariance_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """That of constant velocity, more where vehicles of the batch are fast."""
        found = super(Coasting, self).covariance_batch(parameters, horizons_s, dt_s=dt_s)
        return found * (1.0 + parameters.max() ** 2) if self.fault == "spread" else found


@dataclass(frozen=True, slots=True)
class Smoothed(AbstractNumpySubModel):
    """Coast at a velocity that follows the measured one slowly; with no share, the batch's mean less."""

    share: float = 0.2

    name = "smoothed"
    window = 2
    parameter_names = ("smooth_east_mps", "smooth_north_mps")
    state_columns = 2

    def observe_batch(self, states: FloatArray | None, samples: FloatArray, *, dt_s: float) -> FloatArray:  # noqa: ARG002
        """Follow."""
        measured = samples[:, 2:4]
        if np.isnan(self.share):
            return measured - measured.mean(axis=0)
        return measured if states is None else states + self.share * (measured - states)

    def fit_batch(self, windows: Windows) -> FloatArray:
        """The state itself."""
        assert windows.samples.shape[1:] == (self.window, SAMPLE_COLUMNS)
        assert windows.states is not None
        return windows.states

    def predict_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:  # noqa: ARG002
        """Straight on."""
        return parameters[:, None, :] * horizons_s[:, None]


@dataclass(frozen=True, slots=True)
class Following(AbstractNumpySubModel):
    """Hold the gap to the vehicle ahead as the only parameter."""

    name = "following"
    window = 1
    parameter_names = ("gap_m",)
    reads_context = True

    def fit_batch(self, windows: Windows) -> FloatArray:
        """The gap; -1 where no context is there at all."""
        if windows.samples.shape[2] == SAMPLE_COLUMNS:
            return np.full((len(windows.samples), 1), -1.0)
        return windows.samples[:, -1, SAMPLE_COLUMNS + LEADER_GAP, None]

    def predict_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:  # noqa: ARG002
        """Stay."""
        return np.zeros((len(parameters), horizons_s.size, 2))

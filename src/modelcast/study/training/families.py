"""Families of sub-models that differ by a vector of hyper-parameters: what a search may try."""

import abc
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.base import AbstractSubModel
from modelcast.models.gp.conditional import AxisKernel, log_likelihood
from modelcast.models.gp.gaussian_process import GaussianProcess, Hyperparameters
from modelcast.models.gp.time_grid import TimeGrid
from modelcast.models.gp.vehicle import VehicleProcess, measured, noise_level, noise_levels_m
from modelcast.study.training.windows import TrainingWindows

__all__ = ["AbstractFamily", "FixedFamily", "VehicleFamily"]


class AbstractFamily(abc.ABC):
    """Sub-models that differ by a vector of hyper-parameters, in logarithms."""

    @abc.abstractmethod
    def renamed(self, label: str) -> "AbstractFamily":
        """Return the same family with another name for its sub-models."""

    @property
    @abc.abstractmethod
    def start(self) -> FloatArray:
        """Where a search starts, (D,)."""

    @property
    @abc.abstractmethod
    def bounds(self) -> list[tuple[float, float]]:
        """Least and greatest value of each, D pairs."""

    @abc.abstractmethod
    def build(self, theta: FloatArray) -> AbstractSubModel:
        """Return the sub-model with these hyper-parameters, (D,)."""

    @abc.abstractmethod
    def log_likelihood(self, theta: FloatArray, training: TrainingWindows) -> float:
        """Mean logarithm of the likelihood of a window and axis."""


@dataclass(frozen=True, slots=True)
class VehicleFamily(AbstractFamily):
    """Processes in the vehicle's frame: lengthscale and deviation of both axes, and their velocity noise.

    Parameters
    ----------
    model
        Everything else, and where the search starts.
    """

    model: VehicleProcess

    def renamed(self, label: str) -> "VehicleFamily":
        """Return the same family with another name for its sub-models."""
        return replace(self, model=replace(self.model, label=label))

    @property
    def start(self) -> FloatArray:
        """The model's own."""
        axes = (self.model.along, self.model.across)
        values = [value for axis in axes for value in (axis.lengthscale_s, axis.deviation_m)]
        if self.model.velocities:
            values += [axis.velocity_noise_mps for axis in axes]
        return np.log(values)

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """0.5 to 20 s, 0.1 m to 1 km, 5 mm/s to 5 m/s."""
        axis = [(np.log(0.5), np.log(20.0)), (np.log(0.1), np.log(1000.0))]
        return axis * 2 + [(np.log(0.005), np.log(5.0))] * (2 * self.model.velocities)

    def build(self, theta: FloatArray) -> VehicleProcess:
        """Return the process with these hyper-parameters."""
        value = np.exp(theta)
        along = replace(self.model.along, lengthscale_s=float(value[0]), deviation_m=float(value[1]))
        across = replace(self.model.across, lengthscale_s=float(value[2]), deviation_m=float(value[3]))
        if self.model.velocities:
            along = replace(along, velocity_noise_mps=float(value[4]))
            across = replace(across, velocity_noise_mps=float(value[5]))
        return replace(self.model, along=along, across=across)

    def log_likelihood(self, theta: FloatArray, training: TrainingWindows) -> float:
        """By the noise level that each window would be fitted with."""
        model = self.build(theta)
        times_s = TimeGrid(model.samples, training.dt_s).times_s
        turned = measured(training.samples[:, -model.samples :], velocities=model.velocities)
        level = noise_level(training.samples[:, -1, -1])
        total = 0.0
        for which in np.unique(level):
            rows = level == which
            noise_m = float(noise_levels_m()[which])
            for axis, kernel in enumerate((model.along, model.across)):
                found = log_likelihood(kernel, times_s, turned[rows, axis], position_noise_m=noise_m)
                total += float(found.sum())
        return total / (2 * len(training))


@dataclass(frozen=True, slots=True)
class FixedFamily(AbstractFamily):
    """Linear plus RBF on east and north with hyper-parameters common to all windows: `GaussianProcess`.

    Parameters
    ----------
    model
        Of the form "intercept"; everything but its hyper-parameters.

    Raises
    ------
    ValueError
        Where the form is another.
    """

    model: GaussianProcess

    def __post_init__(self) -> None:
        if self.model.form != "intercept":
            raise ValueError(f"model must be of the form 'intercept', got {self.model.form!r}")

    def renamed(self, label: str) -> "FixedFamily":
        """Return the same family with another name for its sub-models."""
        return replace(self, model=replace(self.model, label=label))

    @property
    def start(self) -> FloatArray:
        """2 s, 10 m, 1 mm, 15 m/s."""
        return np.log([2.0, 10.0, 0.001, 15.0])

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Of lengthscale, deviation, noise and slope."""
        pairs = ((0.3, 10.0), (0.1, 1000.0), (1e-4, 1.0), (0.1, 100.0))
        return [(float(np.log(low)), float(np.log(high))) for low, high in pairs]

    def build(self, theta: FloatArray) -> GaussianProcess:
        """Return the process with these hyper-parameters."""
        lengthscale_s, deviation_m, noise_m, slope_mps = (float(value) for value in np.exp(theta))
        variance_m2 = deviation_m**2
        found = Hyperparameters(
            lengthscale_s,
            noise_m**2 / variance_m2,
            linear_ratio_per_s2=slope_mps**2 / variance_m2,
            variance_m2=variance_m2,
        )
        return replace(self.model, hyperparameters=found)

    def log_likelihood(self, theta: FloatArray, training: TrainingWindows) -> float:
        """With one noise for all windows."""
        lengthscale_s, deviation_m, noise_m, slope_mps = (float(value) for value in np.exp(theta))
        kernel = AxisKernel(lengthscale_s, deviation_m, slope_deviation_mps=slope_mps)
        times_s = TimeGrid(self.model.samples, training.dt_s).times_s
        position_m = training.samples[:, -self.model.samples :, :2]
        moved_m = position_m - position_m[:, -1:]
        both = np.concatenate([moved_m[..., 0], moved_m[..., 1]])
        return float(log_likelihood(kernel, times_s, both, position_noise_m=noise_m).mean())

"""Processes with hyper-parameters learned from real trips, ready to be used by name.

All were trained by predictive survival (`modelcast.evaluation.training.hyperparameters`) on the five OpenACC
development files, 5,000 windows drawn with seed 0, on 2026-11-24: `trained_process` on positions as recorded,
the others on recorded positions, with 1 cm and with 5 cm of noise together.
"""

from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.gaussian_process import GaussianProcess, Hyperparameters
from modelcast.models.gp.vehicle import VehicleProcess

__all__ = ["derivative_process", "trained_process", "vehicle_process"]

_STRAIGHT_AFTER_S = 2.5
_DEGREE = 3


def trained_process(samples: int = 10) -> GaussianProcess:
    """Linear plus RBF on east and north with fixed hyper-parameters, ``gp-trained``; for clean positions.

    Parameters
    ----------
    samples
        Window length n; 10 in training.
    """
    found = Hyperparameters(10.0, 5.2e-10, linear_ratio_per_s2=5.2, variance_m2=136.0)
    return GaussianProcess(samples, "intercept", hyperparameters=found)


def vehicle_process(samples: int = 10) -> VehicleProcess:
    """Positions along and across the course, ``gp-vehicle``.

    Parameters
    ----------
    samples
        Window length n; 10 in training.
    """
    return VehicleProcess(
        "gp-vehicle",
        AxisKernel(4.1, 5.12),
        across=AxisKernel(20.0, 435.0),
        samples=samples,
        degree=_DEGREE,
        straight_after_s=_STRAIGHT_AFTER_S,
    )


def derivative_process(samples: int = 10) -> VehicleProcess:
    """Positions and velocities along and across the course, ``gp-derivative``.

    Parameters
    ----------
    samples
        Window length n; 10 in training.
    """
    return VehicleProcess(
        "gp-derivative",
        AxisKernel(4.09, 5.82, velocity_noise_mps=0.256),
        across=AxisKernel(8.72, 16.2, velocity_noise_mps=0.0213),
        samples=samples,
        velocities=True,
        degree=_DEGREE,
        straight_after_s=_STRAIGHT_AFTER_S,
    )

"""Exact Gaussian processes on equally spaced windows.

`GaussianProcess` fits position on east and north against time, `VehicleProcess` along and across the course,
with given hyper-parameters; `linear_process` is the latter with a line alone, `vehicle_process` and
`derivative_process` are where a search for hyper-parameters starts. `fit_axis` gives the hyper-parameters and
likelihoods of one axis.
"""

from modelcast.models.gp.axis_fit import AxisFits, fit_axis
from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.gaussian_process import GaussianProcess, Hyperparameters
from modelcast.models.gp.untrained import derivative_process, vehicle_process
from modelcast.models.gp.vehicle import VehicleProcess, linear_process

__all__ = [
    "AxisFits",
    "AxisKernel",
    "GaussianProcess",
    "Hyperparameters",
    "VehicleProcess",
    "derivative_process",
    "fit_axis",
    "linear_process",
    "vehicle_process",
]

"""Exact Gaussian processes on equally spaced windows.

`GaussianProcess` fits position on east and north against time, `VehicleProcess` along and across the course,
with given hyper-parameters; `linear_process` is the latter with a line alone, `vehicle_process` and
`derivative_process` are where a search for hyper-parameters starts. `fit_axis` gives the hyper-parameters and
likelihoods of one axis. `KernelProcess` takes any kernel of `modelcast.models.gp.kernels`, `fit_kernel` fits
one on one axis, and `process_of` chooses between it and a closed form.
"""

from modelcast.models.gp.axis_fit import AxisFits, fit_axis
from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.expression import KernelProcess, process_of
from modelcast.models.gp.expression_fit import KernelFits, fit_kernel, likelihood_of_kernel
from modelcast.models.gp.gaussian_process import GaussianProcess, Hyperparameters
from modelcast.models.gp.untrained import derivative_process, vehicle_process
from modelcast.models.gp.vehicle import VehicleProcess, linear_process

__all__ = [
    "AxisFits",
    "AxisKernel",
    "GaussianProcess",
    "Hyperparameters",
    "KernelFits",
    "KernelProcess",
    "VehicleProcess",
    "derivative_process",
    "fit_axis",
    "fit_kernel",
    "likelihood_of_kernel",
    "linear_process",
    "process_of",
    "vehicle_process",
]

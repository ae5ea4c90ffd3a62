"""Exact Gaussian processes on equally spaced windows.

`GaussianProcess` is the motion model; `fit_axis` gives the hyper-parameters and likelihoods of one axis.
"""

from modelcast.models.gp.axis_fit import AxisFits, fit_axis
from modelcast.models.gp.gaussian_process import GaussianProcess, Hyperparameters

__all__ = ["AxisFits", "GaussianProcess", "Hyperparameters", "fit_axis"]

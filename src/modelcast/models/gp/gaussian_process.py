"""The Gaussian-process motion model: linear plus RBF kernel on each axis, fitted exactly at every window."""

import functools
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Literal, get_args

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Maybe, Number, One, Text, Whole, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions
from modelcast.models.gp import gaussian_process_kernels as kernels
from modelcast.models.gp.covariance import predictive_variance_m2, projection
from modelcast.models.gp.tables import Bounds, Form, pack
from modelcast.models.gp.time_grid import WINDOW_BOUNDS, TimeGrid

__all__ = ["GaussianProcess", "Hyperparameters"]

_AXES = ("east", "north")

Noise = Literal["floor", "estimated"]


NOISE_FLOOR_BOUNDS_M = (1e-6, 1.0)
"""Bounds of the floor of the white noise's standard deviation, the upper one outside [m]."""


@dataclass(frozen=True, slots=True)
class Hyperparameters:
    """Hyper-parameters of one Gaussian process, shared by both axes.

    Parameters
    ----------
    lengthscale_s
        Lengthscale of the RBF part [s].
    noise_ratio
        White noise variance relative to the RBF part's variance.
    linear_ratio_per_s2
        Variance of the slope relative to the RBF part's variance, 0 for no linear part [1/s²].
    variance_m2
        Variance of the RBF part [m²]; only the covariance depends on it.

    Raises
    ------
    ValueError
        Where one is out of its range: those of the search and of training, with room to spare.
    """

    lengthscale_s: Annotated[float, Number(0.05, 1000.0)]
    noise_ratio: Annotated[float, Number(1e-15, 1e9)]
    _: KW_ONLY
    linear_ratio_per_s2: Annotated[float, Number(0.0, 1e10)]
    variance_m2: Annotated[float, Number(1e-15, 1e9)] = 1.0

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class GaussianProcess(AbstractSubModel):
    """Gaussian process on position against time with a linear, an RBF and a white-noise part.

    Parameters
    ----------
    samples
        Window length n, 3 to 60.
    form
        "anchored": each axis on its own, the line passes through the last sample (the paper's form).
        "intercept": a flat prior on a constant, and both axes share their hyper-parameters, so that the fit
        does not depend on the frame's orientation.
    noise_floor_m
        Least standard deviation of the white noise [m].
    hyperparameters
        Fixed hyper-parameters, or None to maximise the likelihood of every window.
    noise
        "floor": the floor is the same for every window. "estimated": it is the window's own position noise
        where that is greater; form "intercept" without fixed hyper-parameters only.
    label
        Name of the sub-model; empty for ``gp-trained`` with fixed hyper-parameters, ``gp-adaptive`` with
        estimated noise, else ``gp-`` and the form.

    Raises
    ------
    ValueError
        Where a field is outside its bounds.

    Notes
    -----
    The payload holds for every sample j its share of the displacement at horizon 0, ``weight_j``: the dual
    coefficient times ``k(0, t_j)``. At horizon h the share is
    ``exp(-h²/2l²)·exp(-h·dt/l²)^(n-1-j)·weight_j``, so that the sum is a polynomial in one number.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> t = np.arange(-9, 1) * 0.1
    >>> velocity = [10 * np.cos(t), -10 * np.sin(t)]
    >>> turn = np.stack([10 * np.sin(t), 10 * np.cos(t), *velocity, 0 * t, 1 + 0 * t, 0 * t], axis=1)
    >>> model = GaussianProcess(form="intercept")
    >>> parameters = model.fit(Windows(turn[None], dt_s=0.1))
    >>> model.predict(parameters, np.array([0.5]), dt_s=0.1).round(1)
    array([[[ 4.8, -1.2]]])
    """

    samples: Annotated[int, Whole(*WINDOW_BOUNDS)] = 10
    form: Annotated[Form, Text(choices=get_args(Form))] = "anchored"
    _: KW_ONLY
    noise_floor_m: Annotated[float, Number(*NOISE_FLOOR_BOUNDS_M, under=True)] = 0.001
    hyperparameters: Annotated[Hyperparameters | None, Maybe(One((Hyperparameters,), "hyper-parameters"))] = (
        None
    )
    noise: Annotated[Noise, Text(choices=get_args(Noise))] = "floor"
    label: Annotated[str, Text(64, empty=True)] = ""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.noise == "estimated" and (self.form != "intercept" or self.hyperparameters is not None):
            raise ValueError(
                "noise = 'estimated' needs form 'intercept' and no fixed hyperparameters, "
                f"got {self.form!r} and {self.hyperparameters}"
            )

    @property
    def name(self) -> str:
        """The label, or a name by what the process does."""
        if self.label:
            return self.label
        if self.hyperparameters is not None:
            return "gp-trained"
        return "gp-adaptive" if self.noise == "estimated" else f"gp-{self.form}"

    @property
    def window(self) -> int:
        """Window length n."""
        return self.samples

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Line, lengthscale, weights; then what only the covariance needs.

        With fixed hyper-parameters only line and weights: the receiver has the rest.
        """
        line = [f"slope_{axis}_mps" for axis in _AXES]
        if self.form == "intercept":
            line = [*(f"intercept_{axis}_m" for axis in _AXES), *line]
        weights = [f"weight_{j}_{axis}_m" for axis in _AXES for j in range(self.samples)]
        if self.hyperparameters is not None:
            return (*line, *weights)
        ends = [""] if self.form == "intercept" else [f"_{axis}" for axis in _AXES]
        lengthscales = [f"lengthscale{end}_s" for end in ends]
        tail = [
            name
            for pattern in ("variance{}_m2", "noise_ratio{}", "linear_ratio{}_per_s2", "floored{}")
            for name in (pattern.format(end) for end in ends)
        ]
        return (*line, *lengthscales, *weights, *tail)

    @property
    def payload_parameters(self) -> int:
        """All."""
        return len(self.parameter_names)

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and tables; the interval counts to the microsecond."""
        return _point_functions(self, round(dt_s, 6))

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Covariance of the noise-free position, given the window, relative to its last sample as measured.

        A new *measurement* adds the white noise, ``noise_ratio·variance_m2`` on each axis. The last sample's
        own noise does not enter: it is the origin of the displacement, known to both sides.
        """
        variances = np.empty((parameters.shape[0], horizons_s.size, 2))
        for axis in range(2):
            lengthscale, noise, linear, variance = self._hyperparameters(parameters, axis)
            variances[:, :, axis] = predictive_variance_m2(
                TimeGrid(self.samples, round(dt_s, 6)),
                self.form,
                np.asarray(horizons_s, dtype=np.float64),
                lengthscales_s=lengthscale,
                noise_ratios=noise,
                linear_ratios_per_s2=linear,
                variances_m2=variance,
            )
        return variances[..., None] * np.eye(2)

    def _hyperparameters(
        self, parameters: FloatArray, axis: int
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        fixed = self.hyperparameters
        if fixed is not None:
            values = (fixed.lengthscale_s, fixed.noise_ratio, fixed.linear_ratio_per_s2, fixed.variance_m2)
            one, two, three, four = (np.full(parameters.shape[0], value) for value in values)
            return one, two, three, four
        names = self.parameter_names
        end = "" if self.form == "intercept" else f"_{_AXES[axis]}"
        wanted = (
            f"lengthscale{end}_s",
            f"noise_ratio{end}",
            f"linear_ratio{end}_per_s2",
            f"variance{end}_m2",
        )
        one, two, three, four = (parameters[:, names.index(name)] for name in wanted)
        return one, two, three, four


@functools.lru_cache(maxsize=32)
def _point_functions(model: GaussianProcess, dt_s: float) -> PointFunctions:
    fixed = model.hyperparameters
    if fixed is not None:
        flat = float(model.form == "intercept")
        matrices = projection(
            TimeGrid(model.samples, dt_s),
            model.form,
            lengthscale_s=fixed.lengthscale_s,
            noise_ratio=fixed.noise_ratio,
            linear_ratio_per_s2=fixed.linear_ratio_per_s2,
        )
        header = np.array([model.samples, dt_s, fixed.lengthscale_s, flat])
        return PointFunctions(
            kernels.fit_fixed,
            kernels.predict_fixed,
            np.concatenate([header, *(matrix.ravel() for matrix in matrices)]),
        )
    constants = pack(TimeGrid(model.samples, dt_s), model.form, Bounds(model.noise_floor_m))
    if model.noise == "estimated":
        return PointFunctions(kernels.fit_adaptive, kernels.predict_intercept, constants)
    if model.form == "intercept":
        return PointFunctions(kernels.fit_intercept, kernels.predict_intercept, constants)
    return PointFunctions(kernels.fit_anchored, kernels.predict_anchored, constants)

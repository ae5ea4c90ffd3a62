"""The sub-model of any kernel: a Gaussian process an axis, fitted exactly at every window."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import FieldError, Number, Text, Whole, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions
from modelcast.models.gp import expression_kernels
from modelcast.models.gp.expression_tables import pack_expression
from modelcast.models.gp.gaussian_process import NOISE_FLOOR_BOUNDS_M, GaussianProcess
from modelcast.models.gp.kernels import AbstractKernel, Linear, Rbf, kernel_from_text
from modelcast.models.gp.kernels.base import Sum
from modelcast.models.gp.kernels.text import MOST_CHARACTERS
from modelcast.models.gp.time_grid import WINDOW_BOUNDS, TimeGrid

__all__ = ["KernelProcess", "process_of"]

_AXES = ("east", "north")


@dataclass(frozen=True, slots=True)
class KernelProcess(AbstractSubModel):
    """Gaussian process on position against time with any kernel and white noise, each axis on its own.

    Parameters
    ----------
    expression
        The kernel, as `modelcast.models.gp.kernels.kernel_from_text` reads it; kept in its canonical form.
    samples
        Window length n, 3 to 60.
    noise_floor_m
        Least standard deviation of the white noise [m].

    Raises
    ------
    ValueError
        Where a field is outside its bounds, or the expression is no kernel.

    Notes
    -----
    Positions are relative to the window's last sample, and time counts from it. The hyper-parameters of an
    axis maximise the likelihood of its window (Rasmussen and Williams 2006, equation 5.8) within their
    bounds, as far as a search from the best of many starts finds; the displacement at horizon h is
    ``sum_j k(h, t_j)·alpha_j`` with ``alpha = (K + noise·I)⁻¹·y``.

    `process_of` takes `GaussianProcess` where that is the same process, which is faster.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.models.base import Windows
    >>> t = np.arange(-9, 1) * 0.1
    >>> turn = np.stack([10 * np.sin(t), 10 * np.cos(t), *np.zeros((5, 10))], axis=1)
    >>> model = KernelProcess("linear + rq")
    >>> model.name
    'gp(linear+rq)'
    >>> parameters = model.fit(Windows(turn[None], dt_s=0.1))
    >>> model.predict(parameters, np.array([0.5]), dt_s=0.1).round(1)
    array([[[ 4.8, -1.2]]])
    """

    expression: Annotated[str, Text(MOST_CHARACTERS)]
    samples: Annotated[int, Whole(*WINDOW_BOUNDS)] = 10
    noise_floor_m: Annotated[float, Number(*NOISE_FLOOR_BOUNDS_M, under=True)] = 0.001

    def __post_init__(self) -> None:
        check_fields(self)
        try:
            canonical = str(kernel_from_text(self.expression))
        except ValueError as error:
            raise FieldError("expression", self.expression, f"a kernel ({error})") from None
        object.__setattr__(self, "expression", canonical)

    @property
    def kernel(self) -> AbstractKernel:
        """The kernel; its own hyper-parameters count for nothing."""
        return kernel_from_text(self.expression)

    @property
    def name(self) -> str:
        """The canonical expression."""
        return f"gp({self.expression})"

    @property
    def window(self) -> int:
        """Window length n."""
        return self.samples

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of each axis the hyper-parameters, the white noise's variance and the dual coefficients."""
        own = [one.name for one in self.kernel.hyperparameters]
        weights = [f"weight_{j}_per_m" for j in range(self.samples)]
        return tuple(f"{axis}_{name}" for axis in _AXES for name in (*own, "noise_variance_m2", *weights))

    @property
    def payload_parameters(self) -> int:
        """All."""
        return len(self.parameter_names)

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and tables; the interval counts to the microsecond."""
        constants = pack_expression(
            self.expression, TimeGrid(self.samples, round(dt_s, 6)), self.noise_floor_m
        )
        return PointFunctions(expression_kernels.fit, expression_kernels.predict, constants)

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Covariance of the noise-free position, given the window, relative to its last sample as measured.

        A new *measurement* adds the white noise. A periodic kernel knows a whole period ahead as much as now:
        its covariance need not grow.
        """
        kernel = self.kernel
        times_s = TimeGrid(self.samples, round(dt_s, 6)).times_s
        horizons_s = np.asarray(horizons_s, dtype=np.float64)
        count = len(kernel.hyperparameters)
        variances = np.empty((parameters.shape[0], horizons_s.size, 2))
        for axis in range(2):
            first = axis * (count + 1 + self.samples)
            values = parameters[:, None, None, first : first + count]
            noise = parameters[:, first + count, None]
            # Rounding may put eigenvalues below the noise, which is the least that they can be.
            found, basis = np.linalg.eigh(kernel.at(values, times_s[:, None], times_s))
            cross = basis.swapaxes(1, 2) @ kernel.at(values, times_s[:, None], horizons_s)
            known = (cross**2 / (np.maximum(found, 0.0) + noise)[:, :, None]).sum(axis=1)
            prior = kernel.at(values[:, 0], horizons_s, horizons_s)
            variances[:, :, axis] = np.maximum(prior - known, 0.0)
        return variances[..., None] * np.eye(2)


def process_of(
    text: str, samples: int = 10, *, noise_floor_m: float | None = None, closed_floor_m: float = 0.001
) -> KernelProcess | GaussianProcess:
    """The sub-model of a kernel's expression: in closed form where there is one.

    Parameters
    ----------
    text
        The expression.
    samples
        Window length n.
    noise_floor_m
        Least standard deviation of the white noise [m]; where None, the sub-model's own.
    closed_floor_m
        What that is for the closed form, ``linear+rbf`` [m].

    Raises
    ------
    ValueError
        Where it is no kernel, or a value is out of range.

    Examples
    --------
    >>> process_of("rbf + linear").form, process_of("linear").name
    ('anchored', 'gp(linear)')
    """
    general = KernelProcess(text, samples)
    kernel = general.kernel
    if isinstance(kernel, Sum) and kernel.parts in ((Linear(), Rbf()), (Rbf(), Linear())):
        floor_m = closed_floor_m if noise_floor_m is None else noise_floor_m
        return GaussianProcess(samples, "anchored", noise_floor_m=floor_m, label=general.name)
    return general if noise_floor_m is None else KernelProcess(text, samples, noise_floor_m)

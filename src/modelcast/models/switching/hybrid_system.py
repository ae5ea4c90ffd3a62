"""A stochastic hybrid system: linear modes of acceleration and yaw rate, switched by a hidden Markov chain.

The chain's mode is not seen. The sender follows the chance of each mode sample by sample, by the forward
filter of a hidden Markov model; it is state that `observe` carries from sample to sample. Sender and
receiver hold the modes and the chain in the profile that a message names, so the message says no more than
Part I does already and how likely each mode is.

References
----------
J. Hu, J. Lygeros, S. Sastry, "Towards a Theory of Stochastic Hybrid Systems", HSCC 2000, LNCS 1790.
https://doi.org/10.1007/3-540-46430-1_16
E. B. Fox, E. B. Sudderth, M. I. Jordan, A. S. Willsky, "Bayesian Nonparametric Inference of Switching Dynamic
Linear Models", IEEE Transactions on Signal Processing 59(4), 2011. https://doi.org/10.1109/TSP.2010.2102756
L. R. Rabiner, "A Tutorial on Hidden Markov Models", Proceedings of the IEEE 77(2), 1989, section III.
https://doi.org/10.1109/5.18626
"""

import functools
from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Each, FieldError, Number, One, Text, Whole, check_fields
from modelcast.models.base import AbstractSubModel, PointFunctions, Stream
from modelcast.models.kinematic import along_course
from modelcast.models.payload import CORE_PARAMETERS, PayloadField, PayloadLayout
from modelcast.models.switching import switching_kernels as kernels
from modelcast.models.switching.mode import LinearMode, ModeArrays, advanced, as_arrays
from modelcast.models.switching.moments import mean_tables, second_moments, stationary

__all__ = ["MOST_MODES", "REACH_S", "StochasticHybridSystem"]

MOST_MODES = 10
"""Modes at most."""

REACH_S = 10.0
"""Horizon up to which the mean is followed [s]; beyond it the car goes straight on."""

_ROUNDING = 1e-6
_DECIMALS = 3
"""Of a sampling interval in steps: what differs by less is one interval, with one set of tables."""
_LARGEST_MEAN = 1e4
_LARGEST_MOMENT = 1e12
"""Of an entry of the moments: a mean of 10⁴ adds up to 5·10⁵ in 10 s, whose square is below."""
_MODES = Each(One((LinearMode,), "a linear mode"), 1, MOST_MODES)
_CHANCES = Each(Each(Number(0.0, 1.0), 1, MOST_MODES), 1, MOST_MODES)


@dataclass(frozen=True, slots=True)
class StochasticHybridSystem(AbstractSubModel):
    """Follow the mean of all modes, each as likely as the forward filter holds it.

    Parameters
    ----------
    label
        Its name: ``shs`` where the number of modes was given, ``hdp-hmm`` where it was found.
    modes
        M of them.
    transition
        Chances of the chain over one step, M rows from, M columns to; each row sums to one.
    step_s
        The step that modes and chain are of, from 0.05 to 1 [s]; a prediction holds the moments of every one.
    belief_bits
        Width of the field that a message carries the chance of a mode in; the last mode has what the others
        leave.

    Raises
    ------
    ValueError
        Where a field is outside its bounds, the chain does not fit the modes or a row of it does not sum to
        one, or acceleration or yaw rate run away within `REACH_S`, in the mean or in the mean square.

    Notes
    -----
    With x the acceleration along the course and the yaw rate, and z the mode:

    - ``z_k ~ P[z_{k-1}]`` and ``x_k = A_z x_{k-1} + b_z + w``, ``w ~ N(0, Q_z)``;
    - filter: ``belief_k(j) ∝ N(x_k; A_j x_{k-1} + b_j, Q_j) Σ_i belief_{k-1}(i) P_ij``, from the chain's
      stationary shares at a start and after a gap;
    - prediction: the exact mean of x (`moments`), linear between steps. Speed and heading integrate it, and
      the position them; a stop is final. It is the path of the mean, not the mean of all paths.

    At another sampling interval the filter takes modes and chain of as many steps (`mode.advanced`); the
    prediction has the model's own step.

    The covariance is that of the twice integrated acceleration along the course and, times the speed, of the
    twice integrated yaw rate across it: exact second moments, for a small change of speed and heading.

    Examples
    --------
    A car that brakes, either hard for long or not for long:

    >>> from modelcast.models.base import Windows
    >>> held = LinearMode(((1.0, 0.0), (0.0, 1.0)), (0.0, 0.0), ((0.01, 0.0), (0.0, 0.0001)))
    >>> fades = LinearMode(((0.8, 0.0), (0.0, 0.8)), (0.0, 0.0), ((0.01, 0.0), (0.0, 0.0001)))
    >>> model = StochasticHybridSystem("example", (held, fades), ((0.99, 0.01), (0.01, 0.99)))
    >>> along = np.array([-2.0, -2.0, -2.0, -2.0])
    >>> window = np.zeros((1, 4, 7))
    >>> window[0, :, 2], window[0, :, 4] = 10.0, along
    >>> parameters = model.fit(Windows(window, dt_s=0.1))
    >>> parameters.round(2).tolist()
    [[10.0, 0.0, -2.0, 0.0, 1.0]]
    >>> model.predict(parameters, np.array([1.0]), dt_s=0.1).round(1)
    array([[[9., 0.]]])
    """

    label: Annotated[str, Text(64)]
    modes: Annotated[tuple[LinearMode, ...], _MODES]
    transition: Annotated[tuple[tuple[float, ...], ...], _CHANCES]
    _: KW_ONLY
    step_s: Annotated[float, Number(0.05, 1.0)] = 0.1
    belief_bits: Annotated[int, Whole(1, 16)] = 4

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "modes", tuple(self.modes))
        object.__setattr__(self, "transition", tuple(tuple(row) for row in self.transition))
        count = len(self.modes)
        if len(self.transition) != count or any(len(row) != count for row in self.transition):
            raise FieldError(
                "transition", self.transition, f"{count} rows of {count} chances, as many as modes"
            )
        for at, row in enumerate(self.transition):
            if not abs(sum(row) - 1.0) < _ROUNDING:
                raise FieldError(f"transition[{at}]", row, "chances that sum to one")
        if not _is_bounded(self):
            raise FieldError("modes", self.modes, f"modes that do not run away within {REACH_S:g} s together")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    @property
    def window(self) -> int:
        """One sample: what was before it is in the belief."""
        return 1

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """What Part I carries, then the chance of each mode but the last."""
        return (*CORE_PARAMETERS, *self._belief_names)

    @property
    def payload_parameters(self) -> int:
        """The chances."""
        return len(self.modes) - 1

    @property
    def payload_layout(self) -> PayloadLayout:
        """The chances, from 0 to 1 in equal steps."""
        step = 1.0 / (2**self.belief_bits - 1)
        return PayloadLayout(
            tuple(
                PayloadField(name, step, bits=self.belief_bits, signed=False) for name in self._belief_names
            )
        )

    @property
    def _belief_names(self) -> tuple[str, ...]:
        return tuple(f"chance_{mode}" for mode in range(len(self.modes) - 1))

    @property
    def arrays(self) -> ModeArrays:
        """Modes and chain over one step."""
        return as_arrays(self.modes, self.transition)

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the filter and the prediction, made once for an interval.

        Raises
        ------
        ValueError
            Where the interval is under a thousandth of a step or over `REACH_S`.
        """
        shortest_s = self.step_s * 10.0**-_DECIMALS
        if not shortest_s * (1.0 - _ROUNDING) <= dt_s <= REACH_S:
            raise ValueError(f"{self.name}: dt_s must be from {shortest_s:g} to {REACH_S:g} s, got {dt_s:g}")
        constants = _constants(self, round(dt_s / self.step_s, _DECIMALS))
        stream = Stream(kernels.observe, columns=len(self.modes), at=kernels.AT_COLUMN)
        return PointFunctions(kernels.fit, kernels.predict, constants, stream=stream)

    def covariance(
        self,
        parameters: FloatArray,
        horizons_s: FloatArray,
        *,
        dt_s: float,  # noqa: ARG002 - the model's own step counts
    ) -> FloatArray:
        """Exact spread of what acceleration and yaw rate add up to, (B, H, 2, 2) [m²]."""
        parameters = self.checked(parameters)
        horizons_s = np.asarray(horizons_s, dtype=np.float64)
        within_s = np.minimum(horizons_s, REACH_S)
        steps = int(np.ceil(within_s.max(initial=0.0) / self.step_s)) + 1
        first = parameters[:, 4:]
        belief = np.column_stack([first, np.maximum(1.0 - first.sum(axis=1), 0.0)])
        belief /= belief.sum(axis=1, keepdims=True)
        moments = second_moments(self.arrays, belief, parameters[:, 2:4], steps=steps, step_s=self.step_s)
        mean = moments[..., 0, :]
        spread = moments - mean[..., :, None] * mean[..., None, :]
        at = np.minimum((within_s / self.step_s).astype(np.int64), steps - 1)
        share = within_s / self.step_s - at
        between = spread[:, at] + share[:, None, None] * (spread[:, at + 1] - spread[:, at])
        turned_rad = mean[:, at, 4] + share * (mean[:, at + 1, 4] - mean[:, at, 4])
        later_s = horizons_s - within_s
        along_m, across = (_spread(between, once, later_s) for once in (3, 4))
        speed_mps = np.hypot(parameters[:, 0], parameters[:, 1])[:, None]
        return along_course(parameters[:, :2], turned_rad, along_m, speed_mps * across)


def _spread(covariance: FloatArray, once: int, later_s: FloatArray) -> FloatArray:
    """Standard deviation of an integral's integral, carried on straight for some time, (B, H).

    ``covariance`` (B, H, SIZE, SIZE) holds the integral at ``once`` and its integral two places on.
    """
    twice = once + 2
    straight = 2.0 * later_s * covariance[..., twice, once] + later_s**2 * covariance[..., once, once]
    return np.sqrt(np.maximum(covariance[..., twice, twice] + straight, 0.0))


def _is_bounded(model: StochasticHybridSystem) -> bool:
    """Whether first and second moments stay small from every mode, at rates of zero and of one."""
    count = len(model.modes)
    belief = np.repeat(np.eye(count), 3, axis=0)
    start = np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (count, 1))
    steps = round(REACH_S / model.step_s)
    with np.errstate(over="ignore", invalid="ignore"):  # what is too large for a number is not bounded
        means = _means(model)
        squares = second_moments(model.arrays, belief, start, steps=steps, step_s=model.step_s)
    return bool(np.abs(means).max() <= _LARGEST_MEAN and np.abs(squares).max() <= _LARGEST_MOMENT)


@functools.lru_cache(maxsize=32)
def _means(model: StochasticHybridSystem) -> FloatArray:
    """Tables of the mean over the model's own steps."""
    return mean_tables(model.arrays, round(REACH_S / model.step_s))


@functools.lru_cache(maxsize=32)
def _constants(model: StochasticHybridSystem, steps: float) -> FloatArray:
    """What the point functions need where a sample is so many steps after the one before."""
    table = _means(model)
    modes = advanced(model.arrays, steps)
    header = np.zeros(kernels.HEADER)
    header[kernels.AT_MODES] = len(model.modes)
    header[kernels.AT_STEPS] = len(table) - 1
    header[kernels.AT_STEP] = model.step_s
    inverse = np.linalg.inv(modes.covariance)
    emission = np.column_stack(
        [
            modes.dynamics.reshape(-1, 4),
            modes.offset,
            inverse[:, 0, 0],
            inverse[:, 0, 1],
            inverse[:, 1, 1],
            -0.5 * np.linalg.slogdet(modes.covariance).logabsdet,
        ]
    )
    parts = (header, stationary(modes.chain), modes.chain, emission, table)
    return np.concatenate([part.ravel() for part in parts]).astype(np.float64)

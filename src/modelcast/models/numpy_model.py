"""A sub-model in plain NumPy: batches of windows to parameters, batches of parameters to displacements.

Whoever writes one needs no compiler. It is called by the same loops as the compiled sub-models, one window at
a time, through `modelcast.models.python_function`; where a whole batch is at hand and its rows stand alone,
it is called once. What it gives is looked at before anybody uses it: another shape, or a number that is none,
is an error that names the sub-model, the row and the value.
"""

import abc
import functools
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import ModelcastWarning, SubModelError
from modelcast.core.rules import shown
from modelcast.models import python_kernels as kernels
from modelcast.models.base import (
    AbstractSubModel,
    PointCall,
    PointFunctions,
    Stream,
    Windows,
    made_functions,
)
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.context_columns import CONTEXT_COLUMNS
from modelcast.models.payload import PayloadLayout
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.python_function import PythonFunction
from modelcast.models.row_independence import ROWS, made_up_windows, rows_stand_alone

__all__ = ["AbstractNumpySubModel"]

_CHECKED_HORIZONS_S = np.array([0.0, 0.1, 1.0, 3.7])
_WITH_CONTEXT = SAMPLE_COLUMNS + CONTEXT_COLUMNS


class AbstractNumpySubModel(AbstractSubModel):
    """A sub-model given by `fit_batch` and `predict_batch`, in NumPy or anything that gives its arrays.

    Implementations are frozen dataclasses whose fields pickle. Name, window and parameter names are as in any
    sub-model. Messages carry the predicted path, or what `payload_layout` says.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True, slots=True)
    ... class Newest(AbstractNumpySubModel):
    ...     name, window = "newest", 1
    ...     parameter_names = ("velocity_east_mps", "velocity_north_mps")
    ...
    ...     def fit_batch(self, windows):
    ...         return windows.samples[:, -1, 2:4]
    ...
    ...     def predict_batch(self, parameters, horizons_s, *, dt_s):
    ...         return parameters[:, None, :] * horizons_s[:, None]
    >>> windows = Windows(np.array([[[0.0, 0.0, 10.0, -1.0, 0.0, 0.0, 0.0]]]), dt_s=0.1)
    >>> model = Newest()
    >>> model.predict(model.fit(windows), np.array([0.5]), dt_s=0.1).tolist()
    [[[5.0, -0.5]]]
    """

    @abc.abstractmethod
    def fit_batch(self, windows: Windows) -> FloatArray:
        """Parameters of every window, (B, P).

        Parameters
        ----------
        windows
            (B, `window`, 9), or (B, `window`, 22) where the model `reads_context` and there is some; with
            ``states`` (B, `state_columns`) where it carries any. They are copies.
        """

    @abc.abstractmethod
    def predict_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Displacement from the window's last sample, (B, H, 2): east, north [m].

        Parameters
        ----------
        parameters
            (B, P), as `fit_batch` returned them, or as a message carried them.
        horizons_s
            Times after the last sample, (H,) [s].
        dt_s
            Sampling interval of the windows [s].
        """

    def covariance_batch(
        self,
        parameters: FloatArray,
        horizons_s: FloatArray,
        *,
        dt_s: float,  # noqa: ARG002 - others may need it
    ) -> FloatArray:
        """Predictive covariance, (B, H, 2, 2) [m²]; here that of constant velocity.

        Parameters
        ----------
        parameters, horizons_s, dt_s
            As for `predict_batch`.
        """
        return ConstantVelocity().spread_m2(parameters, horizons_s)

    @property
    def payload_parameters(self) -> int:
        """All of them."""
        return len(self.parameter_names)

    @property
    def payload_layout(self) -> PayloadLayout | None:
        """None: the predicted path is sent."""
        return None

    @property
    def reads_context(self) -> bool:
        """Whether windows are to hold the vehicle ahead and the road (`modelcast.models.context_columns`)."""
        return False

    @property
    def state_columns(self) -> int:
        """Numbers of state S that it carries from sample to sample; 0 where a window says all."""
        return 0

    def observe_batch(
        self,
        states: FloatArray | None,
        samples: FloatArray,
        *,
        dt_s: float,
    ) -> FloatArray:
        """State at a sample, (B, S), from that at the sample before.

        Parameters
        ----------
        states
            (B, S); None at a start and after a gap.
        samples
            The new samples, (B, 9).
        dt_s
            Sampling interval [s].
        """
        raise NotImplementedError(f"{self.name} carries state: it needs observe_batch")

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return what compiled loops call: the batch functions, a row at a time."""
        one = _OneRow(self, dt_s)
        calls = (
            PointCall(kernels.AT_FIT, PythonFunction(one.fit)),
            PointCall(kernels.AT_PREDICT, PythonFunction(one.predict)),
            PointCall(kernels.AT_TRACK, PythonFunction(one.track)),
            *([PointCall(kernels.AT_OBSERVE, PythonFunction(one.observe))] if self.state_columns else []),
        )
        stream = Stream(kernels.observe, self.state_columns, at=kernels.AT_STATE)
        return PointFunctions(
            kernels.fit,
            kernels.predict,
            np.zeros(kernels.HEADER),
            calls,
            track=kernels.track,
            stream=stream if self.state_columns else None,
            context_at=kernels.AT_CONTEXT if self.reads_context else None,
        )

    def fit(self, windows: Windows) -> FloatArray:
        """Parameters of every window, (B, P).

        Raises
        ------
        ValueError
            Where the windows are too short.
        SubModelError
            Where the model fails, or gives another shape or a number that is none.
        """
        self.require_window(windows)
        wide = (len(self.parameter_names),)
        return self._each(lambda rows: self._fitted(windows, rows), len(windows.samples), wide, windows.dt_s)

    def predict(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Displacement from the window's last sample, (B, H, 2) [m]; raises as `fit`."""
        parameters = self.checked(parameters)
        horizons_s = np.array(horizons_s, dtype=np.float64)
        wide = (horizons_s.size, 2)
        return self._each(
            lambda rows: self._predicted(parameters, horizons_s, rows, dt_s), len(parameters), wide, dt_s
        )

    def predict_at(self, parameters: FloatArray, ages_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Displacement of each row at its own age, (B, 2) [m]; raises as `fit`."""
        parameters = self.checked(parameters, ages_s)
        out = np.empty((len(parameters), 2))
        for age_s in np.unique(ages_s):
            chosen = ages_s == age_s
            out[chosen] = self.predict(parameters[chosen], np.array([age_s]), dt_s=dt_s)[:, 0]
        return out

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Predictive covariance, (B, H, 2, 2) [m²]; raises as `fit`."""
        parameters = self.checked(parameters)
        horizons_s = np.array(horizons_s, dtype=np.float64)
        wide = (horizons_s.size, 2, 2)
        return self._each(
            lambda rows: self._spread(parameters, horizons_s, rows, dt_s), len(parameters), wide, dt_s
        )

    def row_dependence(self, dt_s: float) -> tuple[str, ...]:
        """Which of its functions say something else of a row in a batch than of it alone, by bits.

        It is looked at with made-up windows, once for each sub-model and interval; where there is one, it is
        called row by row everywhere, and a `ModelcastWarning` says so.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        return self._row_dependence(made_functions(self, dt_s).calls[0].function)

    @staticmethod
    @functools.lru_cache(maxsize=64)
    def _row_dependence(fit: PythonFunction) -> tuple[str, ...]:
        """What `row_dependence` says, looked at once for functions that are the same."""
        one: _OneRow = cast("Any", fit.body).__self__
        found = one.model._dependent(one.dt_s)  # noqa: SLF001 - of this class
        if found:
            warnings.warn(
                f"The rows of {' and '.join(found)} of the sub-model {one.model.name} change one another: it "
                "is called row by row everywhere, which takes longer.",
                ModelcastWarning,
                stacklevel=3,
            )
        return found

    def _each(
        self, function: Callable[[IntArray], FloatArray], count: int, wide: tuple[int, ...], dt_s: float
    ) -> FloatArray:
        """What a function of rows says of all: asked once, or row by row; (count, *wide)."""
        if not count:
            return np.empty((0, *wide))
        if count == 1 or not self.row_dependence(dt_s):
            return function(np.arange(count))
        return np.concatenate([function(np.array([row])) for row in range(count)])

    def _fitted(self, windows: Windows, rows: IntArray) -> FloatArray:
        """Parameters of these rows of windows that may be longer than needed."""
        samples = windows.samples[rows]
        states = windows.states[rows] if windows.states is not None else self._scanned(samples, windows.dt_s)
        columns = samples.shape[2] if self.reads_context else SAMPLE_COLUMNS
        newest = samples[:, samples.shape[1] - self.window :, :columns].copy()
        own = Windows(newest, dt_s=windows.dt_s, states=states)
        found = self._told("fit_batch", lambda: self.fit_batch(own))
        return self._numbers("fit_batch", found, rows, (len(self.parameter_names),))

    def _scanned(self, samples: FloatArray, dt_s: float) -> FloatArray | None:
        """State at the newest of some samples, (B, n, C), with a start at the oldest."""
        if not self.state_columns:
            return None
        states = None
        for at in range(samples.shape[1]):
            states = self.observed(states, samples[:, at, :SAMPLE_COLUMNS], dt_s)
        return states

    def observed(self, states: FloatArray | None, samples: FloatArray, dt_s: float) -> FloatArray:
        """What `observe_batch` says, looked at.

        Parameters
        ----------
        states
            (B, S); None at a start and after a gap.
        samples
            The new samples, (B, 9).
        dt_s
            Sampling interval [s].

        Raises
        ------
        SubModelError
            Where it raises, or gives another shape or a number that is not finite.
        """
        found = self._told("observe_batch", lambda: self.observe_batch(states, samples.copy(), dt_s=dt_s))
        return self._numbers("observe_batch", found, np.arange(len(samples)), (self.state_columns,))

    def _predicted(
        self, parameters: FloatArray, horizons_s: FloatArray, rows: IntArray, dt_s: float
    ) -> FloatArray:
        """Displacements of these rows of parameters."""
        given = parameters[rows]
        found = self._told("predict_batch", lambda: self.predict_batch(given, horizons_s.copy(), dt_s=dt_s))
        return self._numbers("predict_batch", found, rows, (horizons_s.size, 2))

    def _spread(
        self, parameters: FloatArray, horizons_s: FloatArray, rows: IntArray, dt_s: float
    ) -> FloatArray:
        """Covariances of these rows of parameters."""
        given = parameters[rows]
        found = self._told(
            "covariance_batch", lambda: self.covariance_batch(given, horizons_s.copy(), dt_s=dt_s)
        )
        return self._numbers("covariance_batch", found, rows, (horizons_s.size, 2, 2))

    def _dependent(self, dt_s: float) -> tuple[str, ...]:
        """What `row_dependence` says, looked at."""
        windows = made_up_windows(self.window, dt_s=dt_s)
        parameters = np.concatenate([self._fitted(windows, np.array([row])) for row in range(ROWS)])
        horizons_s = _CHECKED_HORIZONS_S

        def scanned(rows: IntArray) -> FloatArray:
            return cast("FloatArray", self._scanned(windows.samples[rows], dt_s))

        functions: dict[str, Callable[[IntArray], FloatArray]] = {
            **({"observe_batch": scanned} if self.state_columns else {}),
            "fit_batch": lambda rows: self._fitted(windows, rows),
            "predict_batch": lambda rows: self._predicted(parameters, horizons_s, rows, dt_s),
            "covariance_batch": lambda rows: self._spread(parameters, horizons_s, rows, dt_s),
        }
        return tuple(name for name, one in functions.items() if not rows_stand_alone(one))

    def _told(self, called: str, function: Callable[[], Any]) -> Any:
        """What a function of the model gives; what it raises, `SystemExit` too, is told with its name."""
        try:
            return function()
        except (Exception, SystemExit) as error:
            if isinstance(error, SubModelError) and error.model:  # of another one that it asked
                raise
            raise self._failure(called, f"failed in {called}: {type(error).__name__}: {error}") from error

    def _numbers(self, called: str, found: Any, rows: IntArray, wide: tuple[int, ...]) -> FloatArray:
        """What a function of the model gave for some rows, as finite numbers, (n, *wide)."""
        wanted = (len(rows), *wide)
        try:
            values = np.asarray(found, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._failure(called, f"gave no array of numbers from {called}: {shown(found)}") from error
        if values.shape != wanted:
            raise self._failure(called, f"gave {values.shape} from {called}, wanted {wanted}: a row each.")
        if not np.isfinite(values).all():
            row, *place = np.argwhere(~np.isfinite(values))[0]
            raise self._failure(
                called,
                f"gave {values[row][*place]} from {called} in row {rows[row]} at "
                f"{self._place(called, place)}: every number must be finite.",
            )
        return np.ascontiguousarray(values)

    def _failure(self, called: str, what: str) -> SubModelError:
        """The error that one of its functions did something."""
        return SubModelError(f"The sub-model {self.name} {what}", model=self.name, called=called)

    def _place(self, called: str, place: Sequence[int]) -> str:
        """What a number of a row is."""
        if called == "fit_batch":
            return self.parameter_names[place[0]]
        return ", ".join(str(int(one)) for one in place)


@dataclass(frozen=True, slots=True)
class _OneRow:
    """A sub-model as compiled loops call it: one row at a time, for one sampling interval."""

    model: AbstractNumpySubModel
    dt_s: float

    def fit(self, window: FloatArray, constants: FloatArray, _number: float, out: FloatArray) -> None:
        """Fit a window (n, C), which holds context and state where constants say; ``out`` (P or more)."""
        columns = _WITH_CONTEXT if constants[kernels.AT_CONTEXT] else SAMPLE_COLUMNS
        first = int(constants[kernels.AT_STATE])
        states = window[-1:, first : first + self.model.state_columns] if first else None
        found = self.model.fit(Windows(window[None, :, :columns], dt_s=self.dt_s, states=states))[0]
        out[: found.size] = found

    def predict(
        self, parameters: FloatArray, _constants: FloatArray, horizon_s: float, out: FloatArray
    ) -> None:
        """Predict a displacement from parameters (1, P or more)."""
        own = parameters[:, : len(self.model.parameter_names)]
        out[:2] = self.model.predict(own, np.array([horizon_s]), dt_s=self.dt_s)[0, 0]

    def track(self, parameters: FloatArray, horizons_s: FloatArray, _number: float, out: FloatArray) -> None:
        """Predict the displacements (2H,) of parameters (1, P or more) at all horizons."""
        own = parameters[:, : len(self.model.parameter_names)]
        out[:] = self.model.predict(own, horizons_s, dt_s=self.dt_s).ravel()

    def observe(self, before: FloatArray, sample: FloatArray, column: float, out: FloatArray) -> None:
        """Carry state, from ``column`` on, to a sample (C,); none before (0, 0) is a start."""
        states = before[:, int(column) : int(column) + out.size] if before.size else None
        out[:] = self.model.observed(states, sample[None, :SAMPLE_COLUMNS], self.dt_s)[0]

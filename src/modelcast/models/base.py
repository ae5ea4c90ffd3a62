"""What a motion model is: two compiled point functions, and everything in batch that follows from them.

A model is fitted to a *window*, the last ``n`` samples of one vehicle, and its parameters predict the
displacement from the window's last sample at any later time. Parameters are numbers only, so they are the
payload of a message. A model states its two point functions, kernels of the fixed types `FIT_TYPES` and
`PREDICT_TYPES`; the batch interface here, the walk of a policy over a trip and the fleet engine all call
these same two functions by their addresses, so a new model needs no change elsewhere.
"""

import abc
import functools
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models import point_kernels
from modelcast.models.address_kernels import FIT_TYPES, OBSERVE_TYPES, PREDICT_TYPES, point_address
from modelcast.models.context_columns import CONTEXT_COLUMNS
from modelcast.models.member_kernels import NO_ABSORB
from modelcast.models.payload import PayloadLayout
from modelcast.models.python_function import PythonFunction, keeping

__all__ = [
    "AbstractMotionModel",
    "AbstractSubModel",
    "PointCall",
    "PointFunctions",
    "Stream",
    "Windows",
    "made_functions",
]


@dataclass(frozen=True, slots=True)
class Windows:
    """The last ``n`` samples of B vehicles, equally spaced.

    Parameters
    ----------
    samples
        (B, n, 7): east, north [m]; the east, north velocity [m/s], the acceleration along the course [m/s²],
        the yaw rate, clockwise [rad/s], and the standard deviation of the white position noise an axis [m],
        that one named causal estimator each gives at each sample; a noise of 0 says that it is not known.
        Row -1 is the newest. Or (B, n, 9), with the speed that the vehicle reports [m/s] and what it
        reports (`point_kernels.REPORTS`), which are that of the velocity and 0 where they are left out; or
        (B, n, 22), with the columns of `modelcast.models.context_columns` behind. What is kept has both.
    dt_s
        Sampling interval [s].
    states
        State that a model carries from sample to sample, as of the newest one, (B, S); only a sub-model that
        is written in Python and asks for it finds it here. None where there is none.

    Raises
    ------
    ValueError
        Where a shape is another, a value is not finite or the interval is not positive.
    """

    samples: FloatArray
    _: KW_ONLY
    dt_s: float
    states: FloatArray | None = None

    def __post_init__(self) -> None:
        bare, whole = point_kernels.SAMPLE_COLUMNS, point_kernels.SAMPLE_COLUMNS + CONTEXT_COLUMNS
        least = point_kernels.SPEED
        if self.samples.ndim != 3 or self.samples.shape[2] not in (least, bare, whole):
            raise ValueError(
                f"samples must be (B, n, {least}), or (B, n, {bare}) with what is reported, "
                f"or (B, n, {whole}) with context, got {self.samples.shape}"
            )
        if self.samples.shape[2] < bare:
            east, north = point_kernels.VELOCITY_EAST, point_kernels.VELOCITY_NORTH
            speed = np.hypot(self.samples[..., east], self.samples[..., north])
            added = np.stack([speed, np.zeros_like(speed)], axis=-1)
            object.__setattr__(self, "samples", np.concatenate([self.samples, added], axis=2))
        if not np.isfinite(self.samples).all():
            raise ValueError("samples must be finite: skip a vehicle without a full window")
        if not (self.dt_s > 0 and np.isfinite(self.dt_s)):
            raise ValueError(f"dt_s must be positive and finite, got {self.dt_s}")
        if self.states is not None and (self.states.ndim != 2 or len(self.states) != len(self.samples)):
            raise ValueError(f"states must be ({len(self.samples)}, S), got {self.states.shape}")

    @property
    def positions_m(self) -> FloatArray:
        """East and north, (B, n, 2) [m]."""
        return self.samples[..., point_kernels.EAST : point_kernels.NORTH + 1]

    @property
    def velocities_mps(self) -> FloatArray:
        """East and north, (B, n, 2) [m/s]."""
        return self.samples[..., point_kernels.VELOCITY_EAST : point_kernels.VELOCITY_NORTH + 1]

    def rows(self, chosen: IntArray) -> "Windows":
        """These rows alone.

        Parameters
        ----------
        chosen
            Indices of rows.
        """
        states = None if self.states is None else self.states[chosen]
        return Windows(self.samples[chosen], dt_s=self.dt_s, states=states)


@dataclass(frozen=True, slots=True)
class PointCall:
    """A place in a model's constants that holds, while a compiled loop runs, the address of a point function.

    Parameters
    ----------
    at
        Index in the constants.
    function
        The kernel called there, or the Python function.
    types
        `FIT_TYPES` or `PREDICT_TYPES` of a kernel; none of a Python function.
    """

    at: int
    function: Any
    types: tuple[Any, ...] = ()

    @property
    def address(self) -> int:
        """The function as compiled loops take it."""
        if isinstance(self.function, PythonFunction):
            return self.function.address
        return point_address(self.function, self.types)


@dataclass(frozen=True, slots=True)
class Stream:
    """State that a model carries from sample to sample, beyond any window.

    A station keeps it in further columns of its samples: each new sample gets its own from the sample before,
    and ``fit`` finds it in the rows of its window.

    Parameters
    ----------
    observe
        ``observe(before (C,), sample (C,), constants, out_state (S,))``, a kernel of `OBSERVE_TYPES`.
        ``before`` is the sample before with all its columns; it is empty at a start and after a gap, where
        state begins anew.
    columns
        Columns of state, S >= 1.
    at
        Index in the model's constants at which it finds, while a compiled loop runs, the first of its
        columns. It is 0 where samples hold none, as in `Windows`: ``fit`` then makes the state from the
        window alone.
    start
        Where in the constants those of ``observe`` begin.
    """

    observe: Any
    columns: int
    _: KW_ONLY
    at: int
    start: int = 0

    @property
    def observe_address(self) -> int:
        """``observe`` as compiled loops take it."""
        return point_address(self.observe, OBSERVE_TYPES)


@dataclass(frozen=True, slots=True)
class PointFunctions:
    """A model made ready for one sampling interval.

    Parameters
    ----------
    fit
        ``fit(window (n, 9), constants (K,), out_parameters (P,))``, a kernel of `FIT_TYPES`.
    predict
        ``predict(parameters (P,), horizon_s, constants (K,), out_displacement (2,))``, a kernel of
        `PREDICT_TYPES`.
    constants
        The model's settings and tables for this interval, packed by the model, (K,).
    calls
        Point functions of another model that these call by the addresses in their constants.
    stream
        State carried from sample to sample; None where the window says all.
    absorb
        ``absorb(new (P,), moved (3,), constants (K,), held (P,))``, a kernel of `OBSERVE_TYPES`: what a
        receiver holds after an update, from what it held of the same sub-model before. ``new`` are the
        parameters as decoded, ``moved`` the time [s] and the way east and north [m] between the two origins;
        ``held`` is overwritten. None where an update says all.
    track
        ``track(parameters (P,), horizons_s (H,), constants (K,), out_displacements (H, 2))``, a kernel of
        `TRACK_TYPES`: ``predict`` at many horizons at once, to the bit, where that is quicker. None where it
        is not.
    context_at
        Index in the constants at which these find, while a compiled loop runs, the first of the columns of
        `modelcast.models.context_columns` in a sample; 0 stands there where samples hold none. None where
        they read no context.

    Notes
    -----
    The constants are numbers and may go to another process; `addressed` is what compiled loops take, and
    means something in this one only.
    """

    fit: Any
    predict: Any
    constants: FloatArray
    calls: tuple[PointCall, ...] = ()
    stream: Stream | None = None
    absorb: Any = None
    track: Any = None
    context_at: int | None = None

    @property
    def absorb_address(self) -> int:
        """``absorb`` as compiled loops take it, `NO_ABSORB` for none."""
        return NO_ABSORB if self.absorb is None else point_address(self.absorb, OBSERVE_TYPES)

    @property
    def fit_address(self) -> int:
        """``fit`` as compiled loops take it."""
        return point_address(self.fit, FIT_TYPES)

    @property
    def predict_address(self) -> int:
        """``predict`` as compiled loops take it."""
        return point_address(self.predict, PREDICT_TYPES)

    @property
    def addressed(self) -> FloatArray:
        """The constants with the addresses of this process in place, (K,); they keep what they address."""
        if not self.calls:
            return self.constants
        out = keeping(self.constants, self.calls)
        for call in self.calls:
            out[call.at] = call.address
        return out

    def called_from(self, start: int, fit_at: int, predict_at: int) -> tuple[PointCall, ...]:
        """Calls of functions that go round these, whose constants hold these constants from ``start`` on.

        Parameters
        ----------
        start
            Where these constants begin among the outer ones.
        fit_at, predict_at
            Where the outer ones hold the addresses of these functions.
        """
        inner = (replace(call, at=start + call.at) for call in self.calls)
        own = PointCall(fit_at, self.fit, FIT_TYPES), PointCall(predict_at, self.predict, PREDICT_TYPES)
        return (*own, *inner)

    def streamed_from(self, start: int) -> Stream | None:
        """State of functions that go round these, whose constants hold these constants from ``start`` on.

        Parameters
        ----------
        start
            Where these constants begin among the outer ones.
        """
        own = self.stream
        return None if own is None else replace(own, at=start + own.at, start=start + own.start)

    def context_from(self, start: int) -> int | None:
        """`context_at` of functions that go round these, whose constants hold these from ``start`` on.

        Parameters
        ----------
        start
            Where these constants begin among the outer ones.
        """
        return None if self.context_at is None else start + self.context_at

    def reading_context(self, column: int) -> FloatArray:
        """The constants as `addressed` has them, with the place of the context in a sample, (K,).

        Parameters
        ----------
        column
            First column of the context, 0 where samples hold none.
        """
        out = self.addressed
        if self.context_at is None:
            return out
        if out is self.constants:
            out = out.copy()
        out[self.context_at] = column
        return out


class AbstractMotionModel(abc.ABC):
    """A motion model: ``fit`` windows to parameters, ``predict`` displacements from parameters."""

    def checked(self, parameters: FloatArray, ages_s: FloatArray | None = None) -> FloatArray:
        """The parameters as compiled loops take them.

        Parameters
        ----------
        parameters
            (B, P).
        ages_s
            One a row, (B,), where there are any [s].

        Raises
        ------
        ValueError
            Where a shape is another: a compiled loop would read past the end.
        """
        wanted = len(self.parameter_names)
        if parameters.ndim != 2 or parameters.shape[1] != wanted:
            raise ValueError(f"{self.name}: parameters must be (B, {wanted}), got {parameters.shape}")
        if ages_s is not None and ages_s.shape != parameters.shape[:1]:
            raise ValueError(f"ages_s must be ({parameters.shape[0]},), one a row, got {ages_s.shape}")
        return np.ascontiguousarray(parameters, dtype=np.float64)

    def require_window(self, windows: Windows) -> None:
        """Refuse windows that are too short.

        Parameters
        ----------
        windows
            Any.

        Raises
        ------
        ValueError
            Where they hold fewer samples than `window`.
        """
        given = windows.samples.shape[1]
        if given < self.window:
            raise ValueError(f"{self.name} needs windows of {self.window} samples, got {given}")

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """Short name, as in tables and on the command line."""

    @property
    @abc.abstractmethod
    def window(self) -> int:
        """Samples a window must hold, n >= 1."""

    @property
    @abc.abstractmethod
    def parameter_names(self) -> tuple[str, ...]:
        """One name a parameter, unit at the end, in the order of the payload; length P."""

    @abc.abstractmethod
    def fit(self, windows: Windows) -> FloatArray:
        """Parameters of every window, (B, P).

        Parameters
        ----------
        windows
            At least `window` samples each; the newest `window` of them are used, and all by a model that
            carries state from sample to sample (`Stream`).

        Raises
        ------
        ValueError
            Where the windows are shorter than the model needs.
        """

    @abc.abstractmethod
    def predict(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement from the window's last sample, (B, H, 2) [m].

        Parameters
        ----------
        parameters
            (B, P), as `fit` returned them.
        horizons_s
            Times after the window's last sample, (H,) [s].
        dt_s
            Sampling interval of the windows [s].

        Raises
        ------
        ValueError
            Where the parameters have another length.
        """

    @abc.abstractmethod
    def predict_at(self, parameters: FloatArray, ages_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement of each row at its own age, (B, 2) [m].

        Parameters
        ----------
        parameters
            (B, P), as `fit` returned them.
        ages_s
            Time after the window's last sample, one a row, (B,) [s].
        dt_s
            Sampling interval of the windows [s].
        """

    @abc.abstractmethod
    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Predictive covariance of the displacement, (B, H, 2, 2) [m²].

        Parameters
        ----------
        parameters
            (B, P), as `fit` returned them.
        horizons_s
            Times after the window's last sample, (H,) [s].
        dt_s
            Sampling interval of the windows [s].
        """


class AbstractSubModel(AbstractMotionModel):
    """A motion model given by two compiled point functions; the batch methods follow from them.

    Implementations are frozen dataclasses.
    """

    @property
    @abc.abstractmethod
    def payload_parameters(self) -> int:
        """How many of the parameters a message carries beyond a core basic safety message, 0..P."""

    @property
    def payload_layout(self) -> PayloadLayout | None:
        """How a message carries them; None where it cannot. Parameters in neither it nor Part I are zero.

        Of a sub-model without a layout the predicted path is sent (`modelcast.models.predicted_path`).
        """
        return PayloadLayout() if self.payload_parameters == 0 else None

    @property
    def states_own_values(self) -> bool:
        """Whether its sender states other values in Part I than another sub-model of the bank would."""
        return False

    @property
    def starter(self) -> "AbstractSubModel | None":
        """What says the same to a receiver and needs a single sample; None where constant velocity starts."""
        return None

    @property
    def held_parameters(self) -> tuple[str, ...]:
        """Parameters that no message carries: receivers work them out (`PointFunctions.absorb`).

        They are zero as fitted and as decoded. A receiver that held no update of this sub-model before
        predicts with the zeros.
        """
        return ()

    @property
    def predicts_by_parameters(self) -> bool:
        """Whether ``predict`` looks at the parameters alone: constants are the sender's affair then."""
        return False

    @property
    def trusted_horizon_s(self) -> float:
        """Age beyond which everybody predicts by a damped continuation [s]; infinite: never.

        `modelcast.models.trusted.Trusted` sets it.
        """
        return np.inf

    @property
    def trusted_turn_s(self) -> float:
        """How long beyond the trusted horizon the car goes on turning [s]."""
        return np.inf

    @abc.abstractmethod
    def point_functions(self, dt_s: float) -> PointFunctions:
        """Return the compiled functions and tables for a sampling interval."""

    def fit(self, windows: Windows) -> FloatArray:
        """Parameters of every window, (B, P)."""
        self.require_window(windows)
        given = windows.samples.shape[1]
        ready = made_functions(self, windows.dt_s)
        first = given - self.window if ready.stream is None else 0
        samples = np.ascontiguousarray(windows.samples[:, first:], dtype=np.float64)
        out = np.empty((samples.shape[0], len(self.parameter_names)))
        column = point_kernels.SAMPLE_COLUMNS if samples.shape[2] > point_kernels.SAMPLE_COLUMNS else 0
        point_kernels.fit_batch(ready.fit_address, samples, ready.reading_context(column), out)
        return out

    def predict(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement from the window's last sample, (B, H, 2) [m]."""
        parameters = self.checked(parameters)
        ready = made_functions(self, dt_s)
        horizons_s = np.ascontiguousarray(horizons_s, dtype=np.float64)
        out = np.empty((parameters.shape[0], horizons_s.size, 2))
        point_kernels.predict_batch(
            ready.predict_address,
            parameters,
            horizons_s,
            ready.addressed,
            float(self.trusted_horizon_s),
            float(self.trusted_turn_s),
            out,
        )
        return out

    def predict_at(self, parameters: FloatArray, ages_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement of each row at its own age, (B, 2) [m]."""
        parameters = self.checked(parameters, ages_s)
        ready = made_functions(self, dt_s)
        ages_s = np.ascontiguousarray(ages_s, dtype=np.float64)
        out = np.empty((parameters.shape[0], 2))
        point_kernels.predict_each(
            ready.predict_address,
            parameters,
            ages_s,
            ready.addressed,
            float(self.trusted_horizon_s),
            float(self.trusted_turn_s),
            out,
        )
        return out


def made_functions(member: AbstractSubModel, dt_s: float) -> PointFunctions:
    """Point functions of a sub-model for a sampling interval, made once.

    Parameters
    ----------
    member
        The sub-model.
    dt_s
        Sampling interval [s].
    """
    return _functions(_Same(member), dt_s)


@dataclass(frozen=True, slots=True, eq=False)
class _Same:
    """A sub-model by identity: telling whether two are equal costs as much as making their tables."""

    member: AbstractSubModel

    def __hash__(self) -> int:
        return id(self.member)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.member is self.member


@functools.lru_cache(maxsize=64)
def _functions(same: _Same, dt_s: float) -> PointFunctions:
    """Point functions of a member, made once for an interval."""
    return same.member.point_functions(dt_s)

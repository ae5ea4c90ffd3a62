"""Calibrations of sub-models from recorded trips: every instant a fit, every later sample its judge.

The table is made of quantiles, so single wild errors do not move it: first the spread along and across the
course on its own (the 90th percentile of the normalised error), then both together (that of the Mahalanobis
radius), then the radii of the other levels. How much round error is added to the nominal covariance is the
one value of a small grid that makes the 90 % ellipses smallest, their misses counted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import LEVELS, Calibration, course_axes, gaussian_radius, widened
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.study.case import TripCase

__all__ = [
    "HORIZONS_S",
    "PredictionErrors",
    "calibrate",
    "fitted_at",
    "mahalanobis",
    "pooled_calibrations",
    "pooled_errors",
    "prediction_errors",
    "train_calibrations",
]

HORIZONS_S = (0.1, 0.2, 0.4, 0.6, 1.0, 1.4, 2.0, 3.0, 4.0, 5.0)
"""Horizons of the tables; all but the first are samples of 5 Hz logs too [s]."""

UNMODELLED = (0.0, 0.1, 0.3, 1.0)
"""Shares of round error that are tried."""

FEWEST_INSTANTS = 50
"""A horizon with fewer errors gets no entry."""

_TIME_SLACK_S = 1e-3
_MIDDLE = LEVELS.index(0.9)


@dataclass(frozen=True, slots=True)
class PredictionErrors:
    """Errors of one sub-model fitted at N instants, at H horizons, along and across the predicted course.

    Parameters
    ----------
    sub_model
        Its name.
    horizons_s
        Horizons, (H,) [s].
    errors_m
        Predicted less true position, NaN where the truth is not known, (N, H, 2) [m].
    covariance_m2
        Nominal covariance with the same axes, (N, H, 2, 2) [m²].
    """

    sub_model: str
    horizons_s: FloatArray
    errors_m: FloatArray
    covariance_m2: FloatArray

    def select(self, rows: BoolArray) -> "PredictionErrors":
        """Return those of these instants, (N,)."""
        return PredictionErrors(
            self.sub_model, self.horizons_s, self.errors_m[rows], self.covariance_m2[rows]
        )


def fitted_at(case: TripCase, member: AbstractSubModel, stride: int) -> IntArray:
    """Every ``stride``-th sample of a trip that has a full window, (N,).

    Parameters
    ----------
    case
        The trip.
    member
        The sub-model.
    stride
        Samples from one to the next.
    """
    at = np.arange(0, len(case.seen), stride)
    return at[at - case.seen.segment_start[at] + 1 >= member.window]


def prediction_errors(
    case: TripCase, member: AbstractSubModel, horizons_s: Sequence[float] = HORIZONS_S, *, stride: int = 5
) -> PredictionErrors:
    """Errors of a sub-model fitted at the samples that `fitted_at` gives.

    Fitted to what the sender sees, held against the truth of the same part of the trip.

    Parameters
    ----------
    case
        The trip.
    member
        The sub-model.
    horizons_s
        Horizons, (H,) [s]; those between two samples of the trip have no errors.
    stride
        Samples from one fit to the next.
    """
    wanted_s = np.asarray(horizons_s, dtype=np.float64)
    seen, truth = case.seen, case.truth
    ready = TripRuntime(seen, Bank((member,)), case.estimator)
    at = fitted_at(case, member, stride)
    ready.fit_at(at)
    parameters = np.ascontiguousarray(ready.parameters[at, : len(member.parameter_names)])
    moved = member.predict(parameters, wanted_s, dt_s=seen.dt_s)
    axes = course_axes(moved)
    later, known = _later(case, at, wanted_s)
    off = seen.position_m[at][:, None] + moved - truth.position_m[later]
    errors_m = np.einsum("nhij,nhj->nhi", axes, off)
    errors_m[~known] = np.nan
    nominal = member.covariance(parameters, wanted_s, dt_s=seen.dt_s)
    return PredictionErrors(member.name, wanted_s, errors_m, axes @ nominal @ axes.swapaxes(-1, -2))


def _later(case: TripCase, at: IntArray, horizons_s: FloatArray) -> tuple[IntArray, BoolArray]:
    """Samples that lie the horizons after others, (N, H), and which of them exist in the same part."""
    trip = case.seen
    steps = np.rint(horizons_s / trip.dt_s).astype(np.int64)
    ends = np.repeat(trip.segments[1:], np.diff(trip.segments))
    later = at[:, None] + steps
    known = later < ends[at][:, None]
    later = np.minimum(later, len(trip) - 1)
    known &= np.abs(trip.t_s[later] - trip.t_s[at][:, None] - horizons_s) < _TIME_SLACK_S * (1.0 + horizons_s)
    return later, known


def pooled_errors(parts: Sequence[PredictionErrors]) -> PredictionErrors:
    """Errors of one sub-model over several trips.

    Parameters
    ----------
    parts
        At least one, of one sub-model at the same horizons.
    """
    first = parts[0]
    return PredictionErrors(
        first.sub_model,
        first.horizons_s,
        np.concatenate([part.errors_m for part in parts]),
        np.concatenate([part.covariance_m2 for part in parts]),
    )


def calibrate(errors: PredictionErrors) -> Calibration:
    """Return the calibration under which the errors' 90 % ellipses hold 90 % of them.

    Parameters
    ----------
    errors
        Of the training trips.

    Raises
    ------
    ValueError
        Where no horizon has `FEWEST_INSTANTS` errors.
    """
    known = ~np.isnan(errors.errors_m[:, :, 0])
    enough = known.sum(axis=0) >= FEWEST_INSTANTS
    if not enough.any():
        raise ValueError(
            f"{errors.sub_model}: fewer than {FEWEST_INSTANTS} errors at every horizon; train on longer trips"
        )
    horizons_s = errors.horizons_s[enough]
    tried: list[tuple[float, float, FloatArray, FloatArray]] = []
    for share in UNMODELLED:
        base = widened(errors.covariance_m2, errors.horizons_s, share)
        rows = [_entry(errors.errors_m[known[:, h], h], base[known[:, h], h]) for h in np.flatnonzero(enough)]
        factors, radii, sizes = (np.array(column) for column in zip(*rows, strict=True))
        # Sizes of different horizons count alike: what is compared is their ratio.
        tried.append((float(np.log(sizes).sum()), share, factors, radii))
    _, share, factors, radii = min(tried, key=lambda one: one[0])
    return Calibration(
        errors.sub_model,
        horizons_s,
        unmodelled=share,
        factors=factors,
        radii=radii,
        instants=errors.errors_m.shape[0],
    )


def _entry(errors_m: FloatArray, covariance_m2: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Factors (2,) and radii (3,) of one horizon, and the score of its 90 % ellipses [m].

    The score is the ellipse's mean radius plus ten times what errors outside it lack, the interval score of
    Gneiting and Raftery (2007) in the radius.
    """
    level = LEVELS[_MIDDLE]
    spread_m = np.sqrt(np.einsum("nii->ni", covariance_m2))
    # 1.645: the 90 % quantile of a normal error's magnitude. The joint radius corrects both afterwards.
    factors = np.maximum(np.quantile(np.abs(errors_m) / spread_m, level, axis=0) / 1.645, 1e-6)
    radius = mahalanobis(errors_m / factors, covariance_m2)
    target = float(gaussian_radius(level))
    correction = max(float(np.quantile(radius, level)), 1e-6) / target
    factors, radius = factors * correction, radius / correction
    radii = np.maximum(np.quantile(radius, LEVELS), 1e-6)
    radii[_MIDDLE] = target
    size_m = target * np.sqrt(spread_m.prod(axis=1) * factors.prod())
    score_m = size_m * (1.0 + np.maximum(radius / target - 1.0, 0.0) / (1.0 - level))
    return factors, np.maximum.accumulate(radii), float(score_m.mean())


def mahalanobis(errors_m: FloatArray, covariance_m2: FloatArray) -> FloatArray:
    """Radius of each error under its covariance, (N,).

    Parameters
    ----------
    errors_m
        (N, 2) [m].
    covariance_m2
        Positive definite, (N, 2, 2) [m²].
    """
    one, mixed, other = covariance_m2[:, 0, 0], covariance_m2[:, 0, 1], covariance_m2[:, 1, 1]
    along, across = errors_m[:, 0], errors_m[:, 1]
    square = other * along**2 - 2.0 * mixed * along * across + one * across**2
    return np.sqrt(np.maximum(square, 0.0) / (one * other - mixed**2))


def train_calibrations(
    cases: Sequence[TripCase],
    members: Sequence[AbstractSubModel],
    *,
    stride: int = 5,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Calibration]:
    """Calibrations of several sub-models over training trips, by name.

    Parameters
    ----------
    cases
        The trips, made ready.
    members
        The sub-models, damped where they will be.
    stride
        Samples from one fit to the next.
    progress
        Called with trips done, over all sub-models, and their number.
    """
    return pooled_calibrations([(cases, members)], stride=stride, progress=progress)


def pooled_calibrations(
    folds: Sequence[tuple[Sequence[TripCase], Sequence[AbstractSubModel]]],
    *,
    stride: int = 5,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Calibration]:
    """Calibrations of sub-models that were trained anew without the trips they are held against, by name.

    Parameters
    ----------
    folds
        Trips, and sub-models that learnt nothing from them; in every fold sub-models of the same names in the
        same order, each the same but for its training.
    stride, progress
        As in `train_calibrations`.
    """
    total = sum(len(cases) * len(members) for cases, members in folds)
    found: dict[str, Calibration] = {}
    done = 0
    for which, named in enumerate(folds[0][1]):
        parts: list[PredictionErrors] = []
        for cases, members in folds:
            for case in cases:
                parts.append(prediction_errors(case, members[which], stride=stride))
                done += 1
                if progress is not None:
                    progress(done, total)
        found[named.name] = calibrate(pooled_errors(parts))
    return found

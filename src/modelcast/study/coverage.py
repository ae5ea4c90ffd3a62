"""Coverage: how many errors of unseen trips lie inside the ellipses that should hold 50, 90 and 95 %.

Beside every sub-model alone, a hybrid may be counted: at each instant the sub-model with which a sender that
updates just then starts, with that sub-model's own calibration.

Three ellipses are compared: the *nominal* one of the sub-model's own covariance; the *calibrated* one, whose
covariance was learnt on other trips and whose radius is a Gaussian's; and the *mapped* one, the same
covariance with the radius learnt for its level. From the same covariances comes the expected time until a
threshold is crossed, held against the time that was observed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import LEVELS, Calibration, gaussian_radius
from modelcast.models.threshold_time import expected_time_to_threshold
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import TripCase
from modelcast.study.table import Row, Table, TableSchema, count, quantity, ratio, text
from modelcast.study.training.calibration import (
    PredictionErrors,
    calibrate,
    fitted_at,
    mahalanobis,
    pooled_errors,
    prediction_errors,
)

__all__ = ["COVERAGE", "FORMS", "TIMES", "CoverageResult", "Hybrid", "measure_coverage"]

FORMS = ("nominal", "calibrated", "mapped")
"""The three ellipses."""

HORIZONS_S = (0.2, 0.5, 1.0, 2.0, 3.0, 5.0)
TIME_HORIZONS_S = tuple(np.arange(1, 26) * 0.2)

_SMALLEST_M2 = 1e-12
"""Added to a nominal covariance: one of zero has no radius."""


_WHOSE = (text("sub_model", "Name of the sub-model."), text("form", "Kind of ellipse, one of `FORMS`."))

COVERAGE = TableSchema(
    "coverage",
    "Share of errors inside one kind of ellipse.",
    (
        *_WHOSE,
        quantity("horizon_s", "s", "Age of the prediction."),
        ratio("level", "Share that should lie inside."),
        ratio("covered_ratio", "Share that does."),
        count("errors", "How many errors there are."),
    ),
)
"""Coverage: a row a sub-model, ellipse, horizon and level."""

TIMES = TableSchema(
    "times",
    "Expected against observed time until a threshold is crossed, both cut at the last horizon.",
    (
        *_WHOSE,
        quantity("threshold_m", "m", "Tracking error that ends a time."),
        quantity("expected_s", "s", "Mean expected time over the instants."),
        quantity("observed_s", "s", "Mean observed time over the instants."),
        quantity(
            "rank_correlation",
            "1",
            "Spearman's, over the instants; NaN where one of the two does not vary.",
        ),
        count("instants", "How many instants there are."),
    ),
)
"""Times to thresholds: a row a sub-model, ellipse and threshold."""


@dataclass(frozen=True, slots=True)
class CoverageResult:
    """What `measure_coverage` found.

    Parameters
    ----------
    rows, times
        Tables of `COVERAGE` and `TIMES`.
    calibrations
        What was learnt, by the name of the trips it was tested on, then by sub-model.
    """

    rows: Table
    times: Table
    calibrations: Mapping[str, Mapping[str, Calibration]]

    def as_plain(self) -> Mapping[str, Any]:
        """The result as plain values; a number that does not exist is None."""
        return {
            "coverage": self.rows.plain(),
            "times": self.times.plain(),
            "calibrations": {
                tested: {name: one.as_plain() for name, one in found.items()}
                for tested, found in self.calibrations.items()
            },
        }


@dataclass(frozen=True, slots=True)
class Hybrid:
    """How the sub-models are used together.

    Parameters
    ----------
    label
        Name of the hybrid in the rows.
    start
        Which sub-model an update starts with; only rules that look at nothing but the window.
    threshold_m
        The sender's threshold [m].
    """

    label: str
    start: Literal["order", "hindsight"] = "hindsight"
    _: KW_ONLY
    threshold_m: float = 0.3


def measure_coverage(
    groups: Mapping[str, Sequence[TripCase]],
    members: Sequence[AbstractSubModel],
    *,
    train: Sequence[TripCase] = (),
    thresholds_m: Sequence[float] = (0.2, 0.5),
    hybrid: Hybrid | None = None,
    stride: int = 5,
    progress: Callable[[int, int], None] | None = None,
) -> CoverageResult:
    """Calibrate on some trips and count on others.

    Parameters
    ----------
    groups
        Trips by the name of their group. Without `train`, each group is tested with what the others taught.
    members
        The sub-models, with distinct names.
    train
        Trips to learn from, all apart from the groups.
    thresholds_m
        Thresholds of the times [m].
    hybrid
        How they are used together, where that is to be counted too.
    stride
        Samples from one fit to the next.
    progress
        Called with trips done, over all sub-models and the hybrid, and their number.

    Raises
    ------
    ValueError
        Where there is nothing to learn from: one group alone and no `train`.
    """
    if len(groups) < 2 and not train:
        raise ValueError("one group of trips cannot be split: name several files, or trips to train on")
    every = sum(map(len, groups.values()))
    watch = _Watch(
        (every * 2 + len(train)) * len(members) + (every * len(members) if hybrid else 0), progress
    )
    rows: list[Row] = []
    times: list[Row] = []
    calibrations: dict[str, dict[str, Calibration]] = {name: {} for name in groups}
    for member in members:
        learnt = _calibrations(member, groups, train, stride=stride, watch=watch)
        for name, calibration in learnt.items():
            calibrations[name][member.name] = calibration
        parts = [_Part(case, member, learnt[name]) for name, cases in groups.items() for case in cases]
        rows += _coverage_rows(member.name, parts, stride)
        times += _time_rows(member.name, parts, thresholds_m, stride=4 * stride, watch=watch)
    if hybrid is not None:
        parts = _hybrid_parts(groups, members, calibrations, hybrid)
        rows += _coverage_rows(hybrid.label, parts, stride)
        times += _time_rows(hybrid.label, parts, thresholds_m, stride=4 * stride, watch=watch)
    return CoverageResult(COVERAGE.table(rows), TIMES.table(times), calibrations)


@dataclass(slots=True)
class _Watch:
    total: int
    progress: Callable[[int, int], None] | None
    done: int = 0

    def step(self) -> None:
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.total)


@dataclass(frozen=True, slots=True)
class _Part:
    """A trip with a sub-model and its calibration, and the samples at which it counts, (T,); None for all."""

    case: TripCase
    member: AbstractSubModel
    calibration: Calibration
    counts: BoolArray | None = None

    def errors(self, horizons_s: Sequence[float], stride: int) -> PredictionErrors:
        """Errors where it counts."""
        found = prediction_errors(self.case, self.member, horizons_s, stride=stride)
        if self.counts is None:
            return found
        return found.select(self.counts[fitted_at(self.case, self.member, stride)])


def _hybrid_parts(
    groups: Mapping[str, Sequence[TripCase]],
    members: Sequence[AbstractSubModel],
    calibrations: Mapping[str, Mapping[str, Calibration]],
    hybrid: Hybrid,
) -> list[_Part]:
    """Every sub-model with the samples at which an update would start with it."""
    parts: list[_Part] = []
    for name, cases in groups.items():
        for case in cases:
            ready = TripRuntime(case.seen, Bank(tuple(members)), case.estimator)
            # So short a silence makes the sender update at every sample.
            policy = ErrorDriven(
                hybrid.threshold_m,
                hybrid.start,
                "never",
                max_inter_transmit_time_s=0.5 * case.seen.dt_s,
            )
            in_use = ready.run(policy).in_use
            parts += [
                _Part(case, member, calibrations[name][member.name], in_use == m)
                for m, member in enumerate(members)
            ]
    return parts


def _calibrations(
    member: AbstractSubModel,
    groups: Mapping[str, Sequence[TripCase]],
    train: Sequence[TripCase],
    *,
    stride: int,
    watch: _Watch,
) -> dict[str, Calibration]:
    """What each group is tested with."""

    def errors(cases: Sequence[TripCase]) -> list[PredictionErrors]:
        found: list[PredictionErrors] = []
        for case in cases:
            found.append(prediction_errors(case, member, stride=stride))
            watch.step()
        return found

    if train:
        one = calibrate(pooled_errors(errors(train)))
        return dict.fromkeys(groups, one)
    parts = {name: errors(cases) for name, cases in groups.items()}
    return {
        name: calibrate(
            pooled_errors([part for other, own in parts.items() if other != name for part in own])
        )
        for name in groups
    }


def _coverage_rows(label: str, parts: Sequence[_Part], stride: int) -> list[Row]:
    horizons_s = np.array(HORIZONS_S)
    inside = np.zeros((len(FORMS), horizons_s.size, len(LEVELS)), dtype=np.int64)
    counted = np.zeros(horizons_s.size, dtype=np.int64)
    for part in parts:
        learned = np.stack([part.calibration.radius(level, horizons_s) for level in LEVELS], axis=1)
        radii = (gaussian_radius(LEVELS), gaussian_radius(LEVELS), learned)
        own = part.errors(HORIZONS_S, stride)
        nominal = own.covariance_m2 + _SMALLEST_M2 * np.eye(2)
        calibrated = part.calibration.scaled(own.covariance_m2, horizons_s)
        for form, covariance in enumerate((nominal, calibrated, calibrated)):
            reached = _radii(own.errors_m, covariance)
            inside[form] += (reached[:, :, None] <= radii[form]).sum(axis=0)
        counted += (~np.isnan(own.errors_m[:, :, 0])).sum(axis=0)
    return [
        COVERAGE.row(
            sub_model=label,
            form=form,
            horizon_s=float(horizons_s[h]),
            level=level,
            covered_ratio=float(inside[f, h, k] / counted[h]),
            errors=int(counted[h]),
        )
        for f, form in enumerate(FORMS)
        for h in range(horizons_s.size)
        if counted[h]
        for k, level in enumerate(LEVELS)
    ]


def _radii(errors_m: FloatArray, covariance_m2: FloatArray) -> FloatArray:
    """Mahalanobis radius of each error, NaN where there is none, (N, H)."""
    flat = mahalanobis(errors_m.reshape(-1, 2), covariance_m2.reshape(-1, 2, 2))
    return flat.reshape(errors_m.shape[:2])


def _time_rows(
    label: str, parts: Sequence[_Part], thresholds_m: Sequence[float], *, stride: int, watch: _Watch
) -> list[Row]:
    horizons_s = np.array(TIME_HORIZONS_S)
    expected: dict[tuple[str, float], list[FloatArray]] = {(f, th): [] for f in FORMS for th in thresholds_m}
    observed: dict[float, list[FloatArray]] = {threshold_m: [] for threshold_m in thresholds_m}
    for part in parts:
        own = part.errors(TIME_HORIZONS_S, stride)
        watch.step()
        whole = ~np.isnan(own.errors_m[:, :, 0]).any(axis=1)
        length_m = np.hypot(own.errors_m[whole, :, 0], own.errors_m[whole, :, 1])
        nominal = own.covariance_m2[whole]
        calibrated = part.calibration.scaled(nominal, horizons_s)
        radii = part.calibration.level_radii(horizons_s)
        believed = ((nominal, None), (calibrated, None), (calibrated, radii))
        for threshold_m in thresholds_m:
            observed[threshold_m].append(_observed_s(length_m, horizons_s, threshold_m))
            for form, (covariance, own_radii) in zip(FORMS, believed, strict=True):
                expected[form, threshold_m].append(
                    expected_time_to_threshold(covariance, horizons_s, threshold_m, radii=own_radii)
                )
    return [
        _time_row(
            label,
            form,
            threshold_m,
            np.concatenate(expected[form, threshold_m]),
            np.concatenate(observed[threshold_m]),
        )
        for form in FORMS
        for threshold_m in thresholds_m
    ]


def _observed_s(length_m: FloatArray, horizons_s: FloatArray, threshold_m: float) -> FloatArray:
    """Horizon at which each error first reaches the threshold, straight between horizons, (N,) [s]."""
    out = length_m >= threshold_m
    first: IntArray = np.argmax(out, axis=1)
    rows = np.arange(len(first))
    before_m = np.where(first > 0, length_m[rows, np.maximum(first - 1, 0)], 0.0)
    before_s = np.where(first > 0, horizons_s[np.maximum(first - 1, 0)], 0.0)
    share = (threshold_m - before_m) / np.maximum(length_m[rows, first] - before_m, 1e-9)
    crossed_s = before_s + np.clip(share, 0.0, 1.0) * (horizons_s[first] - before_s)
    return np.where(out.any(axis=1), crossed_s, horizons_s[-1])


def _time_row(
    sub_model: str, form: str, threshold_m: float, expected_s: FloatArray, observed_s: FloatArray
) -> Row:
    figures = dict.fromkeys(("expected_s", "observed_s", "rank_correlation"), np.nan)
    if observed_s.size:
        # A covariance that is the same at every instant must not be ranked by its rounding.
        one, other = _ranks(expected_s.round(6)), _ranks(observed_s)
        varies = np.ptp(one) > 0 and np.ptp(other) > 0
        figures = {
            "expected_s": float(expected_s.mean()),
            "observed_s": float(observed_s.mean()),
            "rank_correlation": float(np.corrcoef(one, other)[0, 1]) if varies else np.nan,
        }
    return TIMES.row(
        sub_model=sub_model, form=form, threshold_m=threshold_m, **figures, instants=observed_s.size
    )


def _ranks(values: FloatArray) -> FloatArray:
    """Ranks from 1, those of equal values being their mean, (K,)."""
    _, which, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - 0.5 * (count - 1))[which]

"""Claims about calibration and coverage: learnt on some trips, counted on others."""

import numpy as np
import pytest

from modelcast.models.calibration import LEVELS
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.study.case import TripCase, make_case
from modelcast.study.coverage import Hybrid, measure_coverage
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.calibration import (
    PredictionErrors,
    calibrate,
    fitted_at,
    mahalanobis,
    pooled_calibrations,
    pooled_errors,
    prediction_errors,
    train_calibrations,
)
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

ROUNDING = 1e-9
"""The error that a quantile is made of must not fall outside by rounding."""


def drives(*seeds: int) -> list[TripCase]:
    settings = EvaluationSettings(protocol="sensor")
    return [make_case(generate_drive(seed=seed, duration_s=150.0).truth, settings) for seed in seeds]


def gaussian_errors(count: int, spread_m: tuple[float, float]) -> PredictionErrors:
    rng = np.random.default_rng(4)
    errors = rng.normal(0.0, 1.0, (count, 2, 2)) * np.array(spread_m) * np.array([[1.0], [2.0]])
    return PredictionErrors("cv", np.array([1.0, 2.0]), errors, np.tile(np.eye(2), (count, 2, 1, 1)))


def test_of_gaussian_errors_the_spread_is_found_and_the_radii_are_the_gaussians() -> None:
    table = calibrate(gaussian_errors(40_000, (3.0, 0.5)))
    covariance = table.scaled(np.tile(np.eye(2), (1, 2, 1, 1)), np.array([1.0, 2.0]))[0]
    assert np.sqrt(covariance[:, 0, 0]) == pytest.approx([3.0, 6.0], rel=0.03)
    assert np.sqrt(covariance[:, 1, 1]) == pytest.approx([0.5, 1.0], rel=0.03)
    assert table.radii == pytest.approx(np.tile([1.177, 2.146, 2.448], (2, 1)), rel=0.03)


def test_one_wild_error_in_a_hundred_changes_little() -> None:
    clean = gaussian_errors(5000, (1.0, 1.0))
    wild = clean.errors_m.copy()
    wild[::100] *= 1000.0
    spoilt = calibrate(PredictionErrors("cv", clean.horizons_s, wild, clean.covariance_m2))
    assert spoilt.factors == pytest.approx(calibrate(clean).factors, rel=0.1)


def test_on_its_own_training_errors_every_level_is_exact(drive: Trajectory) -> None:
    case = make_case(drive, EvaluationSettings(protocol="sensor"))
    errors = prediction_errors(case, ConstantTurnRateAcceleration(), stride=2)
    table = calibrate(errors)
    for h, horizon_s in enumerate(table.horizons_s):
        known = ~np.isnan(errors.errors_m[:, h, 0])
        own = table.scaled(errors.covariance_m2[:, h : h + 1], np.array([horizon_s]))[known, 0]
        radius = mahalanobis(errors.errors_m[known, h], own)
        shares = (radius[:, None] <= table.radii[h] * (1.0 + ROUNDING)).mean(axis=0)
        assert shares == pytest.approx(LEVELS, abs=2.0 / known.sum())


def test_errors_are_predictions_less_what_is_later_true(gapped_case: TripCase) -> None:
    """In length, since turning changes none; and none reaches over a gap."""
    model = ConstantVelocity()
    found = prediction_errors(gapped_case, model, (0.3, 1.0), stride=1)
    trip = gapped_case.truth
    count = 0
    for row in range(0, len(trip), 7):
        for h, steps in enumerate((3, 10)):
            later = row + steps
            same_part = later < len(trip) and trip.segment_start[later] == trip.segment_start[row]
            assert np.isnan(found.errors_m[row, h, 0]) == (not same_part)
            if same_part:
                assert trip.speed_mps is not None
                assert trip.heading_rad is not None
                heading = trip.heading_rad[row]
                velocity = trip.speed_mps[row] * np.array([np.sin(heading), np.cos(heading)])
                off = trip.position_m[row] + 0.1 * steps * velocity - trip.position_m[later]
                assert np.hypot(*found.errors_m[row, h]) == pytest.approx(np.hypot(*off), abs=1e-6)
                count += 1
    assert count > 200


def test_training_is_repeatable_and_counts_its_progress() -> None:
    cases = drives(1, 2)
    members = [ConstantVelocity(), GaussianProcess(form="intercept", noise_floor_m=0.01)]
    calls: list[tuple[int, int]] = []
    one = train_calibrations(cases, members, progress=lambda done, total: calls.append((done, total)))
    other = train_calibrations(cases, members)
    assert {name: table.as_plain() for name, table in one.items()} == {
        name: table.as_plain() for name, table in other.items()
    }
    assert calls == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_too_few_errors_are_refused() -> None:
    with pytest.raises(ValueError, match="train on longer trips"):
        calibrate(gaussian_errors(20, (1.0, 1.0)))


def test_one_group_without_training_trips_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot be split"):
        measure_coverage({"one": drives(1)}, [ConstantVelocity()])


def test_on_other_drives_the_mapped_ellipses_come_nearest() -> None:
    """Ten generated drives of one kind, each tested with what the others taught."""
    groups = {str(seed): drives(seed) for seed in range(10)}
    calls: list[tuple[int, int]] = []
    result = measure_coverage(
        groups, [ConstantTurnRateAcceleration()], progress=lambda done, total: calls.append((done, total))
    )
    assert calls[-1] == (20, 20)
    off = {
        form: np.mean([abs(row.covered_ratio - row.level) for row in result.rows if row.form == form])
        for form in ("nominal", "calibrated", "mapped")
    }
    assert off["mapped"] < 0.03
    assert off["mapped"] < min(off["nominal"], off["calibrated"])
    for row in result.times:
        assert 0.0 < row.expected_s <= 5.0
        assert 0.0 < row.observed_s <= 5.0
    assert set(result.calibrations) == set(groups)


def test_a_hybrid_in_order_is_its_first_member() -> None:
    groups = {str(seed): drives(seed) for seed in (1, 2)}
    members = (ConstantTurnRateAcceleration(), ConstantVelocity())
    calls: list[tuple[int, int]] = []
    result = measure_coverage(
        groups,
        members,
        hybrid=Hybrid("both", "order"),
        progress=lambda done, total: calls.append((done, total)),
    )
    assert calls[-1] == (12, 12)
    first, both = (
        [row.replaced(sub_model="") for row in result.rows if row.sub_model == name]
        for name in ("ctra", "both")
    )
    assert both == first
    waits = [[row.observed_s for row in result.times if row.sub_model == name] for name in ("ctra", "both")]
    assert waits[0] == pytest.approx(waits[1])


def test_a_hybrid_in_hindsight_counts_every_instant_once_and_lasts_longer_than_its_worst() -> None:
    groups = {str(seed): drives(seed) for seed in (1, 2)}
    members = (ConstantVelocity(), ConstantTurnRateAcceleration())
    result = measure_coverage(groups, members, hybrid=Hybrid("both", threshold_m=0.5))
    errors = {(row.sub_model, row.horizon_s): row.errors for row in result.rows if row.form == "nominal"}
    assert all(errors["both", h] == errors["cv", h] for name, h in errors if name == "cv")
    lasts = {row.sub_model: row.observed_s for row in result.times if row.threshold_m == 0.5}
    assert lasts["cv"] < lasts["both"]


def test_folds_are_pooled_and_each_is_held_against_its_own_sub_model() -> None:
    one, other = drives(1), drives(2)
    first, second = (GaussianProcess(form="intercept", noise_floor_m=floor) for floor in (0.01, 0.05))
    found = pooled_calibrations([(one, [first]), (other, [second])])
    parts = [prediction_errors(one[0], first), prediction_errors(other[0], second)]
    assert found["gp-intercept"].as_plain() == calibrate(pooled_errors(parts)).as_plain()
    assert fitted_at(one[0], first, 5)[0] == 10


@pytest.mark.real
def test_half_a_fleet_of_real_cars_corrects_what_the_papers_process_believes(
    dynamic_trips: dict[str, Trajectory],
) -> None:
    settings = EvaluationSettings(protocol="recorded")
    cases = [make_case(trip, settings) for trip in dynamic_trips.values()]
    paper = GaussianProcess(form="anchored", noise_floor_m=1e-5)
    result = measure_coverage({"tested": cases[::2]}, [paper], train=cases[1::2])
    off = {
        form: np.mean([abs(row.covered_ratio - row.level) for row in result.rows if row.form == form])
        for form in ("nominal", "mapped")
    }
    assert off["mapped"] < 0.12, off
    assert off["nominal"] > 0.5, off

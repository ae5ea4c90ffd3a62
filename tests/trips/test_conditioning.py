"""Claims about the smoother that makes truth of a coarse recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.io.trips import read_trips
from modelcast.trips import conditioning_kernels as kernels
from modelcast.trips.conditioning import condition
from modelcast.trips.inspection import inspect
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

GRID_M = 0.5
RMS_BOUND_M = 0.10
"""A 0.5 m grid (0.20 m of noise on both axes together) with 1 Hz values must give truth this close."""

DENSE_TOLERANCE = 1e-6
"""Filter and dense solve differ by rounding only; the unknown start costs eight of sixteen digits."""


def coarse(trip: Trajectory, course_rad: FloatArray) -> Trajectory:
    """Recording of a trip on a grid, with speed and heading refreshed every tenth row."""
    assert trip.speed_mps is not None
    latest = _latest(trip)
    return replace(
        trip,
        position_m=np.round(trip.position_m / GRID_M) * GRID_M,
        speed_mps=trip.speed_mps[latest],
        heading_rad=course_rad[latest],
        acceleration_mps2=None,
        yaw_rate_radps=None,
    )


def _latest(trip: Trajectory) -> IntArray:
    at = np.arange(len(trip))
    return at - (at - trip.segment_start) % 10


def present(column: FloatArray | None) -> FloatArray:
    assert column is not None
    return column


def rms_m(a: Trajectory, b: Trajectory) -> float:
    return float(np.sqrt(((a.position_m - b.position_m) ** 2).sum(axis=1).mean()))


def dense_posterior(
    t: FloatArray, z: FloatArray, r: FloatArray, start: FloatArray, q: float
) -> tuple[FloatArray, float]:
    """Posterior mean of every state of one axis and the log-likelihood, by one big Gaussian."""
    n = t.size
    cov = np.zeros((3 * n, 3 * n))
    cov[:3, :3] = np.diag(start**2)
    for i in range(1, n):
        d = t[i] - t[i - 1]
        F = np.array([[1.0, d, d * d / 2], [0.0, 1.0, d], [0.0, 0.0, 1.0]])
        Q = q * np.array(
            [
                [d**5 / 20, d**4 / 8, d**3 / 6],
                [d**4 / 8, d**3 / 3, d**2 / 2],
                [d**3 / 6, d**2 / 2, d],
            ]
        )
        a, b = slice(3 * i - 3, 3 * i), slice(3 * i, 3 * i + 3)
        cov[b, : 3 * i] = F @ cov[a, : 3 * i]
        cov[: 3 * i, b] = cov[b, : 3 * i].T
        cov[b, b] = F @ cov[a, a] @ F.T + Q
    rows, components = np.nonzero(r >= 0.0)
    at = 3 * rows + np.minimum(components, 1)
    y, S = z[rows, components], cov[np.ix_(at, at)] + np.diag(r[rows, components])
    weight = np.linalg.solve(S, y)
    log_likelihood = -0.5 * (y @ weight + np.linalg.slogdet(2.0 * np.pi * S)[1])
    return (cov[:, at] @ weight).reshape(n, 3), float(log_likelihood)


@settings(derandomize=True, deadline=None, max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_smoother_and_likelihood_equal_the_dense_gaussian_posterior(seed: int) -> None:
    """Two parts, uneven steps, missing positions and velocities."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.08, 0.12, 14))
    bounds = np.array([0, 8, 14])
    z = rng.normal(0.0, 0.3, (14, 2, 3))
    r = np.where(rng.uniform(size=z.shape) < 0.7, rng.uniform(0.01, 0.1, z.shape), -1.0)
    r[:, :, 2] = -1.0
    start, q, added = np.array([3.0, 2.0, 1.0]), 0.7, np.array([0.2, 0.3])
    log_parameters, sums = np.log([q, *added]), np.empty((2, 2))
    out = np.empty((14, 2, 3))
    kernels.smooth(t, bounds, z, r, start, log_parameters, out)
    cost = kernels.negative_log_likelihood(t, bounds, z, r, start, log_parameters, sums)
    known = np.where(r >= 0.0, r + np.append(added, 0.0) ** 2, -1.0)
    expected = 0.0
    for axis in range(2):
        for part in (slice(0, 8), slice(8, 14)):
            mean, value = dense_posterior(t[part], z[part, axis], known[part, axis], start, q)
            np.testing.assert_allclose(out[part, axis], mean, atol=DENSE_TOLERANCE)
            expected += value
    assert cost == pytest.approx(-expected, abs=DENSE_TOLERANCE)
    assert sums[:, 1].tolist() == [(r[..., 0] >= 0).sum(), (r[..., 1] >= 0).sum()]


def test_the_search_finds_the_noises_that_made_the_data() -> None:
    """Truth drawn from the smoother's own model: fitted noises lie near, innovations are white."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 200.0, 0.1)
    jerk = rng.normal(0.0, np.sqrt(0.5 / 0.1), (t.size, 2))
    acceleration = np.cumsum(jerk, axis=0) * 0.1
    velocity = np.cumsum(acceleration, axis=0) * 0.1
    path = np.cumsum(velocity, axis=0) * 0.1
    measured = path + rng.normal(0.0, 0.2, path.shape)
    truth, how = condition(build_trajectory("made/1", t, measured))
    assert how.position_noise_m == pytest.approx(0.2, rel=0.05)
    assert how.jerk_density_m2ps5 == pytest.approx(0.5, rel=0.5)
    assert how.position_nis == pytest.approx(1.0, abs=0.1)
    assert np.sqrt(((truth.position_m - path) ** 2).sum(axis=1).mean()) < 0.5 * 0.2 * np.sqrt(2.0)


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 1000))
def test_a_grid_with_held_values_is_undone(seed: int) -> None:
    """Also at the hard brake and in the stops, where the grid alone would let a car wander."""
    clean = generate_drive(seed, duration_s=120.0).truth
    assert clean.heading_rad is not None
    truth, how = condition(coarse(clean, clean.heading_rad))
    assert rms_m(truth, clean) < RMS_BOUND_M
    assert np.hypot(*(truth.position_m - clean.position_m).T).max() < GRID_M
    assert how.velocity_rows < 0.15 * len(clean)
    rest = clean.speed_mps == 0.0
    middle = rest & np.roll(rest, 12) & np.roll(rest, -12)
    assert np.abs(np.diff(truth.position_m, axis=0))[middle[1:]].max() < 0.01


def test_extrapolated_positions_count_once_a_fix_and_at_the_time_of_the_fix() -> None:
    clean = generate_drive(5, duration_s=150.0).truth
    assert clean.speed_mps is not None
    assert clean.heading_rad is not None
    source = np.maximum(_latest(clean) - 2, 0)  # a fix is 0.2 s old when it is first recorded
    velocity = heading_to_velocity(clean.speed_mps, clean.heading_rad)[source]
    position = clean.position_m[source] + velocity * (clean.t_s - clean.t_s[source])[:, None]
    recorded = replace(
        clean,
        position_m=np.round(position / GRID_M) * GRID_M,
        speed_mps=clean.speed_mps[source],
        heading_rad=clean.heading_rad[source],
        acceleration_mps2=None,
        yaw_rate_radps=None,
    )
    truth, how = condition(recorded)
    assert how.coasted
    assert how.fix_age_s == pytest.approx(0.2)
    assert rms_m(truth, clean) < 0.4 * rms_m(recorded, clean)


def test_the_columns_of_the_truth_belong_together() -> None:
    clean = generate_drive(6, duration_s=100.0).truth
    assert clean.heading_rad is not None
    truth = condition(coarse(clean, clean.heading_rad))[0]
    assert truth.speed_mps is not None
    assert truth.heading_rad is not None
    assert truth.yaw_rate_radps is not None
    velocity = np.gradient(truth.position_m, truth.t_s, axis=0)
    moving = truth.speed_mps > 2.0
    along = heading_to_velocity(truth.speed_mps, truth.heading_rad)
    assert np.abs(velocity - along)[moving].max() < 0.1
    turned = wrap_angle_rad(np.diff(truth.heading_rad)) / np.diff(truth.t_s)
    assert np.abs(turned - truth.yaw_rate_radps[1:])[moving[1:]].max() < 0.05
    still = truth.speed_mps == 0.0
    assert np.ptp(np.unwrap(truth.heading_rad)[still & (truth.t_s < 60.0)]) == 0.0


def test_times_parts_and_names_are_kept_and_parts_do_not_touch_each_other() -> None:
    t = np.concatenate([np.arange(0.0, 20.0, 0.1), np.arange(30.0, 50.0, 0.1)])
    path = np.stack([10.0 * t, np.where(t > 25.0, 400.0, 0.0)], axis=1)
    trip = build_trajectory("made/1", t, np.round(path / GRID_M) * GRID_M)
    truth, _ = condition(trip)
    assert truth.trip_id == "made/1"
    assert np.array_equal(truth.t_s, trip.t_s)
    assert np.array_equal(truth.segments, trip.segments)
    assert np.abs(truth.position_m - path).max() < GRID_M


def test_a_repeated_position_is_no_measurement_while_the_car_moves_and_one_while_it_stands() -> None:
    clean = generate_drive(9, duration_s=100.0).truth
    at = np.arange(len(clean))
    repeated = replace(clean, position_m=clean.position_m[at - at % 2], speed_mps=None, heading_rad=None)
    truth, how = condition(repeated)
    moving = present(clean.speed_mps) > 2.0
    assert how.position_rows < 0.6 * len(clean)
    off = np.hypot(*(truth.position_m - clean.position_m).T)[:-2]  # the last repeat has no jump to show it
    assert off[moving[:-2]].max() < 0.05
    assert off.max() < 0.15


def test_a_speed_that_contradicts_the_positions_is_not_used() -> None:
    clean = generate_drive(7, duration_s=100.0).truth
    truth, how = condition(replace(clean, speed_mps=np.full(len(clean), 5.68)))
    assert how.velocity_rows == 0
    assert rms_m(truth, clean) < 0.02


@settings(derandomize=True, deadline=None, max_examples=6)
@given(count=st.integers(1, 8))
def test_a_trip_of_a_few_samples_is_conditioned_too(count: int) -> None:
    t = np.arange(0.0, 0.1 * count - 0.05, 0.1)
    truth, _ = condition(build_trajectory("made/1", t, np.stack([t, t], axis=1), speed_mps=np.ones(count)))
    assert len(truth) == count


def test_conditioning_is_deterministic() -> None:
    seen = generate_drive(8, duration_s=100.0).input
    first, second = condition(seen), condition(seen)
    assert first[1] == second[1]
    assert first[0].position_m.tobytes() == second[0].position_m.tobytes()


@pytest.mark.real
def test_the_spmd_log_becomes_smooth_with_white_innovations(data_folder: Path) -> None:
    trip = next(iter(read_trips(data_folder / "spmd" / "bsm_p1_dev.csv")))
    truth, how = condition(trip)
    assert inspect(trip).noise_p50_m > 0.3
    assert inspect(truth).noise_p95_m < 0.01
    assert how.coasted
    assert how.position_nis == pytest.approx(1.0, abs=0.15)
    assert how.velocity_nis == pytest.approx(1.0, abs=0.15)
    assert how.velocity_noise_mps < 0.3
    assert how.correction_rms_m < 1.0
    assert truth.acceleration_mps2 is not None
    assert np.abs(truth.acceleration_mps2).max() < 4.0


@pytest.mark.real
@pytest.mark.parametrize("name", ["no_ACC__handling_part22", "short_setting__dynamic_part12"])
def test_real_trips_come_back_from_a_grid_with_held_values(data_folder: Path, name: str) -> None:
    errors: list[float] = []
    for trip in read_trips(data_folder / "openacc_zalazone" / f"{name}.csv"):
        if len(errors) == 4:
            break
        velocity = np.gradient(trip.position_m, trip.t_s, axis=0)
        course = np.arctan2(velocity[:, 0], velocity[:, 1])
        errors.append(rms_m(condition(coarse(trip, course))[0], trip))
    assert max(errors) < RMS_BOUND_M


def test_an_inspection_that_is_there_already_changes_nothing() -> None:
    drive = generate_drive(seed=1, duration_s=90.0).truth
    assert drive.heading_rad is not None
    recorded = coarse(drive, drive.heading_rad)
    alone, how = condition(recorded)
    known, again = condition(recorded, inspect(recorded))
    assert how == again
    assert np.array_equal(alone.position_m, known.position_m)

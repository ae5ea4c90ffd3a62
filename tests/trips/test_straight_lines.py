"""Claims about slow fixes joined by straight lines."""

from pathlib import Path

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.trips.inspection import inspect
from modelcast.trips.straight_lines import MAX_JOINED_CURVATURE_RATIO, straight_lines
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

ROUNDING_M = 1e-9


def drive(rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """The generated drive at a rate."""
    truth = generate_drive(seed=5, duration_s=240.0).truth
    t = np.arange(0.0, truth.t_s[-1], 1.0 / rate_hz)
    return t, curve(truth, t)


def curve(truth: Trajectory, t_s: FloatArray) -> FloatArray:
    """The drive between its samples: by velocity and acceleration, not by straight lines."""
    at = np.clip(np.searchsorted(truth.t_s, t_s), 1, len(truth) - 1)
    u = (t_s - truth.t_s[at - 1])[:, None]
    step = truth.dt_s
    velocity = np.gradient(truth.position_m, step, axis=0)
    a, b = truth.position_m[at - 1], truth.position_m[at]
    va, vb = velocity[at - 1], velocity[at]
    s = u / step
    hermite = (2 * s**3 - 3 * s**2 + 1) * a + (s**3 - 2 * s**2 + s) * step * va
    return hermite + (3 * s**2 - 2 * s**3) * b + (s**3 - s**2) * step * vb


def joined(t: FloatArray, path: FloatArray, period_s: float, phase_s: float = 0.0) -> FloatArray:
    """The path as fixes of a period, joined by straight lines."""
    fixes = np.arange(phase_s - period_s, t[-1] + 2.0 * period_s, period_s)
    held = [np.interp(fixes, t, path[:, axis]) for axis in (0, 1)]
    return np.stack([np.interp(t, fixes, one) for one in held], axis=1)


def period_s(t: FloatArray, path: FloatArray) -> float:
    return straight_lines(build_trajectory("made/1", t, path)).period_s


@pytest.mark.parametrize("period", [0.2, 0.3, 0.5, 0.7, 1.0, 2.0, 3.3, 5.0])
@pytest.mark.parametrize("phase", [0.0, 0.1])
def test_joined_fixes_of_any_period_are_found_on_a_grid_of_ten_hertz(period: float, phase: float) -> None:
    t, path = drive(10.0)
    assert period_s(t, joined(t, path, period, phase)) == pytest.approx(period, rel=0.05)


@pytest.mark.parametrize(
    ("rate_hz", "period"), [(5.0, 1.0), (9.65, 1.0), (12.5, 0.5), (18.0, 1.0), (25.0, 0.2), (50.0, 1.0)]
)
@pytest.mark.parametrize("phase", [0.0, 0.037])
def test_so_are_they_on_other_grids_and_between_their_samples(
    rate_hz: float, period: float, phase: float
) -> None:
    t, path = drive(rate_hz)
    assert np.isfinite(period_s(t, joined(t, path, period, phase)))


@pytest.mark.parametrize("period", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("rounded_m", [0.0, 0.01])
def test_a_centimetre_of_noise_or_of_rounding_on_top_hides_nothing(period: float, rounded_m: float) -> None:
    t, path = drive(10.0)
    noisy = joined(t, path, period, 0.03)
    if rounded_m:
        noisy = np.round(noisy / rounded_m) * rounded_m
    else:
        noisy = noisy + np.random.default_rng(1).normal(0.0, 0.01, noisy.shape)
    found = straight_lines(build_trajectory("made/1", t, noisy))
    assert found.curvature_ratio < MAX_JOINED_CURVATURE_RATIO
    assert found.period_s == pytest.approx(period, rel=0.05)


def test_fixes_at_uneven_times_are_found_by_their_corners() -> None:
    t, path = drive(10.0)
    fixes = np.cumsum(np.random.default_rng(2).uniform(0.7, 1.4, 400))
    held = [np.interp(fixes, t, path[:, axis]) for axis in (0, 1)]
    lines = np.stack([np.interp(t, fixes, one) for one in held], axis=1)
    kept = t < min(t[-1], fixes[-1])
    assert period_s(t[kept], lines[kept]) == pytest.approx(1.05, abs=0.15)


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 9.65, 10.0, 18.0, 50.0])
@pytest.mark.parametrize("error_m", [0.0, 0.005, 0.05, 1.0])
def test_honest_drives_are_not_called_joined_with_or_without_noise(rate_hz: float, error_m: float) -> None:
    t, path = drive(rate_hz)
    noisy = path + np.random.default_rng(3).normal(0.0, error_m, path.shape)
    assert np.isnan(period_s(t, noisy))


@pytest.mark.parametrize("speed_mps", [9.987, 10.03, 13.377])
@pytest.mark.parametrize("decimals", [1, 2, 3])
def test_rounding_a_smooth_path_makes_corners_of_its_own_that_are_no_fixes(
    speed_mps: float, decimals: int
) -> None:
    t = np.arange(0.0, 60.0, 0.1)
    path = np.stack([speed_mps * t + 0.03 * t**2, 0.3 * speed_mps * t], axis=1)
    assert np.isnan(period_s(t, path.round(decimals)))


def test_a_drive_that_cannot_tell_is_not_judged() -> None:
    t = np.arange(0.0, 60.0, 0.1)
    standing = straight_lines(build_trajectory("made/1", t, np.zeros((t.size, 2))))
    assert np.isnan(standing.straight_ratio)
    assert np.isnan(standing.curvature_ratio)
    steady = straight_lines(build_trajectory("made/1", t, np.stack([10.0 * t, 0.0 * t], axis=1)))
    assert (steady.straight_ratio, steady.corner_ratio) == (1.0, 0.0)
    assert np.isnan(steady.period_s)
    assert np.isnan(period_s(t[:3], np.zeros((3, 2))))


@pytest.mark.slow
def test_no_trip_of_the_development_data_is_called_joined(data_folder: Path) -> None:
    """All are honest; positions that a unit extrapolates from 1 Hz are found by another test."""
    found = {trip.trip_id: straight_lines(trip) for trip in read_trips(data_folder)}
    assert [name for name, one in found.items() if np.isfinite(one.period_s)] == []
    assert (
        min(one.curvature_ratio for one in found.values() if one.curvature_ratio == one.curvature_ratio) > 0.7
    )
    assert max(one.corner_ratio for one in found.values() if one.corner_ratio == one.corner_ratio) < 0.02


def test_joining_the_development_data_is_found_in_every_long_moving_trip(data_folder: Path) -> None:
    for trip in read_trips(data_folder / "openacc_zalazone" / "short_setting__dynamic_part12.csv"):
        whole = build_trajectory(trip.trip_id, trip.t_s, joined(trip.t_s, trip.position_m, 1.0))
        assert inspect(whole).fix_period_s == pytest.approx(1.0, rel=0.05)

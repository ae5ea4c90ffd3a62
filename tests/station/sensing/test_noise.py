"""Claims about the causal estimate of position noise."""

from dataclasses import replace
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.station.sensing.noise import DEFAULT_NOISE, NoiseEstimator, clipped_share
from modelcast.station.sensing.sensing import position_noise_m, sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.sensors import SensorModel, sense

PERIOD_S = 60.0
ESTIMATORS = [DEFAULT_NOISE, NoiseEstimator("third", order=3), NoiseEstimator("slow", span_s=30.0)]

SCATTER_RATIO = 0.2
"""Of the estimate over its last 4 s: four standard errors of some 80 squares, themselves correlated."""

ROUNDING_RATIO = 1e-6
"""A fourth difference of metres keeps ten digits or more of a millimetre."""


def noisy(noise_m: float, *, dt_s: float = 0.1, seed: int = 0, shift_m: float = 0.0) -> Trajectory:
    """A car on a bend of 60 m radius that brakes and speeds up, with white noise."""
    t = np.arange(0.0, PERIOD_S, dt_s)
    angle = (12.0 * t + 6.0 * np.sin(0.5 * t)) / 60.0
    position = 60.0 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    position += noise_m * np.random.default_rng(seed).standard_normal(position.shape)
    return build_trajectory("made/1", t, position + shift_m)


@pytest.mark.parametrize("dt_s", [0.1, 0.2])
@pytest.mark.parametrize("noise_m", [0.001, 0.01, 0.1, 0.5])
def test_white_noise_is_read_right(noise_m: float, dt_s: float) -> None:
    found = position_noise_m(noisy(noise_m, dt_s=dt_s)) / noise_m
    settled = found[found.size // 4 :]
    assert np.median(settled) == pytest.approx(1.0, rel=0.1)
    assert (np.abs(settled - 1.0) < SCATTER_RATIO).mean() > 0.8


def test_clipping_leaves_no_bias() -> None:
    """Averaged over 100 s and then the last ten minutes; a mean of squares then scatters by 1 %."""
    for clip in (2.0, 4.0, 50.0):
        estimator = NoiseEstimator("long", clip=clip, span_s=100.0)
        t = np.arange(0.0, 1200.0, 0.1)
        white = np.random.default_rng(4).standard_normal((t.size, 2))
        found = position_noise_m(build_trajectory("made/1", t, white), estimator)
        assert found[6000:].mean() == pytest.approx(1.0, rel=0.03)


def test_the_clipped_share_solves_its_equation() -> None:
    drawn = np.random.default_rng(5).exponential(size=200_000)
    for clip in (1.5, 3.0, 10.0):
        share = clipped_share(clip)
        assert np.minimum(drawn, clip * share).mean() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_one_wrong_position_raises_the_estimate_by_the_binomials_of_its_order(order: int) -> None:
    """Unclipped, the squares add up to ``C(2k, k)``, which is the noise gain: one square of the jump."""
    t = np.arange(0.0, 20.0, 0.1)
    position = np.zeros((t.size, 2))
    position[100, 0] = 1.0
    estimator = NoiseEstimator("wide", order=order, clip=1e12, prior_samples=1.0, prior_m=1e-9, span_s=1e6)
    found = position_noise_m(build_trajectory("made/1", t, position), estimator)
    seen = order + 1  # the other differences are exactly zero, which a frozen receiver sends
    assert found[-1] ** 2 * (seen + 1) == pytest.approx(0.5, rel=1e-6)
    weights = np.array([comb(order, a) for a in range(order + 1)])
    assert (weights**2).sum() == comb(2 * order, order)


@given(now=st.integers(0, 598), jump_m=st.floats(-100.0, 100.0))
def test_the_future_changes_no_estimate(now: int, jump_m: float) -> None:
    trip = noisy(0.01)
    position = trip.position_m.copy()
    position[now + 1 :] += jump_m
    changed = replace(trip, position_m=position)
    before, after = (position_noise_m(one)[: now + 1] for one in (trip, changed))
    assert np.array_equal(before, after)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda one: one.name)
def test_scaling_the_track_and_the_prior_scales_the_estimate(estimator: NoiseEstimator) -> None:
    trip = noisy(0.02)
    larger = replace(trip, position_m=8.0 * trip.position_m)
    scaled = position_noise_m(larger, replace(estimator, prior_m=8.0 * estimator.prior_m))
    assert scaled == pytest.approx(8.0 * position_noise_m(trip, estimator), rel=ROUNDING_RATIO)


@given(angle=st.floats(-7.0, 7.0), east_m=st.floats(-1e4, 1e4), north_m=st.floats(-1e4, 1e4))
def test_moving_and_turning_the_frame_changes_nothing(angle: float, east_m: float, north_m: float) -> None:
    trip = noisy(0.02)
    here, there = (position_noise_m(one) for one in (trip, trip.moved(angle, (east_m, north_m))))
    assert there == pytest.approx(here, rel=ROUNDING_RATIO)


def test_no_polynomial_below_the_order_is_noise_however_uneven_the_steps() -> None:
    rng = np.random.default_rng(7)
    t = np.cumsum(0.1 + 0.02 * rng.uniform(-1.0, 1.0, 300))
    position = np.stack([20.0 * t - 3.0 * t**2 + 0.1 * t**3, 5.0 + 0.02 * t**3], axis=1)
    trip = build_trajectory("made/1", t, position)
    assert np.ptp(np.diff(trip.t_s)) > 0.03
    assert position_noise_m(trip, replace(DEFAULT_NOISE, prior_m=1e-12)).max() < 1e-9


def test_a_part_starts_with_what_was_known_before() -> None:
    whole = noisy(0.05)
    late = replace(
        whole, t_s=whole.t_s + np.where(np.arange(600) >= 300, 30.0, 0.0), segments=np.array([0, 300, 600])
    )
    found = position_noise_m(late)
    assert np.array_equal(found[:300], position_noise_m(whole)[:300])
    assert (found[300:304] == found[299]).all()
    assert found[304] != found[299]
    assert (found[:4] == pytest.approx(DEFAULT_NOISE.prior_m)) is True


def test_a_receiver_that_repeats_its_position_tells_nothing() -> None:
    trip = noisy(0.05)
    position = np.where(np.arange(600)[:, None] < 300, trip.position_m, trip.position_m[299])
    found = position_noise_m(replace(trip, position_m=position))
    assert (found[304:] == found[303]).all()


def test_one_jump_of_the_receiver_passes() -> None:
    """Unclipped, a jump of 5 m would lift the estimate to 0.5 m and hold it up for seconds."""
    trip = noisy(0.01)
    position = trip.position_m.copy()
    position[300:] += 5.0
    found = position_noise_m(replace(trip, position_m=position))
    assert found[300:].max() < 0.02


def test_growing_noise_is_followed() -> None:
    trip = noisy(0.01)
    position = trip.position_m.copy()
    position[300:] += 0.3 * np.random.default_rng(9).standard_normal((300, 2))
    found = position_noise_m(replace(trip, position_m=position))
    assert found[-1] == pytest.approx(0.3, rel=SCATTER_RATIO)


@pytest.mark.parametrize(
    ("field", "value"),
    [("order", 1), ("order", 7), ("span_s", 0.0), ("prior_m", np.nan), ("prior_samples", 0.0), ("clip", 1.0)],
)
def test_settings_out_of_range_are_refused(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{field} must"):
        replace(DEFAULT_NOISE, **{field: value})


@pytest.mark.real
@pytest.mark.parametrize("every", [1, 2], ids=["10 Hz", "5 Hz"])
def test_noise_added_to_real_trips_is_read_right(dynamic_trips: dict[str, Trajectory], every: int) -> None:
    """Nine cars; the tenth (BMW_I3) was recorded with 2 cm of noise of its own."""
    for noise_m in (0.001, 0.01, 0.1, 0.5):
        ratios = []
        for seed, (name, trip) in enumerate(sorted(dynamic_trips.items())):
            if name == "BMW_I3":
                continue
            keep = slice(None, None, every)
            truth = build_trajectory(trip.trip_id, trip.t_s[keep], trip.position_m[keep])
            seen = sense(truth, SensorModel(position_noise_m=noise_m), np.random.default_rng(seed))
            samples = sample_matrix(seen, velocity_estimator_for(seen))
            ratios.append(samples[50:, 6] / noise_m)
        pooled = np.concatenate(ratios)
        assert np.median(pooled) == pytest.approx(1.0, rel=0.1)
        within = (np.abs(pooled - 1.0) < SCATTER_RATIO).mean()
        assert within > (0.7 if noise_m == 0.001 else 0.85)


@pytest.mark.real
def test_real_trips_as_recorded_are_told_apart(dynamic_trips: dict[str, Trajectory]) -> None:
    """Nine receivers have well under 1 mm of white noise, one has 1-2 cm."""
    for name, trip in dynamic_trips.items():
        median_m = np.median(position_noise_m(trip))
        assert (0.008 < median_m < 0.03) if name == "BMW_I3" else median_m < 0.001

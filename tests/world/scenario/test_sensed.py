"""Claims about what a fleet sees of itself."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.world.scenario.base import STEP_S, FleetFrame
from modelcast.world.scenario.sensed import FleetSensor, sensed
from modelcast.world.sensors import IDEAL, SensorModel

COUNT = 400


def made(t_s: float, *, identity: int = 0, speed: float = 10.0, there: bool = True) -> FleetFrame:
    """Vehicles that drive east at a speed, all from the origin."""
    full = np.full(COUNT, 1.0 if there else 0.0)
    return FleetFrame(
        t_s,
        np.stack([full * speed * t_s, 0.0 * full], axis=1),
        speed_mps=full * speed,
        heading_rad=full * 0.5 * np.pi,
        acceleration_mps2=0.0 * full,
        yaw_rate_radps=0.0 * full,
        length_m=full * 4.5,
        vehicle_id=(np.arange(COUNT) + identity if there else np.full(COUNT, -1)).astype(np.int64),
        active=full > 0.0,
    )


def run(model: SensorModel, frames: list[FleetFrame], seed: int = 1) -> list[FleetFrame]:
    return [seen for _, seen in sensed(frames, model, np.random.default_rng(seed))]


def test_noise_has_the_sizes_of_the_model() -> None:
    model = SensorModel(position_noise_m=0.3, speed_noise_mps=0.2, heading_noise_rad=0.01)
    frames = [made(k * STEP_S) for k in range(50)]
    seen = run(model, frames)
    position = np.array([s.position_m - f.position_m for s, f in zip(seen, frames, strict=True)])
    heading = np.array([s.heading_rad - f.heading_rad for s, f in zip(seen, frames, strict=True)])
    speed = np.array([s.speed_mps - f.speed_mps for s, f in zip(seen, frames, strict=True)])
    assert position.std() == pytest.approx(0.3, rel=0.02)
    assert speed.std() == pytest.approx(0.2, rel=0.02)
    assert heading.std() == pytest.approx(0.01, rel=0.02)
    assert abs(np.mean(position[1:] * position[:-1])) < 0.05 * 0.3**2


def test_the_slow_error_is_stationary_and_decays_with_its_correlation_time() -> None:
    model = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=2.0)
    frames = [made(k * STEP_S) for k in range(41)]
    error = np.array([s.position_m - f.position_m for s, f in zip(run(model, frames), frames, strict=True)])
    assert error[0].std() == pytest.approx(0.5, rel=0.1)
    assert error[40].std() == pytest.approx(0.5, rel=0.1)
    later = np.mean(error[20] * error[0]) / 0.25
    assert later == pytest.approx(np.exp(-1.0), abs=0.12)


def test_a_vehicle_that_takes_a_slot_has_errors_of_its_own() -> None:
    model = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=1e6)
    first, second = run(model, [made(0.0), made(0.1, identity=1000)])
    one, other = first.position_m, second.position_m - [1.0, 0.0]
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.2


@pytest.mark.parametrize("latency_s", [0.1, 0.15, 0.32])
def test_latency_shows_the_past_but_not_before_the_first_frame(latency_s: float) -> None:
    seen = run(replace(IDEAL, latency_s=latency_s), [made(k * STEP_S) for k in range(10)])
    for k, frame in enumerate(seen):
        expected = 10.0 * max(k * STEP_S - latency_s, 0.0)
        np.testing.assert_allclose(frame.position_m[:, 0], expected, atol=1e-9)
        assert frame.t_s == k * STEP_S


def test_a_late_comer_shows_its_own_first_frame_first() -> None:
    frames = [made(0.0), made(0.1), made(0.2, identity=1000), made(0.3, identity=1000)]
    seen = run(replace(IDEAL, latency_s=0.2), frames)
    np.testing.assert_allclose(seen[2].position_m[:, 0], 2.0)
    np.testing.assert_allclose(seen[3].position_m[:, 0], 2.0)


def test_a_slow_vehicle_holds_its_heading() -> None:
    model = SensorModel(heading_noise_rad=0.1)
    seen = run(model, [made(0.0), made(0.1, speed=0.2), made(0.2, speed=0.2), made(0.3)])
    assert (seen[1].heading_rad == seen[0].heading_rad).all()
    assert (seen[2].heading_rad == seen[0].heading_rad).all()
    assert (seen[3].heading_rad != seen[0].heading_rad).all()


def test_empty_slots_stay_empty_and_speed_is_never_negative() -> None:
    model = SensorModel(slow_position_noise_m=1.0, speed_noise_mps=2.0)
    seen = run(model, [made(0.0, there=False), made(0.1, speed=0.0)])
    for name in ("position_m", "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"):
        assert not getattr(seen[0], name).any()
    assert seen[1].speed_mps.min() == 0.0


def test_two_models_through_one_seed_differ_by_their_sizes_only() -> None:
    frames = [made(0.0), made(0.1)]
    small, large = (run(SensorModel(position_noise_m=size), frames)[1] for size in (0.1, 0.3))
    truth = frames[1].position_m
    np.testing.assert_allclose(3.0 * (small.position_m - truth), large.position_m - truth, atol=1e-9)


def test_time_must_increase_and_slots_must_fit() -> None:
    sensor = FleetSensor(IDEAL)
    _, state = sensor.sense(sensor.init(COUNT, np.random.default_rng(0)), made(0.0))
    with pytest.raises(ValueError, match="later"):
        sensor.sense(state, made(0.0))
    with pytest.raises(ValueError, match="slots"):
        sensor.sense(sensor.init(3, np.random.default_rng(0)), made(0.0))

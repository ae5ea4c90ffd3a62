"""Claims about the learned sub-model: what it looks at, and what it makes of it."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.models.base import Windows
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import FeatureMap, LearnedTrajectory, Perceptron
from modelcast.models.learned.learned_trajectory import feature_constants
from modelcast.study.training.cut_kernels import trip_features

FEATURES = FeatureMap(20)
INPUTS = FEATURES.inputs
ROUNDING = 1e-9
"""Derivatives of high-degree fits multiply the rounding of positions by up to 1e6."""


def network(up_to_noise_m: float = np.inf, *, seed: int = 0, outputs: int = 6) -> Perceptron:
    rng = np.random.default_rng(seed)
    return Perceptron(
        up_to_noise_m,
        centre=rng.normal(size=INPUTS),
        width=rng.uniform(0.5, 2.0, INPUTS),
        weights_1=rng.normal(size=(INPUTS, 8)) / 10,
        bias_1=rng.normal(size=8),
        weights_2=rng.normal(size=(8, 5)),
        bias_2=rng.normal(size=5),
        weights_3=rng.normal(size=(5, outputs)),
        bias_3=rng.normal(size=outputs),
    )


def windows(count: int = 20, length: int = 21, dt_s: float = 0.1) -> Windows:
    """Smooth windows of cars that move at 5 m/s or more, with a noise of 1 mm to 10 cm."""
    rng = np.random.default_rng(3)
    t = (np.arange(1 - length, 1) * dt_s)[None, :, None]
    heading = rng.uniform(-np.pi, np.pi, count)
    velocity = (rng.uniform(5.0, 30.0, count) * np.stack([np.cos(heading), np.sin(heading)])).T[:, None]
    acceleration = rng.normal(0.0, 1.0, (count, 1, 2))
    position = velocity * t + acceleration * t**2 / 2
    moving = velocity + acceleration * t
    rates = rng.normal(0.0, 0.3, (count, 1, 2)) * np.ones((1, length, 1))
    noise = rng.choice([0.001, 0.01, 0.1], (count, 1, 1)) * np.ones((1, length, 1))
    return Windows(np.concatenate([position, moving, rates, noise], axis=2), dt_s=dt_s)


def inputs_of(given: Windows) -> FloatArray:
    found = np.empty((len(given.samples), INPUTS))
    constants = feature_constants(FEATURES, given.dt_s)
    for row, window in enumerate(given.samples):
        trip_features(window, np.array([len(window) - 1]), len(window), constants, found[row : row + 1])
    return found


def mirrored(given: Windows) -> Windows:
    """The same windows with east for west: turns change their sign."""
    return replace(given, samples=given.samples * np.array([-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0]))


def test_a_mirrored_window_has_the_inputs_times_their_signs() -> None:
    given = windows()
    assert inputs_of(mirrored(given)) == pytest.approx(inputs_of(given) * FEATURES.mirrors, abs=1e-6)


def test_turning_the_frame_turns_the_prediction() -> None:
    given, model, angle = windows(), LearnedTrajectory((network(),), 3), 1.1
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    samples = given.samples.copy()
    samples[..., :2], samples[..., 2:4] = samples[..., :2] @ turn, samples[..., 2:4] @ turn
    horizons_s = np.array([0.5, 2.0])
    straight = model.predict(model.fit(given), horizons_s, dt_s=0.1)
    turned = model.predict(model.fit(replace(given, samples=samples)), horizons_s, dt_s=0.1)
    assert turned == pytest.approx(straight @ turn, abs=1e-6)


def test_the_second_derivative_of_a_steady_acceleration_is_read_off_exactly() -> None:
    """Along the course of a straight 2 m/s², every fit of degree 2 or more finds 2 in its third row."""
    t = np.arange(-20, 1) * 0.1
    samples = np.zeros((1, 21, 7))
    samples[0, :, 1] = 10.0 * t + t**2
    samples[0, :, 3] = 10.0 + 2.0 * t
    found = inputs_of(Windows(samples, dt_s=0.1))[0]
    assert found[0] == 10.0
    along = found[3 : 3 + 2 * FEATURES.positions.shape[0] : 2]
    # Rows of the first fit: value, slope, curvature.
    assert along[:3] == pytest.approx([0.0, 0.0, 2.0], abs=ROUNDING * 1e3)


def test_a_smooth_window_at_half_the_rate_has_the_same_slopes_on_a_straight_line() -> None:
    slow, fast = windows(1, 11, 0.2).samples, windows(1, 21, 0.1).samples
    slow[0, :, :4] = fast[0, ::2, :4]
    slow[0, :, 4:], fast[0, :, 4:] = 0.0, 0.0
    velocity = fast[0, -1, 2:4]
    for samples, dt_s in ((slow, 0.2), (fast, 0.1)):
        t = np.arange(1 - samples.shape[1], 1) * dt_s
        samples[0, :, :2], samples[0, :, 2:4] = velocity * t[:, None], velocity
    found = inputs_of(Windows(slow, dt_s=0.2))
    assert found == pytest.approx(inputs_of(Windows(fast, dt_s=0.1)), abs=1e-6)


def test_roughness_is_the_noise_of_the_velocity() -> None:
    rng = np.random.default_rng(5)
    samples = np.zeros((200, 21, 7))
    samples[..., 3] = 20.0
    samples[..., 2:4] += 0.05 * rng.standard_normal((200, 21, 2))
    found = np.exp(inputs_of(Windows(samples, dt_s=0.1))[:, -3:-1])
    assert np.median(found, axis=0) == pytest.approx([0.05, 0.05], rel=0.1)


def test_the_compiled_network_equals_plain_arithmetic() -> None:
    given, net = windows(), network()
    parameters = LearnedTrajectory((net,), 3).fit(given)
    hidden = np.arcsinh((inputs_of(given) - net.centre) / net.width)
    for weights, bias in ((net.weights_1, net.bias_1), (net.weights_2, net.bias_2)):
        hidden = np.maximum(hidden @ weights + bias, 0.0)
    assert parameters[:, 4:] == pytest.approx(hidden @ net.weights_3 + net.bias_3, rel=1e-9, abs=1e-9)
    assert np.array_equal(parameters[:, :4], given.samples[:, -1, 2:6])


def test_the_noise_of_the_window_chooses_the_network() -> None:
    given = windows()
    few, many = network(0.003, seed=1), network(seed=2)
    both = LearnedTrajectory((few, many), 3).fit(given)
    quiet = given.samples[:, -1, 6] <= 0.003
    assert 0 < quiet.sum() < quiet.size
    alone = [LearnedTrajectory((replace(one, up_to_noise_m=np.inf),), 3).fit(given) for one in (few, many)]
    assert np.array_equal(both, np.where(quiet[:, None], alone[0], alone[1]))


def test_a_window_too_short_in_time_leaves_the_kinematic_model_uncorrected() -> None:
    given = windows(dt_s=0.05)
    model = LearnedTrajectory((network(),), 3)
    parameters = model.fit(given)
    assert not parameters[:, 4:].any()
    horizons_s = np.array([0.5, 2.0])
    kinematic = ConstantTurnRateAcceleration()
    expected = kinematic.predict(kinematic.fit(given), horizons_s, dt_s=0.05)
    assert np.array_equal(model.predict(parameters, horizons_s, dt_s=0.05), expected)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"networks": ()}, "networks must be a list of 1 to 16 items"),
        ({"coefficients": 2}, "outputs"),
        ({"lags": 15}, "inputs"),
        ({"time_scale_s": 0.0}, "time_scale_s"),
        ({"turn_s": -1.0}, "turn_s"),
        ({"networks": (network(0.1), network(0.1))}, "rise"),
    ],
)
def test_what_does_not_fit_together_is_refused(change: dict[str, object], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(LearnedTrajectory((network(),), 3), **change)


def test_a_network_whose_shapes_disagree_is_refused() -> None:
    with pytest.raises(ValueError, match="weights_2 must be"):
        replace(network(), weights_2=np.zeros((7, 5)))
    with pytest.raises(ValueError, match=r"bias_3\[0\] must be a number"):
        replace(network(), bias_3=np.full(6, np.nan))

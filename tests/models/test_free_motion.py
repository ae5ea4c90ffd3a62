"""Claims about free sub-models: what Part I states, and what it means."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.context_columns import CONTEXT_COLUMNS, LEADER_KNOWN, ROAD_KNOWN, ROAD_TURN
from modelcast.models.free import Estimates, FreeMotion, Limits
from modelcast.models.free.estimates import map_of
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import FeatureMap, Perceptron
from modelcast.models.learned.learned_kernels import CONTEXT_AT, window_features
from modelcast.models.learned.learned_trajectory import feature_constants
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.point_kernels import REPORTS, SAMPLE_COLUMNS
from modelcast.models.trusted import Trusted

T_S = np.arange(-20, 1) * 0.1
POSITION = Estimates(
    np.inf,
    speed=("position", 10, 3),
    course=("position", 10, 3),
    acceleration=("position", 10, 3),
    yaw_rate=("position", 10, 3),
)


def braking_turn(noise_m: float = 0.0) -> FloatArray:
    """A circle of 50 m at 10 m/s, slowing by 2 m/s²; of the window only the positions are right."""
    along = 10.0 * T_S - T_S**2
    window = np.zeros((1, T_S.size, SAMPLE_COLUMNS))
    window[0, :, 0] = 50.0 * (1.0 - np.cos(along / 50.0))
    window[0, :, 1] = 50.0 * np.sin(along / 50.0)
    window[0, :, 2], window[0, :, 3] = 0.5, 9.0
    window[0, :, 4], window[0, :, 5] = 7.0, -1.0
    window[0, :, 6], window[0, :, 7] = noise_m, 9.5
    return window


def network(features: FeatureMap, outputs: FloatArray, up_to_noise_m: float = np.inf) -> Perceptron:
    """A network that gives the same outputs whatever it sees."""
    inputs = features.inputs
    return Perceptron(
        up_to_noise_m,
        centre=np.zeros(inputs),
        width=np.ones(inputs),
        weights_1=np.zeros((inputs, 2)),
        bias_1=np.zeros(2),
        weights_2=np.zeros((2, 2)),
        bias_2=np.zeros(2),
        weights_3=np.zeros((2, 4)),
        bias_3=outputs,
    )


def stated(model: FreeMotion, window: FloatArray) -> tuple[float, float, float, float]:
    """Speed, heading, acceleration and yaw rate that a message states."""
    east, north, along, turn = model.fit(Windows(window, dt_s=0.1))[0]
    return float(np.hypot(east, north)), float(np.arctan2(east, north)), float(along), float(turn)


def test_estimates_come_from_the_polynomials_that_are_named() -> None:
    """Speed 10 m/s north, 2 m/s² of braking, 0.2 rad/s clockwise: the columns say otherwise."""
    speed, heading, along, turn = stated(
        FreeMotion((POSITION,), features=map_of((POSITION,), 20)), braking_turn()
    )
    assert speed == pytest.approx(10.0, abs=0.01)
    assert heading == pytest.approx(0.0, abs=1e-3)
    assert along == pytest.approx(-2.0, abs=0.1)
    assert turn == pytest.approx(0.2, abs=0.015)  # a cubic errs by its fourth derivative


def test_the_newest_sample_serves_where_no_polynomial_is_named() -> None:
    newest = Estimates(np.inf)
    found = stated(FreeMotion((newest,), features=map_of((newest,), 20)), braking_turn())
    assert found == pytest.approx((np.hypot(0.5, 9.0), np.arctan2(0.5, 9.0), 7.0, -1.0))


def test_the_reported_speed_is_a_speed_of_its_own() -> None:
    by_speed = Estimates(np.inf, speed=("speed", 5, 1))
    speed, heading, *_ = stated(FreeMotion((by_speed,), features=map_of((by_speed,), 20)), braking_turn())
    assert speed == pytest.approx(9.5)
    assert heading == pytest.approx(np.arctan2(0.5, 9.0))


@pytest.mark.parametrize(("noise_m", "expected"), [(0.001, 7.0), (0.01, -2.0), (5.0, -2.0)])
def test_the_vehicles_own_noise_chooses(noise_m: float, expected: float) -> None:
    estimates = (Estimates(0.005), replace(POSITION, up_to_noise_m=1.0))
    model = FreeMotion(estimates, features=map_of(estimates, 20))
    assert stated(model, braking_turn(noise_m))[2] == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize(
    ("reports", "expected"), [(0, 7.0), (1, 7.0), (3, 7.0), (4, -2.0), (5, -2.0), (15, -2.0), (11, 7.0)]
)
def test_who_reports_all_that_is_asked_is_served(reports: int, expected: float) -> None:
    """The first serves who reports an acceleration, whatever else it reports; the last all others."""
    estimates = (replace(POSITION, reports=4), Estimates(np.inf))
    window = braking_turn()
    window[0, :, REPORTS] = reports
    found = stated(FreeMotion(estimates, features=map_of(estimates, 20)), window)
    assert found[2] == pytest.approx(expected, abs=0.1)


@given(st.lists(st.floats(-50.0, 50.0), min_size=4, max_size=4))
def test_a_network_moves_each_value_by_no_more_than_its_limit(outputs: list[float]) -> None:
    limits = Limits()
    features = map_of((POSITION,), 20)
    plain = FreeMotion((POSITION,), features=features)
    moved = replace(plain, networks=(network(features, np.array(outputs)),))
    before, after = stated(plain, braking_turn()), stated(moved, braking_turn())
    for one, other, limit in zip(before, after, limits.values, strict=True):
        assert abs(one - other) <= limit + 1e-12


def test_each_output_moves_its_own_value() -> None:
    features = map_of((POSITION,), 20)
    plain = FreeMotion((POSITION,), features=features)
    before = np.array(stated(plain, braking_turn()))
    for at, sign in enumerate((1.0, -1.0, 1.0, -1.0)):  # to the left is against the clock
        outputs = np.zeros(4)
        outputs[at] = 50.0
        model = replace(plain, networks=(network(features, outputs),))
        expected = np.zeros(4)
        expected[at] = sign * Limits().values[at]
        assert np.array(stated(model, braking_turn())) - before == pytest.approx(expected, abs=1e-9)


def test_limits_of_zero_leave_the_estimates() -> None:
    features = map_of((POSITION,), 20)
    plain = FreeMotion((POSITION,), features=features)
    model = replace(plain, networks=(network(features, np.full(4, 9.0)),), limits=Limits(0.0, 0.0, 0.0, 0.0))
    assert stated(model, braking_turn()) == stated(plain, braking_turn())


def test_the_networks_are_chosen_by_noise_too() -> None:
    features = map_of((POSITION,), 20)
    quiet, loud = network(features, np.array([50.0, 0, 0, 0]), 0.005), network(features, np.zeros(4))
    model = FreeMotion((POSITION,), (quiet, loud), features=features)
    near, far = (stated(model, braking_turn(noise))[0] for noise in (0.001, 0.1))
    assert near - far == pytest.approx(0.28, abs=1e-6)


def test_a_standing_vehicle_states_its_newest_sample() -> None:
    window = braking_turn()
    window[0, :, 2:4] = 0.1
    window[0, :, 4:6] = 0.0
    model = FreeMotion((POSITION,), features=map_of((POSITION,), 20))
    assert model.fit(Windows(window, dt_s=0.1))[0].tolist() == [0.1, 0.1, 0.0, 0.0]


def test_a_window_that_reaches_back_too_short_a_time_states_its_newest_sample() -> None:
    model = FreeMotion((POSITION,), features=map_of((POSITION,), 20))
    assert stated(model, braking_turn())[2] != 7.0
    assert model.fit(Windows(braking_turn(), dt_s=0.02))[0, 2] == 7.0


def test_to_a_receiver_all_are_one_with_constant_turn_rate_and_acceleration() -> None:
    """All are plain in one bank, whoever chose the values; what has other horizons is not."""
    features = map_of((POSITION,), 20)
    free = FreeMotion((POSITION,), features=features)
    predictive = replace(free, networks=(network(features, np.ones(4)),), label="free-predictive")
    starter = Trusted(ConstantTurnRateAcceleration(), 1.5, 1.0)
    assert Bank((predictive, free, starter)).sent_plain == (True, True, True)
    assert Bank((free, Trusted(ConstantTurnRateAcceleration(), 1.5, 2.0))).sent_plain == (True, False)
    parameters = free.fit(Windows(braking_turn(), dt_s=0.1))
    horizons_s = np.linspace(0.0, 5.0, 21)
    mine, its = (one.predict(parameters, horizons_s, dt_s=0.1) for one in (predictive, starter))
    assert (mine == its).all()


def test_the_context_is_an_input_where_it_is_known() -> None:
    """A network that adds the road's first input to the yaw rate: it turns right by 0.02 rad in a second."""
    features = FeatureMap(20, context=True)
    road = features.inputs - features.fixed - 7
    weights = np.zeros((features.inputs, 1))
    weights[road] = 1.0
    net = Perceptron(
        np.inf,
        centre=np.zeros(features.inputs),
        width=np.ones(features.inputs),
        weights_1=weights,
        bias_1=np.zeros(1),
        weights_2=np.ones((1, 1)),
        bias_2=np.zeros(1),
        weights_3=np.array([[0.0, 0.0, 0.0, -100.0]]),
        bias_3=np.zeros(4),
    )
    model = FreeMotion((Estimates(np.inf),), (net,), features=features)
    window = np.concatenate([braking_turn(), np.zeros((1, T_S.size, CONTEXT_COLUMNS))], axis=2)
    nothing = stated(model, window)[3]
    window[0, -1, SAMPLE_COLUMNS + ROAD_TURN] = 0.02
    assert stated(model, window)[3] == nothing  # not known
    window[0, -1, SAMPLE_COLUMNS + ROAD_KNOWN] = 1.0
    assert stated(model, window)[3] == pytest.approx(nothing + Limits().yaw_rate_radps, abs=1e-6)
    assert stated(model, window[..., :SAMPLE_COLUMNS])[3] == nothing


def test_a_mirrored_world_gives_mirrored_inputs() -> None:
    """East for west: what `mirrors` marks changes its sign, and nothing else does."""
    features = FeatureMap(20, speed_fits=((5, 1),), context=True)
    rng = np.random.default_rng(5)
    samples = rng.normal(0.0, 1.0, (1, 21, SAMPLE_COLUMNS + CONTEXT_COLUMNS))
    samples[..., 3] += 10.0
    samples[..., 6] = 0.01
    samples[..., SAMPLE_COLUMNS + LEADER_KNOWN] = samples[..., SAMPLE_COLUMNS + ROAD_KNOWN] = 1.0
    turned = samples.copy()
    for column in (0, 2, 5, *(SAMPLE_COLUMNS + ROAD_TURN + at for at in range(7))):
        turned[..., column] *= -1.0
    here, there = (inputs_of(features, one) for one in (samples, turned))
    assert there == pytest.approx(here * features.mirrors, abs=1e-9)


def inputs_of(features: FeatureMap, samples: FloatArray) -> FloatArray:
    """Inputs of one window."""
    constants = feature_constants(features, 0.1)
    constants[CONTEXT_AT] = SAMPLE_COLUMNS
    out = np.empty(features.inputs)
    assert window_features(samples[0], constants, out)
    return out


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"speed": ("position", 3, 0)}, "a degree from 1"),
        ({"acceleration": ("velocity", 3, 0)}, "a degree from 1"),
        ({"yaw_rate": ("speed", 5, 1)}, "no direction"),
        ({"course": ("height", 5, 1)}, "one of newest"),
        ({"speed": ("speed", 2, 3)}, "a degree from 0"),
        ({"up_to_noise_m": 0.0}, "up_to_noise_m"),
    ],
)
def test_estimates_that_cannot_be_are_refused(wrong: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        replace(POSITION, **wrong)


def test_a_model_whose_map_lacks_its_estimates_is_refused() -> None:
    with pytest.raises(ValueError, match=r"estimates\[0\].*polynomials of the map"):
        FreeMotion((POSITION,), features=FeatureMap(20, ((3, 2),), ()))


def test_a_network_of_another_map_is_refused() -> None:
    features = map_of((POSITION,), 20)
    with pytest.raises(ValueError, match=r"networks\[0\]"):
        FreeMotion((POSITION,), (network(FeatureMap(20), np.zeros(4)),), features=features)


def test_it_travels_as_a_profile_keeps_it() -> None:
    features = map_of((POSITION,), 20, FeatureMap(20, speed_fits=((5, 1),), context=True))
    model = FreeMotion((POSITION,), (network(features, np.ones(4)),), features=features)
    assert from_plain(to_plain(model)) == model

"""Claims about the interacting multiple model: its chances, and what receivers hold from update to update."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from modelcast.core.arrays import FloatArray
from modelcast.messages.code_table import code_table
from modelcast.messages.mbc import ModelUpdate
from modelcast.messages.sizes import SizeModel
from modelcast.models import interacting_kernels as kernels
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.station.receiver.heard import heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState

START = (0.1, 0.2, 0.3, 0.4)
IMM = InteractingMultipleModel(
    persistence_s=2.0,
    noise_m=0.05,
    acceleration_spread_mps2=0.8,
    jerk_spread_mps3=1.5,
    yaw_acceleration_spread_radps2=0.2,
    start=START,
)
MODES = (
    (ConstantVelocity(0.8), [0, 1]),
    (ConstantAcceleration(jerk_spread_mps3=1.5, lateral_spread_mps2=0.8), [0, 1, 2]),
    (
        ConstantTurnRateVelocity(acceleration_spread_mps2=0.8, yaw_acceleration_spread_radps2=0.2),
        [0, 1, 3],
    ),
    (ConstantTurnRateAcceleration(jerk_spread_mps3=1.5, yaw_acceleration_spread_radps2=0.2), [0, 1, 2, 3]),
)
CONSTANTS = IMM.point_functions(0.1).constants
ROUNDING = 1e-9

motions = st.tuples(
    st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), st.floats(-4.0, 4.0), st.floats(-0.5, 0.5)
).filter(lambda one: np.hypot(one[0], one[1]) > 0.5)
ways = st.tuples(st.floats(0.1, 4.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def absorbed(held: FloatArray, moved: FloatArray, new: FloatArray) -> FloatArray:
    out = held.copy()
    kernels.absorb(new, moved, CONSTANTS, out)
    return out


def chances_after(held: FloatArray, age_s: float) -> FloatArray:
    start = np.array(START)
    known = held[4:] if held[4:].sum() > 0.0 else start
    return start + (known - start) * np.exp(-age_s / 2.0)


@given(motions, st.floats(0.0, 8.0))
def test_a_receiver_that_held_nothing_predicts_by_the_chances_at_a_start(
    motion: tuple[float, ...], age_s: float
) -> None:
    sample = np.array([[[3.0, 4.0, *motion, 0.0]]])
    parameters = IMM.fit(Windows(sample, dt_s=0.1))
    assert parameters.tolist() == [[*motion, 0.0, 0.0, 0.0, 0.0]]
    horizon = np.array([age_s])
    means = [one.predict(parameters[:, own], horizon, dt_s=0.1)[0, 0] for one, own in MODES]
    found = IMM.predict(parameters, horizon, dt_s=0.1)[0, 0]
    np.testing.assert_allclose(found, START @ np.array(means), rtol=ROUNDING, atol=ROUNDING)


@given(motions, ways, st.booleans())
def test_an_update_weighs_the_modes_by_the_gaussian_density_of_the_way(
    motion: tuple[float, ...], way: tuple[float, ...], knows: bool
) -> None:
    """Bayes' rule over the chain of Blom and Bar-Shalom, with SciPy's density and the modes' own covariances.

    A way that no mode foresaw within hundreds of standard deviations is left out: densities underflow.
    """
    held = np.array([*motion, *((0.7, 0.1, 0.15, 0.05) if knows else (0.0,) * 4)])
    row, horizon = held[None], np.array([way[0]])
    middle = MODES[3][0].predict(row[:, :4], horizon, dt_s=0.1)[0, 0]
    moved = np.array([way[0], middle[0] + way[1], middle[1] + way[2]])
    density = [
        multivariate_normal.logpdf(
            moved[1:],
            one.predict(row[:, own], horizon, dt_s=0.1)[0, 0],
            one.spread_m2(row[:, own], horizon)[0, 0] + 2.0 * 0.05**2 * np.eye(2),
        )
        for one, own in MODES
    ]
    weight = chances_after(held, way[0]) * np.exp(np.array(density) - max(density))
    new = np.array([1.0, 2.0, 0.5, 0.1, 0.0, 0.0, 0.0, 0.0])
    found = absorbed(held, moved, new)
    np.testing.assert_allclose(found[4:], weight / weight.sum(), rtol=1e-6, atol=1e-12)
    assert found[:4].tolist() == new[:4].tolist()


def test_a_car_that_brakes_straight_on_makes_acceleration_likely_and_the_chain_forgets_it() -> None:
    held, speed = np.array([0.0, 20.0, -2.0, 0.1, 0.0, 0.0, 0.0, 0.0]), 20.0
    for _ in range(8):
        moved = np.array([1.0, 0.0, speed - 1.0])
        speed -= 2.0
        held = absorbed(held, moved, np.array([0.0, speed, -2.0, 0.1, 0.0, 0.0, 0.0, 0.0]))
    assert held[4 + 1] == held[4:].max() > 0.6
    assert held[4:].sum() == pytest.approx(1.0)
    late = np.array([400.0])  # all modes but those that go on stand still or turn by then
    fresh = np.array([*held[:4], 0.0, 0.0, 0.0, 0.0])
    rows = np.stack([held, fresh])
    np.testing.assert_allclose(*IMM.predict(rows, late, dt_s=0.1), rtol=1e-9)


@given(motions, st.floats(0.1, 5.0))
def test_the_covariance_is_that_of_the_mixture(motion: tuple[float, ...], age_s: float) -> None:
    held, horizon = np.array([*motion, 0.4, 0.3, 0.2, 0.1]), np.array([age_s])
    chance = chances_after(held, age_s)
    means = np.array([one.predict(held[None, own], horizon, dt_s=0.1)[0, 0] for one, own in MODES])
    squares = [one.spread_m2(held[None, own], horizon)[0, 0] for one, own in MODES]
    second = sum(
        c * (square + np.outer(mean, mean)) for c, square, mean in zip(chance, squares, means, strict=True)
    )
    mean = chance @ means
    found = IMM.covariance(held[None], horizon, dt_s=0.1)[0, 0]
    np.testing.assert_allclose(found, second - np.outer(mean, mean), rtol=1e-6, atol=1e-6)


def test_the_chances_take_no_byte_and_are_nothing_on_the_wire() -> None:
    bank = Bank((IMM,))
    assert SizeModel().each_update_bytes(bank, "never").tolist() == [40]
    assert bank.sent_plain == (True,)
    codes, held = code_table(bank).quantise(np.array([[10.0, 0.0, 1.0, 0.1, 0.4, 0.3, 0.2, 0.1]]))
    assert codes[0, 4:].tolist() == held[0, 4:].tolist() == [0.0] * 4


# What a host holds -----------------------------------------------------------------------------------------

MOTION = np.array([0.0, 20.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 20.0])


def update(number: int, t_s: float, north_m: float, in_use: int = 0) -> ModelUpdate:
    return ModelUpdate(
        7, number, t_s, position_m=np.array([0.0, north_m]), in_use=in_use, parameters=MOTION, dt_s=0.1
    )


def heard_by(around: LocalDynamicMap, *updates: ModelUpdate) -> MapState:
    state = around.init()
    for one in updates:
        _, state = around.hear(state, heard_messages([one], [one.t_s]))
    return state


def held_of(state: MapState) -> FloatArray:
    return state.parameters[0, : MOTION.size]


def test_a_host_absorbs_every_update_that_it_receives_and_one_that_is_new_starts_from_nothing() -> None:
    around = LocalDynamicMap((Bank((IMM, ConstantVelocity())),), expiry_s=3.0)
    first, second, third = update(0, 10.0, 0.0), update(1, 11.0, 19.0), update(2, 12.5, 44.0)
    new = MOTION[:8]
    once = absorbed(new, np.array([1.0, 0.0, 19.0]), new)
    twice = absorbed(once, np.array([1.5, 0.0, 25.0]), new)
    lost = absorbed(new, np.array([2.5, 0.0, 44.0]), new)
    for updates, wanted in (
        ((first,), new),
        ((first, second), once),
        ((first, second, second), once),
        ((first, second, third), twice),
        ((first, third), lost),
        ((third, second), new),
        ((second,), new),
    ):
        assert held_of(heard_by(around, *updates))[:8].tolist() == wanted.tolist()
    assert len({one.tobytes() for one in (new, once, twice, lost)}) == 4


def test_after_silence_or_another_sub_model_it_starts_anew() -> None:
    around = LocalDynamicMap((Bank((IMM, ConstantVelocity())),), expiry_s=3.0)
    first, late = update(0, 10.0, 0.0), update(1, 13.5, 60.0)
    other, again = update(1, 11.0, 19.0, in_use=1), update(2, 12.0, 36.0)
    assert held_of(heard_by(around, first, late)).tolist() == MOTION.tolist()
    assert held_of(heard_by(around, first, other)).tolist() == MOTION.tolist()
    assert held_of(heard_by(around, first, other, again)).tolist() == MOTION.tolist()

"""Claims about the codes of a bank's parameters, and what receivers make of them."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import stated_local
from modelcast.messages import codes_kernels as kernels
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.code_table import code_table
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.payload import PayloadField
from modelcast.models.predicted_path import PredictedPath, carried_form, carried_layout
from modelcast.models.profile import default_profile
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import bank_from_text, member_names
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive

ALL = Bank(tuple(bank_from_text(f"{name}").members[0] for name in member_names(default_profile())), "all")
TABLE = code_table(ALL)
FIELDS = {"acceleration_mps2": "acceleration_forward_mps2", "yaw_rate_radps": "yaw_rate_radps"}

numbers = st.one_of(
    st.floats(-60.0, 60.0), st.floats(-1e300, 1e300), st.sampled_from([0.0, -0.0, 5e-324, np.inf, -np.inf])
)
rows = st.lists(numbers, min_size=len(TABLE.names), max_size=len(TABLE.names)).map(
    lambda row: np.array([row])
)


def payload_fields() -> dict[str, PayloadField]:
    return {
        f"{member.name}.{field.name}": field
        for member in ALL.members
        for field in carried_layout(member).fields
    }


def test_the_table_has_every_parameter_of_every_sub_model_once() -> None:
    wanted = [f"{m.name}.{name}" for m in map(carried_form, ALL.members) for name in m.parameter_names]
    assert list(TABLE.names) == wanted
    carried = code_table(ALL.carried())
    assert carried.names == TABLE.names
    assert carried.rows.tobytes() == TABLE.rows.tobytes()
    assert (TABLE.offsets[-1], TABLE.wire_offsets[-1]) == (len(wanted), len(TABLE.wire))
    assert [TABLE.names[i] for i in TABLE.wire] == list(payload_fields())
    assert (
        CORE_INDEX["speed_mps"],
        CORE_INDEX["heading_rad"],
    ) == (kernels.SPEED_PLACE, kernels.HEADING_PLACE)


@given(rows)
@example(np.zeros((1, len(TABLE.names))))
@example(np.full((1, len(TABLE.names)), np.inf))
@example(np.full((1, len(TABLE.names)), -np.inf))
def test_a_code_stands_for_the_value_that_its_field_says_bit_for_bit(parameters: FloatArray) -> None:
    codes, held = TABLE.quantise(parameters)
    fields = payload_fields()
    for i, name in enumerate(TABLE.names):
        code, value, own = int(codes[0, i]), float(held[0, i]), name.split(".")[1]
        if name in fields:
            assert fields[name].low <= code <= fields[name].high
            assert value.hex() == float(code * fields[name].step).hex()
        elif own in FIELDS:
            field = CORE_FIELDS[CORE_INDEX[FIELDS[own]]]
            assert value.hex() == float(field.value_of(code) or 0.0).hex()
            assert code == field.code_of(float(parameters[0, i]))
        elif own == "velocity_east_mps":
            speed, heading = (CORE_FIELDS[at] for at in (kernels.SPEED_PLACE, kernels.HEADING_PLACE))
            mps, rad = speed.value_of(code), heading.value_of(int(codes[0, i + 1]))
            assert mps is not None
            assert rad is not None
            wanted = (mps * math.sin(rad), mps * math.cos(rad)) if mps else (0.0, 0.0)
            assert (value.hex(), float(held[0, i + 1]).hex()) == (wanted[0].hex(), wanted[1].hex())


@given(rows)
def test_what_a_receiver_holds_has_the_same_codes_and_the_same_bits(parameters: FloatArray) -> None:
    codes, held = TABLE.quantise(parameters)
    again_codes, again = TABLE.quantise(held)
    assert again_codes.tolist() == codes.tolist()
    assert again.tobytes() == held.tobytes()


@given(rows)
def test_a_sub_model_is_rounded_alike_alone_in_place_and_in_a_batch(parameters: FloatArray) -> None:
    batch = np.concatenate([parameters[:, ::-1], parameters])
    codes, held = TABLE.quantise(batch)
    for first, end in zip(TABLE.offsets[:-1], TABLE.offsets[1:], strict=True):
        own, found = parameters[0, first:end].copy(), np.zeros(end - first, np.int64)
        assert kernels.quantise_parameters(TABLE.rows[first:end], own, found, own) == -1
        assert found.tolist() == codes[1, first:end].tolist()
        assert own.tobytes() == held[1, first:end].tobytes()


def test_no_number_becomes_unavailable_and_beyond_its_range_it_takes_the_last_code() -> None:
    table = code_table(bank_from_text("ctra"))
    codes, held = table.quantise(np.array([[300.0, 0.0, 50.0, -100.0], [0.0, -np.inf, -np.inf, np.inf]]))
    assert codes.tolist() == [[8190, 7200, 2000, -32767], [8190, 14400, -2000, 32767]]
    assert held[:, 2].tolist() == [20.0, -20.0]


def test_what_is_not_a_number_is_refused_by_name_and_nothing_is_written() -> None:
    table = code_table(bank_from_text("cv+ctra"))
    parameters = np.zeros((3, 6))
    parameters[2, 4] = np.nan
    with pytest.raises(ValueError, match=r"row 2: ctra.acceleration_mps2 is not a number"):
        table.quantise(parameters)
    row, codes = parameters[2, 2:].copy(), np.full(4, 9)
    assert kernels.quantise_parameters(table.rows[2:], row, codes, row) == 2
    assert codes.tolist() == [9, 9, 9, 9]
    assert np.array_equal(row, parameters[2, 2:], equal_nan=True)
    with pytest.raises(ValueError, match=r"\(B, 6\)"):
        table.quantise(np.zeros(6))


def test_a_vehicle_that_stands_has_no_heading_whatever_the_sign_of_its_zeros() -> None:
    table = code_table(bank_from_text("cv"))
    crawling = [[0.004, -0.004], [-0.0, -0.0], [-0.0, 0.009], [-0.009, 0.0]]
    codes, held = table.quantise(np.array(crawling))
    assert codes.tolist() == [[0, 0]] * 4
    assert held.tobytes() == np.zeros((4, 2)).tobytes()


@given(st.floats(0.0, 1e6), st.floats(-100.0, 100.0), st.floats(-29.9, 29.9))
@example(59.9996, 0.0, 0.0)
def test_an_instant_comes_back_to_a_millisecond_whenever_it_is_read(
    t_s: float, minute_s: float, later_s: float
) -> None:
    code = kernels.state_instant(t_s, minute_s)
    assert 0 <= code <= 59_999
    found = kernels.instant_of(code, t_s + later_s, minute_s)
    assert abs(found - t_s) <= 0.0005 + 1e-9
    assert found == kernels.instant_of(code, t_s, minute_s)


# What senders fit -----------------------------------------------------------------------------------------

SPEED_MPS, HEADING_RAD, ACCELERATION_MPS2, YAW_RATE_RADPS = (
    CORE_FIELDS[CORE_INDEX[name]].resolution
    for name in ("speed_mps", "heading_rad", "acceleration_forward_mps2", "yaw_rate_radps")
)
CODE_M = 0.01118
"""A code of latitude at the poles, where it is longest."""

ROUNDING = 1e-9
"""Of products of steps and codes."""


def states(count: int = 200) -> FloatArray:
    rng = np.random.default_rng(4)
    spread = np.array([5000.0, 5000.0, 20.0, 20.0, 3.0, 0.3, 0.0])
    return rng.normal(0.0, 1.0, (count, 7)) * spread


def windows(samples: FloatArray) -> Windows:
    """Windows of 25 equal rows each, which is enough for every sub-model."""
    return Windows(np.repeat(samples[:, None, :], 25, axis=1), dt_s=0.1)


def test_every_kinematic_parameter_is_within_half_a_step() -> None:
    samples = states()
    _, held = code_table(bank_from_text("ctra")).quantise(samples[:, 2:6])
    speed, exact = np.hypot(held[:, 0], held[:, 1]), np.hypot(samples[:, 2], samples[:, 3])
    turned = np.arctan2(held[:, 0], held[:, 1]) - np.arctan2(samples[:, 2], samples[:, 3])
    assert np.abs(speed - exact).max() <= SPEED_MPS / 2 + ROUNDING
    assert np.abs((turned + np.pi) % (2 * np.pi) - np.pi).max() <= HEADING_RAD / 2 + ROUNDING
    assert np.abs(held[:, 2] - samples[:, 4]).max() <= ACCELERATION_MPS2 / 2 + ROUNDING
    assert np.abs(held[:, 3] - samples[:, 5]).max() <= YAW_RATE_RADPS / 2 + ROUNDING


def test_rounding_moves_a_kinematic_path_by_half_a_step_of_each_field_at_most() -> None:
    """Half a step of speed and heading grow with the time, of acceleration and yaw rate with its square."""
    model, at_s = ConstantTurnRateAcceleration(), np.array([0.5, 1.0, 2.0])
    exact = model.fit(windows(states()))
    _, held = code_table(Bank((model,))).quantise(exact)
    off_m = np.hypot(
        *np.moveaxis(model.predict(held, at_s, dt_s=0.1) - model.predict(exact, at_s, dt_s=0.1), 2, 0)
    )
    way_m = (np.hypot(exact[:, 0], exact[:, 1])[:, None] + np.abs(exact[:, 2:3]) * at_s) * at_s
    along_m = SPEED_MPS / 2 * at_s + ACCELERATION_MPS2 / 4 * at_s**2
    across_m = way_m * (HEADING_RAD / 2 + YAW_RATE_RADPS / 2 * at_s)
    assert (off_m <= along_m + across_m + ROUNDING).all()
    assert off_m.max() > 0.5 * (along_m + across_m).min()


def test_a_prediction_begins_at_the_position_that_was_sent() -> None:
    """Within half a code of the sample, and stated again it stays."""
    drive = generate_drive(3, 90.0).input
    estimator = velocity_estimator_for(drive)
    sent, exact = (
        TripRuntime(drive, bank_from_text("cv"), estimator, quantised=one) for one in (True, False)
    )
    off_m = np.abs(sent.stated_m - drive.position_m)
    assert 0.4 * CODE_M < off_m.max() <= 0.5 * CODE_M
    np.testing.assert_array_equal(stated_local(sent.stated_m, NOWHERE), sent.stated_m)
    np.testing.assert_array_equal(exact.stated_m, drive.position_m)


@pytest.mark.parametrize(
    "model",
    [
        ConstantTurnRateAcceleration(),
        vehicle_process(),
        default_profile().bank.members[0],
        PredictedPath(GaussianProcess()),
        PredictedPath(default_profile().sub_model("gp-trained")),
    ],
    ids=lambda model: model.name,
)
def test_what_a_sender_fits_is_what_its_receivers_hold(model: AbstractSubModel) -> None:
    """A receiver that rounded again would hold the same bits."""
    drive = generate_drive(3, 90.0).input
    ready = TripRuntime(drive, Bank((model,)), velocity_estimator_for(drive), quantised=True)
    at = np.arange(100, 500, 7)
    ready.fit_at(at)
    held = ready.parameters[at]
    assert code_table(ready.bank).quantise(held)[1].tobytes() == held.tobytes()


def test_what_has_no_layout_is_sent_as_its_predicted_path() -> None:
    model = GaussianProcess(form="intercept")
    assert model.payload_layout is None
    bank = Bank((model,)).carried()
    assert bank.members == (PredictedPath(model),)
    assert bank.carried() == bank
    assert SenderBank.of(Bank((model,)), 0.1).bank.members[0] == PredictedPath(model)


def test_a_bank_completed_by_constant_velocity_has_its_codes_too() -> None:
    own = SenderBank.of(Bank((vehicle_process(),)), 0.1)
    assert [member.name for member in own.bank.members] == ["gp-vehicle", "cv"]
    assert own.table.tobytes() == code_table(own.bank).rows.tobytes()


def test_quantising_costs_few_messages() -> None:
    """On a drive with 1 cm of noise, five millimetres of grid are no matter."""
    drive = generate_drive(5, 300.0)
    bank, estimator = default_profile().bank, velocity_estimator_for(drive.input)
    policy = ErrorDriven(0.2, "order", "never")
    plain, sent = (
        TripRuntime(drive.input, bank, estimator, quantised=one).run(policy) for one in (False, True)
    )
    assert abs(sent.updates - plain.updates) <= 0.05 * plain.updates + 2

"""Claims about what hosts of a fleet believe of remotes, by how they read messages."""

import itertools

import numpy as np
import pytest

from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import FloatArray
from modelcast.messages.mbc import ModelUpdate
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.runtime.fleet.believed import Believed
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.banks import free_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.receiver.heard import heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.world.scenario.base import FleetFrame

SPEED_MPS, BRAKING_MPS2, YAW_RADPS = 20.0, -2.0, 0.1
ROUNDING = 1e-9
SETTINGS = NetworkSettings(warm_up_s=0.0, start_spread_s=0.0)


def radio(received_ratio: float = 1.0) -> TabulatedRadio:
    return TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.full((2, 20), received_ratio), bin_m=500.0))


def frame(step: int, **changes: object) -> FleetFrame:
    """A host that stands, and a remote that brakes in a bend to the right."""
    t_s = round(0.1 * step, 6)
    speed = SPEED_MPS + BRAKING_MPS2 * t_s
    fine = np.linspace(0.0, t_s, 2001)
    pace = SPEED_MPS + BRAKING_MPS2 * fine
    way = [np.trapezoid(pace * turn(YAW_RADPS * fine), fine) for turn in (np.sin, np.cos)]
    columns = {
        "speed_mps": np.array([0.0, speed]),
        "heading_rad": np.array([1.0, YAW_RADPS * t_s]),
        "acceleration_mps2": np.array([0.0, BRAKING_MPS2]),
        "yaw_rate_radps": np.array([0.0, YAW_RADPS]),
        "length_m": np.full(2, 4.5),
        "vehicle_id": np.array([11, 12]),
        "active": np.ones(2, dtype=np.bool_),
    }
    return FleetFrame(t_s, np.array([[30.0, 0.0], way]), **(columns | changes))  # type: ignore[arg-type]


def after(sender: Sender, steps: int, received_ratio: float = 1.0) -> FleetLoop:
    """The loop after some steps."""
    loop = FleetLoop(frame(0), sender, radio(received_ratio), SETTINGS, seed=1)
    for step in range(steps):
        loop.step(frame(step))
    return loop


def content(loop: FleetLoop) -> FloatArray:
    """The newest message of the remote."""
    number = int(loop.stations.senders.number[1]) - 1
    return loop.contents.rows[1, number % at.MESSAGES_KEPT]


def stated(row: FloatArray) -> FloatArray:
    """What it states of motion."""
    return row[at.CONTENT_SPEED_MPS : at.CONTENT_SPEED_MPS + 4]


def place(row: FloatArray) -> FloatArray:
    return row[[at.CONTENT_EAST_M, at.CONTENT_NORTH_M]]


def says(member: AbstractSubModel) -> Sender:
    """A sender of one sub-model, which keeps silent while that errs by less than half a metre."""
    return Sender("one", ErrorDriven(0.5, identify="never"), Bank((member,)))


def believed(loop: FleetLoop, reading: Reading, t_s: float | None = None) -> Believed:
    """What the host believes of the remote."""
    return loop.believed(np.array([0]), np.array([1]), reading=reading, t_s=t_s)


@pytest.mark.parametrize("member", [ConstantTurnRateAcceleration(), ConstantVelocity()])
def test_a_message_states_the_motion_of_its_sample_rounded_as_on_the_wire(member: AbstractSubModel) -> None:
    row = content(after(says(member), 12))
    fit_s = row[at.CONTENT_FIT_S]
    speed, heading, acceleration, yaw_rate = stated(row)
    assert speed == pytest.approx(SPEED_MPS + BRAKING_MPS2 * fit_s, abs=0.011)
    assert speed / 0.02 == pytest.approx(round(speed / 0.02), abs=1e-6)
    assert heading == pytest.approx(YAW_RADPS * fit_s, abs=2e-4)
    assert acceleration == pytest.approx(BRAKING_MPS2, abs=ROUNDING)
    assert yaw_rate == pytest.approx(YAW_RADPS, abs=1e-4)


def test_a_legacy_receiver_coasts_place_speed_and_heading_and_believes_the_rates_stated() -> None:
    loop = after(says(ConstantTurnRateAcceleration()), 12)
    row, found = content(loop), believed(loop, Reading.LEGACY)
    age_s = 1.2 - row[at.CONTENT_FIT_S]
    assert age_s > 1.0
    speed, heading = stated(row)[:2]
    course = np.array([np.sin(heading), np.cos(heading)])
    wanted = [
        *(place(row) + speed * age_s * course),
        *(speed * course),
        *stated(row),
    ]
    assert found.held.tolist() == [True]
    assert found.age_s[0] == pytest.approx(age_s, abs=ROUNDING)
    np.testing.assert_allclose(found.motion[0], wanted, atol=ROUNDING)


def test_a_free_receiver_coasts_part_one_by_the_free_convention_whatever_the_message_carries() -> None:
    free = free_bank().members[0]
    loop = after(says(ConstantVelocity()), 12)
    row = content(loop)
    speed, heading, acceleration, yaw_rate = stated(row)
    own = np.array([[speed * np.sin(heading), speed * np.cos(heading), acceleration, yaw_rate]])
    for late_s in (0.05, 0.4, free.trusted_horizon_s - 0.1):
        found = believed(loop, Reading.FREE, float(row[at.CONTENT_FIT_S]) + late_s).motion[0]
        moved = free.predict_at(own, np.array([late_s]), dt_s=0.1)[0]
        np.testing.assert_allclose(found[:2], place(row) + moved, atol=ROUNDING)
        assert found[4] == pytest.approx(speed + acceleration * late_s, abs=0.01)
        assert found[5] == pytest.approx(heading + yaw_rate * late_s, abs=1e-3)
        assert found[6:] == pytest.approx([acceleration, yaw_rate], abs=0.01)
    beyond_s = row[at.CONTENT_FIT_S] + free.trusted_horizon_s + free.trusted_turn_s + np.array([0.5, 1.0])
    late = [believed(loop, Reading.FREE, float(t_s)).motion[0] for t_s in beyond_s]
    assert late[0][4] == pytest.approx(speed + acceleration * free.trusted_horizon_s, abs=0.05)
    np.testing.assert_allclose(late[0][4:6], late[1][4:6], atol=1e-6)
    assert late[1][6:] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_model_receiver_believes_what_a_local_dynamic_map_does() -> None:
    loop = after(says(ConstantTurnRateAcceleration()), 12)
    row, found = content(loop), believed(loop, Reading.MODEL, 1.3)
    update = ModelUpdate(
        12, 0, float(row[at.CONTENT_FIT_S]),
        position_m=place(row).copy(), in_use=0, parameters=row[at.CONTENT_HEAD :].copy(), dt_s=0.1,
    )  # fmt: skip
    around = LocalDynamicMap((loop.sender.bank,), expiry_s=loop.expiry_s)
    _, state = around.hear(around.init(), heard_messages([update], [1.0]))
    np.testing.assert_allclose(found.motion, around.motions(state, 1.3)[1], atol=1e-7)


def test_going_straight_on_denies_no_acceleration_that_part_one_states() -> None:
    """The path of a model that goes on at constant velocity has none; the message says what it is."""
    for member, reading in itertools.product(
        (ConstantVelocity(), ConstantTurnRateAcceleration()), (Reading.LEGACY, Reading.MODEL)
    ):
        loop = after(says(member), 12)
        found = believed(loop, reading).motion[0]
        assert found[6:] == pytest.approx([BRAKING_MPS2, YAW_RADPS], abs=0.01), (member, reading)
    straight = believed(after(says(ConstantVelocity()), 12), Reading.MODEL).motion[0]
    legacy = believed(after(says(ConstantVelocity()), 12), Reading.LEGACY).motion[0]
    np.testing.assert_allclose(straight, legacy, atol=1e-7)


def test_each_pair_is_read_in_its_own_way_and_the_instant_is_the_end_of_the_step() -> None:
    loop = after(says(ConstantTurnRateAcceleration()), 12)
    both = loop.believed(
        np.array([0, 0]), np.array([1, 1]), reading=np.array([Reading.LEGACY, Reading.MODEL])
    )
    for row, reading in enumerate((Reading.LEGACY, Reading.MODEL)):
        np.testing.assert_allclose(both.motion[row], believed(loop, reading, 1.2).motion[0], atol=ROUNDING)
    assert abs(both.motion[0, 4] - both.motion[1, 4]) > 1.0


def test_nothing_is_believed_of_whom_nobody_hears_heard_long_ago_or_who_is_gone() -> None:
    periodic = named_sender("bsm-10hz")
    deaf, loop = after(periodic, 12, received_ratio=0.0), after(periodic, 12)
    assert believed(loop, Reading.MODEL, 1.2 + 4.8).held.all()
    for found in (believed(deaf, Reading.MODEL), believed(loop, Reading.MODEL, 1.2 + 5.2)):
        assert found.held.tolist() == [False]
        assert np.isnan(found.motion).all()
        assert np.isnan(found.age_s).all()
    loop.step(frame(12, active=np.array([True, False])))
    assert not believed(loop, Reading.MODEL).held.any()


def test_who_takes_a_slot_over_is_not_believed_to_move_as_the_one_before() -> None:
    silent = after(says(ConstantVelocity()), 12)
    silent.stations.senders.vehicle[1] = 99
    assert not believed(silent, Reading.LEGACY).held.any()


@pytest.mark.parametrize(
    ("hosts", "remotes", "reading", "text"),
    [
        ([0], [2], Reading.MODEL, "remotes must lie within 0..1, got 2 to 2"),
        ([-1], [1], Reading.MODEL, "hosts must lie within 0..1, got -1 to -1"),
        ([0], [1], np.array([3]), "reading must lie within 0..2, got 3 to 3"),
        ([[0]], [[1]], Reading.MODEL, r"hosts and remotes must be \(N,\), got \(1, 1\) and \(1, 1\)"),
    ],
)
def test_pairs_that_are_none_are_refused(
    hosts: list[int], remotes: list[int], reading: Reading, text: str
) -> None:
    loop = after(says(ConstantVelocity()), 1)
    with pytest.raises(ValueError, match=text):
        loop.believed(np.array(hosts), np.array(remotes), reading=reading)

"""Claims about what one message may say, and what it changes: at the edges, one by one."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration
from modelcast.station.receiver import slot_kernels
from modelcast.station.receiver.heard import Heard, HeardKind, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.station.receiver.plausibility import Plausibility
from modelcast.station.receiver.track_kernels import forget

CV = ConstantVelocity()
GP = GaussianProcess(4, "intercept")
BANK = Bank((CV, GP))
NARROW = Bank((CV,))
AROUND = LocalDynamicMap((BANK, NARROW), expiry_s=4.0)
JUDGING = replace(AROUND, plausibility=Plausibility())
MALFORMED, ACCEPTED = Receipt.MALFORMED, Receipt.ACCEPTED


def plain(vehicle: Sequence[int], t_s: Sequence[float], **changes: Any) -> Heard:
    """Plain messages that arrive at once, of vehicles that stand 50 m apart by their id."""
    count = len(vehicle)
    times, unknown = np.array(t_s, dtype=np.float64), np.full(count, np.nan)
    given = Heard(
        np.full(count, int(HeardKind.PLAIN)),
        np.array(vehicle, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        t_s=times,
        received_s=np.array(changes.get("received_s", times)),
        position_m=np.stack([50.0 * np.array(vehicle), 0.0 * times], axis=1),
        speed_mps=np.zeros(count),
        heading_rad=unknown,
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.full(count, -1),
        in_use=np.zeros(count, dtype=np.int64),
        parameters=np.empty((count, 0)),
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )
    return replace(given, **{name: np.array(value) for name, value in changes.items()})


def receipt(given: Heard, around: LocalDynamicMap = AROUND) -> list[Receipt]:
    return [Receipt(one) for one in around.hear(around.init(), given)[0].tolist()]


def moving(parameters: Sequence[float], **changes: Any) -> ModelUpdate:
    """An update of the bank; constant velocity first."""
    message = ModelUpdate(
        7,
        3,
        10.0,
        position_m=np.zeros(2),
        in_use=0,
        parameters=np.array(parameters, dtype=np.float64),
        dt_s=0.1,
    )
    return replace(message, **changes)


REST = [0.0] * (int(BANK.offsets[-1]) - 2)


@pytest.mark.parametrize(
    ("column", "inside", "outside"),
    [
        ("speed_mps", 200.0, 200.001),
        ("speed_mps", 0.0, -0.001),
        ("heading_rad", 6.2832, 6.2833),
        ("heading_rad", -6.2832, -6.2833),
        ("acceleration_mps2", 100.0, 100.001),
        ("acceleration_mps2", -100.0, -100.001),
        ("yaw_rate_radps", 10.0, 10.001),
        ("yaw_rate_radps", -10.0, -10.001),
        ("length_m", 100.0, 100.001),
        ("length_m", 0.0, -0.001),
        ("width_m", 100.0, 100.001),
        ("width_m", 0.0, -0.001),
        ("message_count", 2**53 - 1, 2**53),
        ("message_count", 0, -1),
        ("temporary_id", 2**32 - 1, 2**32),
        ("temporary_id", 0, -1),
    ],
)
def test_a_number_is_possible_up_to_its_bound(column: str, inside: float, outside: float) -> None:
    known = {"heading_rad": [1.0]} if column == "speed_mps" else {}
    assert receipt(plain([7], [10.0], **known, **{column: [inside]})) == [ACCEPTED]
    assert receipt(plain([7], [10.0], **known, **{column: [outside]})) == [MALFORMED]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_place_is_within_half_the_earth_s_circumference(axis: int, sign: float) -> None:
    place = np.zeros((1, 2))
    for far_m, expected in ((2e7, ACCEPTED), (2e7 + 0.5, MALFORMED)):
        place[0, axis] = sign * far_m
        assert receipt(plain([7], [10.0], position_m=place)) == [expected]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("expiry_s", "looked_s"), [(4.0, 4.0), (math.inf, 60.0), (64.0, 60.0)])
def test_a_sub_model_must_stay_on_earth_until_it_expires_or_for_a_minute(
    axis: int, expiry_s: float, looked_s: float
) -> None:
    around = replace(AROUND, expiry_s=expiry_s)
    for far_m, expected in ((2e7 * (1.0 - 1e-12), ACCEPTED), (2e7 * (1.0 + 1e-12), MALFORMED)):
        velocity = [0.0, 0.0]
        velocity[axis] = far_m / looked_s
        message = heard_messages([moving([*velocity, *REST])], [10.0])
        assert receipt(message, around) == [expected]


def test_the_bound_itself_is_on_earth() -> None:
    for velocity in ([5e6, 0.0], [0.0, 5e6], [-5e6, 5e6]):
        assert receipt(heard_messages([moving([*velocity, *REST])], [10.0])) == [ACCEPTED]
    assert receipt(heard_messages([moving([5e6, 5.001e6, *REST])], [10.0])) == [MALFORMED]


def test_the_columns_of_a_narrow_profile_are_its_own() -> None:
    """Profile 1 has two parameters, the widest more: what the message lacks is not read."""
    narrow = replace(moving([3.0, -4.0]), t_s=10.0)
    receipts, state = AROUND.hear(AROUND.init(), heard_messages([narrow], [10.0], profile=1))
    assert receipts.tolist() == [ACCEPTED]
    assert AROUND.positions(state, 12.0)[1] == pytest.approx(np.array([[6.0, -8.0]]))
    assert receipt(heard_messages([replace(narrow, in_use=1)], [10.0], profile=1)) == [MALFORMED]
    assert receipt(heard_messages([replace(narrow, in_use=1)], [10.0], profile=0)) == [MALFORMED]


def test_who_stands_has_no_velocity_whoever_spoke_before() -> None:
    given = plain([1, 2], [10.0, 10.0], speed_mps=[20.0, 0.0], heading_rad=[0.7, np.nan])
    _, state = AROUND.hear(AROUND.init(), given)
    assert AROUND.believe(state, 11.0).velocity_mps[1].tolist() == [0.0, 0.0]


def sent_states(*given: Heard) -> MapState:
    state = AROUND.init()
    for one in given:
        receipts, state = AROUND.hear(state, one)
        assert set(receipts.tolist()) == {ACCEPTED}
    return state


def test_standing_it_has_the_stated_heading_and_accelerates_along_it() -> None:
    """It sets off with 2 m/s²: at 5 cm/s it has no course and no yaw rate yet."""
    bank = Bank((ConstantAcceleration(), CV))
    around = LocalDynamicMap((bank,))
    parameters = np.array([0.006, 0.008, 2.0, 0.006, 0.008])
    for heading in (0.3, 2.0, 4.0):
        message = replace(
            heard_messages([moving(parameters.tolist())], [10.0]), heading_rad=np.array([heading])
        )
        _, state = around.hear(around.init(), message)
        beliefs = around.believe(state, 10.02)
        assert beliefs.speed_mps[0] == pytest.approx(0.05, abs=1e-6)
        assert beliefs.heading_rad.tolist() == [heading]
        assert beliefs.yaw_rate_radps.tolist() == [0.0]
        along = 2.0 * (0.6 * math.sin(heading) + 0.8 * math.cos(heading))
        assert beliefs.acceleration_mps2[0] == pytest.approx(along, abs=1e-6)


@pytest.mark.parametrize(
    ("velocity", "heading"),
    [((0.0, 5.0), 0.0), ((5.0, 0.0), 0.5), ((0.0, -5.0), 1.0), ((-5.0, 0.0), 1.5), ((-5.0, 5.0), 1.75)],
)
def test_a_course_is_clockwise_from_north_within_one_turn(
    velocity: tuple[float, float], heading: float
) -> None:
    _, state = AROUND.hear(AROUND.init(), heard_messages([moving([*velocity, *REST])], [10.0]))
    assert AROUND.believe(state, 11.0).heading_rad[0] == pytest.approx(heading * math.pi)


@pytest.mark.parametrize(("speed_mps", "moves"), [(0.09, False), (0.11, True)])
def test_a_tenth_of_a_metre_a_second_is_a_course(speed_mps: float, moves: bool) -> None:
    message = replace(
        heard_messages([moving([speed_mps, 0.0, *REST])], [10.0]),
        speed_mps=np.array([speed_mps]),
        heading_rad=np.array([3.0]),
    )
    _, state = AROUND.hear(AROUND.init(), message)
    assert AROUND.believe(state, 11.0).heading_rad[0] == pytest.approx(math.pi / 2 if moves else 3.0)


# Plausibility through the map ------------------------------------------------------------------------------


def stated(
    times_s: Sequence[float],
    east_m: Sequence[float],
    speed_mps: Sequence[float],
    *,
    received_s: Sequence[float] | None = None,
) -> Heard:
    """One remote that goes east."""
    count = len(times_s)
    return plain(
        [7] * count,
        times_s,
        received_s=times_s if received_s is None else received_s,
        position_m=np.stack([np.array(east_m), np.zeros(count)], axis=1),
        speed_mps=np.array(speed_mps),
        heading_rad=np.full(count, math.pi / 2),
        message_count=np.arange(count),
    )


STEPS = 0.1 * np.arange(40)


@pytest.mark.parametrize(
    ("given", "last"),
    [
        (stated([0.0, 0.1], [0.0, 2.0], [20.0, 20.0]), Receipt.ACCEPTED),
        (stated([0.0, 0.0], [0.0, 2.0], [20.0, 20.0]), Receipt.REPEATED),
        (stated([0.0, -0.1], [0.0, 0.0], [20.0, 20.0], received_s=[0.0, 0.0]), Receipt.OLDER),
        (stated([0.15], [0.0], [20.0], received_s=[0.0]), Receipt.IN_FUTURE),
        (stated([0.0], [0.0], [20.0], received_s=[2.05]), Receipt.STALE),
        (stated([0.0, 0.1], [0.0, 11.0], [20.0, 20.0]), Receipt.POSITION_JUMP),
        (stated([0.0], [0.0], [70.5]), Receipt.SPEED_MISMATCH),
        (stated(STEPS[:12], 22.0 * STEPS[:12], 5.0 + np.sin(9.0 * STEPS[:12])), Receipt.SPEED_MISMATCH),
        (stated(STEPS, 22.0 * STEPS, np.full(40, 5.0)), Receipt.STUCK_SPEED),
    ],
    ids=lambda one: one.name if isinstance(one, Receipt) else "",
)
def test_each_finding_is_the_receipt_of_its_message_and_changes_no_belief(
    given: Heard, last: Receipt
) -> None:
    state = JUDGING.init()
    receipts = []
    for at in range(given.kind.size):
        one = replace(given, **{name: getattr(given, name)[at : at + 1] for name in given.__slots__})
        before = state.held.copy()
        out, state = JUDGING.hear(state, one)
        receipts.append(Receipt(out[0]))
        if receipts[-1] not in {Receipt.ACCEPTED, Receipt.REPEATED}:
            np.testing.assert_array_equal(state.held, before)
    assert receipts[-1] is last
    whole, _ = JUDGING.hear(JUDGING.init(), given)
    assert [Receipt(one) for one in whole.tolist()] == receipts
    assert Receipt.POSITION_JUMP not in receipts[:-1]


def test_an_identification_is_timed_by_plausibility_s_own_limits() -> None:
    update = moving([1.0, 0.0, *REST])
    for t_s, received_s, expected in (
        (11.0, 11.0, ACCEPTED),
        (11.2, 11.0, Receipt.IN_FUTURE),
        (10.5, 12.6, Receipt.STALE),
    ):
        named = SubModelIdentification(7, 3, t_s, in_use=0)
        for around, wanted in ((JUDGING, expected), (AROUND, ACCEPTED)):
            receipts, _ = around.hear(around.init(), heard_messages([update, named], [10.0, received_s]))
            assert receipts.tolist() == [ACCEPTED, wanted]


def test_remotes_are_judged_by_their_own_past_in_one_call_as_in_many() -> None:
    """Three remotes, kilometres apart; the second message of each is judged against its own first."""
    order, times = [5, 9, 2, 5, 9, 2], [10.0, 10.0, 10.0, 10.1, 10.1, 10.1]
    east = np.array([0.0, 1e4, -1e4, 0.5, 1e4 + 500.0, -1e4])
    given = plain(order, times, position_m=np.stack([east, np.zeros(6)], axis=1))
    expected = [ACCEPTED] * 4 + [Receipt.POSITION_JUMP, ACCEPTED]
    assert receipt(given, JUDGING) == expected


def test_a_velocity_not_stated_is_that_of_the_model_s_first_step() -> None:
    """A model that goes north at 20 m/s from places 2 m apart is plausible, 5 m apart it is not."""
    for step_m, expected in ((2.0, ACCEPTED), (5.0, Receipt.SPEED_MISMATCH)):
        messages = [
            moving(
                [0.0, 20.0 + math.sin(k), *REST],
                t_s=10.0 + 0.1 * k,
                sequence=k,
                position_m=np.array([0.0, step_m * k]),
            )
            for k in range(16)
        ]
        given = heard_messages(messages, [one.t_s for one in messages])
        assert receipt(given, JUDGING)[-1] is expected


# Covariances -----------------------------------------------------------------------------------------------


def parameters(seed: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.normal(0.0, 10.0, 2), rng.uniform(0.1, 1.0, len(REST))])


def test_each_covariance_is_that_of_its_own_profile_and_sub_model() -> None:
    """Believed together as alone: ages in intervals of their own, so nothing is interpolated.

    A plain message is calibrated as the first bank's sub-model that it is coasted by.
    """
    said = [(1, 0, 0, 10.0), (2, 0, 1, 10.4), (3, 1, 0, 10.9), (4, -1, 0, 11.5)]
    calibrations = tuple(
        {
            "cv": Calibration(
                "cv",
                np.array([1.0, 2.0]),
                unmodelled=0.0,
                factors=np.full((2, 2), factor),
                radii=np.array([[1.0, 2.1, 2.8]] * 2),
                instants=100,
            )
        }
        for factor in (2.0, 5.0)
    )
    around = LocalDynamicMap((BANK, NARROW), calibrations=calibrations)

    def heard(vehicle: int, profile: int, in_use: int, t_s: float) -> Heard:
        if profile < 0:
            return plain([vehicle], [t_s])
        own = parameters(vehicle)[: 2 if profile == 1 else None]
        message = moving(own.tolist(), vehicle=vehicle, t_s=t_s, in_use=in_use)
        return heard_messages([message], [t_s], profile=profile)

    together = around.init()
    for one in said:
        _, together = around.hear(together, heard(*one))
    found = around.believe(together, 12.0)
    for row, one in enumerate(said):
        alone = around.believe(around.hear(around.init(), heard(*one))[1], 12.0)
        np.testing.assert_allclose(found.covariance_m2[row], alone.covariance_m2[0], rtol=1e-9)
        own = (AROUND.profiles[one[1]] if one[1] >= 0 else NARROW).members[one[2]]
        calibration = calibrations[max(one[1], 0)].get(own.name)
        held = parameters(one[0])[own_columns(one[1], one[2])][None]
        age_s = np.array([12.0 - one[3]])
        expected = (
            own.covariance(held, age_s, dt_s=0.1)
            if calibration is None
            else calibration.covariance(own, held, age_s, dt_s=0.1)
        )
        np.testing.assert_allclose(found.covariance_m2[row], expected[0, 0], rtol=1e-9, atol=1e-15)


def own_columns(profile: int, in_use: int) -> slice:
    bank = BANK if profile == 0 else NARROW
    return slice(int(bank.offsets[in_use]), int(bank.offsets[in_use + 1]))


def test_within_an_interval_of_ages_covariances_are_interpolated_between_its_ends() -> None:
    """Three remotes of one model at ages of 1.00, 1.01 and 1.03 s: the one between is a third of the way."""
    ages = [1.03, 1.01, 1.0]
    messages = [
        moving([5.0, 2.0, *REST], vehicle=k, t_s=10.0 - age, sequence=k) for k, age in enumerate(ages)
    ]
    _, state = AROUND.hear(AROUND.init(), heard_messages(messages, [one.t_s for one in messages]))
    late, between, early = AROUND.believe(state, 10.0).covariance_m2[:, 0, 0]
    ends = CV.covariance(np.array([[5.0, 2.0]]), np.array([1.0, 1.03]), dt_s=0.1)[0, :, 0, 0]
    assert [early, late] == pytest.approx(ends.tolist(), rel=1e-9)
    assert between == pytest.approx(early + (late - early) / 3.0, rel=1e-6)
    assert late > early


# Slots -----------------------------------------------------------------------------------------------------


def test_the_index_finds_all_and_only_what_has_a_slot() -> None:
    """Forty slots and ids that all start their search at four places, in any order of coming and going."""
    around = LocalDynamicMap((NARROW,), capacity=40)
    slots = around.init().slots
    length = slots.lookup.size
    crowd = [one for one in range(20_000) if slot_kernels.place(one, length) in {0, 1, 5, length - 1}][:160]
    rng = np.random.default_rng(3)
    order: list[int] = []  # from the one renewed longest ago
    where: dict[int, int] = {}
    for vehicle in rng.choice(crowd, 1500).tolist():
        slot = slot_kernels.find_slot(slots, vehicle)
        assert slot == where.get(vehicle, -1)
        if slot < 0:
            if len(order) == 40:
                where.pop(order.pop(0))
            slot = slot_kernels.new_slot(slots, vehicle)
            assert slot not in where.values()
            assert slots.held[slot, 0] == -1.0
            assert np.isnan(slots.judged[slot, 0])
            where[vehicle] = slot
        else:
            order.remove(vehicle)
        slots.held[slot, 0], slots.judged[slot, 0] = 1.0, 1.0
        slot_kernels.renew_slot(slots, slot)
        order.append(vehicle)
        if rng.random() < 0.05:
            assert all(slot_kernels.find_slot(slots, one) == where.get(one, -1) for one in crowd)
    forget(slots.held[where[order[-1]]])
    assert slot_kernels.find_slot(slots, order[-1]) == where[order[-1]]


def test_a_full_table_counts_a_live_track_that_gives_way_and_no_dead_one() -> None:
    around = LocalDynamicMap((NARROW,), capacity=2, expiry_s=4.0)
    for wait_s, gave_way in ((0.5, 1), (3.9, 1), (4.1, 0)):
        state = around.init()
        for vehicle, t_s in ((1, 10.0), (2, 10.1), (1, 10.2), (3, 10.1 + wait_s)):
            _, state = around.hear(state, plain([vehicle], [t_s]))
        assert state.gave_way == gave_way
        assert 2 not in around.positions(state, 10.2)[0].tolist()
        assert around.positions(state, 10.1 + wait_s)[0].tolist() == [1, 3]

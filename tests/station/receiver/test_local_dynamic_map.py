"""Claims about the local dynamic map: what it holds follows from what arrived, and from nothing else."""

import math
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.frame_radio import copied
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.kinds import Kind
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import MessageKind
from modelcast.station.receiver import hearing_kernels, track_kernels
from modelcast.station.receiver.heard import Heard, HeardKind, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.study.case import TripCase, make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import draw_losses
from modelcast.trips.trajectory import Trajectory

CV = ConstantVelocity()
GP = GaussianProcess(form="intercept")
CTRA = ConstantTurnRateAcceleration()
BANK = Bank((CV, GP))
DAMPED = Bank((Trusted(GP, 0.7), CV))
AROUND = LocalDynamicMap((BANK,), expiry_s=3.0)

POSITION_M = 1e-9
"""Two ways to add up positions of kilometres in double precision."""

MPS = 0.005
"""A central difference over 0.05 s to either side, of a path with a jerk of 10 m/s³."""

RATE = 0.02
"""The same for its second derivative [m/s²] and yaw rate."""

ROUNDED = 1e-9
"""The age is a difference of two times; a Gaussian process is ill-conditioned."""

BETWEEN = 0.01
"""A variance that grows with the fourth power of the age, interpolated over a tenth of it."""


def fitted() -> FloatArray:
    """Parameters of both sub-models on a bend at 10 m/s, the newest sample heading east."""
    t = np.arange(-9, 1) * 0.1
    position = [20 * np.sin(t / 2), 20 * np.cos(t / 2)]
    velocity = [10 * np.cos(t / 2), -10 * np.sin(t / 2)]
    bend = np.stack([*position, *velocity, np.zeros(10), np.full(10, 0.5), np.zeros(10)], axis=1)
    return BANK.fit(Windows(bend[None], dt_s=0.1))[0, 1:]


FITTED = fitted()


def update(**changes: Any) -> ModelUpdate:
    message = ModelUpdate(
        7, 3, 10.0, position_m=np.array([100.0, 50.0]), in_use=0, parameters=FITTED, dt_s=0.1
    )
    return replace(message, **changes)


def identification(**changes: Any) -> SubModelIdentification:
    return replace(SubModelIdentification(7, 3, 11.0, in_use=1), **changes)


def taken(
    *messages: ModelUpdate | SubModelIdentification,
    state: MapState | None = None,
    received_s: float | None = None,
    around: LocalDynamicMap = AROUND,
) -> tuple[Receipt, MapState]:
    """The last receipt and the state after messages that arrive at once, or all at one time."""
    times = [one.t_s if received_s is None else received_s for one in messages]
    before = around.init() if state is None else copied(state)
    receipts, after = around.hear(before, heard_messages(messages, times))
    return Receipt(receipts[-1]), after


def plain(vehicle: Sequence[int], t_s: Sequence[float], **changes: Any) -> Heard:
    """Plain messages that arrive at once, of vehicles that go east at 20 m/s from the origin."""
    count = len(vehicle)
    times, unknown = np.array(t_s, dtype=np.float64), np.full(count, np.nan)
    given = Heard(
        np.full(count, int(HeardKind.PLAIN)),
        np.array(vehicle, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        t_s=times,
        received_s=times,
        position_m=np.stack([20.0 * times, 0.0 * times], axis=1),
        speed_mps=np.full(count, 20.0),
        heading_rad=np.full(count, math.pi / 2),
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.full(count, -1),
        in_use=np.zeros(count, dtype=np.int64),
        parameters=np.empty((count, 0)),
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )
    return replace(given, **changes)


def snapshot(state: MapState) -> list[FloatArray | IntArray]:
    """What a state holds, counts left out."""
    return [state.held, state.told, state.facts, state.parameters, state.lookup, state.ends]


# Updates and identifications -------------------------------------------------------------------------------


def test_an_update_is_predicted_by_the_sub_model_it_names() -> None:
    for member, model in enumerate((CV, GP)):
        receipt, state = taken(update(in_use=member))
        beliefs = AROUND.believe(state, 11.3)
        own = FITTED[slice(0, 2) if member == 0 else slice(2, None)]
        moved = model.predict_at(own[None], np.array([1.3]), dt_s=0.1)[0]
        assert receipt is Receipt.ACCEPTED
        assert beliefs.position_m[0] == pytest.approx(np.array([100.0, 50.0]) + moved, abs=POSITION_M)
        assert beliefs.information_age_s[0] == pytest.approx(1.3)
        assert (beliefs.vehicle.tolist(), beliefs.in_use.tolist(), beliefs.profile.tolist()) == (
            [7],
            [member],
            [0],
        )


def test_an_identification_changes_the_sub_model_and_nothing_else() -> None:
    receipt, state = taken(update(), identification())
    beliefs = AROUND.believe(state, 14.0)
    assert receipt is Receipt.ACCEPTED
    assert (beliefs.in_use.tolist(), beliefs.information_age_s.tolist()) == ([1], [4.0])


def test_an_identification_of_an_update_never_received_changes_no_belief() -> None:
    _, before = taken(update())
    receipt, state = taken(identification(sequence=4), state=before)
    assert receipt is Receipt.UNKNOWN_UPDATE
    for one, other in zip(snapshot(state), snapshot(before), strict=True):
        np.testing.assert_array_equal(one, other)
    receipt, state = taken(identification())
    assert receipt is Receipt.UNKNOWN_UPDATE
    assert AROUND.positions(state, 11.0)[0].size == 0


def test_it_does_not_keep_the_remote_alive() -> None:
    _, state = taken(update(), identification(sequence=4, t_s=12.0))
    assert AROUND.positions(state, 13.0)[0].tolist() == [7]
    assert AROUND.positions(state, 13.1)[0].tolist() == []


def test_a_silent_remote_expires_and_returns_with_its_next_update() -> None:
    _, state = taken(update())
    assert AROUND.positions(state, 13.0)[0].tolist() == [7]
    assert AROUND.positions(state, 13.1)[0].tolist() == []
    receipt, state = taken(identification(t_s=14.0), state=state)
    assert receipt is Receipt.UNKNOWN_UPDATE
    _, state = taken(update(t_s=20.0, sequence=4), state=state)
    assert AROUND.positions(state, 20.0)[0].tolist() == [7]


def test_remotes_are_kept_apart_and_listed_by_id() -> None:
    top = 2**32 - 1
    _, state = taken(
        update(vehicle=top),
        update(vehicle=2, t_s=10.5),
        identification(vehicle=top),
        update(vehicle=0, t_s=11.0),
    )
    beliefs = AROUND.believe(state, 11.0)
    assert beliefs.vehicle.tolist() == [0, 2, top]
    assert beliefs.in_use.tolist() == [0, 0, 1]
    assert beliefs.information_age_s == pytest.approx([0.0, 0.5, 1.0])
    ids, places = AROUND.positions(state, 11.0)
    assert ids.tolist() == beliefs.vehicle.tolist()
    np.testing.assert_array_equal(places, beliefs.position_m)


def test_no_remote_no_beliefs_and_no_message_no_change() -> None:
    receipts, state = AROUND.hear(AROUND.init(), heard_messages([], []))
    assert receipts.shape == (0,)
    beliefs = AROUND.believe(state, 1.0)
    assert beliefs.position_m.shape == (0, 2)
    assert beliefs.covariance_m2.shape == (0, 2, 2)


def test_an_older_update_is_refused_and_one_of_the_same_instant_only_tells_that_it_is_alive() -> None:
    _, before = taken(update())
    receipt, state = taken(update(t_s=9.9, sequence=2), state=before, received_s=12.0)
    assert receipt is Receipt.OLDER
    assert AROUND.positions(state, 13.1)[0].size == 0
    receipt, state = taken(update(sequence=4, position_m=np.zeros(2)), state=before, received_s=12.0)
    assert receipt is Receipt.REPEATED
    assert AROUND.positions(state, 10.0)[1].tolist() == [[100.0, 50.0]]
    assert AROUND.positions(state, 15.0)[0].size == 1


def test_a_message_count_that_jumps_backwards_locks_nobody_out() -> None:
    _, state = taken(update(sequence=120))
    for step, count in enumerate((121, 3, 2, 127, 0)):
        receipt, state = taken(update(sequence=count, t_s=10.1 + 0.1 * step), state=state)
        assert receipt is Receipt.ACCEPTED
        receipt, state = taken(identification(sequence=count, t_s=10.15 + 0.1 * step), state=state)
        assert receipt is Receipt.ACCEPTED


def test_an_identification_overtaken_by_a_newer_one_is_refused() -> None:
    _, state = taken(update(), identification(t_s=11.0), identification(t_s=12.0, in_use=0))
    receipt, state = taken(identification(t_s=11.0), state=state, received_s=12.1)
    assert receipt is Receipt.OLDER
    assert AROUND.believe(state, 12.1).in_use.tolist() == [0]


# Hostile messages ------------------------------------------------------------------------------------------

NAN, HUGE = math.nan, 1e308

HOSTILE = {
    "NaN time": update(t_s=NAN, sequence=4),
    "infinite time": update(t_s=math.inf, sequence=4),
    "NaN position": update(t_s=11.0, position_m=np.array([NAN, 0.0])),
    "infinite position": update(t_s=11.0, position_m=np.array([0.0, math.inf])),
    "position off the Earth": update(t_s=11.0, position_m=np.array([HUGE, 0.0])),
    "position north of the Earth": update(t_s=11.0, position_m=np.array([0.0, -2.1e7])),
    "NaN parameter": update(t_s=11.0, parameters=np.full(FITTED.size, NAN)),
    "infinite parameter": update(t_s=11.0, parameters=np.full(FITTED.size, math.inf)),
    "huge parameters": update(t_s=11.0, parameters=np.full(FITTED.size, HUGE), in_use=0),
    "huge parameters of another sub-model": update(t_s=11.0, parameters=np.full(FITTED.size, HUGE), in_use=1),
    "negative sub-model": update(t_s=11.0, in_use=-1),
    "unknown sub-model": update(t_s=11.0, in_use=2),
    "huge sub-model": update(t_s=11.0, in_use=2**62),
    "id beyond four bytes": update(t_s=11.0, vehicle=2**32),
    "negative id": update(t_s=11.0, vehicle=-1),
    "negative count": update(t_s=11.0, sequence=-1),
    "huge count": update(t_s=11.0, sequence=2**60),
    "identification of no sub-model": identification(in_use=-1),
    "identification of an unknown sub-model": identification(in_use=2),
    "identification at NaN": identification(t_s=NAN),
}


@pytest.mark.parametrize("message", HOSTILE.values(), ids=HOSTILE.keys())
def test_an_impossible_message_is_refused_and_changes_nothing(
    message: ModelUpdate | SubModelIdentification,
) -> None:
    _, before = taken(update())
    receipt, state = taken(message, state=before, received_s=11.0)
    assert receipt is Receipt.MALFORMED
    assert state.by_receipt == {Receipt.ACCEPTED: 1, Receipt.MALFORMED: 1}
    for one, other in zip(snapshot(state), snapshot(before), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "column",
    [
        {"speed_mps": -0.1},
        {"speed_mps": math.inf},
        {"speed_mps": math.nan},
        {"heading_rad": math.inf},
        {"heading_rad": 7.0},
        {"heading_rad": math.nan},
        {"acceleration_mps2": math.inf},
        {"acceleration_mps2": -101.0},
        {"yaw_rate_radps": -math.inf},
        {"length_m": -1.0},
        {"width_m": math.inf},
    ],
)
def test_a_plain_message_needs_a_possible_motion(column: dict[str, float]) -> None:
    heard = plain([7], [10.0], **{name: np.array([value]) for name, value in column.items()})
    receipts, state = AROUND.hear(AROUND.init(), heard)
    assert receipts.tolist() == [Receipt.MALFORMED]
    assert AROUND.positions(state, 10.0)[0].size == 0


@pytest.mark.parametrize("column", [{"kind": 3}, {"kind": -1}, {"profile": 1}, {"profile": -2}])
def test_a_kind_or_profile_that_is_none_is_refused(column: dict[str, int]) -> None:
    heard = heard_messages([update()], [10.0])
    changed = replace(heard, **{name: np.array([value]) for name, value in column.items()})
    assert AROUND.hear(AROUND.init(), changed)[0].tolist() == [Receipt.MALFORMED]


@pytest.mark.parametrize(
    ("dated_s", "receipt"),
    [
        (11.0, Receipt.ACCEPTED),
        (11.01, Receipt.IN_FUTURE),
        (1e12, Receipt.IN_FUTURE),
        (0.0, Receipt.ACCEPTED),
        (-0.01, Receipt.STALE),
    ],
)
def test_a_message_dated_far_from_its_arrival_is_refused_without_plausibility(
    dated_s: float, receipt: Receipt
) -> None:
    assert taken(update(t_s=dated_s), received_s=10.0)[0] is receipt
    _, state = taken(update(t_s=-5.0), received_s=0.0)
    around = replace(AROUND, expiry_s=math.inf)
    told, _ = taken(identification(t_s=dated_s), state=state, received_s=10.0, around=around)
    assert told is receipt


def test_a_copy_sent_again_much_later_does_not_bring_a_remote_back() -> None:
    _, state = taken(update())
    receipt, state = taken(update(), state=state, received_s=1000.0)
    assert receipt is Receipt.STALE
    assert AROUND.positions(state, 1000.0)[0].size == 0


def test_naming_a_sub_model_whose_parameters_give_no_place_changes_nothing() -> None:
    """The update itself is sound: what it has in use is. What it did not carry is no number."""
    for value in (HUGE, NAN):
        forged = FITTED.copy()
        forged[2:] = value
        receipt, before = taken(update(parameters=forged))
        assert receipt is Receipt.ACCEPTED
        receipt, state = taken(identification(), state=before)
        assert receipt is Receipt.MALFORMED
        for one, other in zip(snapshot(state), snapshot(before), strict=True):
            np.testing.assert_array_equal(one, other)


@given(st.integers(0, 2**32 - 1))
def test_any_bits_are_answered_and_every_belief_is_a_place_on_earth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 40
    odd = np.array([0.0, -1.0, NAN, math.inf, HUGE, -HUGE, 1e-308, 10.0, 2e7])

    def some(*shape: int) -> FloatArray:
        return np.where(rng.random(shape) < 0.2, rng.choice(odd, shape), rng.normal(0, 3, shape))

    def whole(low: int, high: int) -> IntArray:
        return np.where(rng.random(count) < 0.05, -(2**63), rng.integers(low, high, count))

    heard = Heard(
        whole(-1, 4), whole(-1, 5), whole(-1, 3), t_s=some(count), received_s=np.zeros(count),
        position_m=some(count, 2), speed_mps=np.abs(some(count)), heading_rad=some(count),
        acceleration_mps2=some(count), yaw_rate_radps=some(count), profile=whole(-2, 2), in_use=whole(-1, 4),
        parameters=some(count, FITTED.size), length_m=some(count), width_m=some(count), user=whole(-1, 9),
    )  # fmt: skip
    receipts, state = AROUND.hear(AROUND.init(), heard)
    assert sum(state.by_receipt.values()) == count
    assert set(receipts.tolist()) <= set(Receipt)
    beliefs = AROUND.believe(state, 2.0)
    assert (np.abs(beliefs.position_m) < 5e7).all()
    assert np.isfinite(beliefs.covariance_m2).all()


def test_settings_out_of_range_are_refused() -> None:
    for name in ("expiry_s", "max_ahead_s", "max_age_s"):
        for value in (0.0, -1.0, math.nan):
            with pytest.raises(ValueError, match=name):
                replace(AROUND, **{name: value})
    for value in (0.0, 1e-4, 11.0, math.nan):
        with pytest.raises(ValueError, match="dt_s"):
            replace(AROUND, dt_s=value)
    with pytest.raises(ValueError, match="capacity"):
        replace(AROUND, capacity=0)
    with pytest.raises(ValueError, match="calibrations"):
        replace(AROUND, calibrations=({}, {}))


def test_arrays_of_another_shape_or_order_are_refused() -> None:
    heard = heard_messages([update(), update()], [10.0, 11.0])
    for name in ("temporary_id", "t_s", "position_m", "parameters", "in_use"):
        with pytest.raises(ValueError, match=name):
            replace(heard, **{name: getattr(heard, name)[:1]})
    with pytest.raises(ValueError, match="parameters"):
        replace(heard, parameters=np.zeros(2))
    for times in ([11.0, 10.0], [10.0, NAN]):
        with pytest.raises(ValueError, match="received_s"):
            replace(heard, received_s=np.array(times))
    with pytest.raises(ValueError, match="parameters"):
        heard_messages([update(), update(parameters=FITTED[:-1])], [10.0, 11.0])


# Several profiles, and none --------------------------------------------------------------------------------


def test_each_remote_is_predicted_by_the_profile_it_names() -> None:
    other = Bank((CTRA, CV))
    around = LocalDynamicMap((BANK, other))
    own = np.zeros(FITTED.size)
    own[: len(CTRA.parameter_names)] = [5.0, 5.0, 1.0, 0.2]
    heard = replace(
        heard_messages([update(in_use=1), update(vehicle=8, parameters=own)], [10.0, 10.0]),
        profile=np.array([0, 1]),
    )
    receipts, state = around.hear(around.init(), heard)
    assert receipts.tolist() == [Receipt.ACCEPTED] * 2
    beliefs = around.believe(state, 12.0)
    age_s = np.array([2.0])
    wanted = [
        GP.predict_at(FITTED[None, 2:], age_s, dt_s=0.1)[0],
        CTRA.predict_at(own[None, :4], age_s, dt_s=0.1)[0],
    ]
    np.testing.assert_allclose(beliefs.position_m - [100.0, 50.0], wanted, atol=POSITION_M)
    assert (beliefs.profile.tolist(), beliefs.in_use.tolist()) == ([0, 1], [1, 0])
    assert state.by_part_i == 0


def test_without_the_profile_part_i_coasts_and_is_counted() -> None:
    heard = replace(
        plain([7, 8], [10.0, 10.0]),
        kind=np.array([HeardKind.PLAIN, HeardKind.UPDATE], dtype=np.int64),
        in_use=np.array([0, 5]),
        length_m=np.array([4.5, NAN]),
        width_m=np.array([1.8, NAN]),
        user=np.array([2, -1]),
    )
    receipts, state = AROUND.hear(AROUND.init(), heard)
    assert receipts.tolist() == [Receipt.ACCEPTED] * 2
    assert state.by_part_i == 2
    beliefs = AROUND.believe(state, 12.0)
    np.testing.assert_allclose(beliefs.position_m, [[240.0, 0.0]] * 2, atol=POSITION_M)
    assert beliefs.profile.tolist() == [-1, -1]
    assert beliefs.kind.tolist() == [Kind.CYCLIST, Kind.VEHICLE]
    np.testing.assert_array_equal(beliefs.length_m, [4.5, NAN])
    np.testing.assert_array_equal(beliefs.width_m, [1.8, NAN])
    # An identification of a profile not held tells that the remote is alive.
    receipt, state = taken(identification(sequence=0, t_s=12.0, in_use=5), state=state)
    assert receipt is Receipt.ACCEPTED
    assert AROUND.positions(state, 14.9)[0].tolist() == [7]


def test_a_remote_that_stands_needs_no_heading() -> None:
    still = plain([7], [10.0], speed_mps=np.zeros(1), heading_rad=np.array([NAN]))
    receipts, state = AROUND.hear(AROUND.init(), still)
    assert receipts.tolist() == [Receipt.ACCEPTED]
    beliefs = AROUND.believe(state, 12.0)
    assert beliefs.speed_mps.tolist() == beliefs.yaw_rate_radps.tolist() == [0.0]
    assert np.isnan(beliefs.heading_rad[0])
    told = replace(still, heading_rad=np.array([1.0]))
    assert AROUND.believe(AROUND.hear(AROUND.init(), told)[1], 12.0).heading_rad.tolist() == [1.0]


# Motion and covariance -------------------------------------------------------------------------------------


@pytest.mark.parametrize("age_s", [-0.02, 0.0, 0.03, 0.05, 1.0, 2.5])
def test_motion_is_that_of_the_sub_model_s_own_path(age_s: float) -> None:
    """Along a curve at 10 m/s, speeding up by 1 m/s² and turning right by 0.3 rad/s, from north-east."""
    around = LocalDynamicMap((Bank((CTRA,)),))
    speed, heading = 10.0, math.pi / 4
    parameters = np.array([speed * math.sin(heading), speed * math.cos(heading), 1.0, 0.3])
    _, state = taken(update(parameters=parameters), around=around)
    beliefs = around.believe(state, 10.0 + age_s)
    now, course = speed + age_s, heading + 0.3 * age_s
    assert beliefs.speed_mps[0] == pytest.approx(now, abs=MPS)
    velocity = [now * math.sin(course), now * math.cos(course)]
    assert beliefs.velocity_mps[0] == pytest.approx(velocity, abs=3 * MPS)
    assert beliefs.heading_rad[0] == pytest.approx(course, abs=MPS)
    assert beliefs.acceleration_mps2[0] == pytest.approx(1.0, abs=5 * RATE if age_s < 0.05 else RATE)
    assert beliefs.yaw_rate_radps[0] == pytest.approx(0.3, abs=RATE)


@pytest.mark.parametrize(("member", "model", "columns"), [(0, CV, slice(0, 2)), (1, GP, slice(2, None))])
def test_the_covariance_is_that_of_the_sub_model_in_use(
    member: int, model: AbstractSubModel, columns: slice
) -> None:
    _, state = taken(update(in_use=member))
    wanted = model.covariance(FITTED[None, columns], np.array([1.3]), dt_s=0.1)[0, 0]
    np.testing.assert_allclose(AROUND.believe(state, 11.3).covariance_m2[0], wanted, rtol=ROUNDED)


def test_remotes_of_any_ages_have_nearly_their_own_covariances() -> None:
    ages_s = np.linspace(0.01, 2.9, 200)
    messages = [update(vehicle=at, t_s=10.0 - age, in_use=at % 2) for at, age in enumerate(ages_s)][::-1]
    _, state = taken(*messages)
    beliefs = AROUND.believe(state, 10.0)
    for at, age_s in enumerate(beliefs.information_age_s):
        model, own = (CV, FITTED[None, :2]) if at % 2 == 0 else (GP, FITTED[None, 2:])
        wanted = model.covariance(own, np.array([age_s]), dt_s=0.1)[0, 0]
        np.testing.assert_allclose(beliefs.covariance_m2[at], wanted, rtol=BETWEEN, atol=1e-6)


def test_a_calibration_corrects_the_covariance_of_its_sub_model_alone() -> None:
    table = Calibration(
        "cv",
        np.array([1.0, 2.0]),
        unmodelled=0.0,
        factors=np.array([[2.0, 1.0], [2.0, 1.0]]),
        radii=np.array([[1.0, 2.1, 2.8], [1.0, 2.1, 2.8]]),
        instants=100,
    )
    around = replace(AROUND, calibrations=({"cv": table},))
    _, state = taken(update(), update(vehicle=8, in_use=1), around=around)
    calibrated, nominal = (one.believe(state, 11.0).covariance_m2 for one in (around, AROUND))
    wanted = table.covariance(CV, FITTED[None, :2], np.array([1.0]), dt_s=0.1)[0, 0]
    np.testing.assert_allclose(calibrated[0], wanted, rtol=1e-12)
    np.testing.assert_array_equal(calibrated[1], nominal[1])


def test_where_a_sub_model_gives_no_covariance_that_of_constant_velocity_stands_in() -> None:
    forged = FITTED.copy()
    names = GP.parameter_names
    for at, name in enumerate(names):
        if "variance" in name:
            forged[2 + at] = -1.0
    receipt, state = taken(update(in_use=1, parameters=forged))
    assert receipt is Receipt.ACCEPTED
    np.testing.assert_allclose(AROUND.believe(state, 12.0).covariance_m2[0], 4.0 * np.eye(2))


# Bounded tables --------------------------------------------------------------------------------------------


def test_when_full_the_remote_longest_unheard_gives_way_and_is_counted() -> None:
    def said(vehicle: int, t_s: float) -> ModelUpdate:
        return update(vehicle=vehicle, t_s=t_s, position_m=np.array([1000.0 * vehicle, 0.0]))

    around = replace(AROUND, capacity=3)
    _, state = taken(*(said(one, 10.0 + 0.1 * one) for one in range(3)), around=around)
    _, state = taken(said(0, 10.4), said(9, 10.5), state=state, around=around)
    assert around.positions(state, 10.5)[0].tolist() == [0, 2, 9]
    assert state.gave_way == 1
    receipt, state = taken(said(1, 20.0), state=state, around=around)
    assert receipt is Receipt.ACCEPTED
    assert state.gave_way == 1
    assert around.positions(state, 20.0)[0].tolist() == [1]


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["update", "update", "identification"]),
        st.integers(0, 11),
        st.integers(0, 2),
        st.integers(-2, 0).map(float),
        st.integers(0, 2).map(float),
    ),
    max_size=60,
)


@given(STEPS, st.integers(1, 6), st.integers(1, 60))
def test_any_messages_in_any_portions_are_taken_as_by_one_track_a_remote(
    steps: list[tuple[str, int, int, float, float]], capacity: int, portion: int
) -> None:
    """Ids collide in the table's index; the reference is a dictionary in the order of renewal."""
    around = LocalDynamicMap((Bank((CV,)),), expiry_s=3.0, capacity=capacity)
    state, now_s = around.init(), 0.0
    tracks: OrderedDict[int, FloatArray] = OrderedDict()
    messages: list[ModelUpdate | SubModelIdentification] = []
    times: list[float] = []
    wanted: list[int] = []
    for kind, who, count, age_s, gap_s in steps:
        now_s += gap_s
        vehicle, t_s = who << 24, now_s + age_s
        times.append(now_s)
        held = tracks.get(vehicle)
        if kind == "update":
            place = np.array([1e4 * who, t_s])
            messages.append(
                ModelUpdate(vehicle, count, t_s, position_m=place, in_use=0, parameters=np.ones(2), dt_s=0.1)
            )
            if held is None:
                if len(tracks) == capacity:
                    tracks.popitem(last=False)
                held = tracks[vehicle] = np.empty(track_kernels.TRACK_COLUMNS)
                track_kernels.forget(held)
            status = track_kernels.take_update(held, count, 0, t_s, now_s, 3.0)
            if status != Receipt.OLDER:
                tracks.move_to_end(vehicle)
        else:
            messages.append(SubModelIdentification(vehicle, count, t_s, in_use=0))
            if held is None:
                status = int(Receipt.UNKNOWN_UPDATE)
            else:
                status = track_kernels.take_identification(held, count, 0, t_s, now_s, 3.0)
            if status == Receipt.ACCEPTED:
                tracks.move_to_end(vehicle)
        wanted.append(status)
    told: list[int] = []
    for begin in range(0, len(messages), portion):
        part = slice(begin, begin + portion)
        receipts, state = around.hear(state, heard_messages(messages[part], times[part]))
        told += receipts.tolist()
    assert told == wanted
    live = sorted(one for one, held in tracks.items() if track_kernels.is_live(held, now_s, 3.0))
    ids, places = around.positions(state, now_s)
    assert ids.tolist() == live
    wanted_m = [[1e4 * (one >> 24) + now_s - tracks[one][track_kernels.HELD_FIT_S], now_s] for one in live]
    np.testing.assert_allclose(places, np.reshape(wanted_m, (-1, 2)), atol=POSITION_M)


def test_the_statuses_of_the_compiled_loop_are_the_receipts() -> None:
    names = {one.name: int(one) for one in Receipt}
    for module in (track_kernels, hearing_kernels):
        for name in set(module.__all__) & set(names):
            assert getattr(module, name) == names[name]
    assert len(names) == hearing_kernels.STATUSES
    assert len({one.reason for one in Receipt}) == len(Receipt)


# Against the evaluation ------------------------------------------------------------------------------------


@pytest.mark.real
@pytest.mark.parametrize(
    "bank", [pytest.param(BANK, id="whole", marks=pytest.mark.slow), pytest.param(DAMPED, id="damped")]
)
@pytest.mark.parametrize("name", ["TESLA_MODELX", pytest.param("MERCEDES_GLE450", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("identify", "expiry_s"),
    [
        pytest.param("best", math.inf, marks=pytest.mark.slow),
        pytest.param("never", 1.5, marks=pytest.mark.slow),
        ("best", 1.5),
    ],
)
def test_fed_message_by_message_it_believes_what_the_replay_says(
    identify: Literal["best", "never"],
    expiry_s: float,
    name: str,
    bank: Bank,
    dynamic_trips: dict[str, Trajectory],
) -> None:
    """Over a real trip at 40 % losses; the replay gives the error in its two parts."""
    trip = dynamic_trips[name]
    settings = EvaluationSettings((0.2,), (0.4,), bank=bank, identify=identify, protocol="recorded")
    case = make_case(trip, settings)
    sender = TripRuntime(case.seen, bank, case.estimator)
    walk = sender.run(settings.policy(0.2, keep_alive=True))
    lost = draw_losses(case, settings)[0, :1]
    errors = replayed(case, sender, walk, lost, expiry_s=expiry_s)
    number = np.cumsum(np.isin(walk.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE)))
    around = LocalDynamicMap((bank,), expiry_s=expiry_s, dt_s=trip.dt_s)
    state = around.init()
    for now, t_s in enumerate(trip.t_s):
        if walk.transmits[now] and not lost[0, now]:
            message = sent(sender, walk, now, int(number[now]))
            _, state = around.hear(state, heard_messages([message], [t_s]))
        beliefs = around.believe(state, t_s)
        assert (beliefs.vehicle.size == 0) == np.isnan(errors[0, now])
        if beliefs.vehicle.size:
            ahead = case.direction[now]
            off = errors[2, now] * ahead + errors[3, now] * np.array([-ahead[1], ahead[0]])
            assert np.abs(beliefs.position_m[0] - trip.position_m[now] - off).max() < POSITION_M
            assert beliefs.information_age_s[0] == pytest.approx(errors[4, now])
    assert (0 < np.isnan(errors[0]).sum() < len(trip)) == np.isfinite(expiry_s)


def sent(
    sender: TripRuntime, walk: TripMessages, now: int, number: int
) -> ModelUpdate | SubModelIdentification:
    """The message of this sample as it goes on the air."""
    t_s, used = float(sender.trip.t_s[now]), int(walk.in_use[now])
    if walk.kind[now] == MessageKind.IDENTIFICATION:
        return SubModelIdentification(1, number, t_s, in_use=used)
    return ModelUpdate(
        1,
        number,
        t_s,
        position_m=sender.trip.position_m[now],
        in_use=used,
        parameters=sender.parameters[now],
        dt_s=sender.trip.dt_s,
    )


def replayed(
    case: TripCase, sender: TripRuntime, walk: TripMessages, lost: BoolArray, *, expiry_s: float
) -> FloatArray:
    """The evaluation's replay in double precision: errors after, before, along, across, and age, (5, T)."""
    place_m, course = case.truth.position_m, case.direction
    return replay(sender, schedules_of([walk]), lost, place_m, course, expiry_s=expiry_s).errors[:, 0]

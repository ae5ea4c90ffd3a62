"""Claims about plausibility: what a vehicle can do is plausible, what none can do is found and counted."""

import json
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.frame_radio import copied
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.io.trips import read_trips
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateVelocity
from modelcast.station.receiver.heard import Heard, HeardKind, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.station.receiver.plausibility import Finding, Plausibility, PlausibilityState
from modelcast.station.receiver.plausibility_limits import PlausibilityLimits
from modelcast.station.receiver.statements import Statements, statements_of

LIMITS = PlausibilityLimits()
CHECKS = Plausibility()
_COLUMNS = ("vehicle", "t_s", "position_m", "velocity_mps", "received_s")


def reports(
    t_s: Any, position_m: Any, velocity_mps: Any, *, vehicle: int = 7, delay_s: float = 0.0
) -> Statements:
    """What one remote says, each message arriving after the same delay."""
    t = np.asarray(t_s, dtype=np.float64)
    return Statements(
        np.full(t.size, vehicle),
        t,
        position_m=np.asarray(position_m, dtype=np.float64).reshape(t.size, 2),
        velocity_mps=np.broadcast_to(np.asarray(velocity_mps, dtype=np.float64), (t.size, 2)).copy(),
        received_s=t + delay_s,
    )


def straight(count: int = 60, speed_mps: float = 20.0, *, stated_mps: float | None = None) -> Statements:
    """Eastwards at 10 Hz."""
    t = np.arange(count) * 0.1
    said = speed_mps if stated_mps is None else stated_mps
    return reports(t, np.stack([speed_mps * t, np.zeros(count)], axis=1), [said, 0.0])


def found(given: Statements, checks: Plausibility = CHECKS) -> list[Finding]:
    return [Finding(one) for one in checks.check(PlausibilityState(), given)[0]]


def changed(given: Statements, **columns: Any) -> Statements:
    return Statements(**{name: columns.get(name, getattr(given, name)) for name in _COLUMNS})


steps = st.lists(
    st.tuples(
        st.sampled_from([0.02, 0.1, 0.1, 0.3, 1.0]),
        *[st.tuples(st.floats(0, 10), st.floats(-np.pi, np.pi)) for _ in range(2)],
        *[st.tuples(st.floats(0, 1), st.floats(-np.pi, np.pi)) for _ in range(2)],
    ),
    min_size=1,
    max_size=25,
)


def polar(size_and_direction: tuple[float, float], unit: float = 1.0) -> FloatArray:
    size, direction = size_and_direction
    return unit * size * np.array([np.cos(direction), np.sin(direction)])


@given(steps)
def test_no_motion_within_the_limits_is_ever_found_implausible(
    steps: Sequence[tuple[float, tuple[float, float], tuple[float, float], Any, Any]],
) -> None:
    """Any acceleration up to 10 m/s², changing inside the steps, with errors up to the tolerances."""
    t_s, position_m, velocity_mps = 0.0, np.zeros(2), np.array([5.0, 0.0])
    rows = []
    for dt_s, first, second, off, wrong in steps:
        for push in (first, second):
            a = polar(push)
            half = 0.5 * dt_s
            position_m = position_m + velocity_mps * half + 0.5 * a * half**2
            velocity_mps = velocity_mps + a * half
        t_s += dt_s
        if np.hypot(*velocity_mps) > 65.0:
            break
        said = velocity_mps + polar(wrong, 0.999 * LIMITS.speed_tolerance_mps)
        rows.append((t_s, position_m + polar(off, 0.499 * LIMITS.position_tolerance_m), said))
    given = reports([r[0] for r in rows], [r[1] for r in rows], np.array([r[2] for r in rows]))
    assert set(found(given)) == {Finding.PLAUSIBLE}


@pytest.mark.parametrize(("excess_m", "finding"), [(-0.01, "PLAUSIBLE"), (0.01, "SPEED_MISMATCH")])
def test_the_bound_is_the_way_of_full_throttle_then_full_brakes(excess_m: float, finding: str) -> None:
    """Two messages 4 s apart: A dt²/4 farther than at their mean speed, and the two tolerances."""
    allowed_m = 10.0 * 4.0**2 / 4 + LIMITS.position_tolerance_m + 4.0 * LIMITS.speed_tolerance_mps
    far_m = 10.1 * 4.0 + allowed_m + excess_m
    assert (
        found(reports([0.0, 4.0], [[0.0, 0.0], [far_m, 0.0]], [[10.0, 0.0], [10.2, 0.0]]))[1].name == finding
    )


def test_a_speed_that_contradicts_the_displacement_is_found_within_a_second() -> None:
    t = np.arange(40) * 0.1
    varying = np.stack([5.0 + np.sin(5 * t), 0 * t], axis=1)
    findings = found(changed(straight(40), velocity_mps=varying))
    assert findings[0] is Finding.PLAUSIBLE
    assert set(findings[10:]) == {Finding.SPEED_MISMATCH}


@pytest.mark.parametrize("stated_mps", [0.0, 5.68, 35.0])
def test_a_stuck_speed_is_called_stuck_after_two_seconds(stated_mps: float) -> None:
    findings = found(straight(60, 22.0, stated_mps=stated_mps))
    assert set(findings[10:20]) == {Finding.SPEED_MISMATCH}
    assert set(findings[20:]) == {Finding.STUCK_SPEED}


def test_a_speed_stuck_a_little_off_shows_over_a_longer_way() -> None:
    """2 m/s off: 2 m/s T passes 3 m + (0.8 + 0.25) m/s T after 3.2 s."""
    findings = found(straight(100, 22.0, stated_mps=20.0))
    assert set(findings[:30]) == {Finding.PLAUSIBLE}
    assert set(findings[34:]) == {Finding.STUCK_SPEED}


def test_a_constant_speed_that_is_true_is_plausible() -> None:
    for speed_mps in (0.0, 13.0, 69.0):
        assert set(found(straight(400, speed_mps))) == {Finding.PLAUSIBLE}


def test_a_parked_car_with_a_wandering_position_is_plausible() -> None:
    t = np.arange(600) * 0.1
    wander = np.stack([np.cos(t / 3), np.sin(t / 5)], axis=1)
    assert set(found(reports(t, wander, [0.0, 0.0]))) == {Finding.PLAUSIBLE}


def test_constant_speed_in_a_circle_is_plausible() -> None:
    t = np.arange(300) * 0.1
    position = 20 * np.stack([np.sin(t / 2), np.cos(t / 2)], axis=1)
    velocity = 10 * np.stack([np.cos(t / 2), -np.sin(t / 2)], axis=1)
    assert set(found(reports(t, position, velocity))) == {Finding.PLAUSIBLE}


def test_a_speed_held_for_a_second_while_braking_is_plausible() -> None:
    t = np.arange(60) * 0.1
    speed = 30 - 4 * t
    position = np.stack([30 * t - 2 * t**2, 0 * t], axis=1)
    held = np.stack([speed[np.arange(60) // 10 * 10], 0 * t], axis=1)
    assert set(found(reports(t, position, held))) == {Finding.PLAUSIBLE}


def test_a_speed_that_recovers_is_plausible_again_after_one_good_window() -> None:
    given = straight(80, 22.0)
    given.velocity_mps[:40, 0] = 5.68
    findings = found(given)
    assert set(findings[5:40]) <= {Finding.SPEED_MISMATCH, Finding.STUCK_SPEED}
    assert set(findings[65:]) == {Finding.PLAUSIBLE}


def test_one_bad_fix_is_one_bad_message() -> None:
    given = straight()
    given.position_m[30] += [0.0, 25.0]
    findings = found(given)
    assert findings.pop(30) is Finding.POSITION_JUMP
    assert set(findings) == {Finding.PLAUSIBLE}


def test_a_move_that_lasts_is_believed_once_a_vehicle_could_have_made_it() -> None:
    given = straight()
    given.position_m[30:] += [0.0, 25.0]
    findings = found(given)
    # Sideways 25 m and onwards 2 m a step; 70 m/s and 3 m suffice from the fourth step on.
    assert findings[30:34] == [Finding.POSITION_JUMP] * 3 + [findings[33]]
    assert findings[33] is not Finding.POSITION_JUMP
    assert set(findings[55:]) == {Finding.PLAUSIBLE}


def test_a_message_dated_ahead_or_long_ago_is_found_and_not_remembered() -> None:
    given = straight(10)
    late = given.t_s.copy()
    late[3] -= LIMITS.max_ahead_s + 0.01
    late[5] += LIMITS.max_age_s + 0.01
    findings = found(changed(given, received_s=late))
    assert findings[3] is Finding.IN_FUTURE
    assert findings[5] is Finding.STALE
    assert {one for at, one in enumerate(findings) if at not in (3, 5)} == {Finding.PLAUSIBLE}


def test_a_recording_sent_again_later_is_stale() -> None:
    assert set(found(changed(straight(), received_s=straight().t_s + 60.0))) == {Finding.STALE}


def test_repeated_and_overtaken_messages_are_told_apart() -> None:
    given, order = straight(6), np.array([0, 1, 1, 3, 2, 3, 4])
    mixed = Statements(
        given.vehicle[order],
        given.t_s[order],
        position_m=given.position_m[order],
        velocity_mps=given.velocity_mps[order],
        received_s=np.full(7, 0.5),
    )
    assert [one.name for one in found(mixed)] == [
        "PLAUSIBLE",
        "PLAUSIBLE",
        "REPEATED",
        "PLAUSIBLE",
        "OVERTAKEN",
        "REPEATED",
        "PLAUSIBLE",
    ]


def test_no_vehicle_is_that_fast() -> None:
    assert set(found(straight(1, 0.0, stated_mps=71.0))) == {Finding.SPEED_MISMATCH}
    assert set(found(straight(5, 0.0, stated_mps=1e308))) == {Finding.SPEED_MISMATCH}


def test_a_velocity_not_stated_is_not_judged() -> None:
    given = straight()
    given.velocity_mps[20:40] = np.nan
    assert set(found(given)) == {Finding.PLAUSIBLE}
    assert set(found(changed(given, velocity_mps=np.full((60, 2), np.nan)))) == {Finding.PLAUSIBLE}


def interleaved(*given: Statements) -> Statements:
    order = np.argsort(np.concatenate([one.received_s for one in given]), kind="stable")
    return Statements(
        **{name: np.concatenate([getattr(one, name) for one in given])[order] for name in _COLUMNS}
    )


@given(st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_remotes_are_judged_alike_alone_and_among_others_and_in_any_portions(size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    alone = [
        reports(
            t := np.sort(rng.uniform(0, 5, 20)), rng.normal(0, 6, (20, 2)) + t[:, None], rng.normal(0, 9, 2)
        )
        for _ in range(3)
    ]
    alone = [changed(one, vehicle=np.full(20, 5 * at)) for at, one in enumerate(alone)]
    together = interleaved(*alone)
    state, portions = PlausibilityState(), []
    for begin in range(0, 60, size):
        part = slice(begin, begin + size)
        findings, state = CHECKS.check(
            state, Statements(**{name: getattr(together, name)[part] for name in _COLUMNS})
        )
        portions.append(findings)
    whole = np.concatenate(portions)
    assert state.counts.sum() == 60
    for at, one in enumerate(alone):
        assert whole[together.vehicle == 5 * at].tolist() == found(one)


def test_the_given_state_is_left_alone() -> None:
    _, state = CHECKS.check(PlausibilityState(), straight(10))
    before = state.rows.copy(), state.counts.copy()
    CHECKS.check(state, changed(straight(10), t_s=straight(10).t_s + 1.0))
    np.testing.assert_array_equal(state.rows, before[0])
    np.testing.assert_array_equal(state.counts, before[1])


def test_a_silent_remote_is_forgotten() -> None:
    _, state = CHECKS.check(PlausibilityState(), straight(3))
    other = changed(reports([70.0], [[0.0, 0.0]], [0.0, 0.0]), vehicle=np.array([8]))
    _, state = CHECKS.check(state, other)
    assert state.vehicle.tolist() == [8]
    assert state.by_reason == {Finding.PLAUSIBLE: 4}


def test_every_finding_has_its_words() -> None:
    assert len({one.reason for one in Finding}) == len(Finding)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_impossible_settings_are_refused(value: float) -> None:
    with pytest.raises(ValueError, match="window_s"):
        PlausibilityLimits(window_s=value)
    with pytest.raises(ValueError, match="memory_s"):
        Plausibility(memory_s=value)


@pytest.mark.parametrize(
    "columns",
    [
        {"t_s": np.array([np.nan])},
        {"position_m": np.array([[np.inf, 0.0]])},
        {"velocity_mps": np.array([[np.inf, 0.0]])},
        {"received_s": np.zeros(2)},
    ],
    ids=lambda columns: next(iter(columns)),
)
def test_impossible_reports_are_refused(columns: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(columns))):
        changed(straight(1), **columns)


# The map ---------------------------------------------------------------------------------------------------

BANK = Bank((ConstantVelocity(),))
AROUND = LocalDynamicMap((BANK,), plausibility=CHECKS)
UNJUDGED = LocalDynamicMap((BANK,))
RECEIPTS = {
    Finding.PLAUSIBLE: Receipt.ACCEPTED,
    Finding.IN_FUTURE: Receipt.IN_FUTURE,
    Finding.STALE: Receipt.STALE,
    Finding.REPEATED: Receipt.REPEATED,
    Finding.OVERTAKEN: Receipt.OLDER,
    Finding.POSITION_JUMP: Receipt.POSITION_JUMP,
    Finding.SPEED_MISMATCH: Receipt.SPEED_MISMATCH,
    Finding.STUCK_SPEED: Receipt.STUCK_SPEED,
}


def updates(given: Statements) -> Heard:
    """Messages with a model: position, and the velocity as that of constant velocity."""
    sent = [
        ModelUpdate(
            int(given.vehicle[at]),
            at,
            float(given.t_s[at]),
            position_m=given.position_m[at],
            in_use=0,
            parameters=given.velocity_mps[at],
            dt_s=0.1,
        )
        for at in range(given.t_s.size)
    ]
    return heard_messages(sent, given.received_s)


def plain(given: Statements) -> Heard:
    """Messages by Part I alone: position, speed and heading."""
    velocity_mps = given.velocity_mps
    return replace(
        updates(given),
        kind=np.full(given.t_s.size, int(HeardKind.PLAIN)),
        speed_mps=np.hypot(*velocity_mps.T),
        heading_rad=np.arctan2(velocity_mps[:, 0], velocity_mps[:, 1]),
    )


def receipts(given: Statements, around: LocalDynamicMap = AROUND) -> tuple[list[Receipt], MapState]:
    out, state = around.hear(around.init(), updates(given))
    return [Receipt(one) for one in out], state


def named(t_s: float, received_s: float, state: MapState) -> Receipt:
    """What becomes of an identification of the last of twenty updates."""
    message = heard_messages([SubModelIdentification(7, 19, t_s, in_use=0)], [received_s])
    return Receipt(AROUND.hear(copied(state), message)[0][0])


def broken() -> Statements:
    """What a remote says that has every fault there is; they all arrive in order."""
    given = straight(70, 22.0)
    given.velocity_mps[30:, 0] = 5.68
    given.position_m[10] += 30.0
    t_s, received_s = given.t_s.copy(), given.received_s.copy()
    t_s[15] = t_s[14]
    t_s[17] = t_s[14] - 0.05
    t_s[19] += LIMITS.max_ahead_s + 0.01
    t_s[21] -= LIMITS.max_age_s + 0.01
    return changed(given, t_s=t_s, received_s=received_s)


@pytest.mark.parametrize("heard", [updates, plain])
def test_every_finding_is_a_receipt_of_the_map_and_is_counted(heard: Callable[[Statements], Heard]) -> None:
    given = broken()
    out, state = AROUND.hear(AROUND.init(), heard(given))
    told = [Receipt(one) for one in out]
    findings = found(given)
    assert told == [RECEIPTS[one] for one in findings]
    assert set(findings) == set(Finding)
    assert state.by_receipt == {one: told.count(one) for one in set(told)}
    assert sum(state.by_receipt.values()) == 70


@given(st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_the_map_judges_every_remote_like_plausibility_alone_in_any_portions(size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    alone = [
        changed(
            reports(
                t := rng.permutation(np.sort(rng.uniform(0, 3, 20))),
                rng.normal(0, 3, (20, 2)) + 2.0 * t[:, None],
                rng.choice([[2.0, 2.0], [2.0, 9.0]], 20),
            ),
            vehicle=np.full(20, 5 * at),
            received_s=np.sort(rng.uniform(0, 5, 20)),
        )
        for at in range(3)
    ]
    together = interleaved(*alone)
    messages, state, told = updates(together), AROUND.init(), list[int]()
    for begin in range(0, 60, size):
        part = slice(begin, begin + size)
        columns = {one.name: getattr(messages, one.name)[part] for one in fields(messages)}
        out, state = AROUND.hear(state, Heard(**columns))
        told += out.tolist()
    assert told == [RECEIPTS[one] for one in found(together)]


@pytest.mark.parametrize("finding", [one for one in Finding if one is not Finding.PLAUSIBLE])
def test_an_implausible_message_moves_no_track_and_keeps_none_alive(finding: Finding) -> None:
    given = broken()
    at = found(given).index(finding)
    parts = [
        changed(given, **{name: getattr(given, name)[part] for name in _COLUMNS})
        for part in (slice(0, at), slice(at, at + 1))
    ]
    _, before = AROUND.hear(AROUND.init(), updates(parts[0]))
    out, after = AROUND.hear(copied(before), updates(parts[1]))
    assert Receipt(out[0]) is RECEIPTS[finding]
    for name in ("held", "told", "facts", "parameters", "ends"):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    silent_s = float(given.received_s[at - 1]) + AROUND.expiry_s + 0.05
    assert AROUND.positions(after, silent_s)[0].size == 0


def test_a_remote_that_begins_implausibly_is_not_held() -> None:
    told, state = receipts(straight(5, 0.0, stated_mps=71.0))
    assert set(told) == {Receipt.SPEED_MISMATCH}
    assert AROUND.positions(state, 0.5)[0].size == 0


def test_identifications_are_asked_for_their_times_alone() -> None:
    _, state = receipts(straight(20))
    assert named(2.2, 2.05, state) is Receipt.IN_FUTURE
    assert named(2.2, 2.2, state) is Receipt.ACCEPTED
    assert named(2.2, 4.3, state) is Receipt.STALE
    _, unjudged = receipts(straight(20), UNJUDGED)
    message = heard_messages([SubModelIdentification(7, 19, 2.2, in_use=0)], [2.05])
    assert Receipt(UNJUDGED.hear(unjudged, message)[0][0]) is Receipt.ACCEPTED


def test_a_remote_forgotten_by_plausibility_begins_anew() -> None:
    """A jump of 6 km a second after a minute of silence: nothing is left to compare it with."""
    checks = Plausibility(memory_s=60.0)
    around = LocalDynamicMap((BANK,), plausibility=checks)
    for silent_s, receipt in ((59.9, Receipt.POSITION_JUMP), (60.1, Receipt.ACCEPTED)):
        told, _ = receipts(reports([0.0, silent_s], [[0.0, 0.0], [6000.0, 0.0]], [0.0, 0.0]), around)
        assert told == [Receipt.ACCEPTED, receipt]


def test_without_constant_velocity_the_sub_model_in_use_states_the_speed() -> None:
    """Its parameters of zero predict a vehicle at rest; the positions say otherwise."""
    bank = Bank((ConstantTurnRateVelocity(),))
    around = LocalDynamicMap((bank,), plausibility=CHECKS)
    given = straight(30, 22.0)
    messages = replace(updates(given), parameters=np.zeros((30, len(bank.parameter_names) - 1)))
    told, _ = around.hear(around.init(), messages)
    assert told[0] == Receipt.ACCEPTED
    assert told[-1] == Receipt.STUCK_SPEED


def test_without_the_option_nothing_is_judged() -> None:
    told, state = receipts(straight(60, 22.0, stated_mps=5.68), UNJUDGED)
    assert set(told) == {Receipt.ACCEPTED}
    assert np.isnan(state.judged[:, 0]).all()


# Real messages ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def new_york(data_folder: Path) -> dict[str, Statements]:
    """The messages of an event in the order they were recorded, by vehicle; ``all`` for both together."""
    event = json.loads((data_folder / "nyc_cvpd/nycdot-fcw-event.json").read_text(encoding="utf-8"))
    cores = [message["bsmRecord"]["bsmMsg"]["coreData"] for message in event["bsmList"]]
    return {
        name: _stream([core for core in cores if name in (core["id"], "all")])
        for name in ("C7D30386", "A305214A", "all")
    }


def _stream(cores: list[dict[str, Any]]) -> Statements:
    t_s = np.array([core["T_s"] for core in cores])
    heading = np.radians([core["heading_deg"] for core in cores])
    speed = np.array([core["speed_mps"] for core in cores])
    ids: IntArray = np.array([int(core["id"], 16) for core in cores])
    return Statements(
        ids,
        t_s,
        position_m=np.array([[core["X_m"], core["Y_m"]] for core in cores]),
        velocity_mps=np.stack([speed * np.sin(heading), speed * np.cos(heading)], axis=1),
        received_s=t_s,
    )


@pytest.mark.real
def test_new_york_s_stuck_speed_is_found_and_the_other_vehicle_is_not(
    new_york: dict[str, Statements],
) -> None:
    """Counts by reason, repeated messages among them."""
    _, sound = CHECKS.check(PlausibilityState(), new_york["C7D30386"])
    assert sound.by_reason == {Finding.PLAUSIBLE: 159, Finding.REPEATED: 2}
    _, broken = CHECKS.check(PlausibilityState(), new_york["A305214A"])
    assert broken.by_reason == {
        Finding.PLAUSIBLE: 2,
        Finding.REPEATED: 1,
        Finding.SPEED_MISMATCH: 17,
        Finding.STUCK_SPEED: 141,
    }


@pytest.mark.real
def test_the_map_refuses_new_york_s_stuck_speed(new_york: dict[str, Statements]) -> None:
    """Taken in as recorded, each when all before it had arrived."""
    given = new_york["all"]
    told, state = receipts(changed(given, received_s=np.maximum.accumulate(given.received_s)))
    assert told.count(Receipt.ACCEPTED) == 161
    assert told.count(Receipt.STUCK_SPEED) == 141
    end_s = float(given.t_s.max())
    assert AROUND.positions(state, end_s)[0].tolist() == [0xC7D30386]


@pytest.mark.real
@pytest.mark.parametrize("name", ["spmd/bsm_p1_dev.csv", "comma2k19"])
def test_recorded_trips_with_speed_and_heading_are_plausible_throughout(data_folder: Path, name: str) -> None:
    """Coarse position grids, speeds held for a second, lost epochs: none of it is called implausible."""
    judged = 0
    for trip in read_trips(data_folder / name):
        given = statements_of(trip)
        if given is not None:
            assert set(found(given)) == {Finding.PLAUSIBLE}
            judged += given.t_s.size
    assert judged > 500

"""Claims about remotes that change their temporary id: the old track ends, and nothing is mixed up."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.mbc import ModelUpdate
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.station.receiver.heard import Heard, HeardKind, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt

CTRA = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
AROUND = LocalDynamicMap((CTRA,))

PLACE_M, SPEED_MPS, COURSE_RAD, SILENT_S, OLDEST_S = 3.0, 3.0, math.radians(30.0), 0.05, 3.0
"""The gate, as documented."""


class Said(NamedTuple):
    """A plain message that arrives at once."""

    vehicle: int
    t_s: float
    east_m: float
    north_m: float = 0.0
    speed_mps: float = 20.0
    heading_rad: float = math.pi / 2


def heard(said: Sequence[Said], **late: Sequence[float]) -> Heard:
    """The messages in order; ``received_s`` may be given."""
    columns = np.array(said, dtype=np.float64).reshape(-1, 6)
    count, unknown = len(said), np.full(len(said), np.nan)
    return Heard(
        np.full(count, int(HeardKind.PLAIN)),
        columns[:, 0].astype(np.int64),
        np.zeros(count, dtype=np.int64),
        t_s=columns[:, 1],
        received_s=np.array(late.get("received_s", columns[:, 1])),
        position_m=columns[:, 2:4],
        speed_mps=columns[:, 4],
        heading_rad=columns[:, 5],
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.full(count, -1),
        in_use=np.zeros(count, dtype=np.int64),
        parameters=np.empty((count, 0)),
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )


def after(*batches: Sequence[Said]) -> MapState:
    state = AROUND.init()
    for batch in batches:
        receipts, state = AROUND.hear(state, heard(batch))
        assert set(receipts.tolist()) <= {Receipt.ACCEPTED}
    return state


def believed(state: MapState, t_s: float) -> list[int]:
    return AROUND.positions(state, t_s)[0].tolist()


@pytest.mark.parametrize("apart", [True, False], ids=["call by call", "in one call"])
def test_a_vehicle_that_goes_on_under_another_id_is_held_once(apart: bool) -> None:
    said = [Said(1, 10.0, 0.0), Said(2, 10.1, 2.0), Said(2, 10.2, 4.0)]
    state = after(*([one] for one in said)) if apart else after(said)
    assert (believed(state, 10.2), state.renamed) == ([2], 1)


def test_an_id_that_comes_back_takes_its_place_again() -> None:
    state = after([Said(1, 10.0, 0.0)], [Said(2, 10.1, 2.0)], [Said(1, 10.2, 4.0)])
    assert (believed(state, 10.2), state.renamed) == ([1], 2)


def test_an_older_message_of_an_id_that_ended_changes_no_other_track() -> None:
    """It was on its way: it is taken for what it says, beside a track that goes on."""
    state = after([Said(1, 10.0, 0.0)], [Said(2, 10.1, 2.0)], [Said(2, 10.2, 4.0)])
    receipts, state = AROUND.hear(state, heard([Said(1, 10.05, 1.0)], received_s=[10.21]))
    assert receipts.tolist() == [Receipt.ACCEPTED]
    assert believed(state, 10.3) == [1, 2]


def test_a_whole_column_that_renames_itself_at_once_is_held_once() -> None:
    """Three lanes, 7 m apart in each: everybody takes another's old number plus 100."""
    places = [(7.0 * (at % 10), 3.5 * (at // 10)) for at in range(30)]
    old = [Said(at, 10.0, *place) for at, place in enumerate(places)]
    new = [Said(129 - at, 10.1, place[0] + 2.0, place[1]) for at, place in enumerate(places)]
    state = after(old, new)
    assert (believed(state, 10.1), state.renamed) == (list(range(100, 130)), 30)
    where = AROUND.positions(state, 10.1)[1]
    np.testing.assert_allclose(where[::-1], [(east + 2.0, north) for east, north in places])


def test_nobody_beside_ends_a_track_that_still_speaks() -> None:
    """A newcomer at its very place, and it speaks in the same tenth of a second, before or after."""
    for batch in ([Said(1, 10.1, 2.0), Said(2, 10.1, 2.0)], [Said(2, 10.1, 2.0), Said(1, 10.1, 2.0)]):
        state = after([Said(1, 10.0, 0.0)], batch)
        assert (believed(state, 10.1), state.renamed) == ([1, 2], 0)


@pytest.mark.parametrize("inside", [True, False])
@pytest.mark.parametrize("gate", ["ahead", "beside", "speed", "course", "silence", "age"])
def test_the_gate_is_as_documented(gate: str, inside: bool) -> None:
    share = 0.99 if inside else 1.01
    t_s = 10.0 + {"silence": SILENT_S / share, "age": OLDEST_S * share}.get(gate, 0.1)
    new = Said(
        2,
        t_s,
        20.0 * (t_s - 10.0) + (PLACE_M * share if gate == "ahead" else 0.0),
        -PLACE_M * share if gate == "beside" else 0.0,
        20.0 + (SPEED_MPS * share if gate == "speed" else 0.0),
        math.pi / 2 + (COURSE_RAD * share if gate == "course" else 0.0),
    )
    state = after([Said(1, 10.0, 0.0)], [new])
    assert believed(state, t_s) == ([2] if inside else [1, 2])


@pytest.mark.parametrize("speed_mps", [1.9, 2.1])
def test_who_hardly_moves_has_no_course(speed_mps: float) -> None:
    state = after(
        [Said(1, 10.0, 0.0, speed_mps=speed_mps)], [Said(2, 10.1, 0.2, speed_mps=speed_mps, heading_rad=0.0)]
    )
    assert believed(state, 10.1) == ([2] if speed_mps < 2.0 else [1, 2])


def test_a_message_of_the_time_before_the_track_s_ends_nothing() -> None:
    state = after([Said(1, 10.0, 0.0)])
    _, state = AROUND.hear(state, heard([Said(2, 9.95, -1.0)], received_s=[10.2]))
    assert believed(state, 10.2) == [1, 2]


def test_an_expired_track_does_not_end_twice() -> None:
    around = LocalDynamicMap(expiry_s=0.5)
    _, state = around.hear(around.init(), heard([Said(1, 10.0, 0.0)]))
    _, state = around.hear(state, heard([Said(2, 10.6, 12.0)]))
    assert state.renamed == 0


def test_two_new_ids_never_end_one_track_together_nor_one_new_id_two_tracks() -> None:
    state = after([Said(1, 10.0, 0.0)], [Said(2, 10.1, 3.0), Said(3, 10.1, 2.5)])
    assert (believed(state, 10.1), state.renamed) == ([2, 3], 1)
    state = after([Said(1, 10.0, 0.0), Said(5, 10.0, 1.5)], [Said(2, 10.1, 2.5)])
    assert (believed(state, 10.1), state.renamed) == ([2, 5], 1)


def test_the_model_in_use_says_where_the_track_went() -> None:
    """On a bend of 20 m at 10 m/s, 2 s on: 10 m beside where it would coast to."""
    turning = np.array([[10.0, 0.0, 0.0, -0.5, 10.0, 0.0]])
    base = heard([Said(1, 10.0, 0.0, speed_mps=10.0)])
    none = np.zeros(1, dtype=np.int64)
    update = replace(base, kind=none, profile=none, parameters=turning)
    _, state = AROUND.hear(AROUND.init(), update)
    east, north = 20.0 * math.sin(1.0), 20.0 * (1.0 - math.cos(1.0))
    state_after = AROUND.hear(state, heard([Said(2, 12.0, east, north, 10.0, math.pi / 2 - 1.0)]))[1]
    assert (believed(state_after, 12.0), state_after.renamed) == ([2], 1)


@pytest.mark.parametrize(
    ("away_m", "slower_mps", "ends"),
    [(3.0, 0.0, True), (3.0001, 0.0, False), (0.0, 3.0, True), (0.0, 3.0001, False)],
)
def test_at_the_bound_itself_both_agree(away_m: float, slower_mps: float, ends: bool) -> None:
    """Old track standing at the place where it is exactly known; new id beside it, at one instant."""
    state = after([Said(1, 10.0, 0.0, speed_mps=0.0)], [Said(2, 10.25, away_m, speed_mps=slower_mps)])
    assert state.renamed == ends


def test_who_hardly_moves_has_no_course_whatever_the_other_does() -> None:
    """One at 1.9 m/s, the other at 4 m/s the opposite way: no course is compared."""
    state = after(
        [Said(1, 10.0, 0.0, speed_mps=1.9)],
        [Said(2, 10.1, 0.0, speed_mps=4.0, heading_rad=1.5 * math.pi)],
    )
    assert state.renamed == 1
    state = after(
        [Said(1, 10.0, 0.0, speed_mps=2.1)],
        [Said(2, 10.1, 0.0, speed_mps=4.0, heading_rad=1.5 * math.pi)],
    )
    assert state.renamed == 0


def test_an_id_that_is_known_ends_no_track() -> None:
    """Whether it holds the first slot or another: two cars one behind the other, one falls silent."""
    for first, second in ((1, 2), (2, 1)):
        state = after(
            [Said(first, 10.0, 0.0)], [Said(second, 10.0, 5.0)], [Said(1, 10.1, 5.0)], [Said(1, 10.2, 7.0)]
        )
        assert (state.renamed, believed(state, 10.2)) == (0, [1, 2])


def test_an_id_of_an_expired_track_is_new_again() -> None:
    state = after([Said(1, 10.0, 0.0)], [Said(2, 30.0, 400.0)], [Said(1, 30.2, 404.0)])
    assert (state.renamed, believed(state, 30.2)) == (1, [1])


def test_a_message_long_on_its_way_is_compared_at_the_time_it_states() -> None:
    state = AROUND.init()
    _, state = AROUND.hear(state, heard([Said(1, 10.0, 0.0)]))
    _, state = AROUND.hear(state, heard([Said(2, 10.2, 4.0)], received_s=[12.9]))
    assert (state.renamed, believed(state, 12.9)) == (1, [2])


def updated(vehicle: int, t_s: float, place: Sequence[float], parameters: Sequence[float]) -> ModelUpdate:
    """An update whose first sub-model turns and accelerates."""
    return ModelUpdate(
        vehicle,
        vehicle,
        t_s,
        position_m=np.array(place),
        in_use=0,
        parameters=np.array([*parameters, *parameters[:2]]),
        dt_s=0.1,
    )


def agreed_m(old: ModelUpdate, new: ModelUpdate) -> float:
    """Distance at the new id's instant, infinite where the two disagree: the gate in plain words."""
    silent_s = new.t_s - old.t_s
    if not (silent_s >= SILENT_S and 0.0 <= silent_s <= OLDEST_S):
        return math.inf
    model = CTRA.members[0]

    def moved(one: ModelUpdate, age_s: float) -> FloatArray:
        return model.predict_at(one.parameters[None, :4].copy(), np.array([age_s]), dt_s=0.1)[0]

    place = old.position_m + moved(old, silent_s)
    velocity = (moved(old, silent_s + 0.05) - moved(old, silent_s)) / 0.05
    other = moved(new, 0.1) / 0.1
    away_m, speeds = np.hypot(*(place - new.position_m)), (np.hypot(*velocity), np.hypot(*other))
    if away_m > PLACE_M or abs(speeds[0] - speeds[1]) > SPEED_MPS:
        return math.inf
    turned = float(velocity @ other) < 0.866 * speeds[0] * speeds[1]
    return math.inf if min(speeds) > 2.0 and turned else float(away_m)


@pytest.mark.parametrize("seed", range(12))
def test_all_new_ids_of_a_call_and_all_tracks_choose_each_other_as_by_hand(seed: int) -> None:
    """Cars that turn and accelerate by up to 10 m/s² in all, silent up to three seconds."""
    rng = np.random.default_rng(seed)
    count = 14
    olds = [
        updated(
            k,
            10.0 + rng.uniform(0.0, 0.5),
            rng.uniform(-60.0, 60.0, 2),
            [*rng.normal(0.0, 12.0, 2), rng.uniform(-6.0, 6.0), rng.uniform(-0.15, 0.15)],
        )
        for k in range(count)
    ]
    olds.sort(key=lambda one: one.t_s)
    model, news = CTRA.members[0], list[ModelUpdate]()
    spread_s = 2.4 if seed % 2 else 0.05
    for k, old in enumerate(olds):
        t_s = 10.6 + rng.uniform(0.0, spread_s) + (2.2 if seed % 3 == 0 else 0.0)
        own = old.parameters[None, :4].copy()
        there, later = (
            model.predict_at(own, np.array([t_s - old.t_s + ahead_s]), dt_s=0.1)[0] for ahead_s in (0.0, 0.1)
        )
        place = old.position_m + there + rng.normal(0.0, 1.6, 2)
        velocity = (later - there) / 0.1 + rng.normal(0.0, 1.5, 2)
        news.append(updated(100 + k, t_s, place, [*velocity, 0.0, 0.0]))
    news.sort(key=lambda one: one.t_s)
    around = LocalDynamicMap((CTRA,), expiry_s=20.0)
    state = around.init()
    _, state = around.hear(state, heard_messages(olds, [one.t_s for one in olds]))
    gaps = np.array([[agreed_m(old, new) for new in news] for old in olds])
    ends = {
        (olds[row].vehicle, news[int(gaps[row].argmin())].vehicle)
        for row in range(count)
        if np.isfinite(gaps[row].min()) and gaps[:, gaps[row].argmin()].argmin() == row
    }
    before = around.positions(state, 10.6)[0].tolist()
    _, state = around.hear(state, heard_messages(news, [one.t_s for one in news]))
    assert state.renamed == len(ends)
    live = set(around.positions(state, news[-1].t_s)[0].tolist())
    assert live == set(before) - {old for old, _ in ends} | {one.vehicle for one in news}
    assert len(ends) > 0

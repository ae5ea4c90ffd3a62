"""Claims about remotes that change their temporary id: the old track ends, and nothing is mixed up."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.station.receiver.heard import Heard, HeardKind
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

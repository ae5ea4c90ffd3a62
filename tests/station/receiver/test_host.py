"""Claims about the host: what it holds follows from what arrived, and from nothing else."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip import replay_kernels
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import MessageKind
from modelcast.station.receiver.host import Host, HostState, Receipt
from modelcast.study.case import TripCase, make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import draw_losses
from modelcast.trips.trajectory import Trajectory

CV = ConstantVelocity()
GP = GaussianProcess(form="intercept")
BANK = Bank((CV, GP))
DAMPED = Bank((Trusted(GP, 0.7), CV))
HOST = Host(BANK, expiry_s=3.0)

POSITION_M = 1e-9
"""Two ways to add up positions of kilometres in double precision."""


def fitted() -> FloatArray:
    """Parameters of both sub-models on a bend at 10 m/s, the newest sample heading east."""
    t = np.arange(-9, 1) * 0.1
    position = [20 * np.sin(t / 2), 20 * np.cos(t / 2)]
    velocity = [10 * np.cos(t / 2), -10 * np.sin(t / 2)]
    bend = np.stack([*position, *velocity, np.zeros(10), np.full(10, 0.5), np.zeros(10)], axis=1)
    return BANK.fit(Windows(bend[None], dt_s=0.1))[0, 1:]


def update(**changes: Any) -> ModelUpdate:
    message = ModelUpdate(
        7, 3, 10.0, position_m=np.array([100.0, 50.0]), in_use=0, parameters=fitted(), dt_s=0.1
    )
    return replace(message, **changes)


def identification(**changes: Any) -> SubModelIdentification:
    return replace(SubModelIdentification(7, 3, 11.0, in_use=1), **changes)


def taken(*messages: ModelUpdate | SubModelIdentification, host: Host = HOST) -> tuple[Receipt, HostState]:
    """The last receipt and the state after messages that arrive at once."""
    state, receipt = HostState(), Receipt.MALFORMED
    for message in messages:
        receipt, state = host.receive(state, message, received_s=message.t_s)
    return receipt, state


def test_an_update_is_predicted_by_the_sub_model_it_names() -> None:
    for member, model in enumerate((CV, GP)):
        receipt, state = taken(update(in_use=member))
        tracks = HOST.predict(state, 11.3)
        own = fitted()[slice(0, 2) if member == 0 else slice(2, None)]
        moved = model.predict_at(own[None], np.array([1.3]), dt_s=0.1)[0]
        assert receipt is Receipt.ACCEPTED
        assert tracks.position_m[0] == pytest.approx(np.array([100.0, 50.0]) + moved, abs=POSITION_M)
        assert tracks.information_age_s[0] == pytest.approx(1.3)
        assert (tracks.vehicle.tolist(), tracks.in_use.tolist()) == ([7], [member])


def test_an_identification_changes_the_sub_model_and_nothing_else() -> None:
    receipt, state = taken(update(), identification())
    assert receipt is Receipt.ACCEPTED
    assert state.remotes[7].in_use == 1
    assert state.remotes[7].update.t_s == 10.0
    assert state.remotes[7].received_s == 11.0


def test_an_identification_of_an_update_never_received_changes_no_belief() -> None:
    receipt, state = taken(update(), identification(sequence=4))
    assert receipt is Receipt.UNKNOWN_UPDATE
    assert state.remotes[7].in_use == 0
    assert taken(identification()) == (Receipt.UNKNOWN_UPDATE, HostState())


def test_it_tells_all_the_same_that_the_remote_is_alive() -> None:
    _, state = taken(update(), identification(sequence=4, t_s=12.0))
    assert HOST.predict(state, 14.9).vehicle.tolist() == [7]


def test_a_silent_remote_expires_and_returns_with_its_next_update() -> None:
    _, state = taken(update())
    assert HOST.predict(state, 13.0).vehicle.size == 1
    assert HOST.predict(state, 13.1).vehicle.size == 0
    _, state = HOST.receive(state, update(t_s=20.0, sequence=4), received_s=20.0)
    assert HOST.predict(state, 20.0).vehicle.tolist() == [7]


def test_remotes_are_kept_apart_and_listed_by_id() -> None:
    _, state = taken(update(vehicle=9), update(vehicle=2, t_s=10.5), identification(vehicle=9))
    tracks = HOST.predict(state, 11.0)
    assert tracks.vehicle.tolist() == [2, 9]
    assert tracks.in_use.tolist() == [0, 1]
    assert tracks.information_age_s == pytest.approx([0.5, 1.0])


def test_no_remote_no_tracks() -> None:
    assert HOST.predict(HostState(), 1.0).position_m.shape == (0, 2)


def test_the_given_state_is_left_alone() -> None:
    _, state = taken(update())
    held = state.remotes[7]
    HOST.receive(state, identification(), received_s=11.0)
    assert state.remotes == {7: held}
    with pytest.raises(TypeError):
        state.remotes[8] = held  # type: ignore[index] - what is tested


def test_an_older_update_is_refused() -> None:
    for late in (update(t_s=9.9, sequence=2), update()):
        receipt, state = HOST.receive(taken(update())[1], late, received_s=12.0)
        assert receipt is Receipt.OLDER
        assert state.remotes[7].received_s == 10.0


def test_an_identification_overtaken_by_a_newer_one_is_refused() -> None:
    """Two identifications of one update may arrive in the wrong order: the newer one stays."""
    _, state = taken(update(), identification(t_s=11.0, in_use=1))
    _, state = HOST.receive(state, identification(t_s=12.0, in_use=0), received_s=12.0)
    receipt, state = HOST.receive(state, identification(t_s=11.0, in_use=1), received_s=12.1)
    assert receipt is Receipt.OLDER
    assert state.remotes[7].in_use == 0


NAN, HUGE = math.nan, 1e308

HOSTILE = {
    "NaN time": update(t_s=NAN, sequence=4),
    "infinite time": update(t_s=math.inf, sequence=4),
    "time far ahead": update(t_s=1e12, sequence=4),
    "NaN position": update(t_s=11.0, position_m=np.array([NAN, 0.0])),
    "infinite position": update(t_s=11.0, position_m=np.array([0.0, math.inf])),
    "position off the Earth": update(t_s=11.0, position_m=np.array([HUGE, 0.0])),
    "position of three": update(t_s=11.0, position_m=np.zeros(3)),
    "NaN parameter": update(t_s=11.0, parameters=np.full(fitted().size, NAN)),
    "infinite parameter": update(t_s=11.0, parameters=np.full(fitted().size, math.inf)),
    "huge parameters": update(t_s=11.0, parameters=np.full(fitted().size, HUGE), in_use=0),
    "huge parameters of another sub-model": update(
        t_s=11.0, parameters=np.full(fitted().size, HUGE), in_use=1
    ),
    "parameters too few": update(t_s=11.0, parameters=fitted()[:-1]),
    "parameters too many": update(t_s=11.0, parameters=np.append(fitted(), 0.0)),
    "no parameters": update(t_s=11.0, parameters=np.empty(0)),
    "parameters in rows": update(t_s=11.0, parameters=fitted()[None]),
    "negative sub-model": update(t_s=11.0, in_use=-1),
    "unknown sub-model": update(t_s=11.0, in_use=2),
    "huge sub-model": update(t_s=11.0, in_use=2**70),
    "interval of zero": update(t_s=11.0, dt_s=0.0),
    "negative interval": update(t_s=11.0, dt_s=-0.1),
    "NaN interval": update(t_s=11.0, dt_s=NAN),
    "infinite interval": update(t_s=11.0, dt_s=math.inf),
    "interval below the clock": update(t_s=11.0, dt_s=1e-9),
    "interval of hours": update(t_s=11.0, dt_s=1e5),
    "id beyond four bytes": update(t_s=11.0, vehicle=2**70),
    "negative id": update(t_s=11.0, vehicle=-1),
    "identification of no sub-model": identification(in_use=-1),
    "identification of an unknown sub-model": identification(in_use=2),
    "identification at NaN": identification(t_s=NAN),
    "identification far ahead": identification(t_s=1e12),
}


@pytest.mark.parametrize("message", HOSTILE.values(), ids=HOSTILE.keys())
def test_an_impossible_message_is_refused_and_changes_nothing(
    message: ModelUpdate | SubModelIdentification,
) -> None:
    _, state = taken(update())
    receipt, after = HOST.receive(state, message, received_s=11.0)
    assert receipt is Receipt.MALFORMED
    assert after is state
    assert np.isfinite(HOST.predict(after, 12.0).position_m).all()


def test_naming_a_sub_model_whose_parameters_give_no_place_changes_nothing() -> None:
    """The update itself is sound: what it has in use is."""
    forged = fitted()
    forged[2:] = HUGE
    receipt, state = taken(update(parameters=forged))
    assert receipt is Receipt.ACCEPTED
    receipt, after = HOST.receive(state, identification(), received_s=11.0)
    assert receipt is Receipt.MALFORMED
    assert after is state


@pytest.mark.parametrize("expiry_s", [0.0, -1.0, math.nan])
def test_an_expiry_must_be_positive(expiry_s: float) -> None:
    with pytest.raises(ValueError, match="expiry_s"):
        Host(BANK, expiry_s=expiry_s)


@pytest.mark.real
@pytest.mark.parametrize("bank", [BANK, DAMPED], ids=["whole", "damped"])
@pytest.mark.parametrize("name", ["TESLA_MODELX", "MERCEDES_GLE450"])
def test_fed_message_by_message_it_believes_what_the_replay_says(
    name: str, bank: Bank, dynamic_trips: dict[str, Trajectory]
) -> None:
    """Over a real trip at 40 % losses, with expiry; the replay gives the error in its two parts."""
    trip = dynamic_trips[name]
    settings = EvaluationSettings((0.2,), (0.4,), bank=bank, identify="best", protocol="recorded")
    case = make_case(trip, settings)
    sender = TripRuntime(case.seen, bank, case.estimator)
    walk = sender.run(settings.policy(0.2, keep_alive=True))
    lost = draw_losses(case, settings)[0, :1]
    errors = replayed(case, sender, walk, lost, expiry_s=1.5)
    number = np.cumsum(np.isin(walk.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE)))
    state, host = HostState(), Host(bank, expiry_s=1.5)
    for now, t_s in enumerate(trip.t_s):
        if walk.transmits[now] and not lost[0, now]:
            state = host.receive(state, sent(sender, walk, now, int(number[now])), received_s=t_s)[1]
        tracks = host.predict(state, t_s)
        assert (tracks.vehicle.size == 0) == np.isnan(errors[0, now])
        if tracks.vehicle.size:
            ahead = case.direction[now]
            off = errors[2, now] * ahead + errors[3, now] * np.array([-ahead[1], ahead[0]])
            assert np.abs(tracks.position_m[0] - trip.position_m[now] - off).max() < POSITION_M
            assert tracks.information_age_s[0] == pytest.approx(errors[4, now])
    assert 0 < np.isnan(errors[0]).sum() < len(trip)


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
    count = len(case.truth)
    errors = np.empty((5, 1, count))
    replay_kernels.replay(
        sender.own.ready.members,
        case.truth.t_s,
        sender.stated_m,
        sender.parameters,
        case.truth.position_m,
        case.direction,
        walk.kind[None],
        walk.in_use[None],
        walk.update_index[None],
        lost,
        0.0,
        expiry_s,
        errors,
        np.empty((1, count)),
        np.empty(1, dtype=np.int64),
    )
    return errors[:, 0]

"""Claims about the closed loop of a fleet on the air."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.radio import Receptions
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.messages.airtime import Stack
from modelcast.messages.mbc import ModelUpdate
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.profile import default_profile
from modelcast.runtime.fleet import arrays as tracks
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import PAPER_BANK, bank_from_text, named_bank
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.receiver.heard import heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.names import SENDERS
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import REPORTED
from modelcast.study.network.measure import binned_quantiles
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

SETTINGS = NetworkSettings(warm_up_s=0.0, start_spread_s=0.0)
IDEAL_RADIO = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.ones((2, 20)), bin_m=500.0))
"""Everything arrives, within 10 km."""

HALF_RADIO = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.full((2, 20), 0.5), bin_m=500.0))
"""Half of it."""

MASK = (1 << at.SENDER_BITS) - 1
ROUNDING = 1e-9
"""Sums of displacements in another order, at places of a kilometre."""


def traffic(duration_s: float, *, density_per_km: float = 20.0, seed: int = 1) -> list[FleetFrame]:
    road = Highway(500.0, density_per_km, warm_up_s=20.0)
    return list(run_scenario(road, np.random.default_rng(seed), duration_s=duration_s))


@pytest.fixture(scope="module")
def frames() -> list[FleetFrame]:
    return traffic(8.0)


@pytest.fixture(scope="module")
def ring() -> list[FleetFrame]:
    """Traffic that nobody joins or leaves, all of it in reach."""
    road = Highway(500.0, 20.0, form="ring", warm_up_s=20.0)
    return list(run_scenario(road, np.random.default_rng(1), duration_s=4.0))


@pytest.fixture(scope="module")
def seen(frames: list[FleetFrame]) -> list[FleetFrame]:
    """What vehicles see, as the truth of another run: so that a loop and a trip share their samples."""
    sensor = FleetSensor(SensorModel())
    state = sensor.init(len(frames[0]), np.random.default_rng(3))
    shown: list[FleetFrame] = []
    for frame in frames:
        one, state = sensor.sense(state, frame)
        shown.append(one)
    return shown


def steps(
    loop: FleetLoop, frames: list[FleetFrame]
) -> Iterator[tuple[FleetFrame, IntArray, FloatArray, IntArray, Receptions]]:
    """Every frame with senders, times and sizes of the messages sent in it, and what was received."""
    for frame in frames:
        received, _ = loop.step(frame)
        out = loop.handed_over()
        yield frame, out.message_id, out.ready_s, out.size_bytes, received


def stayed(frames: list[FleetFrame]) -> IntArray:
    """Slots that held one vehicle all the time."""
    who = np.array([frame.vehicle_id for frame in frames])
    return np.flatnonzero((who == who[0]).all(axis=0))


def trip_of(frames: list[FleetFrame], slot: int) -> Trajectory:
    def column(name: str) -> FloatArray:
        return np.array([getattr(frame, name)[slot] for frame in frames])

    return build_trajectory(
        f"made/{slot}",
        np.array([round(0.1 * k, 6) for k in range(len(frames))]),
        column("position_m"),
        speed_mps=column("speed_mps"),
        heading_rad=column("heading_rad"),
        acceleration_mps2=column("acceleration_mps2"),
        yaw_rate_radps=column("yaw_rate_radps"),
    )


CV = Bank((ConstantVelocity(),))


@pytest.mark.parametrize(
    ("bank", "policy"),
    [
        (CV, ErrorDriven(0.2, identify="never", max_inter_transmit_time_s=2.0)),
        (default_profile().bank, ErrorDriven(0.2, "guarded", "never", 2.0)),
        (bank_from_text("learned+ctra+gp-vehicle+cv"), ErrorDriven(0.2, "hindsight", "best", 2.0)),
        (PAPER_BANK, ErrorDriven(0.1, max_inter_transmit_time_s=2.0)),
        (PAPER_BANK, ErrorDriven(0.1, "survivor", "final")),
    ],
    ids=lambda one: one.name if isinstance(one, Bank) else f"{one.start}/{one.identify}",
)
def test_error_driven_senders_send_what_the_same_policy_sends_over_their_trip(
    seen: list[FleetFrame], bank: Bank, policy: ErrorDriven
) -> None:
    sender = Sender("tested", policy, bank)
    loop = FleetLoop(seen[0], sender, IDEAL_RADIO, SETTINGS, seed=1)
    sent = np.zeros((len(seen), len(seen[0])), dtype=np.int64)
    for k, (_, ids, *_) in enumerate(steps(loop, seen)):
        for number in ids.tolist():
            content = loop.contents.rows[number & MASK, (number >> at.SENDER_BITS) % at.MESSAGES_KEPT]
            sent[k, number & MASK] = int(content[at.CONTENT_KIND])
    slots = stayed(seen)
    assert slots.size >= 3
    for slot in slots:
        walk = TripRuntime(trip_of(seen, slot), bank, REPORTED, quantised=True).run(policy)
        assert np.array_equal(sent[:, slot], walk.kind)
    named = policy.identify != "never"
    assert (sent == MessageKind.IDENTIFICATION).any() == named
    assert (loop.sent.total[at.IDENTIFICATIONS] > 0) == named


def test_identifications_reach_the_hosts(ring: list[FleetFrame]) -> None:
    """Those of an update that was lost are counted, and change nothing."""
    sender = named_sender("mbc", bank=PAPER_BANK, threshold_m=0.05)
    run = run_network(ring, sender, IDEAL_RADIO, replace(SETTINGS, warm_up_s=0.5), seed=3)
    assert run.sent.total[at.IDENTIFICATIONS] > 0
    assert run.tally.heard[tracks.UNKNOWN] == 0
    lossy = run_network(ring, sender, HALF_RADIO, replace(SETTINGS, warm_up_s=0.5), seed=3)
    assert lossy.tally.heard[tracks.UNKNOWN] > 0


@pytest.mark.parametrize("name", ["mbc", "j2945-mbc", "cam", "cam-road"])
def test_the_number_of_threads_changes_nothing(frames: list[FleetFrame], name: str) -> None:
    counted: list[FloatArray] = []
    for threads in (1, 2, 3):
        run = run_network(
            frames[:30],
            named_sender(name),
            Dsrc(),
            SETTINGS,
            seed=4,
            sensor=FleetSensor(SensorModel()),
            threads=threads,
        )
        counted.append(np.concatenate([part.ravel() for part in (*run.tally, *run.sent, run.series)]))
    assert np.array_equal(counted[0], counted[1], equal_nan=True)
    assert np.array_equal(counted[0], counted[2], equal_nan=True)


def test_windows_are_those_of_a_recorded_trip(seen: list[FleetFrame]) -> None:
    loop = FleetLoop(seen[0], named_sender("mbc"), IDEAL_RADIO, SETTINGS, seed=1)
    for _ in steps(loop, seen):
        pass
    sensed = loop.stations.sensed
    length = sensed.stated_m.shape[1]
    newest = (len(seen) - 1) % length
    slot = int(stayed(seen)[0])
    window = sensed.samples[slot, newest + 1 : newest + 1 + length]
    expected = sample_matrix(trip_of(seen, slot), REPORTED)[-length:]
    np.testing.assert_allclose(window, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", SENDERS)
def test_one_seed_gives_one_result_and_nothing_is_heard_that_was_not_sent(
    frames: list[FleetFrame], name: str
) -> None:
    few = frames[:25]
    counted: list[FloatArray] = []
    for _ in range(2):
        loop = FleetLoop(few[0], named_sender(name), Dsrc(), SETTINGS, seed=4)
        sent: set[int] = set()
        heard = 0
        for _, ids, _, _, received in steps(loop, few):
            sent |= set(ids.tolist())
            assert set(received.message_id.tolist()) <= sent
            assert not (received.receiver == received.message_id & MASK).any()
            heard += received.size
        assert loop.tally.heard.sum() == heard > 0
        assert loop.sent.total[at.MESSAGES] == len(sent)
        counted.append(np.concatenate([part.ravel() for part in (*loop.tally, *loop.sent)]))
    assert np.array_equal(*counted)


def test_hosts_hold_what_a_local_dynamic_map_holds(frames: list[FleetFrame]) -> None:
    """Fed with the same messages, it puts every remote where the loop's tracks put it."""
    sender = named_sender("j2945-mbc")
    loop = FleetLoop(frames[0], sender, Dsrc(), replace(SETTINGS, reach_m=1e4), seed=2)
    around = LocalDynamicMap((sender.bank,), expiry_s=loop.expiry_s)
    slots = stayed(frames)
    states = {slot: around.init() for slot in slots.tolist()}
    offsets = sender.bank.offsets
    for _, _, _, _, received in steps(loop, frames):
        for message, receiver, t_s in zip(received.message_id, received.receiver, received.t_s, strict=True):
            content = loop.contents.rows[message & MASK, (message >> at.SENDER_BITS) % at.MESSAGES_KEPT]
            member = int(content[at.CONTENT_MEMBER])
            parameters = np.full(int(offsets[-1]), np.nan)
            count = offsets[member + 1] - offsets[member]
            parameters[offsets[member] : offsets[member + 1]] = content[at.CONTENT_HEAD :][:count]
            update = ModelUpdate(
                int(content[at.CONTENT_VEHICLE]),
                int(message >> at.SENDER_BITS) % at.MESSAGES_KEPT,
                float(content[at.CONTENT_FIT_S]),
                position_m=content[[at.CONTENT_EAST_M, at.CONTENT_NORTH_M]].copy(),
                in_use=member,
                parameters=parameters,
                dt_s=0.1,
            )
            if int(receiver) in states:
                own = int(receiver)
                _, states[own] = around.hear(states[own], heard_messages([update], [float(t_s)]))
    now_s = round(0.1 * len(frames), 6)
    compared = 0
    for slot, state in states.items():
        vehicles, places = around.positions(state, now_s)
        own, whose = loop.tracks.held[slot], loop.tracks.vehicle[slot]
        for vehicle, place in zip(vehicles, places, strict=True):
            row = own[(whose == vehicle) & (own[:, tracks.TRACK_MESSAGE] >= 0)]
            message = int(row[0, tracks.TRACK_MESSAGE])
            content = loop.contents.rows[message & MASK, (message >> at.SENDER_BITS) % at.MESSAGES_KEPT]
            member = int(content[at.CONTENT_MEMBER])
            count = offsets[member + 1] - offsets[member]
            moved = sender.bank.members[member].predict_at(
                content[at.CONTENT_HEAD :][None, :count].copy(),
                np.array([now_s - content[at.CONTENT_FIT_S]]),
                dt_s=0.1,
            )[0]
            np.testing.assert_allclose(
                content[[at.CONTENT_EAST_M, at.CONTENT_NORTH_M]] + moved, place, atol=ROUNDING
            )
            compared += 1
    assert compared > slots.size


def test_frames_have_the_bytes_of_the_stack(frames: list[FleetFrame]) -> None:
    sender = named_sender("mbc")
    loop = FleetLoop(frames[0], sender, IDEAL_RADIO, SETTINGS, seed=5)
    slot = int(stayed(frames)[0])
    times: list[float] = []
    sizes: list[int] = []
    payload: list[int] = []
    for _, ids, ready_s, size_bytes, _ in steps(loop, frames):
        for message, sent_s, size in zip(ids, ready_s, size_bytes, strict=True):
            if message & MASK == slot:
                times.append(float(sent_s))
                sizes.append(int(size))
                ring = int(message >> at.SENDER_BITS) % at.MESSAGES_KEPT
                payload.append(int(loop.contents.rows[slot, ring, at.CONTENT_BYTES]))
    stack = Stack()
    certificate = stack.carries_certificate(np.array(times))
    assert sizes == stack.frame_bytes(np.array(payload), certificate).tolist()
    assert set(payload) <= set(sender.update_bytes.tolist())


def test_a_vehicle_that_takes_a_slot_over_holds_nothing_and_is_held_by_nobody(
    ring: list[FleetFrame],
) -> None:
    loop = FleetLoop(ring[0], named_sender("bsm-10hz"), IDEAL_RADIO, SETTINGS, seed=6)
    for frame in ring[:10]:
        loop.step(frame)
    others = len(ring[0]) - 1
    assert (loop.tracks.held[0, :, tracks.TRACK_MESSAGE] >= 0).sum() == others
    changed = ring[10].vehicle_id.copy()
    changed[0] = changed.max() + 1000
    held = int(loop.tally.held.sum())
    loop.step(replace(ring[10], vehicle_id=changed))
    # At the start of this step the newcomer holds nothing, and nobody holds it: all other pairs are held.
    assert loop.tally.held.sum() - held == others * (others - 1)


def test_without_loss_every_pair_is_held(ring: list[FleetFrame]) -> None:
    settings = NetworkSettings(warm_up_s=1.0)
    run = run_network(ring, named_sender("bsm-10hz"), IDEAL_RADIO, settings, seed=1)
    assert np.array_equal(run.tally.held, run.tally.pairs)
    assert run.tally.error.sum() == run.tally.held.sum() == run.tally.age.sum() > 0


def test_frames_that_are_not_a_step_apart_are_refused(frames: list[FleetFrame]) -> None:
    with pytest.raises(ValueError, match=r"frames must be 0\.1 s apart"):
        run_network(frames[::2], named_sender("bsm-10hz"), IDEAL_RADIO, SETTINGS, seed=1)


def test_the_run_must_outlast_the_warm_up(frames: list[FleetFrame]) -> None:
    with pytest.raises(ValueError, match="outlast the warm-up"):
        run_network(frames[:5], named_sender("bsm-10hz"), IDEAL_RADIO, NetworkSettings(warm_up_s=9.0), seed=1)


def test_timers_know_no_guard_and_no_survivor() -> None:
    with pytest.raises(ValueError, match="under timers"):
        named_sender("j2945-mbc", start="survivor")
    with pytest.raises(ValueError, match="identify must be never"):
        named_sender("j2945-mbc", identify="best")
    assert named_sender("j2945-mbc", start="guarded").start == "hindsight"


def test_rules_without_what_they_need_are_refused_before_a_run() -> None:
    without_cv = Bank(named_sender("mbc").bank.members[:2])
    costs, selector = named_bank("default").costs("bytes"), default_profile().selector
    with pytest.raises(
        ValueError, match="start 'guarded' needs cv in the bank, got free-predictive, free: add it"
    ):
        named_sender("mbc", bank=without_cv, start="guarded")
    with pytest.raises(ValueError, match="start 'predicted' needs a selector"):
        named_sender("j2945-mbc", start="predicted")
    with pytest.raises(ValueError, match="trained for"):
        named_sender("mbc", bank=PAPER_BANK, start="predicted", selector=selector)
    with pytest.raises(ValueError, match="costs were counted for 4 sub-models, the bank has 2"):
        named_sender("mbc", bank=PAPER_BANK, identify="cheapest", costs=costs)


def test_what_erred_least_of_late_is_sent(seen: list[FleetFrame]) -> None:
    """`recent`, told anew: of members fitted at the last message, the smallest that is as good.

    The free one stays unless another erred less than half as far.
    """
    sender = replace(named_sender("j2945-mbc"), motion=None)
    sender = replace(sender, policy=ErrorDriven(0.05, "recent", "never", 2.0))
    bank = sender.bank
    free = bank.place_of("free")
    loop = FleetLoop(seen[0], sender, IDEAL_RADIO, SETTINGS, seed=1)
    slot = int(stayed(seen)[0])
    runtime = TripRuntime(trip_of(seen, slot), bank, REPORTED, quantised=True)
    scores: dict[int, float] = {}
    last = -1
    chosen: list[tuple[int, int]] = []
    for k, (_, ids, *_) in enumerate(steps(loop, seen)):
        for number in ids[(ids & MASK) == slot].tolist():
            content = loop.contents.rows[slot, (number >> at.SENDER_BITS) % at.MESSAGES_KEPT]
            usable = [m for m, one in enumerate(bank.members) if one.window <= k + 1]
            if last >= 0:
                for m in [m for m, one in enumerate(bank.members) if one.window <= last + 1]:
                    own = runtime.parameters[last : last + 1, bank.offsets[m] : bank.offsets[m + 1]].copy()
                    age_s = np.array([runtime.trip.t_s[k] - runtime.stated_s[last]])
                    off = runtime.stated_m[last] + bank.members[m].predict_at(own, age_s, dt_s=0.1)[0]
                    square = float(((off - runtime.samples[k, :2]) ** 2).sum())
                    scores[m] = square if m not in scores else scores[m] + 0.2 * (square - scores[m])
            known = [m for m in usable if m in scores]
            wanted = usable[0]
            if known:
                bound = 0.25 * scores[free] if free in known else np.inf
                fit = [m for m in known if m == free or scores[m] <= bound]
                best = min(scores[m] for m in fit)
                good = [m for m in fit if scores[m] <= best + sender.within_m**2]
                wanted = min(good, key=lambda m: (sender.update_bytes[m], scores[m], m))
            chosen.append((int(content[at.CONTENT_MEMBER]), wanted))
            runtime.fit_at([k])
            last = k
    assert len(chosen) > 5
    assert all(sent == wanted for sent, wanted in chosen)
    assert len({wanted for _, wanted in chosen}) > 1


def test_an_unknown_sender_is_refused() -> None:
    with pytest.raises(ConfigError, match="Unknown policy 'cow'"):
        named_sender("cow")


def test_small_errors_at_relaxed_timers_take_fewer_messages_and_track_no_worse() -> None:
    """In thin traffic, at most 0.6 of J2945/1's messages at no higher 90th percentile of the error."""
    thin = traffic(12.0, density_per_km=40.0)
    settings = NetworkSettings(warm_up_s=4.0)
    p90_m: dict[str, float] = {}
    sent: dict[str, int] = {}
    for name in ("j2945", "j2945-mbc-relaxed"):
        run = run_network(
            thin, named_sender(name), Dsrc(), settings, seed=5, sensor=FleetSensor(SensorModel())
        )
        p90_m[name] = binned_quantiles(run.tally.error[2:6].sum(axis=0), (0.9,))[0]
        sent[name] = int(run.sent.causes.sum())
    assert sent["j2945-mbc-relaxed"] <= 0.6 * sent["j2945"]
    assert p90_m["j2945-mbc-relaxed"] <= p90_m["j2945"]


def test_the_error_of_relaxed_senders_is_a_choice() -> None:
    coarse = named_sender("j2945-mbc-relaxed", relaxed_error_m=0.05).policy
    assert isinstance(coarse, J2945)
    assert coarse.parameters.min_tracking_error_m == coarse.parameters.max_tracking_error_m == 0.05
    noisy = named_sender("j2945-mbc-relaxed", motion=MotionFilter(0.04)).policy
    assert isinstance(noisy, J2945)
    assert noisy.parameters.min_tracking_error_m == 0.04


def test_hosts_of_a_fleet_refuse_what_they_would_have_to_keep() -> None:
    """They share what each message says, and what an interacting multiple model holds is each host's own."""
    own = named_sender("free", bank=named_bank("imm").bank)
    with pytest.raises(ValueError, match="hosts of a fleet cannot keep what imm needs"):
        run_network(iter(traffic(1.0)), own, IDEAL_RADIO, SETTINGS, seed=1)

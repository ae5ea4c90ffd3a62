"""Claims about what stations on the air send in each step, against their policies in plain words."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.kinds import Kind
from modelcast.core.markov import MarkovChain
from modelcast.messages.airtime import Stack
from modelcast.messages.cam_sizes import FrameSizes, measured_cam_sizes
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.station.policy import neighbours_kernels
from modelcast.station.policy.base import Air, Motion, TransmitInputs
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_kernels import NEXT_S
from modelcast.station.policy.j2945_kernels import step as j2945_step
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.posting_kernels import StepInputs
from modelcast.station.sender.sender import Sender, engine_parameters
from modelcast.station.sender.sending_kernels import send_each
from modelcast.station.sender.stations import sender_bank, sending_stations, widest
from modelcast.station.sensing.sensing import Sensing
from modelcast.station.sensing.sensing_kernels import sense

DT_S = 0.1
PHASE = np.array([0.0, 0.37, 0.81])
CV = ConstantVelocity()
PLAIN = Bank((CV,))
UPDATE, IDENTIFICATION = 1, 2


def turns(count: int = 40, seed: int = 5) -> FloatArray:
    """What three cars measure that accelerate and turn, (T, 3, 6)."""
    rng = np.random.default_rng(seed)
    acceleration = np.repeat(rng.uniform(-4.0, 4.0, (count // 8 + 1, 3)), 8, axis=0)[:count]
    yaw_rate = np.repeat(rng.uniform(-0.4, 0.4, (count // 8 + 1, 3)), 8, axis=0)[:count]
    speed = 18.0 + np.cumsum(acceleration, axis=0) * DT_S
    heading = np.cumsum(yaw_rate, axis=0) * DT_S + np.array([0.0, 2.0, 4.0])
    moves = DT_S * speed[..., None] * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    place = np.cumsum(moves, axis=0) + np.array([[0.0, 0.0], [30.0, 20.0], [-40.0, 10.0]])
    columns = [place, speed[..., None], np.mod(heading, 2.0 * np.pi)[..., None], acceleration[..., None]]
    return np.concatenate([*columns, yaw_rate[..., None]], axis=-1)


@dataclass(frozen=True)
class Posted:
    """One message as the radio gets it, and its content."""

    slot: int
    ready_s: float
    size_bytes: int
    power_dbm: float
    number: int
    next_s: float
    row: FloatArray


@dataclass
class Road:
    """Three stations that share steps."""

    sender: Sender
    phase: FloatArray = field(default_factory=PHASE.copy)

    def __post_init__(self) -> None:
        self.bank = sender_bank(self.sender, DT_S)
        self.sensing = Sensing()
        self.stations = sending_stations(self.sender, self.bank, self.phase, sensing=self.sensing)
        self.tables = neighbour_tables(3, 8, phase_s=self.phase)
        self.contents = at.contents(3, widest(self.sender, self.bank))
        self.outbox, self.tally = at.outbox(3), at.sent_tally()
        self.stations.senders.vehicle[:] = [11, 12, 13]

    def measure(self, t_s: float, measured: FloatArray) -> None:
        """Let all measure."""
        sense(
            self.stations.sensed,
            np.arange(3),
            np.full(3, t_s),
            np.ascontiguousarray(measured),
            np.zeros(3, dtype=np.bool_),
            self.sensing.numbers(DT_S),
        )

    def step(
        self,
        t_s: float,
        uniforms: FloatArray,
        *,
        started: BoolArray | None = None,
        critical: BoolArray | None = None,
        busy: FloatArray | None = None,
        spread_s: float = 0.0,
        slots: tuple[int, int] = (0, 3),
    ) -> list[Posted]:
        """Return what is posted in a step."""
        nobody = np.zeros(3, dtype=np.bool_)
        inputs = StepInputs(
            t_s=t_s,
            dt_s=DT_S,
            spread_s=spread_s,
            started=nobody if started is None else started,
            critical=nobody if critical is None else critical,
            busy_ratio=np.zeros(3) if busy is None else busy,
            uniforms=uniforms,
        )
        send_each(self.stations, inputs, self.tables, self.contents, self.outbox, self.tally, *slots)
        out, found = self.outbox, list[Posted]()
        for k in range(int(out.filled[0])):
            number, slot = divmod(int(out.message_id[k]), 1 << at.SENDER_BITS)
            assert slot == out.sender[k]
            found.append(
                Posted(
                    slot,
                    float(out.ready_s[k]),
                    int(out.size_bytes[k]),
                    float(out.power_dbm[k]),
                    number,
                    float(out.next_s[k]),
                    self.contents.rows[slot, number % at.MESSAGES_KEPT].copy(),
                )
            )
        return found


def driven(road: Road, seen: FloatArray, uniforms: FloatArray, **every: FloatArray) -> list[list[Posted]]:
    """All steps of a drive from 0 s on; further inputs have a row a step."""
    steps = list[list[Posted]]()
    for k, measured in enumerate(seen):
        road.measure(round(DT_S * k, 6), measured)
        started = np.full(3, k == 0)
        more = {name: np.ascontiguousarray(column[k]) for name, column in every.items()}
        steps.append(road.step(round(DT_S * k, 6), uniforms[k], started=started, **more))
    return steps


def drawn(count: int, seed: int = 2) -> FloatArray:
    return np.random.default_rng(seed).random((count, 3, 4))


def velocity(measured: FloatArray) -> FloatArray:
    """Of each row of six numbers."""
    speed, heading = measured[..., 2], measured[..., 3]
    return np.stack([speed * np.sin(heading), speed * np.cos(heading)], axis=-1)


def test_a_periodic_sender_posts_what_its_policy_calls_for_with_its_own_phase_and_jitter() -> None:
    sender = Sender("tested", Periodic(4.0), PLAIN, jitter_s=0.005, power_dbm=17.0)
    road, seen, uniforms = Road(sender), turns(), drawn(40)
    due = np.full(3, -np.inf)
    numbers = np.zeros(3, dtype=int)
    times: list[list[float]] = [[], [], []]
    for k, posted in enumerate(driven(road, seen, uniforms)):
        t_s = round(DT_S * k, 6)
        expected = list[int]()
        for slot in range(3):
            ask_s = t_s + PHASE[slot] * (DT_S - 0.005)
            if ask_s < due[slot] - 1e-9:
                continue
            if due[slot] == -np.inf:
                due[slot] = ask_s + 0.25 * (1.0 - uniforms[k, slot, 0])
            while due[slot] <= ask_s + 1e-9:
                due[slot] += 0.25
            expected.append(slot)
        assert [one.slot for one in posted] == expected
        for one in posted:
            ask_s = t_s + PHASE[one.slot] * (DT_S - 0.005)
            assert one.ready_s == pytest.approx(ask_s + 0.005 * uniforms[k, one.slot, 1])
            ask_next_s = ask_s + DT_S * np.ceil((due[one.slot] - ask_s) / DT_S - 1e-6)
            assert one.next_s == pytest.approx(ask_next_s + 0.005)
            assert (one.power_dbm, one.number) == (17.0, numbers[one.slot])
            numbers[one.slot] += 1
            times[one.slot].append(one.ready_s)
            wanted = np.empty(at.CONTENT_HEAD + 2)
            wanted[at.CONTENT_VEHICLE], wanted[at.CONTENT_NUMBER] = 11 + one.slot, one.number
            wanted[at.CONTENT_KIND], wanted[at.CONTENT_UPDATE] = UPDATE, one.number
            wanted[at.CONTENT_FIT_S] = wanted[at.CONTENT_NAMED_S] = t_s
            wanted[at.CONTENT_SENT_S], wanted[at.CONTENT_MEMBER] = one.ready_s, 0
            wanted[at.CONTENT_EAST_M], wanted[at.CONTENT_NORTH_M] = seen[k, one.slot, :2]
            wanted[at.CONTENT_BYTES] = sender.update_bytes[0]
            wanted[at.CONTENT_SPEED_MPS : at.CONTENT_YAW_RATE_RADPS + 1] = seen[k, one.slot, 2:]
            wanted[at.CONTENT_FIRST] = at.CONTENT_HEAD
            wanted[at.CONTENT_HEAD :] = velocity(seen[k, one.slot])
            np.testing.assert_allclose(one.row, wanted, atol=0.011)  # velocity goes through its codes
            np.testing.assert_array_equal(one.row[: at.CONTENT_FIT_S], wanted[: at.CONTENT_FIT_S])
    accounted(road, times, [sender.update_bytes[0]] * 3, causes=[0, int(numbers.sum()), 0, 0], power_dbm=17.0)
    assert road.tally.total[at.MODELS] == road.tally.total[at.IDENTIFICATIONS] == 0


def accounted(
    road: Road, times: Sequence[Sequence[float]], sizes: Sequence[int], *, causes: list[int], power_dbm: float
) -> None:
    """Compare the tally with the messages of each slot, all of one size a slot."""
    stack = Stack()
    frames = airtime_s = certificates = payload = 0.0
    for own, size in zip(times, sizes, strict=True):
        carried = stack.carries_certificate(np.array(own))
        payloads = np.full(len(own), size)
        frames += stack.frame_bytes(payloads, carried).sum()
        airtime_s += stack.airtime_s(payloads, carried).sum()
        certificates += carried.sum()
        payload += payloads.sum()
    count = sum(len(own) for own in times)
    sums = road.tally.total
    assert sums[at.MESSAGES] == count
    assert sums[at.CERTIFICATES] == certificates
    assert sums[at.PAYLOAD_BYTES] == payload
    assert sums[at.FRAME_BYTES] == frames
    assert sums[at.AIRTIME_S] == pytest.approx(airtime_s)
    assert sums[at.POWER_DBM] == pytest.approx(count * power_dbm)
    assert road.tally.causes.tolist() == causes
    for slot, own in enumerate(times):
        carried = stack.carries_certificate(np.array(own))
        senders = road.stations.senders
        assert senders.sent_s[slot] == own[-1]
        assert senders.certified_s[slot] == np.array(own)[carried][-1]
        assert senders.number[slot] == len(own) == senders.update[slot] + 1


@pytest.mark.parametrize(
    "control", [None, AdaptiveDcc(), ReactiveDcc()], ids=["none", "adaptive", "reactive"]
)
def test_an_awareness_sender_posts_what_its_policy_calls_for(
    control: AdaptiveDcc | ReactiveDcc | None,
) -> None:
    """Asked by the policy's public form, with the busy ratio and the airtime of its largest message."""
    policy = CooperativeAwareness(control=control)
    bank = Bank((ConstantTurnRateAcceleration(), CV), plain="cv")
    sender = Sender("tested", policy, bank, jitter_s=0.0)
    road, seen, uniforms = Road(sender), turns(60), drawn(60)
    busy = np.random.default_rng(4).uniform(0.3, 0.95, (60, 3))
    state = policy.init(3, 2)
    rng = np.random.default_rng(0)
    largest = np.full(3, sender.update_bytes[-1])
    sent = 0
    for k, posted in enumerate(driven(road, seen, uniforms, busy=busy)):
        moves = velocity(seen[k])
        inputs = TransmitInputs(
            round(DT_S * k, 6) + PHASE * DT_S,
            np.zeros(3),
            silence_s=np.zeros(3),
            tracking_error_m=np.zeros((3, 2)),
            available=np.ones((3, 2), dtype=np.bool_),
            motion=Motion(
                position_m=seen[k, :, :2],
                speed_mps=np.hypot(*moves.T),
                heading_rad=np.arctan2(*moves.T),
                critical=np.zeros(3, dtype=np.bool_),
            ),
            air=Air(
                busy[k],
                np.zeros(3),
                packet_error_ratio=np.zeros(3),
                airtime_s=Stack().airtime_s(largest, np.ones(3, dtype=np.bool_)),
            ),
        )
        decisions, state = policy.decide(state, inputs, rng)
        assert [one.slot for one in posted] == np.flatnonzero(decisions.kind).tolist()
        sent += len(posted)
        for one in posted:
            assert one.row[at.CONTENT_MEMBER] == 0
            assert one.size_bytes in Stack().frame_bytes(
                sender.update_bytes[:1].repeat(2), np.array([True, False])
            )
    assert 6 < sent < 150
    assert road.tally.total[at.MODELS] == sent


PARAMETERS = replace(engine_parameters(), min_tracking_error_m=0.05, max_tracking_error_m=0.2)


@dataclass
class ByHand:
    """Three stations under J2945/1 that ask at their own phase; what falls due after a step waits."""

    parameters: J2945Parameters
    tables: NeighbourTables

    def __post_init__(self) -> None:
        self.constants = self.parameters.constants()
        self.rows = J2945(self.parameters, phase_ratio=PHASE).init(3, 1).rows
        self.believed: dict[int, tuple[float, FloatArray, FloatArray]] = {}
        self.waits: dict[int, tuple[float, float, bool, int]] = {}
        self.causes = [0, 0, 0, 0]
        self.waited = self.lost = 0

    def error_m(self, slot: int, t_s: float, seen: FloatArray) -> float:
        """Of the message believed received, coasting as the station itself does."""
        if slot not in self.believed:
            return np.inf
        fit_s, place, moves = self.believed[slot]
        ask_s = t_s + PHASE[slot] * DT_S
        off = seen[slot, :2] + (ask_s - t_s) * velocity(seen[slot]) - place - (ask_s - fit_s) * moves
        return float(np.hypot(*off))

    def step(
        self, t_s: float, seen: FloatArray, uniforms: FloatArray, *, busy: FloatArray, event: BoolArray
    ) -> list[tuple[int, float, float, float]]:
        """Slot, time, power and expected next time of all that is posted."""
        posted = list[tuple[int, float, float, float]]()

        def post(slot: int, how: tuple[float, float, bool, int]) -> None:
            sent_s, power_dbm, received, cause = how
            posted.append((slot, sent_s, power_dbm, float(self.rows[slot, NEXT_S])))
            self.causes[cause] += 1
            self.lost += not received
            if received:
                self.believed[slot] = (t_s, seen[slot, :2], velocity(seen[slot]))

        for slot in range(3):
            if slot in self.waits and self.waits[slot][0] < t_s + DT_S:
                sent_s, *rest = self.waits.pop(slot)
                post(slot, (max(sent_s, t_s), *rest))
                self.waited += 1
            ask_s = t_s + PHASE[slot] * DT_S
            near, ratio = neighbours_kernels.survey(
                self.tables.hosts, self.tables.slots, slot, ask_s, *seen[slot, :2], 1.0, 100.0
            )
            cause, sent_s, power_dbm, received = j2945_step(
                self.rows[slot], ask_s, ask_s + DT_S, self.error_m(slot, t_s, seen), busy[slot], float(near),
                ratio, event[slot], uniforms[slot, :3], self.constants,
            )  # fmt: skip
            if cause and sent_s < t_s + DT_S:
                post(slot, (sent_s, power_dbm, received, cause))
            elif cause:
                self.waits[slot] = (sent_s, power_dbm, received, cause)
        return posted


@pytest.mark.parametrize("parameters", [PARAMETERS, engine_parameters()], ids=["narrow", "standard"])
@pytest.mark.parametrize("seed", range(3))
def test_a_j2945_sender_posts_what_its_rules_call_for_when_they_call(
    parameters: J2945Parameters, seed: int
) -> None:
    count = 60
    road = Road(Sender("tested", J2945(parameters), PLAIN))
    plain = ByHand(parameters, road.tables)
    seen, uniforms, rng = turns(count, seed), drawn(count, seed), np.random.default_rng(seed)
    busy = rng.uniform(0.2, 0.9, (count, 3))
    event = np.zeros((count, 3), dtype=np.bool_)
    event[20:26, 1] = True
    for k in range(count):
        t_s = round(DT_S * k, 6)
        for remote in range(5):  # every host hears some of what five remotes send
            for host in range(3 if k % (remote + 1) == 0 else 0):
                neighbours_kernels.hear(
                    *road.tables, host, remote, k % 128, t_s - 0.05, 25.0 * remote, 0.0, 1.0
                )
        expected = plain.step(t_s, seen[k], uniforms[k], busy=busy[k], event=event[k])
        road.measure(t_s, seen[k])
        posted = road.step(t_s, uniforms[k], started=np.full(3, k == 0), critical=event[k], busy=busy[k])
        found = [(one.slot, one.ready_s, one.power_dbm, one.next_s) for one in posted]
        assert [one[0] for one in found] == [one[0] for one in expected]
        np.testing.assert_allclose(found, expected, atol=1e-6)
    assert road.tally.causes.tolist() == plain.causes
    assert min(plain.causes[1], plain.causes[3], plain.waited) > 0
    assert road.tally.total[at.MODELS] == 0


def test_an_identification_says_which_update_it_names_and_repeats_it() -> None:
    bank = Bank((ConstantAcceleration(), CV))
    sender = Sender("tested", ErrorDriven(0.15, "order", "best"), bank, jitter_s=0.0)
    road, seen = Road(sender), turns()
    updates: dict[int, Posted] = {}
    named = models = 0
    offsets = road.bank.bank.offsets
    for k, posted in enumerate(driven(road, seen, drawn(40))):
        for one in posted:
            row = one.row
            assert row[at.CONTENT_NAMED_S] == round(DT_S * k, 6)
            assert row[at.CONTENT_SENT_S] == one.ready_s == pytest.approx(DT_S * k + DT_S * PHASE[one.slot])
            assert row[at.CONTENT_VEHICLE] == 11 + one.slot
            if row[at.CONTENT_KIND] == IDENTIFICATION:
                named += 1
                before = updates[one.slot]
                assert row[at.CONTENT_UPDATE] == before.number < one.number
                assert row[at.CONTENT_BYTES] == sender.sizes.identification_bytes
                same = [at.CONTENT_FIT_S, at.CONTENT_EAST_M, at.CONTENT_NORTH_M]
                np.testing.assert_array_equal(row[same], before.row[same])
                np.testing.assert_array_equal(row[at.CONTENT_HEAD :], before.row[at.CONTENT_HEAD :])
                assert row[at.CONTENT_FIT_S] < row[at.CONTENT_NAMED_S]
                continue
            updates[one.slot] = one
            models += not sender.plain[int(row[at.CONTENT_MEMBER])]
            assert row[at.CONTENT_UPDATE] == one.number
            assert row[at.CONTENT_BYTES] == sender.update_bytes[int(row[at.CONTENT_MEMBER])]
            np.testing.assert_allclose(row[[at.CONTENT_EAST_M, at.CONTENT_NORTH_M]], seen[k, one.slot, :2])
            own = velocity(seen[k, one.slot])
            np.testing.assert_allclose(row[at.CONTENT_HEAD :][offsets[1] :], own, atol=0.02)
            np.testing.assert_allclose(row[at.CONTENT_HEAD :][:2], own, atol=0.02)
    assert named > 3
    assert road.tally.total[at.IDENTIFICATIONS] == named
    assert road.tally.total[at.MODELS] == models
    assert road.stations.senders.update.tolist() == [updates[slot].number for slot in range(3)]


def test_without_identifications_an_update_holds_the_member_in_use_alone() -> None:
    bank = Bank((ConstantAcceleration(), CV))
    sender = Sender("tested", ErrorDriven(0.15, "keep", "never"), bank, jitter_s=0.0)
    road = Road(sender)
    assert road.contents.rows.shape[2] == at.CONTENT_HEAD + 3
    seen = turns()
    for k, posted in enumerate(driven(road, seen, drawn(40))):
        for one in posted:
            wanted = [*velocity(seen[k, one.slot]), seen[k, one.slot, 4]]
            np.testing.assert_allclose(one.row[at.CONTENT_HEAD :], wanted, atol=0.02)


def test_new_stations_begin_within_the_spread_and_send_nothing_before() -> None:
    sender = Sender("tested", Periodic(10.0), PLAIN, jitter_s=0.0)
    road, seen, uniforms = Road(sender), turns(), drawn(40)
    first: dict[int, int] = {}
    for k in range(40):
        road.measure(DT_S * k, seen[k])
        posted = road.step(DT_S * k, uniforms[k], started=np.full(3, k == 0), spread_s=2.0)
        for one in posted:
            first.setdefault(one.slot, k)
    begins_s = 2.0 * uniforms[0, :, 3]
    assert [first[slot] for slot in range(3)] == np.ceil(begins_s / DT_S).astype(int).tolist()


def test_who_takes_a_slot_over_has_sent_nothing_and_an_empty_slot_says_nothing() -> None:
    bank = Bank((ConstantAcceleration(), CV))
    for policy in (
        ErrorDriven(0.15, "order", "best", 2.0),
        J2945(engine_parameters()),
        CooperativeAwareness(),
        Periodic(3.0),
    ):
        road, seen, uniforms = Road(Sender("tested", policy, bank, jitter_s=0.0)), turns(), drawn(40)
        driven(road, seen[:20], uniforms)
        senders, numbers = road.stations.senders, road.stations.senders.number.copy()
        senders.vehicle[:] = [11, 99, -1]
        road.measure(2.0, seen[20])
        started = np.array([False, True, False])
        posted = road.step(2.0, uniforms[20], started=started)
        assert 2 not in {one.slot for one in posted}
        own = next(one for one in posted if one.slot == 1)
        assert (own.row[at.CONTENT_VEHICLE], own.number) == (99, numbers[1])
        assert own.row[at.CONTENT_KIND] == UPDATE
        # The first after the start carries the certificate again.
        payload = np.array([int(own.row[at.CONTENT_BYTES])])
        assert own.size_bytes == Stack().frame_bytes(payload, np.array([True]))[0]


def test_some_slots_alone_decide() -> None:
    for slots, expected in (((0, 3), [0, 1, 2]), ((1, 3), [1, 2]), ((0, 1), [0]), ((2, 2), [])):
        road = Road(Sender("tested", Periodic(10.0), PLAIN))
        road.measure(0.0, turns()[0])
        posted = road.step(0.0, drawn(1)[0], started=np.ones(3, dtype=np.bool_), slots=slots)
        assert [one.slot for one in posted] == expected


def framed(sizes: FrameSizes) -> Sender:
    return Sender("sized", Periodic(10.0), PLAIN, stack=Stack("unsigned"), frames=sizes)


def test_frames_of_a_chain_are_as_long_as_it_says_whatever_they_hold() -> None:
    """Two sizes in turn, of every station for itself; a payload is what 35 bytes of headers leave."""
    road = Road(framed(FrameSizes((100, 200), MarkovChain(((0.0, 1.0), (1.0, 0.0))))))
    steps = driven(road, turns(12), np.random.default_rng(3).random((12, 3, 4)))
    for slot in range(3):
        sent = [one for step in steps for one in step if one.slot == slot]
        assert len(sent) >= 10
        sizes = [one.size_bytes for one in sent]
        assert set(map(frozenset, pairwise(sizes))) == {frozenset((100, 200))}
        assert [one.row[at.CONTENT_BYTES] for one in sent] == [one - 35 for one in sizes]
    total = road.tally.total
    assert total[at.FRAME_BYTES] == total[at.PAYLOAD_BYTES] + 35 * total[at.MESSAGES]
    assert total[at.CERTIFICATES] == 0.0


def test_sizes_drawn_do_not_depend_on_who_is_worked_on_together() -> None:
    seen, uniforms = turns(30), np.random.default_rng(4).random((30, 3, 4))
    together, apart = Road(framed(measured_cam_sizes())), Road(framed(measured_cam_sizes()))
    whole, parts = list[tuple[int, int]](), list[tuple[int, int]]()
    for k, measured in enumerate(seen):
        started = np.full(3, k == 0)
        for road, cuts, found in ((together, [(0, 3)], whole), (apart, [(2, 3), (0, 2)], parts)):
            road.measure(round(DT_S * k, 6), measured)
            for slots in cuts:
                posted = road.step(round(DT_S * k, 6), uniforms[k], started=started, slots=slots)
                found += [(one.slot, one.size_bytes) for one in posted]
    for slot in range(3):
        sizes = [size for one, size in whole if one == slot]
        assert sizes == [size for one, size in parts if one == slot]
        assert len(set(sizes)) > 1
    assert len({tuple(size for one, size in whole if one == slot) for slot in range(3)}) == 3


def test_sizes_of_cars_are_refused_where_they_mean_nothing() -> None:
    sized = framed(measured_cam_sizes())
    with pytest.raises(ValueError, match="must be unsigned"):
        replace(sized, stack=Stack())
    with pytest.raises(ValueError, match="as long as cars'"):
        sized.of_kind(Kind.PEDESTRIAN)
    with pytest.raises(ValueError, match="longer than what goes round"):
        framed(FrameSizes((35,), MarkovChain(((1.0,),))))

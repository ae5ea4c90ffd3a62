"""Claims about single steps of stations on the air: states set by hand, and what each column holds after."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.airtime import Stack
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.station.policy import cam_kernels, dcc_kernels, neighbours_kernels
from modelcast.station.policy import j2945_kernels as j2945
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.periodic import Periodic
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.octets import SentMessages, messages_of
from modelcast.station.sender.posting_kernels import StepInputs
from modelcast.station.sender.sender import Sender, engine_parameters
from modelcast.station.sender.sending_kernels import send_each
from modelcast.station.sender.stations import sender_bank, sending_stations, widest
from modelcast.station.sensing.sensing import Sensing
from modelcast.station.sensing.sensing_kernels import sense

CA, CTRA, CV = ConstantAcceleration(), ConstantTurnRateAcceleration(), ConstantVelocity()
GP = GaussianProcess(3, "intercept")
PLAIN = Bank((CV,))
NOTHING, UPDATE, IDENTIFICATION = range(3)
DT_S = 0.125
"""A step whose sums have no rounding."""


def moving(t_s: float, speed_mps: float = 16.0, acceleration_mps2: float = 0.0) -> FloatArray:
    """Two cars east and north of where they began, as measured; they report an acceleration."""
    speed = np.array([speed_mps, 0.5 * speed_mps])
    heading = np.array([0.5 * np.pi, 0.0])
    own = np.zeros((2, 6))
    own[:, 0], own[:, 1] = [speed[0] * t_s, -70.0], [40.0, speed[1] * t_s]
    own[:, 2], own[:, 3], own[:, 4] = speed, heading, acceleration_mps2
    return own


@dataclass
class Pair:
    """Two stations, 11 in slot 0 and 12 in slot 1, that share steps."""

    sender: Sender
    phase: tuple[float, float] = (0.0, 0.5)

    def __post_init__(self) -> None:
        self.sensing = Sensing()
        phase = np.array(self.phase)
        self.f = sending_stations(self.sender, sender_bank(self.sender, DT_S), phase, sensing=self.sensing)
        self.f.senders.vehicle[:] = [11, 12]
        self.tables = neighbour_tables(2, 8)
        self.contents = at.contents(2, widest(self.sender, sender_bank(self.sender, DT_S)))
        self.out, self.tally = at.outbox(2), at.sent_tally()

    def measure(self, t_s: float, seen: FloatArray, begins: bool = False) -> None:
        """Let both measure."""
        whose, numbers = np.arange(2), self.sensing.numbers(DT_S)
        sense(self.f.sensed, whose, np.full(2, t_s), seen, np.full(2, begins), numbers)

    def step(
        self, t_s: float, *, started: bool = False, spread_s: float = 0.0, uniform: float = 0.5
    ) -> list[int]:
        """Return who sends."""
        uniforms = np.full((2, 4), uniform)
        nobody = np.zeros(2, dtype=np.bool_)
        inputs = StepInputs(t_s, DT_S, spread_s, np.full(2, started), nobody, np.zeros(2), uniforms)
        send_each(self.f, inputs, self.tables, self.contents, self.out, self.tally, 0, 2)
        return self.out.sender[: self.out.filled[0]].tolist()

    def row(self, slot: int, number: int) -> FloatArray:
        """Return the content of a message."""
        return self.contents.rows[slot, number % at.MESSAGES_KEPT]


def error_driven(bank: Bank, **rules: Any) -> Pair:
    return Pair(Sender("tested", ErrorDriven(0.03, **rules), bank, jitter_s=0.0))


@pytest.mark.parametrize("start", ["order", "guarded"])
def test_the_first_slot_names_what_still_holds_and_repeats_the_update_it_is_of(start: Any) -> None:
    """Cars keep their velocity and report 8 m/s²: constant acceleration is 6 cm off after one step.

    The process has no full window yet, so that all it would have is zero, in update and identification.
    """
    pair = error_driven(Bank((GP, CA, CV)), start=start, identify="on-failure")
    pair.measure(0.0, moving(0.0, acceleration_mps2=8.0))
    assert pair.step(0.0, started=True) == [0, 1]
    assert pair.f.senders.update.tolist() == [0, 0]
    offsets = pair.f.models.members.offsets
    expected = [0.0] * int(offsets[1]) + [16.0, 0.0, 8.0, 16.0, 0.0]
    first = pair.row(0, 0).copy()
    assert first[at.CONTENT_HEAD :].tolist() == pytest.approx(expected, abs=1e-9)
    assert (first[at.CONTENT_KIND], first[at.CONTENT_MEMBER]) == (UPDATE, 1)
    pair.measure(DT_S, moving(DT_S, acceleration_mps2=8.0))
    assert 0 in pair.step(DT_S)
    named = pair.row(0, 1)
    assert (named[at.CONTENT_KIND], named[at.CONTENT_MEMBER]) == (IDENTIFICATION, 2)
    assert named[at.CONTENT_HEAD :].tolist() == first[at.CONTENT_HEAD :].tolist()
    same = [at.CONTENT_UPDATE, at.CONTENT_FIT_S, at.CONTENT_EAST_M, at.CONTENT_NORTH_M]
    assert named[same].tolist() == first[same].tolist()
    assert (named[at.CONTENT_NUMBER], named[at.CONTENT_NAMED_S]) == (1, DT_S)
    assert pair.f.senders.update[0] == 0  # remotes hold the update, not what names it
    assert pair.f.senders.number[0] == 2
    assert pair.contents.beliefs[0, 1, : at.BELIEF_ERROR].tolist() == [1, -1]
    assert (pair.contents.beliefs[0, 2:] == -1).all()


def test_what_a_message_made_believe_before_it_makes_believe_no_longer() -> None:
    pair = Pair(Sender("tested", Periodic(8.0), PLAIN, jitter_s=0.0))
    pair.contents.beliefs[:] = 77
    pair.measure(0.0, moving(0.0))
    assert pair.step(0.0, started=True) == [0, 1]
    # Without its first word the second, an error, is not looked at.
    assert pair.contents.beliefs[:, 0, : at.BELIEF_ERROR].tolist() == [[0, -1], [0, -1]]
    assert (pair.contents.beliefs[:, 1:] == 77).all()


@pytest.mark.parametrize("start", ["order", "guarded"])
def test_a_station_that_takes_a_slot_over_and_waits_has_nothing_that_another_sent(start: Any) -> None:
    pair = error_driven(Bank((CA, CV)), start=start, identify="best")
    for k in range(3):
        pair.measure(DT_S * k, moving(DT_S * k, acceleration_mps2=8.0))
        pair.step(DT_S * k, started=k == 0)
    lanes, senders = pair.f.lanes, pair.f.senders
    assert (lanes.update >= 0).all()
    assert (senders.update >= 0).all()
    numbers = senders.number.copy()
    assert pair.step(0.5, started=True, spread_s=4.0, uniform=0.75) == []
    assert (lanes.update == -1).all()
    assert (lanes.in_use == -1).all()
    assert (lanes.message_s == -np.inf).all()
    assert not lanes.usable.any()
    assert senders.update.tolist() == [-1, -1]
    assert senders.sent_s.tolist() == senders.certified_s.tolist() == [-np.inf] * 2
    assert senders.number.tolist() == numbers.tolist()
    assert pair.f.timers.begins_s.tolist() == [3.5, 3.5]
    assert pair.f.timers.begun.tolist() == [False, False]
    assert pair.step(3.375) == []
    assert pair.step(3.5) == [0, 1]


def test_timers_that_begin_anew_hold_nothing_from_before() -> None:
    policy = CooperativeAwareness(control=AdaptiveDcc())
    pair = Pair(Sender("tested", policy, PLAIN, jitter_s=0.0))
    timers = pair.f.timers
    timers.pending[:], timers.control[:], timers.rows[:], timers.due_s[:] = 5.0, 7.0, 3.0, 9.0
    pair.measure(2.0, moving(0.0))
    assert pair.step(2.0, started=True, spread_s=4.0, uniform=0.5) == []
    assert timers.pending.tolist() == [[np.inf] * 4] * 2
    assert timers.due_s.tolist() == [-np.inf] * 2
    share = pair.f.policy.start_share
    assert timers.control.tolist() == [[share, 0.0, 0.0, 0.0, 2.0]] * 2
    assert timers.rows[:, cam_kernels.LAST_S].tolist() == [-np.inf] * 2
    assert timers.rows[:, cam_kernels.INTERVAL_S].tolist() == [1.0, 1.0]
    assert timers.rows[:, cam_kernels.COUNTED].tolist() == [0.0, 0.0]
    assert (timers.rows[:, cam_kernels.STATE_COLUMNS :] == 3.0).all()


def test_a_share_of_the_channel_is_of_the_largest_message_with_its_certificate() -> None:
    """A share with which that message may come every 0.126 s, more than a step: every other step it is.

    A frame one symbol shorter would be allowed every 0.124 s, and so at every step.
    """
    policy = CooperativeAwareness(control=AdaptiveDcc())
    bank = Bank((CV, CTRA))
    sender = Sender("tested", policy, bank, jitter_s=0.0)
    assert sender.update_bytes.tolist() == [40, 47]
    stack = Stack()
    airtime_s = float(stack.airtime_s(np.array([47]), np.array([True]))[0])
    assert airtime_s > stack.airtime_s(np.array([40]), np.array([True]))[0] + 0.9 * stack.symbol_s
    pair = Pair(sender, (0.0, 0.0))
    sent = list[list[int]]()
    for k in range(5):
        pair.measure(DT_S * k, moving(DT_S * k, speed_mps=80.0))  # 4 m and more a step
        if k == 0:
            pair.step(0.0, started=True, spread_s=4.0, uniform=0.0)
            pair.f.timers.rows[:, cam_kernels.LAST_S] = -np.inf
            pair.f.timers.control[:, dcc_kernels.SHARE] = airtime_s / 0.1255
            pair.f.timers.control[:, dcc_kernels.DUE_S] = 100.0
        sent.append(pair.step(DT_S * k))
    assert sent == [[0, 1], [], [0, 1], [], [0, 1]]


ACCURACY_S = 2.0**-10
PARAMETERS = replace(
    engine_parameters(), time_accuracy_s=ACCURACY_S, power_control=False, channel_quality_weight=1.0
)


def quiet(bank: Bank = PLAIN) -> Pair:
    """Two stations under J2945/1 that have begun, and for which nothing falls due in 100 s."""
    pair = Pair(Sender("tested", J2945(PARAMETERS), bank, jitter_s=0.0))
    pair.measure(0.0, moving(0.0))
    assert pair.step(0.0, started=True, spread_s=4.0, uniform=0.5) == []
    pair.f.timers.begun[:] = True
    for column in (j2945.NEXT_S, j2945.CONTROL_S, j2945.COUNT_S, j2945.SURVEY_S):
        pair.f.timers.rows[:, column] = 100.0
    assert pair.step(0.0) == []
    return pair


def test_what_waits_for_the_end_of_a_step_leaves_in_the_next() -> None:
    pair = quiet()
    pair.f.timers.pending[1] = [DT_S, 13.0, 1.0, 2.0]
    assert pair.step(0.0) == []
    assert pair.f.timers.pending[1].tolist() == [DT_S, 13.0, 1.0, 2.0]
    pair.measure(DT_S, moving(DT_S))
    assert pair.step(DT_S) == [1]
    out = pair.out
    assert (out.ready_s[0], out.power_dbm[0], out.next_s[0]) == (DT_S, 13.0, 100.0)
    assert pair.tally.causes.tolist() == [0, 0, 1, 0]
    assert pair.f.timers.pending[1, 0] == np.inf
    assert pair.f.senders.update.tolist() == [-1, 0]


def test_what_waited_too_long_leaves_at_once() -> None:
    pair = quiet()
    pair.f.timers.pending[1] = [0.25, 13.0, 1.0, 1.0]
    pair.measure(0.5, moving(0.5))
    assert pair.step(0.5) == [1]
    assert pair.out.ready_s[0] == 0.5


@pytest.mark.parametrize("believed", [0.0, 1.0])
def test_what_is_believed_lost_changes_nothing_that_remotes_hold(believed: float) -> None:
    """Number and time go on; what the next error is measured against does not."""
    pair = quiet()
    lanes, senders = pair.f.lanes, pair.f.senders
    lanes.update[:], senders.update[:] = -1, -1
    pair.f.timers.pending[0] = [0.0, 20.0, believed, 1.0]
    assert pair.step(0.0) == [0]
    assert senders.number.tolist() == [1, 0]
    assert senders.sent_s.tolist() == [0.0, -np.inf]
    assert senders.update.tolist() == [0 if believed else -1, -1]
    assert lanes.update.tolist() == [0 if believed else -1, -1]


@pytest.mark.parametrize("lost", [False, True])
def test_what_falls_due_where_the_step_ends_waits_with_all_that_was_decided_of_it(lost: bool) -> None:
    """Slot 1 decides in the middle of its step; a channel of quality 1 loses the message for sure."""
    pair = quiet()
    row = pair.f.timers.rows[1]
    row[j2945.NEXT_S], row[j2945.CHANNEL_QUALITY] = DT_S, 1.0 if lost else 0.0
    row[j2945.INTER_TRANSMIT_TIME_S] = 0.5
    assert pair.step(0.0) == []
    power_dbm = PARAMETERS.max_power_dbm
    assert pair.f.timers.pending[1].tolist() == [DT_S, power_dbm, 0.0 if lost else 1.0, j2945.CAUSE_TIME]
    assert pair.f.timers.pending[0].tolist() == [np.inf] * 4
    row[j2945.NEXT_S] = 100.0
    pair.measure(DT_S, moving(DT_S))
    assert pair.step(DT_S) == [1]
    assert pair.f.senders.update.tolist() == [-1, -1 if lost else 0]


def test_what_falls_due_before_the_step_ends_leaves_in_it() -> None:
    pair = quiet()
    pair.f.timers.rows[:, j2945.NEXT_S] = DT_S - ACCURACY_S
    assert pair.step(0.0) == [0, 1]
    assert pair.out.ready_s[:2].tolist() == [DT_S - ACCURACY_S] * 2
    assert (pair.f.timers.pending[:, 0] == np.inf).all()


def test_an_error_is_measured_against_the_very_first_sample_too() -> None:
    """At 16 m/s, heard at rest, remotes are 2 m off after a step: more than calls for a message for sure."""
    for update, sends in ((0, True), (-1, True)):
        pair = quiet()
        pair.f.lanes.update[:], pair.f.lanes.in_use[:] = update, 0
        pair.f.lanes.origin[0] = [0.0, 0.0, 40.0]
        pair.f.lanes.held[0] = [16.0, 0.0]
        pair.measure(DT_S, moving(DT_S))
        pair.f.timers.rows[0, j2945.CONTROL_S] = DT_S
        assert (pair.step(DT_S) == [0]) == (sends and update < 0)  # they predict rightly what they hold
        assert pair.f.timers.rows[0, j2945.PROBABILITY] == (0.0 if update == 0 else 1.0)


def surrounded(pair: Pair) -> None:
    """Let six be heard around slot 0, which is at (0, 40), and every second message of each be lost.

    The first two lie within 100 m. The others do not, but would of (0, 16) or (40, 40).
    """
    places = [(0.0, 139.0), (60.0, 110.0), (0.0, -61.0), (101.0, 40.0), (-70.0, -75.0), (135.0, 60.0)]
    for k, count in enumerate((0, 2, 4)):
        for remote, (east, north) in enumerate(places):
            neighbours_kernels.hear(*pair.tables, 0, remote, count, 2.125 + 0.25 * k, east, north, 1.0)


@pytest.mark.parametrize("ahead", [0.0, 1.0])
def test_remotes_are_counted_when_a_count_is_due_within_the_accuracy_of_time(ahead: float) -> None:
    """Not where it is due later still; the survey is not due at all."""
    for beyond, counted in ((0.0, 2.0), (2.0**-20, -5.0)):
        pair = quiet()
        surrounded(pair)
        row = pair.f.timers.rows[0]
        row[j2945.NEIGHBOURS] = -5.0
        row[j2945.COUNT_S] = 3.0 + ahead * ACCURACY_S + beyond * ahead
        pair.measure(3.0, moving(0.0))
        assert pair.step(3.0) == []
        assert row[j2945.NEIGHBOURS] == (counted if ahead else 2.0)
        assert row[j2945.CHANNEL_QUALITY] == 0.0
        assert row[j2945.SURVEY_S] == 100.0


@pytest.mark.parametrize("ahead", [0.0, 1.0])
def test_a_survey_is_due_within_the_accuracy_of_time_and_counts_for_both(ahead: float) -> None:
    """Three messages of five arrived, as far as the counts tell: two fifths were lost, of which 0.3 count."""
    pair = quiet()
    surrounded(pair)
    row = pair.f.timers.rows[0]
    row[j2945.NEIGHBOURS] = -5.0
    row[j2945.COUNT_S] = row[j2945.SURVEY_S] = 3.0 + ahead * ACCURACY_S
    pair.measure(3.0, moving(0.0))
    assert pair.step(3.0) == []
    assert row[j2945.NEIGHBOURS] == 2.0
    assert row[j2945.CHANNEL_QUALITY] == min(0.4, PARAMETERS.max_packet_error_ratio) > 0.0


def test_messages_are_read_from_rings_with_the_sample_they_were_decided_at() -> None:
    """Both of each step, whatever the ring; slots asked for in any order."""
    pair = error_driven(Bank((GP, CA, CV)), identify="on-failure")
    ring = pair.f.sensed.stated_m.shape[1]
    assert ring >= 3
    seen = list[int]()
    for k in range(2 * ring + 1):
        measured = moving(DT_S * k, acceleration_mps2=8.0 * (-1) ** k)
        measured[:, :2] += k * k
        pair.measure(DT_S * k, measured)
        who = pair.step(DT_S * k, started=k == 0)[::-1]
        slot, number = np.array(who, dtype=np.int64), pair.f.senders.number[who] - 1
        found: SentMessages = messages_of(pair.f, pair.contents, slot, number)
        assert found.vehicle.tolist() == [11 + one for one in who]
        assert found.number.tolist() == number.tolist()
        np.testing.assert_array_equal(found.sample[:, :2], measured[who, :2])
        np.testing.assert_array_equal(found.sample[:, 4], measured[who, 4])
        for row, one in enumerate(who):
            content = pair.row(one, int(number[row]))
            assert found.kind[row] == content[at.CONTENT_KIND]
            assert found.update[row] == content[at.CONTENT_UPDATE]
            assert found.fit_s[row] == content[at.CONTENT_FIT_S]
            assert found.t_s[row] == content[at.CONTENT_NAMED_S] == DT_S * k
            assert found.in_use[row] == content[at.CONTENT_MEMBER]
            assert found.stated_m[row].tolist() == content[[at.CONTENT_EAST_M, at.CONTENT_NORTH_M]].tolist()
            assert found.parameters[row].tolist() == content[at.CONTENT_HEAD :].tolist()
            seen.append(int(found.kind[row]))
    assert UPDATE in seen


def test_of_an_update_alone_parameters_stand_where_their_sub_model_has_them() -> None:
    pair = error_driven(Bank((CTRA, CA, CV)), identify="never")
    pair.measure(0.0, moving(0.0, acceleration_mps2=2.0))
    pair.step(0.0, started=True)
    for member, values in ((0, [16.0, 0.0, 2.0, 0.0]), (1, [16.0, 0.0, 2.0]), (2, [16.0, 0.0])):
        pair.contents.rows[0, 0, at.CONTENT_MEMBER] = member
        found = messages_of(pair.f, pair.contents, np.array([0]), np.array([0]))
        first = [0, 4, 7][member]
        expected = np.zeros(9)
        expected[first : first + len(values)] = values
        np.testing.assert_allclose(found.parameters[0], expected, atol=0.011)

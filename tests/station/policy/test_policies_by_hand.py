"""Claims about compiled rules: over random inputs each does what its words say, in plain Python."""

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.station.policy import cam_kernels, error_driven_kernels, hindsight_kernels, neighbours_kernels
from modelcast.station.policy import j2945_kernels as rules
from modelcast.station.policy.cam import CamTriggering
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.timer_kernels import next_due
from modelcast.station.policy.tracking_error_kernels import tracking_error

TIMES = 1e-6
"""Sums of steps in another order [s]."""


def later(due_s: float, now_s: float, interval_s: float) -> float:
    """The next time on a timer's grid that is not over, by counting."""
    due_s += interval_s
    while due_s <= now_s + 1e-9 * interval_s:
        due_s += interval_s
    return due_s


@pytest.mark.parametrize("interval_s", [0.1, 1.0, 0.25])
def test_a_timer_passes_over_what_fell_due_meanwhile(interval_s: float) -> None:
    for now_s in (-0.3, 0.0, 0.04, 0.1, 0.2, 0.26, 0.9999, 1.0, 7.31):
        assert next_due(0.0, now_s, interval_s) == pytest.approx(later(0.0, now_s, interval_s))


# SAE J2945/1 -----------------------------------------------------------------------------------------------


@dataclass
class Vehicle:
    """One vehicle under SAE J2945/1, as its clauses read."""

    p: J2945Parameters
    start_s: float
    phase: float
    last_s: float = -math.inf
    neighbours: float = 0.0
    density: float = 0.0
    quality: float = 0.0
    busy: float = 0.0
    probability: float = 0.0
    failures: int = 0
    cause: int = 1
    critical: bool = False

    def __post_init__(self) -> None:
        self.next_s = self.control_s = self.start_s + self.phase * self.p.rate_control_interval_s
        self.count_s = self.start_s + self.phase * self.p.density_interval_s
        self.survey_s = self.start_s + self.phase * self.p.per_sub_interval_s
        self.longest_s = self.p.min_inter_transmit_time_s
        self.power_dbm = self.p.start_power_dbm

    def row(self) -> list[float]:
        """In the order of the compiled columns."""
        return [
            self.last_s, self.next_s, self.control_s, self.count_s, self.survey_s, self.neighbours,
            self.density, self.quality, self.busy, self.longest_s, self.probability, self.power_dbm,
            self.failures, self.cause, float(self.critical),
        ]  # fmt: skip

    def chance(self, error_m: float) -> float:
        """Probability of a message for an error."""
        p = self.p
        error_m /= max(1.0, min(self.density / p.density_coefficient, p.max_error_growth))
        if not p.tracking_error_trigger or not error_m >= p.min_tracking_error_m:
            return 0.0
        if error_m >= p.max_tracking_error_m:
            return 1.0
        beyond = (error_m - p.min_tracking_error_m) ** (2 if p.squared_exponent else 1)
        return 1.0 - math.exp(-p.error_sensitivity * beyond)

    def count_and_survey(self, now_s: float, near: float, ratio: float) -> None:
        """Take in what is heard, where it is due."""
        p, early_s = self.p, self.p.time_accuracy_s
        if now_s >= self.count_s - early_s:
            self.neighbours = near
            self.count_s = later(self.count_s, now_s + early_s, p.density_interval_s)
        if now_s >= self.survey_s - early_s:
            mean = 0.0 if math.isnan(ratio) else min(ratio, p.max_packet_error_ratio)
            weight = p.channel_quality_weight
            self.quality = min((1 - weight) * self.quality + weight * mean, p.max_packet_error_ratio)
            self.survey_s = later(self.survey_s, now_s + early_s, p.per_sub_interval_s)

    def control(self, now_s: float, error_m: float, busy: float, draw: float) -> None:
        """Smooth, and bring the next message forward."""
        p = self.p
        if now_s < self.control_s - p.time_accuracy_s:
            return
        self.busy += p.busy_weight * (busy - self.busy)
        self.density += p.density_weight * (self.neighbours - self.density)
        share = max(1.0, self.density / p.density_coefficient)
        self.longest_s = min(
            p.min_inter_transmit_time_s * share,
            p.max_inter_transmit_time_s if share > 1.0 else math.inf,
        )
        self.probability = self.chance(error_m)
        if draw < self.probability and self.next_s - now_s >= p.reschedule_threshold_s - 1e-9:
            self.next_s, self.cause = now_s, 2
        elif (
            self.last_s > -math.inf
            and self.next_s - self.last_s - self.longest_s >= p.reschedule_threshold_s - 1e-9
        ):
            self.next_s, self.cause = max(now_s, self.last_s + self.longest_s), 1
        self.control_s = later(self.control_s, now_s + p.time_accuracy_s, p.rate_control_interval_s)

    def watch(self, now_s: float, event: bool) -> None:
        """A critical event sends at once and then at every critical interval."""
        if event and not self.critical:
            self.next_s = now_s
        elif event:
            self.next_s = min(self.next_s, max(now_s, self.last_s + self.p.critical_interval_s))
        elif self.cause == 3:
            self.next_s, self.cause = self.last_s + self.longest_s, 1
        if event:
            self.cause = 3
        self.critical = event

    def send(self, jitter: float, loss: float, at_s: float) -> tuple[float, bool]:
        """Power, and whether it is believed received; the next is scheduled."""
        p, power_dbm = self.p, self.p.max_power_dbm
        if p.power_control and self.cause == 1:
            high, low = p.max_power_dbm, p.min_power_dbm
            share = (self.busy - p.min_busy_ratio) / (p.max_busy_ratio - p.min_busy_ratio)
            wanted = high - (high - low) * min(max(share, 0.0), 1.0)
            self.power_dbm += p.power_gain * (wanted - self.power_dbm)
            power_dbm = self.power_dbm
        lost = loss < self.quality and self.failures < p.max_successive_failures
        self.failures = self.failures + 1 if lost else 0
        follows = self.cause == 2 and p.follow_up_s > 0.0
        wait_s = min(self.longest_s, p.follow_up_s) if follows else self.longest_s
        self.last_s, self.next_s, self.cause = at_s, at_s + wait_s + p.jitter_s * (2.0 * jitter - 1.0), 1
        return power_dbm, not lost


SETS = {
    "standard": J2945Parameters(),
    "unsquared": J2945Parameters(squared_exponent=False, error_sensitivity=2.0, density_weight=0.6),
    "smooth": J2945Parameters(channel_quality_weight=0.4, busy_weight=0.3, max_packet_error_ratio=0.8),
    "relaxed": J2945Parameters(
        max_inter_transmit_time_s=0.9, max_error_growth=3.0, follow_up_s=0.15, density_weight=0.5
    ),
    "bare": J2945Parameters(tracking_error_trigger=False, power_control=False, max_successive_failures=1),
    "slow timers": J2945Parameters(
        density_interval_s=0.35, per_sub_interval_s=0.5, rate_control_interval_s=0.2, critical_interval_s=0.3
    ),
}


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("seed", range(4))
def test_j2945_is_its_clauses(name: str, seed: int) -> None:
    p, rng = SETS[name], np.random.default_rng(seed)
    plain = Vehicle(p, 3.0, float(rng.random()))
    row, constants = np.full(15, 7.0), p.constants()
    rules.start(row, 3.0, plain.phase, constants)
    assert row.tolist() == pytest.approx(plain.row())
    now_s, event, sent = 3.0 + 0.1 * plain.phase, False, 0
    for _ in range(120):
        error_m, busy, near = (
            float(rng.uniform(0.0, 0.8)),
            float(rng.uniform(0.2, 1.0)),
            float(rng.integers(0, 200)),
        )
        ratio = math.nan if rng.random() < 0.2 else float(rng.random())
        event = bool(rng.random() < (0.6 if event else 0.1))
        uniforms = rng.random(3)
        until_s = now_s + 0.1
        answer = rules.step(row, now_s, until_s, error_m, busy, near, ratio, event, uniforms, constants)
        plain.count_and_survey(now_s, near, ratio)
        plain.control(now_s, error_m, busy, uniforms[0])
        plain.watch(now_s, event)
        if plain.next_s >= until_s:
            assert answer[:2] == (0, math.inf)
            assert not answer[3]
        else:
            cause, at_s = plain.cause, max(plain.next_s, now_s)
            power_dbm, believed = plain.send(uniforms[1], uniforms[2], at_s)
            assert answer == (cause, pytest.approx(at_s), pytest.approx(power_dbm), believed)
            sent += 1
        assert row.tolist() == pytest.approx(plain.row(), abs=TIMES)
        now_s += 0.1 if rng.random() < 0.9 else 0.3
    assert sent > 10


def test_a_timer_is_served_up_to_its_accuracy_early_and_no_earlier() -> None:
    """Each of the three timers alone, asked just within 1 ms of its time, and just beyond."""
    p = J2945Parameters()
    constants = p.constants()
    for column, value in ((3, 5), (4, 7), (2, 6)):
        for early_s, served in ((0.0009, True), (0.0011, False), (-0.0009, True)):
            row = np.zeros(15)
            rules.start(row, 0.0, 0.0, constants)
            row[[1, 2, 3, 4]] = 100.0
            row[column], row[5] = 10.0, 3.0 if column == 2 else 0.0
            rules.step(row, 10.0 - early_s, 10.05, 0.0, 0.0, 9.0, 0.2, False, np.zeros(3), constants)
            assert (row[value] != 0.0) == served
            assert row[column] == pytest.approx(10.0 + served * (1.0 if column == 4 else 0.1))


def test_power_and_times_at_their_bounds() -> None:
    constants = J2945Parameters().constants()
    assert [rules.power_for(busy, constants) for busy in (0.5, 0.65, 0.8)] == pytest.approx(
        [20.0, 15.0, 10.0]
    )
    times = [
        rules.max_inter_transmit_time(density, constants) for density in (24.9, 25.0, 25.5, 150.0, 151.0)
    ]
    assert times == pytest.approx([0.1, 0.1, 0.102, 0.6, 0.6])


@pytest.mark.parametrize("seed", range(30))
def test_the_tracking_error_takes_each_position_by_its_age(seed: int) -> None:
    """As stated while young, moved on when older, nothing where too old."""
    rng = np.random.default_rng(seed)
    p = J2945Parameters(local_as_is_age_s=0.0625, local_max_age_s=0.125, remote_as_is_age_s=0.25)
    local_age, remote_age = (
        float(rng.choice([0.03, 0.0625, 0.1, 0.125, 0.13])),
        float(rng.choice([0.2, 0.25, 1.0, 3.0, 3.01])),
    )
    now_s = 64.0
    local = np.array([now_s - local_age, *rng.normal(0.0, 30.0, 4)])
    believed, predicted = rng.normal(0.0, 30.0, 2), rng.normal(0.0, 30.0, 2)
    own = local[1:3] + (local_age * local[3:5] if local_age >= 0.0625 else 0.0)
    off = (predicted if remote_age >= 0.25 else believed) - own
    expected = 0.0 if local_age > 0.125 or remote_age > 3.0 else math.hypot(*off)
    found = tracking_error(now_s, local, now_s - remote_age, *believed, *predicted, p.constants())
    assert found == pytest.approx(expected)


# Neighbours ------------------------------------------------------------------------------------------------


@dataclass
class Host:
    """What one host heard: (time, count, east, north) of every message of each remote it has a slot for."""

    capacity: int
    kept: int
    sub_s: float
    phase_s: float
    heard: dict[int, list[tuple[float, int, float, float]]] = field(
        default_factory=lambda: defaultdict(list[tuple[float, int, float, float]])
    )
    refused: int = 0

    def hear(self, remote: int, message: tuple[float, int, float, float]) -> bool:
        """Take a message in, where there is room."""
        if remote not in self.heard and len(self.heard) == self.capacity:
            silent = [k for k, own in self.heard.items() if message[0] - own[-1][0] > self.kept * self.sub_s]
            for one in silent:
                del self.heard[one]
            if not silent:
                self.refused += 1
                return False
        self.heard[remote].append(message)
        return True

    def survey(self, now_s: float, place: FloatArray, range_m: float) -> tuple[int, float]:
        """How many are near, and the mean ratio of what was missed of them."""
        near, ratios = 0, list[float]()
        running = math.floor((now_s - self.phase_s) / self.sub_s + 1e-6)
        for own in self.heard.values():
            time_s, _, east, north = own[-1]
            if (
                now_s - time_s > self.sub_s * (1 + 1e-6)
                or math.hypot(east - place[0], north - place[1]) > range_m
            ):
                continue
            near += 1
            numbers = [math.floor((one[0] - self.phase_s) / self.sub_s + 1e-6) for one in own]
            counted = [
                one[1] for one, at in zip(own, numbers, strict=True) if running - self.kept < at < running
            ]
            if len(counted) >= 2:
                expected = 1 + (counted[-1] - counted[0]) % 128
                ratios.append(max(expected - len(counted), 0) / expected)
        return near, float(np.mean(ratios)) if ratios else math.nan


@pytest.mark.parametrize(("sub_s", "sub_intervals"), [(1.0, 5), (0.5, 3), (0.25, 1)])
@pytest.mark.parametrize("seed", range(3))
def test_a_host_counts_and_gives_up_slots_as_the_words_say(
    sub_s: float, sub_intervals: int, seed: int
) -> None:
    """Six slots, fifteen remotes that come and go, in all directions."""
    rng = np.random.default_rng(seed)
    phase_s = float(rng.random())
    tables = neighbour_tables(1, 6, sub_intervals=sub_intervals, phase_s=np.array([phase_s]))
    plain = Host(6, sub_intervals + 1, sub_s, phase_s)
    counts, slots = np.zeros(15, dtype=int), dict[int, int]()
    present = rng.random(15) < 0.4
    for step in range(400):
        now_s = 0.0371 * step
        if step % 20 == 0:
            present = rng.random(15) < 0.4
        for remote in np.flatnonzero(present & (rng.random(15) < 0.5)).tolist():
            counts[remote] = (counts[remote] + rng.integers(1, 4)) % 128
            where = rng.uniform(-90.0, 90.0, 2)
            slot = neighbours_kernels.hear(*tables, 0, remote, int(counts[remote]), now_s, *where, sub_s)
            assert (slot >= 0) == plain.hear(remote, (now_s, int(counts[remote]), *where))
            if slot >= 0:
                assert slots.get(slot, remote) not in set(plain.heard) - {remote}
                slots[slot] = remote
        if step % 5 == 0:
            asked_s, place = now_s + 0.0113, rng.uniform(-50.0, 50.0, 2)
            near, ratio = neighbours_kernels.survey(
                tables.hosts, tables.slots, 0, asked_s, *place, sub_s, 100.0
            )
            assert (near, ratio) == pytest.approx(plain.survey(asked_s, place, 100.0), nan_ok=True)
            assert near == neighbours_kernels.count(
                tables.hosts, tables.slots, 0, asked_s, *place, sub_s, 100.0
            )
            held = {
                one for one in range(15) if neighbours_kernels.find(tables.slots, tables.lookup, 0, one) >= 0
            }
            assert held == set(plain.heard)
    assert tables.hosts["refused"][0] == plain.refused > 0


def test_more_messages_than_a_slot_can_count_are_as_many_as_it_can() -> None:
    """300 in one sub-interval count as 255: of 300 modulo 128 expected none is missed."""
    tables = neighbour_tables(1, 2)
    for k in range(300):
        neighbours_kernels.hear(*tables, 0, 9, k % 128, 0.003 * k, 0.0, 0.0, 1.0)
    assert tables.slots["received"].max() == 255
    assert neighbours_kernels.survey(tables.hosts, tables.slots, 0, 1.0, 0.0, 0.0, 1.0, 100.0) == (1, 0.0)


def test_a_crowd_of_ids_is_found_whatever_was_given_up() -> None:
    """Ids that start their search at the same place of the index."""
    tables = neighbour_tables(1, 32)
    length = tables.lookup.shape[1]
    crowd = [one for one in range(8000) if neighbours_kernels.place(one, length) in {length - 2, length - 1}][
        :60
    ]
    for turn in range(3):
        for at, remote in enumerate(crowd[20 * turn : 20 * turn + 20]):
            neighbours_kernels.hear(*tables, 0, remote, 0, 10.0 * turn + 0.1 * at, 0.0, 0.0, 1.0)
        neighbours_kernels.forget(*tables, 0, 10.0 * turn + 2.0, 1.45)
        found = [one for one in crowd if neighbours_kernels.find(tables.slots, tables.lookup, 0, one) >= 0]
        assert found == crowd[20 * turn + 6 : 20 * turn + 20]


# Cooperative awareness -------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_awareness_is_triggered_as_the_clause_reads(seed: int) -> None:
    """On turn, way or speed beyond the limits once the shortest time is over, else after the interval."""
    rng = np.random.default_rng(seed)
    rule = CamTriggering()
    constants, row = rule.constants(), np.full(7, 5.0)
    cam_kernels.start(row, constants)
    assert row.tolist() == [-math.inf, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    last: tuple[float, FloatArray, float, float] | None = None
    interval_s, counted = 1.0, 0
    place, speed, heading = np.zeros(2), 10.0, 3.0
    causes = {"turn": 0, "way": 0, "speed": 0, "time": 0}
    for step in range(300):
        now_s, shortest_s = 0.1 * step, float(rng.choice([0.1, 0.3]))
        busy = (step // 60) % 2 == 0
        place = place + rng.normal(0.0, 1.0 if busy else 0.01, 2)
        speed += rng.normal(0.0, 0.2 if busy else 0.001)
        heading = (heading + rng.normal(0.0, 0.03 if busy else 1e-4) + math.pi) % (2 * math.pi) - math.pi
        found = cam_kernels.step(row, now_s, *place, speed, heading, shortest_s, constants)
        expected = last is None
        if last is not None and now_s - last[0] >= shortest_s - 1e-9:
            elapsed_s = now_s - last[0]
            turn = abs((heading - last[3] + math.pi) % (2 * math.pi) - math.pi)
            moved = {
                "turn": turn > math.radians(4.0),
                "way": math.hypot(*(place - last[1])) > 4.0,
                "speed": abs(speed - last[2]) > 0.5,
            }
            for name, one in moved.items():
                causes[name] += one
            if any(moved.values()):
                expected, interval_s, counted = True, min(max(elapsed_s, shortest_s), 1.0), 0
            elif elapsed_s >= interval_s - 1e-9:
                expected, counted = True, counted + 1
                causes["time"] += 1
                interval_s = 1.0 if counted >= 3 else interval_s
        assert found == expected
        if expected:
            last = (now_s, place, speed, heading)
        assert row[5:7].tolist() == pytest.approx([interval_s, counted])
    assert min(causes.values()) > 0


def test_awareness_at_its_limits_waits() -> None:
    """A change of exactly the limit does not call for a message: 4 m and 0.5 m/s."""
    constants = CamTriggering().constants()
    for east, speed, sends in ((4.0, 0.0, False), (4.001, 0.0, True), (0.0, 0.5, False), (0.0, 0.501, True)):
        row = np.zeros(7)
        cam_kernels.start(row, constants)
        assert cam_kernels.step(row, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, constants)
        assert cam_kernels.step(row, 0.5, east, 0.0, speed, 0.0, 0.1, constants) == sends


# Algorithm 1 -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("start", ["predicted", "hindsight", "guarded"])
def test_rules_with_scores_start_with_the_first_of_the_highest(seed: int, start: str) -> None:
    """In order where the first available has none; a score that is no number never wins."""
    rng = np.random.default_rng(seed)
    code = getattr(error_driven_kernels, f"START_{start.upper()}")
    for _ in range(40):
        scores = rng.choice([math.nan, 0.0, 0.0, 1.0, 2.0, -1.0], 4)
        available = rng.random(4) < 0.7
        ready = np.flatnonzero(available).tolist()
        if not ready:
            expected = -1
        elif math.isnan(scores[ready[0]]):
            expected = ready[0]
        else:
            expected = max(ready, key=lambda m, s=scores: -math.inf if math.isnan(s[m]) else s[m])
        found = error_driven_kernels.start_member(
            available, rng.random(4), scores, int(rng.integers(-1, 4)), code
        )
        assert found == expected


def test_a_sub_model_kept_is_the_one_in_use_where_it_can_be() -> None:
    keep = error_driven_kernels.START_KEEP
    for available, in_use, expected in (
        ([True, True], 0, 0), ([True, True], 1, 1), ([True, False], 1, 0), ([False, True], 0, 1),
        ([True, True], -1, 0), ([False, False], 1, -1),
    ):  # fmt: skip
        found = error_driven_kernels.start_member(np.array(available), np.zeros(2), np.zeros(2), in_use, keep)
        assert found == expected


TABLE = CostTable(
    12.0,
    3.0,
    thresholds_m=np.array([0.1, 0.4]),
    update_life_s=np.array([2.0, 4.0]),
    age_edges_s=np.array([1.0, 2.0]),
    share_edges=np.array([0.5]),
    residual_life_s=np.arange(1.0, 25.0).reshape(2, 2, 3, 2) / 10.0,
)


def test_costs_are_interpolated_over_the_logarithm_of_the_threshold() -> None:
    """Half-way between 0.1 and 0.4 m is 0.2 m: lives of 3 s, and tables half-way."""
    packed = TABLE.packed(0.2)
    assert packed[:7].tolist() == pytest.approx([3.0, 12.0 / 3.0, 3, 2, 1.0, 2.0, 0.5])
    assert packed[7:] == pytest.approx(TABLE.residual_life_s.mean(axis=0).ravel())
    for threshold_m, at in ((0.1, 0), (0.05, 0), (0.4, 1), (2.0, 1)):
        assert TABLE.packed(threshold_m)[7:] == pytest.approx(TABLE.residual_life_s[at].ravel())
        assert TABLE.packed(threshold_m)[1] == pytest.approx(12.0 / TABLE.update_life_s[at])
    assert TABLE.members == 2


def test_a_life_is_looked_up_by_class_of_age_and_share() -> None:
    packed = TABLE.packed(0.1)
    for member in range(2):
        for row, age_s in enumerate((0.9, 1.0, 2.0)):
            for column, share in enumerate((0.49, 0.5)):
                found = error_driven_kernels.residual_life_s(packed, member, age_s, share)
                assert found == TABLE.residual_life_s[0, member, row, column]


@pytest.mark.parametrize("seed", range(20))
def test_cheapest_weighs_a_naming_against_updates_over_the_life_it_buys(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs = replace(TABLE, identification_cost=float(rng.uniform(0.2, 4.0))).packed(0.1)
    for _ in range(30):
        errors, age_s, in_use = (
            rng.uniform(0.0, 0.2, 2),
            float(rng.uniform(0.0, 3.0)),
            int(rng.integers(0, 2)),
        )
        failed = np.full(2, np.inf)
        kind, used = error_driven_kernels.step(
            errors, failed, in_use, age_s, 0.0, 0.1, math.inf, error_driven_kernels.IDENTIFY_CHEAPEST, costs
        )
        holding = np.flatnonzero(errors < 0.1).tolist()
        lives = {m: error_driven_kernels.residual_life_s(costs, m, age_s, errors[m] / 0.1) for m in holding}
        best = max(lives, key=lambda m, own=lives: own[m], default=-1)
        if in_use in holding:
            assert (kind, used) == (error_driven_kernels.NOTHING, in_use)
        elif best >= 0 and costs[0] < costs[1] * lives[best]:
            assert (kind, used) == (error_driven_kernels.IDENTIFICATION, best)
        else:
            assert (kind, used) == (error_driven_kernels.UPDATE, in_use)
        assert failed.tolist() == [np.inf if m in holding else age_s for m in range(2)]


def test_a_life_in_hindsight_is_that_of_an_error_that_grows_with_the_square_of_the_age() -> None:
    for age_s, error_m, life_s in (
        (1.0, 0.05, 2.0), (0.5, 0.2, 0.5), (1.0, 0.8, 0.5), (0.3, 0.2 * 36.0, 0.05), (0.3, 0.2 * 37.0, 0.05),
        (2.0, 0.0125, 8.0), (2.0, 0.0, 8.0), (0.1, 0.0, 0.1 * math.sqrt(2000.0)),
        (0.1, 9e-5, 0.1 * math.sqrt(2000.0)),
    ):  # fmt: skip
        assert hindsight_kernels.log_life(age_s, error_m, 0.2) == pytest.approx(math.log(life_s))
    assert hindsight_kernels.LAGS_S == (0.3, 0.5, 0.8, 1.0, 1.5, 2.0)
    assert hindsight_kernels.MARGIN == 0.2

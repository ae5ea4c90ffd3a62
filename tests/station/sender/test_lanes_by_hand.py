"""Claims about single decisions of error-driven lanes, on states and samples written by hand.

The bank is CA, CV and CTRA. They are held with 1, 2 and 4 m/s east and neither acceleration nor turn, so
half a second on they stand at 0.5, 1 and 2 m, exactly.
"""

from dataclasses import dataclass
from math import inf, log, nan, sqrt
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.messages.codes_kernels import COLUMNS
from modelcast.models.address_kernels import FIT_TYPES, point_address
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.members import ReadyBank
from modelcast.station.arrays import Fits, LaneRules, Lanes, Sensed, fits, lanes, sensed
from modelcast.station.policy.error_driven_kernels import (
    IDENTIFICATION,
    IDENTIFY_FINAL,
    IDENTIFY_NEVER,
    IDENTIFY_ON_FAILURE,
    KEEP_ALIVE,
    NOTHING,
    START_GUARDED,
    START_HINDSIGHT,
    START_KEEP,
    START_ORDER,
    START_PREDICTED,
    START_RECENT,
    START_SURVIVOR,
    UPDATE,
)
from modelcast.station.sender.fitting_kernels import SenderModels
from modelcast.station.sender.motion_kernels import MOTION, PartOne
from modelcast.station.sender.speaking_kernels import SCRATCH, followed, forget_lane, speak
from modelcast.station.sender.starting_kernels import available, chosen

CA, CV, CTRA = range(3)
PARAMETERS = (slice(0, 3), slice(3, 5), slice(5, 9))
READY = ReadyBank.of(Bank((ConstantAcceleration(), ConstantVelocity(), ConstantTurnRateAcceleration())), 0.1)
NO_PART_ONE = PartOne(np.full((3, MOTION), -1), READY.offsets, np.empty((0, 7)))
RING, FITS = 32, 24
HELD = np.array([1.0, 0.0, 0.0, 2.0, 0.0, 4.0, 0.0, 0.0, 0.0])
"""Parameters of the three, in turn; each goes straight on."""

NOW = 45
"""A sample whose place in each ring is another."""


@dataclass
class Bench:
    """Vehicles, and lanes over them."""

    models: SenderModels
    sensed: Sensed
    fits: Fits
    rules: LaneRules
    lanes: Lanes

    def measure(
        self,
        v: int,
        number: int,
        t_s: float,
        at_m: tuple[float, float] = (0.0, 0.0),
        *,
        velocity: tuple[float, float] = (0.0, 0.0),
        acceleration: float = 0.0,
        stated: tuple[float, float, float] | None = None,
        history: int = 1,
    ) -> None:
        """Write a sample; a message states its own instant and position where none is given."""
        place = number % RING
        for twice in (place, place + RING):
            self.sensed.t_s[v, twice] = t_s
            self.sensed.samples[v, twice] = [*at_m, *velocity, acceleration, *[0.0] * 4]
        own = (t_s, *at_m) if stated is None else stated
        self.sensed.stated_s[v, place] = own[0]
        self.sensed.stated_m[v, place] = own[1:]
        self.sensed.history[v, place] = history

    def believe(self, b: int, number: int, member: int, origin: tuple[float, float, float]) -> None:
        """Let the remotes of a lane hold `HELD` from an origin on."""
        self.lanes.update[b], self.lanes.in_use[b] = number, member
        self.lanes.origin[b], self.lanes.message_s[b] = origin, origin[0]
        self.lanes.held[b], self.lanes.usable[b] = HELD, True

    def speak(self, b: int, number: int) -> int:
        """Let a lane decide."""
        scratch = np.empty(SCRATCH)
        return speak(self.models, self.sensed, self.fits, self.rules, self.lanes, b, number, scratch)

    def chosen(self, b: int, number: int) -> int:
        """Let a lane choose among what is available."""
        scratch = np.empty(SCRATCH)
        return chosen(self.models, self.sensed, self.fits, self.rules, self.lanes, b, number, scratch)


def bench(
    vehicle: list[int],
    *,
    windows: tuple[int, int, int] = (1, 1, 1),
    sizes: tuple[int, int, int] = (30, 10, 20),
    fallback: int = -1,
    guard: int = -1,
    free: int = -1,
    selector: tuple[int, int] = (0, 1),
    dt_s: float = 0.1,
    within_m: float = 0.0,
    **columns: Any,
) -> Bench:
    """Lanes over these vehicles that start in order, never identify and err half a metre at most."""
    count = len(vehicle)
    default: dict[str, Any] = {
        "threshold_m": 0.5,
        "silence_s": inf,
        "start": START_ORDER,
        "identify": IDENTIFY_NEVER,
        "only": -1,
        "speaker": -1,
        "bank": -1,
        "loss": 0.0,
        "budget": 1.0,
        "approach_m": inf,
    }
    rows = {name: np.zeros(count, type(one)) + columns.get(name, one) for name, one in default.items()}
    return Bench(
        SenderModels(
            READY.members._replace(windows=np.array(windows)),
            np.empty((0, COLUMNS)),
            np.array(sizes),
            fallback,
            guard,
            free,
            *selector,
            dt_s,
            NO_PART_ONE,
        ),
        sensed(max(vehicle) + 1, RING),
        fits(max(vehicle) + 1, FITS, members=3, parameters=9),
        LaneRules(
            vehicle=np.array(vehicle),
            costs=np.zeros((count, 1)),
            selector=columns.get("constants", np.zeros((count, 1))),
            guards=columns.get("guards", np.full((count, 2), -1)),
            within_m=within_m,
            expects=np.zeros(count, dtype=np.bool_),
            **rows,
        ),
        lanes(count, members=3, parameters=9),
    )


# What falls due -----------------------------------------------------------------------------------------


def test_a_lane_forgets_all_it_said_and_no_other_lane_does() -> None:
    fresh, state = lanes(3, members=3, parameters=9), lanes(3, members=3, parameters=9)
    told = ("update", "in_use", "message_s", "kind", "usable", "last_usable", "failed_s", "scores")
    columns = [(getattr(state, name), getattr(fresh, name)) for name in told]
    columns += list(zip(state.guarded, fresh.guarded, strict=True))
    for column, _ in columns:
        column[:] = True if column.dtype == np.bool_ else 7
    forget_lane(state, 1)
    for column, new in columns:
        assert np.array_equal(column[1], new[1])
        for other in (0, 2):
            assert not np.any(column[other] == new[other])


@pytest.mark.parametrize(
    ("east_m", "kind"),
    [(1.5, UPDATE), (np.nextafter(1.5, 0.0), NOTHING), (0.5, UPDATE), (np.nextafter(0.5, 1.0), NOTHING)],
)
def test_an_error_that_reaches_the_threshold_calls_for_an_update(east_m: float, kind: int) -> None:
    """CV is in use and stands at 1 m; half a metre either way is too far."""
    made = bench([2, 0])
    made.measure(0, NOW, 8.5, (east_m, 0.0))
    made.believe(1, 40, CV, (8.0, 0.0, 0.0))
    assert made.speak(1, NOW) == kind == made.lanes.kind[1]
    assert made.lanes.update[1] == (NOW if kind == UPDATE else 40)
    assert made.lanes.message_s[1] == (8.5 if kind == UPDATE else 8.0)


@pytest.mark.parametrize("start", [START_ORDER, START_SURVIVOR])
@pytest.mark.parametrize(
    ("said_s", "silence_s", "kind"),
    [
        (8.5, 1e-9, KEEP_ALIVE),
        (8.5, 1.5e-9, NOTHING),
        (8.25, 0.25, KEEP_ALIVE),
        (8.25, 0.26, NOTHING),
        (8.0, 0.26, KEEP_ALIVE),
        (8.0, 3.0, NOTHING),
    ],
)
def test_silence_is_long_enough_a_nanosecond_early(
    start: int, said_s: float, silence_s: float, kind: int
) -> None:
    """It counts from the last message, not from the update that is held."""
    made = bench([0], start=start, silence_s=silence_s)
    made.measure(0, NOW, 8.5, (1.0, 0.0))
    made.believe(0, 40, CV, (8.0, 0.0, 0.0))
    made.lanes.message_s[0] = said_s
    assert made.speak(0, NOW) == kind
    assert made.lanes.update[0] == (NOW if kind == KEEP_ALIVE else 40)
    assert made.lanes.message_s[0] == (8.5 if kind == KEEP_ALIVE else said_s)


@pytest.mark.parametrize("start", [START_ORDER, START_KEEP, START_RECENT])
@pytest.mark.parametrize("identify", [IDENTIFY_ON_FAILURE, IDENTIFY_FINAL])
def test_another_member_that_holds_is_named_by_who_identifies(start: int, identify: int) -> None:
    made = bench([0, 0], start=start, identify=[identify, IDENTIFY_NEVER])
    made.measure(0, NOW, 8.5, (2.0, 0.125))
    for b in (0, 1):
        made.believe(b, 40, CV, (8.0, 0.0, 0.0))
    assert made.speak(0, NOW) == IDENTIFICATION
    assert (made.lanes.update[0], made.lanes.in_use[0], made.lanes.message_s[0]) == (40, CTRA, 8.5)
    assert made.lanes.failed_s[0].tolist() == [0.5, 0.5, inf]
    assert made.speak(1, NOW) == UPDATE


@pytest.mark.parametrize("start", [START_ORDER, START_KEEP, START_SURVIVOR, START_HINDSIGHT, START_RECENT])
@pytest.mark.parametrize("identify", [IDENTIFY_ON_FAILURE, IDENTIFY_NEVER])
def test_when_members_failed_is_kept_for_those_who_ask(start: int, identify: int) -> None:
    """The age is the update's, whatever was said since; what was not fitted has failed at once."""
    made = bench([1], start=start, identify=identify)
    made.measure(1, NOW, 8.5, (-1.0, 7.0))
    made.believe(0, 40, CV, (8.0, -2.0, 7.0))
    made.lanes.usable[0, CTRA] = False
    made.lanes.message_s[0] = 8.25
    made.lanes.origin[0, 1] = -2.0
    assert made.speak(0, NOW) == NOTHING
    asked = identify == IDENTIFY_ON_FAILURE or start == START_SURVIVOR
    assert made.lanes.failed_s[0].tolist() == ([0.5, inf, 0.5] if asked else [inf, inf, inf])
    assert (made.lanes.update[0], made.lanes.in_use[0], made.lanes.message_s[0]) == (40, CV, 8.25)


def test_what_was_not_fitted_does_not_hold() -> None:
    made = bench([0])
    made.measure(0, NOW, 8.5, (1.0, 0.0))
    made.believe(0, 40, CV, (8.0, 0.0, 0.0))
    made.lanes.usable[0, CV] = False
    assert made.speak(0, NOW) == UPDATE


def test_an_update_at_the_very_first_sample_is_held() -> None:
    made = bench([0])
    made.measure(0, 5, 8.5, (1.0, 0.0))
    made.believe(0, 0, CV, (8.0, 0.0, 0.0))
    assert made.speak(0, 5) == NOTHING
    assert made.lanes.update[0] == 0


# What an update holds -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "start", [START_ORDER, START_KEEP, START_SURVIVOR, START_HINDSIGHT, START_GUARDED, START_RECENT]
)
@pytest.mark.parametrize("identify", [IDENTIFY_ON_FAILURE, IDENTIFY_NEVER])
def test_all_members_are_fitted_where_another_may_be_named_or_judged(start: int, identify: int) -> None:
    made = bench([0, 1], start=start, identify=identify)
    made.measure(1, NOW, 8.5, (3.0, -2.0), velocity=(6.0, 8.0), acceleration=0.5, stated=(8.25, 31.0, -22.0))
    made.lanes.failed_s[1] = 0.25
    made.lanes.held[1] = -5.0
    assert made.speak(1, NOW) == UPDATE
    state, every = made.lanes, identify != IDENTIFY_NEVER or start in (START_SURVIVOR, START_RECENT)
    assert (state.update[1], state.in_use[1], state.message_s[1], state.kind[1]) == (NOW, CA, 8.5, UPDATE)
    assert state.origin[1].tolist() == [8.25, 31.0, -22.0]
    assert state.usable[1].tolist() == [True, every, every]
    assert state.failed_s[1].tolist() == [inf, inf, inf]
    fitted = [6.0, 8.0, 0.5, 6.0, 8.0, 6.0, 8.0, 0.5, 0.0]
    assert state.held[1].tolist() == (fitted if every else [*fitted[:3], *[-5.0] * 6])
    assert made.fits.number[1, NOW % FITS].tolist() == [NOW, *[NOW if every else -1] * 2]
    assert state.last_usable[1].tolist() == [start == START_RECENT] * 3
    if start == START_RECENT:
        assert state.last[1].tolist() == fitted
        assert state.last_origin[1].tolist() == [8.25, 31.0, -22.0]
    assert state.update[0] == -1


def test_a_lane_of_one_member_holds_no_other_though_its_vehicle_fitted_them() -> None:
    made = bench([0, 0], only=[-1, CV], start=[START_SURVIVOR, START_SURVIVOR])
    made.measure(0, NOW, 8.5, velocity=(6.0, 8.0))
    assert made.speak(0, NOW) == made.speak(1, NOW) == UPDATE
    assert made.lanes.usable.tolist() == [[True, True, True], [False, True, False]]
    assert made.lanes.in_use.tolist() == [CA, CV]


def test_a_lane_of_one_member_remembers_that_one() -> None:
    made = bench([0], only=CV, start=START_RECENT)
    made.measure(0, NOW, 8.5, velocity=(6.0, 8.0))
    assert made.speak(0, NOW) == UPDATE
    assert made.lanes.last_usable[0].tolist() == [False, True, False]
    assert made.lanes.last[0].tolist() == [0.0, 0.0, 0.0, 6.0, 8.0, 0.0, 0.0, 0.0, 0.0]


def test_a_member_whose_fit_fails_gives_way_to_the_first_that_can_be_fitted() -> None:
    """Without an acceleration CV is left; without a velocity none, and the next sample asks again."""
    made = bench([0], start=START_KEEP)
    for preferred in (CA, CTRA, CV):
        made.measure(0, NOW + preferred, 8.5, velocity=(6.0, 8.0), acceleration=nan)
        made.lanes.in_use[0], made.lanes.update[0] = preferred, -1
        assert made.speak(0, NOW + preferred) == UPDATE
        assert made.lanes.in_use[0] == CV
        assert made.lanes.usable[0].tolist() == [False, True, False]
    made.measure(0, NOW + 3, 8.75, velocity=(nan, nan))
    made.lanes.update[0] = -1
    assert made.speak(0, NOW + 3) == UPDATE
    assert made.lanes.in_use[0] == CA
    assert not made.lanes.usable.any()


def test_without_a_full_window_no_member_is_in_use() -> None:
    made = bench([0], windows=(4, 3, 2))
    made.measure(0, NOW, 8.5, velocity=(6.0, 8.0), history=1)
    assert made.speak(0, NOW) == UPDATE
    assert made.lanes.in_use[0] == -1
    assert made.lanes.update[0] == NOW
    assert not made.lanes.usable.any()


def test_every_number_of_the_scratch_is_overwritten() -> None:
    """One of them more would be memory for nothing."""
    made = bench([0], start=START_HINDSIGHT)
    for number in range(NOW - 20, NOW + 1):
        made.measure(0, number, 0.125 * number, (0.5 * number, 3.0), velocity=(4.0, 0.0), history=30)
    scratch = np.full(SCRATCH, -1.25)
    kind = speak(made.models, made.sensed, made.fits, made.rules, made.lanes, 0, NOW, scratch)
    assert kind == UPDATE
    assert not np.any(scratch == -1.25)


# Guarded lanes ------------------------------------------------------------------------------------------


def guarded(first: int, kinds: tuple[int, int], **given: Any) -> Bench:
    """Four lanes from ``first`` on: CV alone, CTRA alone, the bank (CA first), and the one that speaks.

    What the guards just decided is ``kinds``. All hold what they say from a place of their own; CA and CV of
    the bank's lane hold still at the sample, and a new fit is of 6 m/s.
    """
    count = first + 5
    columns = {name: np.full(count, -1) for name in ("speaker", "bank", "only")}
    columns["speaker"][first + 2], columns["bank"][first + 3] = first + 3, first + 2
    columns["only"][first : first + 2] = CV, CTRA
    guards = np.full((count, 2), -1)
    guards[first + 3] = first, first + 1
    made = bench([1] * count, guard=CV, guards=guards, **columns, **given)
    made.measure(1, NOW, 8.5, (1.0, 0.0), velocity=(6.0, 0.0))
    made.believe(first, 39, CV, (7.75, 9.0, 9.0))
    made.believe(first + 1, 38, CTRA, (7.5, 9.0, 9.0))
    made.believe(first + 2, 41, CV, (8.0, 0.0, 0.0))
    made.lanes.kind[first : first + 2] = kinds
    return made


@pytest.mark.parametrize("first", [0, 5])
@pytest.mark.parametrize(
    ("step", "kinds", "kind", "held"),
    [
        (-1, (NOTHING, UPDATE), NOTHING, (41, CV)),
        (0, (NOTHING, UPDATE), NOTHING, (39, CV)),
        (0, (KEEP_ALIVE, NOTHING), KEEP_ALIVE, (39, CV)),
        (1, (UPDATE, NOTHING), NOTHING, (38, CTRA)),
        (1, (NOTHING, UPDATE), UPDATE, (38, CTRA)),
    ],
)
def test_a_guarded_lane_says_what_the_one_says_that_it_is_with(
    *, first: int, step: int, kinds: tuple[int, int], kind: int, held: tuple[int, int]
) -> None:
    made, b = guarded(first, kinds), first + 3
    made.lanes.guarded.step[b] = step
    made.lanes.message_s[b] = 8.0
    assert made.speak(first + 2, NOW) == NOTHING  # the bank's CV holds, whatever the guards do
    assert made.speak(b, NOW) == kind == made.lanes.kind[b]
    assert (made.lanes.update[b], made.lanes.in_use[b]) == held
    assert made.lanes.message_s[b] == (8.0 if kind == NOTHING else 8.5)
    assert followed(made.rules, made.lanes, b) == (first + 2 if step < 0 else first + step)
    assert followed(made.rules, made.lanes, first + 4) == first + 4


@pytest.mark.parametrize("first", [0, 5])
def test_a_bank_comes_back_with_its_guards_message_though_its_own_still_holds(first: int) -> None:
    made, b = guarded(first, (UPDATE, NOTHING)), first + 3
    made.lanes.guarded.step[b], made.lanes.guarded.lead[b] = 0, 3
    assert made.speak(first + 2, NOW) == UPDATE
    assert made.speak(b, NOW) == UPDATE
    assert (made.lanes.update[b], made.lanes.in_use[b], made.lanes.guarded.step[b]) == (NOW, CA, -1)
    assert made.lanes.held[first + 2, PARAMETERS[CA]][0] == 6.0


@pytest.mark.parametrize("first", [0, 5])
@pytest.mark.parametrize(("lost", "member"), [(2, CA), (3, CTRA)])
def test_a_bank_that_goes_on_losing_carries_its_guards_sub_model(first: int, lost: int, member: int) -> None:
    """Of two that have sent as much the second; the message in hand is the one more that is lost."""
    made, b = guarded(first, (NOTHING, NOTHING)), first + 3
    made.believe(first + 2, 41, CTRA, (8.0, 0.0, 0.0))  # a metre off
    made.lanes.guarded.counts[b] = (7, 7, 7 + lost - 1)
    assert made.speak(first + 2, NOW) == UPDATE
    assert (made.lanes.update[first + 2], made.lanes.in_use[first + 2]) == (NOW, member)
    assert made.lanes.usable[first + 2, member]


def test_a_guard_without_a_full_window_does_not_stand_in() -> None:
    made, b = guarded(0, (NOTHING, NOTHING), windows=(1, 1, 3)), 3
    made.believe(2, 41, CTRA, (8.0, 0.0, 0.0))
    made.lanes.guarded.counts[b] = (7, 7, 12)
    assert made.speak(2, NOW) == UPDATE
    assert made.lanes.in_use[2] == CA


@pytest.mark.parametrize(("history", "member"), [(2, CV), (3, CTRA)])
def test_constant_velocity_stands_in_for_a_guard_without_a_full_window(history: int, member: int) -> None:
    """So a guard alone is what a bank of it alone is, completed by constant velocity."""
    made = guarded(0, (NOTHING, NOTHING), windows=(1, 1, 3))
    made.measure(1, NOW, 8.5, (1.0, 0.0), velocity=(6.0, 0.0), history=history)
    assert made.speak(1, NOW) == UPDATE
    assert made.lanes.in_use[1] == member
    assert made.lanes.usable[1].tolist() == [m == member for m in range(3)]


def test_a_lane_without_a_guard_counts_nothing() -> None:
    made = guarded(0, (UPDATE, UPDATE))
    assert made.speak(4, NOW) == UPDATE
    assert made.lanes.in_use[4] == CA
    assert not made.lanes.guarded.counts.any()


# Which sub-model is chosen ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("history", "fallback", "only", "expected"),
    [
        (0, -1, -1, []),
        (1, -1, -1, [CV]),
        (2, -1, -1, [CV, CTRA]),
        (3, -1, -1, [CV, CTRA]),
        (4, -1, -1, [CA, CV, CTRA]),
        (4, -1, CA, [CA]),
        (4, -1, CV, [CV]),
        (4, -1, CTRA, [CTRA]),
        (3, -1, CA, []),
        (1, CV, -1, [CV]),
        (3, CV, -1, [CV, CTRA]),
        (4, CV, -1, [CA, CTRA]),
        (4, CV, CV, [CV]),
        (4, CA, -1, [CA, CV, CTRA]),
        (4, CTRA, -1, [CA, CV]),
        (2, CTRA, -1, [CV]),
        (4, CTRA, CTRA, [CTRA]),
    ],
)
def test_a_member_is_available_with_a_full_window_where_it_is_wanted(
    history: int, fallback: int, only: int, expected: list[int]
) -> None:
    """One that stands in serves where none before it in the bank does."""
    made = bench([1, 2], windows=(4, 1, 2), fallback=fallback, only=[-1, only])
    made.measure(1, NOW, 8.5, history=9)
    made.measure(2, NOW, 8.5, history=history)
    made.lanes.available[:] = np.array([[True], [history % 2 == 0]])
    available(made.models, made.sensed, made.rules, made.lanes, 1, NOW)
    assert np.flatnonzero(made.lanes.available[1]).tolist() == expected
    assert made.lanes.available[0].all()


JERK, SPEED = 0.5, 9.0
AHEAD = np.array([0.6, 0.8])
OFF = np.array([0.25, -0.5])


def jerked(made: Bench, v: int, dt_s: float, now: int, history: int) -> None:
    """Let a car go straight with a constant jerk; its messages state where it was a little before."""
    for number in range(now - 24, now + 1):
        t = dt_s * number
        along = SPEED * t + JERK * t**3 / 6.0
        speed = SPEED + JERK * t * t / 2.0
        stated = along * AHEAD + OFF
        made.measure(
            v,
            number,
            t,
            (float(along * AHEAD[0]), float(along * AHEAD[1])),
            velocity=(float(speed * AHEAD[0]), float(speed * AHEAD[1])),
            acceleration=JERK * t,
            stated=(t - 0.0625, float(stated[0]), float(stated[1])),
            history=history - (now - number),
        )


def lives(dt_s: float, now: int, backs: list[int], threshold_m: float, failed: tuple[int, ...] = ()) -> Any:
    """Mean logarithms of how long CA and CV would have lasted from samples so far back."""
    sums = np.zeros(2)
    t = dt_s * now
    for back in backs:
        then = t - dt_s * back
        flown = t - then + 0.0625
        went = SPEED * (t - then) + JERK * (t**3 - then**3) / 6.0
        straight = (SPEED + JERK * then * then / 2.0) * flown
        for m, along in ((CA, straight + JERK * then * flown**2 / 2.0), (CV, straight)):
            error_m = float(np.hypot(*((along - went) * AHEAD + OFF)))
            if m == CV or back not in failed:
                sums[m] += log(min(max((t - then) * sqrt(threshold_m / error_m), 0.05), 8.0))
    return sums / len(backs) + [0.2, 0.0]


@pytest.mark.parametrize("start", [START_HINDSIGHT, START_GUARDED])
@pytest.mark.parametrize(
    ("dt_s", "longest", "history", "backs"),
    [
        (0.1, 4, 60, [3, 5, 8, 10, 15, 20]),
        (0.1, 4, 24, [3, 5, 8, 10, 15, 20]),
        (0.1, 4, 23, [3, 5, 8, 10, 15]),
        (0.1, 4, 12, [3, 5, 8]),
        (0.1, 4, 11, [3, 5]),
        (0.1, 4, 7, [3]),
        (0.1, 1, 4, [3]),
        (0.1, 1, 21, [3, 5, 8, 10, 15, 20]),
        (0.25, 2, 60, [1, 2, 3, 4, 6, 8]),
        (0.3, 1, 60, [1, 2, 3, 5, 7]),
        (0.3, 1, 2, [1]),
        (1.0, 1, 60, [1, 2]),
    ],
)
def test_hindsight_asks_how_long_each_would_have_lasted(
    start: int, dt_s: float, longest: int, history: int, backs: list[int]
) -> None:
    """From each lag once, that all available members had a window at; a member that is not, counts for none.

    The first has a margin of a fifth.
    """
    made = bench(
        [0, 1], windows=(longest, 1, 22), dt_s=dt_s, start=[START_ORDER, start], threshold_m=[9.0, 1.5]
    )
    jerked(made, 1, dt_s, NOW, history)
    made.lanes.available[1] = [True, True, False]
    made.lanes.chances[:] = 7.0
    found = made.chosen(1, NOW)
    expected = lives(dt_s, NOW, backs, 1.5)
    assert made.lanes.chances[1, :2] == pytest.approx(expected, rel=1e-9)
    assert np.isnan(made.lanes.chances[1, CTRA])
    assert found == int(np.argmax(expected))
    assert (made.lanes.chances[0] == 7.0).all()
    for back in backs:
        assert made.fits.number[1, (NOW - back) % FITS].tolist() == [NOW - back, NOW - back, -1]
    assert np.count_nonzero(made.fits.number[1, :, CV] >= 0) == len(backs)


def test_hindsight_leaves_out_a_fit_that_failed() -> None:
    made = bench([0], start=START_HINDSIGHT, threshold_m=1.5)
    jerked(made, 0, 0.1, NOW, 60)
    made.sensed.samples[0, [(NOW - 5) % RING, (NOW - 5) % RING + RING], 4] = nan
    made.lanes.available[0] = [True, True, False]
    made.chosen(0, NOW)
    expected = lives(0.1, NOW, [3, 5, 8, 10, 15, 20], 1.5, failed=(5,))
    assert made.lanes.chances[0, :2] == pytest.approx(expected, rel=1e-9)


def test_hindsight_says_nothing_where_no_lag_lies_in_the_past() -> None:
    """The first available member is taken then."""
    made = bench([0], start=START_HINDSIGHT)
    jerked(made, 0, 0.1, NOW, 3)
    made.lanes.available[0] = [False, True, True]
    with np.errstate(invalid="ignore"):
        assert made.chosen(0, NOW) == CV
    assert np.isnan(made.lanes.chances[0]).all()


@pytest.mark.parametrize(
    ("scores", "sizes", "within_m", "can", "expected"),
    [
        ([0.0, 1.0, 1.0], (30, 10, 20), 0.0, [CA, CV, CTRA], CA),
        ([1.0, 0.0, 1.0], (10, 30, 20), 0.0, [CA, CV, CTRA], CV),
        ([1.0, 2.0, 0.5], (10, 30, 40), 0.0, [CA, CV, CTRA], CTRA),
        ([0.0, 0.0, 0.0], (10, 30, 20), 0.0, [CA, CV, CTRA], CA),
        ([0.0, 0.0, 0.0], (30, 10, 20), 0.0, [CA, CV, CTRA], CV),
        ([2.0, 2.0, 2.0], (20, 20, 20), 0.0, [CA, CV, CTRA], CA),
        ([2.0, 2.0, 2.0], (30, 20, 20), 0.0, [CA, CV, CTRA], CV),
        # A resolution of half a metre: a quarter of a square metre makes no difference.
        ([1.0, 0.9, 0.8], (20, 20, 20), 0.5, [CA, CV, CTRA], CTRA),
        ([1.0, 1.25, 1.26], (30, 20, 10), 0.5, [CA, CV, CTRA], CV),
        ([1.0, 1.25, 0.99], (30, 20, 40), 0.5, [CA, CV, CTRA], CA),
        # What cannot be sent, or was never judged, sets no mark.
        ([0.0, 2.0, 1.0], (10, 20, 30), 0.0, [CV, CTRA], CTRA),
        ([-1.0, 2.0, 1.0], (10, 20, 30), 0.0, [CA, CV, CTRA], CTRA),
        ([-1.0, -1.0, -1.0], (30, 20, 10), 0.0, [CV, CTRA], CV),
        ([-1.0, -1.0, -1.0], (30, 20, 10), 0.0, [], -1),
    ],
)
def test_recent_takes_the_smallest_of_those_that_erred_least(
    scores: list[float], sizes: tuple[int, int, int], within_m: float, can: list[int], expected: int
) -> None:
    made = bench([0, 1], start=START_RECENT, sizes=sizes, within_m=within_m)
    made.measure(1, NOW, 8.5)
    made.lanes.scores[1] = scores
    made.lanes.available[1, can] = True
    made.lanes.scores[0] = [0.0, 5.0, 0.0]
    assert made.chosen(1, NOW) == expected
    assert made.lanes.scores[1].tolist() == scores
    assert made.lanes.scores[0].tolist() == [0.0, 5.0, 0.0]


@pytest.mark.parametrize(
    ("scores", "sizes", "can", "expected"),
    [
        # A quarter of the mean square is half the error: no less will do, and more is not asked.
        ([0.26, 1.0, 9.0], (20, 20, 20), [CA, CV, CTRA], CV),
        ([0.25, 1.0, 9.0], (20, 20, 20), [CA, CV, CTRA], CA),
        ([0.25, 1.0, 0.2], (20, 20, 20), [CA, CV, CTRA], CTRA),
        # A larger message is no better reason, and a smaller one none at all.
        ([0.0, 1.0, 0.0], (30, 20, 40), [CA, CV, CTRA], CA),
        ([0.9, 1.0, 9.0], (10, 20, 20), [CA, CV, CTRA], CV),
        # Without the free one, or where it was never judged, the others stand as ever.
        ([0.9, 1.0, 0.8], (20, 20, 20), [CA, CTRA], CTRA),
        ([0.9, -1.0, 0.8], (20, 20, 20), [CA, CV, CTRA], CTRA),
    ],
)
def test_recent_leaves_the_free_one_only_for_half_its_error(
    scores: list[float], sizes: tuple[int, int, int], can: list[int], expected: int
) -> None:
    made = bench([0], start=START_RECENT, sizes=sizes, free=CV)
    made.measure(0, NOW, 8.5)
    made.lanes.scores[0] = scores
    made.lanes.available[0, can] = True
    assert made.chosen(0, NOW) == expected


@pytest.mark.parametrize("number", [NOW, 63, 64])
def test_recent_gives_the_newest_square_a_fifth(number: int) -> None:
    """CA, CV and CTRA stand at 0.5, 1 and 2 m; the car is at 2.5. A score of nothing is a score."""
    made = bench([0, 1], start=START_RECENT)
    made.measure(1, number, 8.5, (2.5, -3.0))
    for before, can in (([-1.0, 0.0, 1.0], [True, True, True]), ([2.0, -1.0, 0.0], [True, True, False])):
        made.lanes.last[1], made.lanes.last_origin[1] = HELD, [8.0, 0.0, -3.0]
        made.lanes.scores[1], made.lanes.last_usable[1] = before, can
        made.lanes.available[1] = True
        made.chosen(1, number)
        squares = [4.0, 2.25, 0.25]
        expected = [
            old if not judged else new if old < 0.0 else 0.8 * old + 0.2 * new
            for old, new, judged in zip(before, squares, can, strict=True)
        ]
        assert made.lanes.scores[1] == pytest.approx(expected, rel=1e-12)


@kernel
def first_and_last(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Say where a window begins and ends, and what else was given."""
    out[0], out[1], out[2] = window[0, 0], window[-1, 0], window.shape[0] + constants[0]


@pytest.mark.parametrize("number", [NOW, 40, 63, 64])
@pytest.mark.parametrize(("history", "length"), [(1, 1), (2, 2), (4, 4), (5, 5), (6, 5), (30, 5)])
def test_a_selector_sees_the_newest_samples_of_this_part_of_the_drive(
    number: int, history: int, length: int
) -> None:
    """Five of them span its lags. Samples lie at their numbers, so the last of the window is the latest."""
    address = point_address(first_and_last, FIT_TYPES)
    constants: FloatArray = np.array([[1000.0], [0.25]])
    made = bench([0, 1], start=START_PREDICTED, selector=(address, 5), constants=constants)
    for before in range(RING):
        made.measure(1, number - before, 8.5, (float(number - before), 0.0), history=history)
    made.lanes.available[1] = True
    assert made.chosen(1, number) == (CV if length > 1 else CA)
    assert made.lanes.chances[1].tolist() == [number - length + 1, number, length + 0.25]

"""Claims about the judgement of one report after another: its words in plain Python, ties included."""

import math
from dataclasses import dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.receiver.plausibility import Finding, Plausibility, PlausibilityState
from modelcast.station.receiver.plausibility_limits import PlausibilityLimits
from modelcast.station.receiver.statements import Statements

LIMITS = PlausibilityLimits(
    0.125,
    max_age_s=2.0,
    max_speed_mps=64.0,
    max_acceleration_mps2=8.0,
    position_tolerance_m=3.0,
    speed_tolerance_mps=0.75,
    window_s=1.0,
    stuck_after_s=2.0,
    stuck_window_s=4.0,
    speed_step_mps=0.25,
)
"""All of them sums of a few powers of two, so that what equals a limit does so exactly."""


@dataclass
class Remote:
    """What is known of one remote: its reports since the window began, and since when its speed is held."""

    window: list[tuple[float, FloatArray, FloatArray]] = field(
        default_factory=list[tuple[float, FloatArray, FloatArray]]
    )
    failed: bool = False
    failed_speed: float = math.nan
    same_since_s: float = math.nan
    speed: float = math.nan

    def judge(self, t_s: float, place: FloatArray, velocity: FloatArray, received_s: float) -> Finding:
        """Return the finding; what is plausible, or a mismatch of a way, counts from now on."""
        speed = math.hypot(*velocity)
        refused = self.refusal(t_s, place, speed, received_s)
        if refused is not Finding.PLAUSIBLE:
            return refused
        first = not self.window
        if first or not abs(speed - self.speed) <= LIMITS.speed_step_mps:
            self.same_since_s, self.speed = t_s, speed
        self.window.append((t_s, place, velocity))
        if first:
            return Finding.PLAUSIBLE
        if any(math.isnan(one) for pair in self.window[-2:] for one in pair[2]):
            self.window, self.failed = self.window[-1:], False
            return Finding.PLAUSIBLE
        return self.compare(t_s, place, speed)

    def refusal(self, t_s: float, place: FloatArray, speed: float, received_s: float) -> Finding:
        """What keeps a report from counting at all."""
        far, before_s = False, -math.inf
        if self.window:
            before_s, before, _ = self.window[-1]
            reach_m = LIMITS.max_speed_mps * (t_s - before_s) + LIMITS.position_tolerance_m
            far = math.hypot(*(place - before)) > reach_m
        reasons = {
            Finding.IN_FUTURE: t_s - received_s > LIMITS.max_ahead_s,
            Finding.STALE: received_s - t_s > LIMITS.max_age_s,
            Finding.REPEATED: t_s == before_s,
            Finding.OVERTAKEN: t_s < before_s,
            Finding.POSITION_JUMP: far,
            Finding.SPEED_MISMATCH: speed > LIMITS.max_speed_mps,
        }
        return next((one for one, holds in reasons.items() if holds), Finding.PLAUSIBLE)

    def compare(self, t_s: float, place: FloatArray, speed: float) -> Finding:
        """Way gone against way stated since the window began; the window ends where it is long enough."""
        steps = list(zip(self.window, self.window[1:], strict=False))
        stated = sum((0.5 * (a[2] + b[2]) * (b[0] - a[0]) for a, b in steps), np.zeros(2))
        unseen_m = sum(0.25 * LIMITS.max_acceleration_mps2 * (b[0] - a[0]) ** 2 for a, b in steps)
        start_s, start, _ = self.window[0]
        lasted_s = t_s - start_s
        allowed_m = LIMITS.position_tolerance_m + LIMITS.speed_tolerance_mps * lasted_s + unseen_m
        fails = abs(math.hypot(*(place - start)) - math.hypot(*stated)) > allowed_m
        finding = Finding.PLAUSIBLE
        if fails or self.failed:
            stuck = t_s - self.same_since_s >= LIMITS.stuck_after_s
            finding = Finding.STUCK_SPEED if stuck else Finding.SPEED_MISMATCH
        same = self.same_since_s <= start_s
        other = self.failed and not abs(speed - self.failed_speed) <= LIMITS.speed_step_mps
        goes_on = same and lasted_s < LIMITS.stuck_window_s and not other
        if lasted_s >= LIMITS.window_s and (fails or not goes_on):
            self.failed, self.failed_speed = fails, speed if fails and same else math.nan
            self.window = self.window[-1:]
        return finding


def told(seed: int, count: int = 120) -> Statements:
    """A remote that goes straight in steps of an eighth of a second, and errs now and then, all on a grid."""
    rng = np.random.default_rng(seed)
    t_s, east, speed, stuck = 64.0, 0.0, 10.0, 0
    rows = list[tuple[float, float, float, float]]()
    for _ in range(count):
        dt_s = float(
            rng.choice([0.125, 0.125, 0.25, 0.5, 1.0, 0.0, -0.125], p=[0.4, 0.2, 0.15, 0.1, 0.09, 0.03, 0.03])
        )
        t_s += dt_s
        speed = float(np.clip(speed + 0.25 * rng.integers(-1, 2), 0.0, 60.0))
        east += speed * dt_s
        stuck = stuck - 1 if stuck else int(rng.integers(10, 50)) * (rng.random() < 0.06)
        stated = rows[-1][2] if stuck and rows else speed
        stated += float(rng.choice([0.0, 0.25, 2.0, math.nan], p=[0.9, 0.06, 0.02, 0.02]))
        off = float(rng.choice([0.0, 3.0, -5.5, 40.0], p=[0.85, 0.08, 0.04, 0.03]))
        if seed % 3 == 0:
            east += 3.0 * dt_s  # it says it is slower than it goes
        delay_s = float(rng.choice([0.0, -0.125, 2.0, 2.125, -0.25], p=[0.92, 0.02, 0.02, 0.02, 0.02]))
        rows.append((t_s, east + off, stated, t_s + delay_s))
    columns = np.array(rows)
    return Statements(
        np.full(count, 7),
        columns[:, 0].copy(),
        position_m=np.stack([columns[:, 1], np.zeros(count)], axis=1),
        velocity_mps=np.stack([columns[:, 2], np.where(np.isnan(columns[:, 2]), np.nan, 0.0)], axis=1),
        received_s=columns[:, 3].copy(),
    )


def test_every_report_is_judged_as_by_hand() -> None:
    counted = dict.fromkeys(Finding, 0)
    for seed in range(40):
        given = told(seed)
        plain = Remote()
        findings, _ = Plausibility(LIMITS).check(PlausibilityState(), given)
        for at, found in enumerate(findings.tolist()):
            expected = plain.judge(
                float(given.t_s[at]),
                given.position_m[at],
                given.velocity_mps[at],
                float(given.received_s[at]),
            )
            assert Finding(found) is expected, (seed, at)
            counted[expected] += 1
    assert min(counted.values()) > 10


def said(
    t_s: list[float], east_m: list[float], speed_mps: list[float], vehicle: int = 7, **late: list[float]
) -> Statements:
    """A remote that goes east."""
    return Statements(
        np.full(len(t_s), vehicle),
        np.array(t_s),
        position_m=np.stack([np.array(east_m), np.zeros(len(t_s))], axis=1),
        velocity_mps=np.stack([np.array(speed_mps), np.zeros(len(t_s))], axis=1),
        received_s=np.array(late.get("received_s", t_s)),
    )


def test_what_equals_a_limit_is_plausible() -> None:
    checks = Plausibility(LIMITS)
    for given, expected in (
        (said([0.0], [0.0], [64.0]), Finding.PLAUSIBLE),
        (said([0.0], [0.0], [64.25]), Finding.SPEED_MISMATCH),
        (said([0.0, 1.0], [0.0, 67.0], [64.0, 64.0]), Finding.PLAUSIBLE),
        (said([0.0, 1.0], [0.0, 67.25], [64.0, 64.0]), Finding.POSITION_JUMP),
        # 3 m, 0.75 m/s over a second, and 8 m/s² a quarter of a second squared.
        (said([0.0, 1.0], [0.0, 15.75], [10.0, 10.0]), Finding.PLAUSIBLE),
        (said([0.0, 1.0], [0.0, 15.875], [10.0, 10.0]), Finding.SPEED_MISMATCH),
        (said([0.125], [0.0], [1.0], received_s=[0.0]), Finding.PLAUSIBLE),
        (said([0.0], [0.0], [1.0], received_s=[2.0]), Finding.PLAUSIBLE),
    ):
        assert Finding(checks.check(PlausibilityState(), given)[0][-1]) is expected


def test_who_is_forgotten_is_judged_as_a_stranger() -> None:
    """After a failure, a jump and a minute of silence, by the earliest arrival of what is checked."""
    checks = Plausibility(LIMITS, memory_s=8.0)
    failing = said([0.0, 1.0], [0.0, 40.0], [10.0, 10.0])
    for wait_s, expected in ((8.0, Finding.STUCK_SPEED), (8.125, Finding.PLAUSIBLE)):
        findings, state = checks.check(PlausibilityState(), failing)
        assert Finding(findings[-1]) is Finding.SPEED_MISMATCH
        back = said([1.0 + wait_s], [40.0 + 10.0 * wait_s], [10.0])
        assert Finding(checks.check(state, back)[0][0]) is expected
    _, state = checks.check(PlausibilityState(), failing)
    together = Statements(
        np.array([8, 7]),
        np.array([9.0, 9.5]),
        position_m=np.array([[0.0, 0.0], [125.0, 0.0]]),
        velocity_mps=np.array([[0.0, 0.0], [10.0, 0.0]]),
        received_s=np.array([9.0, 9.5]),
    )
    assert checks.check(state, together)[0].tolist() == [Finding.PLAUSIBLE, Finding.STUCK_SPEED]


def test_only_who_entered_is_remembered() -> None:
    checks = Plausibility(LIMITS)
    _, state = checks.check(PlausibilityState(), said([0.0], [0.0], [64.5], vehicle=3))
    assert state.vehicle.tolist() == []
    _, state = checks.check(state, said([0.0], [0.0], [1.0], vehicle=5))
    _, state = checks.check(state, said([0.0], [0.0], [64.5], vehicle=3))
    assert state.vehicle.tolist() == [5]
    assert state.rows.shape[0] == 1

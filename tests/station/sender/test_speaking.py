"""Claims about error-driven lanes: on short drives, each rule against its words in plain Python."""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.learned import Selector
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.arrays import Lanes, lanes
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.lane_rules import speaking_lanes
from modelcast.station.sender.speaking_kernels import speak_through
from modelcast.station.sensing.velocity import REPORTED
from modelcast.trips.trajectory import Trajectory, build_trajectory

MARGIN_M = 1e-9
"""Two ways to predict differ by less; where an error lies closer to the threshold, neither is wrong."""

STARTS = ("order", "keep", "survivor", "hindsight", "guarded")
IDENTIFIES = ("on-failure", "final", "best", "never")
CA, CTRA, CV = ConstantAcceleration(), ConstantTurnRateAcceleration(), ConstantVelocity()
GP = GaussianProcess(3, "intercept")
BANK = Bank((GP, CV, CTRA))
"""Windows of three samples and of one."""

SEEDS = (1, 4)


def winding(seed: int) -> Trajectory:
    """Six seconds of a car whose acceleration and yaw rate jump every second; one part is two samples."""
    rng = np.random.default_rng(seed)
    acceleration = np.repeat(rng.uniform(-4.0, 4.0, 7), 10)[:61]
    yaw_rate = np.repeat(rng.uniform(-0.4, 0.4, 7), 10)[:61]
    speed = 15.0 + np.cumsum(acceleration) * 0.1
    heading = np.cumsum(yaw_rate) * 0.1
    steps = 0.1 * speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    t = np.round(0.1 * np.arange(61), 6)
    keep = (t < 2.75) | ((t > 3.35) & (t < 3.55)) | (t > 3.95)
    return build_trajectory(
        f"made/{seed}",
        t[keep],
        np.cumsum(steps, axis=0)[keep] + rng.normal(0.0, 0.01, (61, 2))[keep],
        speed_mps=speed[keep],
        heading_rad=np.mod(heading[keep], 2.0 * np.pi),
        acceleration_mps2=acceleration[keep],
        yaw_rate_radps=yaw_rate[keep],
    )


def events(runtime: TripRuntime, policy: ErrorDriven) -> list[tuple[int, str, int]]:
    sent = runtime.run(policy)
    at = np.flatnonzero(sent.transmits)
    return [(int(i), MessageKind(sent.kind[i]).label, int(sent.in_use[i])) for i in at]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("identify", IDENTIFIES)
@pytest.mark.parametrize("start", STARTS)
def test_lanes_are_algorithm_1_in_plain_words(
    seed: int, start: Any, identify: Any, replica: Callable[..., Any], algorithm_1: Callable[..., Any]
) -> None:
    trip = winding(seed)
    plain, runtime = replica(trip, BANK), TripRuntime(trip, BANK, REPORTED)
    for threshold_m, longest_s in ((0.1, 0.6), (0.3, None)):
        expected, margin_m = algorithm_1(
            plain, threshold_m=threshold_m, start=start, identify=identify, longest_s=longest_s or np.inf
        )
        assert margin_m >= MARGIN_M
        assert events(runtime, ErrorDriven(threshold_m, start, identify, longest_s)) == expected


def test_the_drives_tell_the_rules_apart() -> None:
    """Else the test above would claim little: some of 20 rules are one where all fail at once."""
    told: set[tuple[tuple[int, str, int], ...]] = set()
    for start, identify in product(STARTS, IDENTIFIES):
        policy = ErrorDriven(0.1, start, identify)
        told.add(
            tuple(one for seed in SEEDS for one in events(TripRuntime(winding(seed), BANK, REPORTED), policy))
        )
    assert len(told) >= 12


def jerking(seed: int, hold: int) -> Trajectory:
    """A car whose acceleration turns round every so many samples: what it did last it does not do next.

    After 15 s it does so every 3 s, which a sub-model can tell.
    """
    rng = np.random.default_rng(seed)
    signs = np.concatenate([(-1.0) ** (np.arange(150) // hold), (-1.0) ** (np.arange(150) // 30)])
    acceleration = 3.0 * signs * rng.uniform(0.6, 1.4, 300)
    speed = 15.0 + np.cumsum(acceleration) * 0.1
    along = np.cumsum(speed) * 0.1
    return build_trajectory(
        "made/jerks",
        0.1 * np.arange(300),
        np.stack([along, np.zeros(300)], axis=1),
        speed_mps=speed,
        heading_rad=np.full(300, np.pi / 2),
        acceleration_mps2=acceleration,
        yaw_rate_radps=np.zeros(300),
    )


@pytest.mark.parametrize("members", ["ca cv", "ca ctra cv"])
@pytest.mark.parametrize(
    ("seed", "hold", "threshold_m"),
    [(0, 4, 0.2), (1, 3, 0.2), (3, 5, 0.2), (3, 6, 0.2), (7, 6, 0.3), (7, 8, 0.5)],
)
def test_a_guarded_lane_is_steered_by_its_virtual_senders(
    *,
    seed: int,
    hold: int,
    threshold_m: float,
    members: str,
    replica: Callable[..., Any],
    algorithm_1: Callable[..., Any],
) -> None:
    """On these drives guards serve, change and give way to the bank again."""
    trip = jerking(seed, hold)
    bank = Bank(tuple({"ca": CA, "ctra": CTRA, "cv": CV}[name] for name in members.split()))
    runtime, plain = TripRuntime(trip, bank, REPORTED), replica(trip, bank)
    for identify, longest_s in product(("never", "on-failure"), (None, 0.8)):
        expected, margin_m = algorithm_1(
            plain,
            threshold_m=threshold_m,
            start="guarded",
            identify=identify,
            longest_s=longest_s or np.inf,
        )
        assert margin_m >= MARGIN_M
        assert events(runtime, ErrorDriven(threshold_m, "guarded", identify, longest_s)) == expected
    free = events(runtime, ErrorDriven(threshold_m, "hindsight", "never"))
    assert free != events(runtime, ErrorDriven(threshold_m, "guarded", "never"))  # it acts on these drives


def spoken(
    trip: Trajectory,
    bank: Bank,
    policy: ErrorDriven,
    *,
    within_m: float = 0.0,
    selector: Selector | None = None,
) -> tuple[TripRuntime, list[tuple[int, int]], Lanes]:
    """Updates of a lane, sample and sub-model, and the lane afterwards."""
    runtime = TripRuntime(trip, bank, REPORTED, selector)
    rules = speaking_lanes(
        [policy], [0], guards=(), dt_s=trip.dt_s, selector=selector, within_m=within_m
    ).rules
    members, parameters = len(runtime.bank.members), int(runtime.bank.offsets[-1])
    state = lanes(1, members=members, parameters=parameters)
    kind, in_use, update = (np.empty((1, len(trip)), dtype=np.int64) for _ in range(3))
    speak_through(runtime.own.models(), runtime.sensed, runtime.fits, rules, state, kind, in_use, update)
    at = np.flatnonzero(kind[0] != MessageKind.NOTHING)
    return runtime, [(int(k), int(in_use[0, k])) for k in at], state


def error_m(runtime: TripRuntime, then: int, now: int, member: int) -> float:
    """Of a member fitted at one sample, at a later one, by the model's own batch prediction."""
    offsets = runtime.bank.offsets
    own = runtime.parameters[then : then + 1, offsets[member] : offsets[member + 1]].copy()
    age_s = np.array([runtime.trip.t_s[now] - runtime.stated_s[then]])
    moved = runtime.bank.members[member].predict_at(own, age_s, dt_s=runtime.trip.dt_s)[0]
    return float(np.hypot(*(runtime.stated_m[then] + moved - runtime.samples[now, :2])))


def ready(runtime: TripRuntime, now: int, only_for_want: int = -1) -> list[int]:
    """Members that have a full window at a sample."""
    long = int(now - runtime.trip.segment_start[now]) + 1
    found = [m for m, one in enumerate(runtime.bank.members) if one.window <= long]
    return [m for m in found if m != only_for_want] or found


@pytest.mark.parametrize("within_m", [0.0, 0.03, 0.3, 30.0])
@pytest.mark.parametrize("seed", SEEDS)
def test_recent_takes_the_smallest_message_of_those_that_erred_as_little(seed: int, within_m: float) -> None:
    """Its mean of squares gives the newest a fifth; sub-models are judged at every message from the last."""
    runtime, sent, state = spoken(winding(seed), BANK, ErrorDriven(0.1, "recent", "never"), within_m=within_m)
    sizes, free = runtime.own.sizes, BANK.place_of("ctra")
    scores: dict[int, float] = {}
    expected: list[tuple[int, int]] = []
    last = -1
    for now, _ in sent:
        if last >= 0:
            for m in ready(runtime, last):
                square = error_m(runtime, last, now, m) ** 2
                scores[m] = scores[m] + 0.2 * (square - scores[m]) if m in scores else square
        known = [m for m in ready(runtime, now) if m in scores]
        bound = 0.25 * scores[free] if free in known else np.inf
        fit = [m for m in known if m == free or scores[m] <= bound]
        good = [m for m in fit if scores[m] <= min(scores[one] for one in fit) + within_m**2]
        first = ready(runtime, now)[0]
        expected.append((now, min(good, key=lambda m: (sizes[m], scores[m], m)) if good else first))
        runtime.fit_at([now])
        last = now
    assert sent == expected
    for m, score in scores.items():
        assert state.scores[0, m] == pytest.approx(score)
    if within_m == 30.0:
        smallest = int(np.argmin(sizes))
        assert {m for _, m in sent[2:]} <= {smallest, free}


def test_recent_without_a_resolution_takes_more_than_one_sub_model() -> None:
    assert (
        len(
            {
                m
                for seed in SEEDS
                for _, m in spoken(winding(seed), BANK, ErrorDriven(0.1, "recent", "never"))[1]
            }
        )
        > 1
    )


def test_a_sub_model_that_stands_in_serves_only_for_want_of_another() -> None:
    trip = winding(1)
    for start in ("order", "keep", "survivor", "hindsight", "recent"):
        runtime, sent, _ = spoken(trip, Bank((GP,)), ErrorDriven(0.05, start, "never"))  # pyright: ignore[reportArgumentType]
        assert [one.window for one in runtime.bank.members] == [3, 1]
        assert {m for _, m in sent} == {0, 1}
        for now, m in sent:
            assert [m] == ready(runtime, now, only_for_want=1)


def test_predicted_takes_what_the_selector_says_lasts_once_it_can_say(
    constant_selector: Callable[..., Selector],
) -> None:
    """A second of past needs eleven samples; before, and after a gap, the first that serves is taken."""
    trip = winding(1)
    bank = Bank((CV, CA, CTRA))
    names = tuple(one.name for one in bank.members)
    for best in range(3):
        scores = np.where(np.arange(3) == best, 1.0, 0.0)
        selector = constant_selector(names, scores, 0.1, lags=10)
        _, sent, _ = spoken(trip, bank, ErrorDriven(0.1, "predicted", "never"), selector=selector)
        long = trip.segment_start
        for now, m in sent:
            assert m == (best if now - long[now] + 1 >= 11 else 0)


def costs(lives_s: list[float], identification: float) -> CostTable:
    """Lives of two sub-models at any age and error, updates of cost 10 every second."""
    return CostTable(
        10.0,
        identification,
        thresholds_m=np.array([0.1]),
        update_life_s=np.array([1.0]),
        age_edges_s=np.empty(0),
        share_edges=np.empty(0),
        residual_life_s=np.array(lives_s).reshape(1, len(lives_s), 1, 1),
    )


def test_cheapest_names_what_lasts_where_that_costs_less_than_updates_do() -> None:
    """A second of updates costs 10: to name what holds for half a second pays under 5."""
    trip = winding(4)
    on_failure = events(TripRuntime(trip, BANK, REPORTED), ErrorDriven(0.1, "order", "on-failure"))
    never = events(TripRuntime(trip, BANK, REPORTED), ErrorDriven(0.1, "order", "never"))
    for cost, expected in ((4.9, on_failure), (5.0, never)):
        policy = ErrorDriven(0.1, "order", "cheapest", costs=costs([0.5, 0.5, 0.5], cost))
        found = events(TripRuntime(trip, BANK, REPORTED), policy)
        assert [one[:2] for one in found][:3] == [one[:2] for one in expected][:3]
        assert any(kind == "identification" for _, kind, _ in found) == (cost < 5.0)
    assert found == never

"""Claims about selection: scores in hindsight and from a selector, and the cost-aware rule."""

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.learned import Selector
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.base import MessageKind, TransmitInputs
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.hindsight import LAGS_S, hindsight_scores
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.case import TripCase
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.costs import CostSettings, train_costs
from modelcast.study.training.descent import Descent
from modelcast.study.training.members import MemberSettings, choose_members
from modelcast.study.training.selection import SelectorSettings, member_lives_s, train_selector
from modelcast.trips.trajectory import Trajectory

BANK = Bank((ConstantVelocity(), ConstantTurnRateAcceleration()))
THRESHOLDS_M = (0.2, 0.5)
QUICK = SelectorSettings(
    THRESHOLDS_M, networks=2, every=1, descent=Descent(hidden=(12, 12), steps=150, batch=256)
)


@pytest.fixture(scope="module")
def case(gapped_case: TripCase) -> TripCase:
    return gapped_case


@pytest.fixture(scope="module")
def selector(case: TripCase) -> Selector:
    pytest.importorskip("sklearn")
    return train_selector([case], BANK, QUICK)


@pytest.fixture(scope="module")
def costs(case: TripCase) -> CostTable:
    return train_costs([case], BANK, CostSettings(THRESHOLDS_M))


def ready(case: TripCase, selector: Selector | None = None) -> TripRuntime:
    return TripRuntime(case.seen, BANK, case.estimator, selector)


def decided_stepwise(
    policy: ErrorDriven, sender: Any, scores: Callable[[int], np.ndarray]
) -> tuple[list[int], list[int]]:
    """Messages and sub-models of a policy asked sample by sample; scores are made at every sample."""
    rng = np.random.default_rng(0)
    state = policy.init(1, 2)
    origin = spoken = 0
    kinds, used = [], []
    t_s = sender.trip.t_s
    for now in range(len(t_s)):
        errors = [sender.tracking_error_m(origin, now, m) if now else np.inf for m in range(2)]
        inputs = TransmitInputs(
            t_s[[now]],
            t_s[[now]] - t_s[origin],
            silence_s=t_s[[now]] - t_s[spoken],
            tracking_error_m=np.array([errors]),
            available=np.array([[sender.has_window(now, m) for m in range(2)]]),
            predicted_life=scores(now)[None],
        )
        decisions, state = policy.decide(state, inputs, rng)
        kind = int(decisions.kind[0])
        origin = now if kind in (MessageKind.UPDATE, MessageKind.KEEP_ALIVE) else origin
        spoken = now if kind != MessageKind.NOTHING else spoken
        kinds.append(kind)
        used.append(int(decisions.in_use[0]))
    return kinds, used


def same(walk: TripMessages, stepwise: tuple[list[int], list[int]]) -> bool:
    return walk.kind.tolist() == stepwise[0] and walk.in_use.tolist() == stepwise[1]


def test_deciding_step_by_step_with_scores_in_hindsight_is_the_walk(
    case: TripCase, replica: Callable[..., Any]
) -> None:
    sender = replica(case.seen, BANK)
    policy = ErrorDriven(0.3, "hindsight", "never", 2.0)

    def scores(now: int) -> np.ndarray:
        first = case.seen.segment_start[now]
        backs = list(dict.fromkeys(max(int(x / case.seen.dt_s + 0.5), 1) for x in LAGS_S))
        backs = [back for back in backs if now - back >= first]
        errors = [[sender.tracking_error_m(now - back, now, m) for back in backs] for m in range(2)]
        ages_s = np.array([case.seen.t_s[now] - case.seen.t_s[now - back] for back in backs])
        return hindsight_scores(ages_s, np.array(errors).reshape(2, -1), 0.3)

    walk = ready(case).run(policy)
    assert same(walk, decided_stepwise(policy, sender, scores))
    assert set(walk.in_use[walk.transmits]) == {0, 1}


def test_deciding_step_by_step_with_a_selector_is_the_walk(
    case: TripCase, selector: Selector, replica: Callable[..., Any]
) -> None:
    sender = replica(case.seen, BANK)
    policy = ErrorDriven(0.3, "predicted", "never")
    count = selector.window_at(case.seen.dt_s)

    def scores(now: int) -> np.ndarray:
        first = max(now - count + 1, case.seen.segment_start[now])
        window = sender.samples[None, first : now + 1]
        return selector.scores(Windows(window, dt_s=case.seen.dt_s), 0.3)[0]

    walk = ready(case, selector).run(policy)
    assert same(walk, decided_stepwise(policy, sender, scores))
    assert set(walk.in_use[walk.transmits]) == {0, 1}


def test_deciding_step_by_step_by_costs_is_the_walk_and_the_plain_rule(
    case: TripCase, costs: CostTable, replica: Callable[..., Any]
) -> None:
    policy = ErrorDriven(0.3, "order", "cheapest", costs=costs.priced(60.0, 12.0))
    sender = ready(case)
    walk = sender.run(policy)
    errors_m = sender.tracking_error_m(walk)
    stepwise = decided_stepwise(policy, replica(case.seen, BANK), lambda _: np.full(2, np.nan))
    assert same(walk, stepwise)
    assert walk.identifications > 0
    table = costs.priced(60.0, 12.0)
    for i in np.flatnonzero(walk.transmits)[1:]:
        holding = np.flatnonzero(errors_m[i] < 0.3)
        age_s = case.seen.t_s[i] - case.seen.t_s[walk.update_index[i - 1]]
        pays = any(table.pays(0.3, int(m), age_s=age_s, share=errors_m[i, m] / 0.3) for m in holding)
        assert (walk.kind[i] == MessageKind.IDENTIFICATION) == pays


def test_free_identifications_are_algorithm_1_and_dear_ones_are_never(
    case: TripCase, costs: CostTable
) -> None:
    """With two sub-models there is one to name, so that the smallest error and the longest life agree."""
    for threshold_m in THRESHOLDS_M:
        free = ErrorDriven(threshold_m, "order", "cheapest", costs=costs.priced(1.0, 1e-9))
        dear = ErrorDriven(threshold_m, "order", "cheapest", costs=costs.priced(1.0, 1e9))
        for policy, plain in ((free, "on-failure"), (dear, "never")):
            got, wanted = ready(case).run(policy), ready(case).run(ErrorDriven(threshold_m, "order", plain))
            assert np.array_equal(got.kind, wanted.kind)


def test_lives_are_what_walks_of_one_sub_model_last(case: TripCase) -> None:
    """A sub-model alone updates exactly when the life of its last update is over."""
    lives_s = member_lives_s(ready(case), np.array(THRESHOLDS_M), 30.0)
    walk = TripRuntime(case.seen, BASELINE_BANK, case.estimator).run(ErrorDriven(0.2))
    at = np.flatnonzero(walk.transmits)
    assert np.diff(case.seen.t_s[at]) == pytest.approx(lives_s[at[:-1], 0, 0])
    ended = np.isfinite(lives_s).all(axis=(1, 2))
    assert (lives_s[ended][:, 1] >= lives_s[ended][:, 0]).all()


def test_members_are_chosen_while_they_save_messages(case: TripCase) -> None:
    """A second copy of a sub-model saves nothing."""
    turn = ConstantTurnRateAcceleration()
    found = choose_members([case], (*BANK.members, ConstantAcceleration()), MemberSettings((0.3,), most=3))
    alone = found.steps[0]
    assert found.bank.members[0].name == min(alone, key=lambda name: alone[name])
    assert alone["cv"] == 1.0
    lowest = [min(step.values()) for step in found.steps[: len(found.bank.members)]]
    assert all(after <= 0.995 * before for before, after in pairwise(lowest))
    order = MemberSettings((0.3,), start="order")
    assert choose_members([case], (turn, ConstantVelocity()), order).bank.members == (turn,)
    for settings in ({"most": 0}, {"least_gain": 1.0}, {"start": "predicted"}, {"identify": "cheapest"}):
        with pytest.raises(ValueError, match=r"most|least_gain|chosen"):
            MemberSettings(**settings)
    with pytest.raises(ValueError, match="at least one"):
        choose_members([], BANK.members)


def test_only_the_sub_model_in_use_is_paid_for_where_no_other_is_named() -> None:
    sizes, bank = SizeModel(), Bank((ConstantVelocity(), GaussianProcess()))
    alone = sizes.each_update_bytes(bank, "never").tolist()
    assert alone == [sizes.each_update_bytes(Bank((member,)), "never")[0] for member in bank.members]
    first, second = sizes.each_update_bytes(bank, "on-failure").tolist()
    assert first == second >= max(alone)


def test_hindsight_prefers_what_did_well_and_is_silent_without_a_past() -> None:
    ages_s = np.array([0.5, 1.0])
    good, bad = [0.01, 0.04], [0.2, 0.8]
    assert np.argmax(hindsight_scores(ages_s, np.array([bad, good]), 0.2)) == 1
    assert np.argmax(hindsight_scores(ages_s, np.array([good, bad]), 0.2)) == 0
    level = hindsight_scores(ages_s, np.array([good, good]), 0.2)
    assert level[0] - level[1] == pytest.approx(0.2)
    assert np.isnan(hindsight_scores(np.empty(0), np.empty((2, 0)), 0.2)).all()
    with pytest.raises(ValueError, match="ages_s"):
        hindsight_scores(np.ones(3), np.ones((2, 2)), 0.2)


def test_a_window_too_short_for_the_features_starts_in_order(case: TripCase, selector: Selector) -> None:
    walk = ready(case, selector).run(ErrorDriven(0.2, "predicted", "never"))
    short = np.arange(len(case.seen)) - case.seen.segment_start < selector.window_at(case.seen.dt_s) - 1
    assert (walk.in_use[short & walk.transmits] == 0).all()


def test_the_mirror_image_of_a_drive_is_selected_alike_by_hindsight(drive: Trajectory) -> None:
    mirrored = replace(
        drive,
        position_m=drive.position_m * np.array([-1.0, 1.0]),
        heading_rad=None if drive.heading_rad is None else -drive.heading_rad,
        yaw_rate_radps=None if drive.yaw_rate_radps is None else -drive.yaw_rate_radps,
    )
    policy = ErrorDriven(0.3, "hindsight", "never")
    walks = [TripRuntime(trip, BANK, velocity_estimator_for(trip)).run(policy) for trip in (drive, mirrored)]
    assert np.array_equal(walks[0].in_use, walks[1].in_use)


def test_training_repeats_and_survives_a_text(case: TripCase, selector: Selector, costs: CostTable) -> None:
    again = train_selector([case], BANK, QUICK)
    assert again == selector
    read = Selector.from_plain(json.loads(json.dumps(selector.as_plain())))
    assert read == selector
    table = CostTable.from_plain(json.loads(json.dumps(costs.as_plain())))
    assert table.as_plain() == costs.as_plain()


def test_between_two_thresholds_scores_and_lives_lie_between(
    case: TripCase, selector: Selector, costs: CostTable
) -> None:
    window = Windows(ready(case).samples[None, 100:130], dt_s=case.seen.dt_s)
    low, middle, high = (selector.scores(window, th)[0] for th in (0.2, np.sqrt(0.1), 0.5))
    assert middle == pytest.approx(0.5 * (low + high))
    assert selector.scores(window, 9.0)[0] == pytest.approx(high)
    rates = [costs.packed(th)[1] for th in (0.2, np.sqrt(0.1), 0.5)]
    assert 1.0 / rates[1] == pytest.approx(0.5 * (1.0 / rates[0] + 1.0 / rates[2]))


def test_what_was_trained_for_another_bank_is_refused(
    case: TripCase, selector: Selector, costs: CostTable
) -> None:
    other = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    with pytest.raises(ValueError, match=r"cv\+ctra"):
        TripRuntime(case.seen, other, case.estimator, selector)
    with pytest.raises(ValueError, match="selector"):
        ready(case).run(ErrorDriven(0.2, "predicted"))
    with pytest.raises(ValueError, match="selector"):
        EvaluationSettings(bank=BANK, start="predicted")
    with pytest.raises(ValueError, match="costs"):
        EvaluationSettings(bank=BANK, identify="cheapest")
    with pytest.raises(ValueError, match="2 sub-models"):
        EvaluationSettings(bank=BASELINE_BANK, identify="cheapest", costs=costs)


def test_a_candidate_carries_what_its_rules_need(selector: Selector, costs: CostTable) -> None:
    candidate = FixedCandidate("ours", BANK, "predicted", "cheapest", selector, costs)
    settings = candidate.fitted((), EvaluationSettings())
    policy = settings.policy(0.2, keep_alive=False)
    assert (policy.start, policy.identify, policy.costs) == ("predicted", "cheapest", costs)
    assert settings.selector_in_use is selector
    assert json.loads(json.dumps(settings.as_plain()))["selector"]["networks"] == 2
    plain = FixedCandidate("plain", BANK).fitted((), settings)
    assert plain.selector is None


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"update_cost": 0.0}, "update_cost"),
        ({"identification_cost": np.inf}, "identification_cost"),
        ({"thresholds_m": np.array([0.5, 0.2])}, "thresholds_m"),
        ({"update_life_s": np.array([1.0])}, "update_life_s"),
        ({"age_edges_s": np.array([1.0, 0.5])}, "age_edges_s"),
        ({"share_edges": np.array([0.1])}, "residual_life_s"),
    ],
)
def test_impossible_costs_are_refused_by_name(costs: CostTable, changes: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(costs, **changes)

"""Claims about the error-driven policy, decision by decision."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.station.policy.base import Decisions, MessageKind, TransmitInputs
from modelcast.station.policy.error_driven import ErrorDriven, ErrorDrivenState

TH = 0.5
GOOD, FAIR, BAD = 0.1, 0.3, 0.9

# Any generator will do: the policy draws nothing.
RNG = np.random.default_rng(0)


def decided(
    policy: ErrorDriven,
    errors: list[float],
    *,
    in_use: int = 0,
    failed_s: tuple[float, ...] = (np.inf, np.inf),
    silence_s: float = 0.4,
    available: tuple[bool, ...] = (True, True),
) -> tuple[MessageKind, int, list[float]]:
    """MessageKind, sub-model and first failures after one decision of one vehicle, 0.4 s after its update."""
    inputs = TransmitInputs(
        np.array([7.0]),
        np.array([0.4]),
        silence_s=np.array([silence_s]),
        tracking_error_m=np.array([errors]),
        available=np.array([available]),
    )
    state = ErrorDrivenState(np.array([in_use]), np.array([failed_s]))
    decisions, after = policy.decide(state, inputs, RNG)
    return MessageKind(decisions.kind[0]), int(decisions.in_use[0]), after.first_failure_s[0].tolist()


@pytest.mark.parametrize("identify", ["on-failure", "final", "best", "never"])
def test_an_update_follows_when_every_sub_model_fails(identify: str) -> None:
    kind, in_use, failed_s = decided(ErrorDriven(TH, identify=identify), [BAD, BAD], in_use=1)
    assert (kind, in_use) == (MessageKind.UPDATE, 0)
    assert failed_s == [np.inf, np.inf]


@pytest.mark.parametrize("identify", ["on-failure", "final", "best", "never"])
def test_an_error_equal_to_the_threshold_has_failed(identify: str) -> None:
    policy = ErrorDriven(TH, identify=identify)
    assert decided(policy, [TH, TH])[0] == MessageKind.UPDATE
    assert decided(policy, [np.nextafter(TH, 0.0), TH])[0] == MessageKind.NOTHING


@pytest.mark.parametrize("identify", ["on-failure", "final", "best"])
def test_another_is_named_when_the_one_in_use_fails(identify: str) -> None:
    kind, in_use, failed_s = decided(ErrorDriven(TH, identify=identify), [BAD, FAIR])
    assert (kind, in_use) == (MessageKind.IDENTIFICATION, 1)
    assert failed_s == [0.4, np.inf]


def test_never_fits_anew_when_the_one_in_use_fails() -> None:
    assert decided(ErrorDriven(TH, identify="never"), [BAD, GOOD])[:2] == (MessageKind.UPDATE, 0)
    assert decided(ErrorDriven(TH, identify="never"), [GOOD, BAD])[:2] == (MessageKind.NOTHING, 0)


def test_the_best_of_those_that_hold_is_named() -> None:
    three = {"failed_s": (np.inf,) * 3, "available": (True,) * 3}
    assert decided(ErrorDriven(TH), [BAD, FAIR, GOOD], **three)[:2] == (MessageKind.IDENTIFICATION, 2)


def test_only_best_switches_while_the_one_in_use_holds() -> None:
    for identify, kind in (("on-failure", MessageKind.NOTHING), ("final", MessageKind.NOTHING)):
        assert decided(ErrorDriven(TH, identify=identify), [FAIR, GOOD])[:2] == (kind, 0)
    assert decided(ErrorDriven(TH, identify="best"), [FAIR, GOOD])[:2] == (MessageKind.IDENTIFICATION, 1)


def test_a_failure_is_final_until_the_next_update_only_under_final() -> None:
    """The first sub-model failed once and holds again; the second, in use, fails now."""
    case = {"in_use": 1, "failed_s": (0.2, np.inf)}
    assert decided(ErrorDriven(TH, identify="final"), [GOOD, BAD], **case)[0] == MessageKind.UPDATE
    again = decided(ErrorDriven(TH, identify="on-failure"), [GOOD, BAD], **case)
    assert again[:2] == (MessageKind.IDENTIFICATION, 0)


@pytest.mark.parametrize(
    ("start", "failed_s", "expected"),
    [
        ("order", (0.1, 0.3), 0),
        ("keep", (0.3, 0.1), 1),
        ("survivor", (0.1, 0.3), 1),
        ("survivor", (0.3, 0.1), 0),
    ],
)
def test_the_start_rule_names_the_sub_model_after_an_update(
    start: str, failed_s: tuple[float, float], expected: int
) -> None:
    kind, in_use, _ = decided(ErrorDriven(TH, start), [BAD, BAD], in_use=1, failed_s=failed_s)
    assert (kind, in_use) == (MessageKind.UPDATE, expected)


@pytest.mark.parametrize("start", ["order", "keep", "survivor"])
def test_a_sub_model_without_a_full_window_never_starts(start: str) -> None:
    policy = ErrorDriven(TH, start)
    late = {"in_use": 0, "failed_s": (0.3, 0.1)}
    assert decided(policy, [BAD, BAD], available=(False, True), **late)[1] == 1


def test_silence_up_to_the_limit_calls_for_a_keep_alive() -> None:
    policy = ErrorDriven(TH, max_inter_transmit_time_s=2.0)
    assert decided(policy, [GOOD, GOOD], silence_s=1.9)[0] == MessageKind.NOTHING
    kind, _, failed_s = decided(policy, [GOOD, BAD], silence_s=2.0)
    assert kind == MessageKind.KEEP_ALIVE
    assert failed_s == [np.inf, np.inf]
    assert decided(policy, [BAD, BAD], silence_s=2.0)[0] == MessageKind.UPDATE


def test_the_first_decision_is_an_update() -> None:
    for start in ("order", "keep", "survivor"):
        nothing = {"in_use": -1, "silence_s": np.inf}
        policy = ErrorDriven(TH, start, max_inter_transmit_time_s=2.0)
        assert decided(policy, [np.inf, np.inf], **nothing)[:2] == (MessageKind.UPDATE, 0)


@given(errors=st.lists(st.floats(0.0, 2.0), min_size=1, max_size=40))
def test_a_bank_of_one_never_identifies(errors: list[float]) -> None:
    policy = ErrorDriven(TH, max_inter_transmit_time_s=2.0)
    kinds, _ = driven(policy, np.array(errors)[:, None, None])
    assert not (kinds == MessageKind.IDENTIFICATION).any()


@given(
    seed=st.integers(0, 2**32 - 1),
    start=st.sampled_from(["order", "keep", "survivor"]),
    identify=st.sampled_from(["on-failure", "final", "best", "never"]),
)
def test_a_vehicle_decides_alike_alone_and_in_a_batch(seed: int, start: str, identify: str) -> None:
    errors = np.random.default_rng(seed).uniform(0.0, 1.0, (30, 4, 3))
    policy = ErrorDriven(TH, start, identify, max_inter_transmit_time_s=0.7)
    kinds, used = driven(policy, errors)
    for row in range(4):
        alone = driven(policy, errors[:, row : row + 1])
        assert np.array_equal(kinds[:, row], alone[0][:, 0])
        assert np.array_equal(used[:, row], alone[1][:, 0])


def driven(policy: ErrorDriven, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Messages and sub-models (T, B) of vehicles whose errors (T, B, M) are given, whatever they send."""
    steps, vehicles, members = errors.shape
    state = policy.init(vehicles, members)
    update_s = np.zeros(vehicles)
    message_s = np.full(vehicles, -np.inf)
    kinds, used = [], []
    for step in range(steps):
        now = np.full(vehicles, 0.1 * step)
        inputs = TransmitInputs(
            now,
            now - update_s,
            silence_s=now - message_s,
            tracking_error_m=errors[step] if step else np.full((vehicles, members), np.inf),
            available=np.ones((vehicles, members), dtype=np.bool_),
        )
        decisions, state = policy.decide(state, inputs, RNG)
        update_s = np.where(
            np.isin(decisions.kind, (MessageKind.UPDATE, MessageKind.KEEP_ALIVE)), now, update_s
        )
        message_s = np.where(decisions.kind != MessageKind.NOTHING, now, message_s)
        kinds.append(decisions.kind)
        used.append(decisions.in_use)
    return np.array(kinds), np.array(used)


def test_the_given_state_is_left_alone() -> None:
    policy = ErrorDriven(TH)
    state = policy.init(1, 2)
    inputs = TransmitInputs(
        np.zeros(1),
        np.zeros(1),
        silence_s=np.full(1, np.inf),
        tracking_error_m=np.array([[BAD, GOOD]]),
        available=np.ones((1, 2), dtype=np.bool_),
    )
    decisions, after = policy.decide(state, inputs, RNG)
    assert isinstance(decisions, Decisions)
    assert state.in_use.tolist() == [-1]
    assert np.isinf(state.first_failure_s).all()
    assert after is not state


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"threshold_m": 0.0}, "threshold_m"),
        ({"threshold_m": -1.0}, "threshold_m"),
        ({"threshold_m": np.nan}, "threshold_m"),
        ({"threshold_m": 0.2, "start": "first"}, "start"),
        ({"threshold_m": 0.2, "identify": "sometimes"}, "identify"),
        ({"threshold_m": 0.2, "identify": "cheapest"}, "costs"),
        ({"threshold_m": 0.2, "max_inter_transmit_time_s": 0.0}, "max_inter_transmit_time_s"),
        ({"threshold_m": 0.2, "max_inter_transmit_time_s": np.nan}, "max_inter_transmit_time_s"),
    ],
)
def test_impossible_settings_are_refused_by_name(arguments: dict[str, object], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        ErrorDriven(**arguments)


def test_messages_have_labels_for_traces() -> None:
    assert [kind.label for kind in MessageKind] == ["nothing", "update", "identification", "keep-alive"]

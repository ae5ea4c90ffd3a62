"""Training of a bank's members and their order: greedy forward selection by the messages they cost."""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.evaluation.case import TripCase
from modelcast.evaluation.settings import BASELINE_BANK
from modelcast.evaluation.walk import TripBank
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.policy.error_driven import ErrorDriven
from modelcast.policy.rules import IdentifyRule, StartRule

__all__ = ["ChosenMembers", "MemberSettings", "choose_members"]


@dataclass(frozen=True, slots=True)
class MemberSettings:
    """How members are chosen.

    Parameters
    ----------
    thresholds_m
        Thresholds at which messages are counted [m].
    start, identify
        The rules the bank is to be used with; those that need training of their own cannot be asked for.
    least_gain
        Share of the messages that a further member must save.
    most
        Members at most.

    Raises
    ------
    ValueError
        Where a number is out of its range, or a rule needs training of its own.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    _: KW_ONLY
    start: StartRule = "hindsight"
    identify: IdentifyRule = "never"
    least_gain: float = 0.005
    most: int = 4

    def __post_init__(self) -> None:
        if not self.thresholds_m or self.most < 1:
            raise ValueError("thresholds_m and most must hold at least one")
        if not 0.0 <= self.least_gain < 1.0:
            raise ValueError(f"least_gain must be from 0 to below 1, got {self.least_gain}")
        if self.start == "predicted" or self.identify == "cheapest":
            raise ValueError("members are chosen before 'predicted' and 'cheapest' can be trained")


@dataclass(frozen=True, slots=True)
class ChosenMembers:
    """A bank, and how it came about.

    Parameters
    ----------
    bank
        Members in the order they were chosen.
    steps
        For every round, the messages over the baseline's of the bank with each candidate added, by name.
    """

    bank: Bank
    steps: tuple[dict[str, float], ...]


def choose_members(
    cases: Sequence[TripCase],
    candidates: Sequence[AbstractSubModel],
    settings: MemberSettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> ChosenMembers:
    """Choose members one by one, each the one that saves most messages beside those chosen before.

    The first is the best alone. The order of choice is the bank's order, so the first is the one that starts
    where no rule says otherwise.

    Parameters
    ----------
    cases
        Trips made ready. What was trained on these very trips looks better here than it is.
    candidates
        Sub-models with distinct names.
    settings
        Rules, thresholds and when to stop.
    progress
        Called with banks tried and the most that may be tried.

    Raises
    ------
    ValueError
        Where there is no case or no candidate.
    """
    settings = MemberSettings() if settings is None else settings
    if not cases or not candidates:
        raise ValueError("members are chosen from at least one candidate on at least one trip")
    baseline = _messages(cases, BASELINE_BANK, settings)
    chosen: list[AbstractSubModel] = []
    steps: list[dict[str, float]] = []
    best, tried = np.inf, 0
    most = min(settings.most, len(candidates))
    while len(chosen) < most:
        ratios: dict[str, float] = {}
        left = [one for one in candidates if one not in chosen]
        for one in left:
            ratios[one.name] = _messages(cases, Bank((*chosen, one)), settings) / baseline
            tried += 1
            if progress is not None:
                progress(tried, most * len(candidates))
        steps.append(ratios)
        winner = min(left, key=lambda one: ratios[one.name])
        if ratios[winner.name] > (1.0 - settings.least_gain) * best:
            break
        best = ratios[winner.name]
        chosen.append(winner)
    return ChosenMembers(Bank(tuple(chosen)), tuple(steps))


def _messages(cases: Sequence[TripCase], bank: Bank, settings: MemberSettings) -> float:
    """Messages of a bank, all trips and thresholds together."""
    total = 0
    for case in cases:
        ready = TripBank(case.seen, bank, case.estimator)
        for threshold_m in settings.thresholds_m:
            walk = ready.walk(ErrorDriven(threshold_m, settings.start, settings.identify))
            total += walk.updates + walk.identifications
    return float(total)

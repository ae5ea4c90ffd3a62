"""Training of a bank's members and their order: greedy forward selection by the messages they cost."""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.guard import unguarded
from modelcast.station.policy.rules import IdentifyRule, StartRule
from modelcast.study.case import TripCase

__all__ = ["ChosenMembers", "Fold", "MemberSettings", "choose_members", "choose_names"]


@dataclass(frozen=True, slots=True)
class MemberSettings:
    """How members are chosen.

    Parameters
    ----------
    thresholds_m
        Thresholds at which messages are counted [m].
    start, identify
        The rules the bank is to be used with; those that need training of their own cannot be asked for.
        ``guarded`` chooses as ``hindsight`` does: the guard comes last.
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
    start: StartRule = "guarded"
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
class Fold:
    """Trips, and candidates that may be judged on them.

    Parameters
    ----------
    cases
        Trips made ready.
    candidates
        Sub-models by distinct names; every fold has the same names.
    """

    cases: Sequence[TripCase]
    candidates: Sequence[AbstractSubModel]


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
    names, steps = choose_names([Fold(cases, candidates)], settings, progress=progress)
    named = {one.name: one for one in candidates}
    return ChosenMembers(Bank(tuple(named[name] for name in names)), steps)


def choose_names(
    folds: Sequence[Fold],
    settings: MemberSettings | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[tuple[str, ...], tuple[dict[str, float], ...]]:
    """Choose by name over several folds, each with candidates trained without its trips: (names, steps).

    Parameters
    ----------
    folds
        At least one, with the same names.
    settings, progress
        As in `choose_members`; the steps are those of `ChosenMembers`.

    Raises
    ------
    ValueError
        Where there is no case or no candidate, or the folds' names differ.
    """
    settings = MemberSettings() if settings is None else settings
    if not folds or not any(fold.cases for fold in folds) or not folds[0].candidates:
        raise ValueError("members are chosen from at least one candidate on at least one trip")
    names = [one.name for one in folds[0].candidates]
    shelves = [{one.name: one for one in fold.candidates} for fold in folds]
    if any(set(shelf) != set(names) for shelf in shelves):
        raise ValueError(f"every fold needs the candidates {', '.join(names)}")

    def messages(*wanted: str) -> float:
        return sum(
            _messages(fold.cases, Bank(tuple(shelf[name] for name in wanted)), settings)
            for fold, shelf in zip(folds, shelves, strict=True)
        )

    baseline = sum(_messages(fold.cases, BASELINE_BANK, settings) for fold in folds)
    chosen: list[str] = []
    steps: list[dict[str, float]] = []
    best, tried = np.inf, 0
    most = min(settings.most, len(names))
    while len(chosen) < most:
        ratios: dict[str, float] = {}
        left = [name for name in names if name not in chosen]
        for name in left:
            ratios[name] = messages(*chosen, name) / baseline
            tried += 1
            if progress is not None:
                progress(tried, most * len(names))
        steps.append(ratios)
        winner = min(left, key=lambda name: ratios[name])
        if ratios[winner] > (1.0 - settings.least_gain) * best:
            break
        best = ratios[winner]
        chosen.append(winner)
    return tuple(chosen), tuple(steps)


def _messages(cases: Sequence[TripCase], bank: Bank, settings: MemberSettings) -> float:
    """Messages of a bank, all trips and thresholds together."""
    total = 0
    start = unguarded(settings.start)
    for case in cases:
        ready = TripRuntime(case.seen, bank, case.estimator)
        for threshold_m in settings.thresholds_m:
            walk = ready.run(ErrorDriven(threshold_m, start, settings.identify))
            total += walk.updates + walk.identifications
    return float(total)

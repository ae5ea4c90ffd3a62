"""The rules of error-driven lanes as compiled steps take them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.station.arrays import LaneRules
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.guard import GUARD, unguarded

__all__ = ["SpeakingLanes", "check_rules", "speaking_lanes"]


def check_rules(policy: ErrorDriven, bank: Bank, selector: Selector | None) -> None:
    """Refuse rules without what they need, or with what was trained for another bank.

    Parameters
    ----------
    policy
        The rules.
    bank
        Sub-models they choose among.
    selector
        What the start rule ``predicted`` asks.

    Raises
    ------
    ValueError
        Where the bank lacks the guard's sub-model, the selector or the costs do not fit it, or the policy
        identifies and yet expects losses or has a sub-model that states values of its own in Part I.
    """
    own = tuple(member.name for member in bank.members)
    names = tuple(member.name for member in bank.complete().members)
    if policy.start == "predicted":
        if selector is None:
            raise ValueError("start 'predicted' needs a selector trained for the bank: take another rule")
        selector.check_members(names)
    if policy.start == "guarded" and len(own) > 1 and GUARD not in own:
        raise ValueError(f"start 'guarded' needs {GUARD} in the bank, got {', '.join(own)}: add it")
    if policy.identify == "cheapest" and policy.costs is not None:
        policy.costs.check_members(len(names))
    stating = [member.name for member in bank.members if member.states_own_values]
    if stating and len(own) > 1 and policy.identify != "never":
        raise ValueError(
            f"identify must be never with {', '.join(stating)}, got {policy.identify!r}: who may name a "
            "sub-model later sends the values of all, and Part I holds one sub-model's"
        )
    if policy.expects and len(names) > 1 and policy.identify != "never":
        raise ValueError(
            f"believe 'expected' goes with identify 'never' (a lost identification names nothing), got "
            f"{policy.identify!r}"
        )


@dataclass(frozen=True, slots=True)
class SpeakingLanes:
    """Lanes of some senders.

    Parameters
    ----------
    rules
        Of all L lanes.
    speaks
        The lane whose messages go out, one a sender, (B,).
    """

    rules: LaneRules
    speaks: IntArray


@dataclass(frozen=True, slots=True)
class _Lane:
    """One lane of a sender, before it has a place among all."""

    policy: ErrorDriven
    only: int = -1
    speaker: int = -1
    bank: int = -1
    guards: tuple[int, int] = (-1, -1)


def speaking_lanes(
    policies: Sequence[ErrorDriven],
    vehicles: Sequence[int],
    *,
    guards: Sequence[int],
    dt_s: float,
    selector: Selector | None = None,
    within_m: float = 0.0,
) -> SpeakingLanes:
    """Return the lanes of senders, one policy and vehicle each.

    Parameters
    ----------
    policies, vehicles
        Of each sender, B.
    guards
        Members that guard a guarded sender, constant velocity first; empty where there is nothing to guard.
    dt_s
        Sampling interval [s].
    selector
        What senders that start with the predicted member ask.
    within_m
        Resolution below which recent errors are equal [m].

    Raises
    ------
    ValueError
        Where a sender starts with the predicted member and there is no selector.
    """
    lanes: list[_Lane] = []
    vehicle: list[int] = []
    speaks: list[int] = []
    for policy, own in zip(policies, vehicles, strict=True):
        guarded = policy.start == "guarded"
        if guarded and len(guards) > 0:
            first, bank = len(lanes), len(lanes) + len(guards)
            lanes += [_Lane(policy.alone, only=member) for member in guards]
            lanes.append(_Lane(replace(policy, start=unguarded(policy.start)), speaker=bank + 1))
            lanes.append(_Lane(policy, bank=bank, guards=(first, bank - 1 if len(guards) > 1 else -1)))
        else:
            lanes.append(_Lane(replace(policy, start="order") if guarded else policy))
        vehicle += [own] * (len(lanes) - len(vehicle))
        speaks.append(len(lanes) - 1)
    # Thousands of senders share a policy: what follows from it is worked out once.
    known = {id(lane.policy): lane.policy for lane in lanes}
    row_of = {one: row for row, one in enumerate(known)}
    of = np.array([row_of[id(lane.policy)] for lane in lanes], dtype=np.int64)
    each = list(known.values())
    codes = [policy.codes for policy in each]
    rules = LaneRules(
        vehicle=np.array(vehicle, dtype=np.int64),
        threshold_m=np.array([code[0] for code in codes])[of],
        silence_s=np.array([code[1] for code in codes])[of],
        start=np.array([policy.start_code for policy in each], dtype=np.int64)[of],
        identify=np.array([code[2] for code in codes], dtype=np.int64)[of],
        costs=_rows([code[3] for code in codes])[of],
        selector=_rows([_selecting(policy, selector, dt_s) for policy in each])[of],
        only=np.array([lane.only for lane in lanes], dtype=np.int64),
        speaker=np.array([lane.speaker for lane in lanes], dtype=np.int64),
        bank=np.array([lane.bank for lane in lanes], dtype=np.int64),
        guards=np.array([lane.guards for lane in lanes], dtype=np.int64),
        expects=np.array([policy.expects for policy in each], dtype=np.bool_)[of],
        loss=np.array([policy.believed_loss for policy in each])[of],
        budget=np.array([policy.budget for policy in each])[of],
        approach_m=np.array([policy.approach_m for policy in each], dtype=np.float64)[of],
        legacy_m=np.array([policy.legacy_threshold_m for policy in each], dtype=np.float64)[of],
        within_m=within_m,
    )
    return SpeakingLanes(rules, np.array(speaks, dtype=np.int64))


def _selecting(policy: ErrorDriven, selector: Selector | None, dt_s: float) -> FloatArray:
    """Return the selector's constants at the policy's threshold."""
    if policy.start != "predicted":
        return np.zeros(1)
    if selector is None:
        raise ValueError("start 'predicted' needs a selector: train one for this bank, or start in order")
    return selector.packed(dt_s, policy.threshold_m)


def _rows(vectors: Sequence[FloatArray]) -> FloatArray:
    """Return vectors as rows of one matrix, zeros behind the short ones."""
    found = np.zeros((len(vectors), max(one.size for one in vectors)))
    for row, one in zip(found, vectors, strict=True):
        row[: one.size] = one
    return found

"""Who sends in ``modelcast network``: a policy with the bank and the rules that its user means."""

from collections.abc import Iterable
from itertools import product
from math import inf, isfinite

from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.cli.network_plan import NetworkPlan
from modelcast.core.exceptions import ConfigError
from modelcast.core.kinds import Kind
from modelcast.station.banks import NamedBank
from modelcast.station.sender.in_use import in_use
from modelcast.station.sender.names import sends_models
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.study.network.rows import NO_BANK, SENDERS
from modelcast.study.table import Row
from modelcast.world.sensors import filter_for

__all__ = ["named_banks", "sender_of", "sender_rows"]


def named_banks(plan: NetworkPlan) -> dict[str, NamedBank]:
    """The banks that a plan names, by their names in rows.

    Parameters
    ----------
    plan
        What all runs share.

    Raises
    ------
    ConfigError, DataFormatError
        As for `modelcast.cli.banks.bank_in_use`.
    """
    profile = profile_in_use(plan.profile)
    return {name: bank_in_use(text, profile=profile) for name, text in plan.bank_texts.items()}


def sender_of(
    plan: NetworkPlan,
    policy: str,
    bank: str,
    *,
    threshold_m: float,
    named: NamedBank | None,
    motion: MotionFilter,
    kind: Kind = Kind.VEHICLE,
) -> Sender:
    """The sender of a policy, a bank and a threshold.

    Error-driven senders of models take the bank's own rules where the plan names none. Timers start with
    what the plan says, and never identify.

    Parameters
    ----------
    plan
        What all runs share.
    policy, bank, threshold_m
        As in `modelcast.study.network.rows.NetworkCase`.
    named
        The bank of that name; None for a policy that sends no model. The free policies take the profile's.
    motion
        Filter of those that filter their motion.
    kind
        Of who sends.

    Raises
    ------
    ConfigError
        Where an option is out of its range, or does not go with policy and bank.
    DataFormatError
        Where the profile is none.
    """
    profile = profile_in_use(plan.profile)
    try:
        return named_sender(
            policy,
            **in_use(
                policy,
                named,
                profile=profile,
                kind=kind,
                start=plan.start,
                identify=plan.identify,
                cost=plan.cost,
            ),
            threshold_m=threshold_m if isfinite(threshold_m) else plan.thresholds_m[0],
            keep_alive_s=plan.keep_alive_s,
            believe=plan.believe,
            budget=plan.budget,
            approach_m=plan.approach_m or inf,
            legacy_threshold_m=plan.legacy_threshold_m or inf,
            relaxed_error_m=plan.relaxed_error_m,
            motion=motion,
            stack=plan.stack,
        ).of_kind(kind)
    except ValueError as error:
        what = f"--policy {policy}" + ("" if named is None else f" --bank {bank}")
        raise ConfigError(f"{what}: {error}") from error


def sender_rows(plan: NetworkPlan, policies: Iterable[str]) -> list[Row]:
    """Make every sender that a plan asks for, and say what those of models send.

    Parameters
    ----------
    plan
        What all runs share.
    policies
        Names.

    Raises
    ------
    ConfigError, DataFormatError
        As for `sender_of` and `named_banks`, before anything runs.
    """
    try:
        motion = filter_for(plan.sensor.model())
    except ValueError as error:
        raise ConfigError(str(error)) from error
    banks = named_banks(plan)
    rows: list[Row] = []
    for policy in policies:
        own = banks if sends_models(policy) else {NO_BANK: None}
        for (bank, named), threshold_m in product(own.items(), plan.thresholds_of(policy)):
            sender = sender_of(plan, policy, bank, threshold_m=threshold_m, named=named, motion=motion)
            rules, members = sender.lanes, "+".join(member.name for member in sender.bank.members)
            row = SENDERS.row(
                policy=policy, bank=bank, sub_models=members, start=rules.start, identify=rules.identify
            )
            if named is not None and row not in rows:
                rows.append(row)
    return rows

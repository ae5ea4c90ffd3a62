"""The runs that ``modelcast mixed`` is asked for: checked before the first begins."""

from collections.abc import Sequence
from dataclasses import replace

from modelcast.cli.network_cases import Varied, network_cases
from modelcast.cli.network_plan import NetworkPlan
from modelcast.core.exceptions import ConfigError
from modelcast.study.network.mixed import MixedPolicy
from modelcast.study.network.rows import NO_BANK, NetworkCase

__all__ = ["mixed_cases"]

_FEWEST = 2


def mixed_cases(plan: NetworkPlan, varied: Varied, penetration: Sequence[float]) -> list[NetworkCase]:
    """All runs asked for, one a density, radio, penetration and seed.

    Parameters
    ----------
    plan
        What all runs share; of banks and thresholds it has one.
    varied
        What is varied; its policies send together.
    penetration
        Vehicles that send by the last policy [%].

    Raises
    ------
    ModelcastError
        As for `network_cases`; where policies are fewer than two or come twice, or a share is none.
    """
    policies = tuple(varied.policies)
    if len(policies) < _FEWEST or len(set(policies)) != len(policies):
        raise ConfigError(f"--policy must name two policies or more, each once, got {' '.join(policies)}")
    receivers = [100.0 * ratio for ratio in plan.receivers_ratios]
    for name, shares in (("penetration", penetration), ("receivers", receivers)):
        if not shares or not all(0.0 <= share <= 100.0 for share in shares):
            given = ", ".join(f"{share:g}" for share in shares) or "none"
            raise ConfigError(f"--{name} must be shares from 0 to 100 %, got {given}")
    alone = network_cases(plan, varied)
    banks = [case.bank for case in alone if case.bank != NO_BANK]
    thresholds = [case.threshold_m for case in alone if case.threshold_m == case.threshold_m]
    first = [case for case in alone if case.policy == policies[0]]
    return [
        replace(
            case,
            policy=MixedPolicy(policies, share / 100.0).name,
            bank=banks[0] if banks else NO_BANK,
            **({"threshold_m": thresholds[0]} if thresholds else {}),
        )
        for case in first
        for share in dict.fromkeys(penetration)
    ]

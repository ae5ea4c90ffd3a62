"""The runs that ``modelcast network`` is asked for: checked before the first begins, and told in a line."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import inf, isfinite, nan

from modelcast.channel.propagation import Propagation
from modelcast.channel.radio_words import get_radio
from modelcast.channel.registry import RADIOS
from modelcast.cli.named_words import check_word
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.roadside_plan import RoadsidePlan
from modelcast.core.exceptions import ConfigError
from modelcast.core.named_settings import named_settings
from modelcast.station.sender.names import POLICIES, check_one_word_each, check_sender, sends_models
from modelcast.study.network.mixed import mixed_of
from modelcast.study.network.rows import NO_BANK, NetworkCase

__all__ = ["MOST_MORE_BYTES", "Varied", "network_cases", "rival_of", "told"]

MOST_MORE_BYTES = 1400
"""What a WAVE short message carries at most unless a station is set to more (IEEE 1609.3, WsmMaxLength)."""


@dataclass(frozen=True, slots=True)
class Varied:
    """What is varied, as a user gives it; names that come twice count once.

    Parameters
    ----------
    densities_per_km
        Vehicles a kilometre of road [1/km].
    radios, policies
        Names.
    seeds
        Runs of each combination.
    """

    densities_per_km: Sequence[float]
    radios: Sequence[str]
    policies: Sequence[str]
    seeds: int


def network_cases(plan: NetworkPlan, varied: Varied) -> list[NetworkCase]:
    """All runs asked for, once each: a policy without models not once a bank, a timer not once a threshold.

    Parameters
    ----------
    plan
        What all runs share.
    varied
        What is varied.

    Raises
    ------
    ModelcastError
        Where a name is unknown, two words name one policy, a number is out of its range, or the traffic
        cannot be had.
    """
    _check_names(varied)
    plan.check_traffic()
    if plan.roadside is not None:
        _check_roadside(plan.roadside, varied)
    _ = plan.warns()
    if varied.seeds < 1:
        raise ConfigError(f"--seeds must be at least 1, got {varied.seeds}")
    for value in varied.densities_per_km:
        if not value > 0:
            raise ConfigError(f"--density must be positive, in vehicles a kilometre, got {value:g}")
    if not 0 <= plan.more_bytes <= MOST_MORE_BYTES:
        raise ConfigError(f"--more-bytes must lie within 0..{MOST_MORE_BYTES}, got {plan.more_bytes}")
    if not plan.thresholds_m or not all(0 < value < inf for value in plan.thresholds_m):
        raise ConfigError(f"--threshold must be positive, got {plan.thresholds_m or 'none'}")
    if not 0 <= plan.warm_up_s < plan.duration_s:
        raise ConfigError(f"--warm-up must be below --duration, got {plan.warm_up_s} and {plan.duration_s}")
    if plan.identify not in {None, "never"} and "mbc" not in varied.policies:
        raise ConfigError(f"--identify {plan.identify} goes with --policy mbc: timers fit all anew")
    densities = (nan,) if plan.has_own_density else tuple(dict.fromkeys(varied.densities_per_km))
    banks = tuple(plan.bank_texts)
    return [
        NetworkCase(density, radio, policy, bank, run, threshold_m=threshold_m)
        for density, radio, policy in product(
            densities, dict.fromkeys(varied.radios), dict.fromkeys(varied.policies)
        )
        for bank, threshold_m, run in product(
            banks if sends_models(policy) else (NO_BANK,),
            plan.thresholds_of(policy),
            range(varied.seeds),
        )
    ]


def _check_names(varied: Varied) -> None:
    """Refuse radios and policies that there are not, and two words for one policy."""
    for name, given, group, check in (
        ("radio", varied.radios, RADIOS, get_radio),
        ("policy", varied.policies, POLICIES, check_sender),
    ):
        if not given:
            raise ConfigError(f"--{name} must be of {', '.join(group.names())}, got none")
        for word in given:
            check_word(f"--{name}", check, word)
    try:
        check_one_word_each(varied.policies)
    except ConfigError as error:
        raise ConfigError(f"--policy: {error}") from error


_RESERVING = ("sidelink", "nr")
"""Radios whose stations hold one message until its reserved time."""


def _check_roadside(roadside: RoadsidePlan, varied: Varied) -> None:
    """Refuse units that cannot be had, before anything runs."""
    if any(mixed_of(name).is_mixed for name in varied.policies):
        raise ConfigError("--roadside goes with one sender a fleet: units read messages of one bank")
    holding = next((word for word in varied.radios if named_settings(word)[0] in _RESERVING), None)
    if roadside.relay is not None and holding is not None:
        raise ConfigError(
            f"--relay goes with --radio dsrc, abstract or ideal: a station of --radio {holding} holds one "
            "message at a time and sends it at its reserved time, so a relay there would lose most of what "
            "it repeats"
        )
    try:
        _ = roadside.units()
    except ValueError as error:
        raise ConfigError(f"--roadside: {error}") from error
    if not roadside.height_m > 1.0:
        raise ConfigError(f"--roadside-height must be above 1 m, got {roadside.height_m}")
    raised = roadside.raise_antennas(Propagation())
    for word in varied.radios:
        check_word("--radio", partial(get_radio, propagation=raised), word)


def rival_of(against: str | None, cases: Sequence[NetworkCase]) -> str:
    """The policy that warnings are set against.

    Parameters
    ----------
    against
        As the user names it; None for the first, or in mixed fleets the one with the fewest new senders.
    cases
        All runs.

    Raises
    ------
    ConfigError
        Where no run has that policy.
    """
    policies = list(dict.fromkeys(case.policy for case in cases))
    if against is None:
        return min(policies, key=lambda name: mixed_of(name).senders_ratio)
    if against not in policies:
        raise ConfigError(f"--against {against}: no run has that policy; there are {', '.join(policies)}")
    return against


def told(cases: Sequence[NetworkCase], done: int) -> str:
    """How many runs there are, and of what, in one line.

    Parameters
    ----------
    cases
        All of them.
    done
        How many need not be run again.

    Examples
    --------
    >>> pairs = (("j2945", "none"), ("mbc", "paper"), ("mbc", "default"))
    >>> cases = [NetworkCase(25.0, "dsrc", *pair, run) for pair in pairs for run in range(2)]
    >>> print(told(cases, 1))
    6 runs (1 done before): 1 density, 1 radio, 2 seeds, 3 senders (j2945; mbc with paper, default)
    """
    banks: dict[str, list[str]] = {}
    for policy, bank in dict.fromkeys((case.policy, case.bank) for case in cases):
        banks.setdefault(policy, []).append(bank)
    senders = "; ".join(
        policy + ("" if own == [NO_BANK] else f" with {', '.join(own)}") for policy, own in banks.items()
    )
    thresholds = len({case.threshold_m for case in cases if isfinite(case.threshold_m)})
    counts = [
        (len({repr(case.density_per_km) for case in cases}), "density", "densities"),
        (len({case.radio for case in cases}), "radio", "radios"),
        (len({case.run for case in cases}), "seed", "seeds"),
        (sum(map(len, banks.values())), "sender", "senders"),
    ]
    if thresholds > 1:
        counts.insert(-1, (thresholds, "threshold", "thresholds"))
    parts = ", ".join(f"{count} {one if count == 1 else many}" for count, one, many in counts)
    runs = "1 run" if len(cases) == 1 else f"{len(cases)} runs"
    return runs + (f" ({done} done before)" if done else "") + f": {parts} ({senders})"

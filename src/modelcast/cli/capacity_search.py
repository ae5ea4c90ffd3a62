"""What ``modelcast capacity`` is asked for, checked before anything runs."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, asdict, dataclass
from math import isnan
from typing import Any

from modelcast.cli.network_cases import Varied, network_cases
from modelcast.cli.network_plan import NetworkPlan
from modelcast.core.exceptions import ConfigError
from modelcast.study.network.capacity_limits import Limit, Quantity
from modelcast.study.network.rows import NetworkCase

__all__ = ["CapacitySearch", "limits_of", "margin_of"]

_USUAL_M = (0.5, 1.0)
_USUAL_MARGIN_M = 500.0
_STRAIGHT = ("highway", "braking", "cut-in", "loaded")
_TOWNS = ("grid", "crossing")
_POSITIONS: dict[str, Quantity] = {"absolute": "absolute", "relative": "relative"}


@dataclass(frozen=True, slots=True)
class CapacitySearch:
    """What is sought.

    Parameters
    ----------
    plan
        What all runs share.
    radios, policies, limits
        A bisection each, and for each of the plan's thresholds where the policy has one.
    bounds_per_km, ratio, seeds
        As for `bisected`; runs of each density.
    """

    plan: NetworkPlan
    radios: tuple[str, ...]
    policies: tuple[str, ...]
    limits: tuple[Limit, ...]
    _: KW_ONLY
    bounds_per_km: tuple[float, float]
    ratio: float
    seeds: int

    def as_plain(self) -> dict[str, Any]:
        """As plain values."""
        return {
            **self.plan.as_plain(),
            "banks": list(self.plan.banks),
            "thresholds_m": list(self.plan.thresholds_m),
            "radios": list(self.radios),
            "policies": list(self.policies),
            "limits": [asdict(limit) for limit in self.limits],
            "bounds_per_km": list(self.bounds_per_km),
            "ratio": self.ratio,
            "seeds": self.seeds,
        }

    @property
    def senders(self) -> list[tuple[str, str, float]]:
        """Radio, policy and threshold of each group of bisections that share their runs."""
        return [
            (radio, policy, threshold_m)
            for radio in dict.fromkeys(self.radios)
            for policy in dict.fromkeys(self.policies)
            for threshold_m in self.plan.thresholds_of(policy)
        ]

    def cases(self, density_per_km: float, radio: str, policy: str, threshold_m: float) -> list[NetworkCase]:
        """The runs of one density.

        Parameters
        ----------
        density_per_km, radio, policy, threshold_m
            Which.
        """
        every = network_cases(self.plan, Varied((density_per_km,), (radio,), (policy,), self.seeds))
        return [
            case
            for case in every
            if case.threshold_m == threshold_m or (isnan(case.threshold_m) and isnan(threshold_m))
        ]

    def check(self) -> None:
        """Refuse what cannot be sought.

        Raises
        ------
        ConfigError
            Where an option is out of its range, or a name is unknown.
        """
        low, high = self.bounds_per_km
        if not 0.0 < low < high:
            raise ConfigError(f"--lowest and --highest must be positive and rise, got {low:g} and {high:g}")
        if not self.ratio > 1.0:
            raise ConfigError(f"--ratio must be above 1, got {self.ratio:g}")
        if not self.limits:
            raise ConfigError("--limit or --missed: name at least one, as --limit 0.5")
        _ = network_cases(self.plan, Varied((low,), self.radios, self.policies, self.seeds))


def limits_of(
    errors_m: Sequence[float], positions: Sequence[str], missed: Sequence[float]
) -> tuple[Limit, ...]:
    """Limits as users name them.

    Parameters
    ----------
    errors_m
        Of errors; where there are none, 0.5 m and 1 m unless there are limits on misses [m].
    positions
        Of which places these are: ``absolute``, ``relative``.
    missed
        Shares of warnings missed.

    Raises
    ------
    ConfigError
        Where a position is unknown, or a limit is out of its range.
    """
    unknown = [word for word in positions if word not in _POSITIONS]
    if unknown or not positions:
        raise ConfigError(
            f"--position must be of {', '.join(_POSITIONS)}, got {', '.join(unknown) or 'none'}"
        )
    values = errors_m or (() if missed else _USUAL_M)
    found = [
        _limit("--limit", _POSITIONS[position], value)
        for position in dict.fromkeys(positions)
        for value in values
    ]
    found += [_limit("--missed", "missed", value) for value in missed]
    return tuple(dict.fromkeys(found))


def _limit(option: str, quantity: Quantity, value: float) -> Limit:
    try:
        return Limit(quantity, value)
    except ValueError as error:
        raise ConfigError(f"{option}: {error}") from error


def margin_of(scenario: str, length_m: float, margin_m: float | None) -> float:
    """How near to an end of the road vehicles are not counted as hosts [m].

    Parameters
    ----------
    scenario, length_m
        The traffic; its density can be chosen.
    margin_m
        As users name it; None for the usual.

    Raises
    ------
    ConfigError
        Where the scenario has no such ends, is none whose density can be chosen, or nothing is left to count.
    """
    if scenario not in (*_STRAIGHT, *_TOWNS):
        raise ConfigError(
            f"--scenario must be {', '.join((*_STRAIGHT, *_TOWNS))}, whose density can be chosen, "
            f"got {scenario!r}"
        )
    if scenario in _TOWNS:
        if margin_m:
            raise ConfigError(f"--margin goes with {', '.join(_STRAIGHT)}: a {scenario} has no two ends")
        return 0.0
    found = _USUAL_MARGIN_M if margin_m is None else margin_m
    if not 0.0 <= 2.0 * found < length_m:
        raise ConfigError(
            f"--margin {found:g} at both ends leaves nothing of --length {length_m:g}: take less, or a "
            "longer road"
        )
    return found

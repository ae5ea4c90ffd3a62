"""Mixed fleets in a network evaluation: how a run of one is named, and its rows.

A run's policy reads ``baseline+mbc@25``: 25 % of the vehicles send by the last, the others share the rest
evenly. A third of the vehicles each reads as legacy, free and model receivers do.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.runtime.fleet.engine import NetworkRun
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.mixed import GroupRun, MixedTally, pairing
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.sender import Sender
from modelcast.study.network.measure import binned_quantiles
from modelcast.study.network.rows import CASE_KEYS, HEADLINE_M, PAIRINGS, PENETRATION, CaseResult

__all__ = ["MixedPolicy", "measure_mixed", "mixed_of"]

_QUANTILES = (0.5, 0.9, 0.99)
_THIRDS = (1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)


@dataclass(frozen=True, slots=True)
class MixedPolicy:
    """Who sends in a run.

    Parameters
    ----------
    senders
        Names of policies.
    senders_ratio
        Share of the vehicles that send by the last, 0..1.

    Examples
    --------
    >>> MixedPolicy(("baseline", "free", "mbc"), 0.5).name, MixedPolicy(("cam",)).name
    ('baseline+free+mbc@50', 'cam')
    """

    senders: tuple[str, ...]
    senders_ratio: float = 1.0

    @property
    def is_mixed(self) -> bool:
        """Whether there are several senders."""
        return len(self.senders) > 1

    @property
    def name(self) -> str:
        """The policy as rows name it."""
        share = f"@{100.0 * self.senders_ratio:g}" if self.is_mixed else ""
        return "+".join(self.senders) + share

    def mix(self, senders: Sequence[Sender], free: Bank) -> Mix:
        """The fleet.

        Parameters
        ----------
        senders
            Of the names.
        free
            By which free receivers coast Part I.
        """
        others = (1.0 - self.senders_ratio) / (len(senders) - 1)
        shares = (*(others for _ in senders[1:]), self.senders_ratio)
        return Mix(tuple(senders), shares, readings=_THIRDS, free=free)


def mixed_of(policy: str) -> MixedPolicy:
    """Who sends in a run of that policy.

    Parameters
    ----------
    policy
        As rows name it.

    Examples
    --------
    >>> mixed_of("baseline+mbc@25")
    MixedPolicy(senders=('baseline', 'mbc'), senders_ratio=0.25)
    >>> mixed_of("j2945-mbc").is_mixed
    False
    """
    names, marked, share = policy.partition("@")
    return MixedPolicy(tuple(names.split("+")), float(share) / 100.0 if marked else 1.0)


def measure_mixed(
    result: CaseResult,
    run: NetworkRun,
    mixed: MixedPolicy,
    settings: NetworkSettings,
    receivers_ratios: Sequence[float],
) -> CaseResult:
    """Add the rows of a mixed fleet to those of its run.

    Parameters
    ----------
    result
        Rows of the run.
    run
        What it counted.
    mixed
        Who sent.
    settings
        With what it was run.
    receivers_ratios
        Shares of model receivers, 0..1.
    """
    case = result.run.picked(CASE_KEYS)
    span = slice(*(round(edge_m / settings.distance_bin_m) for edge_m in HEADLINE_M))
    pairings = [
        PAIRINGS.row(
            **case,
            senders_ratio=mixed.senders_ratio,
            sender=group.name,
            reading=reading.name.lower(),
            **_spoken(group),
            **_tracked(run.mixed, pairing(number, reading), span),
        )
        for number, group in enumerate(run.groups)
        for reading in Reading
    ]
    penetration = [
        PENETRATION.row(
            **case,
            senders_ratio=mixed.senders_ratio,
            receivers_ratio=ratio,
            **_errors(_shared(run.mixed, ratio, span)),
        )
        for ratio in receivers_ratios
    ]
    return replace(result, pairings=tuple(pairings), penetration=tuple(penetration))


def _spoken(group: GroupRun) -> dict[str, Any]:
    """What a vehicle of a group sends; NaN where there is none."""
    time_s = group.vehicle_s if group.vehicle_s > 0.0 else np.nan
    sums = group.sent.total
    return {
        "message_rate_hz": float(sums[at.MESSAGES]) / time_s,
        "bytes_per_s": float(sums[at.FRAME_BYTES]) / time_s,
        "airtime_ratio": float(sums[at.AIRTIME_S]) / time_s,
    }


def _tracked(counts: MixedTally, which: int, span: slice) -> dict[str, Any]:
    """How one pairing is tracked."""
    pairs = int(counts.pairs[which, span].sum())
    age = binned_quantiles(counts.age[which, span].sum(axis=0), (0.5, 0.9))
    return {
        "held_ratio": counts.held[which, span].sum() / pairs if pairs else np.nan,
        **_errors(counts.error[which, span].sum(axis=0)),
        "age_p50_s": age[0],
        "age_p90_s": age[1],
        "pairs": pairs,
    }


def _errors(counts: IntArray | FloatArray) -> dict[str, Any]:
    values = binned_quantiles(counts, _QUANTILES)
    return dict(zip(("pte_p50_m", "pte_p90_m", "pte_p99_m"), values, strict=True))


def _shared(counts: MixedTally, ratio: float, span: slice) -> FloatArray:
    """Errors over all pairs where a share of the hosts reads models and the others as legacy receivers do."""
    found = np.zeros(counts.error.shape[2])
    total = float(counts.pairs[:, span].sum())
    for reading, share in ((Reading.LEGACY, 1.0 - ratio), (Reading.MODEL, ratio)):
        pairs = counts.pairs[reading :: len(Reading), span].sum()
        if pairs:
            errors = counts.error[reading :: len(Reading), span].sum(axis=(0, 1))
            found += share * total / pairs * errors
    return found

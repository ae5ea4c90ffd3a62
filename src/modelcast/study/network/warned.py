"""From what hosts of one run warned of to its rows."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from modelcast.study.network.rows import CASE_KEYS, CaseResult
from modelcast.study.network.warning_rows import WARNED_EVENTS, WARNED_HOSTS, WARNINGS
from modelcast.study.safety.fleet_result import PairingScores
from modelcast.study.table import Row

__all__ = ["measure_warnings"]


def measure_warnings(
    result: CaseResult, scores: Sequence[PairingScores], senders: Sequence[str]
) -> CaseResult:
    """Add the rows of warnings to those of a run.

    Parameters
    ----------
    result
        Rows of the run.
    scores
        As `modelcast.study.safety.fleet_score.score_pairings` gives them.
    senders
        Names of the groups.
    """
    case = result.run.picked(CASE_KEYS)
    totals: list[Row] = []
    hosts: list[Row] = []
    events: list[Row] = []
    for one in scores:
        who: dict[str, Any] = {
            **case,
            "application": one.application,
            "sender": senders[one.group],
            "reading": one.reading.name.lower(),
        }
        never = np.isinf(one.delay_s)
        totals.append(
            WARNINGS.row(
                **who,
                host_s=one.host_s,
                counted=one.counted,
                events=one.event_s.size,
                never=int(never.sum()),
                positives=int(one.positives.sum()),
                missed=int(one.missed.sum()),
                negatives=int(one.negatives.sum()),
                false=int(one.false.sum()),
                false_warnings=int(one.false_warnings.sum()),
            )
        )
        columns = (one.host, one.negatives, one.false, one.false_warnings)
        hosts += [
            WARNED_HOSTS.row(**who, host=host, negatives=negatives, false=false, false_warnings=warnings)
            for host, negatives, false, warnings in zip(*(part.tolist() for part in columns), strict=True)
        ]
        late_s = np.where(never, np.nan, one.delay_s)
        fields = ("host", "remote", "t_s", "positives", "missed", "delay_s")
        parts = (one.event_host, one.event_remote, one.event_s, one.positives, one.missed, late_s)
        events += [
            WARNED_EVENTS.row(**who, **dict(zip(fields, values, strict=True)))
            for values in zip(*(part.tolist() for part in parts), strict=True)
        ]
    return replace(result, warnings=tuple(totals), warned_hosts=tuple(hosts), warned_events=tuple(events))

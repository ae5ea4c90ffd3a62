"""Hosts of a fleet scored pair by pair: true warnings as events, and what became of each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.station.receiver.reading import Reading
from modelcast.study.safety.events import delays_s, false_warnings, true_warnings
from modelcast.study.safety.fleet import Assessed, SafetyObserver
from modelcast.study.safety.fleet_result import PairingScores
from modelcast.study.safety.fleet_settings import FleetSafetySettings

__all__ = ["score_pairings"]

_SLACK_S = 1e-6


def score_pairings(observer: SafetyObserver, groups: int) -> list[PairingScores]:
    """Scores of every application by who speaks and who reads how; readings without hosts are left out.

    Instants within `FleetSafetySettings.merge_s` of the beginning and ``grace_s`` of the end do not count:
    what came before is not known, and what may still come neither.

    Parameters
    ----------
    observer
        After the run.
    groups
        Number of senders.
    """
    found: list[PairingScores] = []
    for name in observer.settings.applications:
        rows = observer.assessed(name)
        for number in range(groups * len(Reading)):
            group, reading = divmod(number, len(Reading))
            host_s = float(observer.host_s[reading])
            if host_s > 0.0:
                pairs = [_scored(pair, observer.settings, observer.end_s) for pair in _pairs(rows, number)]
                found.append(_joined(name, group, Reading(reading), host_s, pairs))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Scores of one pair: `PairingScores.counted` to ``false_warnings``, and its events.

    ``events`` (4, E): host, remote, instants that count, and those missed.
    """

    counts: tuple[int, int, int, int]
    events: IntArray
    begins_s: FloatArray
    delay_s: FloatArray


def _pairs(rows: Assessed, number: int) -> Iterator[Assessed]:
    """Rows of one pairing, pair by pair, each by rising time."""
    at = np.flatnonzero(rows.pairing == number)
    at = at[np.lexsort((rows.t_s[at], rows.remote[at], rows.host[at]))]
    host, remote = rows.host[at], rows.remote[at]
    ends = np.flatnonzero((np.diff(host) != 0) | (np.diff(remote) != 0)) + 1
    for own in np.split(at, ends):
        if own.size:
            yield rows.taken(own)


def _scored(pair: Assessed, settings: FleetSafetySettings, end_s: float) -> _Pair:
    t_s, truly, warned = pair.t_s, pair.truly, pair.warned
    begins_s, stops_s = settings.warm_up_s + settings.merge_s, end_s - settings.grace_s
    inside: BoolArray = (t_s >= begins_s - _SLACK_S) & (t_s <= stops_s + _SLACK_S)
    near: BoolArray = inside & (np.abs(pair.margin_m) < settings.near_m)
    true = true_warnings(truly, near, t_s, merge_s=settings.merge_s)
    events = true.first.size

    false = false_warnings(warned[None], truly, inside, t_s, merge_s=settings.merge_s)
    return _Pair(
        (
            int(near.sum()), int((near & ~truly).sum()), int((near & ~truly & warned).sum()), int(false[0]),
        ),
        np.stack(
            [
                np.repeat(pair.host[:1], events),
                np.repeat(pair.remote[:1], events),
                true.instants(near & truly),
                true.instants(near & truly & ~warned),
            ]
        ),
        t_s[true.first],
        delays_s(true, warned[None], t_s, grace_s=settings.grace_s)[:, 0],
    )  # fmt: skip


def _joined(
    application: str, group: int, reading: Reading, host_s: float, pairs: Sequence[_Pair]
) -> PairingScores:
    counts = [sum(one.counts[at] for one in pairs) for at in range(4)]
    nothing = np.zeros((4, 0), dtype=np.int64)
    host, remote, positives, missed = np.concatenate([nothing, *(one.events for one in pairs)], axis=1)
    begins_s = np.concatenate([np.zeros(0), *(one.begins_s for one in pairs)])
    # By time, then by who: the order in which they happened.
    order = np.lexsort((remote, host, begins_s))
    return PairingScores(
        application,
        group,
        reading,
        host_s=host_s,
        counted=counts[0],
        negatives=counts[1],
        false=counts[2],
        false_warnings=counts[3],
        event_host=host[order],
        event_remote=remote[order],
        event_s=begins_s[order],
        positives=positives[order],
        missed=missed[order],
        delay_s=np.concatenate([np.zeros(0), *(one.delay_s for one in pairs)])[order],
    )

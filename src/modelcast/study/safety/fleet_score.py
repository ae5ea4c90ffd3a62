"""Hosts of a fleet scored pair by pair: true warnings as events, and what became of each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

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
    """Scores of every application by who speaks and how hosts read it.

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
        for group, reading in product(range(groups), observer.settings.readings):
            number = len(Reading) * group + reading
            pairs = [_scored(pair, observer.settings, observer.end_s) for pair in _pairs(rows, number)]
            found.append(_joined(name, group, reading, observer.host_s, pairs))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Scores of one pair: host, and `PairingScores.counted` to ``false_warnings``; and its events.

    ``events`` (4, E): host, remote, instants that count, and those missed.
    """

    host: int
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
        int(pair.host[0]),
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
    counts: IntArray = np.array([one.counts for one in pairs], dtype=np.int64).reshape(-1, 4)
    counts, of = counts[counts.any(axis=1)], [one.host for one in pairs if any(one.counts)]
    host, place = np.unique(np.array(of, dtype=np.int64), return_inverse=True)
    by_host = np.zeros((host.size, 4), dtype=np.int64)
    np.add.at(by_host, place, counts)
    nothing = np.zeros((4, 0), dtype=np.int64)
    by, remote, positives, missed = np.concatenate([nothing, *(one.events for one in pairs)], axis=1)
    begins_s = np.concatenate([np.zeros(0), *(one.begins_s for one in pairs)])
    # By time, then by who: the order in which they happened.
    order = np.lexsort((remote, by, begins_s))
    return PairingScores(
        application,
        group,
        reading,
        host_s=host_s,
        counted=int(by_host[:, 0].sum()),
        host=host,
        negatives=by_host[:, 1],
        false=by_host[:, 2],
        false_warnings=by_host[:, 3],
        event_host=by[order],
        event_remote=remote[order],
        event_s=begins_s[order],
        positives=positives[order],
        missed=missed[order],
        delay_s=np.concatenate([np.zeros(0), *(one.delay_s for one in pairs)])[order],
    )

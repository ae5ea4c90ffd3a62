"""Warnings of hosts of a fleet pooled over seeds: shares with intervals, delays, and ratios to a rival.

The same traffic meets every policy, radio and reading of a seed, so the true warnings are the same, and
ratios are between the same warnings. Resamples draw warnings (hosts, where false ones are counted), and runs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.station.receiver.reading import Reading
from modelcast.study.compare.bootstrap import Limits, limits, resample_weights
from modelcast.study.network.rows import SETTING_KEYS, CaseResult
from modelcast.study.network.warning_rows import ALL_SENDERS, POOLED_WARNINGS
from modelcast.study.safety.table import delay_quantiles, share_of
from modelcast.study.table import Row

__all__ = ["pool_warnings"]

_HOUR_S = 3600.0
_RESAMPLES = 2000
_TIME_UNIT_S = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class _Units:
    """What is pooled: E true warnings and H hosts.

    Parameters
    ----------
    event
        Run, host, remote and time in milliseconds, in order, (E, 4).
    positives, missed, delay_s
        Of each, (E,); a delay is infinite where no warning came.
    host
        Run and identifier, in order, (H, 2).
    negatives, false
        Of each, (H,).
    false_warnings, host_s
        Sums.
    """

    event: IntArray
    positives: FloatArray
    missed: FloatArray
    delay_s: FloatArray
    _: KW_ONLY
    host: IntArray
    negatives: FloatArray
    false: FloatArray
    false_warnings: int
    host_s: float


def pool_warnings(results: Sequence[CaseResult], against: str = "", *, seed: int = 0) -> list[Row]:
    """Rows over the seeds, by case, application, sender and reading.

    Of a mixed fleet there is a row over all senders beside each one's own.

    Parameters
    ----------
    results
        Of single runs, in order.
    against
        Policy that ratios are taken to, among the runs of the same density and radio: with the same threshold
        where there is one, else its first; in mixed fleets what legacy receivers there warn of. Without it
        there are none.
    seed
        Of the bootstrap.
    """
    groups: dict[tuple[str, ...], list[CaseResult]] = {}
    for one in results:
        if one.warnings:
            groups.setdefault(tuple(repr(getattr(one.run, name)) for name in SETTING_KEYS), []).append(one)
    units: dict[tuple[tuple[str, ...], str, str, str], _Units] = {}
    for key, own in groups.items():
        for application, sender, reading in _asked(own[0]):
            units[key, application, sender, reading] = _units(own, application, sender, reading)
    found: list[Row] = []
    for (key, application, sender, reading), one in units.items():
        whole = ALL_SENDERS if _is_mixed(groups[key][0]) else sender
        rival = _rival(key, application, groups, units, against) if sender == whole else None
        found.append(_pooled(groups[key], (application, sender, reading), one, rival, seed))
    return found


def _is_mixed(result: CaseResult) -> bool:
    return len({row.sender for row in result.warnings}) > 1


def _asked(result: CaseResult) -> list[tuple[str, str, str]]:
    """Applications, senders and readings of a run; all senders first, where there are several."""
    found = [(row.application, row.sender, row.reading) for row in result.warnings]
    whole = [(name, ALL_SENDERS, reading) for name, _, reading in found] if _is_mixed(result) else []
    return list(dict.fromkeys([*whole, *found]))


def _units(own: Sequence[CaseResult], application: str, sender: str, reading: str) -> _Units:
    """The warnings and hosts of one row."""

    def is_asked(row: Any) -> bool:
        return (row.application, row.reading) == (application, reading) and sender in {
            ALL_SENDERS,
            row.sender,
        }

    events = [row for one in own for row in one.warned_events if is_asked(row)]
    keys = [(row.run, row.host, row.remote, round(row.t_s / _TIME_UNIT_S)) for row in events]
    order = sorted(range(len(events)), key=keys.__getitem__)
    late_s = np.array([events[at].delay_s for at in order], dtype=np.float64)
    hosts: dict[tuple[int, int], IntArray] = {}
    false_warnings = 0
    for row in (row for one in own for row in one.warned_hosts if is_asked(row)):
        counts: IntArray = np.array([row.negatives, row.false], dtype=np.int64)
        hosts[row.run, row.host] = hosts.get((row.run, row.host), 0) + counts
        false_warnings += row.false_warnings
    there = sorted(hosts)
    by_host: IntArray = np.array([hosts[key] for key in there], dtype=np.int64).reshape(-1, 2)
    totals = [next(row for row in one.warnings if is_asked(row)) for one in own]
    return _Units(
        np.array([keys[at] for at in order], dtype=np.int64).reshape(-1, 4),
        np.array([events[at].positives for at in order], dtype=np.float64),
        np.array([events[at].missed for at in order], dtype=np.float64),
        np.where(np.isnan(late_s), np.inf, late_s),
        host=np.array(there, dtype=np.int64).reshape(-1, 2),
        negatives=by_host[:, 0].astype(np.float64),
        false=by_host[:, 1].astype(np.float64),
        false_warnings=false_warnings,
        host_s=sum(row.host_s for row in totals),
    )


def _rival(
    key: tuple[str, ...],
    application: str,
    groups: Mapping[tuple[str, ...], Sequence[CaseResult]],
    units: Mapping[tuple[tuple[str, ...], str, str, str], _Units],
    against: str,
) -> _Units | None:
    """What a row is held against; None where there is no such run."""
    density, radio, _, _, threshold = key
    near = [other for other in groups if other[:3] == (density, radio, repr(against))]
    if not near:
        return None
    chosen = next((other for other in near if other[-1] == threshold), near[0])
    asked = [(sender, reading) for name, sender, reading in _asked(groups[chosen][0]) if name == application]
    legacy = Reading.LEGACY.name.lower()
    sender, reading = next((one for one in asked if one[1] == legacy), asked[0])
    return units[chosen, application, sender, reading]


def _pooled(
    own: Sequence[CaseResult], who: tuple[str, str, str], one: _Units, rival: _Units | None, seed: int
) -> Row:
    runs = np.array([result.run.run for result in own], dtype=np.int64)
    rng = child_generator(seed, "warnings", who[0])
    of_runs = resample_weights(np.arange(runs.size, dtype=np.int64), _RESAMPLES, rng)

    def drawn(run: IntArray) -> FloatArray:
        """Weights of units of these runs, (R, N)."""
        each = np.arange(run.size, dtype=np.int64)
        weights = resample_weights(each, _RESAMPLES, rng) if run.size else np.zeros((_RESAMPLES, 0))
        return weights * of_runs[:, np.searchsorted(runs, run)]

    missed, missed_limits = _ratio(drawn(one.event[:, 0]), one.missed, one.positives)
    false, false_limits = _ratio(drawn(one.host[:, 0]), one.false, one.negatives)
    missed_over, missed_over_limits = _NONE
    false_over, false_over_limits = _NONE
    if rival is not None and np.array_equal(rival.event, one.event):
        missed_over, missed_over_limits = _ratio(drawn(one.event[:, 0]), one.missed, rival.missed)
        both = np.unique(np.concatenate([one.host, rival.host]), axis=0)
        counts = [_spread(part.host, part.false, both) for part in (one, rival)]
        false_over, false_over_limits = _ratio(drawn(both[:, 0]), *counts)
    p50_s, p90_s, p99_s = delay_quantiles(one.delay_s)
    return POOLED_WARNINGS.row(
        **own[0].run.picked(SETTING_KEYS),
        application=who[0],
        sender=who[1],
        reading=who[2],
        seeds=runs.size,
        message_rate_hz=float(np.mean([result.run.message_rate_hz for result in own])),
        busy_ratio=float(np.mean([result.run.busy_ratio for result in own])),
        events=one.missed.size,
        positives=int(one.positives.sum()),
        negatives=int(one.negatives.sum()),
        missed_ratio=missed,
        missed_low=missed_limits[0],
        missed_high=missed_limits[1],
        false_ratio=false,
        false_low=false_limits[0],
        false_high=false_limits[1],
        false_per_hour=share_of(one.false_warnings * _HOUR_S, one.host_s),
        never_ratio=share_of(float(np.isinf(one.delay_s).sum()), one.delay_s.size),
        delay_p50_s=p50_s,
        delay_p90_s=p90_s,
        delay_p99_s=p99_s,
        missed_over=missed_over,
        missed_over_low=missed_over_limits[0],
        missed_over_high=missed_over_limits[1],
        false_over=false_over,
        false_over_low=false_over_limits[0],
        false_over_high=false_over_limits[1],
    )


_NONE: tuple[float, Limits] = (float("nan"), (None, None))


def _ratio(weights: FloatArray, part: FloatArray, whole: FloatArray) -> tuple[float, Limits]:
    """Ratio of sums, and its interval over the units; none where a resample has none of the whole."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = (weights @ part) / (weights @ whole)
        ends = limits(ratios, np.arange(part.size, dtype=np.int64))
        return float(np.float64(part.sum()) / np.float64(whole.sum())), ends


def _spread(own: IntArray, values: FloatArray, every: IntArray) -> FloatArray:
    """Values of some hosts over all of them, 0 elsewhere."""
    place = {tuple(key): at for at, key in enumerate(every.tolist())}
    found = np.zeros(every.shape[0])
    for key, value in zip(own.tolist(), values.tolist(), strict=True):
        found[place[tuple(key)]] = value
    return found

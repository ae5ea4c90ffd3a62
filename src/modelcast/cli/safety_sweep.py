"""Recordings scored for ``modelcast safety``: those missing now, those of an interrupted call as they are."""

import hashlib
import importlib.resources
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from modelcast.channel.recorded import RecordedLosses
from modelcast.cli.safety_options import SafetyOptions
from modelcast.cli.shared_work import workers_of
from modelcast.corpora.executors.base import AbstractExecutor
from modelcast.io.loss_logs import LossLog
from modelcast.io.run_store import RunStore
from modelcast.io.safety_runs import SafetyCase
from modelcast.study.safety.pairs import Recording
from modelcast.study.safety.result import RecordingScores, SafetyResult
from modelcast.study.safety.run import pool_scores, telling_film
from modelcast.study.safety.score import Walked, score_recording
from modelcast.trips.fingerprint import fingerprint

__all__ = ["SafetyWork", "gathered", "run_options", "safety_work", "score_all"]

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class SafetyWork:
    """One recording to be scored with one sensor: a case each kind of loss.

    Parameters
    ----------
    cases
        Each with the losses to be replayed, None where they are drawn.
    recording
        The recording.
    """

    cases: tuple[tuple[SafetyCase, RecordedLosses | None], ...]
    recording: Recording


def safety_work(
    recordings: Sequence[Recording], options: SafetyOptions, logs: Sequence[LossLog]
) -> list[SafetyWork]:
    """Every recording with every sensor, in the order of the options.

    Parameters
    ----------
    recordings
        What was read.
    options
        Sensors and lengths of bursts.
    logs
        Losses to be replayed.
    """
    bursts = [burst_s or None for burst_s in dict.fromkeys(options.burst)] if options.ratios else []
    found: list[SafetyWork] = []
    for recording in recordings:
        trips = tuple(fingerprint(trip) for trip in recording.trips)
        for sensor in dict.fromkeys(options.sensors):
            drawn = [(SafetyCase(recording.name, sensor, burst_s, trips), None) for burst_s in bursts]
            replayed = [
                (
                    SafetyCase(recording.name, sensor, log.channel.mean_burst_s, trips, log.name, log.sha256),
                    log.channel,
                )
                for log in logs
            ]
            found.append(SafetyWork((*drawn, *replayed), recording))
    return found


def run_options(options: SafetyOptions) -> dict[str, Any]:
    """What the scores of a recording depend on beside its trips, as plain values; files by their hashes.

    Parameters
    ----------
    options
        As the user gave them; sensors, kinds of loss and what only pools scores are left out.

    Raises
    ------
    ConfigError
        Where a file cannot be read.
    """
    from modelcast.io.regular import sha256_of

    found = dict(options.as_plain())
    for name in ("sensors", "burst", "losses", "against", "resamples"):
        del found[name]
    shipped = importlib.resources.files("modelcast") / "profiles" / "default.json"
    found["files"] = {
        "shipped": hashlib.sha256(shipped.read_bytes()).hexdigest(),
        **{path.name: sha256_of(path) for path in options.files},
        **options.foreign,
    }
    return found


def _score(options: SafetyOptions, work: SafetyWork) -> list[RecordingScores]:
    """Scores of one piece of work, in whatever process; what senders send is found once for all losses."""
    candidates, walked = options.candidates(), dict[int, Walked]()
    return [
        score_recording(
            work.recording, candidates, options.settings(case.sensor, case.mean_burst_s or 0.0, recorded),
            sensor=case.sensor, loss_log=case.loss_log, walked=walked,
        )
        for case, recorded in work.cases
    ]  # fmt: skip


def score_all(
    work: Sequence[SafetyWork],
    options: SafetyOptions,
    store: RunStore[SafetyCase, RecordingScores],
    *,
    executor: AbstractExecutor,
    progress: Progress,
) -> dict[SafetyCase, RecordingScores]:
    """Score what is not scored yet, each written as soon as it is done; by sensor and kind of loss.

    Parameters
    ----------
    work
        What is asked for.
    options
        How.
    store
        Where scores are found and kept.
    executor
        Where.
    progress
        Takes cases done and to do.
    """
    cases = [case for one in work for case, _ in one.cases]
    found = {case: done for case in cases if (done := store.find(case)) is not None}
    missing = [
        replace(one, cases=tuple(pair for pair in one.cases if pair[0] not in found))
        for one in work
        if any(case not in found for case, _ in one.cases)
    ]
    # The largest first, so that no processor waits long for the last one.
    missing.sort(key=lambda one: -sum(pair.samples.size for pair in one.recording.pairs))
    progress(len(found), len(cases))
    with workers_of(executor, len(missing)) as pool:
        for one, scored in pool.as_done(partial(_score, options), missing):
            for (case, _), scores in zip(one.cases, scored, strict=True):
                store.keep(case, scores)
                found[case] = scores
            progress(len(found), len(cases))
    # By sensor and kind of loss, as the first recording has them, then by recording.
    kinds = list(dict.fromkeys((case.sensor, case.mean_burst_s, case.loss_log) for case in cases))
    order = sorted(cases, key=lambda case: kinds.index((case.sensor, case.mean_burst_s, case.loss_log)))
    return {case: found[case] for case in order}


def gathered(
    scores: Sequence[RecordingScores],
    recordings: Sequence[Recording],
    options: SafetyOptions,
    logs: Sequence[LossLog],
    *,
    failures: Mapping[str, str],
    skipped: Mapping[str, str],
) -> SafetyResult:
    """All scores as one result, pooled over the recordings.

    Parameters
    ----------
    scores
        Of all work, by sensor and kind of loss, in the order of the recordings.
    recordings
        The recordings.
    options
        How they were scored.
    logs
        Losses that were replayed.
    failures, skipped
        Files and trips left out, and why.
    """
    candidates = options.candidates()
    against = options.against or candidates[0].name
    budget = options.budget or candidates[-1].name
    kind = scores[0].kind
    recorded = next((log.channel for log in logs if log.name == kind.loss_log), None)
    asked = options.settings(kind.sensor, kind.mean_burst_s or 0.0, recorded)
    return pool_scores(
        scores,
        {
            **options.as_plain(),
            "decided_by": asked.evaluation.sender,
            "against": against,
            "budget": budget,
            "losses": [log.as_text() for log in logs],
        },
        resamples=options.resamples,
        seed=options.seed,
        film=telling_film(scores, recordings, candidates, asked, names=(against, budget)),
        failures=failures,
        skipped=skipped,
    )

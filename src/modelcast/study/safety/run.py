"""A safety application over recorded pairs: trips and senders in, one result out."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.core.near_names import near
from modelcast.study.compare.candidate import FixedCandidate
from modelcast.study.safety.film import EventFilm, film_event, telling_event
from modelcast.study.safety.pairs import Recording, recordings_of
from modelcast.study.safety.result import RecordingScores, SafetyResult
from modelcast.study.safety.score import score_recording
from modelcast.study.safety.settings import SafetySettings
from modelcast.study.safety.table import pooled_rows
from modelcast.trips.trajectory import Trajectory

__all__ = ["evaluate_safety", "pool_scores", "telling_film"]

_FILMED_RATIO = 0.4


def evaluate_safety(
    trips: Sequence[Trajectory],
    candidates: Sequence[FixedCandidate],
    settings: SafetySettings,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> SafetyResult:
    """Score what followers warn of by the messages of their leaders, against perfect knowledge.

    Parameters
    ----------
    trips
        Recorded trips, some of which follow each other; those of no pair are left out.
    candidates
        Who sends.
    settings
        Application, losses, sensor.
    progress
        Called with recordings done and recordings to do.

    Raises
    ------
    ConfigError
        Where no vehicle follows another, names repeat, or a name in the settings is none of a candidate.
    """
    names = [candidate.name for candidate in candidates]
    if not names or len(set(names)) < len(names):
        raise ConfigError(f"name at least one candidate, and each once: got {', '.join(names) or 'none'}")
    against, budget = settings.against or names[0], settings.budget or names[-1]
    for name in (against, budget):
        if name not in names:
            raise ConfigError(
                f"no candidate is named {name!r}{near(name, names)}; there are {', '.join(names)}"
            )
    recordings = recordings_of(trips)
    scores: list[RecordingScores] = []
    for recording in recordings:
        scores.append(score_recording(recording, candidates, settings))
        if progress is not None:
            progress(len(scores), len(recordings))
    evaluation = settings.evaluation
    plain = {
        **evaluation.as_plain(),
        "application": repr(settings.application),
        "bases": list(settings.bases),
        "budget": budget,
        "against": against,
        "truth": settings.truth,
        "near_m": settings.near_m,
        "later_m": settings.later_m,
        "resamples": settings.resamples,
    }
    film = telling_film(scores, recordings, candidates, settings, names=(against, budget))
    return pool_scores(scores, plain, resamples=settings.resamples, seed=evaluation.seed, film=film)


def pool_scores(
    scores: Sequence[RecordingScores],
    settings: Mapping[str, Any],
    *,
    resamples: int,
    seed: int,
    film: EventFilm | None,
    failures: Mapping[str, str] | None = None,
    skipped: Mapping[str, str] | None = None,
) -> SafetyResult:
    """All scores as one result, pooled over the recordings.

    Parameters
    ----------
    scores
        By sensor and kind of loss, in the order of the recordings.
    settings
        As plain values; ``against`` names the candidate that ratios are taken to.
    resamples, seed
        Of the bootstrap.
    film
        As `telling_film` gave it.
    failures, skipped
        Files and trips left out, and why.
    """
    first = [one for one in scores if one.kind == scores[0].kind]
    return SafetyResult(
        settings,
        recordings=scores,
        pooled=pooled_rows(scores, settings["against"], resamples=resamples, seed=seed),
        events=sum(one.positives.size for one in first),
        pairs=sum(len(one.pairs) for one in first),
        counted=int(sum(one.counted.sum() for one in first)),
        positives=int(sum(one.positives.sum() for one in first)),
        failures=failures or {},
        skipped=skipped or {},
        film=film,
    )


def telling_film(
    scores: Sequence[RecordingScores],
    recordings: Sequence[Recording],
    candidates: Sequence[FixedCandidate],
    settings: SafetySettings,
    *,
    names: tuple[str, str],
) -> EventFilm | None:
    """Film the true warning at which a candidate gains most, at a loss ratio near 40 %; None where none is.

    Parameters
    ----------
    scores
        Of all recordings, all sensors and kinds of loss; the first kind is filmed.
    recordings
        In the same order.
    candidates
        Who sends.
    settings
        Of the first kind.
    names
        The candidate that is the measure, and the one that gains.
    """
    first = [one for one in scores if one.kind == scores[0].kind]
    ratio = min(
        {one.packet_error_ratio for one in first[0].conditions}, key=lambda one: abs(one - _FILMED_RATIO)
    )
    place = telling_event(first, ratio, settings.bases[-1], names)
    if place is None:
        return None
    at, event = place
    pair = int(first[at].event_pair[event])
    begin = int(np.searchsorted(first[at].event_pair, pair))
    return film_event(
        recordings[at],
        recordings[at].pairs[pair],
        event - begin,
        candidates,
        settings,
        sensor=first[at].sensor,
        ratio=ratio,
    )

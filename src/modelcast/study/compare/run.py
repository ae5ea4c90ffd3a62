"""The honest protocol: candidates side by side, each trip judged by what was learnt on other routes."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.core.near_names import near
from modelcast.study.compare.candidate import AbstractCandidate
from modelcast.study.compare.free import free_name, with_free
from modelcast.study.compare.result import (
    COUNTS,
    RATIOS,
    REFERENCE_RATIOS,
    RIVAL_RATIOS,
    ROUTES,
    TRACKING_RATIOS,
    CandidateRow,
    ComparedTrip,
    ComparisonResult,
)
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.compare.stage import reference_ratios, stage_trips, usable_trips
from modelcast.study.compare.table import Resamples, ratio_rows, rivals_rows, tracking_rows
from modelcast.study.compare.trial import candidate_row, fit_folds, run_trial
from modelcast.study.routes import route_names, routes
from modelcast.study.table import Row, Table
from modelcast.trips.fingerprint import known_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["checked_reference", "compare"]

Progress = Callable[[int, int], None]


def compare(
    trips: Sequence[Trajectory],
    candidates: Sequence[AbstractCandidate],
    settings: CompareSettings | None = None,
    *,
    progress: Progress | None = None,
) -> ComparisonResult:
    """Evaluate every candidate on the same trips, thresholds, losses and protocols.

    Parameters
    ----------
    trips
        Recorded trips, with distinct identifiers.
    candidates
        What is compared; a trained one is fitted anew for every route, on the trips of the others. The free
        receiver is put behind them, unless it is one of them or `EvaluationSettings.free` is None.
    settings
        What to do.
    progress
        Called with trips done and trips to do, counted over all candidates and protocols.

    Returns
    -------
    ComparisonResult
        Pooled rows with 95 % intervals over the trips, and rows a trip.

    Raises
    ------
    ConfigError
        Where names repeat, no trip is long enough, or a trained candidate has no other route to learn from.

    Examples
    --------
    >>> from modelcast.study.compare.candidate import FixedCandidate
    >>> from modelcast.station.banks import BASELINE_BANK
    >>> from modelcast.study.settings import EvaluationSettings
    >>> from modelcast.world.drive import generate_drive
    >>> asked = CompareSettings(EvaluationSettings((0.5,), (0.0,), seeds=1, references=False), ("recorded",))
    >>> result = compare([generate_drive(1, 90.0).truth], [FixedCandidate("cv", BASELINE_BANK)], asked)
    >>> [row.candidate for row in result.ratios], result.ratios[0].message_ratio
    (['cv', 'free'], 1.0)
    """
    settings = CompareSettings() if settings is None else settings
    candidates = with_free(candidates, settings.evaluation)
    reference, free = checked_reference(candidates, settings), free_name(candidates, settings.evaluation)
    usable, failures = usable_trips(trips, max(candidate.window for candidate in candidates))
    route = routes(usable, settings.route_by)
    _require_other_routes(candidates, route)
    clusters = route if settings.cluster == "route" else np.arange(len(usable), dtype=np.int64)
    resamples = Resamples.drawn(clusters, settings.resamples, settings.evaluation.seed)
    work = _Work(progress, len(candidates) * len(settings.protocols) * len(usable))
    staged = stage_trips(usable, settings)
    training_trips: frozenset[str] = frozenset()
    for candidate in candidates:
        folds = fit_folds(candidate, usable, route, settings.evaluation)
        if not candidate.is_trained:  # one that is, is judged on other trips than it was trained on
            training_trips |= folds[0].training_trips
        work.candidates.append(candidate_row(candidate, folds[0]))
        for protocol, ready in staged.items():
            trial = run_trial(
                candidate.name,
                protocol,
                ready,
                route,
                folds,
                step=work.step,
                bases=(settings.rate_basis,),
            )
            work.counts += trial.counts
            work.tracking += tracking_rows(
                candidate.name,
                trial,
                shares_s=[trip.case.truth.dt_s for trip in ready],
                durations_s=[trip.case.truth.duration_s for trip in ready],
                resamples=resamples,
            )
    return ComparisonResult(
        {**settings.as_plain(), "against": reference, "free": free},
        routes=_route_rows(usable, route),
        trips=tuple(
            _trip_row(
                trip, int(number), training_trips, [ready[at].case.warnings for ready in staged.values()]
            )
            for at, (trip, number) in enumerate(zip(usable, route, strict=True))
        ),
        candidates=tuple(work.candidates),
        ratios=RATIOS.table(ratio_rows(work.counts, reference, resamples)),
        tracking=TRACKING_RATIOS.table(work.tracking),
        counts=COUNTS.table(work.counts),
        rivals=RIVAL_RATIOS.table(rivals_rows(work.counts, reference, free, resamples)),
        references=REFERENCE_RATIOS.table(reference_ratios(staged, settings)),
        failures=failures,
    )


class _Work:
    """What has been gathered so far, and how much is left.

    Parameters
    ----------
    progress
        Told after each step.
    steps
        How many there are.
    """

    def __init__(self, progress: Progress | None, steps: int) -> None:
        self._progress = progress
        self._steps = steps
        self._done = 0
        self.candidates: list[CandidateRow] = []
        self.counts: list[Row] = []
        self.tracking: list[Row] = []

    def step(self) -> None:
        """Count one trip as done."""
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._steps)


def checked_reference(candidates: Sequence[AbstractCandidate], settings: CompareSettings) -> str:
    """The candidate that differences are taken to, once all names are seen to differ.

    That is the free receiver where none is named, or the first one where that is not run.

    Parameters
    ----------
    candidates
        As `with_free` gives them.
    settings
        As for `compare`.

    Raises
    ------
    ConfigError
        Where names repeat, or none has the name of the one to compare against.
    """
    names = [candidate.name for candidate in candidates]
    if not names:
        raise ConfigError("name at least one candidate to compare")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise ConfigError(f"two candidates are named {repeated[0]}: name each once")
    first = free_name(candidates, settings.evaluation) or names[0]
    against = first if settings.against is None else settings.against
    if against not in names:
        known = f"there are {', '.join(names)}: name one of them, or compare it too"
        raise ConfigError(f"no candidate is named '{against}'{near(against, names)}; {known}")
    return against


def _require_other_routes(candidates: Sequence[AbstractCandidate], route: IntArray) -> None:
    trained = [candidate.name for candidate in candidates if candidate.is_trained]
    if trained and int(route.max()) == 0:
        raise ConfigError(
            f"all trips lie on one route, so {', '.join(trained)} would be judged on the ground it was "
            "trained on: give trips of other routes too, or a profile that was trained elsewhere"
        )


def _route_rows(trips: Sequence[Trajectory], route: IntArray) -> Table:
    rows: list[Row] = []
    for number, name in enumerate(route_names(trips, route)):
        members = [trip for trip, own in zip(trips, route.tolist(), strict=True) if own == number]
        rows.append(
            ROUTES.row(
                route=number,
                name=name,
                trips=len(members),
                duration_s=sum(trip.duration_s for trip in members),
            )
        )
    return ROUTES.table(rows)


def _trip_row(
    trip: Trajectory, route: int, training_trips: frozenset[str], warnings: Sequence[Mapping[str, str]]
) -> ComparedTrip:
    """The trip, with the warnings of all protocols: smoothing makes some of them needless in one."""
    return ComparedTrip(
        trip.trip_id,
        trip.source,
        route,
        duration_s=trip.duration_s,
        samples=len(trip),
        dt_s=trip.dt_s,
        warnings={kind: text for one in warnings for kind, text in one.items()},
        in_training=bool(known_trips([trip], training_trips)),
    )

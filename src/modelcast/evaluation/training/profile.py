"""Training of a whole profile: networks, hyper-parameters, calibrations, the bank's order, and the record.

The first sub-model of the bank is the one that sent the fewest messages; behind it stands the best one that
does with a single sample, for starts and gaps. With ``validate`` the order comes from routes left out of the
training, else from the training trips themselves, which favours what was fitted to them. The record says
which.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, Literal, cast

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.chance import child_generator
from modelcast.core.trajectory import Trajectory
from modelcast.core.version import package_version
from modelcast.evaluation.case import TripCase, make_case
from modelcast.evaluation.routes import routes
from modelcast.evaluation.settings import BASELINE_BANK, EvaluationSettings
from modelcast.evaluation.training.calibration import train_calibrations
from modelcast.evaluation.training.families import VehicleFamily
from modelcast.evaluation.training.hyperparameters import TrainedPair, train_hyperparameters
from modelcast.evaluation.training.learned import LearnedSettings, train_learned
from modelcast.evaluation.training.views import SenderView, view_trips
from modelcast.evaluation.training.windows import TrainingWindows, training_windows
from modelcast.evaluation.walk import TripBank
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import derivative_process, vehicle_process
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.profile import Profile
from modelcast.policy.error_driven import ErrorDriven
from modelcast.policy.rules import IdentifyRule, StartRule

__all__ = ["LONGEST_WINDOW", "ProfileSettings", "profile_learner", "train_profile"]

LONGEST_WINDOW = 21
"""Samples that the longest window of a trained sub-model holds."""

Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps to do."""

Protocol = Literal["recorded", "sensor"]

_PROTOCOLS: tuple[Protocol, ...] = ("recorded", "sensor")

_PROCESS_VIEWS = (SenderView("recorded"), SenderView("motion", 0.01), SenderView("motion", 0.05))

_KINEMATIC: tuple[AbstractSubModel, ...] = (
    ConstantTurnRateAcceleration(),
    ConstantTurnRateVelocity(),
    ConstantAcceleration(),
    ConstantVelocity(),
)


@dataclass(frozen=True, slots=True)
class ProfileSettings:
    """How a profile is trained.

    Parameters
    ----------
    learned
        Of the learned sub-model.
    process_windows, process_evaluations
        Windows that a Gaussian process's hyper-parameters are searched on, and objective evaluations.
    thresholds_m
        Thresholds at which messages are counted [m].
    validate
        Whether everything is also trained once without each route, and counted on it.
    seed
        Of all random numbers.

    Raises
    ------
    ValueError
        Where a number is not positive.
    """

    learned: LearnedSettings = field(default_factory=LearnedSettings)
    _: KW_ONLY
    process_windows: int = 2000
    process_evaluations: int = 60
    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    validate: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if self.process_windows < 1 or self.process_evaluations < 1 or not self.thresholds_m:
            raise ValueError("process_windows, process_evaluations and thresholds_m must be positive")


@dataclass(frozen=True, slots=True)
class _Shelf:
    """All sub-models that training trips taught, and the Gaussian processes' searches."""

    members: tuple[AbstractSubModel, ...]
    processes: dict[str, TrainedPair]


def train_profile(
    trips: Sequence[Trajectory], settings: ProfileSettings | None = None, *, progress: Progress | None = None
) -> Profile:
    """Train everything that vehicles share.

    Parameters
    ----------
    trips
        As read.
    settings
        How.
    progress
        Called as the work goes on.

    Raises
    ------
    MissingExtraError
        Where scikit-learn, which the extra ``train`` brings, is not installed.
    ValueError
        Where the trips are too short to learn from, or ``validate`` finds a single route only.
    """
    settings = ProfileSettings() if settings is None else settings
    shelf = _train(trips, settings, progress, "")
    cases = _cases(trips, settings.seed)
    counted, basis = _counts(cases, shelf.members, settings), "training trips"
    if settings.validate:
        counted, basis = _held_out(trips, settings, progress), "routes left out"
    totals = {name: sum(float(row.sum()) for row in rows.values()) for name, rows in counted.items()}
    named = {member.name: member for member in shelf.members}
    order = sorted((name for name in named), key=lambda name: totals[name])
    first = named[order[0]]
    fallback = next(named[name] for name in order if named[name].window == 1)
    bank = Bank((first,) if first is fallback else (first, fallback))
    calibrations = train_calibrations(
        [case for one in cases.values() for case in one],
        bank.members,
        progress=None if progress is None else lambda done, to_do: progress("calibrations", done, to_do),
    )
    return Profile(
        bank,
        shelf=tuple(member for member in shelf.members if member not in (*bank.members, *_KINEMATIC)),
        calibrations=calibrations,
        record=_record(trips, settings, shelf, counted, basis),
    )


def profile_learner(
    settings: ProfileSettings | None = None,
) -> Callable[[Sequence[Trajectory], EvaluationSettings], EvaluationSettings]:
    """Return what `modelcast.evaluation.compare.candidate.TrainedCandidate` calls for every route left out.

    Parameters
    ----------
    settings
        How each profile is trained.
    """

    def learn(trips: Sequence[Trajectory], shared: EvaluationSettings) -> EvaluationSettings:
        profile = train_profile(trips, settings)
        rules = cast("StartRule", profile.start), cast("IdentifyRule", profile.identify)
        return replace(shared, bank=profile.bank, start=rules[0], identify=rules[1])

    return learn


def _train(
    trips: Sequence[Trajectory], settings: ProfileSettings, progress: Progress | None, note: str
) -> _Shelf:
    def told(what: str) -> Callable[[int, int], None]:
        def tell(done: int, to_do: int) -> None:
            if progress is not None:
                progress(what + note, done, to_do)

        return tell

    learned = train_learned(trips, replace(settings.learned, seed=settings.seed), progress=told("networks"))
    windows = _process_windows(trips, settings)
    processes = {
        model.name: train_hyperparameters(
            windows,
            VehicleFamily(model),
            evaluations=settings.process_evaluations,
            progress=told(model.name),
        )
        for model in (vehicle_process(), derivative_process())
    }
    found = tuple(pair.better.model for pair in processes.values())
    return _Shelf((learned, *found, *_KINEMATIC), processes)


def _process_windows(trips: Sequence[Trajectory], settings: ProfileSettings) -> TrainingWindows:
    """Windows of all views, of the trips at the commonest sampling interval."""
    intervals = np.round([trip.dt_s for trip in trips], 3)
    values, counts = np.unique(intervals, return_counts=True)
    dt_s = values[counts.argmax()]
    chosen = [trip for trip, own in zip(trips, intervals, strict=True) if own == dt_s]
    seen = [one.seen for view in _PROCESS_VIEWS for one in view_trips(chosen, view, seed=settings.seed)]
    return training_windows(
        seen,
        samples=vehicle_process().window,
        longest_s=5.0,
        count=settings.process_windows,
        rng=child_generator(settings.seed, "process windows"),
    )


def _cases(trips: Sequence[Trajectory], seed: int) -> dict[str, list[TripCase]]:
    """The trips in both protocols; a recording that is no truth of its own in one of them only."""
    found: dict[str, list[TripCase]] = {}
    for protocol in _PROTOCOLS:
        asked = EvaluationSettings(
            protocol=protocol, seed=seed, bank=BASELINE_BANK, start="order", identify="never"
        )
        made = [make_case(trip, asked) for trip in trips]
        found[protocol] = [
            case for case in made if protocol in ("sensor", case.inspection.recommended_protocol)
        ]
    return found


def _counts(
    cases: dict[str, list[TripCase]], members: Sequence[AbstractSubModel], settings: ProfileSettings
) -> dict[str, dict[str, FloatArray]]:
    """Messages of every sub-model alone and of the baseline, by protocol, (thresholds,) each."""
    found: dict[str, dict[str, FloatArray]] = {}
    for name, bank in {
        **{member.name: Bank((member,)) for member in members},
        "baseline": BASELINE_BANK,
    }.items():
        found[name] = {}
        for protocol, own in cases.items():
            total = np.zeros(len(settings.thresholds_m))
            for case in own:
                ready = TripBank(case.seen, bank, case.estimator)
                total += [
                    ready.walk(ErrorDriven(threshold_m, identify="never")).updates
                    for threshold_m in settings.thresholds_m
                ]
            found[name][protocol] = total
    return found


def _held_out(
    trips: Sequence[Trajectory], settings: ProfileSettings, progress: Progress | None
) -> dict[str, dict[str, FloatArray]]:
    """Messages as `_counts` has them, of sub-models trained without the route that each trip is on."""
    route = routes(trips)
    count = int(route.max()) + 1
    if count < 2:
        raise ValueError("all trips lie on one route: there is none to leave out (train without validation)")
    total: dict[str, dict[str, FloatArray]] = {}
    for left_out in range(count):
        others = [trip for trip, own in zip(trips, route, strict=True) if own != left_out]
        tested = [trip for trip, own in zip(trips, route, strict=True) if own == left_out]
        shelf = _train(others, settings, progress, f" without route {left_out + 1} of {count}")
        counted = _counts(_cases(tested, settings.seed), shelf.members, settings)
        for name, rows in counted.items():
            for protocol, row in rows.items():
                total.setdefault(name, {}).setdefault(protocol, np.zeros_like(row))
                total[name][protocol] = total[name][protocol] + row
    return total


def _record(
    trips: Sequence[Trajectory],
    settings: ProfileSettings,
    shelf: _Shelf,
    counted: dict[str, dict[str, FloatArray]],
    basis: str,
) -> dict[str, Any]:
    """What the profile says of its own making."""
    learned = settings.learned
    return {
        "modelcast": package_version(),
        "seed": settings.seed,
        "trips": [
            {"trip": trip.trip_id, "format": trip.source, "duration_s": round(trip.duration_s, 3)}
            for trip in trips
        ],
        "networks": {
            "hidden": list(learned.descent.hidden),
            "coefficients": learned.coefficients,
            "steps": learned.descent.steps,
            "windows": learned.rows,
            "longest_s": learned.longest_s,
            "loss_thresholds_m": list(learned.descent.thresholds_m),
            "stages": [
                {
                    "noise_range_m": [str(edge) for edge in stage.noise_range_m],
                    "views": [view.name for view in stage.views],
                }
                for stage in learned.stages
            ],
        },
        "processes": {
            name: {
                "kept": pair.better.by,
                **{
                    one.by: {
                        "log_likelihood": one.log_likelihood,
                        "mean_survival_s": list(one.mean_survival_s),
                        "message_rate_hz": list(one.message_rate_hz),
                    }
                    for one in (pair.likelihood, pair.survival)
                },
            }
            for name, pair in shelf.processes.items()
        },
        "figures": {
            "counted_on": basis,
            "thresholds_m": list(settings.thresholds_m),
            "messages": {
                name: {protocol: row.astype(int).tolist() for protocol, row in rows.items()}
                for name, rows in counted.items()
            },
        },
    }

"""Training of a whole profile: networks, hyper-parameters, calibrations, the bank's order, and the record.

Sub-models come in families that are trained together (`FAMILIES`); those are trained that the bank names, or
that are asked for beside it. A profile trained before lends those that are not.

With ``validate`` everything is also trained without each route, and counted and calibrated on it. The bank's
members are chosen there: first the sub-model that sends the fewest messages alone, then others while they
save some beside it (`members`). Without it the bank is `DEFAULT_NAMES`, and the figures are of the training
trips themselves, which favours what was fitted to them; the record says which. A sub-model that does with a
single sample stands last, for starts and gaps; where the start rule is ``guarded``, constant velocity.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, Literal, cast

from modelcast.core.version import package_version
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.learned import LearnedTrajectory, Selector
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.profile import MOST_MEMBERS, Profile
from modelcast.models.regimes import REGIME_BANK, Regimes
from modelcast.models.sub_models import model_of_word, names_registered
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.guard import GUARD, unguarded
from modelcast.study.case import TripCase, make_case
from modelcast.study.routes import routes
from modelcast.study.settings import EvaluationSettings
from modelcast.study.training.calibration import pooled_calibrations
from modelcast.study.training.costs import train_costs
from modelcast.study.training.dates import training_dates
from modelcast.study.training.free_members import (
    FREE_NAMES,
    FreeMembers,
    FreeMembersSettings,
    train_free_members,
)
from modelcast.study.training.learned import LearnedSettings, train_learned
from modelcast.study.training.members import Fold, MemberSettings, choose_names
from modelcast.study.training.processes import ProcessSettings, TrainedProcesses, train_processes
from modelcast.study.training.selection import SelectorSettings, train_selector
from modelcast.study.training.switching import SwitchingSettings, TrainedSwitching, train_switching
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "DEFAULT_NAMES",
    "FAMILIES",
    "LONGEST_WINDOW",
    "MOST_NAMES",
    "ProfileSettings",
    "families_of",
    "named_training_trips",
    "train_profile",
]

LONGEST_WINDOW = 21
"""Samples that the longest window of a trained sub-model holds."""

Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps to do."""

Protocol = Literal["recorded", "sensor"]

_PROTOCOLS: tuple[Protocol, ...] = ("recorded", "sensor")

DEFAULT_NAMES = ("free-predictive", "free")
"""Members where they are not chosen: on its own training trips a learned one looks better than it is."""

FAMILIES: dict[str, tuple[str, ...]] = {
    "free": FREE_NAMES,
    "learned": ("learned",),
    "processes": ("gp-vehicle", "gp-derivative", "gp-trained"),
    "switching": ("shs", "hdp-hmm"),
}
"""What is trained together, and the names of its sub-models; ``processes`` has those of the regimes too."""

_REGIME = "gp-regime-"

MOST_NAMES = MOST_MEMBERS - 2
"""Members that may be named: a starter and the guard may join them in the profile."""

_STARTER = Trusted(ConstantTurnRateAcceleration(), 1.5, 1.0)
"""The horizon is that of decision 010: what must end is the acceleration; the turn that of decision 028."""

_KINEMATIC: tuple[AbstractSubModel, ...] = (
    _STARTER,
    ConstantTurnRateVelocity(),
    ConstantAcceleration(),
    ConstantVelocity(),
)


def families_of(names: Iterable[str]) -> tuple[str, ...]:
    """Families that must be trained for some sub-models, in the order of `FAMILIES`.

    Parameters
    ----------
    names
        Of sub-models, or of the bank of the regimes; those that need no training belong to none.

    Examples
    --------
    >>> families_of(["ctra", "gp-regime-1", "free"])
    ('free', 'processes')
    """
    wanted = set(names)
    regimes = any(name == REGIME_BANK or name.startswith(_REGIME) for name in wanted)
    return tuple(
        family for family, own in FAMILIES.items() if wanted & set(own) or (family == "processes" and regimes)
    )


@dataclass(frozen=True, slots=True)
class ProfileSettings:
    """How a profile is trained.

    Parameters
    ----------
    learned
        Of the learned sub-model.
    free
        Of the free sub-models.
    processes
        Of the Gaussian processes.
    switching
        Of the switching sub-models, which are no candidates of the bank; None for none.
    thresholds_m
        Thresholds at which messages are counted [m].
    members
        How the bank's members are chosen, and its rules.
    names
        The bank's members in order; where empty, chosen with ``validate``, `DEFAULT_NAMES` without.
    also
        `FAMILIES` that are trained beside those that the bank names.
    selector
        Of what the start rule ``predicted`` asks.
    validate
        Whether everything is also trained once without each route, and counted on it.
    seed
        Of all random numbers.

    Raises
    ------
    ValueError
        Where there is no threshold, or a family is unknown.
    """

    learned: LearnedSettings = field(default_factory=LearnedSettings)
    _: KW_ONLY
    free: FreeMembersSettings = field(default_factory=FreeMembersSettings)
    processes: ProcessSettings = field(default_factory=ProcessSettings)
    switching: SwitchingSettings | None = field(default_factory=SwitchingSettings)
    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    members: MemberSettings = field(default_factory=lambda: MemberSettings((0.2, 0.5)))
    names: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    selector: SelectorSettings = field(default_factory=SelectorSettings)
    validate: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.thresholds_m:
            raise ValueError("thresholds_m must hold at least one")
        unknown = [family for family in self.also if family not in FAMILIES]
        if unknown:
            raise ValueError(f"also names families, {', '.join(FAMILIES)}, not {unknown[0]!r}")

    @property
    def families(self) -> tuple[str, ...]:
        """What is trained, in the order of `FAMILIES`."""
        wanted = {*self.also, *families_of(self.names or DEFAULT_NAMES)}
        return tuple(family for family in FAMILIES if family in wanted)


@dataclass(frozen=True, slots=True)
class _Judged:
    """Trips by protocol, and sub-models that are judged on them."""

    cases: dict[str, list[TripCase]]
    shelf: "_Shelf"

    @property
    def pooled(self) -> Fold:
        """All trips together, with the sub-models that a bank is chosen from."""
        return Fold([case for cases in self.cases.values() for case in cases], self.shelf.candidates)


@dataclass(frozen=True, slots=True)
class _Shelf:
    """All sub-models that training trips taught, and how."""

    free: FreeMembers | None
    learned: LearnedTrajectory | None
    processes: TrainedProcesses | None
    switching: TrainedSwitching | None

    @property
    def candidates(self) -> tuple[AbstractSubModel, ...]:
        """What a bank is chosen from; a sub-model that asks for context is not, since few have any."""
        return (
            *(() if self.free is None else (self.free.free, self.free.predictive)),
            *(() if self.learned is None else (self.learned,)),
            *(() if self.processes is None else self.processes.candidates),
            *_KINEMATIC,
        )

    @property
    def aside(self) -> tuple[AbstractSubModel, ...]:
        """What a bank may be made of by name only."""
        return (
            *(() if self.free is None else (self.free.context,)),
            *(() if self.processes is None else (self.processes.fixed,)),
            *(() if self.switching is None else self.switching.models),
        )

    @property
    def regimes(self) -> Regimes | None:
        """Driving regimes, where Gaussian processes were trained."""
        return None if self.processes is None else self.processes.regimes

    @property
    def members(self) -> tuple[AbstractSubModel, ...]:
        """What a bank is chosen from, what is only there by name, and the regimes'."""
        return (*self.candidates, *self.aside, *(() if self.regimes is None else self.regimes.members))

    def bank(self, names: Sequence[str]) -> Bank:
        """The bank of these members: trained ones, and those that other packages register."""
        named = {member.name: member for member in self.members}
        foreign = [name for name in names if name not in named and names_registered(name)]
        named |= {name: model_of_word(name) for name in foreign}
        unknown = [name for name in names if name not in named]
        if unknown:
            raise ValueError(f"no trained sub-model is named {unknown[0]}; there are {', '.join(named)}")
        return Bank(tuple(named[name] for name in names))


def train_profile(
    trips: Sequence[Trajectory],
    settings: ProfileSettings | None = None,
    *,
    beside: Profile | None = None,
    progress: Progress | None = None,
) -> Profile:
    """Train everything that vehicles share.

    Parameters
    ----------
    trips
        As read.
    settings
        How.
    beside
        A profile trained before: its sub-models of families that are not trained now go to the shelf.
    progress
        Called as the work goes on.

    Raises
    ------
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, is not installed.
    ValueError
        Where the trips are too short to learn from, or ``validate`` finds a single route only.
    """
    settings = ProfileSettings() if settings is None else settings
    shelf = _train(trips, settings, progress, "")
    if settings.validate:
        folds = _folds(trips, settings, progress)
    else:
        folds = [_Judged(_cases(trips, settings.seed), shelf)]

    def choosing(done: int, to_do: int) -> None:
        if progress is not None:
            progress("members", done, to_do)

    names, steps = settings.names, ()
    if not names and settings.validate:
        names, steps = choose_names([fold.pooled for fold in folds], settings.members, progress=choosing)
    elif not names:
        names = DEFAULT_NAMES
    bank = shelf.bank(names)
    if bank.window > 1:
        names = (*names, _starter(bank).name)
    if settings.members.start == "guarded" and GUARD not in names:
        names = (*names, GUARD)
    bank = shelf.bank(names)

    def calibrating(done: int, to_do: int) -> None:
        if progress is not None:
            progress("calibrations", done, to_do)

    calibrations = pooled_calibrations(
        [(fold.pooled.cases, fold.shelf.bank(names).members) for fold in folds], progress=calibrating
    )
    figures = _figures(folds, names, settings)
    selector, costs = _selection(folds, names, settings, progress)
    kept = _Kept() if beside is None else _kept(beside, settings.families)
    return Profile(
        bank,
        shelf=tuple(
            member
            for member in (*shelf.candidates, *shelf.aside, *kept.shelf)
            if member not in (*bank.members, *_KINEMATIC)
        ),
        regimes=shelf.regimes or kept.regimes,
        start=settings.members.start,
        identify=settings.members.identify,
        selector=selector,
        costs=costs.as_plain(),
        calibrations=calibrations,
        added=kept.added,
        added_record=kept.added_record,
        record=_record(trips, settings, shelf, {**figures, "steps": list(steps)}, kept),
        training_trips=tuple(dict.fromkeys((*map(fingerprint, trips), *kept.training_trips))),
    )


def _starter(bank: Bank) -> AbstractSubModel:
    """What serves where no member of a bank has a full window."""
    found = bank.members[bank.plain_place].starter if bank.plain_place >= 0 else None
    return _STARTER if found is None else found


@dataclass(frozen=True, slots=True)
class _Kept:
    """What stays of a profile trained before: sub-models, regimes, how they were trained, and on what."""

    shelf: tuple[AbstractSubModel, ...] = ()
    _: KW_ONLY
    added: tuple[AbstractSubModel, ...] = ()
    added_record: Mapping[str, Any] = field(default_factory=dict[str, Any])
    regimes: Regimes | None = None
    record: Mapping[str, Any] = field(default_factory=dict[str, Any])
    trips: tuple[dict[str, Any], ...] = ()
    training_trips: tuple[str, ...] = ()


_RECORDS = {"free": "free", "learned": "networks", "processes": "processes", "switching": "switching"}
"""Where a profile's record tells of each of `FAMILIES`."""


def _kept(profile: Profile, families: Sequence[str]) -> _Kept:
    """What a profile has of the families that are not trained now."""
    anew = {name for family in families for name in FAMILIES[family]} | {one.name for one in _KINEMATIC}
    regimes = None if "processes" in families else profile.regimes
    shelf = tuple(one for one in (*profile.bank.members, *profile.shelf) if one.name not in anew)
    added = tuple(one for one in profile.added if one.name not in anew)
    if not (shelf or added or regimes):
        return _Kept()
    told = {_RECORDS[family] for family in FAMILIES if family not in families}
    return _Kept(
        shelf,
        added=added,
        added_record={name: one for name, one in profile.added_record.items() if name not in anew},
        regimes=regimes,
        record={name: one for name, one in profile.record.items() if name in told},
        trips=tuple(profile.record.get("trips", ())),
        training_trips=profile.training_trips,
    )


def named_training_trips(profile: Profile, trips: Sequence[Trajectory]) -> Profile:
    """A profile trained before profiles named their trips, with their fingerprints; its identity stays.

    Parameters
    ----------
    profile
        The profile; its record lists the trips by identifier, format and duration.
    trips
        Those trips, in any order and among others.

    Raises
    ------
    ValueError
        Where a trip of the record is not among them, or lasts otherwise.
    """
    given = {trip.trip_id: trip for trip in trips}
    found: list[str] = []
    for row in profile.record["trips"]:
        trip = given.get(row["trip"])
        if trip is None:
            raise ValueError(f"the profile was trained on {row['trip']}, which is not among the trips given")
        if (trip.source, round(trip.duration_s, 3)) != (row["format"], row["duration_s"]):
            raise ValueError(
                f"{row['trip']} is {trip.source} of {trip.duration_s:.3f} s, but the profile was trained on "
                f"{row['format']} of {row['duration_s']} s"
            )
        found.append(fingerprint(trip))
    return replace(profile, training_trips=tuple(found))


def _train(
    trips: Sequence[Trajectory], settings: ProfileSettings, progress: Progress | None, note: str
) -> _Shelf:
    def told(what: str) -> Callable[[int, int], None]:
        def tell(done: int, to_do: int) -> None:
            if progress is not None:
                progress(what + note, done, to_do)

        return tell

    def tell(what: str, done: int, to_do: int) -> None:
        told(what)(done, to_do)

    seed, families = settings.seed, settings.families
    free = learned = processes = switching = None
    if "free" in families:
        how = replace(settings.free, free=replace(settings.free.free, seed=seed))
        free = train_free_members(trips, how, progress=tell)
    if "learned" in families:
        learned = train_learned(trips, replace(settings.learned, seed=seed), progress=told("networks"))
    if "processes" in families:
        processes = train_processes(trips, settings.processes, seed=seed, progress=tell)
    if "switching" in families and settings.switching is not None:
        switching = train_switching(trips, settings.switching, seed=seed, progress=tell)
    return _Shelf(free, learned, processes, switching)


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


def _selection(
    folds: Sequence[_Judged], names: Sequence[str], settings: ProfileSettings, progress: Progress | None
) -> tuple[Selector, CostTable]:
    """What ``predicted`` and ``cheapest`` need, from the largest fold, with that fold's own sub-models."""

    def selecting(done: int, to_do: int) -> None:
        if progress is not None:
            progress("selector", done, to_do)

    largest = max(folds, key=lambda fold: len(fold.pooled.cases))
    bank = largest.shelf.bank(names)
    cases = largest.pooled.cases
    selector = train_selector(cases, bank, replace(settings.selector, seed=settings.seed), progress=selecting)
    costs = train_costs(cases, bank, start=settings.members.start)
    return cast("Selector", from_plain(to_plain(selector))), costs  # rounded as the text keeps it


def _folds(
    trips: Sequence[Trajectory], settings: ProfileSettings, progress: Progress | None
) -> list[_Judged]:
    """The trips of every route, each with sub-models trained without it."""
    route = routes(trips)
    count = int(route.max()) + 1
    if count < 2:
        raise ValueError("all trips lie on one route: there is none to leave out (train without validation)")
    folds: list[_Judged] = []
    for left_out in range(count):
        others = [trip for trip, own in zip(trips, route, strict=True) if own != left_out]
        tested = [trip for trip, own in zip(trips, route, strict=True) if own == left_out]
        shelf = _train(others, settings, progress, f" without route {left_out + 1} of {count}")
        folds.append(_Judged(_cases(tested, settings.seed), shelf))
    return folds


def _figures(folds: Sequence[_Judged], names: Sequence[str], settings: ProfileSettings) -> dict[str, Any]:
    """Messages of the bank, of every sub-model alone and of the baseline, by protocol, one a threshold."""
    found: dict[str, dict[str, list[int]]] = {}
    for fold in folds:
        regimes = fold.shelf.regimes
        banks = {
            "bank": fold.shelf.bank(names),
            **{member.name: Bank((member,)) for member in fold.shelf.members},
            **({} if regimes is None else {REGIME_BANK: regimes.bank}),
            "baseline": BASELINE_BANK,
        }
        for name, bank in banks.items():
            rules = settings.members
            start = rules.start if name == "bank" else unguarded(rules.start)
            for protocol, cases in fold.cases.items():
                row = found.setdefault(name, {}).setdefault(protocol, [0] * len(settings.thresholds_m))
                for case in cases:
                    ready = TripRuntime(case.seen, bank, case.estimator)
                    for at, threshold_m in enumerate(settings.thresholds_m):
                        walk = ready.run(ErrorDriven(threshold_m, start, rules.identify))
                        row[at] += walk.updates + walk.identifications
    return {
        "counted_on": "routes left out" if settings.validate else "training trips",
        "thresholds_m": list(settings.thresholds_m),
        "messages": found,
    }


def _record(
    trips: Sequence[Trajectory],
    settings: ProfileSettings,
    shelf: _Shelf,
    figures: dict[str, Any],
    kept: _Kept,
) -> dict[str, Any]:
    """What the profile says of its own making, and of what it keeps."""
    own = [
        {"trip": trip.trip_id, "format": trip.source, "duration_s": round(trip.duration_s, 3)}
        for trip in trips
    ]
    dates = training_dates(trips)
    return {
        **kept.record,
        **({"dates": dates} if dates else {}),
        "modelcast": package_version(),
        "seed": settings.seed,
        "trips": [*own, *(row for row in kept.trips if row not in own)],
        **({} if shelf.free is None else {"free": shelf.free.record}),
        **({} if shelf.learned is None else _networks_record(settings.learned)),
        **({} if shelf.processes is None else _processes_record(shelf.processes)),
        **({} if shelf.switching is None else {"switching": shelf.switching.record}),
        "figures": figures,
    }


def _networks_record(learned: LearnedSettings) -> dict[str, Any]:
    """How the learned sub-model was trained."""
    return {
        "networks": {
            "hidden": list(learned.descent.hidden),
            "coefficients": learned.coefficients,
            "steps": learned.descent.steps,
            "windows": learned.rows,
            "playbacks": [how.name or "as recorded" for how in learned.playbacks],
            "longest_s": learned.longest_s,
            "loss_thresholds_m": list(learned.descent.thresholds_m),
            "stages": [
                {
                    "noise_range_m": [str(edge) for edge in stage.noise_range_m],
                    "views": [view.name for view in stage.views],
                }
                for stage in learned.stages
            ],
        }
    }


def _processes_record(processes: TrainedProcesses) -> dict[str, Any]:
    """What the searches of the Gaussian processes found."""
    return {
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
            for name, pair in processes.pairs.items()
        }
    }

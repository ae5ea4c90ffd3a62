"""Whether the sub-models complete each other: one holds while the other fails; who lasts a manoeuvre."""

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.study.compare.stage import StagedTrip
from modelcast.study.illustration import STRETCH_S, draw_manoeuvre, draw_timeline
from modelcast.study.result import Manoeuvre, Timeline
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind

__all__ = ["Complement", "Survival", "complement"]

_SHOWN_KINDS = frozenset(
    {ManoeuvreKind.LANE_CHANGE, ManoeuvreKind.TURN, ManoeuvreKind.U_TURN, ManoeuvreKind.ROUNDABOUT}
)
"""Manoeuvres that a map shows something of: those to a side, before a stop or a hard brake."""

_LEAST_WAY_M = 10.0
"""A map of less way than this shows a vehicle that stands [m]."""


@dataclass(frozen=True, slots=True)
class Survival:
    """How long each sub-model's path stays under the threshold from just before a manoeuvre on.

    Parameters
    ----------
    trip, kind, start_s
        Which manoeuvre [s].
    survival_s
        By sub-model [s].
    """

    trip: str
    kind: str
    start_s: float
    survival_s: dict[str, float]


@dataclass(frozen=True, slots=True)
class Complement:
    """How the two sub-models share the time in which both serve, on all trips.

    Parameters
    ----------
    members
        Names of the sub-models, in the bank's order.
    threshold_m
        The threshold [m].
    only_s
        Time during which one alone held, in the order of `members` [s].
    both_s, neither_s
        Time during which both held, and both failed (and were fitted anew) [s].
    timeline
        The stretch in which each holds longest while the other fails; None where no trip has one.
    manoeuvre
        The manoeuvre of 10 m of way or more in which the paths of both part the most, of those to a side if
        there are any; None where no trip has one.
    survivals
        One a manoeuvre.
    """

    members: tuple[str, ...]
    threshold_m: float
    _: KW_ONLY
    only_s: tuple[float, ...]
    both_s: float
    neither_s: float
    timeline: Timeline | None
    manoeuvre: Manoeuvre | None
    survivals: tuple[Survival, ...]


def complement(
    trips: Sequence[StagedTrip],
    manoeuvres: Iterable[Sequence[FoundManoeuvre]],
    settings: EvaluationSettings,
) -> Complement:
    """Walk every trip at the smallest threshold, and see who held when.

    Parameters
    ----------
    trips
        Made ready in one protocol; all hold a window.
    manoeuvres
        Manoeuvres of each.
    settings
        Whose sub-models and rules, and at which thresholds.
    """
    threshold_m = min(settings.thresholds_m)
    only_s: FloatArray = np.zeros(len(settings.bank.members))
    both_s = neither_s = 0.0
    best, timeline = 0.0, None
    widest, manoeuvre = (False, 0.0), None
    survivals: list[Survival] = []
    for trip, found in zip(trips, manoeuvres, strict=True):
        case = trip.case
        ready = TripRuntime(
            case.seen,
            settings.bank,
            case.estimator,
            quantised=settings.quantised,
            sensed=trip.baseline.sensed,
        )
        walk = ready.run(settings.policy(threshold_m, keep_alive=False))
        errors_m = ready.tracking_error_m(walk)
        served = np.flatnonzero(np.isfinite(errors_m).all(axis=1))
        holds: BoolArray = errors_m[served] < threshold_m
        holding: IntArray = np.count_nonzero(holds, axis=1)
        alone: BoolArray = np.zeros(errors_m.shape, dtype=np.bool_)
        alone[served] = holds & (holding == 1)[:, None]
        only_s += case.truth.dt_s * np.count_nonzero(alone, axis=0)
        both_s += case.truth.dt_s * np.count_nonzero(holding == holds.shape[1])
        neither_s += case.truth.dt_s * np.count_nonzero(holding == 0)
        value, index = _richest(alone, case.truth.t_s, case.truth.dt_s)
        if value > best:
            best, timeline = value, draw_timeline(case, ready, walk, index)
        for one in found:
            index = min(int(case.truth.t_s.searchsorted(one.start_s)), len(case.truth) - 1)
            drawn = draw_manoeuvre(case, [ready], threshold_m, index)
            if len(drawn.predicted_m) < len(settings.bank.members):
                continue  # the window before it is not full: there is but one path
            survivals.append(_survival(drawn, one.kind))
            apart_s = _parting(survivals[-1])
            rank = one.kind in _SHOWN_KINDS, apart_s
            if apart_s > 0.0 and _way_m(drawn) >= _LEAST_WAY_M and rank > widest:
                widest, manoeuvre = rank, drawn
    return Complement(
        tuple(member.name for member in settings.bank.members),
        threshold_m,
        only_s=tuple(only_s.tolist()),
        both_s=float(both_s),
        neither_s=float(neither_s),
        timeline=timeline,
        manoeuvre=manoeuvre,
        survivals=tuple(survivals),
    )


def _richest(alone: BoolArray, t_s: FloatArray, dt_s: float) -> tuple[float, int]:
    """The stretch in which the shorter of both times alone is longest [s], and the sample in its middle."""
    counts: FloatArray = np.zeros((alone.shape[0] + 1, alone.shape[1]))
    counts[1:] = alone.cumsum(axis=0)
    ends = np.searchsorted(t_s, t_s + STRETCH_S)
    within = counts[ends] - counts[: t_s.size]
    shorter: FloatArray = np.sort(within, axis=1)[:, 0]
    first = int(np.argmax(shorter))
    middle = int(t_s.searchsorted(float(t_s[first]) + STRETCH_S / 2))
    return float(shorter[first]) * dt_s, min(middle, t_s.size - 1)


def _survival(drawn: Manoeuvre, kind: ManoeuvreKind) -> Survival:
    """How long each path stayed near: to the end of what was drawn at most."""
    longest_s = float(drawn.horizons_s[-1])
    lives = {name: min(life_s, longest_s) for name, life_s in drawn.survival_s.items()}
    return Survival(drawn.trip, kind.value, drawn.start_s, lives)


def _way_m(drawn: Manoeuvre) -> float:
    """How far the vehicle goes while its paths are drawn [m]."""
    return float(np.hypot(*np.diff(drawn.truth_m, axis=0).T).sum())


def _parting(survival: Survival) -> float:
    """How far the survival times of the paths lie apart [s]."""
    lives = list(survival.survival_s.values())
    return max(lives) - min(lives)

"""The free sub-models of a profile, trained on trips: estimates, and networks with and without context."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.free import FreeMotion
from modelcast.models.free.estimates import map_of
from modelcast.models.learned.features import FeatureMap
from modelcast.models.profile import Profile
from modelcast.runtime.trip.context import ContextSettings, TripContexts
from modelcast.study.routes import ground_cells, routes
from modelcast.study.training.adding import require_new, with_added
from modelcast.study.training.free import (
    EDGES_M,
    HORIZONS_S,
    REPORTS_KNOWN,
    FreeSettings,
    search_estimates,
    searched_features,
    train_free,
)
from modelcast.study.training.free_rows import FreeRows, free_rows, joined_rows
from modelcast.study.training.playback import AS_RECORDED, Playback
from modelcast.study.training.views import PlayedTrip, SenderView, played_trips
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "DEFAULT_VIEWS",
    "FREE_NAMES",
    "FREE_PLAYBACKS",
    "FreeMembers",
    "FreeMembersSettings",
    "add_free",
    "train_free_members",
]

Progress = Callable[[str, int, int], None]
"""Called with what is being done, steps done and steps to do."""

FREE_NAMES = ("free", "free-predictive", "free-context")
"""Sub-models that are trained."""

FREE_PLAYBACKS = (AS_RECORDED, Playback(0.8), Playback(1.25))
"""Ways each trip is played."""

_DEGREE = np.pi / 180.0

DEFAULT_VIEWS = (
    (SenderView("recorded"), 1.0),
    (SenderView("recorded", 0.003), 1.0),
    (SenderView("positions", 0.005), 1.0),
    (SenderView("positions", 0.01), 1.0),
    (SenderView("positions", 0.03), 1.0),
    (SenderView("motion"), 1.0),
    (SenderView("motion", 0.003), 1.0),
    (SenderView("motion", 0.01), 2.0),
    (SenderView("motion", 0.02), 1.0),
    (SenderView("motion", 0.05), 1.0),
    (SenderView("rates", 0.01), 1.0),
    (SenderView("rates", 0.04), 1.0),
    (SenderView("speed", 0.005), 0.5),
    (SenderView("speed", 0.03), 0.5),
    (SenderView("acceleration", 0.01), 0.5),
    (SenderView("acceleration", 0.04), 0.5),
    (SenderView("yaw rate", 0.01), 0.5),
    (SenderView("yaw rate", 0.04), 0.5),
    (SenderView("positions", 0.005, every=2), 0.5),
    (SenderView("motion", 0.01, every=2), 1.0),
    (SenderView("rates", 0.01, every=2), 0.5),
    (SenderView("motion", 0.08, speed_noise_mps=0.1, heading_noise_rad=0.5 * _DEGREE), 1.0),
)
"""Kinds of senders, from none to 8 cm of position noise, and how much each counts."""


@dataclass(frozen=True, slots=True)
class FreeMembersSettings:
    """How the free sub-models are trained.

    Parameters
    ----------
    free
        Networks and search.
    views
        Kinds of senders, and how much each counts.
    playbacks
        Ways each trip is played.
    rows
        Windows of all groups of trips as one kind of sender sees them.
    shortest_s
        So much of a trip must follow a window [s].
    context
        What the sub-model with context is let know in training.

    Raises
    ------
    ValueError
        Where there would be no window.
    """

    free: FreeSettings = field(default_factory=FreeSettings)
    _: KW_ONLY
    views: tuple[tuple[SenderView, float], ...] = DEFAULT_VIEWS
    playbacks: tuple[Playback, ...] = FREE_PLAYBACKS
    rows: int = 24_000
    shortest_s: float = 2.0
    context: ContextSettings = field(default_factory=ContextSettings)

    def __post_init__(self) -> None:
        if self.rows < 1:
            raise ValueError(f"windows of a kind of sender must be at least 1, got {self.rows}")


@dataclass(frozen=True, slots=True)
class FreeMembers:
    """What training gives.

    Parameters
    ----------
    free
        Estimates alone.
    predictive
        A network chooses what is stated.
    context
        The same, which also knows the vehicle ahead and the road.
    record
        How they were trained. Plain values.
    """

    free: FreeMotion
    predictive: FreeMotion
    context: FreeMotion

    record: Mapping[str, Any]

    @property
    def members(self) -> tuple[FreeMotion, ...]:
        """All of them."""
        return self.free, self.predictive, self.context


def train_free_members(
    trips: Sequence[Trajectory], settings: FreeMembersSettings | None = None, *, progress: Progress
) -> FreeMembers:
    """Train the free sub-models.

    Parameters
    ----------
    trips
        As read. Trips of one route are a group; a group counts by the square root of the ground it covers:
        laps of one course teach less than as many minutes of roads.
    settings
        How.
    progress
        Called as the work goes on.

    Raises
    ------
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, are not installed.
    ValueError
        Where no trip has a full window.
    """
    settings = FreeMembersSettings() if settings is None else settings
    free = settings.free
    groups = _groups(trips, settings)

    def cut(features: FeatureMap) -> FreeRows:
        contexts = _contexts(trips, settings.context) if features.context else None
        parts: list[FreeRows] = []
        for group, share in groups:
            parts += free_rows(
                group,
                [(view, weight * share) for view, weight in settings.views],
                features,
                HORIZONS_S,
                rows=max(1, round(settings.rows * share)),
                shortest_s=settings.shortest_s,
                seed=free.seed,
                contexts=contexts,
            )
        if not parts:
            raise ValueError(f"no trip has {settings.shortest_s:g} s after a full window")
        return joined_rows(parts)

    done = 0

    def searched() -> None:
        nonlocal done
        done += 1
        progress("windows", done, len(EDGES_M) * len(REPORTS_KNOWN))

    longest = min(free.searched_lags, free.features.lags)
    features = searched_features(longest)
    estimates = search_estimates(cut(features), features, free, searched)
    alone = FreeMotion(
        estimates,
        limits=free.limits,
        features=map_of(estimates, longest),
        horizon_s=free.horizon_s,
        turn_s=free.turn_s,
    )
    found: list[FreeMotion] = []
    for name, context in zip(FREE_NAMES[1:], (False, True), strict=True):
        own = replace(free, features=replace(free.features, context=context))
        steps = own.descent.reports * len(EDGES_M)

        def told(at: int, name: str = name, steps: int = steps) -> None:
            progress(name, at, steps)

        rows = cut(map_of(estimates, own.features.lags, own.features))
        found.append(train_free(rows, estimates, own, label=name, step=told))
    return FreeMembers(alone, found[0], found[1], _record(trips, settings))


def add_free(
    profile: Profile,
    trips: Sequence[Trajectory],
    settings: FreeMembersSettings | None = None,
    *,
    progress: Progress,
) -> Profile:
    """A profile with the free sub-models added; all else in it stays as it is, its identity too.

    Parameters
    ----------
    profile
        Any profile.
    trips, settings, progress
        As for `train_free_members`.

    Raises
    ------
    MissingExtraError, ValueError
        As for `train_free_members`; also where the profile was itself trained with a sub-model of the name.
    """
    require_new(profile, FREE_NAMES)
    found = train_free_members(trips, settings, progress=progress)
    return with_added(profile, found.members, {"free": found.record}, trips)


def _record(trips: Sequence[Trajectory], settings: FreeMembersSettings) -> dict[str, Any]:
    """What a profile says of the free sub-models' making."""
    free = settings.free
    return {
        "seed": free.seed,
        "trips": len(trips),
        "duration_s": round(sum(trip.duration_s for trip in trips), 3),
        "views": [[view.name, weight] for view, weight in settings.views],
        "playbacks": [how.name or "as recorded" for how in settings.playbacks],
        "windows": settings.rows,
        "hidden": list(free.descent.hidden),
        "steps": free.descent.steps,
        "loss_thresholds_m": list(free.descent.thresholds_m),
        "limits": free.limits.values.tolist(),
    }


def _groups(
    trips: Sequence[Trajectory], settings: FreeMembersSettings
) -> list[tuple[list[PlayedTrip], float]]:
    """Trips of each route, played in all ways, and the route's share."""
    route = routes(trips)
    found: list[tuple[list[PlayedTrip], float]] = []
    for number in range(int(route.max()) + 1):
        own = [trip for trip, at in zip(trips, route, strict=True) if at == number]
        found.append((played_trips(own, settings.playbacks), float(np.sqrt(ground_cells(own)))))
    total = sum(share for _, share in found)
    return [(group, share / total) for group, share in found]


def _contexts(trips: Sequence[Trajectory], settings: ContextSettings) -> dict[str, FloatArray]:
    """Context of every trip, by its identifier."""
    held = TripContexts(trips, settings)
    return {trip.trip_id: held.of(at) for at, trip in enumerate(trips)}

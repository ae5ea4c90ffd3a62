"""Training of free sub-models: windows by the vehicle's noise, and networks that choose what Part I states.

Both make the same thing long: how long the path that receivers coast along holds under a threshold. Windows
are tried one by one for each range of noise, on what the training trips' senders see. A network begins with
these estimates and learns to move them, within limits, to what predicts longest (`survival.survival_cost`).
Half the windows are mirrored, roads are resized at random; of what a network may know of its context, half is
hidden at random, so that it does with either, both or none.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, owned
from modelcast.core.chance import child_generator
from modelcast.models.free import Estimates, FreeMotion, Limits
from modelcast.models.free.estimates import Window, derivative_of, levels_of, map_of
from modelcast.models.free.free_kernels import VALUES, estimates_each
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned.features import LEADER_INPUTS, ROAD_INPUTS, FeatureMap
from modelcast.models.learned.perceptron import Perceptron
from modelcast.study.training.descent import (
    Descent,
    Weights,
    batches,
    descend,
    numerics,
    perceptron_of,
    squashing,
)
from modelcast.study.training.free_rows import FreeRows
from modelcast.study.training.hold_kernels import holds_each
from modelcast.study.training.inputs import varied
from modelcast.study.training.survival import FORGIVEN_S, survival_cost

__all__ = [
    "EDGES_M",
    "FREE_STEPS",
    "HORIZONS_S",
    "NETWORK_FEATURES",
    "REPORTS_KNOWN",
    "FreeSettings",
    "estimated",
    "mean_log_life",
    "search_estimates",
    "searched_features",
    "train_free",
]

EDGES_M = (0.0025, 0.0075, 0.018, np.inf)
"""Ranges of position noise that have estimates and a network of their own, up to each [m]."""

REPORTS_KNOWN = (15, 11, 7, 3, 1, 0)
"""What a vehicle may report beside positions (`Estimates.reports`), the most first; each has estimates of its
own, and serves who reports something that none is for."""

NETWORK_FEATURES = FeatureMap(20, speed_fits=((2, 1), (5, 1), (10, 1), (10, 2), (20, 1), (20, 2)))
"""What a network looks at."""

_STEP_S = 0.1

HORIZONS_S: FloatArray = np.arange(1, 81, dtype=np.float64) * _STEP_S
"""Times at which paths are held against the truth [s]."""

FREE_STEPS = 1000
"""Batches each network is trained on: more fit the training roads and predict no longer on others."""

_LINES = tuple((length, 1) for length in (2, 3, 4, 5, 6, 8, 10))
_PARABOLAS = tuple((length, 2) for length in (4, 6, 8, 10, 12, 16, 20))
_OVERLAP = 1.35
_FEWEST = 200


@dataclass(frozen=True, slots=True)
class FreeSettings:
    """How free sub-models are trained.

    Parameters
    ----------
    features
        What networks look at, beside the polynomials of the estimates.
    limits
        How far networks may move an estimate.
    horizon_s, turn_s
        Trusted horizon, and how long the vehicle goes on turning beyond it [s].
    descent
        Loss and optimiser.
    searched_lags
        Length of the longest polynomial that estimates may have, in tenths of a second.
    searched
        Windows that estimates are searched on, at most, for one range of noise and what is reported.
    seed
        Of all random numbers.
    """

    features: FeatureMap = field(default_factory=lambda: NETWORK_FEATURES)
    _: KW_ONLY
    limits: Limits = field(default_factory=Limits)
    horizon_s: float = 1.5
    turn_s: float = 1.0
    descent: Descent = field(default_factory=lambda: Descent(steps=FREE_STEPS))
    searched_lags: int = 12
    searched: int = 2500
    seed: int = 0


def _within(rows: FreeRows, low_m: float, high_m: float) -> FreeRows:
    """Windows whose noise lies in a range, or a little beyond."""
    inside = (rows.noise_m > low_m / _OVERLAP) & (rows.noise_m <= high_m * _OVERLAP)
    return rows.taken(np.flatnonzero(inside))


def _ranges() -> list[tuple[float, float]]:
    return list(pairwise((0.0, *EDGES_M)))


def estimated(rows: FreeRows, estimates: tuple[Estimates, ...], features: FeatureMap) -> FloatArray:
    """The four values of some windows, as the compiled sender estimates them, (B, 4).

    Parameters
    ----------
    rows
        The windows.
    estimates, features
        Which, and the map that says where they stand.
    """
    out = np.empty((len(rows.inputs), VALUES))
    estimates_each(
        owned(rows.noise_m), owned(rows.reports), owned(rows.inputs), levels_of(estimates, features), out
    )
    return out


def mean_log_life(values: FloatArray, rows: FreeRows, settings: FreeSettings) -> float:
    """Mean logarithm of how long paths hold, over the thresholds.

    Parameters
    ----------
    values
        What Part I states, (B, 4).
    rows
        The windows.
    settings
        Horizons of what receivers coast by, and thresholds.
    """
    receiver = ConstantTurnRateAcceleration().point_functions(_STEP_S)
    along, left = values[:, 0] * np.cos(values[:, 1]), values[:, 0] * np.sin(values[:, 1])
    # A frame whose north is the newest course: east is to the right.
    stated = np.column_stack([-left, along, values[:, 2], -values[:, 3]])
    thresholds_m = np.sort(np.array(settings.descent.thresholds_m))
    held = np.empty((len(stated), thresholds_m.size))
    holds_each(
        receiver.predict_address,
        stated,
        HORIZONS_S,
        receiver.addressed,
        settings.horizon_s,
        settings.turn_s,
        np.stack([-rows.paths_m[..., 1], rows.paths_m[..., 0]], axis=-1),
        rows.known,
        thresholds_m,
        held,
    )
    logs = np.log(_STEP_S * held + FORGIVEN_S).mean(axis=1)
    return float(np.average(logs, weights=rows.shares))


def search_estimates(
    rows: FreeRows, features: FeatureMap, settings: FreeSettings, step: Callable[[], None]
) -> tuple[Estimates, ...]:
    """For each range of noise, and what is reported, the windows whose values predict longest.

    Parameters
    ----------
    rows
        Windows with the inputs of `searched_features`.
    features
        That map.
    settings
        How many windows are tried on, and horizons.
    step
        Called once a range.
    """
    found: list[Estimates] = []
    for reports in REPORTS_KNOWN:
        best = Estimates(np.inf)
        for low_m, high_m in _ranges():
            best = replace(best, up_to_noise_m=high_m, reports=reports)
            inside = (rows.noise_m > low_m / _OVERLAP) & (rows.noise_m <= high_m * _OVERLAP)
            own = np.flatnonzero(inside & (rows.reports == reports))
            if own.size >= _FEWEST:
                rng = child_generator(settings.seed, "search", str(high_m), reports)
                shares = rows.shares[own] / rows.shares[own].sum()
                few = rows.taken(rng.choice(own, min(settings.searched, own.size), replace=False, p=shares))
                best = _searched(best, replace(few, shares=np.ones(len(few.inputs))), features, settings)
            found.append(best)
            step()
    return tuple(found)


def _searched(best: Estimates, rows: FreeRows, features: FeatureMap, settings: FreeSettings) -> Estimates:
    """Change one estimate at a time while that predicts longer, twice through all."""

    def score(one: Estimates) -> float:
        return mean_log_life(estimated(rows, (one,), features), rows, settings)

    reached = score(best)
    for _ in range(2):
        before = reached
        for name in ("acceleration", "yaw_rate", "speed", "course"):
            for window in _candidates(name, features):
                tried = replace(best, **{name: window})
                one = score(tried)
                if one > reached + 1e-6:
                    best, reached = tried, one
        if reached <= before + 1e-6:
            break
    return best


def _candidates(name: str, features: FeatureMap) -> list[Window]:
    """Windows that can give an estimate."""
    columns = ["position", "velocity"] + (["speed"] if name in ("speed", "acceleration") else [])
    found: list[Window] = [("newest", 0, 0)]
    for column in columns:
        needed, fits = derivative_of(name, column), features.fits[column]
        found += [(column, *fit) for fit in fits if fit[1] >= needed and fit[0] <= features.lags]
    return found


def searched_features(lags: int) -> FeatureMap:
    """All polynomials that the search tries.

    Parameters
    ----------
    lags
        Of the longest, in tenths of a second.
    """
    fits = (*_LINES, *_PARABOLAS)
    return FeatureMap(lags, fits, fits, fits)


def train_free(
    rows: FreeRows,
    estimates: tuple[Estimates, ...],
    settings: FreeSettings,
    *,
    label: str,
    step: Callable[[int], None],
) -> FreeMotion:
    """Train the networks of a free sub-model.

    Parameters
    ----------
    rows
        Windows with the inputs of the settings' map and the polynomials of the estimates.
    estimates
        Where the networks begin.
    settings
        How.
    label
        Name of the sub-model.
    step
        Called with the number of reports so far, of `Descent.reports` times the ranges of noise.

    Raises
    ------
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, are not installed.
    """
    features = map_of(estimates, settings.features.lags, settings.features)
    networks: list[Perceptron] = []
    for at, (low_m, high_m) in enumerate(_ranges()):
        own = _within(rows, low_m, high_m)
        if not len(own.inputs):
            continue

        def told(done: int, at: int = at) -> None:
            step(at * settings.descent.reports + done)

        centre, width = squashing(own.inputs, features.mirrors)
        begun = estimated(own, estimates, features)
        lesson = _Lesson(own, begun, features, f"{label} {high_m}", centre, width)
        weights = _train_network(lesson, settings, told)
        networks.append(perceptron_of(weights, centre, width, up_to_noise_m=high_m))
    if networks and not np.isinf(networks[-1].up_to_noise_m):
        networks[-1] = replace(networks[-1], up_to_noise_m=np.inf)
    return FreeMotion(
        estimates,
        tuple(networks),
        limits=settings.limits,
        features=features,
        horizon_s=settings.horizon_s,
        turn_s=settings.turn_s,
        label=label,
    )


@dataclass(frozen=True, slots=True)
class _Lesson:
    """What one network is to learn: windows, where it begins (B, 4), and how inputs are squashed (I,)."""

    rows: FreeRows
    begun: FloatArray
    features: FeatureMap
    key: str
    centre: FloatArray
    width: FloatArray


def _train_network(lesson: _Lesson, settings: FreeSettings, step: Callable[[int], None]) -> Weights:
    _, jnp, _ = numerics()
    how, limits = settings.descent, settings.limits.values
    steps_s: FloatArray = np.diff(HORIZONS_S, prepend=0.0).astype(np.float64)
    between_s = HORIZONS_S - 0.5 * steps_s
    speeding_s = np.minimum(between_s, settings.horizon_s)
    turning_s = np.minimum(between_s, settings.horizon_s + settings.turn_s)

    def cost(outputs: Any, begun: Any, paths_m: Any, known: Any) -> Any:
        stated = begun + limits * jnp.tanh(outputs)
        speed = jnp.maximum(jnp.maximum(stated[:, :1], 0.0) + stated[:, 2:3] * speeding_s, 0.0)
        course = stated[:, 1:2] + stated[:, 3:4] * turning_s
        moved = jnp.stack([speed * jnp.cos(course), speed * jnp.sin(course)], axis=-1)
        off_m = jnp.cumsum(moved * steps_s[:, None], axis=1) - paths_m
        return survival_cost(off_m, known, steps_s, thresholds_m=how.thresholds_m, softness=how.softness)

    return descend(
        cost,
        _batches(lesson, settings),
        how,
        sizes=(lesson.features.inputs, VALUES),
        seed=settings.seed,
        key=lesson.key,
        step=step,
    )


def _batches(lesson: _Lesson, settings: FreeSettings) -> Iterator[tuple[FloatArray, Sequence[FloatArray]]]:
    """Squashed inputs, estimates, paths and what is known, each batch varied."""
    rows, features, how = lesson.rows, lesson.features, settings.descent
    rng = child_generator(settings.seed, "batches", lesson.key)
    for chosen in batches(rows.shares / rows.shares.sum(), how, rng):
        inputs, turned, size = varied(rows.inputs[chosen], features, how.resize, rng)
        if features.context:
            _hide(inputs, features, rng)
        begun = lesson.begun[chosen] * np.column_stack([size, turned, size, turned])
        paths_m = rows.paths_m[chosen] * size[:, None, None]
        paths_m[..., 1] *= turned[:, None]
        squashed = np.arcsinh((inputs - lesson.centre) / lesson.width)
        yield squashed, [begun, paths_m, rows.known[chosen].astype(np.float64)]


def _hide(inputs: FloatArray, features: FeatureMap, rng: np.random.Generator) -> None:
    """Take the vehicle ahead from a quarter of the windows, and the road from another."""
    flags = features.inputs - features.fixed
    first = flags - LEADER_INPUTS - ROAD_INPUTS
    road = first + LEADER_INPUTS
    for columns, flag in ((slice(first, road), flags), (slice(road, flags), flags + 1)):
        hidden = rng.random(len(inputs)) < 0.25
        inputs[hidden, columns] = 0.0
        inputs[hidden, flag] = 0.0

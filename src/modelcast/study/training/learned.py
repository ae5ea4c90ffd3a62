"""Training of the learned sub-model: windows as many kinds of senders see them, and what came next.

The network learns what constant turn rate and acceleration gets wrong: the difference to the true path over
the next seconds, in the frame of the newest velocity, as coefficients of a polynomial against time. What it
makes small is not the error but the number of messages: the loss is the logarithm of the time that the path
holds under a threshold, softened (`survival.survival_cost`). An error that no threshold forgives
costs nothing more for being larger. Every trip is also played slower, faster and backwards (`playback`), half
the windows are mirrored, every road is resized at random, and every
network sees one range of position noise: a network for millimetres and one for decimetres have little in
common.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned.features import LAG_STEP_S, SHORTEST_SPAN, FeatureMap
from modelcast.models.learned.learned_kernels import FRAME_MPS
from modelcast.models.learned.learned_trajectory import LearnedTrajectory
from modelcast.models.learned.perceptron import Perceptron
from modelcast.models.point_kernels import (
    ACCELERATION,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)
from modelcast.station.sensing.sensing import position_noise_m, sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.training.descent import (
    Descent,
    batches,
    descend,
    numerics,
    perceptron_of,
    squashing,
)
from modelcast.study.training.inputs import varied, window_inputs
from modelcast.study.training.playback import DEFAULT_PLAYBACKS, Playback
from modelcast.study.training.survival import survival_cost
from modelcast.study.training.views import PlayedTrip, SenderView, Viewed, played_trips, view_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["DEFAULT_STAGES", "LearnedSettings", "NoiseStage", "train_learned"]

Progress = Callable[[int, int], None]

_DEGREE = np.pi / 180.0


@dataclass(frozen=True, slots=True)
class NoiseStage:
    """One network: which noise it serves, and which senders it is trained on.

    Parameters
    ----------
    noise_range_m
        The window's position noise from which and up to which it serves [m].
    views
        Kinds of senders; of each, only windows in that range (and a little beyond) are learned from.
    """

    noise_range_m: tuple[float, float]
    views: tuple[SenderView, ...]


def _poor(columns: str, position_noise_m: float) -> SenderView:
    """Return a view with a worse speed and heading."""
    return SenderView(columns, position_noise_m, speed_noise_mps=0.1, heading_noise_rad=0.5 * _DEGREE)


DEFAULT_STAGES = (
    NoiseStage((0.0, 0.003), (SenderView("recorded"), SenderView("motion", 0.002))),
    NoiseStage(
        (0.003, 0.025),
        (
            SenderView("recorded"),
            SenderView("recorded", 0.01),
            SenderView("motion", 0.01),
            SenderView("motion", 0.02),
            SenderView("rates", 0.01),
            SenderView("motion", 0.005),
            SenderView("positions", 0.01),
        ),
    ),
    NoiseStage(
        (0.025, 0.08),
        (
            SenderView("motion", 0.03),
            SenderView("motion", 0.05),
            _poor("motion", 0.05),
            SenderView("rates", 0.05),
            SenderView("positions", 0.05),
        ),
    ),
    NoiseStage(
        (0.08, np.inf),
        (
            SenderView("motion", 0.1),
            _poor("rates", 0.1),
            SenderView("motion", 0.2),
            _poor("motion", 0.4),
            SenderView("positions", 0.1),
            SenderView("positions", 0.3),
        ),
    ),
)
"""Four networks: millimetres, a centimetre, five, decimetres."""

_OVERLAP = 1.5
"""A network also learns from windows whose noise is beyond its range by this factor."""


@dataclass(frozen=True, slots=True)
class LearnedSettings:
    """How the networks are trained.

    Parameters
    ----------
    stages
        The networks, by rising noise.
    playbacks
        Ways each trip is played.
    coefficients
        Coefficients of the correction on each axis.
    descent
        Loss and optimiser.
    rows
        Windows drawn for one network, at most.
    longest_s
        How far ahead the path is learned [s].
    horizon_s, turn_s
        Trusted horizon of the sub-model, and how long the car goes on turning beyond it [s].
    seed
        Of noise, mirrors, first weights and order.
    features
        What the networks look at.
    """

    stages: tuple[NoiseStage, ...] = DEFAULT_STAGES
    _: KW_ONLY
    playbacks: tuple[Playback, ...] = DEFAULT_PLAYBACKS
    coefficients: int = 3
    rows: int = 150_000
    longest_s: float = 6.0
    horizon_s: float = 3.0
    turn_s: float = 2.0
    seed: int = 0
    descent: Descent = field(default_factory=Descent)
    features: FeatureMap = field(default_factory=FeatureMap)


@dataclass(frozen=True, slots=True)
class _Rows:
    """Inputs (B, I) and errors of the kinematic prediction along and to the left, (B, H, 2) [m]."""

    inputs: FloatArray
    errors_m: FloatArray


def train_learned(
    trips: Sequence[Trajectory],
    settings: LearnedSettings | None = None,
    *,
    progress: Progress | None = None,
) -> LearnedTrajectory:
    """Train the networks of the learned sub-model.

    Parameters
    ----------
    trips
        As read; every network needs a view of at least one of them.
    settings
        How.
    progress
        Called with passes over the data done and all.

    Raises
    ------
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, are not installed.
    ValueError
        Where a network has no window to learn from.
    """
    settings = LearnedSettings() if settings is None else settings
    horizons_s = np.concatenate([np.arange(0.1, 0.95, 0.1), np.arange(1.0, settings.longest_s + 0.01, 0.2)])
    reports = settings.descent.reports
    played = played_trips(trips, settings.playbacks)
    networks: list[Perceptron] = []
    for at, stage in enumerate(settings.stages):
        rows = _stage_rows(played, stage, horizons_s, settings)

        def step(done: int, at: int = at) -> None:
            if progress is not None:
                progress(at * reports + done, reports * len(settings.stages))

        networks.append(_train_network(rows, stage.noise_range_m[1], horizons_s, settings, step))
    return LearnedTrajectory(
        tuple(networks),
        settings.coefficients,
        time_scale_s=settings.longest_s,
        lags=settings.features.lags,
        horizon_s=settings.horizon_s,
        turn_s=settings.turn_s,
    )


def _stage_rows(
    played: Sequence[PlayedTrip], stage: NoiseStage, horizons_s: FloatArray, settings: LearnedSettings
) -> _Rows:
    found: list[_Rows] = []
    share = settings.rows // len(stage.views)
    for view in stage.views:
        viewed = list(view_trips(played, view, seed=settings.seed))
        ends = [_ends(one, settings, stage.noise_range_m) for one in viewed]
        total = sum(rows.size for rows in ends)
        rng = child_generator(settings.seed, "rows", view.name)
        for one, rows in zip(viewed, ends, strict=True):
            count = min(rows.size, round(share * rows.size / total)) if total else 0
            if count:
                chosen = np.sort(rng.permutation(rows)[:count])
                found.append(_cut(one, chosen, horizons_s, settings))
    if not found:
        views = ", ".join(view.name for view in stage.views)
        raise ValueError(f"no trip has {settings.longest_s:g} s after a full window as seen by: {views}")
    return _Rows(
        np.concatenate([rows.inputs for rows in found]), np.concatenate([rows.errors_m for rows in found])
    )


def _ends(viewed: Viewed, settings: LearnedSettings, noises_m: tuple[float, float]) -> IntArray:
    """Samples with a noise in this range, a full window behind and the whole path ahead."""
    trip = viewed.seen
    last = np.repeat(trip.segments[1:] - 1, np.diff(trip.segments))
    enough = np.arange(len(trip)) - trip.segment_start >= settings.features.lags
    enough &= trip.dt_s >= LAG_STEP_S * SHORTEST_SPAN  # else so many samples do not reach back far enough
    noise_m = position_noise_m(trip)
    enough &= (noise_m >= noises_m[0] / _OVERLAP) & (noise_m <= noises_m[1] * _OVERLAP)
    return np.flatnonzero(enough & (trip.t_s[last] - trip.t_s >= settings.longest_s))


def _cut(viewed: Viewed, rows: IntArray, horizons_s: FloatArray, settings: LearnedSettings) -> _Rows:
    seen, truth = viewed.seen, viewed.truth
    samples = sample_matrix(seen, velocity_estimator_for(seen))
    features = settings.features
    inputs = window_inputs(samples, rows, features.lags + 1, features, seen.dt_s)
    at_s = seen.t_s[rows][:, None] + horizons_s
    path = np.stack([np.interp(at_s, truth.t_s, truth.position_m[:, axis]) for axis in range(2)], axis=-1)
    newest = samples[rows]
    kinematic = newest[:, [VELOCITY_EAST, VELOCITY_NORTH, ACCELERATION, YAW_RATE]]
    expected = ConstantTurnRateAcceleration().predict(kinematic, horizons_s, dt_s=seen.dt_s)
    missed = path - newest[:, None, :2] - expected
    east, north = _course(newest[:, VELOCITY_EAST], newest[:, VELOCITY_NORTH])
    along = missed[..., 0] * east[:, None] + missed[..., 1] * north[:, None]
    left = missed[..., 1] * east[:, None] - missed[..., 0] * north[:, None]
    return _Rows(inputs, np.stack([along, left], axis=-1))


def _course(east: FloatArray, north: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit course as the compiled frame has it: north for a car that stands."""
    speed = np.hypot(east, north)
    moves = speed >= FRAME_MPS
    safe = np.where(moves, speed, 1.0)
    return np.where(moves, east / safe, 0.0), np.where(moves, north / safe, 1.0)


def error_scale_m(horizons_s: FloatArray) -> FloatArray:
    """Error at each horizon that counts alike [m]; it makes the basis of the coefficients, not the loss."""
    return 0.1 + 0.1 * horizons_s + 0.1 * horizons_s**2


def _train_network(
    rows: _Rows,
    up_to_noise_m: float,
    horizons_s: FloatArray,
    settings: LearnedSettings,
    step: Callable[[int], None],
) -> Perceptron:
    _, jnp, _ = numerics()
    how, count = settings.descent, settings.coefficients
    centre, width = squashing(rows.inputs, settings.features.mirrors)
    powers = np.vander(horizons_s / settings.longest_s, count, increasing=True)
    _, r = np.linalg.qr(powers / error_scale_m(horizons_s)[:, None])
    # The network's outputs are coefficients in an orthonormal basis; those of the powers follow from them.
    basis = powers @ np.linalg.inv(r)
    steps_s = np.diff(horizons_s, prepend=0.0)

    def cost(outputs: Any, errors_m: Any) -> Any:
        paths = [outputs[:, axis * count : (axis + 1) * count] @ basis.T for axis in range(2)]
        off_m = jnp.stack(paths, axis=-1) - errors_m
        known = jnp.ones(off_m.shape[:2])
        return survival_cost(off_m, known, steps_s, thresholds_m=how.thresholds_m, softness=how.softness)

    weights = descend(
        cost,
        _batches(rows, settings, str(up_to_noise_m), centre, width),
        how,
        sizes=(settings.features.inputs, 2 * count),
        seed=settings.seed,
        key=str(up_to_noise_m),
        step=step,
    )
    back = np.kron(np.eye(2), np.linalg.inv(r)).T
    weights = weights._replace(weights_3=weights.weights_3 @ back, bias_3=weights.bias_3 @ back)
    return perceptron_of(weights, centre, width, up_to_noise_m=up_to_noise_m)


def _batches(
    rows: _Rows, settings: LearnedSettings, key: str, centre: FloatArray, width: FloatArray
) -> Iterator[tuple[FloatArray, Sequence[FloatArray]]]:
    """Squashed inputs and errors; half the windows mirrored, each on a road somewhat larger or smaller."""
    rng = child_generator(settings.seed, "batches", key)
    how, features = settings.descent, settings.features
    shares = np.full(len(rows.inputs), 1.0 / len(rows.inputs))
    for chosen in batches(shares, how, rng):
        inputs, turned, size = varied(rows.inputs[chosen], features, how.resize, rng)
        errors_m = rows.errors_m[chosen] * size[:, None, None]
        errors_m[..., 1] *= turned[:, None]
        yield np.arcsinh((inputs - centre) / width), [errors_m]

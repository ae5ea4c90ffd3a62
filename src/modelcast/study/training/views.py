"""What senders may see of a training trip: receivers differ, and a learned sub-model must serve them all.

Every view makes, from a trip's truth, an input as one kind of sender would have it: positions alone or with
speed and heading, with or without acceleration and yaw rate, at a stated noise, at the trip's own rate or
half of it. Trips are few, so each may also be played otherwise: slower or faster on a road as much
larger or smaller that the accelerations stay, or backwards (`playback`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.study.training.playback import AS_RECORDED, Playback, play
from modelcast.trips.conditioning import condition
from modelcast.trips.inspection import inspect
from modelcast.trips.trajectory import Trajectory
from modelcast.world.sensors import SensorModel, sense, with_motion

__all__ = ["PlayedTrip", "SenderView", "Viewed", "played_trips", "view_trips"]

_FASTEST_TURN_RADPS = 1.0

_MOVING = {
    "speed": ("heading_rad", "acceleration_mps2", "yaw_rate_radps"),
    "motion": ("acceleration_mps2", "yaw_rate_radps"),
    "acceleration": ("yaw_rate_radps",),
    "yaw rate": ("acceleration_mps2",),
    "rates": (),
}
"""Columns with a speed, and what such a sender does not see."""


@dataclass(frozen=True, slots=True)
class SenderView:
    """One kind of sender.

    Parameters
    ----------
    columns
        ``recorded``: what the log holds, noise added to the positions. ``positions``: nothing but positions.
        ``speed``: speed too. ``motion``: speed and heading too; ``acceleration``, ``yaw rate`` and ``rates``:
        one of these or both as well.
    position_noise_m
        White noise added to each axis [m].
    speed_noise_mps, heading_noise_rad
        Of speed and heading, where it has them.
    every
        Every so many samples are kept.

    Raises
    ------
    ValueError
        Where the columns are unknown or ``every`` is under 1.
    """

    columns: str
    position_noise_m: float = 0.0
    _: KW_ONLY
    speed_noise_mps: float = 0.05
    heading_noise_rad: float = np.deg2rad(0.2)
    every: int = 1

    def __post_init__(self) -> None:
        if self.columns not in ("recorded", "positions", *_MOVING):
            known = ", ".join(("recorded", "positions", *_MOVING))
            raise ValueError(f"columns must be one of {known}, got {self.columns!r}")
        if self.every < 1:
            raise ValueError(f"every must be at least 1, got {self.every}")

    @property
    def name(self) -> str:
        """As in the training record."""
        thinned = "" if self.every == 1 else f" 1/{self.every}"
        found = f"{self.columns} {1000 * self.position_noise_m:g} mm{thinned}"
        if self.columns in _MOVING:
            found += f", {self.speed_noise_mps:g} m/s, {np.rad2deg(self.heading_noise_rad):.2g} deg"
        return found


@dataclass(frozen=True, slots=True)
class Viewed:
    """Truth and what a sender sees, by sample, and which samples of the played trip these are."""

    truth: Trajectory
    seen: Trajectory
    kept: IntArray


@dataclass(frozen=True, slots=True)
class PlayedTrip:
    """A trip's truth, played one way, and whether its recording was on a coarse grid or held values."""

    truth: Trajectory
    coarse: bool


def played_trips(
    trips: Sequence[Trajectory], playbacks: Sequence[Playback] = (AS_RECORDED,)
) -> list[PlayedTrip]:
    """Condition the trips that need it, and play each in all ways: the same for every view.

    Parameters
    ----------
    trips
        As read.
    playbacks
        Ways of playing a trip.
    """
    found: list[PlayedTrip] = []
    for trip in trips:
        coarse = inspect(trip).recommended_protocol == "sensor"
        truth = condition(trip)[0] if coarse else trip
        found += [PlayedTrip(play(truth, how), coarse) for how in playbacks]
    return found


def view_trips(played: Sequence[PlayedTrip], view: SenderView, *, seed: int) -> Iterator[Viewed]:
    """Yield every trip as that sender sees it.

    A trip on a coarse grid or with held values has been conditioned, and has no ``recorded`` view: judged
    against itself it would teach the recorder's errors.

    Parameters
    ----------
    played
        As `played_trips` gives them.
    view
        The kind of sender.
    seed
        Of the noise.
    """
    for one in played:
        if one.coarse and view.columns == "recorded":
            continue
        truth, kept = _thinned(one.truth, view.every)
        rng = child_generator(seed, truth.trip_id, "view", view.name)
        yield Viewed(truth, _seen(truth, view, rng), kept)


def _seen(truth: Trajectory, view: SenderView, rng: np.random.Generator) -> Trajectory:
    noisy_m = truth.position_m + view.position_noise_m * rng.standard_normal(truth.position_m.shape)
    if view.columns == "recorded":
        return replace(truth, position_m=noisy_m)
    if view.columns == "positions":
        bare = replace(truth, speed_mps=None, heading_rad=None, acceleration_mps2=None, yaw_rate_radps=None)
        return replace(bare, position_m=noisy_m)
    sensor = SensorModel(
        position_noise_m=view.position_noise_m,
        speed_noise_mps=view.speed_noise_mps,
        heading_noise_rad=view.heading_noise_rad,
    )
    unseen = dict.fromkeys(_MOVING[view.columns])
    return replace(sense(_with_rates(with_motion(truth)), sensor, rng), **unseen)


def _with_rates(trip: Trajectory) -> Trajectory:
    """Return the trip with acceleration and yaw rate, by differences where it lacks them."""
    speed, heading = trip.speed_mps, trip.heading_rad
    if speed is None or heading is None:
        raise ValueError(f"{trip.trip_id}: no speed or heading to take rates from")
    along = _slope(trip, speed) if trip.acceleration_mps2 is None else trip.acceleration_mps2
    turn = _slope(trip, np.unwrap(heading)) if trip.yaw_rate_radps is None else trip.yaw_rate_radps
    turn = np.clip(turn, -_FASTEST_TURN_RADPS, _FASTEST_TURN_RADPS)
    return replace(trip, acceleration_mps2=along, yaw_rate_radps=turn)


def _slope(trip: Trajectory, column: FloatArray) -> FloatArray:
    slopes = np.zeros_like(column)
    for a, b in pairwise(trip.segments):
        if b - a > 1:
            slopes[a:b] = np.gradient(column[a:b], trip.t_s[a:b])
    return slopes


def _thinned(trip: Trajectory, every: int) -> tuple[Trajectory, IntArray]:
    """Every so many samples of each part, and which."""
    if every == 1:
        return trip, np.arange(len(trip))
    kept: list[IntArray] = [np.arange(a, b, every) for a, b in pairwise(trip.segments)]
    rows = np.concatenate(kept)
    bounds = np.cumsum([0] + [part.size for part in kept])

    def maybe(column: FloatArray | None) -> FloatArray | None:
        return None if column is None else column[rows]

    found = replace(
        trip,
        t_s=trip.t_s[rows],
        position_m=trip.position_m[rows],
        segments=bounds,
        dt_s=every * trip.dt_s,
        speed_mps=maybe(trip.speed_mps),
        heading_rad=maybe(trip.heading_rad),
        acceleration_mps2=maybe(trip.acceleration_mps2),
        yaw_rate_radps=maybe(trip.yaw_rate_radps),
        up_m=maybe(trip.up_m),
    )
    return found, rows

"""Recorded trips played otherwise: few recordings, and more kinds of road to learn from.

Played slower by a factor s on a road s² times as large, a trip keeps all its accelerations and the shapes of
its curves; what changes is how long each of them lasts. Played backwards, braking becomes speeding up, and
every curve opens as it closed.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.core.scientific import scientific
from modelcast.trips.trajectory import Trajectory

__all__ = ["AS_RECORDED", "DEFAULT_PLAYBACKS", "Playback", "play"]

_SLACK = 1e-6
"""A last sample that falls this share of a step beyond the end is kept."""


@dataclass(frozen=True, slots=True)
class Playback:
    """How a trip is played.

    Parameters
    ----------
    stretch
        How much longer everything lasts; lengths grow with its square.
    backwards
        Whether time runs backwards.

    Raises
    ------
    ValueError
        Where the stretch is not positive and finite.
    """

    stretch: float = 1.0
    backwards: bool = False

    def __post_init__(self) -> None:
        if not (np.isfinite(self.stretch) and self.stretch > 0.0):
            raise ValueError(f"stretch must be positive and finite, got {self.stretch}")

    @property
    def name(self) -> str:
        """As in the training record; empty for a trip as it was recorded."""
        stretched = "" if self.stretch == 1.0 else f"x{self.stretch:g}"
        return " ".join(part for part in (stretched, "backwards" if self.backwards else "") if part)


AS_RECORDED = Playback()

DEFAULT_PLAYBACKS = (
    AS_RECORDED,
    *(Playback(stretch) for stretch in (0.65, 0.8, 1.25, 1.5)),
    *(Playback(stretch, backwards=True) for stretch in (0.8, 1.0, 1.25)),
)
"""Decision 019 has what they gain."""


def play(trip: Trajectory, how: Playback) -> Trajectory:
    """Return the trip played that way, at its own sampling interval, without accelerations and height.

    Parameters
    ----------
    trip
        As recorded; returned as it is where nothing is asked.
    how
        Stretch and direction.

    Examples
    --------
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t_s = 0.1 * np.arange(101)
    >>> braking = np.column_stack([20.0 * t_s - t_s**2, np.zeros(101)])
    >>> slower = play(build_trajectory("made/1", t_s, braking), Playback(2.0))
    >>> len(slower), slower.position_m[-1].round(6).tolist()
    (201, [400.0, 0.0])
    """
    if how == AS_RECORDED:
        return trip
    parts = [_part(trip, slice(a, b), how) for a, b in pairwise(trip.segments)]
    if how.backwards:
        parts.reverse()
    names = parts[0].keys()
    joined = {name: np.concatenate([part[name] for part in parts]) for name in names}
    return replace(
        trip,
        trip_id=f"{trip.trip_id} {how.name}",
        segments=np.cumsum([0] + [part["t_s"].size for part in parts]),
        t_s=joined["t_s"] - joined["t_s"][0],
        position_m=joined["position_m"],
        speed_mps=joined.get("speed_mps"),
        heading_rad=joined.get("heading_rad"),
        acceleration_mps2=None,
        yaw_rate_radps=None,
        up_m=None,
        origin=None,
    )


def _part(trip: Trajectory, rows: slice, how: Playback) -> dict[str, FloatArray]:
    """One gapless part, sampled anew."""
    order = slice(None, None, -1) if how.backwards else slice(None)
    at_s = (-trip.t_s if how.backwards else trip.t_s)[rows][order] * how.stretch
    count = int((at_s[-1] - at_s[0]) / trip.dt_s + _SLACK) + 1
    t_s = at_s[0] + trip.dt_s * np.arange(count)
    position_m = trip.position_m[rows][order] * how.stretch**2
    if count > 1:
        interpolate = scientific("interpolate", "training on trips played at another speed", "train")
        position_m = interpolate.CubicSpline(at_s, position_m)(t_s)
    found = {"t_s": t_s, "position_m": position_m[:count]}
    if trip.speed_mps is not None:
        found["speed_mps"] = np.interp(t_s, at_s, trip.speed_mps[rows][order] * how.stretch)
    if trip.heading_rad is not None:
        turned_rad: FloatArray = np.unwrap(trip.heading_rad[rows])[order] + (np.pi if how.backwards else 0.0)
        heading_rad = np.asarray(np.interp(t_s, at_s, turned_rad), dtype=np.float64)
        found["heading_rad"] = wrap_angle_rad(heading_rad)
    return found

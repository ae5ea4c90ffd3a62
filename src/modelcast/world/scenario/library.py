"""Real trips laid on a road: how people drive, at a density that was never recorded.

Every vehicle takes a stretch of a recorded trip, begun at a random sample, and drives it along a straight
lane: the trip's speed along its path, and its small lateral motion. Where the stretch or the road ends, a new
vehicle with a new stretch takes the slot. Vehicles do not see each other: they may pass through one another,
which matters for collisions and warnings and not for tracking or for the radio.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.core.scientific import scientific
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame
from modelcast.world.scenario.bounds import check_positive, vehicle_count
from modelcast.world.sensors import with_motion

__all__ = ["TripRoad", "TripRoadState"]

_SMOOTH_S = 3.0
_FINE_S = 0.3  # takes the receiver's noise off
_SLOW_MPS = 2.0
_WIDEST_M = 1.0
_LEAST_S = 10.0


@dataclass(frozen=True, slots=True)
class TripRoadState:
    """A road of real trips at one instant.

    Parameters
    ----------
    number
        Steps since t = 0.
    sample
        Which sample of the library each vehicle is at, (V,).
    offset_m
        Added to the library's distance to give the place along the road, (V,) [m].
    lane
        Lanes counted over both directions, (V,).
    vehicle_id
        (V,).
    next_id
        The next identifier to give out.
    rng
        The run's generator.
    """

    number: int
    sample: IntArray
    _: KW_ONLY
    offset_m: FloatArray
    lane: IntArray
    vehicle_id: IntArray
    next_id: int
    rng: np.random.Generator


@dataclass(frozen=True, slots=True)
class TripRoad(AbstractScenario[TripRoadState]):
    """A straight road on which recorded trips drive.

    Speed is the trip's own, smoothed over 0.3 s. The lateral motion is the trip's deviation from its own path
    smoothed over 3 s (Gaussian windows), drawn in where its root mean square over some seconds nears 1 m: a
    bend of the recorded road shows as a sway of about a metre.

    Parameters
    ----------
    trips
        Recorded trips with a sample every `STEP_S`; gapless parts under 10 s are not used.
    length_m
        Length of the road [m].
    density_per_km
        Vehicles a kilometre of road, both directions together [1/km].
    lanes
        Lanes in each direction; the second half of all lanes leads the other way.
    lane_width_m, median_m
        Width of a lane, and between the innermost lanes of the two directions [m].
    vehicle_length_m
        Length of the vehicles [m].

    Raises
    ------
    ValueError
        Where no trip can be used, or a value has the wrong sign.
    """

    trips: Sequence[Trajectory]
    length_m: float = 2000.0
    density_per_km: float = 60.0
    _: KW_ONLY
    lanes: int = 3
    lane_width_m: float = 3.5
    median_m: float = 4.0
    vehicle_length_m: float = 4.5
    _library: FloatArray = field(init=False, repr=False, compare=False)
    _left: IntArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_positive(self, "length_m", "density_per_km", "lane_width_m", "vehicle_length_m")
        if self.lanes < 1 or not self.median_m >= 0.0 or self.slots < 1:
            raise ValueError(
                f"lanes and the number of vehicles must be at least 1 and median_m at least 0, got "
                f"{self.lanes}, {self.slots} and {self.median_m}"
            )
        parts = [part for trip in self.trips for part in _parts(trip)]
        if not parts:
            raise ValueError(
                f"no gapless part of {_LEAST_S} s at {STEP_S} s a sample in {len(self.trips)} trips"
            )
        library = np.concatenate(parts, axis=1)
        left: list[IntArray] = [np.arange(part.shape[1] - 1, -1, -1, dtype=np.int64) for part in parts]
        object.__setattr__(self, "_library", library)
        object.__setattr__(self, "_left", np.concatenate(left))

    @property
    def slots(self) -> int:
        """Number of vehicles V."""
        return vehicle_count(self.density_per_km, self.length_m)

    def init(self, rng: np.random.Generator) -> TripRoadState:
        """Lay a random stretch at a random place of a random lane for every vehicle."""
        vehicles = self.slots
        sample = self._drawn(vehicles, rng)
        place = (np.arange(vehicles) + rng.random(vehicles)) * self.length_m / vehicles
        return TripRoadState(
            0,
            sample,
            offset_m=place - self._library[0, sample],
            lane=rng.integers(0, 2 * self.lanes, vehicles),
            vehicle_id=np.arange(vehicles, dtype=np.int64),
            next_id=vehicles,
            rng=rng,
        )

    def step(self, state: TripRoadState) -> TripRoadState:
        """Return the state a step later."""
        sample = state.sample + 1
        ended = self._left[state.sample] == 0
        sample[ended] = self._drawn(int(ended.sum()), state.rng)
        before = self._library[0, state.sample] + state.offset_m
        offset = np.where(ended, before - self._library[0, sample], state.offset_m)
        over = self._library[0, sample] + offset >= self.length_m
        offset = np.where(over, offset - self.length_m, offset)
        new = np.flatnonzero(ended | over)
        identity = state.vehicle_id.copy()
        identity[new] = state.next_id + np.arange(new.size)
        return replace(
            state,
            number=state.number + 1,
            sample=sample,
            offset_m=offset,
            vehicle_id=identity,
            next_id=state.next_id + int(new.size),
        )

    def frame(self, state: TripRoadState) -> FleetFrame:
        """Return the fleet; every slot is active."""
        along, left, speed, course, acceleration, yaw_rate = self._rows(state)
        place = along + state.offset_m
        back = state.lane >= self.lanes
        lane = state.lane % self.lanes
        centre = 0.5 * self.median_m + (self.lanes - 0.5 - lane) * self.lane_width_m
        sign = np.where(back, -1.0, 1.0)
        east: FloatArray = np.where(back, self.length_m - place, place)
        north = sign * (left - centre)
        heading = wrap_angle_rad(sign * 0.5 * np.pi - course)
        return FleetFrame(
            round(state.number * STEP_S, 6),
            np.stack([east, north], axis=1),
            speed_mps=speed,
            heading_rad=heading,
            acceleration_mps2=acceleration,
            yaw_rate_radps=-yaw_rate,
            length_m=np.full(self.slots, self.vehicle_length_m),
            vehicle_id=state.vehicle_id,
            active=np.ones(self.slots, dtype=np.bool_),
        )

    def _rows(self, state: TripRoadState) -> tuple[FloatArray, ...]:
        """Return the library's rows at the vehicles' samples."""
        rows: FloatArray = self._library[:, state.sample]
        return tuple(rows)

    def _drawn(self, count: int, rng: np.random.Generator) -> IntArray:
        """Return samples of the library to begin at, none of them the last of its part."""
        return rng.choice(np.flatnonzero(self._left > 0), count)


def _parts(trip: Trajectory) -> list[FloatArray]:
    """Return a trip's gapless parts as they drive along a lane, (6, N) each.

    Rows: distance [m], offset to the left [m], speed, course from the lane [rad, anticlockwise],
    acceleration, yaw rate (anticlockwise).
    """
    if abs(trip.dt_s - STEP_S) > 0.01 * STEP_S:
        return []
    known = with_motion(trip).speed_mps
    speed: FloatArray = np.zeros(len(trip)) if known is None else known
    return [
        _along_lane(trip.position_m[a:b], speed[a:b])
        for a, b in zip(trip.segments[:-1], trip.segments[1:], strict=True)
        if (b - a) * STEP_S >= _LEAST_S
    ]


def _along_lane(position_m: FloatArray, speed_mps: FloatArray) -> FloatArray:
    """Return one part's rows; speed, course, acceleration and yaw rate are derivatives of the first two."""
    pace = _blurred(np.maximum(speed_mps, 0.0), _FINE_S)
    fine = _smoothed(position_m, _FINE_S)
    smooth = _smoothed(position_m, _SMOOTH_S)
    forward = np.gradient(smooth, STEP_S, axis=0)
    off = fine - smooth
    left = (forward[:, 0] * off[:, 1] - forward[:, 1] * off[:, 0]) / np.maximum(
        np.hypot(forward[:, 0], forward[:, 1]), _SLOW_MPS
    )
    spread = _blurred(left**2, _SMOOTH_S)
    left = left / np.sqrt(1.0 + spread / _WIDEST_M**2)
    # below _SLOW_MPS a car moves sideways less and less: its course stays bounded down to standstill
    slope = np.gradient(left, STEP_S) / np.maximum(pace, _SLOW_MPS)
    course = np.arctan(slope)
    along, left = _integral(pace), left[0] + _integral(pace * slope)
    speed = pace * np.sqrt(1.0 + slope**2)
    return np.stack([along, left, speed, course, np.gradient(speed, STEP_S), np.gradient(course, STEP_S)])


def _integral(rate: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], (0.5 * STEP_S * (rate[1:] + rate[:-1])).cumsum()])


def _smoothed(position_m: FloatArray, std_s: float) -> FloatArray:
    """Return positions smoothed in time, reflected in their ends so that a straight line stays one."""
    reach = min(round(4.0 * std_s / STEP_S), len(position_m) - 1)
    before = 2.0 * position_m[0] - position_m[reach:0:-1]
    after = 2.0 * position_m[-1] - position_m[-2 : -2 - reach : -1]
    padded = np.concatenate([before, position_m, after])
    return _blurred(padded, std_s, mode="reflect")[reach : reach + len(position_m)]


def _blurred(values: FloatArray, std_s: float, mode: str = "nearest") -> FloatArray:
    """Return values smoothed in time by a Gaussian, along the first axis."""
    filters = scientific("ndimage", "traffic of recorded trips")
    return filters.gaussian_filter1d(values, std_s / STEP_S, axis=0, mode=mode)

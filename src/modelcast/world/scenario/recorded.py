"""Recorded trips on one clock: a platoon, or any fleet that was measured together."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.trips.trajectory import Trajectory
from modelcast.world.scenario.base import NOBODY, STEP_S, AbstractScenario, FleetFrame
from modelcast.world.true_motion import true_motion

__all__ = ["Replay", "make_replay"]


@dataclass(frozen=True, slots=True)
class Replay(AbstractScenario[int]):
    """Vehicles as they were recorded; the state is the number of the frame, and nothing is random.

    After the last frame no slot is active. A vehicle that comes back after a gap is a new one.

    Parameters
    ----------
    position_m
        (T, V, 2) [m].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        As in `FleetFrame`, (T, V).
    active
        When which vehicle is there, (T, V).
    length_m
        (V,) [m].
    kind
        As in `FleetFrame`, (V,), with the usual width of each; None where all are vehicles.

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    position_m: FloatArray
    speed_mps: FloatArray
    _: KW_ONLY
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    active: BoolArray
    length_m: FloatArray
    kind: IntArray | None = None
    _identity: IntArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        shape = self.active.shape
        if len(shape) != 2 or self.position_m.shape != (*shape, 2) or self.length_m.shape != shape[1:]:
            raise ValueError(
                f"active must be (T, V), position_m (T, V, 2) and length_m (V,), got {shape}, "
                f"{self.position_m.shape} and {self.length_m.shape}"
            )
        if self.kind is not None and self.kind.shape != shape[1:]:
            raise ValueError(f"kind must have shape {shape[1:]}, got {self.kind.shape}")
        for name in ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {getattr(self, name).shape}")
        before = np.concatenate([np.zeros((1, shape[1]), dtype=np.bool_), self.active[:-1]])
        visits = np.cumsum(np.asarray(self.active & ~before, dtype=np.int64), axis=0)
        identity = np.asarray(np.arange(shape[1]) + shape[1] * (visits - 1), dtype=np.int64)
        object.__setattr__(self, "_identity", np.where(self.active, identity, NOBODY))

    @property
    def slots(self) -> int:
        """Number of vehicles V."""
        return int(self.length_m.size)

    @property
    def duration_s(self) -> float:
        """Time that the recording lasts [s]."""
        return self.active.shape[0] * STEP_S

    def init(self, rng: np.random.Generator) -> int:
        """Return the first frame's number."""
        del rng
        return 0

    def step(self, state: int) -> int:
        """Return the next frame's number."""
        return state + 1

    def frame(self, state: int) -> FleetFrame:
        """Return the vehicles of a frame."""
        at = min(state, self.active.shape[0] - 1)
        here = self.active[at] & (state < self.active.shape[0])
        return FleetFrame(
            round(state * STEP_S, 6),
            self.position_m[at] * here[:, None],
            speed_mps=self.speed_mps[at] * here,
            heading_rad=self.heading_rad[at] * here,
            acceleration_mps2=self.acceleration_mps2[at] * here,
            yaw_rate_radps=self.yaw_rate_radps[at] * here,
            length_m=self.length_m * here,
            vehicle_id=np.where(here, self._identity[at], NOBODY),
            active=here,
            kind=self.kind,
            width_m=None
            if self.kind is None
            else np.array([SIZES_M[Kind(one)][1] for one in self.kind.tolist()]),
        )


def make_replay(
    trips: Sequence[Trajectory],
    starts_s: Sequence[float],
    *,
    length_m: float = SIZES_M[Kind.VEHICLE][0],
    kinds: Sequence[Kind] | None = None,
) -> Replay:
    """Trips on a common clock of `STEP_S`, interpolated linearly; in the gaps of a trip its car is not there.

    Parameters
    ----------
    trips
        One a vehicle, at `STEP_S` or finer; columns that are missing are taken from positions by differences
        on both sides.
    starts_s
        When each trip begins on the common clock, (V,) [s].
    length_m
        Length of the vehicles [m].
    kinds
        Of each; people have their usual length. None where all are vehicles.

    Raises
    ------
    ValueError
        Where there is no trip, the numbers differ, or a trip is coarser than the clock.
    """
    if kinds is not None and len(kinds) != len(trips):
        raise ValueError(f"as many kinds as trips are needed: {len(kinds)}, {len(trips)}")
    if not trips or len(trips) != len(starts_s):
        raise ValueError(f"as many starts as trips are needed, at least one: {len(starts_s)}, {len(trips)}")
    coarse = [trip.trip_id for trip in trips if trip.dt_s > 1.5 * STEP_S]
    if coarse:
        raise ValueError(f"trips must have a sample every {STEP_S} s; coarser is {coarse[0]}: leave it out")
    end_s = max(start + float(trip.t_s[-1]) for start, trip in zip(starts_s, trips, strict=True))
    first_s = min(starts_s)
    clock = first_s + np.arange(int(np.floor((end_s - first_s) / STEP_S + 1e-6)) + 1) * STEP_S
    shape = (clock.size, len(trips))
    position = np.zeros((*shape, 2))
    columns = {name: np.zeros(shape) for name in ("speed", "heading", "acceleration", "yaw_rate")}
    active = np.zeros(shape, dtype=np.bool_)
    for slot, (trip, start) in enumerate(zip(trips, starts_s, strict=True)):
        motion = true_motion(trip)
        for a, b in zip(trip.segments[:-1], trip.segments[1:], strict=True):
            if b - a < 3:
                continue
            t_s = trip.t_s[a:b] + start
            here = (clock >= t_s[0] - 1e-6) & (clock <= t_s[-1] + 1e-6)
            active[here, slot] = True
            at = np.stack(
                [np.interp(clock[here], t_s, motion[a:b, k]) for k in range(motion.shape[1])], axis=1
            )
            position[here, slot] = at[:, :2]
            columns["speed"][here, slot] = np.maximum(at[:, 2], 0.0)
            columns["heading"][here, slot] = (at[:, 3] + np.pi) % (2.0 * np.pi) - np.pi
            columns["acceleration"][here, slot], columns["yaw_rate"][here, slot] = at[:, 4], at[:, 5]
    return Replay(
        position,
        columns["speed"],
        heading_rad=columns["heading"],
        acceleration_mps2=columns["acceleration"],
        yaw_rate_radps=columns["yaw_rate"],
        active=active,
        length_m=np.full(len(trips), length_m)
        if kinds is None
        else np.array([length_m if one == Kind.VEHICLE else SIZES_M[one][0] for one in kinds]),
        kind=None if kinds is None else np.array(kinds, dtype=np.int64),
    )

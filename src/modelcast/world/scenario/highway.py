"""A highway of several lanes in both directions, periodic, so that its density never changes.

Drivers follow (`following_kernels`), change lanes where it pays (MOBIL) along a curve of least jerk, and
wander a little in their lanes. Two shapes: a straight road on which who leaves at the end comes in again at
the beginning as a new vehicle, and a ring that everybody stays on.
"""

from dataclasses import KW_ONLY, dataclass, replace
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario import highway_kernels as kernels
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame
from modelcast.world.scenario.bounds import check_positive, vehicle_count
from modelcast.world.scenario.drivers import HIGHWAY, Drivers

__all__ = ["Highway", "HighwayState"]


@dataclass(frozen=True, slots=True)
class HighwayState:
    """A highway at one instant.

    Parameters
    ----------
    number
        Steps since t = 0; negative while the traffic warms up.
    numbers
        Rows as in `highway_kernels`, (COLUMNS, V).
    integers
        Lane, lane being left, identifier, (3, V).
    order
        Slots by place along the road, one carriageway after the other, (V,).
    drivers
        Traits, (TRAITS, V).
    next_id
        The next identifier to give out.
    rng
        The run's generator.
    """

    number: int
    numbers: FloatArray
    _: KW_ONLY
    integers: IntArray
    order: IntArray
    drivers: FloatArray
    next_id: int
    rng: np.random.Generator

    @property
    def lane(self) -> IntArray:
        """Lane of each vehicle, 0 is the rightmost, (V,)."""
        return self.integers[kernels.LANE]

    @property
    def place_m(self) -> FloatArray:
        """Place along the road in the direction of driving, (V,) [m]."""
        return self.numbers[kernels.S]


@dataclass(frozen=True, slots=True)
class Highway(AbstractScenario[HighwayState]):
    """A periodic highway; V = density times length, constant.

    Parameters
    ----------
    length_m
        Length of the road [m]. The ring is a circle of this circumference, the straight road runs east from
        the origin.
    density_per_km
        Vehicles a kilometre of road, all lanes of both directions together [1/km].
    lanes
        Lanes in each direction.
    both_directions
        Whether there is a second carriageway.
    form
        ``straight`` or ``ring``.
    drivers
        Who drives.
    lane_width_m, median_m
        Width of a lane, and between the innermost lanes of the two carriageways [m].
    lane_change_s
        How long a change of lane lasts at speed [s]. Around 5 s on highways (Toledo and Zohar, Transp. Res.
        Rec. 1999 (2007) 71: 1 to 13 s, mean about 5).
    keep_right_mps2
        What the lane to the right is worth by itself, the bias of MOBIL [m/s²].
    warm_up_s
        Driven before t = 0, so that the traffic is no longer as it was laid out [s].

    Raises
    ------
    ValueError
        Where the vehicles do not fit on the road, or a value has the wrong sign.
    """

    length_m: float = 2000.0
    density_per_km: float = 60.0
    _: KW_ONLY
    lanes: int = 3
    both_directions: bool = True
    form: Literal["straight", "ring"] = "straight"
    drivers: Drivers = HIGHWAY
    lane_width_m: float = 3.5
    median_m: float = 4.0
    lane_change_s: float = 5.0
    keep_right_mps2: float = 0.1
    warm_up_s: float = 60.0

    def __post_init__(self) -> None:
        check_positive(self, "length_m", "density_per_km", "lane_width_m", "lane_change_s")
        if not (self.warm_up_s >= 0.0 and self.median_m >= 0.0 and self.lanes >= 1):
            raise ValueError(
                f"warm_up_s and median_m must be at least 0 and lanes at least 1, got {self.warm_up_s}, "
                f"{self.median_m} and {self.lanes}"
            )
        if self.form not in {"straight", "ring"}:
            raise ValueError(f"form must be 'straight' or 'ring', got {self.form!r}")
        inside = self.length_m / (2.0 * np.pi) - 0.5 * self.median_m - self.lanes * self.lane_width_m
        if self.form == "ring" and inside < 20.0:
            raise ValueError(f"a ring of {self.length_m} m is too tight for {self.lanes} lanes: lengthen it")
        if self.slots < 1:
            raise ValueError(
                f"{self.density_per_km} vehicles/km on {self.length_m} m make no vehicle: raise either"
            )

    @property
    def slots(self) -> int:
        """Number of vehicles V."""
        return vehicle_count(self.density_per_km, self.length_m)

    @property
    def forward(self) -> int:
        """Number of vehicles on the first carriageway: slots 0 to `forward` - 1."""
        return (self.slots + 1) // 2 if self.both_directions else self.slots

    def init(self, rng: np.random.Generator) -> HighwayState:
        """Lay the vehicles out with random gaps, and let them drive for the warm-up.

        Raises
        ------
        ValueError
            Where they do not fit.
        """
        vehicles = self.slots
        traits = self.drivers.draw(vehicles, rng)
        numbers = np.zeros((kernels.COLUMNS, vehicles))
        integers = np.zeros((3, vehicles), dtype=np.int64)
        for first, end in ((0, self.forward), (self.forward, vehicles)):
            for lane in range(self.lanes):
                who = np.arange(first + lane, end, self.lanes)
                integers[kernels.LANE : kernels.OLD_LANE + 1, who] = lane
                self._lay_out(who, traits, numbers, rng)
        numbers[kernels.PROGRESS] = 1.0
        numbers[kernels.SINCE_CHANGE_S] = rng.uniform(0.0, 10.0, vehicles)
        numbers[kernels.GAP_ERR : kernels.PEDAL + 1] = rng.standard_normal((3, vehicles))
        place = numbers[kernels.S]
        order = np.concatenate(
            [
                np.argsort(place[: self.forward], kind="stable"),
                self.forward + np.argsort(place[self.forward :], kind="stable"),
            ]
        ).astype(np.int64)
        warm_up = round(self.warm_up_s / STEP_S)
        state = HighwayState(
            -warm_up, numbers, integers=integers, order=order, drivers=traits, next_id=vehicles, rng=rng
        )
        for _ in range(warm_up):
            state = self.step(state)
        integers = state.integers.copy()
        integers[kernels.ID] = np.arange(vehicles)
        return replace(state, integers=integers, next_id=vehicles)

    def step(self, state: HighwayState) -> HighwayState:
        """Return the state a step later."""
        numbers, integers, order = state.numbers.copy(), state.integers.copy(), state.order.copy()
        next_id = kernels.step(
            numbers,
            integers,
            order,
            np.array([0, self.forward, self.slots], dtype=np.int64),
            state.drivers,
            self.settings(),
            state.rng.standard_normal((kernels.NORMALS, self.slots)),
            state.number + 2**20,
            state.next_id,
            self.lanes,
            STEP_S,
        )
        return replace(
            state, number=state.number + 1, numbers=numbers, integers=integers, order=order, next_id=next_id
        )

    def frame(self, state: HighwayState) -> FleetFrame:
        """Return the fleet; every slot is active."""
        out = np.empty((6, self.slots))
        kernels.poses(state.numbers, state.integers, self.forward, self.settings(), self.lanes, out)
        return FleetFrame(
            round(state.number * STEP_S, 6),
            np.ascontiguousarray(out[0:2].T),
            speed_mps=out[2],
            heading_rad=out[3],
            acceleration_mps2=out[4],
            yaw_rate_radps=out[5],
            length_m=state.drivers[following.LENGTH],
            vehicle_id=state.integers[kernels.ID],
            active=np.ones(self.slots, dtype=np.bool_),
        )

    def settings(self) -> FloatArray:
        """Return the road as the kernels take it."""
        return np.array(
            [
                self.length_m,
                self.lane_width_m,
                self.median_m,
                self.lane_change_s,
                self.length_m / (2.0 * np.pi),
                self.drivers.wander_m,
                self.drivers.pedal_noise_mps2,
                self.drivers.perception_noise,
                self.keep_right_mps2,
                float(self.form == "ring"),
            ]
        )

    def _lay_out(
        self,
        who: IntArray,
        traits: FloatArray,
        numbers: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        """Place vehicles in a lane, with gaps random around their mean, at the speed these gaps allow."""
        if not who.size:
            return
        length, least = traits[following.LENGTH, who], traits[following.GAP, who]
        spare_m = self.length_m - float((length + least).sum())
        if spare_m < 0.05 * self.length_m:
            raise ValueError(
                f"{who.size} vehicles of {length.mean():.1f} m do not fit into a lane of {self.length_m} m "
                f"with {least[0]} m between them: lower density_per_km, now {self.density_per_km}, or raise "
                f"lanes, now {self.lanes}"
            )
        share = rng.uniform(0.5, 1.5, who.size)
        gap = least + spare_m * share / float(share.sum())
        behind = np.concatenate([[0.0], (gap[:-1] + 0.5 * (length[:-1] + length[1:])).cumsum()])
        numbers[kernels.S, who] = (behind + rng.uniform(0.0, self.length_m)) % self.length_m
        mean = spare_m / who.size / float(traits[following.HEADWAY, who].mean())
        numbers[kernels.V, who] = min(0.9 * mean, 0.9 * float(traits[following.DESIRED_SPEED, who].min()))

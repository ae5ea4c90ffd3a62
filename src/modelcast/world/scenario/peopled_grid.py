"""People in a Manhattan grid: pedestrians on pavements and crossings, cyclists beside the lanes.

Vehicles are those of `Grid`. Pedestrians cross the arms of junctions, by themselves with a critical gap or
with a green of their own where there are signals; some are careless. Cyclists wait at each junction until it
is theirs. Vehicles stop for who is on the carriageway before them. People pass through one another; nobody
passes through a vehicle or a building.
"""

from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.kinds import CYCLIST_M, PEDESTRIAN_M, Kind
from modelcast.world.scenario import people_arrays as walking
from modelcast.world.scenario import people_kernels as kernels
from modelcast.world.scenario import town_arrays as arrays
from modelcast.world.scenario import town_kernels
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame
from modelcast.world.scenario.drivers import Drivers
from modelcast.world.scenario.following_kernels import LENGTH
from modelcast.world.scenario.footways import CYCLE_LANE_M, STREET_HALF_M, Footways, make_footways
from modelcast.world.scenario.grid import Grid, GridState
from modelcast.world.scenario.people import RIDERS, Pedestrians
from modelcast.world.scenario.streets import LANE_M

__all__ = ["PeopledGrid", "PeopledState"]

WALK_S, CLEAR_S = 7.0, 12.0
"""People's green, and the time they have to clear the street, 13 m at 1.07 m/s [s]: MUTCD 4E.06."""

_CAR_WIDTH_M = 1.8
_SETTLE_S = 30.0


@dataclass(frozen=True, slots=True)
class PeopledState:
    """A grid with people at one instant.

    Parameters
    ----------
    grid
        Its vehicles, its clock and the run's generator.
    walkers, walkers_at
        Pedestrians' numbers and integers, rows as in `people_arrays`, (., P).
    traits
        Pedestrians' traits, (4, P).
    riders, riders_at
        Cyclists' numbers and integers, rows as in `town_arrays`, (., C).
    riders_traits
        (TRAITS, C), rows as in `following_kernels`.
    aside_m
        How far to the right of the lane's middle each cyclist rides, (C,) [m].
    waited_s
        How long each cyclist has waited at its junction, (C,) [s].
    order, first
        Cyclists by link and place, (C,); where each link begins in them, (K + 1,).
    counts
        Who stepped onto a carriageway, who of them carelessly, who turned back, since t = 0, (3,).
    """

    grid: GridState
    _: KW_ONLY
    walkers: FloatArray
    walkers_at: IntArray
    traits: FloatArray
    riders: FloatArray
    riders_at: IntArray
    riders_traits: FloatArray
    aside_m: FloatArray
    waited_s: FloatArray
    order: IntArray
    first: IntArray
    counts: IntArray

    @property
    def stepped_out(self) -> int:
        """How often a pedestrian stepped onto a carriageway since t = 0."""
        return int(self.counts[walking.STEPPED_OUT])

    @property
    def carelessly(self) -> int:
        """How often of these it was a careless one, who did not wait for a gap or a green."""
        return int(self.counts[walking.STEPPED_CARELESSLY])

    @property
    def turned_back(self) -> int:
        """How often a pedestrian turned back."""
        return int(self.counts[walking.TURNED_BACK])


@dataclass(frozen=True, slots=True)
class PeopledGrid(AbstractScenario[PeopledState]):
    """A closed grid with a constant number of vehicles, pedestrians and cyclists, in this order of slots.

    Parameters
    ----------
    grid
        Streets and vehicles; its junctions reach to the buildings, 15 m. Where there are signals, people get
        a green of their own at the end of each cycle.
    pedestrians, cyclists
        How many, at least one together.
    who
        The pedestrians.
    riders
        The cyclists.

    Raises
    ------
    ValueError
        Where nobody is asked for, or the junctions are of another size.

    Examples
    --------
    >>> PeopledGrid(Grid(3, 3, 20.0), 30, 10).slots  # 48 vehicles
    88
    """

    grid: Grid
    pedestrians: int = 100
    cyclists: int = 30
    _: KW_ONLY
    who: Pedestrians = Pedestrians()  # noqa: RUF009 - it is frozen
    riders: Drivers = RIDERS
    _vehicles: Grid = field(init=False, repr=False, compare=False)
    _footways: Footways = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if min(self.pedestrians, self.cyclists) < 0 or self.pedestrians + self.cyclists < 1:
            raise ValueError(
                f"pedestrians and cyclists must be at least one together, got {self.pedestrians} and "
                f"{self.cyclists}"
            )
        if self.grid.junction_m != STREET_HALF_M:
            raise ValueError(f"junction_m must be {STREET_HALF_M} with people, got {self.grid.junction_m}")
        grid = self.grid
        if grid.junctions == "signals":
            grid = replace(grid, people_s=WALK_S + CLEAR_S)
        object.__setattr__(self, "_vehicles", grid)
        footways = make_footways(grid.streets, columns=grid.columns, rows=grid.rows, block_m=grid.block_m)
        object.__setattr__(self, "_footways", footways)

    @property
    def slots(self) -> int:
        """Number of vehicles and people V."""
        return self.grid.slots + self.pedestrians + self.cyclists

    def init(self, rng: np.random.Generator) -> PeopledState:
        """Let the vehicles warm up, put people on pavements and cycle lanes, and let all settle for 30 s."""
        grid = self._vehicles.init(rng)
        streets, ways = self._vehicles.streets, self._footways
        links = streets.direction.size
        riders = np.zeros((arrays.COLUMNS, self.cyclists))
        riders_at = np.zeros((arrays.INTEGERS, self.cyclists), dtype=np.int64)
        riders_at[arrays.CAME_FROM] = -1
        riders_at[arrays.LINK] = rng.integers(links, size=self.cyclists)
        riders[arrays.S] = rng.uniform(0.0, 0.8 * streets.length_m, self.cyclists)
        for i, uniform in enumerate(rng.random(self.cyclists)):
            riders_at[arrays.NEXT_MOVE, i] = town_kernels.choose_move(
                streets.follower, int(riders_at[arrays.LINK, i]), self.grid.straight_ratio, uniform
            )
        order, first = np.arange(self.cyclists, dtype=np.int64), np.zeros(links + 1, dtype=np.int64)
        town_kernels.sort_by_link(riders, riders_at, order, first)
        walkers, walkers_at = self._on_pavements(ways, rng)
        state = PeopledState(
            replace(grid, number=-round(_SETTLE_S / STEP_S)),
            walkers=walkers,
            walkers_at=walkers_at,
            traits=self.who.draw(self.pedestrians, rng),
            riders=riders,
            riders_at=riders_at,
            riders_traits=self.riders.draw(self.cyclists, rng),
            aside_m=rng.uniform(*CYCLE_LANE_M, self.cyclists) - LANE_M / 2,
            order=order,
            first=first,
            waited_s=np.zeros(self.cyclists),
            counts=np.zeros(walking.COUNTS, dtype=np.int64),
        )
        while state.grid.number < 0:
            state = self.step(state)
        return replace(
            state,
            grid=replace(state.grid, counts=np.zeros(arrays.COUNTS, dtype=np.int64)),
            counts=np.zeros(walking.COUNTS, dtype=np.int64),
        )

    def _on_pavements(self, ways: Footways, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
        """Pedestrians at random places of footways along blocks, which cross no lane."""
        along = np.argwhere((ways.onto >= 0) & (ways.lanes[:, :, 1] < 0))
        origin, direction = along[rng.integers(len(along), size=self.pedestrians)].T
        walkers = np.zeros((walking.WALKING_COLUMNS, self.pedestrians))
        walkers[walking.LEFT] = rng.uniform(0.2, 1.0, self.pedestrians) * ways.length_m[origin, direction]
        walkers_at = np.zeros((walking.WALKING_INTEGERS, self.pedestrians), dtype=np.int64)
        node = ways.onto[origin, direction]
        walkers_at[walking.NODE], walkers_at[walking.DIRECTION] = node, direction
        # Where straight on leads nowhere, to a side that leads somewhere.
        for quarter in (1, 3, 0):
            onward = (direction + quarter) % 4
            found = ways.onto[node, onward] >= 0
            walkers_at[walking.NEXT] = np.where(found, onward, walkers_at[walking.NEXT])
        walkers_at[walking.STAGE] = 3
        return walkers, walkers_at

    def step(self, state: PeopledState) -> PeopledState:
        """Return the state a step later: people first, and vehicles with an eye on them."""
        streets, grid, rng = self._vehicles.streets, state.grid, state.grid.rng
        busy = np.zeros((2, streets.direction.size))
        roads = arrays.Roads(
            streets.follower, streets.connector_m, streets.ends, streets.green_start_s, streets.cycle_s,
            streets.direction, streets.approach, streets.conflicts, busy,
        )  # fmt: skip
        ways = walking.Ways(
            self._footways.corner_m,
            self._footways.onto,
            self._footways.length_m,
            self._footways.lanes,
            np.empty_like(busy),
            np.empty_like(busy),
            np.empty(len(streets.approach), dtype=np.int64),
            self._people_have_green(grid),
        )
        vehicles = arrays.Town(
            grid.numbers, grid.integers, grid.order, grid.first, grid.left_last, grid.counts
        )
        kernels.foresee(vehicles, grid.drivers[LENGTH], roads, ways, streets.length_m)
        walkers = walking.Walkers(
            state.walkers.copy(), state.walkers_at.copy(), state.traits, state.counts.copy()
        )
        kernels.walk(
            walkers,
            ways,
            self._walking_settings(),
            rng.standard_normal(self.pedestrians),
            rng.random((3, self.pedestrians)),
            busy,
            STEP_S,
        )
        riders = arrays.Town(
            state.riders.copy(), state.riders_at.copy(), state.order.copy(), state.first.copy(),
            grid.left_last, grid.counts,
        )  # fmt: skip
        waited = state.waited_s.copy()
        kernels.ride(
            riders, state.riders_traits, state.aside_m, waited, roads, ways, self._riding_settings(),
            rng.standard_normal((2, self.cyclists)), rng.random(self.cyclists), self._has_signals, busy,
            STEP_S,
        )  # fmt: skip
        return replace(
            state,
            grid=self._vehicles.step_among(grid, busy),
            walkers=walkers.numbers,
            walkers_at=walkers.integers,
            riders=riders.numbers,
            riders_at=riders.integers,
            order=riders.order,
            first=riders.first,
            waited_s=waited,
            counts=walkers.counts,
        )

    def frame(self, state: PeopledState) -> FleetFrame:
        """Return all; every slot is active."""
        streets, vehicles = self._vehicles.streets, self._vehicles.frame(state.grid)
        on_foot, riding = np.empty((6, self.pedestrians)), np.empty((6, self.cyclists))
        nobody = np.zeros((2, 0))
        ways = walking.Ways(
            self._footways.corner_m, self._footways.onto, self._footways.length_m, self._footways.lanes,
            nobody, nobody, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_),
        )  # fmt: skip
        walkers = walking.Walkers(state.walkers, state.walkers_at, state.traits, state.counts)
        kernels.walking_poses(walkers, ways, on_foot)
        beside = state.riders.copy()
        beside[arrays.WANDER] -= state.aside_m
        town_kernels.poses(
            beside,
            state.riders_at,
            streets.start_m,
            streets.direction,
            streets.connector_m,
            streets.curve,
            riding,
        )
        people = np.concatenate([on_foot, riding], axis=1)
        counts = (self.grid.slots, self.pedestrians, self.cyclists)
        return FleetFrame(
            vehicles.t_s,
            np.concatenate([vehicles.position_m, people[:2].T]),
            speed_mps=np.concatenate([vehicles.speed_mps, people[2]]),
            heading_rad=np.concatenate([vehicles.heading_rad, people[3]]),
            acceleration_mps2=np.concatenate([vehicles.acceleration_mps2, people[4]]),
            yaw_rate_radps=np.concatenate([vehicles.yaw_rate_radps, people[5]]),
            length_m=np.concatenate(
                [vehicles.length_m, np.repeat((PEDESTRIAN_M[0], CYCLIST_M[0]), counts[1:])]
            ),
            vehicle_id=np.arange(self.slots, dtype=np.int64),
            active=np.ones(self.slots, dtype=np.bool_),
            kind=np.repeat(np.array([Kind.VEHICLE, Kind.PEDESTRIAN, Kind.CYCLIST], dtype=np.int64), counts),
            width_m=np.repeat((_CAR_WIDTH_M, PEDESTRIAN_M[1], CYCLIST_M[1]), counts),
        )

    @property
    def _has_signals(self) -> bool:
        return self.grid.junctions == "signals"

    def _people_have_green(self, grid: GridState) -> BoolArray:
        """Where people may set out now, (J,)."""
        streets = self._vehicles.streets
        found = np.zeros(len(streets.approach), dtype=np.bool_)
        if self._has_signals:
            at = (grid.number * STEP_S + grid.offset_s) % streets.cycle_s
            begins = streets.cycle_s - WALK_S - CLEAR_S
            found[streets.ends] = (at >= begins) & (at < begins + WALK_S)
        return found

    def _walking_settings(self) -> FloatArray:
        """Settings as the kernel of pedestrians takes them."""
        who = self.who
        return np.array(
            [
                who.spare_s,
                who.turns_back_per_minute / 60.0,
                who.careless_ratio,
                who.pace_noise_ratio,
                float(self._has_signals),
            ]
        )

    def _riding_settings(self) -> FloatArray:
        """Settings as the kernel of cyclists takes them: those of the grid that matter to them."""
        found = np.zeros(10)
        found[arrays.LINK_M] = self._vehicles.streets.length_m
        found[arrays.STRAIGHT_ON] = self.grid.straight_ratio
        found[arrays.WANDER_M], found[arrays.PEDAL_NOISE] = self.riders.wander_m, self.riders.pedal_noise_mps2
        return found

"""A Manhattan grid: blocks, one lane each way, signals or priority at junctions, turns of smooth curvature.

Nobody leaves: at each junction a driver draws where to go among the streets there are. With signals the
approaches of a junction have green one after the other, so that no two ways cross; with priority drivers wait
for a gap. A driver does not enter a junction that cannot be left again. Some may misjudge.
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario import town_arrays as arrays
from modelcast.world.scenario import town_kernels as kernels
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame
from modelcast.world.scenario.bounds import check_positive, vehicle_count
from modelcast.world.scenario.drivers import CITY, Drivers
from modelcast.world.scenario.streets import AMBER_S, LANE_M, Streets, make_streets

__all__ = ["Grid", "GridState"]

_FULLEST = 0.6
"""Above this share of standing room a grid locks."""


@dataclass(frozen=True, slots=True)
class GridState:
    """A grid at one instant.

    Parameters
    ----------
    number
        Steps since t = 0; negative while the traffic warms up.
    numbers, integers
        Rows as in `town_arrays`, (COLUMNS, V) and (INTEGERS, V).
    order, first
        Slots by link and place, (V,); where each link begins in them, (K + 1,).
    left_last
        The vehicle that left each link last, (K,).
    offset_s
        By how much each link's signal is ahead of the clock, (K,) [s].
    drivers
        Traits, (TRAITS, V).
    rng
        The run's generator.
    counts
        Crossings, and those of them that misjudged, since t = 0, (2,).
    """

    number: int
    numbers: FloatArray
    _: KW_ONLY
    integers: IntArray
    order: IntArray
    first: IntArray
    left_last: IntArray
    counts: IntArray
    offset_s: FloatArray
    drivers: FloatArray
    rng: np.random.Generator

    @property
    def link(self) -> IntArray:
        """Directed link of each vehicle, (V,)."""
        return self.integers[arrays.LINK]

    @property
    def crossings(self) -> int:
        """Vehicles that passed a signal, or went straight on over a major street, since t = 0."""
        return int(self.counts[arrays.CROSSINGS])

    @property
    def misjudged(self) -> int:
        """How many of them should have waited."""
        return int(self.counts[arrays.MISJUDGED])

    @property
    def runs(self) -> IntArray:
        """Who enters, or is in, a junction that it should have waited at: 1 or 0, (V,)."""
        return self.integers[arrays.RUNS]


@dataclass(frozen=True, slots=True)
class Grid(AbstractScenario[GridState]):
    """A closed Manhattan grid; the number of vehicles is constant.

    Parameters
    ----------
    columns, rows
        Junctions from west to east and from south to north, at least 2 each.
    density_per_km
        Vehicles a kilometre of street, both directions together [1/km].
    block_m
        Distance between junctions [m].
    junction_m
        From a junction's middle to its stop lines [m].
    green_s
        Green for each approach [s].
    turn_mps2
        Lateral acceleration at the sharpest point of a turn [m/s²].
    junctions
        ``signals``; or ``priority``: the streets from west to east are major, and from the others drivers
        enter by the critical gaps of the Highway Capacity Manual (2010), two-way stop control: 6.5 s straight
        on, 7.1 s left, 6.2 s right, and 4.1 s for a left turn from the major street.
    misjudged_ratio
        Share of drivers at a junction who misjudge. With priority they go straight on over a major street in
        a gap that is just enough, 0.25 to 0.85 s before or behind one that drives there; where no such gap
        comes up, they wait for a good one. With signals they run the first 4 s of red. Drivers with the right
        of way do not notice them.
    straight_ratio
        Odds of going straight on, above 0 and below 1; the rest is shared by left and right.
    drivers
        Who drives.
    people_s
        At the end of each cycle of signals, when all vehicles have red and people cross [s].
    warm_up_s
        Driven before t = 0, where nobody misjudges [s].

    Raises
    ------
    ValueError
        Where the vehicles fill the streets so much that they would lock, or a value is out of bounds.

    Examples
    --------
    >>> Grid(3, 3, 20.0, block_m=200.0).slots  # 12 streets of 200 m
    48
    """

    columns: int = 5
    rows: int = 5
    density_per_km: float = 20.0
    _: KW_ONLY
    block_m: float = 200.0
    junction_m: float = 15.0
    green_s: float = 12.0
    turn_mps2: float = 2.5
    junctions: Literal["signals", "priority"] = "signals"
    misjudged_ratio: float = 0.0
    straight_ratio: float = 0.5
    drivers: Drivers = CITY
    people_s: float = 0.0
    warm_up_s: float = 120.0
    _streets: Streets = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.columns < 2 or self.rows < 2:
            raise ValueError(f"columns and rows must be at least 2, got {self.columns} and {self.rows}")
        if not 8.0 <= self.junction_m <= 0.3 * self.block_m:
            raise ValueError(
                f"junction_m must lie between 8 and 0.3 of block_m = {self.block_m}, got {self.junction_m}"
            )
        check_positive(self, "density_per_km", "green_s", "turn_mps2")
        if self.junctions not in {"signals", "priority"}:
            raise ValueError(f"junctions must be 'signals' or 'priority', got {self.junctions!r}")
        if not 0.0 <= self.misjudged_ratio <= 1.0:
            raise ValueError(f"misjudged_ratio must lie in 0..1, got {self.misjudged_ratio}")
        if not 0.0 < self.straight_ratio < 1.0:
            raise ValueError(f"straight_ratio must lie between 0 and 1, got {self.straight_ratio}")
        for name in ("warm_up_s", "people_s"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be at least 0, got {getattr(self, name)}")
        streets = make_streets(
            self.columns,
            self.rows,
            block_m=self.block_m,
            junction_m=self.junction_m,
            green_s=self.green_s,
            people_s=self.people_s,
        )
        object.__setattr__(self, "_streets", streets)
        room = self.drivers.length_m[1] + self.drivers.gap_m
        most = int(_FULLEST * streets.length_m / room) * streets.direction.size
        if not 1 <= self.slots <= most:
            raise ValueError(
                f"density_per_km must make between 1 and {most} vehicles on {self.street_m:.0f} m, "
                f"got {self.slots}"
            )

    @property
    def streets(self) -> Streets:
        """Its streets as tables."""
        return self._streets

    @property
    def street_m(self) -> float:
        """Total length of the streets [m]."""
        return self.block_m * (self.columns * (self.rows - 1) + self.rows * (self.columns - 1))

    @property
    def slots(self) -> int:
        """Number of vehicles V."""
        return vehicle_count(self.density_per_km, self.street_m)

    def init(self, rng: np.random.Generator) -> GridState:
        """Spread the vehicles over the links, and let them drive for the warm-up."""
        streets, vehicles = self._streets, self.slots
        links = streets.direction.size
        traits = self.drivers.draw(vehicles, rng)
        integers = np.zeros((arrays.INTEGERS, vehicles), dtype=np.int64)
        integers[arrays.CAME_FROM] = -1
        numbers = np.zeros((arrays.COLUMNS, vehicles))
        integers[arrays.LINK] = (np.arange(vehicles) + rng.integers(links)) % links
        rank = np.arange(vehicles) // links
        numbers[arrays.S] = (rank + 0.5) * streets.length_m / (int(rank.max()) + 1)
        for i, uniform in enumerate(rng.random(vehicles)):
            integers[arrays.NEXT_MOVE, i] = kernels.choose_move(
                streets.follower, integers[arrays.LINK, i], self.straight_ratio, uniform
            )
        numbers[arrays.GAP_ERR : arrays.PEDAL + 1] = rng.standard_normal((3, vehicles))
        order, first = np.arange(vehicles, dtype=np.int64), np.zeros(links + 1, dtype=np.int64)
        kernels.sort_by_link(numbers, integers, order, first)
        state = GridState(
            -round(self.warm_up_s / STEP_S),
            numbers,
            integers=integers,
            order=order,
            first=first,
            left_last=np.full(links, -1, dtype=np.int64),
            counts=np.zeros(arrays.COUNTS, dtype=np.int64),
            offset_s=_junction_offsets(streets, rng),
            drivers=traits,
            rng=rng,
        )
        while state.number < 0:
            state = self.step(state)
        return replace(state, counts=np.zeros(arrays.COUNTS, dtype=np.int64))

    def step(self, state: GridState) -> GridState:
        """Return the state a step later."""
        return self.step_among(state, np.zeros((2, self._streets.direction.size)))

    def step_among(self, state: GridState, busy_s: FloatArray) -> GridState:
        """Return the state a step later, where people are on the lanes.

        Parameters
        ----------
        state
            As `init` or `step` gave it.
        busy_s
            For how long people still are on the crossings of each link, (2, K) [s]: `town_arrays.Roads`.
        """
        streets = self._streets
        town = arrays.Town(
            state.numbers.copy(),
            state.integers.copy(),
            state.order.copy(),
            state.first.copy(),
            state.left_last.copy(),
            state.counts.copy(),
        )
        roads = arrays.Roads(
            streets.follower,
            streets.connector_m,
            streets.ends,
            streets.green_start_s - state.offset_s,
            streets.cycle_s,
            streets.direction,
            streets.approach,
            streets.conflicts,
            busy_s,
        )
        normals = state.rng.standard_normal((arrays.NORMALS, self.slots))
        uniforms = state.rng.random(self.slots)
        misjudges = np.zeros(self.slots, dtype=np.bool_)
        if self.misjudged_ratio > 0.0 and state.number >= 0:
            misjudges = state.rng.random(self.slots) < self.misjudged_ratio
        kernels.step(
            town,
            state.drivers,
            roads,
            self._settings(),
            normals,
            uniforms,
            misjudges,
            state.number * STEP_S,
            STEP_S,
        )
        return replace(state, number=state.number + 1, **town._asdict())

    def frame(self, state: GridState) -> FleetFrame:
        """Return the fleet; every slot is active."""
        streets = self._streets
        out = np.empty((6, self.slots))
        kernels.poses(
            state.numbers,
            state.integers,
            streets.start_m,
            streets.direction,
            streets.connector_m,
            streets.curve,
            out,
        )
        return FleetFrame(
            round(state.number * STEP_S, 6),
            np.ascontiguousarray(out[0:2].T),
            speed_mps=out[2],
            heading_rad=out[3],
            acceleration_mps2=out[4],
            yaw_rate_radps=out[5],
            length_m=state.drivers[following.LENGTH],
            vehicle_id=np.arange(self.slots, dtype=np.int64),
            active=np.ones(self.slots, dtype=np.bool_),
        )

    def _settings(self) -> FloatArray:
        """Return the grid as the kernels take it."""
        drivers = self.drivers
        return np.array(
            [
                self._streets.length_m,
                self.green_s,
                AMBER_S,
                self.turn_mps2,
                drivers.wander_m,
                drivers.pedal_noise_mps2,
                drivers.perception_noise,
                LANE_M,
                float(self.junctions == "priority"),
                self.straight_ratio,
            ]
        )


def _junction_offsets(streets: Streets, rng: np.random.Generator) -> FloatArray:
    """Return a random offset for every junction's signals, by the link that leads to it, (K,) [s]."""
    return rng.random(int(streets.ends.max()) + 1)[streets.ends] * streets.cycle_s

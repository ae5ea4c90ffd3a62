"""Streams of cars in lanes: leaders brake hard now and then, others cut in, and who is behind notices late.

What a forward collision warning or a brake light by radio is for: the distances are short, the braking is
hard, and drivers react after a second. Near-collisions occur, and contacts; both are counted in the state.
"""

from dataclasses import KW_ONLY, dataclass, field, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.scenario import braking_kernels as kernels
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario import highway_kernels
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame
from modelcast.world.scenario.bounds import check_range
from modelcast.world.scenario.cut_ins import find_cut_in
from modelcast.world.scenario.drivers import STREAM, Drivers
from modelcast.world.scenario.highway import Highway, HighwayState

__all__ = ["BrakingState", "BrakingStreams"]

_FREE_RATIO = 0.15  # of a lane, left free between its streams
_SLOWEST_MPS = 8.0  # streams that would have to start slower do not fit; who is slower does not brake by draw
_SPARE_MPS = 1.0
_CUT_IN_DROP_MPS = (2.0, 5.0)
_MOST_WAITING = 10


@dataclass(frozen=True, slots=True)
class BrakingState:
    """Streams at one instant.

    Parameters
    ----------
    road
        The vehicles as those of a highway, with the further rows of `braking_kernels`.
    history
        Way, speed and acceleration of the last H steps, in a ring, (3, H, V).
    counts
        Brakings drawn, contacts, near-collisions and cut-ins since t = 0, (4,).
    waiting_s
        Time gaps of cut-ins that were drawn and for which nobody is in place yet, (N,) [s].
    """

    road: HighwayState
    history: FloatArray
    _: KW_ONLY
    counts: IntArray
    waiting_s: FloatArray

    @property
    def brakings(self) -> int:
        """Hard brakings drawn since t = 0."""
        return int(self.counts[kernels.BRAKINGS])

    @property
    def contacts(self) -> int:
        """How often a vehicle came to touch its leader since t = 0."""
        return int(self.counts[kernels.CONTACTS])

    @property
    def near_collisions(self) -> int:
        """How often the time to collision of a vehicle with its leader fell under 1.5 s since t = 0."""
        return int(self.counts[kernels.NEAR_COLLISIONS])

    @property
    def cut_ins(self) -> int:
        """How many vehicles began to cut in since t = 0."""
        return int(self.counts[kernels.CUT_INS])

    @property
    def touches(self) -> IntArray:
        """Who touches its leader, or did and is not yet 0.5 m behind it, (V,)."""
        return self.road.integers[kernels.TOUCHES]

    @property
    def phase(self) -> IntArray:
        """Phase of each vehicle's drawn braking: 0 none, 1 pressing, 2 letting go, 3 holding, (V,)."""
        return self.road.integers[kernels.PHASE]


@dataclass(frozen=True, slots=True)
class BrakingStreams(AbstractScenario[BrakingState]):
    """Streams on a straight, periodic road; V = density times length, constant.

    In every lane vehicles drive in streams with the time gaps of their drivers, and more room between
    streams. At random times (a Poisson process) the leader of a stream brakes: the deceleration is drawn, is
    reached at 20 m/s³, and is let go at 10 m/s³ at the speed that was drawn; that is held for a while. A
    draw that finds no leader at 8 m/s or more who is not braking yet is dropped.

    Everybody reacts to what the vehicle ahead did a reaction time ago, and brakes at 9 m/s² at most. Where
    that is too late the follower touches its leader: within one step it takes the leader's speed, if lower,
    and stays behind it. So vehicles never overlap, and only in the step of a contact a speed is not the
    integral of an acceleration.

    Parameters
    ----------
    length_m, density_per_km
        Of the road, all lanes of both directions together [m], [1/km].
    lanes, both_directions
        As of the highway.
    vehicles
        In each stream; the last of a lane may have fewer.
    brakings_per_minute
        Of the whole road [1/min].
    deceleration_mps2
        Range that a braking's deceleration is drawn from evenly; 0.4 to 0.9 g where not given [m/s²].
    stop_ratio
        Share of the brakings that end at standstill; the others end at a speed drawn evenly from those at
        which the deceleration is still reached.
    hold_s
        Range of the time that this speed is held [s].
    reaction_s
        Range of the reaction times. Green (Transp. Human Factors 2 (2000) 195, DOI 10.1207/STHF0203_1) finds
        0.7 s for who expects the braking, 1.25 s for brake lights that are not expected, 1.5 s for a surprise
        [s].
    cut_ins_per_minute
        Of the whole road [1/min]: a vehicle moves to the lane beside, in front of one there, and brakes
        lightly once it is there. A cut-in that was drawn waits until somebody is in place for it; where ten
        wait, further ones are dropped.
    cut_in_gap_s
        Range of the time gap that it leaves to who it cuts in on, as it begins [s].
    cut_in_mps2
        Range of the deceleration that it brakes with, by 2 to 5 m/s [m/s²].
    lane_change_s
        How long a cut-in lasts at speed [s].
    drivers
        Who drives; their headways are the time gaps.
    lane_width_m, median_m
        As of the highway [m].
    warm_up_s
        Driven before t = 0, without brakings [s].

    Raises
    ------
    ValueError
        Where a range is empty or a value has the wrong sign or is out of its bounds.

    Examples
    --------
    >>> streams = BrakingStreams(1000.0, 20.0, brakings_per_minute=60.0, warm_up_s=0.0)
    >>> state = streams.init(np.random.default_rng(1))
    >>> for _ in range(100):
    ...     state = streams.step(state)
    >>> state.brakings, state.contacts
    (8, 0)
    """

    length_m: float = 2000.0
    density_per_km: float = 60.0
    _: KW_ONLY
    lanes: int = 3
    both_directions: bool = True
    vehicles: int = 8
    brakings_per_minute: float = 10.0
    deceleration_mps2: tuple[float, float] = (3.92, 8.83)
    stop_ratio: float = 0.3
    hold_s: tuple[float, float] = (1.0, 4.0)
    reaction_s: tuple[float, float] = (0.7, 1.5)
    cut_ins_per_minute: float = 0.0
    cut_in_gap_s: tuple[float, float] = (0.3, 1.0)
    cut_in_mps2: tuple[float, float] = (1.0, 2.5)
    lane_change_s: float = 3.0
    drivers: Drivers = STREAM
    lane_width_m: float = 3.5
    median_m: float = 4.0
    warm_up_s: float = 20.0
    _road: Highway = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        road = Highway(
            self.length_m,
            self.density_per_km,
            lanes=self.lanes,
            both_directions=self.both_directions,
            drivers=self.drivers,
            lane_width_m=self.lane_width_m,
            median_m=self.median_m,
            lane_change_s=self.lane_change_s,
            warm_up_s=self.warm_up_s,
        )
        object.__setattr__(self, "_road", road)
        check_range(self, "deceleration_mps2", 1.0, following.HARDEST_MPS2)
        check_range(self, "reaction_s", 0.0, 5.0)
        check_range(self, "hold_s", 0.0, 600.0)
        check_range(self, "cut_in_gap_s", 0.2, 3.0)
        check_range(self, "cut_in_mps2", 0.1, following.HARDEST_MPS2)
        if self.vehicles < 1:
            raise ValueError(f"vehicles must be at least 1 a stream, got {self.vehicles}")
        for name in ("brakings_per_minute", "cut_ins_per_minute"):
            rate: float = getattr(self, name)
            if not (np.isfinite(rate) and rate >= 0.0):
                raise ValueError(f"{name} must be at least 0 and finite, got {rate}")
        if self.cut_ins_per_minute > 0.0 and self.lanes < 2:
            raise ValueError(f"cut_ins_per_minute needs at least 2 lanes, got {self.lanes}")
        if not 0.0 <= self.stop_ratio <= 1.0:
            raise ValueError(f"stop_ratio must lie in 0..1, got {self.stop_ratio}")

    @property
    def slots(self) -> int:
        """Number of vehicles V."""
        return self._road.slots

    def init(self, rng: np.random.Generator) -> BrakingState:
        """Lay the streams out, and let them drive for the warm-up.

        Raises
        ------
        ValueError
            Where they do not fit.
        """
        vehicles, forward = self.slots, self._road.forward
        traits = self.drivers.draw(vehicles, rng)
        numbers = np.zeros((kernels.COLUMNS, vehicles))
        integers = np.zeros((kernels.INTEGERS, vehicles), dtype=np.int64)
        for first, end in ((0, forward), (forward, vehicles)):
            for lane in range(self.lanes):
                who = np.arange(first + lane, end, self.lanes)
                integers[highway_kernels.LANE : highway_kernels.OLD_LANE + 1, who] = lane
                if who.size:
                    self._lay_out(who, traits, numbers, integers, rng)
        numbers[highway_kernels.PROGRESS] = 1.0
        numbers[highway_kernels.GAP_ERR : highway_kernels.PEDAL + 1] = rng.standard_normal((3, vehicles))
        integers[highway_kernels.ID] = np.arange(vehicles)
        reaction = rng.uniform(*self.reaction_s, vehicles)
        integers[kernels.DELAY_STEPS] = np.rint(reaction / STEP_S).astype(np.int64)
        place = numbers[highway_kernels.S]
        order = np.concatenate(
            [np.argsort(place[:forward], kind="stable"), forward + np.argsort(place[forward:], kind="stable")]
        ).astype(np.int64)
        warm_up = round(self.warm_up_s / STEP_S)
        road = HighwayState(
            -warm_up, numbers, integers=integers, order=order, drivers=traits, next_id=vehicles, rng=rng
        )
        past = self._past(numbers[highway_kernels.V], -warm_up)
        nothing = np.zeros(kernels.COUNTS, dtype=np.int64)
        state = BrakingState(road, past, counts=nothing, waiting_s=np.zeros(0))
        for _ in range(warm_up):
            state = self.step(state)
        return replace(state, counts=nothing)

    def step(self, state: BrakingState) -> BrakingState:
        """Return the state a step later."""
        road = state.road
        stream = kernels.Stream(
            road.numbers.copy(),
            road.integers.copy(),
            road.order.copy(),
            state.history.copy(),
            state.counts.copy(),
        )
        waiting_s = state.waiting_s
        if road.number >= 0:
            self._draw_brakings(stream, road.rng)
            waiting_s = self._draw_cut_ins(stream, road, waiting_s)
        next_id = kernels.step(
            stream,
            road.drivers,
            np.array([0, self._road.forward, self.slots], dtype=np.int64),
            self._road.settings(),
            road.rng.standard_normal((highway_kernels.NORMALS, self.slots)),
            road.number % state.history.shape[1],
            road.next_id,
            self.lanes,
            STEP_S,
        )
        moved = replace(
            road,
            number=road.number + 1,
            numbers=stream.numbers,
            integers=stream.integers,
            order=stream.order,
            next_id=next_id,
        )
        return BrakingState(moved, stream.history, counts=stream.counts, waiting_s=waiting_s)

    def frame(self, state: BrakingState) -> FleetFrame:
        """Return the fleet; every slot is active."""
        return self._road.frame(state.road)

    def _lay_out(
        self,
        who: IntArray,
        traits: FloatArray,
        numbers: FloatArray,
        integers: IntArray,
        rng: np.random.Generator,
    ) -> None:
        """Place the vehicles of a lane, from the rear, in streams at one speed."""
        length, least = traits[following.LENGTH, who], traits[following.GAP, who]
        headway = traits[following.HEADWAY, who]
        fits = (1.0 - _FREE_RATIO) * self.length_m - float((length + least).sum())
        speed = min(0.95 * float(traits[following.DESIRED_SPEED, who].min()), fits / float(headway.sum()))
        if speed < _SLOWEST_MPS:
            raise ValueError(
                f"{who.size} vehicles do not fit into a lane of {self.length_m} m as streams at "
                f"{_SLOWEST_MPS} m/s: lower density_per_km, now {self.density_per_km}, or raise lanes, now "
                f"{self.lanes}"
            )
        leads = (np.arange(who.size) % self.vehicles == self.vehicles - 1) | (
            np.arange(who.size) == who.size - 1
        )
        share = np.where(leads, rng.uniform(0.5, 1.5, who.size), 0.0)
        gap = least + speed * headway
        gap += (self.length_m - float((length + gap).sum())) * share / float(share.sum())
        behind = np.concatenate([[0.0], (gap[:-1] + 0.5 * (length[:-1] + length[1:])).cumsum()])
        numbers[highway_kernels.S, who] = (behind + rng.uniform(0.0, self.length_m)) % self.length_m
        numbers[highway_kernels.V, who] = speed
        integers[kernels.LEADS, who] = leads

    def _past(self, speed_mps: FloatArray, number: int) -> FloatArray:
        """Return a history of steady driving up to a step."""
        steps = round(self.reaction_s[1] / STEP_S) + 1
        history = np.zeros((3, steps, speed_mps.size))
        for ago in range(steps):
            row = (number - ago) % steps
            history[0, row] = -speed_mps * ago * STEP_S
            history[1, row] = speed_mps
        return history

    def _draw_brakings(self, stream: kernels.Stream, rng: np.random.Generator) -> None:
        """Let leaders begin to brake."""
        numbers, integers = stream.numbers, stream.integers
        for _ in range(int(rng.poisson(self.brakings_per_minute * STEP_S / 60.0))):
            speed = numbers[highway_kernels.V]
            free = (integers[kernels.LEADS] == 1) & (integers[kernels.PHASE] == kernels.DRIVES)
            free &= (speed >= _SLOWEST_MPS) & (numbers[highway_kernels.PROGRESS] >= 1.0)
            if not free.any():
                continue
            i = int(rng.choice(np.flatnonzero(free)))
            deceleration = float(rng.uniform(*self.deceleration_mps2))
            most = max(0.0, float(speed[i]) - kernels.least_drop_mps(deceleration) - _SPARE_MPS)
            ends = float(rng.uniform(0.0, most))
            numbers[kernels.BRAKE_MPS2, i] = deceleration
            numbers[kernels.BRAKE_TO_MPS, i] = 0.0 if rng.random() < self.stop_ratio else ends
            numbers[kernels.HOLD_S, i] = rng.uniform(*self.hold_s)
            integers[kernels.PHASE, i] = kernels.PRESSES
            stream.counts[kernels.BRAKINGS] += 1

    def _draw_cut_ins(self, stream: kernels.Stream, road: HighwayState, waiting_s: FloatArray) -> FloatArray:
        """Let vehicles cut in, and brake once they are in the lane; return the gaps still waited for."""
        rng, numbers, integers = road.rng, stream.numbers, stream.integers
        there = (integers[kernels.CUTS_IN] == 1) & (
            numbers[highway_kernels.PROGRESS] >= highway_kernels.LEFT_OLD_LANE
        )
        for i in np.flatnonzero(there):
            integers[kernels.CUTS_IN, i] = 0
            if integers[kernels.PHASE, i] == kernels.DRIVES:
                numbers[kernels.BRAKE_MPS2, i] = rng.uniform(*self.cut_in_mps2)
                slower = numbers[highway_kernels.V, i] - rng.uniform(*_CUT_IN_DROP_MPS)
                numbers[kernels.BRAKE_TO_MPS, i] = max(0.0, slower)
                numbers[kernels.HOLD_S, i] = rng.uniform(*self.hold_s)
                integers[kernels.PHASE, i] = kernels.PRESSES
        drawn = int(rng.poisson(self.cut_ins_per_minute * STEP_S / 60.0)) if self.cut_ins_per_minute else 0
        waiting = [*waiting_s, *rng.uniform(*self.cut_in_gap_s, drawn)]
        left: list[float] = []
        for gap_s in waiting:
            found = find_cut_in(
                road,
                stream,
                length_m=self.length_m,
                forward=self._road.forward,
                gap_s=float(gap_s),
            )
            if found is None:
                left.append(float(gap_s))
                continue
            who, lane = found
            integers[highway_kernels.OLD_LANE, who] = integers[highway_kernels.LANE, who]
            integers[highway_kernels.LANE, who] = lane
            integers[kernels.CUTS_IN, who] = 1
            numbers[highway_kernels.PROGRESS, who] = 0.0
            stream.counts[kernels.CUT_INS] += 1
        return np.array(left[:_MOST_WAITING])

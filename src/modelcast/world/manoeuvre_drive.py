"""Generated drives whose manoeuvres are known: what counting manoeuvres is measured by.

A drive is a random row of manoeuvres and of what looks like one and is none: bends, S-bends, motorway ramps,
swerves within the lane, gentle braking, crawling, and a sway about the lane's middle all along. Sizes,
durations and shapes are drawn from wide ranges, so that no shape that is looked for is the one driven.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind, Side
from modelcast.trips.trajectory import Trajectory
from modelcast.world.script import FINE_S, Script, at_rows, integrate, lateral_wave

__all__ = ["KnownDrive", "coarsened", "generate_known_drive"]

_FIRST_SPEED_MPS = 10.0
_JERK_MPS3 = 2.0
_HARD_JERK_MPS3 = 15.0
_SWAY_M = 0.15  # amplitude of each of three waves about the lane's middle
_SWAY_SPEED_MPS = 4.0


@dataclass(frozen=True, slots=True)
class KnownDrive:
    """A drive without errors, and what was done in it.

    Parameters
    ----------
    truth
        Positions, speed, heading, acceleration and yaw rate.
    manoeuvres
        What was done, in order of time.
    """

    truth: Trajectory
    manoeuvres: tuple[FoundManoeuvre, ...]


@dataclass(frozen=True, slots=True)
class _Plan:
    """A script being written, the generator it is drawn from, and the manoeuvres done so far."""

    script: Script
    rng: np.random.Generator
    done: list[FoundManoeuvre]

    @property
    def now_s(self) -> float:
        return self.script.steps * FINE_S

    def side(self) -> float:
        return float(self.rng.choice([-1.0, 1.0]))

    def draw(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def reach(self, low_mps: float, high_mps: float) -> None:
        """Take a speed drawn from a range, gently, unless it has one."""
        if not low_mps <= self.script.speed_mps <= high_mps:
            self.script.change_speed("speed", self.draw(low_mps, high_mps), self.draw(1.0, 2.5), _JERK_MPS3)

    def note(self, kind: ManoeuvreKind, start_s: float, size: float, side: float = 0.0) -> None:
        sides: dict[float, Side] = {-1.0: "left", 0.0: "", 1.0: "right"}
        self.done.append(FoundManoeuvre(kind, start_s, self.now_s, size=abs(size), side=sides[side]))


def _lane_change(plan: _Plan) -> None:
    plan.reach(8.0, 32.0)
    side, start, shift = plan.side(), plan.now_s, plan.draw(2.8, 3.7)
    plan.script.change_lane(side, plan.draw(3.0, 8.0), shift, plan.draw(0.35, 0.65))
    plan.note(ManoeuvreKind.LANE_CHANGE, start, shift, side)


def _lane_change_in_bend(plan: _Plan) -> None:
    """A lane change on a bend of one radius."""
    plan.reach(12.0, 32.0)
    side, start, shift, duration = plan.side(), plan.now_s, plan.draw(2.8, 3.7), plan.draw(3.5, 7.0)
    lateral = plan.side() * plan.draw(0.3, 1.5)
    ramp = np.linspace(0.0, lateral, 100)
    around = np.full(round(plan.draw(3.0, 4.0) / FINE_S), lateral)
    wave = lateral_wave(side * shift, duration, plan.draw(0.4, 0.6))[1] + lateral
    across = np.concatenate([ramp, around, wave, around, ramp[::-1]])
    plan.script.add("lane change in a bend", np.zeros(across.size), across)
    start += (ramp.size + around.size) * FINE_S
    kind = ManoeuvreKind.LANE_CHANGE
    known = FoundManoeuvre(kind, start, start + duration, size=shift, side="right" if side > 0.0 else "left")
    plan.done.append(known)


def _turn(plan: _Plan) -> None:
    plan.reach(4.5, 8.0)
    side, start, angle = plan.side(), plan.now_s, np.deg2rad(plan.draw(55.0, 125.0))
    plan.script.turn(side * angle, plan.draw(1.8, 3.0))
    plan.note(ManoeuvreKind.TURN, start, angle, side)


def _u_turn(plan: _Plan) -> None:
    plan.reach(3.0, 4.0)
    side, start, angle = plan.side(), plan.now_s, np.deg2rad(plan.draw(172.0, 188.0))
    plan.script.turn(side * angle, plan.draw(1.6, 2.2))
    plan.note(ManoeuvreKind.U_TURN, start, angle, side)


def _roundabout(plan: _Plan) -> None:
    """Entry to one side, circulation to the other, exit to the first."""
    plan.reach(5.5, 8.0)
    side, start = plan.side(), plan.now_s
    angle = np.deg2rad(plan.draw(55.0, 290.0))
    plan.script.turn(-side * np.deg2rad(plan.draw(25.0, 50.0)), plan.draw(1.8, 2.8))
    plan.script.keep("roundabout", plan.draw(0.1, 0.5))
    plan.script.turn(side * angle, plan.draw(2.0, 3.0))
    plan.script.keep("roundabout", plan.draw(0.1, 0.5))
    plan.script.turn(-side * np.deg2rad(plan.draw(25.0, 50.0)), plan.draw(1.8, 2.8))
    plan.note(ManoeuvreKind.ROUNDABOUT, start, angle, side)


def _stop(plan: _Plan) -> None:
    plan.reach(6.0, 20.0)
    plan.script.change_speed("brake", 0.0, plan.draw(1.2, 2.8), _JERK_MPS3)
    start, stood = plan.now_s, plan.draw(2.5, 20.0)
    plan.script.keep("stop", stood)
    plan.note(ManoeuvreKind.STOP, start, stood)


def _hard_brake(plan: _Plan) -> None:
    plan.reach(14.0, 32.0)
    start, peak = plan.now_s, plan.draw(4.8, 8.5)
    plan.script.change_speed("hard brake", plan.draw(2.0, 5.0), peak, _HARD_JERK_MPS3)
    plan.note(ManoeuvreKind.HARD_BRAKE, start, peak)


def _bend(plan: _Plan) -> None:
    """A bend of the road: wider than a turn, at the speed of the road."""
    plan.reach(14.0, 32.0)
    plan.script.turn(plan.side() * np.deg2rad(plan.draw(8.0, 75.0)), plan.draw(0.4, 2.0))


def _s_bend(plan: _Plan) -> None:
    plan.reach(14.0, 32.0)
    side, angle, lateral = plan.side(), np.deg2rad(plan.draw(8.0, 40.0)), plan.draw(0.4, 2.0)
    plan.script.turn(side * angle, lateral)
    plan.script.keep("bend", plan.draw(0.1, 4.0))
    plan.script.turn(-side * angle * plan.draw(0.7, 1.3), lateral)


def _staggered(plan: _Plan) -> None:
    """Two turns to opposite sides, some metres apart: no roundabout."""
    side = plan.side()
    for turned in (side, -side):
        plan.reach(4.5, 8.0)
        start, angle = plan.now_s, np.deg2rad(plan.draw(70.0, 100.0))
        plan.script.turn(turned * angle, plan.draw(1.8, 3.0))
        plan.note(ManoeuvreKind.TURN, start, angle, turned)
        plan.script.keep("between", plan.draw(1.0, 4.0))


def _ramp(plan: _Plan) -> None:
    """A loop of a motorway junction: far round, and too wide for a roundabout or a turn."""
    plan.reach(14.0, 18.0)
    plan.script.turn(plan.side() * np.deg2rad(plan.draw(150.0, 280.0)), plan.draw(2.0, 2.6))


def _swerve(plan: _Plan) -> None:
    """A shift within the lane, as past a parked car."""
    plan.reach(8.0, 25.0)
    plan.script.change_lane(plan.side(), plan.draw(2.5, 5.0), plan.draw(0.5, 1.3))


def _crawl(plan: _Plan) -> None:
    """Slow down without standing."""
    plan.script.change_speed("brake", plan.draw(1.5, 3.0), plan.draw(1.0, 2.8), _JERK_MPS3)
    plan.script.keep("crawl", plan.draw(2.0, 6.0))


_MENU: Mapping[Callable[[_Plan], None], float] = {
    _lane_change: 0.16,
    _lane_change_in_bend: 0.06,
    _turn: 0.10,
    _staggered: 0.04,
    _ramp: 0.03,
    _u_turn: 0.04,
    _roundabout: 0.09,
    _stop: 0.08,
    _hard_brake: 0.07,
    _bend: 0.13,
    _s_bend: 0.08,
    _swerve: 0.08,
    _crawl: 0.07,
}


def generate_known_drive(seed: int, duration_s: float = 1200.0, rate_hz: float = 10.0) -> KnownDrive:
    """Drive of manoeuvres, and of what looks like one, in random order.

    Parameters
    ----------
    seed
        Same seed, same bytes.
    duration_s
        Length of the drive [s]; it ends after the manoeuvre that reaches it.
    rate_hz
        Rows a second [Hz], at most 50.

    Raises
    ------
    ValueError
        Where the duration is not positive or the rate is not in (0, 50].

    Examples
    --------
    >>> drive = generate_known_drive(1, 120.0)
    >>> [(one.kind.value, one.side) for one in drive.manoeuvres][:2]
    [('roundabout', 'left'), ('lane change', 'left')]
    """
    if not duration_s > 0.0:
        raise ValueError(f"duration_s must be positive, got {duration_s}")
    if not 0.0 < rate_hz <= 50.0:
        raise ValueError(f"rate_hz must lie in (0, 50], got {rate_hz}")
    rng, sway_rng = np.random.default_rng(seed).spawn(2)
    plan = _Plan(Script(_FIRST_SPEED_MPS), rng, [])
    plan.script.keep("cruise", 5.0)
    items, shares = list(_MENU), np.array(list(_MENU.values()))
    while plan.now_s < duration_s:
        items[int(rng.choice(len(items), p=shares / shares.sum()))](plan)
        plan.reach(6.0, 32.0)
        plan.script.keep("cruise", plan.draw(1.5, 9.0), plan.draw(0.0, 0.4))
    heading = float(rng.uniform(-np.pi, np.pi))
    _sway(plan.script, sway_rng)
    fine = integrate(plan.script, speed_mps=_FIRST_SPEED_MPS, heading_rad=heading)
    rows = np.round(np.arange(int(plan.now_s * rate_hz)) / rate_hz / FINE_S).astype(np.int64)
    return KnownDrive(at_rows(fine, rows, f"known/{seed}"), tuple(plan.done))


def _sway(script: Script, rng: np.random.Generator) -> None:
    """Add three waves about the lane's middle to the lateral acceleration wherever the vehicle is fast."""
    along, across = np.concatenate(script.along), np.concatenate(script.across)
    t_s = np.arange(across.size) * FINE_S
    speed = _FIRST_SPEED_MPS + np.cumsum(along) * FINE_S
    for period_s in rng.uniform(6.0, 25.0, 3):
        pulsation = 2.0 * np.pi / period_s
        phase = rng.uniform(0.0, 2.0 * np.pi)
        wave = -_SWAY_M * pulsation**2 * np.sin(pulsation * t_s + phase)
        across = across + np.where(speed > _SWAY_SPEED_MPS, wave, 0.0)
    script.along[:], script.across[:] = [along], [across]


def coarsened(trip: Trajectory, grid_m: tuple[float, float], held_s: float) -> Trajectory:
    """Trip as a coarse recorder writes it: positions on a grid, all else held, yaw rate left out.

    Parameters
    ----------
    trip
        The trip.
    grid_m
        Steps of the grid east and north [m].
    held_s
        How long speed, heading and acceleration keep a value [s].
    """
    rows = max(1, round(held_s / trip.dt_s))
    last = np.arange(len(trip)) // rows * rows

    def held(column: FloatArray | None) -> FloatArray | None:
        return None if column is None else column[last]

    return replace(
        trip,
        position_m=np.round(trip.position_m / grid_m) * grid_m,
        speed_mps=held(trip.speed_mps),
        heading_rad=held(trip.heading_rad),
        acceleration_mps2=held(trip.acceleration_mps2),
        yaw_rate_radps=None,
    )

"""Speed, growth of cost with the fleet, and gentleness of the built-in traffic."""

import time

import numpy as np

from measured import record
from modelcast.core.arrays import FloatArray
from modelcast.world.scenario.base import STEP_S, AbstractScenario, FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import sensed
from modelcast.world.sensors import SensorModel

DURATION_S = 60.0


def jerk_mps3(frames: list[FleetFrame]) -> float:
    """Return the root mean square of the jerk along the course, whoever changes slot left out."""
    identity = np.array([frame.vehicle_id for frame in frames])
    acceleration: FloatArray = np.array([frame.acceleration_mps2 for frame in frames])
    jerk = (np.diff(acceleration, axis=0) / STEP_S)[identity[1:] == identity[:-1]]
    return float(np.sqrt((jerk**2).mean()))


def measure(kind: str, name: str, scenario: AbstractScenario[object]) -> None:
    """Print the speed of one scenario, compiled already, and its jerk."""
    state = scenario.init(np.random.default_rng(1))
    frames = [scenario.frame(state)]
    steps = round(DURATION_S / STEP_S)
    begun = time.process_time()
    for _ in range(steps):
        state = scenario.step(state)
        frames.append(scenario.frame(state))
    took = time.process_time() - begun
    speed = np.array([frame.speed_mps for frame in frames])
    record(
        kind, 1e6 * took / steps / scenario.slots, "µs a vehicle and step", sizes={"vehicles": scenario.slots}
    )
    print(
        f"{name:28s} {scenario.slots:6d} vehicles {DURATION_S / took:7.0f} x real time (CPU) "
        f"{1e6 * took / steps / scenario.slots:6.3f} us a vehicle and step, "
        f"mean {speed.mean():5.1f} m/s, jerk {jerk_mps3(frames):.2f} m/s3"
    )


def main() -> None:
    """Measure highways and grids of several sizes, and the sensors of 1,000 vehicles."""
    list(run_scenario(Highway(warm_up_s=1.0), np.random.default_rng(0), duration_s=1.0))
    list(run_scenario(Grid(warm_up_s=1.0), np.random.default_rng(0), duration_s=1.0))
    for length_m in (1250.0, 5000.0, 25000.0, 50000.0):
        measure("highway, 200/km", f"highway 200/km, {length_m / 1000:g} km", Highway(length_m, 200.0))
    for density, lanes in ((25.0, 3), (100.0, 3), (400.0, 4), (800.0, 5), (1200.0, 6)):
        measure(
            "highway, 2 km",
            f"highway {density:g}/km, 2 km, {lanes} lanes",
            Highway(2000.0, density, lanes=lanes),
        )
    for side, density in ((5, 20.0), (8, 45.0), (20, 33.0)):
        measure("grid", f"grid {side} x {side}, {density:g}/km", Grid(side, side, density))
    frames = list(run_scenario(Highway(5000.0, 200.0), np.random.default_rng(1), duration_s=DURATION_S))
    begun = time.process_time()
    for _ in sensed(frames, SensorModel(slow_position_noise_m=0.5), np.random.default_rng(2)):
        pass
    print(f"sensors of 1,000 vehicles    {DURATION_S / (time.process_time() - begun):7.0f} x real time")


if __name__ == "__main__":
    main()

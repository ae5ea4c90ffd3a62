"""A platoon on a straight road in SUMO: where its vehicles are, and the accelerations they are given."""

# libsumo's stubs leave most results open.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportMissingImports=false

import os
import subprocess
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from math import radians
from pathlib import Path

import libsumo
import numpy as np
import numpy.typing as npt
import sumo

from modelcast import FleetFrame

STEP_S = 0.1
LENGTH_M = 4.0
ROAD_M = 20_000.0


class SumoPlatoon:
    """N vehicles one behind the other, the leader first.

    Parameters
    ----------
    vehicles
        N.
    """

    def __init__(self, vehicles: int) -> None:
        self.names = [f"v{number}" for number in range(vehicles)]
        self.t_s = 0.0

    def frame(self) -> FleetFrame:
        """Where all are now; SUMO's positions are front bumpers, a frame's the middles."""
        vehicle = libsumo.vehicle
        front_m = np.array([vehicle.getPosition(name) for name in self.names])
        heading_rad = np.array([radians(vehicle.getAngle(name)) for name in self.names])
        ahead = np.stack([np.sin(heading_rad), np.cos(heading_rad)], axis=1)
        number = len(self.names)
        return FleetFrame(
            self.t_s,
            front_m - 0.5 * LENGTH_M * ahead,
            speed_mps=np.array([vehicle.getSpeed(name) for name in self.names]),
            heading_rad=heading_rad,
            acceleration_mps2=np.array([vehicle.getAcceleration(name) for name in self.names]),
            yaw_rate_radps=np.zeros(number),
            length_m=np.full(number, LENGTH_M),
            vehicle_id=np.arange(number),
            active=np.ones(number, dtype=np.bool_),
        )

    def drive(self, leader_mps: float, acceleration_mps2: npt.NDArray[np.float64]) -> None:
        """Let the leader take a speed and the followers an acceleration, and SUMO move all by a step.

        Parameters
        ----------
        leader_mps
            Speed of the leader after the step [m/s].
        acceleration_mps2
            Of the followers, (N - 1,) [m/s²].
        """
        libsumo.vehicle.setSpeed(self.names[0], leader_mps)
        for name, wanted in zip(self.names[1:], acceleration_mps2.tolist(), strict=True):
            libsumo.vehicle.setSpeed(name, max(libsumo.vehicle.getSpeed(name) + wanted * STEP_S, 0.0))
        libsumo.simulationStep()
        self.t_s = round(self.t_s + STEP_S, 6)


@contextmanager
def sumo_platoon(vehicles: int, gap_m: float, speed_mps: float) -> Generator[SumoPlatoon]:
    """A platoon that drives at one speed with one gap.

    Parameters
    ----------
    vehicles
        With the leader.
    gap_m
        Between two of them [m].
    speed_mps
        Their speed [m/s].
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        network = _network(folder)
        first_m = (vehicles + 1) * (gap_m + LENGTH_M)
        # Nothing of SUMO's own between the vehicles: gaps are the followers' affair.
        car = (
            f'<vType id="car" length="{LENGTH_M}" minGap="0" tau="{STEP_S}" accel="10" decel="10" '
            'emergencyDecel="10" maxSpeed="100" sigma="0" speedDev="0"/>'
        )
        lines = [
            car,
            '<route id="road" edges="road"/>',
            *(
                _vehicle(number, first_m - number * (gap_m + LENGTH_M), speed_mps)
                for number in range(vehicles)
            ),
        ]
        routes = folder / "platoon.rou.xml"
        routes.write_text("<routes>" + "\n".join(lines) + "</routes>", encoding="utf-8")
        libsumo.start(
            [
                "sumo", "-n", str(network), "-r", str(routes), "--step-length", str(STEP_S),
                "--collision.action", "none", "--no-step-log", "--no-warnings",
            ]
        )  # fmt: skip
        try:
            libsumo.simulationStep()
            platoon = SumoPlatoon(vehicles)
            for label in platoon.names:
                libsumo.vehicle.setSpeedMode(label, 0)
            yield platoon
        finally:
            libsumo.close()


def _vehicle(number: int, place_m: float, speed_mps: float) -> str:
    return (
        f'<vehicle id="v{number}" type="car" route="road" depart="0" insertionChecks="none" '
        f'departPos="{place_m}" departSpeed="{speed_mps}"/>'
    )


def _network(folder: Path) -> Path:
    """A straight road to the east, of one lane."""
    (folder / "road.nod.xml").write_text(
        f'<nodes><node id="a" x="0" y="0"/><node id="b" x="{ROAD_M}" y="0"/></nodes>', encoding="utf-8"
    )
    (folder / "road.edg.xml").write_text(
        '<edges><edge id="road" from="a" to="b" numLanes="1" speed="60"/></edges>', encoding="utf-8"
    )
    network = folder / "road.net.xml"
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    files = ["-n", str(folder / "road.nod.xml"), "-e", str(folder / "road.edg.xml"), "-o", str(network)]
    environment = {**os.environ, "SUMO_HOME": sumo.SUMO_HOME}
    subprocess.run([str(program), *files], check=True, capture_output=True, env=environment)  # noqa: S603
    return network

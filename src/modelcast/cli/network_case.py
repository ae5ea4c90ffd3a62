"""One run of ``modelcast network``: which traffic, which radio, which sender; what a worker process does."""

import tempfile
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import KW_ONLY, asdict, dataclass
from pathlib import Path
from typing import Any

from modelcast.cli.options import SensorOptions
from modelcast.core.chance import child_generator
from modelcast.core.exceptions import ConfigError
from modelcast.evaluation.network.measure import measure
from modelcast.evaluation.network.rows import CaseResult, NetworkCase
from modelcast.simulation.network.engine import run_network
from modelcast.simulation.network.sender import named_sender
from modelcast.simulation.network.settings import NetworkSettings
from modelcast.simulation.scenario.base import FleetFrame, run_scenario
from modelcast.simulation.scenario.grid import Grid
from modelcast.simulation.scenario.highway import Highway
from modelcast.simulation.scenario.sensed import FleetSensor

__all__ = ["BUILT_IN", "RADIOS", "SUMO", "NetworkPlan", "run_case"]

BUILT_IN = ("highway", "grid")
SUMO = ("sumo-highway", "sumo-grid", "sumo-junction")
RADIOS = ("dsrc", "sidelink", "abstract")

_BLOCK_M = 200.0
_STREET_M = 30.0
_MOST_SUMO_VEHICLES = 1.6
"""Slots for SUMO's traffic over the vehicles that the density asks for: what flows in varies."""


@dataclass(frozen=True, slots=True)
class NetworkPlan:
    """What all runs of one call share.

    Parameters
    ----------
    scenario
        A name of `BUILT_IN` or `SUMO`, or a file of floating-car data.
    duration_s, warm_up_s
        Time simulated, and how much of it is left out of the counts [s].
    length_m
        Length of a highway [m].
    lanes
        Lanes in each direction of a highway; 0 for as many as the density needs.
    blocks
        Junctions on each side of a grid.
    seed
        Of all random numbers.
    certificates
        Rule of the certificates.
    threshold_m, keep_alive_s
        Of error-driven senders [m], [s].
    sensor
        What vehicles see of themselves.
    """

    scenario: str
    _: KW_ONLY
    duration_s: float
    warm_up_s: float
    length_m: float
    lanes: int
    blocks: int
    seed: int
    certificates: str
    threshold_m: float
    keep_alive_s: float
    sensor: SensorOptions

    def as_plain(self) -> dict[str, Any]:
        """All of it as plain values; a file by its name."""
        return {**asdict(self), "scenario": Path(self.scenario).name}

    @property
    def settings(self) -> NetworkSettings:
        """What is tracked and counted."""
        return NetworkSettings(warm_up_s=self.warm_up_s)

    def lanes_for(self, density_per_km: float) -> int:
        """Lanes in each direction: as given, or one more for each density that fills the last."""
        if self.lanes:
            return self.lanes
        return 3 + sum(density_per_km > full for full in (200.0, 400.0, 800.0))


@contextmanager
def _frames(plan: NetworkPlan, case: NetworkCase) -> Generator[Iterator[FleetFrame]]:
    """The traffic of one run; all policies and radios of a seed and density meet the same."""
    rng = child_generator(plan.seed, case.run, "traffic")
    if plan.scenario == "highway":
        road = Highway(plan.length_m, case.density_per_km, lanes=plan.lanes_for(case.density_per_km))
        yield run_scenario(road, rng, duration_s=plan.duration_s)
    elif plan.scenario == "grid":
        grid = Grid(plan.blocks, plan.blocks, case.density_per_km, block_m=_BLOCK_M)
        yield run_scenario(grid, rng, duration_s=plan.duration_s)
    elif plan.scenario in SUMO:
        with tempfile.TemporaryDirectory(prefix="modelcast-") as name:
            yield _sumo_frames(plan, case, Path(name))
    else:
        from modelcast.io.fcd import read_fcd
        from modelcast.simulation.scenario.base import STEP_S
        from modelcast.simulation.scenario.resampling import resampled

        frames = resampled(read_fcd(plan.scenario), STEP_S)
        yield (frame for frame in frames if frame.t_s < plan.duration_s)


def _sumo_frames(plan: NetworkPlan, case: NetworkCase, folder: Path) -> Iterator[FleetFrame]:
    from modelcast.io.sumo import run_sumo
    from modelcast.io.sumo_networks import grid_input, highway_input, junction_input

    seed, lasts_s = plan.seed + case.run, plan.duration_s + 60.0
    density = case.density_per_km
    if plan.scenario == "sumo-highway":
        source = highway_input(
            folder, length_m=plan.length_m, density_per_km=density, lanes=plan.lanes_for(density), seed=seed,
            duration_s=lasts_s,
        )  # fmt: skip
        vehicles = density * plan.length_m / 1000.0
    elif plan.scenario == "sumo-grid":
        source = grid_input(
            folder, columns=plan.blocks, rows=plan.blocks, density_per_km=density, block_m=_BLOCK_M,
            seed=seed, duration_s=lasts_s,
        )  # fmt: skip
        vehicles = density * 2.0 * plan.blocks * (plan.blocks - 1) * _BLOCK_M / 1000.0
    else:
        source = junction_input(folder, seed=seed, duration_s=lasts_s)
        vehicles = 200.0
    slots = int(_MOST_SUMO_VEHICLES * vehicles) + 50
    return run_sumo(source, slots=slots, duration_s=plan.duration_s, seed=seed, warm_up_s=30.0)


def _radio(plan: NetworkPlan, name: str) -> tuple[Any, float]:
    """The radio of that name, and the width of its bins of distance."""
    from modelcast.channel.dsrc import Dsrc
    from modelcast.channel.path_loss import ManhattanNlos
    from modelcast.channel.propagation import Propagation, Shadowing, StreetGrid
    from modelcast.channel.sidelink import Sidelink
    from modelcast.channel.tabulated import TabulatedRadio, measured_table

    town = plan.scenario in {"grid", "sumo-grid"}
    propagation = Propagation()
    if town:
        streets = StreetGrid(_BLOCK_M, _STREET_M)
        shadowing = Shadowing(decorrelation_m=10.0)
        propagation = Propagation(shadowing=shadowing, streets=streets, nlos=ManhattanNlos())
    if name == "dsrc":
        dsrc = Dsrc(propagation=propagation)
        return dsrc, dsrc.parameters.bin_m
    if name == "sidelink":
        sidelink = Sidelink(propagation=propagation)
        return sidelink, sidelink.parameters.bin_m
    table = measured_table()
    return TabulatedRadio(table), table.bin_m


def run_case(plan: NetworkPlan, case: NetworkCase) -> CaseResult:
    """Run one case and return its rows.

    Parameters
    ----------
    plan
        What all runs share.
    case
        The run.

    Raises
    ------
    ConfigError
        Where an option is out of its range, or the traffic does not fit.
    """
    from modelcast.messages.airtime import Stack

    certificates: Any = plan.certificates
    try:
        sender = named_sender(
            case.policy,
            threshold_m=plan.threshold_m,
            keep_alive_s=plan.keep_alive_s,
            stack=Stack(certificates),
        )
        radio, bin_m = _radio(plan, case.radio)
        model = plan.sensor.model()
        seed = int(child_generator(plan.seed, case.run, "loop").integers(2**31))
        with _frames(plan, case) as frames:
            run = run_network(frames, sender, radio, plan.settings, seed=seed, sensor=FleetSensor(model))
    except ValueError as error:
        raise ConfigError(str(error)) from error
    return measure(run, case, plan.settings, outcome_bin_m=bin_m)

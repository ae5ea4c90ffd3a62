"""Fleets on a shared channel, for every scenario, radio and sender asked for: runs in, one result out."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from itertools import product
from math import nan
from typing import Any

import numpy as np

from modelcast.channel.radio import AbstractRadio
from modelcast.core.chance import child_generator
from modelcast.core.exceptions import ConfigError
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.sender import Sender
from modelcast.study.network.measure import measure
from modelcast.study.network.pool import gather
from modelcast.study.network.rows import (
    NO_BANK,
    NO_THRESHOLD,
    SENDERS,
    CaseResult,
    NetworkCase,
    NetworkResult,
)
from modelcast.study.table import Row
from modelcast.world.scenario.base import AbstractScenario, run_scenario
from modelcast.world.scenario.motion import checked
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

__all__ = ["FleetJob", "FleetRuns", "loop_seed", "run_fleet", "simulate_fleets", "traffic_chance"]


@dataclass(frozen=True, slots=True)
class FleetRuns:
    """How often and how long fleets run, and what is counted.

    Parameters
    ----------
    duration_s
        Time simulated [s].
    seeds
        Runs of each combination.
    seed
        Seed of all random numbers.
    settings
        What is tracked and counted.
    sensor
        What vehicles see of themselves.
    threads
        Threads of each run; the result is the same whatever their number.

    Raises
    ------
    ValueError
        Where there is no run, or none that lasts.
    """

    duration_s: float = 30.0
    _: KW_ONLY
    seeds: int = 1
    seed: int = 0
    settings: NetworkSettings = field(default_factory=NetworkSettings)
    sensor: SensorModel = field(default_factory=SensorModel)
    threads: int = 1

    def __post_init__(self) -> None:
        if self.seeds < 1:
            raise ValueError(f"seeds must be at least 1, got {self.seeds}")
        if not self.duration_s > self.settings.warm_up_s:
            raise ValueError(
                f"duration_s must be longer than the warm-up of {self.settings.warm_up_s} s, "
                f"got {self.duration_s}"
            )


def traffic_chance(seed: int, run: int) -> np.random.Generator:
    """Chance of the traffic of a run: all senders and radios of it meet the same.

    Parameters
    ----------
    seed
        Of all runs.
    run
        Its number, from 0.
    """
    return child_generator(seed, run, "traffic")


def loop_seed(seed: int, run: int) -> int:
    """Seed of the senders, radio and sensors of a run.

    Parameters
    ----------
    seed
        Of all runs.
    run
        Its number, from 0.
    """
    return int(child_generator(seed, run, "loop").integers(2**31))


@dataclass(frozen=True, slots=True)
class FleetJob:
    """One run, as it is handed to a process.

    Parameters
    ----------
    case
        What it is called.
    scenario, radio, sender
        Its traffic, its channel, and what every vehicle sends.
    runs
        How long it lasts, and what is counted.
    """

    case: NetworkCase
    scenario: AbstractScenario[Any]
    radio: AbstractRadio[Any]
    sender: Sender
    runs: FleetRuns


def run_fleet(job: FleetJob) -> CaseResult:
    """Do one run and return its rows.

    Parameters
    ----------
    job
        Which.

    Raises
    ------
    ValueError
        Where vehicles do not fit on the road, or do not move as their columns say.
    """
    runs, case = job.runs, job.case
    frames = run_scenario(job.scenario, traffic_chance(runs.seed, case.run), duration_s=runs.duration_s)
    run = run_network(
        checked(frames),
        job.sender,
        job.radio,
        runs.settings,
        seed=loop_seed(runs.seed, case.run),
        sensor=FleetSensor(runs.sensor),
        threads=runs.threads,
    )
    return measure(run, case, runs.settings, outcome_bin_m=job.radio.bin_m)


def simulate_fleets(
    scenarios: Sequence[AbstractScenario[Any]],
    senders: Sequence[Sender],
    radios: Mapping[str, AbstractRadio[Any]],
    runs: FleetRuns,
    *,
    each: Callable[[Callable[[FleetJob], CaseResult], Iterable[FleetJob]], Iterable[CaseResult]] = map,
    progress: Callable[[int, int], None] | None = None,
) -> NetworkResult:
    """Run every sender over every radio in every scenario, and pool the runs.

    Parameters
    ----------
    scenarios
        Traffic; no two of one density.
    senders
        What every vehicle sends, and when; no two with one name, bank and threshold.
    radios
        Channels by name.
    runs
        How often, how long, and what is counted.
    each
        Applies a function to jobs and returns what it gave, in order: `map`, or one that shares the jobs out
        among processes, as `concurrent.futures.ProcessPoolExecutor.map`; the result is the same.
    progress
        Called with runs done and runs to do.

    Raises
    ------
    ConfigError
        Where there is nothing to run, or rows of two runs could not be told apart.
    ValueError
        Where vehicles do not fit on the road, or do not move as their columns say.

    Examples
    --------
    >>> from modelcast.channel.dsrc import Dsrc
    >>> from modelcast.station.sender.sender import named_sender
    >>> from modelcast.world.scenario.highway import Highway
    >>> road = Highway(500.0, 20.0, warm_up_s=0.0)
    >>> asked = FleetRuns(2.0, settings=NetworkSettings(warm_up_s=1.0))
    >>> found = simulate_fleets([road], [named_sender("bsm-10hz")], {"dsrc": Dsrc()}, asked)
    >>> [(row.policy, row.radio, round(row.message_rate_hz, 6)) for row in found.runs]
    [('bsm-10hz', 'dsrc', 10.0)]
    """
    cases = {
        _case(scenario, name, sender, run): (scenario, radio, sender)
        for run, scenario, (name, radio), sender in product(
            range(runs.seeds), scenarios, radios.items(), senders
        )
    }
    wanted = runs.seeds * len(scenarios) * len(radios) * len(senders)
    if not wanted:
        raise ConfigError("name at least one scenario, one radio and one sender")
    if len(cases) < wanted:
        raise ConfigError(
            "two runs could not be told apart: scenarios differ in density, senders in name, sub-models or "
            "threshold (dataclasses.replace gives a sender another name)"
        )
    results: list[CaseResult] = []
    for result in each(run_fleet, [FleetJob(case, *what, runs) for case, what in cases.items()]):
        results.append(result)
        if progress is not None:
            progress(len(results), wanted)
    return gather(results, [_sender_row(sender) for sender in senders if _bank(sender) != NO_BANK])


def _case(scenario: AbstractScenario[Any], radio: str, sender: Sender, run: int) -> NetworkCase:
    """What a run is called; the density is that of the scenario where it has one."""
    density_per_km = float(getattr(scenario, "density_per_km", nan))
    policy = sender.policy
    threshold_m = policy.threshold_m if isinstance(policy, ErrorDriven) else NO_THRESHOLD
    return NetworkCase(density_per_km, radio, sender.name, _bank(sender), threshold_m=threshold_m, run=run)


def _bank(sender: Sender) -> str:
    """The sub-models that a sender sends; `NO_BANK` where all its messages are plain ones."""
    return NO_BANK if all(sender.plain) else "+".join(member.name for member in sender.bank.members)


def _sender_row(sender: Sender) -> Row:
    rules = sender.lanes
    return SENDERS.row(
        policy=sender.name,
        bank=_bank(sender),
        sub_models=_bank(sender),
        start=rules.start,
        identify=rules.identify,
    )

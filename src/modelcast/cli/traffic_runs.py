"""The runs of the paper's claim on traffic: a plan goes the way of ``modelcast network``."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from modelcast.cli.network_cases import Varied, network_cases
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import sender_rows
from modelcast.cli.network_sweep import Sweep, sweep
from modelcast.cli.options import SensorOptions
from modelcast.study.network.densities import TrafficPlan
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row

__all__ = ["TrafficResult", "network_plan", "run_traffic"]


@dataclass(frozen=True, slots=True)
class TrafficResult:
    """What the runs of a plan came to.

    Parameters
    ----------
    rows
        The hybrid against the baseline, as `modelcast.study.network.pairs.traffic_rows` gives them.
    network
        Rows of all runs.
    """

    rows: tuple[Row, ...]
    network: NetworkResult


def network_plan(plan: TrafficPlan) -> NetworkPlan:
    """Return what all runs of a plan share: what it leaves open is as ``modelcast network`` has it.

    Parameters
    ----------
    plan
        The plan.
    """
    return NetworkPlan(
        "highway",
        duration_s=plan.duration_s,
        warm_up_s=plan.warm_up_s,
        length_m=plan.length_m,
        lanes=0,
        blocks=5,
        seed=0,
        certificates="gap",
        banks=plan.banks,
        profile=None,
        start=plan.start,
        identify=plan.identify,
        cost="bytes",
        threads=1,
        thresholds_m=plan.thresholds_m,
        keep_alive_s=2.0,
        believe=None,
        budget=4.0 / 3.0,
        approach_m=0.0,
        legacy_threshold_m=0.0,
        relaxed_error_m=None,
        sensor=SensorOptions(),
    )


def run_traffic(
    out: Path,
    plan: TrafficPlan,
    *,
    jobs: int,
    progress: Callable[[int, int], None],
    say: Callable[[str], None] = lambda _line: None,
) -> TrafficResult:
    """Run a traffic plan into a folder, as ``modelcast network`` would, and compare.

    Runs that an earlier call left there are taken up, also those of one that was interrupted. So a plan grows
    by seeds, densities, thresholds, radios and banks; other lengths and times need another folder.

    Parameters
    ----------
    out
        The output folder.
    plan
        What is run.
    jobs
        Runs at a time.
    progress
        Takes runs done and runs to do.
    say
        Takes lines for the user before the first run: how long the plan takes, how much of it is done.

    Raises
    ------
    ModelcastError
        Where the plan cannot be run, or the folder holds runs of other options.
    """
    shared = network_plan(plan)
    say(f"the whole plan takes about {_rounded(plan.expected_s(jobs))}, {jobs} at a time")
    cases = network_cases(shared, Varied(plan.densities_per_km, plan.radios, plan.policies, plan.seeds))
    asked = Sweep(shared, cases, senders=sender_rows(shared, plan.policies))

    @contextmanager
    def watch() -> Generator[Callable[[int, int], None]]:
        yield progress

    swept = sweep(asked, out, jobs=jobs, watch=watch, say=say)
    return TrafficResult(tuple(swept.rows), swept.result)


def _rounded(duration_s: float) -> str:
    """Whole hours, or under one of them whole minutes, one at least."""
    if duration_s >= 3600.0:
        return f"{duration_s / 3600.0:.0f} h"
    return f"{max(duration_s / 60.0, 1.0):.0f} min"

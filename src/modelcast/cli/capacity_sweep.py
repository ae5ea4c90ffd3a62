"""Bisections of ``modelcast capacity``: their runs are those of ``modelcast network``, kept as these are."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from modelcast.cli.network_case import run_case
from modelcast.cli.network_cases import Varied, network_cases
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.shared_work import Workers, workers
from modelcast.core.exceptions import ConfigError
from modelcast.io.capacity import write_capacity
from modelcast.io.network_runs import NetworkRunFiles
from modelcast.io.output import atomic_folder
from modelcast.io.run_store import RunStore, run_store
from modelcast.report.capacity import write_capacity_report
from modelcast.study.network.capacity import CapacityFound, Probe, bisected, probe_of
from modelcast.study.network.rows import CaseResult, NetworkCase, RunRow

__all__ = ["CapacitySearch", "search"]

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class CapacitySearch:
    """What is sought.

    Parameters
    ----------
    plan
        What all runs share.
    radios, policies, limits_m
        A bisection each.
    bounds_per_km, ratio, seeds
        As for `bisected`; runs of each density.
    """

    plan: NetworkPlan
    radios: tuple[str, ...]
    policies: tuple[str, ...]
    limits_m: tuple[float, ...]
    _: KW_ONLY
    bounds_per_km: tuple[float, float]
    ratio: float
    seeds: int

    def as_plain(self) -> dict[str, Any]:
        """As plain values."""
        return {
            **self.plan.as_plain(),
            "banks": list(self.plan.banks),
            "thresholds_m": list(self.plan.thresholds_m),
            "radios": list(self.radios),
            "policies": list(self.policies),
            "limits_m": list(self.limits_m),
            "bounds_per_km": list(self.bounds_per_km),
            "ratio": self.ratio,
            "seeds": self.seeds,
        }

    def cases(self, density_per_km: float, radio: str, policy: str) -> list[NetworkCase]:
        """The runs of one density.

        Parameters
        ----------
        density_per_km, radio, policy
            Which.
        """
        return network_cases(self.plan, Varied((density_per_km,), (radio,), (policy,), self.seeds))


def search(asked: CapacitySearch, out: Path, *, jobs: int, progress: Progress) -> list[CapacityFound]:
    """Find every capacity and write the output folder, whole or not at all.

    Parameters
    ----------
    asked
        What is sought.
    out
        The output folder; runs that an earlier call left there or beside it are taken up.
    jobs
        Runs at a time.
    progress
        Takes runs done and runs to do at most.

    Raises
    ------
    ConfigError
        Where an option is out of its range, or an input changes meanwhile.
    """
    low, high = asked.bounds_per_km
    if not 0.0 < low < high:
        raise ConfigError(f"--lowest and --highest must be positive and rise, got {low:g} and {high:g}")
    if not asked.ratio > 1.0:
        raise ConfigError(f"--ratio must be above 1, got {asked.ratio:g}")
    for radio in asked.radios or ("none",):
        for policy in asked.policies or ("none",):
            _ = asked.cases(low, radio, policy)
    plan = asked.plan
    key = plan.key()
    files = NetworkRunFiles(plan.as_plain(), key)
    runs = _Runs(asked, progress)
    with (
        atomic_folder(out, command="capacity") as folder,
        run_store(out, files, command="capacity") as store,
        workers(max(min(jobs, asked.seeds), 1)) as pool,
    ):
        found = [
            one
            for radio in dict.fromkeys(asked.radios)
            for policy in dict.fromkeys(asked.policies)
            for one in _found(asked, (radio, policy), runs, store=store, pool=pool)
        ]
        if plan.key() != key:
            raise ConfigError("an input changed while it was read: run the command again")
        store.publish(runs.done, folder)
        write_capacity(found, asked.as_plain(), folder)
        write_capacity_report(found, folder)
    return found


class _Runs:
    """Runs that were needed, and how many there are."""

    def __init__(self, asked: CapacitySearch, progress: Progress) -> None:
        self.done: dict[NetworkCase, CaseResult] = {}
        self._asked, self._progress = asked, progress

    def of(
        self,
        cases: list[NetworkCase],
        store: RunStore[NetworkCase, CaseResult],
        pool: Workers,
    ) -> list[RunRow]:
        """Rows of some runs: those known, and the others run now."""
        for case in cases:
            if case not in self.done and (known := store.find(case)) is not None:
                self.done[case] = known
        missing = [case for case in cases if case not in self.done]
        for case, result in pool.as_done(partial(run_case, self._asked.plan), missing):
            store.keep(case, result)
            self.done[case] = result
            self._progress(len(self.done), len(self.done) + 1)
        return [self.done[case].run for case in cases]


def _found(
    asked: CapacitySearch,
    who: tuple[str, str],
    runs: _Runs,
    *,
    store: RunStore[NetworkCase, CaseResult],
    pool: Workers,
) -> list[CapacityFound]:
    """The capacities of one radio and policy, a limit after the other."""
    radio, policy = who
    found: list[CapacityFound] = []
    tried: list[float] = []
    for limit_m in asked.limits_m:

        def probe(density_per_km: float, limit_m: float = limit_m) -> Probe:
            tried.append(density_per_km)
            return probe_of(runs.of(asked.cases(density_per_km, radio, policy), store, pool), limit_m)

        one = bisected(probe, asked.bounds_per_km, limit_m, ratio=asked.ratio, known=sorted(set(tried)))
        found.append(CapacityFound(radio, policy, limit_m, one))
    return found

"""Bisections of ``modelcast capacity``: their runs are those of ``modelcast network``, kept as these are."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from modelcast.cli.capacity_search import CapacitySearch
from modelcast.cli.network_case import run_case
from modelcast.cli.progress import busy
from modelcast.cli.shared_work import Workers, workers
from modelcast.core.exceptions import ConfigError
from modelcast.io.capacity import write_capacity
from modelcast.io.network_runs import NetworkRunFiles
from modelcast.io.output import atomic_folder
from modelcast.io.run_store import RunStore, run_store
from modelcast.report.capacity import write_capacity_report
from modelcast.study.network.capacity import CapacityFound, bisected
from modelcast.study.network.capacity_limits import Limit, Probe, probe_of
from modelcast.study.network.rows import CaseResult, NetworkCase

__all__ = ["search"]

Progress = Callable[[int], None]


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
    asked.check()
    plan = asked.plan
    key = plan.key(radios=asked.radios, policies=asked.policies)
    files = NetworkRunFiles(plan.as_plain(), key)
    runs = _Runs(asked, progress)
    with (
        atomic_folder(out, command="capacity") as folder,
        run_store(out, files, command="capacity") as store,
        workers(max(min(jobs, asked.seeds), 1)) as pool,
    ):
        found = [
            one for sender in asked.senders for one in _found(asked, sender, runs, store=store, pool=pool)
        ]
        if plan.key(radios=asked.radios, policies=asked.policies) != key:
            raise ConfigError("an input changed while it was read: run the command again")
        store.publish(runs.done, folder)
        with busy("writing the report", quiet=False):
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
    ) -> list[CaseResult]:
        """Some runs: those known, and the others run now."""
        for case in cases:
            if case not in self.done and (known := store.find(case)) is not None:
                self.done[case] = known
        missing = [case for case in cases if case not in self.done]
        for case, result in pool.as_done(partial(run_case, self._asked.plan), missing):
            store.keep(case, result)
            self.done[case] = result
            self._progress(len(self.done))
        return [self.done[case] for case in cases]


def _found(
    asked: CapacitySearch,
    sender: tuple[str, str, float],
    runs: _Runs,
    *,
    store: RunStore[NetworkCase, CaseResult],
    pool: Workers,
) -> list[CapacityFound]:
    """The capacities of one radio, policy and threshold, a limit after the other."""
    radio, policy, threshold_m = sender
    found: list[CapacityFound] = []
    tried: list[float] = []
    for limit in asked.limits:

        def probe(density_per_km: float, limit: Limit = limit) -> Probe:
            tried.append(density_per_km)
            cases = asked.cases(density_per_km, *sender)
            try:
                return probe_of(runs.of(cases, store, pool), limit)
            except ValueError as error:
                raise ConfigError(f"{radio}, {policy}: {error}") from error

        one = bisected(probe, asked.bounds_per_km, ratio=asked.ratio, known=sorted(set(tried)))
        found.append(CapacityFound(radio, policy, threshold_m=threshold_m, limit=limit, capacity=one))
    return found

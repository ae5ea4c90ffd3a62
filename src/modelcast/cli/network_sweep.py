"""A sweep of network runs into an output folder: what is missing is run, all is written.

``modelcast network`` and the traffic of ``modelcast reproduce paper`` both go this way.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.network_case import TraceFiles, run_case
from modelcast.cli.network_cases import told
from modelcast.cli.network_film import find_meeting, write_film
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import named_banks
from modelcast.cli.options import SensorOptions
from modelcast.cli.progress import busy
from modelcast.cli.shared_work import workers
from modelcast.core.exceptions import ConfigError
from modelcast.io.network import write_network
from modelcast.io.network_runs import NetworkRunFiles, RunKey
from modelcast.io.output import atomic_folder
from modelcast.io.run_store import RunStore, run_store
from modelcast.io.traffic import write_traffic
from modelcast.io.traffic_survey import TrafficSurvey, survey_document
from modelcast.report.network import traffic_lines, write_network_report
from modelcast.report.traffic import write_traffic_report
from modelcast.study.network.pairs import traffic_rows
from modelcast.study.network.pool import gather
from modelcast.study.network.rows import CaseResult, NetworkCase, NetworkResult
from modelcast.study.table import Row

__all__ = ["Sweep", "Swept", "sweep"]

Progress = Callable[[int, int], None]
"""Takes runs done and runs to do."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """What is to be run, and what of it was found out before.

    Parameters
    ----------
    plan, cases, senders
        What all runs share, the runs, and who sends.
    found
        What the traffic's file holds, where it is one.
    command
        Whose output folder it is.
    against
        Policy that warnings are set against.
    film
        Whether a meeting of the first run is filmed.
    trace
        Where traces of all runs go, none of which is taken from an earlier call then; None for none.
    """

    plan: NetworkPlan
    cases: Sequence[NetworkCase]
    _: KW_ONLY
    senders: Sequence[Row]
    found: TrafficSurvey | None = None
    command: str = "network"
    against: str = ""
    film: bool = False
    trace: TraceFiles | None = None


@dataclass(frozen=True, slots=True)
class Swept:
    """What a sweep has written.

    Parameters
    ----------
    result
        Rows of all runs.
    rows
        The hybrid against the baseline, where both were run.
    options, key, traffic, training_trips
        As for `modelcast.io.network.network_document`.
    """

    result: NetworkResult
    rows: Sequence[Row]
    _: KW_ONLY
    options: Mapping[str, Any]
    key: RunKey
    traffic: Mapping[str, Any] | None
    training_trips: Sequence[str]


def sweep(
    asked: Sweep,
    out: Path,
    *,
    jobs: int,
    watch: Callable[[], AbstractContextManager[Progress]],
    say: Callable[[str], None],
) -> Swept:
    """Run the cases and write the output folder, whole or not at all.

    Parameters
    ----------
    asked
        What is to be run.
    out
        The output folder; runs that an earlier call left there or beside it are taken up.
    jobs
        Runs at a time.
    watch
        Gives a context in which progress is shown.
    say
        Takes lines for the user, before the first run.

    Raises
    ------
    ConfigError
        Where the folder is of other options, an input changes meanwhile, or there is nothing to film.
    """
    plan, cases, found = asked.plan, asked.cases, asked.found
    options, asked_of = plan.as_plain(), [(case.radio, case.policy) for case in cases]
    radios, policies = zip(*asked_of, strict=True)
    key = plan.key(radios=radios, policies=policies)
    meeting = find_meeting(plan, cases[0]) if asked.film else None
    files = NetworkRunFiles(options, key)
    with (
        atomic_folder(out, command=asked.command) as folder,
        run_store(out, files, command=asked.command) as store,
    ):
        traffic = None if found is None else survey_document(found)
        for line in () if found is None else traffic_lines(found):
            say(line)
        known, notes = _training_trips(plan)
        for line in notes:
            say(line)
        known_runs = cases if asked.trace is None else ()
        results = {case: done for case in known_runs if (done := store.find(case)) is not None}
        say(told(cases, len(results)))
        for line in store.outdated(case for case in known_runs if case not in results):
            say(line)
        with watch() as progress:
            results = _run_all(asked, results, store, jobs=jobs, progress=progress)
        if plan.key(radios=radios, policies=policies) != key:
            raise ConfigError("an input changed while it was read: run the command again")
        result = gather(results.values(), asked.senders, against=asked.against)
        with busy("writing the report", quiet=False):
            store.publish(results, folder)
            write_network(result, options, folder, key=key, traffic=traffic, training_trips=known)
            write_network_report(
                result, options, folder, traffic=traffic, notes=notes, defaults=_defaults(plan)
            )
            if meeting is not None:
                write_film(plan, cases[0], meeting, folder)
            rows = traffic_rows(result)
            if rows:
                write_traffic(rows, folder)
                write_traffic_report(rows, folder)
    return Swept(result, rows, options=options, key=key, traffic=traffic, training_trips=known)


def _defaults(plan: NetworkPlan) -> dict[str, Any]:
    """What every run of such banks and thresholds depends on where nobody asks for anything."""
    asked = FleetOptions().plan(SensorOptions(), banks=plan.banks, thresholds_m=plan.thresholds_m)
    return asked.as_plain()


def _training_trips(plan: NetworkPlan) -> tuple[tuple[str, ...], list[str]]:
    """Recorded trips of the traffic that a bank was trained on, and what is told of them."""
    if not plan.trips:
        return (), []
    from modelcast.io.trips import read_trips
    from modelcast.report.training_trips import training_note
    from modelcast.trips.fingerprint import known_trips

    trips = tuple(read_trips(plan.trips))
    trained_on = {trip for named in named_banks(plan).values() for trip in named.trained_on}
    known = known_trips(trips, trained_on)
    return known, training_note(known, len(trips))


def _run_all(
    asked: Sweep,
    known: Mapping[NetworkCase, CaseResult],
    store: RunStore[NetworkCase, CaseResult],
    *,
    jobs: int,
    progress: Progress,
) -> dict[NetworkCase, CaseResult]:
    """Rows of all runs: those known, and the others run now, each written as soon as it is done."""
    results = dict(known)
    missing = [case for case in asked.cases if case not in results]
    processes = max(min(jobs, len(missing)), 1)
    if processes > 1:
        # The largest first, so that no processor waits long for the last one.
        missing.sort(key=lambda case: -case.density_per_km)
    progress(len(results), len(asked.cases))
    with workers(processes) as pool:
        for case, result in pool.as_done(
            partial(run_case, asked.plan, found=asked.found, trace=asked.trace), missing
        ):
            store.keep(case, result)
            results[case] = result
            progress(len(results), len(asked.cases))
    return results

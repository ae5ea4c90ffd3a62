"""``modelcast network``: policies and radios in traffic, as a closed loop."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.options import Numbers, Paths, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import CostUnit, IdentifyRule, StartRule

if TYPE_CHECKING:
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.io.fcd_survey import FcdSurvey
    from modelcast.io.run_store import RunStore
    from modelcast.study.network.rows import CaseResult, NetworkCase, SenderRow

__all__ = ["network"]


def network(
    *,
    scenario: str = "highway",
    trips: Paths = (),
    density: Numbers = (25.0, 100.0, 400.0),
    radio: Words = ("dsrc",),
    policy: Words = ("bsm-10hz", "j2945", "j2945-mbc", "mbc", "cam"),
    duration: float = 30.0,
    warm_up: float = 10.0,
    seeds: int = 3,
    seed: int = 0,
    length: float = 2000.0,
    lanes: int = 0,
    blocks: int = 5,
    certificates: CertificateRule = "gap",
    bank: Words = ("default",),
    profile: str | None = None,
    start: StartRule | None = None,
    identify: IdentifyRule | None = None,
    cost: CostUnit = "bytes",
    threshold: Numbers = (0.2,),
    keep_alive: float = 2.0,
    relaxed_error: float | None = None,
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    out: Path = Path("out/network"),
    jobs: int = 0,
    threads: int = 1,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run fleets on a shared channel: traffic moves, senders decide, messages contend, receivers track.

    Writes runs/, summary.json, runs.parquet, distances.parquet, outcomes.parquet, seconds.parquet, table.md,
    report.html and its figures, all at once when the last run is done. Runs that are done are kept, also
    where the command was interrupted: it can be called again with more densities, radios, policies or seeds.

    Parameters
    ----------
    scenario
        highway, grid; sumo-highway, sumo-grid, sumo-junction (extra sumo); platoon: the cars of an OpenACC
        file on their one clock, as long as it lasts; trips: recorded trips laid on a straight road; or a file
        of floating-car data (CSV, Parquet or SUMO XML). Platoon, junction and files have their own density.
    trips
        Recorded trips of platoon and trips: files or folders, several after one another. Of several platoons
        seeds take one each in turn.
    density
        Vehicles a kilometre of road, both directions, several after one another.
    radio
        dsrc, sidelink, abstract, or several after one another.
    policy
        bsm-10hz, baseline, mbc, j2945, j2945-filtered, j2945-mbc, j2945-mbc-relaxed, j2945-mbc-relaxed-5,
        cam, or several after one another.
    duration
        Time simulated [s].
    warm_up
        How much of it is left out of all counts but the time series [s].
    seeds
        Runs of each combination.
    seed
        Seed of all random numbers.
    length
        Length of the highway, or of the road of trips [m].
    lanes
        Lanes in each direction of it; 0 for as many as the density needs.
    blocks
        Junctions on each side of the grid.
    certificates
        Which messages carry the certificate: gap, timer, always, digest, unsigned.
    bank
        Sub-models of mbc and the j2945-mbc ones, several banks after one another, each as for evaluate. The
        other policies send no model and are run once, not once a bank.
    profile
        File of the profile in use, as for evaluate.
    start
        Sub-model that their messages start with, as for evaluate; where not given, mbc takes the bank's rule
        and the others what erred least of late (recent). Timers know no guard and no survivor.
    identify
        When mbc names another sub-model, as for evaluate; the bank's rule where not given. The others never
        do.
    cost
        What the rule cheapest counts: messages, bytes or airtime.
    threshold
        Tracking-error thresholds of baseline and mbc, several after one another; what timers call for is run
        once, not once a threshold [m].
    keep_alive
        Longest silence of baseline and mbc [s].
    relaxed_error
        Tracking error that calls for a message of the relaxed policies in thin traffic [m]; where not given,
        1 cm, or the sensor's white position noise where that is more.
    sensor
        What vehicles see of themselves.
    out
        Output folder.
    jobs
        Runs at a time; 0 for one a processor.
    threads
        Threads of each run; the result is the same whatever their number.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.network_cases import Varied, network_cases
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.cli.network_senders import sender_rows

    plan = NetworkPlan(
        scenario,
        trips=tuple(str(path) for path in trips),
        duration_s=duration,
        warm_up_s=warm_up,
        length_m=length,
        lanes=lanes,
        blocks=blocks,
        seed=seed,
        certificates=certificates,
        banks=tuple(bank),
        profile=profile,
        start=start,
        identify=identify,
        cost=cost,
        threads=threads,
        thresholds_m=tuple(threshold),
        keep_alive_s=keep_alive,
        relaxed_error_m=relaxed_error,
        sensor=sensor,
    )
    cases = network_cases(plan, Varied(density, radio, policy, seeds))
    senders = sender_rows(plan, dict.fromkeys(policy))
    return _publish(plan, cases, senders, out, jobs=jobs or os.cpu_count() or 1, json=json, quiet=quiet)


def _publish(
    plan: "NetworkPlan",
    cases: "list[NetworkCase]",
    senders: "list[SenderRow]",
    out: Path,
    *,
    jobs: int,
    json: bool,
    quiet: bool,
) -> int:
    """Run the cases, write the output folder, show the result."""
    import json as json_format
    import sys

    from modelcast.cli.network_cases import told
    from modelcast.cli.progress import counted
    from modelcast.cli.terminal import say, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.fcd_survey import survey_document
    from modelcast.io.network import network_document, write_network
    from modelcast.io.output import atomic_folder
    from modelcast.io.run_store import run_store
    from modelcast.report.network import network_console, write_network_report
    from modelcast.study.network.pool import gather

    options, key = plan.as_plain(), plan.key()
    with atomic_folder(out, command="network") as folder, run_store(out, options, key) as store:
        found = _survey(plan)
        traffic = None if found is None else survey_document(found)
        if found is not None and not quiet and not json:
            _show_traffic(found)
        known, notes = _training_trips(plan)
        for line in () if quiet or json else notes:
            say(line)
        results = {case: done for case in cases if (done := store.find(case)) is not None}
        if not quiet and not json:
            say(told(cases, len(results)))
        with counted("runs", quiet=quiet or json) as progress:
            results = _run_all(plan, cases, results, store, found, jobs=jobs, progress=progress)
        if plan.key() != key:
            raise ConfigError("an input changed while it was read: run the command again")
        result = gather(results.values(), senders)
        store.publish(results, folder)
        write_network(result, options, folder, key=key, traffic=traffic, training_trips=known)
        write_network_report(result, options, folder, traffic=traffic, notes=notes)
    if json:
        document = network_document(result, options, key, traffic, known)
        json_format.dump(document, sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        show(network_console(result))
        say(f"report: {out / 'report.html'}")
    return 0


def _survey(plan: "NetworkPlan") -> "FcdSurvey | None":
    """What the file of floating-car data holds, where the traffic is one."""
    if not plan.from_file:
        return None
    from modelcast.io.fcd import survey_fcd

    return survey_fcd(plan.scenario)


def _training_trips(plan: "NetworkPlan") -> tuple[tuple[str, ...], list[str]]:
    """Recorded trips of the traffic that a bank was trained on, and what is told of them."""
    if not plan.trips:
        return (), []
    from modelcast.cli.network_senders import named_banks
    from modelcast.io.trips import read_trips
    from modelcast.report.training_trips import training_note
    from modelcast.trips.fingerprint import known_trips

    trips = tuple(read_trips(plan.trips))
    trained_on = {trip for named in named_banks(plan).values() for trip in named.trained_on}
    known = known_trips(trips, trained_on)
    return known, training_note(known, len(trips))


def _show_traffic(found: "FcdSurvey") -> None:
    """Tell what a file holds before anything runs."""
    from modelcast.cli.terminal import say
    from modelcast.report.network import traffic_lines

    for line in traffic_lines(found):
        say(line)


def _run_all(
    plan: "NetworkPlan",
    cases: "list[NetworkCase]",
    known: "Mapping[NetworkCase, CaseResult]",
    store: "RunStore",
    found: "FcdSurvey | None",
    *,
    jobs: int,
    progress: Callable[[int, int], None],
) -> "dict[NetworkCase, CaseResult]":
    """Rows of all runs: those known, and the others run now, each written as soon as it is done."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor, as_completed

    from modelcast.cli.network_case import run_case

    results = dict(known)
    missing = [case for case in cases if case not in results]

    def take(case: "NetworkCase", result: "CaseResult") -> None:
        store.keep(case, result)
        results[case] = result
        progress(len(results), len(cases))

    progress(len(results), len(cases))
    if jobs == 1 or len(missing) <= 1:
        for case in missing:
            take(case, run_case(plan, case, found))
        return results
    # The largest first, so that no processor waits long for the last one.
    missing.sort(key=lambda case: -case.density_per_km)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(missing)), mp_context=context) as pool:
        waiting = {pool.submit(run_case, plan, case, found): case for case in missing}
        for future in as_completed(waiting):
            take(waiting[future], future.result())
    return results

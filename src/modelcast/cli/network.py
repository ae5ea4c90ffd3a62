"""``modelcast network``: policies and radios in traffic, as a closed loop."""

from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.options import Numbers, Paths, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule

if TYPE_CHECKING:
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.io.fcd_survey import FcdSurvey

__all__ = ["network", "survey", "unsaid"]


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
    keep_alive: float = 1.0,
    believe: BelieveRule | None = None,
    budget: float = 4.0 / 3.0,
    approach: float = 20.0,
    legacy_threshold: float = 0.0,
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
        highway; braking: streams whose leaders brake hard now and then; cut-in: streams in which vehicles
        cut in; grid: streets with signals and buildings; crossing: the same with priority instead of signals,
        and drivers who misjudge gaps; sumo-highway, sumo-grid, sumo-junction (extra sumo); platoon: the cars
        of an OpenACC file on their one clock, as long as it lasts; trips: recorded trips laid on a straight
        road; or a file of floating-car data (CSV, Parquet or SUMO XML). Platoon, junction and files have
        their own density.
    trips
        Recorded trips of platoon and trips: files or folders, several after one another. Of several platoons
        seeds take one each in turn.
    density
        Vehicles a kilometre of road, both directions, several after one another.
    radio
        dsrc, sidelink, abstract, or several after one another.
    policy
        bsm-10hz, baseline, free, mbc, j2945, j2945-filtered, j2945-free, j2945-free-relaxed,
        j2945-free-relaxed-5, j2945-mbc, j2945-mbc-relaxed, j2945-mbc-relaxed-5, cam, or several after one
        another. The free ones send plain messages that receivers coast by the profile's best free sub-model.
    duration
        Time simulated [s].
    warm_up
        How much of it is left out of all counts but the time series [s].
    seeds
        Runs of each combination.
    seed
        Seed of all random numbers.
    length
        Length of the highway, of the road of streams or of trips [m].
    lanes
        Lanes in each direction of it; 0 for as many as the density needs.
    blocks
        Junctions on each side of grid and crossing.
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
        Tracking-error thresholds of baseline, free and mbc, several after one another; what timers call for
        is run once, not once a threshold [m].
    keep_alive
        Longest silence of baseline, free and mbc [s].
    believe
        What mbc takes its remotes to hold: whatever it sent, or each of its last messages with its
        probability at the packet error ratio it observes (expected); that where not given, for the
        rules of a profile's bank.
    budget
        Messages that mbc with --believe expected may send, over those of a channel without losses.
    approach
        Way that two vehicles may come closer between two messages of baseline, free and mbc [m]; 0 for none.
    legacy_threshold
        Error at which legacy receivers, which coast place, speed and heading of a message at constant
        velocity, get an update of baseline, free and mbc [m]; 0 for not minding them.
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
    import json as json_format
    import sys

    from modelcast.cli.network_cases import Varied, network_cases
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.cli.network_senders import sender_rows
    from modelcast.cli.network_sweep import Sweep, sweep
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, show
    from modelcast.io.network import network_document
    from modelcast.report.network import network_console

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
        believe=believe,
        budget=budget,
        approach_m=approach,
        legacy_threshold_m=legacy_threshold,
        relaxed_error_m=relaxed_error,
        sensor=sensor,
    )
    cases = network_cases(plan, Varied(density, radio, policy, seeds))
    asked = Sweep(plan, cases, senders=sender_rows(plan, dict.fromkeys(policy)), found=survey(plan))
    swept = sweep(
        asked,
        out,
        jobs=jobs_in_use(jobs),
        watch=lambda: counted("runs", quiet=quiet or json),
        say=unsaid if quiet or json else say,
    )
    if json:
        parts = (swept.options, swept.key, swept.traffic, swept.training_trips)
        json_format.dump(network_document(swept.result, *parts), sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        show(network_console(swept.result))
        say(f"report: {out / 'report.html'}")
    return 0


def unsaid(_line: str) -> None:
    """Takes a line that nobody is told."""


def survey(plan: "NetworkPlan") -> "FcdSurvey | None":
    """What the file of floating-car data holds, where the traffic is one."""
    if not plan.from_file:
        return None
    from modelcast.io.fcd import survey_fcd

    return survey_fcd(plan.scenario)

"""``modelcast mixed``: fleets in which not everybody sends models, nor reads them."""

from pathlib import Path

from modelcast.cli.options import Numbers, Paths, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule

__all__ = ["mixed"]


def mixed(
    *,
    scenario: str = "highway",
    trips: Paths = (),
    density: Numbers = (100.0,),
    radio: Words = ("dsrc",),
    policy: Words = ("baseline", "mbc"),
    penetration: Numbers = (0.0, 25.0, 50.0, 75.0, 100.0),
    receivers: Numbers = (0.0, 25.0, 50.0, 75.0, 100.0),
    duration: float = 30.0,
    warm_up: float = 10.0,
    seeds: int = 3,
    seed: int = 0,
    length: float = 2000.0,
    lanes: int = 0,
    blocks: int = 5,
    certificates: CertificateRule = "gap",
    bank: str = "default",
    profile: str | None = None,
    start: StartRule | None = None,
    identify: IdentifyRule | None = None,
    cost: CostUnit = "bytes",
    threshold: float = 0.2,
    keep_alive: float = 1.0,
    believe: BelieveRule | None = None,
    budget: float = 4.0 / 3.0,
    approach: float = 20.0,
    legacy_threshold: float = 0.0,
    relaxed_error: float | None = None,
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    out: Path = Path("out/mixed"),
    jobs: int = 0,
    threads: int = 1,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run fleets in which some vehicles send by one policy and some by another, and read in three ways.

    A third of the vehicles each reads messages as legacy receivers do (constant velocity), as free ones (Part
    I by constant turn rate and acceleration), and by the models. Writes what 'modelcast network' writes, and
    pairings.parquet, penetration.parquet, pairings.md and the penetration map. Runs that are done are kept.

    Parameters
    ----------
    scenario
        As for network.
    trips
        As for network.
    density
        Vehicles a kilometre of road, both directions, several after one another.
    radio
        dsrc, sidelink, abstract, or several after one another.
    policy
        Two policies of network or more: the last is the new one, the others share the rest of the vehicles
        evenly.
    penetration
        Vehicles that send by the last policy, several after one another [%].
    receivers
        Vehicles that read models, for the map, several after one another; the others are legacy ones [%].
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
        Sub-models of the policies that send models, as for evaluate.
    profile
        File of the profile in use, as for evaluate.
    start
        As for network.
    identify
        As for network.
    cost
        What the rule cheapest counts: messages, bytes or airtime.
    threshold
        Tracking-error threshold of baseline, free and mbc [m].
    keep_alive
        Longest silence of baseline, free and mbc [s].
    believe
        As for network.
    budget
        As for network.
    approach
        Way that two vehicles may come closer between two messages of baseline, free and mbc [m]; 0 for none.
    legacy_threshold
        Error at which legacy receivers get an update of baseline, free and mbc [m]; 0 for not minding them.
    relaxed_error
        As for network.
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

    from modelcast.cli.mixed_cases import mixed_cases
    from modelcast.cli.network import survey, unsaid
    from modelcast.cli.network_cases import Varied
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.cli.network_senders import sender_rows
    from modelcast.cli.network_sweep import Sweep, sweep
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, show
    from modelcast.io.network import network_document
    from modelcast.report.mixed import mixed_console

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
        banks=(bank,),
        profile=profile,
        start=start,
        identify=identify,
        cost=cost,
        threads=threads,
        thresholds_m=(threshold,),
        keep_alive_s=keep_alive,
        believe=believe,
        budget=budget,
        approach_m=approach,
        legacy_threshold_m=legacy_threshold,
        relaxed_error_m=relaxed_error,
        sensor=sensor,
        receivers_ratios=tuple(dict.fromkeys(one / 100.0 for one in receivers)),
    )
    cases = mixed_cases(plan, Varied(density, radio, policy, seeds), penetration)
    senders = sender_rows(plan, dict.fromkeys(policy))
    swept = sweep(
        Sweep(plan, cases, senders=senders, found=survey(plan), command="mixed"),
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
        show(mixed_console(swept.result))
        say(f"penetration map: {out / 'penetration.svg'}")
    return 0

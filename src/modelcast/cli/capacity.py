"""``modelcast capacity``: the greatest density at which tracking or warnings hold, by bisection."""

from pathlib import Path

from modelcast.cli.options import Count, Numbers, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule

__all__ = ["capacity"]


def capacity(
    *,
    radio: Words = ("dsrc",),
    policy: Words = ("bsm-10hz", "baseline", "free", "mbc", "j2945", "j2945-free", "j2945-mbc"),
    limit: Numbers = (),
    position: Words = ("absolute",),
    missed: Numbers = (),
    lowest: float = 25.0,
    highest: float = 4000.0,
    ratio: float = 1.1,
    scenario: str = "highway",
    duration: float = 12.0,
    warm_up: float = 6.0,
    seeds: Count = 2,
    seed: Count = 0,
    length: float = 3000.0,
    margin: float | None = None,
    lanes: int = 0,
    certificates: CertificateRule = "gap",
    more_bytes: int = 0,
    bank: str = "default",
    profile: str | None = None,
    threshold: Numbers = (0.5,),
    keep_alive: float = 1.0,
    believe: BelieveRule | None = None,
    approach: float = 20.0,
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    out: Path = Path("out/capacity"),
    jobs: int = 0,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Find the vehicles a kilometre up to which limits hold: p99 of errors, or missed warnings.

    For example: `modelcast capacity --policy j2945 j2945-mbc`

    Each radio, policy, threshold and limit has a bisection of its own; densities that are run for one limit
    serve the others. Errors are those of pairs 50 m to 150 m apart, of which 95 % must be tracked. Writes
    runs/, summary.json, capacity.parquet, table.md, the figure capacity as PNG, SVG and PDF. Runs that are
    done are kept, also where the command was interrupted.

    Parameters
    ----------
    radio
        dsrc, sidelink, nr, abstract, ideal, or several after one another.
    policy
        As for network, several after one another.
    limit
        Errors that the 99th percentile must stay under [m], several after one another; where not given, 0.5
        and 1, or none where --missed is given.
    position
        Errors of which places: absolute (against the truth), relative (of the remote, seen from where the
        host takes itself to be), or both after one another.
    missed
        Shares of the true forward collision warnings' instants that hosts may miss, 0..1, several after one
        another.
    lowest
        Density from which on the limit is sought [1/km].
    highest
        Density up to which it is sought [1/km].
    ratio
        How far apart, as a ratio, the two densities may be between which it is found.
    scenario
        highway, braking, cut-in, loaded, grid or crossing, as for network.
    duration
        Time simulated [s].
    warm_up
        How much of it is not counted [s].
    seeds
        Runs of each density.
    seed
        Seed of all random numbers.
    length
        Length of the highway or of streams [m].
    margin
        Vehicles so close to an end of the road have fewer neighbours, and are not counted as hosts of errors
        [m]; where not given, 500 m on straight roads and nothing on a grid. Warnings are counted everywhere.
    lanes
        Lanes in each direction; 0 for as many as the density needs.
    certificates
        Which messages carry the certificate: always loads the channel most.
    more_bytes
        Bytes of every message beside what it is known to hold, as for network.
    bank
        Sub-models of mbc and the j2945-mbc ones, as for network.
    profile
        File of the profile in use, as for network.
    threshold
        Tracking errors that call for a message of the error-driven policies [m], several after one another.
    keep_alive
        Longest silence of the error-driven policies [s].
    believe
        What they take their remotes to hold, as for network.
    approach
        Way that two vehicles may come closer between two of their messages [m]; 0 for none.
    sensor
        What vehicles see of themselves.
    out
        Output folder.
    jobs
        Runs at a time; 0 for one a processor.
    json
        Print summary.json instead of a table.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.capacity_search import CapacitySearch, limits_of, margin_of
    from modelcast.cli.capacity_sweep import search
    from modelcast.cli.fleet_options import FleetOptions
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.core.installed import require_installed
    from modelcast.io.capacity import capacity_document
    from modelcast.report.capacity import capacity_console
    from modelcast.study.network.capacity_limits import WARNS

    require_installed("modelcast capacity", "network")
    limits = limits_of(limit, position, missed)
    plan = FleetOptions(
        scenario,
        duration=duration,
        warm_up=warm_up,
        seeds=seeds,
        seed=seed,
        length=length,
        lanes=lanes,
        certificates=certificates,
        more_bytes=more_bytes,
        profile=profile,
        keep_alive=keep_alive,
        believe=believe,
        approach=approach,
        application=(WARNS,) if missed else (),
    ).plan(sensor, banks=(bank,), thresholds_m=threshold, margin_m=margin_of(scenario, length, margin))
    asked = CapacitySearch(
        plan, tuple(radio), tuple(policy), limits,
        bounds_per_km=(lowest, highest), ratio=ratio, seeds=seeds,
    )  # fmt: skip
    with counted("runs", quiet=quiet) as progress:
        found = search(asked, out, jobs=jobs_in_use(jobs), progress=lambda done: progress(done, None))
    if json:
        say_json(capacity_document(found, asked.as_plain()))
    elif not quiet:
        show(capacity_console(found))
        say(f"figure: {out / 'capacity.png'}")
    return 0

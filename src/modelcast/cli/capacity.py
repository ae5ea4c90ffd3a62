"""``modelcast capacity``: the greatest density at which tracking holds, by bisection."""

from pathlib import Path

from modelcast.cli.options import Numbers, SensorOptions, Words
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule

__all__ = ["capacity"]


def capacity(
    *,
    radio: Words = ("dsrc",),
    policy: Words = ("bsm-10hz", "baseline", "free", "mbc", "j2945", "j2945-free", "j2945-mbc"),
    limit: Numbers = (0.5, 1.0),
    lowest: float = 25.0,
    highest: float = 4000.0,
    ratio: float = 1.1,
    scenario: str = "highway",
    duration: float = 12.0,
    warm_up: float = 6.0,
    seeds: int = 2,
    seed: int = 0,
    length: float = 1500.0,
    lanes: int = 0,
    certificates: CertificateRule = "gap",
    bank: str = "default",
    profile: str | None = None,
    threshold: float = 0.5,
    keep_alive: float = 1.0,
    believe: BelieveRule | None = None,
    approach: float = 20.0,
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    out: Path = Path("out/capacity"),
    jobs: int = 0,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Find the vehicles a kilometre up to which tracking holds: p99 under a limit, 95 % of the pairs tracked.

    Pairs are those 50 m to 150 m apart. Each radio, policy and limit has a bisection of its own; densities
    that are run for one limit serve the others. Writes runs/, summary.json, capacity.parquet, table.md,
    capacity.png and capacity.svg. Runs that are done are kept, also where the command was interrupted.

    Parameters
    ----------
    radio
        dsrc, sidelink, abstract, or several after one another.
    policy
        As for network, several after one another.
    limit
        Tracking errors that the 99th percentile must stay under [m], several after one another.
    lowest, highest
        Densities between which the limit is sought [1/km].
    ratio
        How far apart, as a ratio, the two densities may be between which it is found.
    scenario
        highway or grid.
    duration, warm_up
        Time simulated, and how much of it is not counted [s].
    seeds
        Runs of each density.
    seed
        Seed of all random numbers.
    length
        Length of the highway [m]. Near its ends vehicles have fewer neighbours; they are counted.
    lanes
        Lanes in each direction; 0 for as many as the density needs.
    certificates
        Which messages carry the certificate: always loads the channel most.
    bank, profile
        Sub-models of mbc and the j2945-mbc ones, as for network.
    threshold, keep_alive, believe, approach
        Of the error-driven policies, as for network.
    sensor
        What vehicles see of themselves; errors are against the truth.
    out
        Output folder.
    jobs
        Runs at a time; 0 for one a processor.
    json
        Print summary.json instead of a table.
    quiet
        Print nothing but errors.
    """
    import json as json_format
    import sys

    from modelcast.cli.capacity_sweep import CapacitySearch, search
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.capacity import capacity_document
    from modelcast.report.capacity import capacity_console

    if scenario not in {"highway", "grid"}:
        raise ConfigError(
            f"--scenario must be highway or grid, whose density can be chosen, got {scenario!r}"
        )
    if not limit or not all(value > 0.0 for value in limit):
        raise ConfigError(f"--limit must be positive, got {limit or 'none'}")
    plan = NetworkPlan(
        scenario,
        duration_s=duration,
        warm_up_s=warm_up,
        length_m=length,
        lanes=lanes,
        blocks=5,
        seed=seed,
        certificates=certificates,
        banks=(bank,),
        profile=profile,
        start=None,
        identify=None,
        cost="bytes",
        threads=1,
        thresholds_m=(threshold,),
        keep_alive_s=keep_alive,
        believe=believe,
        budget=4.0 / 3.0,
        approach_m=approach,
        legacy_threshold_m=0.0,
        relaxed_error_m=None,
        sensor=sensor,
    )
    asked = CapacitySearch(
        plan, tuple(radio), tuple(policy), tuple(limit),
        bounds_per_km=(lowest, highest), ratio=ratio, seeds=seeds,
    )  # fmt: skip
    with counted("runs", quiet=quiet or json) as progress:
        found = search(asked, out, jobs=jobs_in_use(jobs), progress=progress)
    if json:
        json_format.dump(capacity_document(found, asked.as_plain()), sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        show(capacity_console(found))
        say(f"figure: {out / 'capacity.png'}")
    return 0

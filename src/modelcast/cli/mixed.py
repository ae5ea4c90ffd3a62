"""``modelcast mixed``: fleets in which not everybody sends models, nor reads them."""

from pathlib import Path

from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.options import Numbers, SensorOptions, Words

__all__ = ["mixed"]


def mixed(
    *,
    density: Numbers = (100.0,),
    radio: Words = ("dsrc",),
    policy: Words = ("baseline", "mbc"),
    penetration: Numbers = (0.0, 25.0, 50.0, 75.0, 100.0),
    receivers: Numbers = (0.0, 25.0, 50.0, 75.0, 100.0),
    bank: str = "default",
    threshold: float = 0.2,
    options: FleetOptions = FleetOptions(),  # noqa: B008 - frozen
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    out: Path = Path("out/mixed"),
    jobs: int = 0,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run fleets in which some vehicles send by one policy and some by another, and read in three ways.

    For example: `modelcast mixed --policy baseline mbc --penetration 0 50 100`

    A third of the vehicles each reads messages as legacy receivers do (constant velocity), as free ones (Part
    I by constant turn rate and acceleration), and by the models. Writes what 'modelcast network' writes, and
    pairings.parquet, penetration.parquet, pairings.md and the penetration map; with --application every host
    is assessed by all three readings, and there is a map of missed and false warnings. Runs that are done are
    kept.

    Parameters
    ----------
    density
        Vehicles a kilometre of road, both directions, several after one another.
    radio
        dsrc, sidelink, nr, abstract, ideal, or several after one another.
    policy
        Two policies of network or more: the last is the new one, the others share the rest of the vehicles
        evenly.
    penetration
        Vehicles that send by the last policy, several after one another [%].
    receivers
        Vehicles that read models, for the map, several after one another; the others are legacy ones [%].
    bank
        Sub-models of the policies that send models, as for evaluate.
    threshold
        Tracking-error threshold of baseline, free and mbc [m].
    options
        Traffic, senders and hosts.
    sensor
        What vehicles see of themselves.
    out
        Output folder.
    jobs
        Runs at a time; 0 for one a processor.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.mixed_cases import mixed_cases
    from modelcast.cli.network import survey, unsaid
    from modelcast.cli.network_cases import Varied, rival_of
    from modelcast.cli.network_senders import sender_rows
    from modelcast.cli.network_sweep import Sweep, sweep
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.core.installed import require_installed
    from modelcast.io.network import network_document
    from modelcast.report.fleet_warnings import warnings_console
    from modelcast.report.mixed import mixed_console

    require_installed("modelcast mixed", "network")
    ratios = tuple(dict.fromkeys(one / 100.0 for one in receivers))
    plan = options.plan(sensor, banks=(bank,), thresholds_m=(threshold,), receivers_ratios=ratios)
    cases = mixed_cases(plan, Varied(density, radio, policy, options.seeds), penetration)
    asked = Sweep(
        plan,
        cases,
        senders=sender_rows(plan, dict.fromkeys(policy)),
        found=survey(plan),
        command="mixed",
        against=rival_of(options.against, cases),
    )
    swept = sweep(
        asked,
        out,
        jobs=jobs_in_use(jobs),
        watch=lambda: counted("runs", quiet=quiet),
        say=unsaid if quiet or json else say,
    )
    if json:
        parts = (swept.options, swept.key, swept.traffic, swept.training_trips)
        say_json(network_document(swept.result, *parts))
    elif not quiet:
        show(mixed_console(swept.result))
        if swept.result.pooled_warnings:
            show(warnings_console(swept.result))
        say(f"report: {out / 'report.html'}")
    return 0

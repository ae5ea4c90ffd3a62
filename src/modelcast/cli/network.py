"""``modelcast network``: policies and radios in traffic, as a closed loop."""

from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.options import Numbers, SensorOptions, Words
from modelcast.cli.people_plan import PeoplePlan
from modelcast.cli.roadside_options import RoadsideOptions

if TYPE_CHECKING:
    from modelcast.cli.network_case import TraceFiles
    from modelcast.cli.network_plan import NetworkPlan
    from modelcast.io.traffic_survey import TrafficSurvey

__all__ = ["network", "survey", "unsaid"]


def network(
    *,
    density: Numbers = (25.0, 100.0, 400.0),
    radio: Words = ("dsrc",),
    radio_settings: bool = False,
    policy: Words = ("bsm-10hz", "j2945", "j2945-free", "j2945-mbc", "free", "mbc", "cam"),
    bank: Words = ("default",),
    threshold: Numbers = (0.2,),
    options: FleetOptions = FleetOptions(),  # noqa: B008 - frozen
    sensor: SensorOptions = SensorOptions(),  # noqa: B008 - frozen
    roadside: RoadsideOptions = RoadsideOptions(),  # noqa: B008 - frozen
    people: PeoplePlan = PeoplePlan(),  # noqa: B008 - frozen
    film: bool = False,
    trace: Path | None = None,
    trace_format: Words = ("parquet",),
    out: Path = Path("out/network"),
    jobs: int = 0,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run fleets on a shared channel: traffic moves, senders decide, messages contend, receivers track.

    For example: `modelcast network --density 25 100 --policy j2945 j2945-mbc`

    Writes runs/, summary.json, runs.parquet, distances.parquet, outcomes.parquet, seconds.parquet, table.md,
    report.html and its figures, and with --application the tables of warnings, all at once when the last run
    is done. Runs that are done are kept, also where the command was interrupted: it can be called again with
    more densities, radios, policies or seeds.

    Parameters
    ----------
    density
        Vehicles a kilometre of road, both directions, several after one another.
    radio
        dsrc, sidelink (LTE-V2X), nr (NR-V2X), abstract (a table of losses), ideal (no loss), or several after
        one another; each with settings of its own as dsrc:preset=deployed-obu,noise_figure_db=8.
    radio_settings
        List the settings and presets of the radios that --radio names, and run nothing.
    policy
        bsm-10hz, baseline, free, mbc, j2945, j2945-filtered, j2945-free, j2945-free-relaxed,
        j2945-free-relaxed-5, j2945-mbc, j2945-mbc-relaxed, j2945-mbc-relaxed-5, j3161, j3161-mbc,
        j3161-mbc-relaxed, cam (adaptive congestion control), cam-reactive, cam-uncontrolled, cam-road
        (intervals and sizes as cars had them), or several after one another. The free ones send plain
        messages that receivers coast by the profile's best free sub-model. NAME:grant=one-shot (or periodic)
        asks for such resources of every radio that reserves any; the j3161 ones take power_control=yes and
        tracking_error_trigger=yes (or no) too.
    bank
        Sub-models of mbc and those with mbc in their name, several banks after one another, each as for
        evaluate. The other policies send no model and are run once, not once a bank.
    threshold
        Tracking-error thresholds of baseline, free and mbc, several after one another; what timers call for
        is run once, not once a threshold [m].
    options
        Traffic, senders and hosts.
    sensor
        What vehicles see of themselves.
    roadside
        Fixed stations beside them.
    people
        What the devices of pedestrians and cyclists do.
    film
        Film a meeting of the first run: somebody comes from behind a building, and what the host of a vehicle
        believes of them; with --roadside without the units and with them. Writes the figure film as PNG,
        SVG and PDF, and film.parquet.
    trace
        Folder for the traces of all runs, a folder each: positions, transmissions, receptions and what
        expired, row by row, the warm-up too. Runs done before are run again.
    trace_format
        parquet, csv, ns2, bonnmotion (movements of all stations for other simulators), omnetpp (output
        vectors), or several after one another.
    out
        Output folder.
    jobs
        Runs at a time; 0 for one a processor.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from dataclasses import replace

    if radio_settings:
        from modelcast.cli.radio_list import list_settings

        list_settings(radio, json=json)
        return 0
    from modelcast.cli.network_cases import Varied, network_cases, rival_of
    from modelcast.cli.network_senders import sender_rows
    from modelcast.cli.network_sweep import Sweep, sweep
    from modelcast.cli.progress import counted
    from modelcast.cli.shared_work import jobs_in_use
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.core.installed import require_installed
    from modelcast.io.network import network_document
    from modelcast.report.network import network_console

    require_installed("modelcast network", "network")
    plan = options.plan(sensor, banks=tuple(bank), thresholds_m=tuple(threshold))
    units = roadside.plan(scenario=plan.scenario, blocks=plan.blocks)
    devices = people.checked(there_are=plan.has_people or bool(plan.tracks) or plan.persons)
    plan = replace(plan, roadside=units, people=devices)
    cases = network_cases(plan, Varied(density, radio, policy, options.seeds))
    asked = Sweep(
        plan,
        cases,
        senders=sender_rows(plan, dict.fromkeys(policy)),
        found=survey(plan),
        against=rival_of(options.against, cases),
        film=film,
        trace=_traces(trace, trace_format, out=out),
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
        show(network_console(swept.result))
        say(f"report: {out / 'report.html'}")
    return 0


def _traces(folder: Path | None, formats: Words, *, out: Path) -> "TraceFiles | None":
    """Where traces go, checked before anything runs.

    Raises
    ------
    ConfigError
        Where a format is unknown, formats come without a folder, or the folder is the output folder or in it.
    """
    from modelcast.cli.network_case import TraceFiles
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.traces import TRACE_FORMATS

    unknown = [name for name in formats if name not in TRACE_FORMATS]
    if unknown or not formats:
        known = ", ".join(TRACE_FORMATS)
        raise ConfigError(f"--trace-format must be of {known}, got {', '.join(unknown) or 'none'}")
    if folder is None:
        if tuple(formats) != ("parquet",):
            raise ConfigError(f"--trace-format {' '.join(formats)} goes with --trace FOLDER")
        return None
    if folder.resolve().is_relative_to(out.resolve()):
        raise ConfigError(
            f"--trace {folder} lies in --out {out}, which is replaced whole: name another folder"
        )
    return TraceFiles(folder, tuple(formats))


def unsaid(_line: str) -> None:
    """Takes a line that nobody is told."""


def survey(plan: "NetworkPlan") -> "TrafficSurvey | None":
    """What the traffic's file holds, where it is one; of a configuration of SUMO, its first run."""
    from modelcast.cli.progress import busy

    if plan.from_sumo_config:
        from modelcast.cli.network_traffic import sumo_survey

        with busy("running SUMO once, to see its traffic", quiet=False):
            return sumo_survey(plan, plan.seed)
    if not plan.from_file:
        return None
    from modelcast.io.fcd import survey_fcd

    with busy("reading the traffic", quiet=False):
        return survey_fcd(plan.scenario, people=plan.persons)

"""One run of ``modelcast reproduce``: read, run every reading, write, show."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from modelcast.cli.all_trips import all_trips, recorded_paths
from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.options import parse_columns
from modelcast.cli.progress import busy, counted
from modelcast.cli.reading import PARTLY_FAILED, TripSource, require_paths
from modelcast.cli.reproduce_options import ReproduceOptions
from modelcast.cli.run_record import write_run
from modelcast.cli.shared_work import jobs_in_use, workers_of
from modelcast.cli.terminal import say, say_json, show
from modelcast.cli.traffic_runs import run_traffic
from modelcast.core.exceptions import ConfigError
from modelcast.core.installed import require_installed
from modelcast.io.manifest import require_replaceable
from modelcast.io.output import atomic_folder
from modelcast.io.paper import paper_document, write_paper
from modelcast.report.paper import paper_console, write_paper_report
from modelcast.study.compare.stage import usable_trips
from modelcast.study.paper.choices import PLAIN
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import reproduce_paper
from modelcast.study.paper.traffic import with_traffic
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips

__all__ = ["Reproduction", "run_reproduction"]


@dataclass(frozen=True, slots=True)
class Reproduction:
    """What ``modelcast reproduce`` was asked for.

    Parameters
    ----------
    study
        Which published evaluation.
    paths, format_name, columns, trip
        The trips.
    options
        Everything that changes the figures.
    """

    study: str
    paths: tuple[Path, ...]
    format_name: str | None
    columns: str | None
    trip: str
    options: ReproduceOptions


def run_reproduction(
    asked: Reproduction, out: Path, *, where: ExecutorOptions, json: bool, quiet: bool
) -> int:
    """Run what was asked for and return the exit code.

    Parameters
    ----------
    asked
        Trips and options.
    out
        Output folder.
    where
        Where parts of the study are worked on.
    json
        Print the summary instead of tables.
    quiet
        Print nothing but errors.

    Raises
    ------
    ConfigError
        Where an option is out of its range, or no trip can be used.
    """
    require_paths(asked.paths, f"reproduce {asked.study}")
    executor = where.executor()
    plan, traffic = asked.options.plan(), asked.options.traffic_plan()
    runs = asked.options.traffic_out or out.with_name(f"{out.name}-traffic")
    if asked.options.traffic:
        require_installed("modelcast reproduce --traffic", "network")
        _require_own_folder(runs, out)
    source = TripSource(
        asked.paths,
        format_name=asked.format_name,
        columns=parse_columns(asked.columns),
        pattern=asked.trip,
    )
    silent = quiet or json
    with atomic_folder(out, command="reproduce", shown=f"--out {out}") as folder:
        reason = "figures are pooled over all of them; parts of the study are shared out"
        trips = all_trips(source, asked.paths, reason, quiet=silent)
        with workers_of(executor, len(trips) + 1) as pool:
            counts: list[ManoeuvreCounts] = []
            if asked.options.pick and trips:
                trips, short = usable_trips(trips, int(PLAIN.bank.windows.max()))
                source.failures.update(short)
                with busy("counting manoeuvres", quiet=quiet):
                    counts = rank_trips(pool.each(count_manoeuvres, trips))
                trips = [trip for trip in trips if trip.trip_id == counts[0].trip_id]
            with counted("parts", quiet=quiet) as progress:
                found = reproduce_paper(trips, plan, each=pool.each, progress=progress)
        failures = {**found.failures, **source.failures}
        result = replace(found, failures=failures, skipped=dict(source.skipped))
        if counts:
            result = replace(result, manoeuvres=tuple(counts), picked=_picked(counts))
            if not silent:
                say(result.picked)
        if asked.options.traffic:
            with counted("runs", quiet=quiet) as progress:
                swept = run_traffic(
                    runs,
                    traffic,
                    jobs=jobs_in_use(where.jobs),
                    progress=progress,
                    say=_nobody if silent else say,
                )
            result = with_traffic(result, swept.rows)
        write_run(folder, "reproduce", _arguments(asked), recorded_paths(asked.paths))
        with busy("writing the report", quiet=quiet):
            write_paper(result, folder)
            write_paper_report(result, folder)
    _tell(result, out, json=json, quiet=quiet)
    return PARTLY_FAILED if failures else 0


def _picked(counts: Sequence[ManoeuvreCounts]) -> str:
    """Which trip was picked from how many."""
    first = counts[0]
    none = "" if first.total else "; no trip has any, so the first by name was taken"
    return f"picked {first.trip_id}: {first.total} manoeuvres, the most of {len(counts)} trips{none}"


def _require_own_folder(runs: Path, out: Path) -> None:
    """Refuse a folder of traffic runs that the report would replace, or that others wrote."""
    own, other = runs.resolve(), out.resolve()
    if own == other or own.is_relative_to(other) or other.is_relative_to(own):
        raise ConfigError(
            f"--traffic-out {runs} and --out {out}: runs that can be taken up again need a folder of their "
            "own, beside the report's"
        )
    require_replaceable(own, "network", shown=f"--traffic-out {runs}")


def _arguments(asked: Reproduction) -> dict[str, object]:
    return {
        "study": asked.study,
        "paths": [str(path) for path in asked.paths],
        "format": asked.format_name,
        "columns": asked.columns,
        "trip": asked.trip,
        "options": asked.options.as_plain(),
    }


def _tell(result: PaperResult, out: Path, *, json: bool, quiet: bool) -> None:
    if json:
        say_json(paper_document(result))
    elif not quiet:
        show(paper_console(result))
        say(f"report: {out / 'report.html'}")


def _nobody(_line: str) -> None:
    """Nobody is told."""

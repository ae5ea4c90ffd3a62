"""One run of ``modelcast reproduce``: read, run every reading, write, show."""

import json as json_format
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from modelcast.cli.options import parse_columns
from modelcast.cli.progress import busy, counted, watched
from modelcast.cli.reading import PARTLY_FAILED, TripSource
from modelcast.cli.reproduce_options import ReproduceOptions
from modelcast.cli.run_record import write_run
from modelcast.cli.shared_work import workers
from modelcast.cli.terminal import say, show
from modelcast.cli.traffic_runs import run_traffic
from modelcast.core.exceptions import ConfigError
from modelcast.io.output import atomic_folder
from modelcast.io.paper import paper_document, write_paper
from modelcast.report.paper import paper_console, write_paper_report
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import reproduce_paper
from modelcast.study.paper.traffic import with_traffic
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.trajectory import Trajectory

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


def run_reproduction(asked: Reproduction, out: Path, *, jobs: int, json: bool, quiet: bool) -> int:
    """Run what was asked for and return the exit code.

    Parameters
    ----------
    asked
        Trips and options.
    out
        Output folder.
    jobs
        Processes; 0 for one a processor.
    json
        Print the summary instead of tables.
    quiet
        Print nothing but errors.

    Raises
    ------
    ConfigError
        Where an option is out of its range, or no trip can be used.
    """
    if not asked.paths:
        raise ConfigError(f"name at least one trip file or folder (modelcast reproduce {asked.study} --help)")
    plan, traffic = asked.options.plan(), asked.options.traffic_plan()
    source = TripSource(
        asked.paths,
        format_name=asked.format_name,
        columns=parse_columns(asked.columns),
        pattern=asked.trip,
    )
    silent = quiet or json
    with atomic_folder(out, command="reproduce", shown=f"--out {out}") as folder:
        with watched(source, quiet=silent) as shown:
            trips = list(shown)
        with workers(jobs) as pool:
            if asked.options.pick and trips:
                with busy("counting manoeuvres", quiet=silent):
                    trips = _richest(trips, list(pool.each(count_manoeuvres, trips)), quiet=silent)
            with counted("parts", quiet=silent) as progress:
                found = reproduce_paper(trips, plan, each=pool.each, progress=progress)
        failures = {**found.failures, **source.failures}
        result = replace(found, failures=failures, skipped=dict(source.skipped))
        if asked.options.traffic:
            runs = asked.options.traffic_out or out.with_name(f"{out.name}-traffic")
            with counted("runs", quiet=silent) as progress:
                swept = run_traffic(
                    runs,
                    traffic,
                    jobs=jobs or os.cpu_count() or 1,
                    progress=progress,
                    say=_nobody if silent else say,
                )
            result = with_traffic(result, swept.rows)
        write_run(folder, "reproduce", _arguments(asked), asked.paths)
        with busy("writing the report", quiet=silent):
            write_paper(result, folder)
            write_paper_report(result, folder)
    _tell(result, out, json=json, quiet=quiet)
    return PARTLY_FAILED if failures else 0


def _richest(
    trips: Sequence[Trajectory], counts: Sequence[ManoeuvreCounts], *, quiet: bool
) -> list[Trajectory]:
    """The trip with the most manoeuvres alone."""
    first = rank_trips(counts)[0]
    if not quiet:
        say(f"picked {first.trip_id}: {first.total} manoeuvres, the most of {len(counts)} trips")
    return [trip for trip in trips if trip.trip_id == first.trip_id]


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
        json_format.dump(paper_document(result), sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        show(paper_console(result))
        say(f"report: {out / 'report.html'}")


def _nobody(_line: str) -> None:
    """Nobody is told."""

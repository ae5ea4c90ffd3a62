"""``modelcast reproduce``: a published evaluation on one's own trips."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from modelcast.cli.options import Columns, Format
from modelcast.cli.reproduce_options import ReproduceOptions

__all__ = ["reproduce"]


def reproduce(
    study: Annotated[Literal["paper"], Parameter(name="study")],
    /,
    *paths: Path,
    out: Path = Path("out/paper"),
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    options: ReproduceOptions = ReproduceOptions(),  # noqa: B008 - frozen
    pick: bool = False,
    jobs: int = 0,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Repeat a published evaluation on recorded trips, under every choice that its text leaves open.

    paper: Mahjoub, Toghi, Gani, Fallah, 2019. Writes report.html, claims.md, claims.csv, summary.json,
    figures/ and run.json.

    Parameters
    ----------
    study
        paper.
    paths
        Files or folders with recorded trips.
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'.
    trip
        Take only trips whose identifier matches this shell pattern.
    options
        What changes the figures.
    pick
        Take one trip alone: the one with the most manoeuvres, as modelcast trips --rank ranks them.
    jobs
        Readings at a time; 0 for one a processor. The result is the same whatever their number.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    import json as json_format
    import sys
    from dataclasses import replace

    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import busy, counted, watched
    from modelcast.cli.reading import PARTLY_FAILED, TripSource
    from modelcast.cli.run_record import write_run
    from modelcast.cli.shared_work import workers
    from modelcast.cli.terminal import say, show
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.output import atomic_folder
    from modelcast.io.paper import paper_document, write_paper
    from modelcast.report.paper import paper_console, write_paper_report
    from modelcast.study.paper.run import reproduce_paper
    from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips

    if not paths:
        raise ConfigError(f"name at least one trip file or folder (modelcast reproduce {study} --help)")
    plan = options.plan()
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip)
    silent = quiet or json
    with atomic_folder(out, command="reproduce", shown=f"--out {out}") as folder:
        with watched(source, quiet=silent) as shown:
            trips = list(shown)
        if pick and trips:
            with busy("counting manoeuvres", quiet=silent), workers(jobs) as pool:
                counts = list(pool.each(count_manoeuvres, trips))
            richest = rank_trips(counts)[0]
            trips = [one for one in trips if one.trip_id == richest.trip_id]
            if not silent:
                say(f"picked {richest.trip_id}: {richest.total} manoeuvres, the most of {len(counts)} trips")
        with counted("parts", quiet=silent) as progress, workers(jobs) as pool:
            found = reproduce_paper(trips, plan, each=pool.each, progress=progress)
        failures = {**found.failures, **source.failures}
        result = replace(found, failures=failures, skipped=dict(source.skipped))
        asked = {
            "study": study,
            "paths": [str(path) for path in paths],
            "format": format,
            "columns": columns,
            "trip": trip,
            "pick": pick,
            "options": options.as_plain(),
        }
        write_run(folder, "reproduce", asked, paths)
        with busy("writing the report", quiet=silent):
            write_paper(result, folder)
            write_paper_report(result, folder)
    if json:
        json_format.dump(paper_document(result), sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        show(paper_console(result))
        say(f"report: {out / 'report.html'}")
    return PARTLY_FAILED if failures else 0

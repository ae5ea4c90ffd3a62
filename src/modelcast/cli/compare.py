"""``modelcast compare``: members, banks and rules side by side, on routes that none was trained on."""

from pathlib import Path

from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.options import Columns, Format, Rate

__all__ = ["compare"]


def compare(
    *paths: Path,
    out: Path = Path("out/compare"),
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    rate: Rate = None,
    options: CompareOptions = CompareOptions(),  # noqa: B008 - frozen
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Compare banks and rules on the same trips: messages, bytes and tracking error at equal rate.

    Writes summary.json, table.md, comparison.png, comparison.svg, messages.parquet, tracking.parquet and
    run.json.

    Parameters
    ----------
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
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    options
        What changes the figures.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from dataclasses import replace

    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import busy, counted, watched
    from modelcast.cli.reading import PARTLY_FAILED, TripSource, require_paths
    from modelcast.cli.run_record import write_run
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.io.comparison import comparison_document, write_comparison
    from modelcast.io.output import atomic_folder
    from modelcast.report.comparison import comparison_console, write_comparison_report
    from modelcast.study.compare.run import compare as compare_trips

    require_paths(paths, "compare")
    settings, candidates = options.settings(), options.candidates()
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip, rate_hz=rate)
    silent = quiet or json
    with atomic_folder(out, command="compare", shown=f"--out {out}") as folder:
        with watched(source, quiet=silent) as shown:
            trips = list(shown)
        with counted("trips", quiet=silent) as progress:
            found = compare_trips(trips, candidates, settings, progress=progress)
        failures = {**found.failures, **source.failures}
        result = replace(found, failures=failures, skipped=dict(source.skipped))
        asked = {
            "paths": [str(path) for path in paths],
            "format": format,
            "columns": columns,
            "trip": trip,
            "rate": rate,
            "options": options.as_plain(),
        }
        known = [trip.id for trip in result.trips if trip.in_training]
        write_run(
            folder,
            "compare",
            asked,
            (*paths, *options.files),
            training_trips=known,
            foreign=options.foreign,
        )
        with busy("writing the report", quiet=silent):
            write_comparison(result, folder)
            write_comparison_report(result, folder)
    if json:
        say_json(comparison_document(result))
    elif not quiet:
        show(comparison_console(result))
        say(f"table and figure: {out}")
    return PARTLY_FAILED if failures else 0

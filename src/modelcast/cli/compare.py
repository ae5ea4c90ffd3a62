"""``modelcast compare``: members, banks and rules side by side, on routes that none was trained on."""

from pathlib import Path

from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.executor_options import ExecutorOptions
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
    where: ExecutorOptions = ExecutorOptions(),  # noqa: B008 - frozen
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Compare banks and rules on the same trips: messages, bytes and tracking error at equal rate.

    For example: `modelcast compare drive.csv --bank cv free default`

    Writes summary.json, table.md, the figure comparison as PNG, SVG and PDF, messages.parquet,
    tracking.parquet and run.json.

    Parameters
    ----------
    paths
        Files or folders with recorded trips, or a corpus.
    out
        Output folder; one that an earlier run of this command wrote is replaced.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    options
        What changes the figures.
    where
        Of a corpus, where it is worked on.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.all_trips import recorded_paths
    from modelcast.cli.comparison_run import Comparison, compared
    from modelcast.cli.progress import busy
    from modelcast.cli.reading import PARTLY_FAILED, require_paths
    from modelcast.cli.run_record import write_run
    from modelcast.cli.terminal import say, say_json, show
    from modelcast.io.comparison import comparison_document, write_comparison
    from modelcast.io.output import atomic_folder
    from modelcast.report.comparison import comparison_console, write_comparison_report

    require_paths(paths, "compare")
    silent = quiet or json
    shown = f"--out {out}"
    asked_for = Comparison(paths, format, columns, trip=trip, rate_hz=rate, options=options, where=where)
    with (
        compared(asked_for, out, quiet=silent) as result,
        atomic_folder(out, command="compare", shown=shown) as folder,
    ):
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
            (*recorded_paths(paths), *options.files),
            training_trips=known,
            foreign=options.foreign,
        )
        with busy("writing the report", quiet=quiet):
            write_comparison(result, folder)
            write_comparison_report(result, folder)
    if json:
        say_json(comparison_document(result))
    elif not quiet:
        show(comparison_console(result))
        say(f"table and figure: {out}")
    return PARTLY_FAILED if result.failures else 0

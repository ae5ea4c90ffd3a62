"""``modelcast ingest``: recordings of any format as one corpus of Parquet files."""

from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.options import Columns, Format, Rate

if TYPE_CHECKING:
    from modelcast.corpora.finishing import Ingested

__all__ = ["ingest"]

_HERE = ExecutorOptions()


def ingest(
    *paths: Path,
    out: Path,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    rate: Rate = None,
    where: ExecutorOptions = _HERE,
    partitions: int | None = None,
    inspect: bool = False,
    quiet: bool = False,
    json: bool = False,
) -> int:
    """Make a corpus: recorded trips of any number as Parquet files by vehicle, with a catalogue.

    For example: `modelcast ingest recordings/ --out corpus`

    A run that was interrupted goes on where it stopped: give the same command again. A file that cannot be
    read is reported and gives no trips; the others do.

    Parameters
    ----------
    paths
        Files or folders with recorded trips; corpora are among them.
    out
        The corpus' folder: new, empty, or an unfinished corpus of the same sources.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    where
        Where the sources are read.
    partitions
        Parts that vehicles are shared out to; where not given as many as give a million samples each.
    inspect
        Also measure the quality of every trip for the catalogue, as trips does; takes several times as long.
    quiet
        Print nothing but errors.
    json
        Print one JSON document instead.
    """
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import rated
    from modelcast.cli.reading import PARTLY_FAILED, require_paths
    from modelcast.cli.terminal import complain, say_json
    from modelcast.corpora.ingestion import ingest as run
    from modelcast.corpora.ingestion import rows_under_way
    from modelcast.corpora.sources import find_sources

    require_paths(paths, "ingest")
    executor = where.executor()
    thresholds_m = None
    if inspect:
        from modelcast.study.settings import EvaluationSettings

        thresholds_m = EvaluationSettings().thresholds_m
    found = find_sources(
        paths,
        format,
        columns=parse_columns(columns),
        pattern=trip,
        rate_hz=rate,
        memory_bytes=executor.worker_bytes,
    )
    with rated(quiet=quiet, under_way=lambda: rows_under_way(out)) as watch:
        made = run(
            found, out, partitions=partitions, thresholds_m=thresholds_m, executor=executor, watch=watch
        )
    for name, reason in made.failures.items():
        complain(f"{name}: {reason}")
    if json:
        say_json(_document(made))
    elif not quiet:
        _tell(made, out)
    return PARTLY_FAILED if made.failures else 0


def _document(made: "Ingested") -> "dict[str, object]":
    from dataclasses import fields

    plain = {item.name: getattr(made, item.name) for item in fields(made) if item.name != "corpus"}
    partitions = [
        {"name": one.name, "trips": one.trips, "samples": one.rows} for one in made.corpus.partitions
    ]
    return {**plain, "corpus": str(made.corpus.path), "partitions": partitions}


def _tell(made: "Ingested", out: Path) -> None:
    from modelcast.cli.terminal import say
    from modelcast.report.console import skipped_lines

    count = len(made.corpus.partitions)
    parts = "1 partition" if count == 1 else f"{count} partitions"
    trips = "1 trip" if made.trips == 1 else f"{made.trips:,} trips"
    say(f"{trips}, {made.samples:,} samples of {made.rows:,} rows in {parts} written to {out}")
    for kind, counts in (("skipped", made.skipped_rows), ("repaired", made.repaired_rows)):
        if counts:
            say(f"{kind}: " + ", ".join(f"{rows:,} {reason}" for reason, rows in counts.items()))
    if made.rows_without_trip:
        say(f"of vehicles without a usable row: {made.rows_without_trip:,} rows more")
    for line in skipped_lines(made.skipped, rest="skipped.parquet names all"):
        say(line)

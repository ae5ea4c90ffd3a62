"""``modelcast reproduce``: a published evaluation on one's own trips."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from modelcast.cli.executor_options import ExecutorOptions
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
    where: ExecutorOptions = ExecutorOptions(),  # noqa: B008 - frozen
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Repeat a published evaluation on recorded trips, under every choice that its text leaves open.

    For example: `modelcast reproduce paper drive.csv --out out/paper`

    paper: Mahjoub, Toghi, Gani, Fallah, 2019. Writes report.html, claims.md, claims.csv, summary.json,
    figures/ and run.json.

    Parameters
    ----------
    study
        paper.
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
    options
        What changes the figures.
    where
        Where readings are worked on, also without a corpus. The result is the same.
    json
        Print summary.json instead of tables.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.reproduction_run import Reproduction, run_reproduction

    return run_reproduction(
        Reproduction(study, paths, format, columns, trip, options), out, where=where, json=json, quiet=quiet
    )

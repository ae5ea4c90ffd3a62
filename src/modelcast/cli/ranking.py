"""What ``modelcast trips --rank`` does: count manoeuvres, order the trips, show or write the order."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from modelcast.cli.progress import watched
from modelcast.cli.reading import TripSource
from modelcast.cli.terminal import say, say_json, show
from modelcast.core.exceptions import ConfigError
from modelcast.io.output import atomic_file, atomic_folder
from modelcast.io.ranking import ranking_document, ranking_table
from modelcast.io.table_files import write_table
from modelcast.report.figures.course import course_drawings
from modelcast.report.figures.files import write_drawings
from modelcast.report.ranking import ranking_report
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["rank_source"]

_FORMS: dict[str, Literal["csv", "parquet"]] = {".csv": "csv", ".parquet": "parquet"}


def rank_source(
    source: TripSource,
    inputs: Sequence[Path],
    *,
    top: int | None,
    out: Path | None,
    figures: Path | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Rank the trips of a source; return the exit code.

    Parameters
    ----------
    source
        The trips.
    inputs
        The files they come from: none of them is replaced.
    top
        How many to show and to draw; all where None. The file holds all.
    out
        A .csv or .parquet for the ranking.
    figures
        A folder for the courses of the trips shown.
    as_json
        Print a JSON document instead of the table.
    quiet
        Show no progress.

    Raises
    ------
    ConfigError
        Where no trip was read, or a place cannot be written.
    """
    if out is None:
        ranked, kept = _ranked(source, top=top, keep=figures is not None, quiet=quiet)
    else:
        form = _FORMS.get(out.suffix)
        if form is None:
            raise ConfigError(f"--out {out}: end it in {' or '.join(_FORMS)}")
        with atomic_file(out, inputs=inputs, shown=f"--out {out}") as file:
            ranked, kept = _ranked(source, top=top, keep=figures is not None, quiet=quiet)
            write_table(ranking_table(ranked), file, form)
    if figures is not None:
        with atomic_folder(figures, command="trips", shown=f"--figures {figures}") as folder:
            write_drawings(course_drawings(kept), folder)
    failures, skipped = source.failures, source.skipped
    if as_json:
        told = ranking_document(ranked[:top], counted=len(ranked), failures=failures, skipped=skipped)
        say_json(told)
        return source.exit_code
    show(ranking_report(ranked[:top], counted=len(ranked), failures=failures, skipped=skipped))
    if out is not None:
        say(f"ranking: {out}")
    if figures is not None:
        say(f"courses: {figures}")
    return source.exit_code


def _ranked(
    source: TripSource, *, top: int | None, keep: bool, quiet: bool
) -> tuple[list[ManoeuvreCounts], list[tuple[Trajectory, ManoeuvreCounts]]]:
    """Return all counts in order, and the trips to draw; no other trip is kept."""
    found = list[ManoeuvreCounts]()
    trips = dict[str, Trajectory]()
    with watched(source, quiet=quiet) as shown:
        for trip in shown:
            found.append(count_manoeuvres(trip))
            if keep:
                trips[trip.trip_id] = trip
                best = {one.trip_id for one in rank_trips(found)[:top]}
                trips = {name: one for name, one in trips.items() if name in best}
    if not found:
        raise ConfigError("no usable trip")
    ranked = rank_trips(found)
    return ranked, [(trips[one.trip_id], one) for one in ranked[:top] if keep]

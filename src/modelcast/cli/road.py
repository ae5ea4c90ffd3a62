"""``modelcast road``: files of the roads that were driven before, for senders that read context."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from modelcast.cli.options import Columns, Format

if TYPE_CHECKING:
    from modelcast.station.context.survey import RoadSurvey

__all__ = ["road"]


def road(
    action: Literal["build", "show"],
    *paths: Path,
    out: Path | None = None,
    cells: int = 200_000,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Build a road file of recorded trips, or show one: kilometres, passes, bytes, and a map.

    For example: `modelcast road build monday.csv --out road.parquet`

    'modelcast road build TRIPS... --out roads.parquet' keeps a cell every 5 m of each drive. 'modelcast road
    show roads.parquet --out roads.png' draws them. Evaluate with 'modelcast evaluate TRIPS --road
    roads.parquet': a trip never remembers its own cells.

    Parameters
    ----------
    action
        'build' or 'show'.
    paths
        To build: files or folders with recorded trips, the earliest first. To show: one road file.
    out
        To build: the .parquet to write. To show: the .png, .svg or .pdf of the map; none is drawn where not
        given.
    cells
        Most cells that a file keeps; those of the first trips give way.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    json
        Print one JSON document instead of text.
    quiet
        Show no progress, and to build print nothing but errors.
    """
    from modelcast.cli.reading import require_paths
    from modelcast.cli.terminal import say, say_json
    from modelcast.core.exceptions import ConfigError

    if action == "show":
        if len(paths) != 1:
            raise ConfigError("name one road file (modelcast road show roads.parquet)")
        survey, code = _shown(paths[0], out), 0
    else:
        if out is None or out.suffix != ".parquet":
            raise ConfigError("--out: name the .parquet to write")
        require_paths(paths, "road")
        survey, code = _built(
            paths, out, cells, format_name=format, columns=columns, pattern=trip, quiet=quiet or json
        )
    passes, length_km = len(set(survey.passes.tolist())), round(survey.length_m / 1e3, 3)
    if json:
        facts = {
            "cells": len(survey),
            "length_km": length_km,
            "passes": passes,
            "trips": len(survey.fingerprints),
            "memory_bytes": survey.memory_bytes,
            "places": "WGS-84" if survey.geodetic else "local plane",
        }
        say_json(facts, sort=False)
    elif action == "show" or not quiet:
        say(
            f"{length_km:g} km in {passes} passes of {len(survey.fingerprints)} trips: "
            f"{len(survey)} cells, {survey.memory_bytes / 1e3:.0f} kB in memory"
        )
        if not survey.geodetic:
            say("places are metres on a local plane: the file serves trips on the same plane alone")
        if out is not None:
            say(f"written: {out}")
    return code


def _built(
    paths: tuple[Path, ...],
    out: Path,
    cells: int,
    *,
    format_name: str | None,
    columns: str | None,
    pattern: str,
    quiet: bool,
) -> "tuple[RoadSurvey, int]":
    """Build a file; returns what it holds, and the exit code."""
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import watched
    from modelcast.cli.reading import TripSource
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.output import atomic_file
    from modelcast.io.road import MOST_CELLS_READ, write_roads
    from modelcast.station.context.survey import survey_roads

    if not 1 <= cells <= MOST_CELLS_READ:
        raise ConfigError(f"--cells must be from 1 to {MOST_CELLS_READ}, got {cells}")
    source = TripSource(paths, format_name=format_name, columns=parse_columns(columns), pattern=pattern)
    try:
        with atomic_file(out, inputs=paths, shown=f"--out {out}") as file:
            with watched(source, quiet=quiet) as shown:
                survey = survey_roads(shown, cells)
            if not len(survey):
                raise ConfigError("no trip drove far enough for a road: nothing was written")
            write_roads(survey, file)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if not quiet:
        source.tell_skipped()
    return survey, source.exit_code


def _shown(path: Path, out: Path | None) -> "RoadSurvey":
    """Read a file, and draw it where a figure is asked for."""
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.output import atomic_file
    from modelcast.io.road import read_roads

    if out is not None and out.suffix not in (".png", ".svg", ".pdf"):
        raise ConfigError(f"--out {out}: end it in .png, .svg or .pdf")
    survey = read_roads(path)
    if out is not None:
        from modelcast.report.figures.files import drawn
        from modelcast.report.figures.road import plot_roads
        from modelcast.report.style import style

        with atomic_file(out, inputs=(path,), shown=f"--out {out}") as file, style():
            file.write(drawn("roads", plot_roads(survey)).content(out.suffix))
    return survey

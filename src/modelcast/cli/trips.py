"""``modelcast trips``: what is in recorded trips, and how good the recording is."""

from pathlib import Path

from modelcast.cli.options import Columns, Format, Rate

__all__ = ["trips"]


def trips(
    *paths: Path,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    rate: Rate = None,
    rank: bool = False,
    top: int | None = None,
    out: Path | None = None,
    figures: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Show each trip's duration, rate, gaps, grid, held values, noise, manoeuvres, skipped and odd samples.

    For example: `modelcast trips drive.csv`

    With --rank: count the manoeuvres of each trip, and order the trips by them.

    Parameters
    ----------
    paths
        Files or folders with recorded trips.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    rank
        Order the trips by their lane changes, turns, U-turns, roundabouts, stops and hard brakes.
    top
        With --rank, show and draw this many trips only.
    out
        With --rank, also write the whole order to this .csv or .parquet.
    figures
        With --rank, also draw the course of each trip shown, its manoeuvres marked, into this folder.
    json
        Print one JSON document instead of tables.
    quiet
        Show no progress.
    """
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import watched
    from modelcast.cli.reading import TripSource, require_paths
    from modelcast.core.exceptions import ConfigError

    require_paths(paths, "trips")
    if not rank and (top, out, figures) != (None, None, None):
        raise ConfigError("--top, --out and --figures belong to --rank")
    if top is not None and top < 1:
        raise ConfigError(f"--top must be at least 1, got {top}")
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip, rate_hz=rate)
    if rank:
        from modelcast.cli.ranking import rank_source

        return rank_source(
            source, paths, top=top, out=out, figures=figures, as_json=json, quiet=quiet or json
        )
    from modelcast.cli.trip_notes import TripNotes
    from modelcast.station.receiver.plausibility import trip_findings
    from modelcast.study.settings import EvaluationSettings
    from modelcast.trips.inspection import inspect
    from modelcast.trips.manoeuvres.rank import count_manoeuvres

    with TripNotes() as notes:
        with watched(source, quiet=quiet) as shown:
            for one in shown:
                quality = inspect(one)
                notes.add(quality, trip_findings(one), count_manoeuvres(one, quality))
        if not notes.count:
            raise ConfigError("no usable trip")
        tell = notes.say_json if json else notes.show
        tell(source.failures, source.skipped, EvaluationSettings().thresholds_m)
    return source.exit_code

"""``modelcast convert``: trips of any format as one Parquet or CSV table."""

from pathlib import Path

from modelcast.cli.options import Columns, Format, Rate

__all__ = ["convert"]


def convert(
    *paths: Path,
    out: Path,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    rate: Rate = None,
    quiet: bool = False,
) -> int:
    """Write recorded trips as one table that modelcast, or any data-frame library, reads back.

    For example: `modelcast convert drive.gpx --out drive.parquet`

    Parameters
    ----------
    paths
        Files or folders with recorded trips.
    out
        The .parquet or .csv to write; it appears whole or not at all, in place of an older one. It may be
        none of the files that are read.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'; other units
        have meanings of their own, as east_ft, speed_kmh, speed_mph and speed_kn (docs/formats.md).
    trip
        Take only trips whose identifier matches this shell pattern.
    rate
        Take trips as read so many times a second, from no later sample [Hz]; as recorded where not given.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.options import parse_columns
    from modelcast.cli.progress import watched
    from modelcast.cli.reading import TripSource, require_paths
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.output import atomic_file
    from modelcast.io.write_trips import write_csv, write_parquet

    writers = {".csv": write_csv, ".parquet": write_parquet}
    write = writers.get(out.suffix)
    if write is None:
        raise ConfigError(f"--out {out}: end it in {' or '.join(writers)}")
    require_paths(paths, "convert")
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip, rate_hz=rate)
    with atomic_file(out, inputs=paths, shown=f"--out {out}") as file:
        with watched(source, quiet=quiet) as shown:
            write(shown, file)
        if source.trips == 0:
            raise ConfigError("no usable trip: nothing was written")
    if not quiet:
        say(f"{source.trips} trip{'' if source.trips == 1 else 's'} written to {out}")
        source.tell_skipped()
    return source.exit_code

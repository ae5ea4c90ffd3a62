"""``modelcast convert``: trips of any format as one Parquet or CSV table."""

from pathlib import Path

from modelcast.cli.options import Columns, Format

__all__ = ["convert"]


def convert(
    *paths: Path,
    out: Path,
    format: Format = None,  # noqa: A002 - the word a user would type
    columns: Columns = None,
    trip: str = "*",
    quiet: bool = False,
) -> int:
    """Write recorded trips as one table that modelcast, or any data-frame library, reads back.

    Parameters
    ----------
    paths
        Files or folders with recorded trips.
    out
        The .parquet or .csv to write.
    format
        Name of the files' format; found from their content where not given.
    columns
        Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v'.
    trip
        Take only trips whose identifier matches this shell pattern.
    quiet
        Print nothing but errors.
    """
    from modelcast.cli.options import parse_columns
    from modelcast.cli.reading import TripSource, watched
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.io.write_trips import write_csv, write_parquet

    writers = {".csv": write_csv, ".parquet": write_parquet}
    write = writers.get(out.suffix)
    if write is None:
        raise ConfigError(f"--out {out}: end it in {' or '.join(writers)}")
    if not paths:
        raise ConfigError("name at least one trip file or folder (modelcast convert --help)")
    source = TripSource(paths, format_name=format, columns=parse_columns(columns), pattern=trip)
    partial = out.with_name(f".{out.name}.partial")
    try:
        with watched(source, quiet=quiet) as shown:
            write(shown, partial)
        if source.trips == 0:
            raise ConfigError("no usable trip: nothing was written")
        partial.replace(out)
    except OSError as error:
        raise ConfigError(f"--out {out} cannot be written: {error.strerror}") from error
    finally:
        partial.unlink(missing_ok=True)
    if not quiet:
        say(f"{source.trips} trips written to {out}")
    return source.exit_code

"""How much of a file may be held at a time, and the error where a trip alone is more.

A trip is one value that is judged, smoothed and evaluated as a whole, so it has to fit into memory; what
bounds the memory of a file is therefore a bound on its largest trip.
"""

from modelcast.core.exceptions import DataFormatError

__all__ = ["HELD_BYTES", "MOST_NAME_BYTES", "MOST_TRIPS", "require_fitting", "too_long"]

HELD_BYTES = 96 * 2**20
"""Octets of numbers gathered at a time, and so of one trip, unless a command is told otherwise.

Making a trip of them takes about six times as much for a while: under 1 GiB with all libraries.
"""

MOST_NAME_BYTES = 1024
"""Octets of a text that names a vehicle, and of a trip's identifier.

What is longer is damage, and repeated over many rows would fill the memory.
"""

MOST_TRIPS = 1_000_000
"""Trips of one file; each takes some hundred octets while the others are looked for."""


def too_long(
    path: str, trip: str, *, row_bytes: int, held_bytes: int, remedy: str = "Write it into several files."
) -> DataFormatError:
    """Return the error about a trip that alone is more than may be held.

    Parameters
    ----------
    path
        The file.
    trip
        Its identifier.
    row_bytes
        Octets that a row takes.
    held_bytes
        The limit.
    remedy
        What the user can do.
    """
    return DataFormatError(
        path,
        f"the trip {trip} has over {held_bytes // row_bytes:,} rows, which take more than the "
        f"{held_bytes / 2**20:,.0f} MiB that the numbers of one trip may",
        remedy=remedy,
    )


def require_fitting(path: str, trip: str, rows: int, *, row_bytes: int, held_bytes: int) -> None:
    """Refuse a trip that is more than may be held.

    Parameters
    ----------
    path, trip, row_bytes, held_bytes
        As for `too_long`.
    rows
        Its rows so far.

    Raises
    ------
    DataFormatError
        Where it is.
    """
    if rows * row_bytes > held_bytes:
        raise too_long(path, trip, row_bytes=row_bytes, held_bytes=held_bytes)

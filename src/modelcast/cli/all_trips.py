"""Trips that a command works on together, in memory."""

from collections.abc import Sequence
from pathlib import Path

from modelcast.cli.progress import watched
from modelcast.cli.reading import TripSource
from modelcast.cli.terminal import complain
from modelcast.corpora.layout import CORPUS_FILE, is_corpus
from modelcast.trips.trajectory import Trajectory

__all__ = ["all_trips", "recorded_paths"]


def all_trips(source: TripSource, paths: Sequence[Path], reason: str, *, quiet: bool) -> list[Trajectory]:
    """Return all trips of a source; where there is a corpus, in order of identifier whatever its partitions.

    Parameters
    ----------
    source
        The trips, not yet taken.
    paths
        What the user named.
    reason
        Why a corpus is not shared out by its partitions: said of one, in a line.
    quiet
        Show no progress.
    """
    has_corpus = any(map(is_corpus, paths))
    if has_corpus:
        complain(f"the trips of a corpus are taken together, in one process: {reason}")
    with watched(source, quiet=quiet) as shown:
        trips = list(shown)
    return sorted(trips, key=lambda trip: trip.trip_id) if has_corpus else trips


def recorded_paths(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return what ``run.json`` records of paths: of a corpus the file that has the hashes of all others.

    Parameters
    ----------
    paths
        What the user named.
    """
    return tuple(path / CORPUS_FILE if is_corpus(path) else path for path in paths)

"""What ``modelcast trips`` has found of each trip, kept in a file where it is much."""

import json
import pickle  # what is read back was written by this process, into a file without a name
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from tempfile import SpooledTemporaryFile
from textwrap import indent
from typing import IO, Self

from rich.table import Table

from modelcast.cli.terminal import show
from modelcast.report.inspection import Findings, failed_lines, trip_document, trip_table
from modelcast.trips.inspection import TripInspection
from modelcast.trips.manoeuvres.base import ManoeuvreCounts

__all__ = ["TripNotes"]

_IN_MEMORY_BYTES = 32 * 2**20
_SHOWN_AT_ONCE = 200

Note = tuple[TripInspection, Findings, ManoeuvreCounts]


class TripNotes:
    """Notes of trips in order, written once and shown once; a context manager that removes its file."""

    def __init__(self) -> None:
        self._file: IO[bytes] = SpooledTemporaryFile(_IN_MEMORY_BYTES)  # noqa: SIM115 - closed in __exit__
        self.count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, inspection: TripInspection, findings: Findings, manoeuvres: ManoeuvreCounts) -> None:
        """Note what was found of a trip."""
        note = (inspection, None if findings is None else dict(findings), manoeuvres)
        pickle.dump(note, self._file, pickle.HIGHEST_PROTOCOL)
        self.count += 1

    def _all(self) -> Iterator[Note]:
        self._file.seek(0)
        for _ in range(self.count):
            yield pickle.load(self._file)  # noqa: S301 - as above

    def _tables(self, thresholds_m: Sequence[float]) -> Iterator[Table]:
        """Yield a table a trip; what its file was taken for stands in the first of trips that share it."""
        last = None
        for note in self._all():
            inspection = note[0]
            taken = (inspection.source, inspection.reading.understood)
            yield trip_table(*note, thresholds_m=thresholds_m, with_understood=taken != last)
            last = taken

    def say_json(
        self, failures: Mapping[str, str], skipped: Mapping[str, str], thresholds_m: Sequence[float]
    ) -> None:
        """Print one JSON document, a trip at a time.

        Parameters
        ----------
        failures
            Files that could not be read, with the reason.
        skipped
            Vehicles and files that held no trip, with the reason.
        thresholds_m
            Tracking-error thresholds that the noise is judged by [m].
        """
        whole = {"failures": failures, "skipped": skipped, "thresholds_m": list(thresholds_m), "trips": []}
        head, _, tail = json.dumps(whole, indent=2, sort_keys=True).rpartition("[]")
        sys.stdout.write(head + "[")
        mark = "\n"
        for note in self._all():
            document = json.dumps(trip_document(*note, thresholds_m=thresholds_m), indent=2, sort_keys=True)
            sys.stdout.write(mark + indent(document, "    "))
            mark = ",\n"
        sys.stdout.write("\n  ]" + tail + "\n")

    def show(
        self, failures: Mapping[str, str], skipped: Mapping[str, str], thresholds_m: Sequence[float]
    ) -> None:
        """Print a table a trip, and what gave none.

        Parameters
        ----------
        failures, skipped, thresholds_m
            As for `say_json`.
        """
        tables = self._tables(thresholds_m)
        while some := list(islice(tables, _SHOWN_AT_ONCE)):
            show(*some)
        lines = failed_lines(failures, skipped)
        if lines:
            show(*lines)

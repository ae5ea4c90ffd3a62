"""A recording on the page: wound to any time, with errors where other recordings know the truth."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self, final

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import geodetic_to_local
from modelcast.dashboard.document import read_snapshot, road_text, snapshot_text
from modelcast.dashboard.feed import AbstractLogFeed
from modelcast.dashboard.seen_paths import SeenPaths
from modelcast.dashboard.snapshot import Snapshot
from modelcast.io.mcap_records import Place
from modelcast.node.recording.about import About
from modelcast.node.recording.reader import Recorded, RecordReader
from modelcast.node.recording.replay import about_of
from modelcast.node.recording.steps import read_step
from modelcast.node.recording.topics import PAGE, STEP

__all__ = ["RecordingFeed"]

_MOST_SNAPSHOTS = 2_000_000
_MOST_STEPS = 10_000_000
_LONGEST_GAP_S = 0.3
"""Between two recorded places that truth is taken from."""


@final
class RecordingFeed(AbstractLogFeed):
    """A recording that can be wound to any time; a context manager.

    Opening reads all of it once; what is kept is where each snapshot stands, and the road.

    Parameters
    ----------
    path
        The MCAP.
    truths
        Recordings of other nodes: where they knew themselves to be is the truth of the remotes that bear
        their names.

    Raises
    ------
    DataFormatError
        Where one of them is no recording.
    OSError
        Where one cannot be read.
    """

    def __init__(self, path: Path, truths: Sequence[Path] = ()) -> None:
        self._reader = RecordReader(path)
        super().__init__()
        self._places: list[Place] = []
        self._truth: dict[int, FloatArray] = {}
        try:
            about = about_of(self._reader)
            self._road = road_text(self._read_all())
            for truth in truths:
                for name, course in _courses(truth, about).items():
                    known = self._truth.get(name, np.zeros((0, 3)))
                    self._truth[name] = np.concatenate((known, course))
        except BaseException:
            self._reader.__exit__(None, None, None)
            raise

    def __enter__(self) -> Self:
        """Read from the open file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._reader.__exit__(kind, error, trace)

    @property
    def name(self) -> str:
        """The file's own name."""
        return self._reader.path.name

    @property
    def cut_off(self) -> bool:
        """Whether the end of the recording is missing."""
        return self._reader.cut_off

    def text_at(self, t_s: float) -> str:
        """The newest snapshot that is no later than a time, or the first.

        Parameters
        ----------
        t_s
            The time [s].

        Raises
        ------
        DataFormatError
            Where the file has changed since it was opened.
        """
        found = self._reader.at(self._places[self.place_at(t_s)])
        return snapshot_text(self._with_errors(self._judged(found)))

    def _read_all(self) -> list[FloatArray]:
        """Find all snapshots, and draw the road from them."""
        seen = SeenPaths()
        for message in self._reader.messages():
            if message.topic != PAGE.name:
                continue
            snapshot = self._judged(message)
            if self._times_s and snapshot.t_s <= self._times_s[-1]:
                problem = f"a snapshot of {snapshot.t_s} s after {self._times_s[-1]} s"
                raise self._reader.wrong(message, ValueError(problem))
            if len(self._times_s) == _MOST_SNAPSHOTS:
                raise self._reader.wrong(message, ValueError(f"more than {_MOST_SNAPSHOTS} snapshots"))
            self._times_s.append(snapshot.t_s)
            self._places.append(message.place)
            remotes = snapshot.remotes
            places = list(zip(remotes.vehicle.tolist(), *remotes.position_m.T.tolist(), strict=True))
            if snapshot.host is not None:
                places.append((-1, *snapshot.host.position_m))
            seen.add(places)
        if not self._times_s:
            raise DataFormatError(
                str(self._reader.path), "holds no snapshot", remedy="Record for a second or longer."
            )
        return seen.lines_m()

    def _judged(self, message: Recorded) -> Snapshot:
        try:
            return read_snapshot(message.data.decode())
        except ValueError as error:
            raise self._reader.wrong(message, error) from error

    def _with_errors(self, snapshot: Snapshot) -> Snapshot:
        """The same, with the distance to the truth where that is known."""
        remotes = snapshot.remotes
        error_m = remotes.error_m.copy()
        for row, name in enumerate(remotes.vehicle.tolist()):
            course = self._truth.get(name)
            place_m = None if course is None else _place_at(course, snapshot.t_s)
            if place_m is not None:
                error_m[row] = float(np.hypot(*(remotes.position_m[row] - place_m)))
        return replace(snapshot, remotes=replace(remotes, error_m=error_m))


def _courses(path: Path, host: About) -> dict[int, FloatArray]:
    """Where another node knew itself to be, by the name it bore: the host's time, east and north, (T, 3)."""
    rows: dict[int, list[tuple[float, float, float]]] = {}
    with RecordReader(path) as reader:
        later_s = about_of(reader).utc_at_zero_s - host.utc_at_zero_s
        count = 0
        for message in reader.messages():
            if message.topic != STEP.name:
                continue
            try:
                step = read_step(reader.words(message))
            except ValueError as error:
                raise reader.wrong(message, error) from error
            if step.motion is None:
                continue
            count += 1
            if count > _MOST_STEPS:
                raise reader.wrong(message, ValueError(f"more than {_MOST_STEPS} steps"))
            rows.setdefault(step.temporary_id, []).append((step.t_s + later_s, *step.motion.place_deg))
    found: dict[int, FloatArray] = {}
    for name, own in rows.items():
        table = np.array(own, dtype=np.float64)
        table[:, 1:] = geodetic_to_local(np.ascontiguousarray(table[:, 1:]), host.origin)
        found[name] = table
    return found


def _place_at(course: FloatArray, t_s: float) -> FloatArray | None:
    """East and north at a time, between two places that are known, (2,) [m]; None where there are none."""
    after = int(np.searchsorted(course[:, 0], t_s))
    if after < len(course) and course[after, 0] == t_s:
        return course[after, 1:]
    if not 0 < after < len(course) or course[after, 0] - course[after - 1, 0] > _LONGEST_GAP_S:
        return None
    share = (t_s - course[after - 1, 0]) / (course[after, 0] - course[after - 1, 0])
    return course[after - 1, 1:] + share * (course[after, 1:] - course[after - 1, 1:])

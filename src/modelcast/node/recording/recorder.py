"""Records a node as it runs: the step hands over and goes on, a thread writes.

Where the quota is reached, the disk refuses or the thread falls behind, recording ends for good, the files
are left readable, and the node goes on: `Recorder.ended` says why.
"""

import json
import threading
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, final

from modelcast.dashboard.document import snapshot_text
from modelcast.dashboard.snapshot import Snapshot
from modelcast.node.inputs.samples import Sample
from modelcast.node.node import NodeState
from modelcast.node.recording.about import About, about_words
from modelcast.node.recording.files import RecordingFiles, recorded_octets
from modelcast.node.recording.foxglove import geojson_words, location_words
from modelcast.node.recording.frames import heard_words, sent_words
from modelcast.node.recording.maps import belief_words
from modelcast.node.recording.record import AbstractRecord
from modelcast.node.recording.steps import sample_words, step_words
from modelcast.node.recording.topics import (
    ABOUT,
    BELIEFS,
    HEARD,
    LOCATION,
    PAGE,
    REMOTES,
    SAMPLES,
    SENT,
    STEP,
    Topic,
)
from modelcast.runtime.transport.base import Arrival
from modelcast.station.receiver.local_dynamic_map import Beliefs

__all__ = ["MOST_WAITING_OCTETS", "PAGE_EVERY_STEPS", "Recorder"]

MOST_WAITING_OCTETS = 64 << 20
"""What may wait to be written, about; beyond it the disk is too slow."""

PAGE_EVERY_STEPS = 5
"""Steps from one snapshot of the page to the next; so often also `REMOTES`."""

_FLUSH_NS = 1_000_000_000
_SHARE = 3
"""Octets of JSON for an octet that is handed over, about, base64 and names included."""

Messages = Iterable[tuple[Topic, int, dict[str, Any] | str]]


@final
class Recorder(AbstractRecord):
    """Writes a recording; a context manager.

    Parameters
    ----------
    folder
        Where; it is made where it is not there.
    about
        What the node is made again from.
    begin_s
        Now, on the node's clock: the files are named by it [s].
    most_octets
        Of all recordings in the folder, those that are there already included.

    Raises
    ------
    OSError
        Where nothing can be written there at all.
    """

    def __init__(self, folder: Path, about: About, *, begin_s: float, most_octets: float) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        before = recorded_octets(folder)
        self._about, self._calls, self._steps = about, 0, 0
        self._files = RecordingFiles(folder, about.utc_at_zero_s + begin_s, most_octets=most_octets - before)
        self.path = self._files.path
        """The MCAP; the capture beside it is named alike."""
        self.ended = ""
        """Why nothing more is recorded; empty while it is."""
        self._queue: deque[tuple[int, Callable[[], Messages], list[tuple[int, bytes]]]] = deque()
        self._waiting, self._closing = 0, False
        self._changed = threading.Condition()
        self._flushed_ns: int | None = None
        self._thread = threading.Thread(target=self._work, name="recorder", daemon=True)
        self._thread.start()
        self._put(1000, lambda: [(ABOUT, self._ns(begin_s), about_words(about))])

    def __enter__(self) -> "Recorder":
        """Record from now on."""
        return self

    def __exit__(self, *_: object) -> None:
        """Write what waits, and close."""
        self.close()

    @property
    def octets(self) -> int:
        """Written so far, both files together."""
        return self._files.octets

    def heard(self, now_s: float, arrived: Sequence[Arrival], outcomes: Sequence[str]) -> None:
        """Take what one call of `modelcast.node.node.Node.hear` brought."""
        call, frames = self._calls, list(arrived)
        self._calls += 1
        kept = [(self._ns(one.received_s), one.octets) for one in frames]
        self._put(
            sum(len(one.octets) + 100 for one in frames),
            lambda: (
                (HEARD, self._ns(one.received_s), words)
                for one, words in zip(frames, heard_words(call, now_s, frames, outcomes), strict=True)
            ),
            kept,
        )

    def sent(self, now_s: float, message: bytes, frame: bytes) -> None:
        """Take a frame that was handed to the transport."""
        t_ns = self._ns(now_s)
        self._put(
            len(message) + len(frame) + 100,
            lambda: [(SENT, t_ns, sent_words(now_s, message, frame))],
            [(t_ns, frame)],
        )

    def stepped(self, state: NodeState) -> None:
        """Take what a step made."""
        # Arrays of the map may be views of what the next step changes: they are copied now.
        around = Beliefs(**{one.name: getattr(state.around, one.name).copy() for one in fields(Beliefs)})
        t_ns, draws = self._ns(state.t_s), self._steps % PAGE_EVERY_STEPS == 0
        self._steps += 1

        def messages() -> Messages:
            yield STEP, t_ns, step_words(state)
            yield BELIEFS, t_ns, belief_words(state.t_s, around)
            if state.motion is not None:
                yield LOCATION, t_ns, location_words(state.motion, t_ns)
            if draws:
                yield REMOTES, t_ns, geojson_words(around, self._about.origin)

        self._put(sum(getattr(around, one.name).nbytes for one in fields(Beliefs)) + 1000, messages)

    def sampled(self, now_s: float, samples: Sequence[Sample]) -> None:
        """Take what was taken from a source.

        Parameters
        ----------
        now_s
            When [s].
        samples
            In order of arrival.
        """
        if samples:
            t_ns, own = self._ns(now_s), list(samples)
            self._put(100 * len(own), lambda: [(SAMPLES, t_ns, sample_words(now_s, own))])

    @property
    def wants_page(self) -> bool:
        """Whether the step that was taken last is one that the page is recorded of."""
        return not self.ended and self._steps % PAGE_EVERY_STEPS == 1

    def shown(self, snapshot: Snapshot) -> None:
        """Take what the page would show, where `wants_page`.

        Parameters
        ----------
        snapshot
            Of the last step.
        """
        t_ns = self._ns(snapshot.t_s)
        self._put(150 * snapshot.remotes.vehicle.size + 1000, lambda: [(PAGE, t_ns, snapshot_text(snapshot))])

    def close(self) -> None:
        """Write what waits, end the files and let go of them."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join()

    def _ns(self, t_s: float) -> int:
        return round((self._about.utc_at_zero_s + t_s) * 1e9)

    def _put(
        self, octets: int, messages: Callable[[], Messages], frames: list[tuple[int, bytes]] | None = None
    ) -> None:
        with self._changed:
            if self.ended:
                return
            self._waiting += octets
            if self._waiting > MOST_WAITING_OCTETS:
                self._closing, self.ended = True, "the disk is too slow"
            else:
                self._queue.append((octets, messages, frames or []))
            self._changed.notify()

    def _work(self) -> None:
        """Write what is handed over, until it is to end."""
        try:
            while not self.ended or self._queue:
                with self._changed:
                    self._changed.wait_for(lambda: self._queue or self._closing)
                    if not self._queue:
                        break
                    octets, messages, frames = self._queue.popleft()
                    self._waiting -= octets
                if not self._files.has_room(_SHARE * octets):
                    self._end("the quota is reached")
                    break
                self._write(messages(), frames)
            self._files.finish()
        except OSError as error:
            self._end(error.strerror or str(error))
            self._files.give_up()

    def _write(self, messages: Messages, frames: list[tuple[int, bytes]]) -> None:
        newest_ns = 0
        for topic, t_ns, words in messages:
            text = (
                words if isinstance(words, str) else json.dumps(words, separators=(",", ":"), allow_nan=False)
            )
            self._files.add(topic, t_ns, text)
            newest_ns = max(newest_ns, t_ns)
        self._files.add_frames(frames)
        if self._flushed_ns is None or newest_ns - self._flushed_ns >= _FLUSH_NS:
            self._flushed_ns = newest_ns
            self._files.flush()

    def _end(self, why: str) -> None:
        with self._changed:
            self.ended = self.ended or why
            self._queue.clear()
            self._waiting = 0

"""A recorded node made again and taken through what it met: the same map, bit for bit, or what differs."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, final

from modelcast.core.exceptions import DataFormatError
from modelcast.node.building import node_of
from modelcast.node.config import NodeConfig
from modelcast.node.envelope import AbstractEnvelope
from modelcast.node.node import Node, NodeState
from modelcast.node.recording.about import About, read_about
from modelcast.node.recording.frames import Heard, Sent, read_heard, read_sent
from modelcast.node.recording.making import config_of, envelope_again, profile_of
from modelcast.node.recording.maps import belief_difference
from modelcast.node.recording.reader import Recorded, RecordReader
from modelcast.node.recording.record import AbstractRecord
from modelcast.node.recording.steps import Step, read_step, step_words
from modelcast.node.recording.topics import ABOUT, BELIEFS, HEARD, SENT, STEP
from modelcast.runtime.transport.base import AbstractTransport, Arrival
from modelcast.station.sender.sender import Sender

__all__ = ["Replayed", "about_of", "replay_recording"]

_REMEDY = "It must be an MCAP that modelcast node recorded (docs/recording.md)."
_MOST_IN_CALL = 100_000

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class Replayed:
    """What a replay found.

    Parameters
    ----------
    steps, heard, sent
        Steps that were taken again, frames that were heard and messages that were sent in them.
    difference
        The first difference from the recording, in words; empty for none.
    cut_off
        Whether the recording's end is missing, as after a crash.
    skipped
        Messages of topics that are none of a recording, by topic.
    """

    steps: int
    heard: int
    sent: int
    difference: str
    cut_off: bool
    skipped: dict[str, int]


def about_of(reader: RecordReader) -> About:
    """What the node of a recording is made again from.

    Parameters
    ----------
    reader
        The recording.

    Raises
    ------
    DataFormatError
        Where it does not say so at its begin.
    """
    first = next(reader.messages(), None)
    if first is None or first.topic != ABOUT.name:
        raise DataFormatError(str(reader.path), f"does not begin with {ABOUT.name}", remedy=_REMEDY)
    return _read(reader, first, read_about)


def replay_recording(
    path: Path,
    sender_of: Callable[[NodeConfig], Sender],
    *,
    visit: Callable[[Node, NodeState], None] | None = None,
) -> Replayed:
    """Make the node of a recording again, take it through what it met, and compare.

    Every frame is given to it in the call in which it arrived, every step gets the own motion that was
    recorded. What is compared, to the bit: the map after every step, what became of every frame, every
    message sent, the name, and the warnings. The first difference ends it.

    Parameters
    ----------
    path
        The MCAP.
    sender_of
        Gives what a configuration sends.
    visit
        Takes the node and its state after every step.

    Raises
    ------
    DataFormatError
        Where the file is no recording, or one of another modelcast.
    ConfigError
        Where bank or profile cannot be had.
    OSError
        Where it cannot be read.
    """
    with RecordReader(path) as reader:
        about = about_of(reader)
        config = config_of(about, str(path))
        sender = sender_of(config)
        profile = profile_of(config, sender)
        if profile != about.profile:
            raise DataFormatError(
                str(path),
                f"its bank {config.sending.bank!r} had the number {about.profile}, and has {profile} now",
                remedy="Replay it where bank and profile are what they were.",
            )
        course = _Course(config, sender, about, envelope_again(about, config, str(path)))
        difference = ""
        for message in reader.messages():
            difference = course.take(reader, message)
            if difference:
                break
            if visit is not None and course.stepped is not None and message.topic == BELIEFS.name:
                visit(course.node, course.stepped)
        if not difference and not reader.cut_off:
            difference = course.finish(reader)
        return Replayed(
            steps=course.steps,
            heard=course.heard,
            sent=course.sent,
            difference=difference,
            cut_off=reader.cut_off,
            skipped=dict(reader.skipped),
        )


@final
class _Tape(AbstractTransport):
    """Gives what was recorded, and lets go of what is sent."""

    def __init__(self) -> None:
        self.inbox: list[Arrival] = []

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Nothing: what is sent is taken by the record."""

    def receive(self, until_s: float) -> list[Arrival]:  # noqa: ARG002 - they are of this call
        """Give what was put in."""
        found, self.inbox = self.inbox, []
        return found


@final
class _Again(AbstractRecord):
    """Keeps what the node does now until the recording says the same."""

    def __init__(self) -> None:
        self.outcomes: list[str] = []
        self.messages: deque[bytes] = deque()

    def heard(self, now_s: float, arrived: Any, outcomes: Any) -> None:  # noqa: ARG002
        """Keep what became of frames."""
        self.outcomes = list(outcomes)

    def sent(self, now_s: float, message: bytes, frame: bytes) -> None:  # noqa: ARG002
        """Keep a message."""
        self.messages.append(message)

    def stepped(self, state: NodeState) -> None:
        """Nothing: the state is what the step returns."""


@final
class _Course:
    """The node, and where in the recording it is."""

    def __init__(self, config: NodeConfig, sender: Sender, about: About, envelope: AbstractEnvelope) -> None:
        self._tape, self._again = _Tape(), _Again()
        self.node = node_of(
            config, sender, self._tape, envelope, origin=about.origin, names_seed=about.names_seed,
            station_seed=about.station_seed, record=self._again,
        )  # fmt: skip
        self.steps = self.heard = self.sent = 0
        self.stepped: NodeState | None = None
        self._call: list[Heard] = []

    def take(self, reader: RecordReader, message: Recorded) -> str:
        """Do what a message tells, and return what is different; empty for nothing."""
        if message.topic == HEARD.name:
            return self._take_heard(_read(reader, message, read_heard), reader)
        difference = self._hear(reader)
        if difference or message.topic not in {STEP.name, BELIEFS.name, SENT.name}:
            return difference
        if message.topic == STEP.name:
            return self._step(_read(reader, message, read_step), reader)
        if message.topic == SENT.name:
            return self._send(_read(reader, message, read_sent), reader)
        return self._compare(reader, message)

    def finish(self, reader: RecordReader) -> str:
        """Bring the last frames to the node; where the recording is cut off there may be more of them."""
        return self._hear(reader)

    def _take_heard(self, one: Heard, reader: RecordReader) -> str:
        """Gather the frames of one call; the next call's first brings them to the node."""
        difference = "" if not self._call or one.call == self._call[0].call else self._hear(reader)
        if len(self._call) >= _MOST_IN_CALL:
            problem = f"more than {_MOST_IN_CALL} frames in the call {one.call}"
            raise DataFormatError(str(reader.path), problem, remedy=_REMEDY)
        self._call.append(one)
        return difference

    def _hear(self, reader: RecordReader) -> str:
        call, self._call = self._call, []
        if not call:
            return ""
        self._tape.inbox = [one.arrival for one in call]
        _run(reader, lambda: self.node.hear(call[0].now_s))
        for one, outcome in zip(call, self._again.outcomes, strict=True):
            if one.outcome != outcome:
                at_s = one.arrival.received_s
                return f"the frame received at {at_s!r} s: {outcome!r}, not {one.outcome!r}"
        self.heard += len(call)
        return ""

    def _send(self, one: Sent, reader: RecordReader) -> str:
        if not self._again.messages:
            _run(reader, lambda: self.node.send(one.now_s))
        if not self._again.messages:
            return f"nothing is sent at {one.now_s!r} s, and {len(one.message)} octets were"
        now = self._again.messages.popleft()
        if now != one.message:
            pairs = zip(now, one.message, strict=False)
            least = min(len(now), len(one.message))
            at = next((at for at, (new, old) in enumerate(pairs) if new != old), least)
            return f"the message sent at {one.now_s!r} s differs from octet {at} on"
        self.sent += 1
        return ""

    def _step(self, one: Step, reader: RecordReader) -> str:
        if self._again.messages:
            return f"{len(self._again.messages)} messages more are sent before the step at {one.t_s!r} s"
        self.stepped = _run(reader, lambda: self.node.step(one.t_s, one.motion))
        self.steps += 1
        words = step_words(self.stepped)
        for name, value in one.words.items():
            if words[name] != value:
                return f"{self._place()}: {name} is {words[name]!r}, not {value!r}"[:500]
        return ""

    def _compare(self, reader: RecordReader, message: Recorded) -> str:
        state = self.stepped
        if state is None:
            raise reader.wrong(message, ValueError("a map before the first step"))
        difference = _read(reader, message, lambda words: belief_difference(words, state.t_s, state.around))
        return difference and f"{self._place()}: {difference}"[:500]

    def _place(self) -> str:
        assert self.stepped is not None  # noqa: S101 - called after a step
        return f"step {self.steps} at {self.stepped.t_s!r} s"


def _run(reader: RecordReader, act: Callable[[], Result]) -> Result:
    """Do what a recording asks of the node; times that no node runs through are the recording's fault."""
    try:
        return act()
    except ValueError as error:
        raise DataFormatError(
            str(reader.path), f"a node cannot go through it: {error}", remedy=_REMEDY
        ) from error


def _read(reader: RecordReader, message: Recorded, read: Callable[[object], Result]) -> Result:
    """The words of a message as what they are."""
    words = reader.words(message)
    try:
        return read(words)
    except ValueError as error:
        raise reader.wrong(message, error) from error

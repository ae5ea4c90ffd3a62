"""Recorded frames on the air again, at the times at which the node sent and heard them."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

from modelcast.node.clock import AbstractClock
from modelcast.node.recording.frames import read_heard, read_sent
from modelcast.node.recording.reader import RecordReader
from modelcast.node.recording.topics import HEARD, SENT
from modelcast.runtime.transport.base import AbstractTransport

__all__ = ["emit_recording"]


async def emit_recording(
    path: Path,
    transport: AbstractTransport,
    clock: AbstractClock,
    *,
    times_as_fast: float = 1.0,
    stop: asyncio.Event,
) -> int:
    """Send every frame of a recording again, the node's own and those it heard; returns how many.

    The octets are the recorded ones: they state the recorded times, and a node that judges the age of
    messages refuses them where its clock has gone on.

    Parameters
    ----------
    path
        The MCAP.
    transport
        Where frames go.
    clock
        By which they are timed.
    times_as_fast
        k: the recording takes 1/k of its time.
    stop
        Ends it before.

    Raises
    ------
    ValueError
        Where k is not positive.
    DataFormatError, OSError
        As for `RecordReader`.
    """
    if not 0.0 < times_as_fast < float("inf"):
        raise ValueError(f"times_as_fast must be positive, got {times_as_fast}")
    sent, began_s, first_s = 0, clock.now_s(), None
    with RecordReader(path) as reader:
        for t_s, octets in _frames(reader):
            first_s = t_s if first_s is None else first_s
            wait_s = began_s + (t_s - first_s) / times_as_fast - clock.now_s()
            if wait_s > 0.0:
                try:
                    async with asyncio.timeout(wait_s):
                        await stop.wait()
                except TimeoutError:
                    pass
            if stop.is_set():
                break
            if octets:
                transport.send(octets, sent_s=clock.now_s())
                sent += 1
    return sent


def _frames(reader: RecordReader) -> Iterator[tuple[float, bytes]]:
    for message in reader.messages():
        if message.topic not in {HEARD.name, SENT.name}:
            continue
        words = reader.words(message)
        try:
            if message.topic == HEARD.name:
                arrival = read_heard(words).arrival
                found = arrival.received_s, arrival.octets
            else:
                own = read_sent(words)
                found = own.now_s, own.octets
        except ValueError as error:
            raise reader.wrong(message, error) from error
        yield found

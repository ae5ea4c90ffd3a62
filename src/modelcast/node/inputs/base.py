"""A source of samples, and the bounded box between whoever fills it and whoever takes from it."""

import abc
from collections import Counter, deque
from collections.abc import Iterable, Mapping
from threading import Lock

from modelcast.node.inputs.samples import Sample

__all__ = ["AbstractSource", "Mailbox"]


class AbstractSource(abc.ABC):
    """What a node measures by; see `modelcast.node.inputs` for the verbs."""

    @abc.abstractmethod
    async def start(self) -> None:
        """Begin; returns at once, whether or not the other end is there."""

    @abc.abstractmethod
    async def stop(self) -> None:
        """End, and let go of sockets, devices and threads."""

    @abc.abstractmethod
    def take(self, now_s: float) -> list[Sample]:
        """What came since the last call and not after a time, in order of arrival; never waits.

        Parameters
        ----------
        now_s
            On the node's clock [s].
        """

    @abc.abstractmethod
    def counts(self) -> Mapping[str, int]:
        """What was met so far, by name: samples, connections, and what was passed over by reason."""


class Mailbox:
    """Samples that wait to be taken, and what else was met; filled and emptied from any thread.

    Parameters
    ----------
    most
        Samples kept; where one more comes the oldest goes, counted as "overrun".

    Examples
    --------
    >>> from modelcast.node.inputs.samples import BusValue
    >>> box = Mailbox(most=2)
    >>> for at in (1.0, 2.0, 3.0, 4.0):
    ...     box.put([BusValue("speed_mps", at, at, at)])
    >>> [value.value for value in box.take(3.5)], [value.value for value in box.take(4.0)]
    ([3.0], [4.0])
    >>> box.counts()
    {'samples': 4, 'overrun': 2}
    """

    def __init__(self, *, most: int) -> None:
        if most < 1:
            raise ValueError(f"most must be at least 1, got {most}")
        self._most = most
        self._samples: deque[Sample] = deque()
        self._counts: Counter[str] = Counter()
        self._lock = Lock()

    def put(self, samples: Iterable[Sample]) -> None:
        """Add samples, each received not before the last."""
        with self._lock:
            for sample in samples:
                self._counts["samples"] += 1
                if len(self._samples) == self._most:
                    self._samples.popleft()
                    self._counts["overrun"] += 1
                self._samples.append(sample)

    def take(self, now_s: float) -> list[Sample]:
        """Remove and return what was received up to a time [s]."""
        taken: list[Sample] = []
        with self._lock:
            while self._samples and self._samples[0].received_s <= now_s:
                taken.append(self._samples.popleft())
        return taken

    def count(self, name: str, many: int = 1) -> None:
        """Count something that was met."""
        with self._lock:
            self._counts[name] += many

    def counts(self) -> dict[str, int]:
        """What was met so far, by name."""
        with self._lock:
            return dict(self._counts)

"""Where the page's snapshots come from: live, or from a log that can be wound to any time."""

import abc
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from modelcast.dashboard.document import road_text, snapshot_text
from modelcast.dashboard.seen_paths import SeenPaths
from modelcast.dashboard.slot import LatestSlot
from modelcast.dashboard.snapshot import Snapshot

__all__ = ["KINDS", "AbstractFeed", "AbstractLogFeed", "LiveFeed", "Span"]

KINDS = ("road", "snapshot")
"""Of the texts that a feed puts into a slot."""

_ROAD_EVERY_S = 2.0


@dataclass(frozen=True, slots=True)
class Span:
    """What of a log there is.

    Parameters
    ----------
    first_s, last_s
        Times of its first and last snapshot [s].
    step_s
        Usual time between two [s].
    """

    first_s: float
    last_s: float
    step_s: float


class AbstractFeed(abc.ABC):
    """Gives texts of `modelcast.dashboard.document` to whoever looks; all calls from one event loop."""

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """What is looked at, for people."""

    @property
    @abc.abstractmethod
    def span(self) -> Span | None:
        """What of a log there is; None where snapshots come by themselves."""

    @abc.abstractmethod
    def attach(self, slot: LatestSlot) -> None:
        """Begin to give to one who looks: the road, the newest or first snapshot, then what comes.

        Parameters
        ----------
        slot
            With the kinds `KINDS`.
        """

    @abc.abstractmethod
    def detach(self, slot: LatestSlot) -> None:
        """Give no more.

        Parameters
        ----------
        slot
            As attached.
        """

    @abc.abstractmethod
    def seek(self, slot: LatestSlot, t_s: float) -> None:
        """Give the newest snapshot of a log that is no later than a time; a live feed ignores it.

        Parameters
        ----------
        slot
            As attached.
        t_s
            The time, any number [s].
        """


class AbstractLogFeed(AbstractFeed):
    """A log whose snapshots are found by their times, which rise; whoever opens it fills these in."""

    def __init__(self) -> None:
        self._times_s: list[float] = []
        self._road = road_text([])

    def __len__(self) -> int:
        return len(self._times_s)

    @property
    def span(self) -> Span:
        """First and last time, and the median step, in whole milliseconds."""
        steps = np.diff(self._times_s)
        step_s = round(float(np.median(steps)), 3) if steps.size else 0.1
        return Span(self._times_s[0], self._times_s[-1], step_s)

    @abc.abstractmethod
    def text_at(self, t_s: float) -> str:
        """The newest snapshot that is no later than a time, or the first.

        Parameters
        ----------
        t_s
            The time [s].
        """

    def place_at(self, t_s: float) -> int:
        """Which snapshot that is, counted from 0.

        Parameters
        ----------
        t_s
            The time [s].
        """
        return max(bisect_right(self._times_s, t_s) - 1, 0)

    def attach(self, slot: LatestSlot) -> None:
        """Give the road and the first snapshot."""
        slot.put("road", self._road)
        self.seek(slot, -np.inf)

    def detach(self, slot: LatestSlot) -> None:
        """Nothing: a log gives only what it is asked for."""

    def seek(self, slot: LatestSlot, t_s: float) -> None:
        """Give the snapshot of a time."""
        slot.put("snapshot", self.text_at(t_s))


class LiveFeed(AbstractFeed):
    """Passes on what is published, and draws the road from it.

    Parameters
    ----------
    name
        What is looked at, for people.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._slots: set[LatestSlot] = set()
        self._seen = SeenPaths()
        self._road: tuple[int, float, str] | None = None
        self._newest: str | None = None

    @property
    def name(self) -> str:
        """What is looked at."""
        return self._name

    @property
    def span(self) -> Span | None:
        """None: it is live."""
        return None

    @property
    def watched(self) -> bool:
        """Whether anybody looks; where nobody does, snapshots need not be made."""
        return bool(self._slots)

    def publish(self, snapshot: Snapshot) -> None:
        """Show a snapshot to all who look.

        Parameters
        ----------
        snapshot
            Later than the last.
        """
        self._draw(snapshot)
        self._newest = snapshot_text(snapshot)
        for slot in self._slots:
            slot.put("snapshot", self._newest)

    def forget_road(self) -> None:
        """Draw the road anew, as where the plane has changed."""
        self._seen, self._road = SeenPaths(), None
        for slot in self._slots:
            slot.put("road", road_text([]))

    def attach(self, slot: LatestSlot) -> None:
        """Begin to give the road and the newest snapshot."""
        self._slots.add(slot)
        if self._road is not None:
            slot.put("road", self._road[2])
        if self._newest is not None:
            slot.put("snapshot", self._newest)

    def detach(self, slot: LatestSlot) -> None:
        """Give no more."""
        self._slots.discard(slot)

    def seek(self, slot: LatestSlot, t_s: float) -> None:
        """Nothing: there is only now."""

    def _draw(self, snapshot: Snapshot) -> None:
        """Take the places in; every two seconds a road that has grown is given again."""
        host, remotes = snapshot.host, snapshot.remotes
        places = list(zip(remotes.vehicle.tolist(), *remotes.position_m.T.tolist(), strict=True))
        if host is not None:
            places.append((-1, *host.position_m))
        self._seen.add(places)
        before = (0, -1e300) if self._road is None else self._road[:2]
        if self._seen.points > before[0] and not 0.0 <= snapshot.t_s - before[1] < _ROAD_EVERY_S:
            self._road = (self._seen.points, snapshot.t_s, road_text(self._seen.lines_m()))
            for slot in self._slots:
                slot.put("road", self._road[2])

"""People beside a fleet on the air: what their devices send, which antennas they have, whom they track.

A phone is no car: its antenna is low and small, it sends by a rule of its own, and nobody needs to know of a
pedestrian far away. People are told by `FleetFrame.kind`. Their devices are on the air like all others: what
they send contends and disturbs, and what they pass over they have received.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from math import inf, isfinite
from typing import Literal, get_args

import numpy as np

from modelcast.channel.cells_kernels import build_cells
from modelcast.channel.radio import Receptions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.core.kinds import PEOPLE
from modelcast.core.parts import Parts
from modelcast.runtime.fleet import people_kernels as kernels
from modelcast.runtime.fleet.arrays import Tally
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.fleet.tracking_kernels import count_pairs, most_in_reach
from modelcast.station.sender.message_arrays import SentTally
from modelcast.station.sender.sender import Sender
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Devices", "Keeps", "People", "PeopleRun", "is_person"]

Keeps = Literal["vehicles", "all", "nobody"]
"""Of whom people's devices keep a map."""


@dataclass(frozen=True, slots=True)
class People:
    """What the devices of people do.

    Parameters
    ----------
    sender
        What they send, when, and with which power.
    gain_db
        What their antennas add to a vehicle's, as they hear and as they send, not above 0 [dB].
    keeps
        Of whom they keep a map: of vehicles, of all, or of nobody. What they hear of others is passed over
        unread.
    reach_m
        People and vehicles farther apart than this keep no track of one another, nor people of people; such
        pairs are not counted either [m].

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    sender: Sender
    _: KW_ONLY
    gain_db: float = 0.0
    keeps: Keeps = "vehicles"
    reach_m: float = inf

    def __post_init__(self) -> None:
        if not (isfinite(self.gain_db) and self.gain_db <= 0.0):
            raise ValueError(f"gain_db must be finite and not above 0, got {self.gain_db}")
        if self.keeps not in get_args(Keeps):
            raise ValueError(f"keeps must be one of {', '.join(get_args(Keeps))}, got {self.keeps!r}")
        if not self.reach_m > 0.0:
            raise ValueError(f"reach_m must be positive, got {self.reach_m}")


@dataclass(frozen=True, slots=True)
class PeopleRun:
    """What the devices of people did in a run, the warm-up left out.

    Parameters
    ----------
    sent
        What they sent.
    person_s
        Time observed, over all people [s].
    received
        Messages that their radios decoded.
    unread
        Of these, those of whom they keep no map.
    far
        Of the others, those that state a place beyond their reach. What is left they read.
    """

    sent: SentTally
    _: KW_ONLY
    person_s: float
    received: int
    unread: int
    far: int

    @property
    def read(self) -> int:
        """Messages that were worth their signature's check: neither unread nor far."""
        return self.received - self.unread - self.far


def is_person(frame: FleetFrame) -> BoolArray:
    """Which slots hold a person, (V,).

    Parameters
    ----------
    frame
        The truth.
    """
    if frame.kind is None:
        return np.zeros(len(frame), dtype=np.bool_)
    return np.asarray(frame.active & np.isin(frame.kind, PEOPLE), dtype=np.bool_)


class Devices:
    """The devices of the people of one run.

    Parameters
    ----------
    people
        What they do.
    settings
        Of the run.
    """

    def __init__(self, people: People, settings: NetworkSettings) -> None:
        self.people, self._settings = people, settings
        self._keeps = get_args(Keeps).index(people.keeps)
        self._person: BoolArray = np.zeros(0, dtype=np.bool_)
        self._steps, self._counts = 0, np.zeros(kernels.FATES, dtype=np.int64)

    @property
    def reach_m(self) -> float:
        """How far apart the ends of a pair with a person may be that is tracked and counted [m]."""
        return min(self.people.reach_m, self._settings.reach_m)

    @property
    def person(self) -> BoolArray:
        """Which slots hold a person, (V,)."""
        return self._person

    def place(self, frame: FleetFrame, stations: int) -> bool:
        """Take the people of a frame over; returns whether others are people than before.

        Parameters
        ----------
        frame
            The truth.
        stations
            Slots of the fleet, those of units behind the frame's among them.
        """
        before, found = self._person, np.zeros(stations, dtype=np.bool_)
        found[: len(frame)] = is_person(frame)
        self._person = found
        self._steps += int(found.sum())
        return not np.array_equal(before, found)

    def gains_db(self) -> FloatArray:
        """What each antenna adds to a vehicle's, (V,) [dB]."""
        return np.where(self._person, self.people.gain_db, 0.0)

    def read(self, received: Receptions, seen_m: FloatArray, rows: FloatArray) -> Receptions:
        """What hosts read of what they received.

        Parameters
        ----------
        received
            By all stations.
        seen_m
            Where stations take themselves to be, (V, 2) [m].
        rows
            Contents of messages, as `Contents` has them.
        """
        kept = np.empty(received.size, dtype=np.int64)
        found = kernels.find_read(
            owned(received.message_id, np.int64),
            owned(received.receiver, np.int64),
            self._person,
            self._keeps,
            seen_m,
            rows,
            self.people.reach_m,
            kept,
            self._counts,
        )
        if found == received.size:
            return received
        kept = kept[:found]
        return replace(
            received,
            message_id=received.message_id[kept],
            sender=received.sender[kept],
            receiver=received.receiver[kept],
            t_s=received.t_s[kept],
            rssi_dbm=received.rssi_dbm[kept],
        )

    def count_pairs(
        self, truth_m: FloatArray, counted: BoolArray, tallies: Sequence[Tally], parts: Parts
    ) -> None:
        """Count the pairs that may be tracked: of vehicles all, with people those in reach.

        Parameters
        ----------
        truth_m
            Where stations are, NaN where nobody is, (V, 2) [m].
        counted
            Whose pairs as hosts count, (V,).
        tallies
            One a part; written.
        parts
            Share the work.
        """
        bins, width_m = tallies[0].pairs.size, self._settings.distance_bin_m
        vehicles = build_cells(np.where(self._person[:, None], np.nan, truth_m), width_m * bins)
        everybody = build_cells(truth_m, min(self.reach_m, width_m * bins))

        def work(part: int) -> None:
            share, pairs = (part, parts.number), tallies[part].pairs
            count_pairs(vehicles, share, width_m, counted, pairs)
            kernels.count_with_people(
                everybody, share, self._person, self._keeps, self.reach_m, width_m, counted, pairs
            )

        parts.each(work)

    def most_in_reach(self, frame: FleetFrame) -> int:
        """Upper bound of the stations that one may track in a frame.

        Parameters
        ----------
        frame
            The truth.
        """
        here = np.where(frame.active[:, None], frame.position_m, np.nan)
        person = is_person(frame)
        vehicles = np.where(person[:, None], np.nan, here)
        return most_in_reach(vehicles, self._settings.reach_m) + most_in_reach(here, self.reach_m)

    def forget_counts(self) -> None:
        """Set all counts to zero."""
        self._steps, self._counts = 0, np.zeros(kernels.FATES, dtype=np.int64)

    def run(self, sent: SentTally) -> PeopleRun:
        """What was counted since the counts were forgotten.

        Parameters
        ----------
        sent
            What they sent.
        """
        counts: IntArray = self._counts
        return PeopleRun(
            sent,
            person_s=self._steps * self._settings.dt_s,
            received=int(counts.sum()),
            unread=int(counts[kernels.UNREAD]),
            far=int(counts[kernels.TOO_FAR]),
        )

"""Receptions of a step on their way to the hosts: checked, sorted by host, and taken in part by part."""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.radio import Receptions
from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.runtime.fleet.arrays import Tally, Tracks
from modelcast.runtime.fleet.reception_kernels import Heard, HearingLimits, by_host, hear_messages
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.sender.message_arrays import SENDER_BITS, Contents

__all__ = ["Hearing", "check_receptions"]


@dataclass(frozen=True, slots=True)
class Hearing:
    """The hosts of a fleet while one step is on the air.

    Parameters
    ----------
    limits
        What a host takes in.
    tables, tracks, contents
        What hosts hold, and what messages say.
    vehicle
        Who is in which slot, (V,).
    seen_m, truth_m
        Where hosts take themselves to be, and where they are, (V, 2) [m].
    reading
        How they read messages, (V,).
    counted
        Whose gaps count, (V,).
    first_unit
        The first slot of roadside units, V where there are none: what they send are copies.
    """

    limits: HearingLimits
    _: KW_ONLY
    tables: NeighbourTables
    tracks: Tracks
    contents: Contents
    vehicle: IntArray
    seen_m: FloatArray
    truth_m: FloatArray
    reading: IntArray
    counted: BoolArray
    first_unit: int

    def taking(
        self, received: Receptions, parts: Sequence[tuple[int, int]], tallies: Sequence[Tally]
    ) -> Callable[[int], None]:
        """The work of letting hosts take in what they heard, for any part of them.

        Parameters
        ----------
        received
            Receptions in order of time. Those of one step may be taken in one after another.
        parts
            First and end slot of each part.
        tallies
            Where each part counts.
        """
        receiver = owned(received.receiver, np.int64)
        start, order = (
            np.empty(self.vehicle.size + 1, dtype=np.int64),
            np.empty(receiver.size, dtype=np.int64),
        )
        by_host(receiver, start, order)
        heard = Heard(
            message_id=owned(received.message_id, np.int64),
            received_s=owned(received.t_s),
            order=order,
            start=start,
            vehicle=self.vehicle,
            seen_m=self.seen_m,
            truth_m=self.truth_m,
            reading=self.reading,
            counted=self.counted,
            is_copy=owned(received.sender >= self.first_unit, np.bool_),
        )

        def work(part: int) -> None:
            hear_messages(
                heard, self.limits, self.tables, self.contents.rows, self.tracks, tallies[part], *parts[part]
            )

        return work


def check_receptions(received: Receptions, vehicles: int, since_s: float, radio: str) -> None:
    """Refuse receptions that hosts cannot look up.

    Parameters
    ----------
    received
        What a radio delivered.
    vehicles
        Number V of slots.
    since_s
        When the interval began [s].
    radio
        Its name.

    Raises
    ------
    ValueError
        Where they are none of this fleet's (`Receptions.check`), or a message was never sent.
    """
    try:
        received.check(vehicles, since_s)
    except ValueError as error:
        raise ValueError(f"{radio}: {error}") from error
    unknown = (received.message_id & ((1 << SENDER_BITS) - 1)) >= vehicles
    if unknown.any():
        raise ValueError(f"{radio}: message {int(received.message_id[unknown][0])} was never sent")

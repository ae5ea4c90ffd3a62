"""A policy in NumPy in the station: asked once a step about all that send, between two compiled steps.

What it decides is checked before a station acts on it. Random numbers are of a generator of its own, so that
the same seed gives the same messages, whatever the number of threads.
"""

import numpy as np

from modelcast.messages.stack_kernels import airtime, frame_bytes
from modelcast.station.policy.base import Air
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.policy.policy_numbers import RULE_PLAIN
from modelcast.station.sender.asking import Asking, inputs_of
from modelcast.station.sender.deciding_kernels import Decided, asked, know_each, post_each
from modelcast.station.sender.message_arrays import Contents, Outbox, SentTally
from modelcast.station.sender.posting_kernels import SendingStations, StepInputs
from modelcast.station.sender.sender import Sender

__all__ = ["Deciding", "deciding_of"]


class Deciding:
    """The stations of one sender whose policy decides in NumPy.

    Parameters
    ----------
    sender
        Its policy is asked.
    stations
        V of them, that have sent nothing.
    rng
        Of the policy alone.

    Raises
    ------
    ValueError
        Where the policy's state has no row a vehicle.
    """

    def __init__(self, sender: Sender, stations: SendingStations, rng: np.random.Generator) -> None:
        vehicles, members = stations.senders.vehicle.size, stations.models.members.windows.size
        self._asking = Asking(sender.policy, vehicles, members, rng)
        self._power_dbm = sender.power_dbm
        self._asked = asked(vehicles, members)
        self._decided = Decided(
            np.zeros(vehicles, dtype=np.int64),
            np.full(vehicles, -1, dtype=np.int64),
            np.full(vehicles, np.inf),
            np.zeros(vehicles),
            np.zeros(vehicles, dtype=np.bool_),
            np.zeros((vehicles, 2), dtype=np.int64),
        )

    def decide(self, stations: SendingStations, given: StepInputs, tables: NeighbourTables) -> None:
        """Ask the policy about all stations that send in a step; `post` acts on it.

        Parameters
        ----------
        stations, given, tables
            As for `send_each`.

        Raises
        ------
        ValueError
            Where it decides what a station cannot do; it names the policy.
        """
        known, decided = self._asked, self._decided
        know_each(stations, given, tables, known)
        rows = np.flatnonzero(known.asks)
        if not rows.size:
            return
        self._asking.begin(np.flatnonzero(known.begins))
        stack, drawn = stations.numbers.stack, stations.numbers.frames
        longest = frame_bytes(int(stations.models.sizes.max()), True, stack)
        longest_s = airtime(drawn.mean_bytes if drawn.size_bytes.size else longest, stack)
        air = Air(
            given.busy_ratio[rows],
            known.neighbours[rows],
            packet_error_ratio=known.error_ratio[rows],
            airtime_s=np.full(rows.size, longest_s),
        )
        inputs = inputs_of(known, rows, dt_s=given.dt_s, critical=given.critical[rows], air=air)
        said = self._asking.decide(rows, inputs)
        decided.kind[rows], decided.member[rows] = said.kind, said.in_use
        decided.send_s[rows], decided.believed[rows] = said.send_s, said.believed
        power_dbm = np.where(np.isnan(said.power_dbm), self._power_dbm, said.power_dbm)
        decided.power_dbm[rows] = np.minimum(power_dbm, self._power_dbm)

    def post(
        self,
        stations: SendingStations,
        given: StepInputs,
        box: tuple[Contents, Outbox, SentTally],
        slots: tuple[int, int],
    ) -> None:
        """Post what was decided for the stations of some slots.

        Parameters
        ----------
        stations, given
            As for `send_each`.
        box
            Contents, outbox and tally, as for `send_each`.
        slots
            The first, and the end.
        """
        post_each(stations, given, self._asked, self._decided, *box, *slots)


def deciding_of(sender: Sender, stations: SendingStations, rng: np.random.Generator) -> Deciding | None:
    """Return who asks a sender's policy, or None where its rule is compiled.

    Parameters
    ----------
    sender, stations, rng
        As for `Deciding`.
    """
    return Deciding(sender, stations, rng) if stations.policy.rule == RULE_PLAIN else None

"""A policy in NumPy in the station: asked once a step about all that send, between two compiled steps.

What it decides is checked before a station acts on it. Random numbers are of a generator of its own, so that
the same seed gives the same messages, whatever the number of threads.
"""

from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.messages.stack_kernels import airtime, frame_bytes
from modelcast.station.policy.base import Air, Motion, TransmitInputs
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.policy.policy_numbers import RULE_PLAIN
from modelcast.station.policy.state_rows import check_state, put_rows, take_rows
from modelcast.station.sender.deciding_kernels import Asked, Decided, know_each, post_each
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
        self._policy, self._rng, self._power_dbm = sender.policy, rng, sender.power_dbm
        vehicles, members = stations.senders.vehicle.size, stations.models.members.windows.size
        self._name = type(sender.policy).__name__
        self._state: Any = sender.policy.init(vehicles, members)
        check_state(self._state, vehicles, self._name)
        self._members = members
        nobody = np.zeros(vehicles, dtype=np.bool_)
        columns: list[FloatArray] = [np.zeros(vehicles) for _ in range(7)]
        self._asked = Asked(
            nobody,
            nobody.copy(),
            *columns,
            position_m=np.zeros((vehicles, 2)),
            error_m=np.full((vehicles, members), np.inf),
            available=np.zeros((vehicles, members), dtype=np.bool_),
            in_use=np.full(vehicles, -1, dtype=np.int64),
        )
        self._decided = Decided(
            np.zeros(vehicles, dtype=np.int64),
            np.full(vehicles, -1, dtype=np.int64),
            np.full(vehicles, np.inf),
            np.zeros(vehicles),
            np.zeros(vehicles, dtype=np.bool_),
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
        asked, decided = self._asked, self._decided
        know_each(stations, given, tables, asked)
        rows = np.flatnonzero(asked.asks)
        if not rows.size:
            return
        begins = np.flatnonzero(asked.begins)
        if begins.size:
            fresh = self._policy.init(begins.size, self._members)
            self._state = put_rows(self._state, begins, fresh)
        stack = stations.numbers.stack
        longest_s = airtime(frame_bytes(int(stations.models.sizes.max()), True, stack), stack)
        inputs = TransmitInputs(
            asked.ask_s[rows],
            asked.age_s[rows],
            silence_s=asked.silence_s[rows],
            tracking_error_m=asked.error_m[rows],
            available=asked.available[rows],
            in_use=asked.in_use[rows],
            until_s=asked.ask_s[rows] + given.dt_s,
            motion=Motion(
                asked.position_m[rows],
                asked.speed_mps[rows],
                heading_rad=asked.heading_rad[rows],
                critical=given.critical[rows],
            ),
            air=Air(
                given.busy_ratio[rows],
                asked.neighbours[rows],
                packet_error_ratio=asked.error_ratio[rows],
                airtime_s=np.full(rows.size, longest_s),
            ),
        )
        try:
            said, after = self._policy.decide(take_rows(self._state, rows), inputs, self._rng)
            said.check(inputs)
            check_state(after, rows.size, self._name)
        except ValueError as error:
            raise ValueError(f"{self._name}: {error}") from error
        self._state = put_rows(self._state, rows, after)
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

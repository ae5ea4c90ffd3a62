"""Whether a node on a manual clock does what the trip runtime does: the same octets, the same map.

The node takes the trip by the inputs of a node on the road (`TripReplay` and `MotionSource`), sends in its
envelope on the virtual transport, and another node hears it over losses. The trip runtime is what evaluations
are made by; the losses are those that the transport drew.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.channel.erasure import IndependentErasure
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.models.bank import Bank
from modelcast.node.clock import ManualClock
from modelcast.node.envelope import Unsecured
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.node import Node, NodeState
from modelcast.node.recording.record import AbstractRecord
from modelcast.runtime.transport.base import Arrival
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.receiver.ears import Ears
from modelcast.station.sender.sender import Sender
from modelcast.station.station import Station
from modelcast.study.agreement import drive_by_trip, first_difference, replayed_places
from modelcast.study.case import TripCase

__all__ = ["NodeAgreement", "node_agreement", "states_its_motion"]

_ID = 1
_LOSS_RATIO = 0.4
_MOTION = ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")


@dataclass(frozen=True, slots=True)
class NodeAgreement:
    """What a node made of one trip.

    Parameters
    ----------
    messages
        How many the trip runtime sent.
    sent
        First difference of the node's messages from them; empty for none.
    host
        First sample at which another node believes something else than the replay; empty for none.
    judged
        Samples at which that node believed something.
    """

    messages: int
    sent: str
    host: str
    judged: int

    @property
    def agrees(self) -> bool:
        """Whether there is no difference."""
        return not (self.sent or self.host)


def states_its_motion(case: TripCase) -> bool:
    """Whether an evaluation takes the whole motion as the recording states it.

    Where it does not, since a quantity is missing or a speed is stuck, it estimates velocities over a window
    of places, and a node makes them from earlier fixes: the two are not the same.

    Parameters
    ----------
    case
        The trip, made ready.
    """
    return case.estimator.window == 0 and all(getattr(case.seen, name) is not None for name in _MOTION)


def node_agreement(case: TripCase, bank: Bank, policy: ErrorDriven, *, seed: int = 0) -> NodeAgreement:
    """Drive one trip by the trip runtime and by a node, and compare.

    Parameters
    ----------
    case
        The trip, made ready; its 10 Hz are the node's tick.
    bank
        The sender's sub-models.
    policy
        Its rules.
    seed
        Of the losses that the other node meets.

    Raises
    ------
    ValueError
        Where the rules do not go with the bank.
    """
    trip, drive = case.seen, drive_by_trip(case, bank, policy, temporary_id=_ID)
    source, clock, said = TripReplay(trip), ManualClock(float(trip.t_s[0])), _Said()
    motion = MotionSource(source.origin)
    medium = VirtualMedium(IndependentErasure(_LOSS_RATIO), instant_s=trip.dt_s, seed=seed)
    sender = Sender("agreement", policy, bank, jitter_s=0.0)  # it leaves at its sample
    ears = Ears((bank,), np.inf, None, dt_s=trip.dt_s, capacity=4)
    driving, hearing = (
        Node(
            Station(sender, temporary_id=number, dt_s=trip.dt_s, origin=source.origin, ears=ears),
            medium.join(),
            Unsecured(),
            record=said if number == _ID else None,
        )
        for number in (_ID, _ID + 1)
    )
    events: list[tuple[int, bytes]] = []
    lost: BoolArray = np.zeros((1, len(trip)), dtype=np.bool_)
    believed: list[NodeState] = []
    for sample, t_s in enumerate(trip.t_s.tolist()):
        clock.set(t_s)
        motion.feed(source.take(clock.now_s()))
        driving.step(clock.now_s(), motion.at(clock.now_s()))
        before = medium.lost
        driving.send(clock.now_s())
        lost[0, sample] = medium.lost > before
        events += [(sample, octets) for octets in said.taken()]
        hearing.hear(clock.now_s())
        believed.append(hearing.step(clock.now_s(), None))
    places = replayed_places(trip, drive, lost).T
    judged = sum(int(state.around.vehicle.size) for state in believed)
    return NodeAgreement(
        len(drive.events), first_difference(drive.events, events), _host_difference(believed, places), judged
    )


def _host_difference(believed: list[NodeState], places_m: FloatArray) -> str:
    """The first sample at which what a node believes is not what the replay says, in any bit."""
    for sample, (state, wanted) in enumerate(zip(believed, places_m, strict=True)):
        found = state.around.position_m
        if found.shape[0] == 0 and np.isnan(wanted).all():
            continue
        if found.shape != (1, 2) or not np.array_equal(found[0], wanted):
            return f"sample {sample}: {found.tolist()}, not {wanted.tolist()}"
    return ""


class _Said(AbstractRecord):
    """Keeps messages until they are taken."""

    def __init__(self) -> None:
        self._messages: list[bytes] = []

    def taken(self) -> list[bytes]:
        """What was sent since the last call."""
        found, self._messages = self._messages, []
        return found

    def heard(self, now_s: float, arrived: Sequence[Arrival], outcomes: Sequence[str]) -> None:
        """Nothing."""

    def sent(self, now_s: float, message: bytes, frame: bytes) -> None:  # noqa: ARG002
        """Keep the message."""
        self._messages.append(message)

    def stepped(self, state: NodeState) -> None:
        """Nothing."""

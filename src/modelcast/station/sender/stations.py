"""Stations that have measured and sent nothing, as compiled steps take them; one is a batch of one."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.messages.cam_sizes import no_sizes
from modelcast.station.arrays import fits, lanes, sensed
from modelcast.station.policy.believed_loss_kernels import DEPTH
from modelcast.station.policy.hindsight_kernels import LAGS_S
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sender.lane_rules import speaking_lanes
from modelcast.station.sender.message_arrays import FleetNumbers, senders
from modelcast.station.sender.posting_kernels import SendingStations
from modelcast.station.sender.sender import Sender
from modelcast.station.sender.timed_kernels import timers
from modelcast.station.sensing.sensing import Sensing

__all__ = ["guards_of", "sender_bank", "sending_stations", "widest"]


def sender_bank(sender: Sender, dt_s: float) -> SenderBank:
    """Make a sender's bank ready for a sampling interval [s]."""
    return SenderBank.of(
        sender.bank, dt_s, identify=sender.lanes.identify, sizes=sender.sizes, selector=sender.selector
    )


def guards_of(sender: Sender, bank: SenderBank) -> tuple[int, ...]:
    """Return the members that guard a sender; empty for none."""
    return bank.guards if sender.lanes.start == "guarded" else ()


def widest(sender: Sender, bank: SenderBank) -> int:
    """Return the most parameters that a message holds."""
    offsets = bank.bank.offsets
    return int(offsets[-1] if sender.carries_all else np.diff(offsets).max())


def sending_stations(
    sender: Sender,
    bank: SenderBank,
    phase: FloatArray,
    *,
    sensing: Sensing | None = None,
    first_member: int = 0,
) -> SendingStations:
    """Return the arrays of stations that have measured and sent nothing.

    Parameters
    ----------
    sender
        What they send, and by which rule.
    bank
        Its bank.
    phase
        Where in a step each decides, (V,) in [0, 1).
    sensing
        How they read their measurements; None for all columns measured.
    first_member
        Place of the bank's first sub-model among those of all senders that share a channel.
    """
    vehicles, dt_s = phase.size, bank.dt_s
    rule, guards = sender.lanes, guards_of(sender, bank)
    spoken = speaking_lanes(
        [rule] * vehicles,
        range(vehicles),
        guards=guards,
        dt_s=dt_s,
        selector=sender.selector,
        within_m=sender.within_m,
    )
    window = int(bank.bank.windows.max())
    if sender.selector is not None:
        window = max(window, sender.selector.window_at(dt_s))
    scored = rule.start in {"hindsight", "guarded"}
    back = 1 + (max(int(lag_s / dt_s + 0.5) for lag_s in LAGS_S) if scored else 0)
    own = Sensing(motion=sender.motion) if sensing is None else sensing
    members, parameters = len(bank.bank.members), int(bank.bank.offsets[-1])
    return SendingStations(
        models=bank.models(guards),
        sensed=sensed(vehicles, max(window + back, own.memory(dt_s)), bank.ready.sample_columns),
        fits=fits(vehicles, back, members=members, parameters=parameters),
        rules=spoken.rules,
        lanes=lanes(
            spoken.rules.vehicle.size,
            members=members,
            parameters=parameters,
            older=DEPTH - 1 if rule.expects else 0,
        ),
        policy=sender.policy.numbers,
        timers=timers(phase),
        senders=senders(phase),
        numbers=FleetNumbers(
            stack=sender.stack.numbers,
            identification_bytes=sender.sizes.identification_bytes,
            carries_all=sender.carries_all,
            first_member=first_member,
            plain=np.array(sender.plain, dtype=np.bool_),
            power_dbm=sender.power_dbm,
            jitter_s=sender.jitter_s,
            grant=int(sender.grant),
            frames=no_sizes() if sender.frames is None else sender.frames.numbers,
        ),
    )

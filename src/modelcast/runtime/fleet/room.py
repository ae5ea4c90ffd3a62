"""What a fleet's loop is made of at its beginning: groups of speakers, and room for what hosts hold."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.chance import child_generator
from modelcast.runtime.fleet import tracking_kernels
from modelcast.runtime.fleet.people import Devices
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.fleet.speakers import Speakers
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.sender.sender import Sender
from modelcast.station.sensing.sensing import Sensing
from modelcast.world.scenario.base import FleetFrame

__all__ = ["capacity_of", "speakers_of", "sub_intervals_of"]

_SPARE_SLOTS = 64


def speakers_of(
    senders: Sequence[Sender],
    settings: NetworkSettings,
    phase: FloatArray,
    *,
    parts: list[tuple[int, int]],
    groups: int,
    sensing: Sensing | None,
    seed: int,
) -> list[Speakers]:
    """One group a sender; what stations hold of their messages is that of their slots, whoever is there.

    Parameters
    ----------
    senders
        One or more.
    settings, phase, parts, groups, sensing
        As for `Speakers`.
    seed
        Of policies in NumPy.
    """
    found: list[Speakers] = []
    first = 0
    for sender in senders:
        shared = found[0].stations.senders if found else None
        found.append(
            Speakers(
                sender, settings, phase,
                parts=parts, groups=groups, sensing=sensing, first_member=first, shared=shared,
                rng=child_generator(seed, "policy", len(found)),
            )
        )  # fmt: skip
        first += len(found[-1].bank.bank.members)
    return found


def sub_intervals_of(sender: Sender) -> int:
    """Sub-intervals that the sender's rule counts packet errors over."""
    rule = sender.policy
    return (rule.parameters if isinstance(rule, J2945) else J2945Parameters()).sub_intervals


def capacity_of(first: FleetFrame, settings: NetworkSettings, devices: Devices | None) -> int:
    """Slots of a host: half as many again as the fullest has in reach at first, and some.

    Where slots are empty at first, as in traffic that comes and goes, as many more as if all were taken.

    Parameters
    ----------
    first
        The first frame.
    settings
        How far hosts reach.
    devices
        Of people, who reach less far; None for none.
    """
    place = np.where(first.active[:, None], first.position_m, np.nan)
    near = tracking_kernels.most_in_reach(place, settings.reach_m)
    if devices is not None:
        near = min(near, devices.most_in_reach(first))
    most = near * len(first) / max(first.active.sum(), 1)
    return int(min(len(first) + _SPARE_SLOTS, int(1.5 * most) + _SPARE_SLOTS, 2**15 - 1))

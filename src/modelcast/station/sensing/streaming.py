"""State that sub-models carry from sample to sample: what a station senses, and what they make of it.

A bank whose members need no more than their windows costs nothing here.
"""

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.models.member_kernels import Members
from modelcast.models.members import ReadyBank
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.station.arrays import Sensed
from modelcast.station.sensing.streaming_kernels import observe_each

__all__ = ["observe_newest", "with_states"]


def observe_newest(members: Members, sensed: Sensed, vehicle: IntArray) -> None:
    """Let members observe the newest sample of vehicles, just taken in; it is written into ``sensed``.

    Parameters
    ----------
    members
        Of the bank that ``sensed`` was made for.
    sensed
        What all vehicles hold.
    vehicle
        Whose, (K,).
    """
    if sensed.samples.shape[2] > SAMPLE_COLUMNS:
        observe_each(members, sensed, vehicle, sensed.taken[vehicle] - 1)


def with_states(sensed: Sensed, ready: ReadyBank) -> Sensed:
    """What one vehicle sensed over a whole trip, with the state of a bank's members at every sample.

    Parameters
    ----------
    sensed
        Of one vehicle, in a ring that holds all its samples; it stays as it is.
    ready
        The bank.

    Raises
    ------
    ValueError
        Where the ring holds the newest samples only.
    """
    if ready.sample_columns == SAMPLE_COLUMNS:
        return sensed
    if sensed.taken.max(initial=0) > sensed.stated_m.shape[1]:
        raise ValueError("states are carried from the first sample on, and the ring holds it no longer")
    samples = np.zeros((*sensed.samples.shape[:2], ready.sample_columns))
    samples[..., :SAMPLE_COLUMNS] = sensed.samples[..., :SAMPLE_COLUMNS]
    held = sensed._replace(samples=samples)
    vehicle = np.arange(len(samples), dtype=np.int64)
    observe_each(ready.members, held, vehicle, np.zeros_like(vehicle))
    return held

"""State that sub-models carry from sample to sample: what a station senses, and what they make of it.

A bank whose members need no more than their windows costs nothing here.
"""

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.context_columns import CONTEXT_COLUMNS
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
    if (members.streams[:, -1] > 0).any():
        observe_each(members, sensed, vehicle, sensed.taken[vehicle] - 1)


def with_states(sensed: Sensed, ready: ReadyBank, context: FloatArray | None = None) -> Sensed:
    """What one vehicle sensed over a whole trip, with its context and the state of a bank's members.

    Parameters
    ----------
    sensed
        Of one vehicle, in a ring that holds all its samples; it stays as it is.
    ready
        The bank.
    context
        The vehicle ahead and the road at every sample (`modelcast.models.context_columns`), (T, 13), for a
        bank that reads them; None where nothing is known.

    Raises
    ------
    ValueError
        Where the ring holds the newest samples only, or there is not one row of context a sample.
    """
    if ready.sample_columns == SAMPLE_COLUMNS:
        return sensed
    if sensed.taken.max(initial=0) > sensed.stated_m.shape[1]:
        raise ValueError("states are carried from the first sample on, and the ring holds it no longer")
    samples = np.zeros((*sensed.samples.shape[:2], ready.sample_columns))
    samples[..., :SAMPLE_COLUMNS] = sensed.samples[..., :SAMPLE_COLUMNS]
    if context is not None and ready.reads_context:
        _lay_context(samples, sensed, context)
    held = sensed._replace(samples=samples)
    vehicle = np.arange(len(samples), dtype=np.int64)
    observe_each(ready.members, held, vehicle, np.zeros_like(vehicle))
    return held


def _lay_context(samples: FloatArray, sensed: Sensed, context: FloatArray) -> None:
    """Write the context of a trip behind what one vehicle measured, in both places of every sample."""
    count, ring = int(sensed.taken[0]), sensed.stated_m.shape[1]
    if context.shape != (count, CONTEXT_COLUMNS):
        raise ValueError(f"context must be ({count}, {CONTEXT_COLUMNS}), got {context.shape}")
    if not np.isfinite(context).all():
        raise ValueError("context must be finite: what is not known is zero")
    columns = slice(SAMPLE_COLUMNS, SAMPLE_COLUMNS + CONTEXT_COLUMNS)
    samples[0, :count, columns] = samples[0, ring : ring + count, columns] = context

"""A trip as a receiver that reads at a lower rate would have had it: nothing of it comes from later samples.

That holds of the trip's samples. Those of an uneven recording are interpolated when it is read
(`modelcast.trips.trajectory.build_trajectory`), each from a row before and a row behind it: there a sample
may know of a row up to a recorded step later, and all of the recording tells whether it counts as uneven.

The receiver reads once a step, a sixteenth of a step after the instant it reads for, so that a clock that
jitters by less makes no difference. It takes the last sample recorded at or before its reading, as it is: a
position that is some milliseconds old stays where it was measured. Where no new sample has come by a reading,
the one before is held, once, unless it is older than `HOLD_STEPS`; then the trip has a gap.

Interpolation would use the sample behind an instant, which no receiver has; and drawing the last one forward
would be a model of motion, which is what is to be judged.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.trajectory import Trajectory

__all__ = ["HOLD_STEPS", "READ_DELAY_STEPS", "at_rate"]

READ_DELAY_STEPS = 1.0 / 16.0
"""How long after an instant it is read, in steps of the rate asked for."""

HOLD_STEPS = 1.25
"""Oldest sample that is held for want of a new one, in steps; also the slowest recording that is taken."""

_SAME_S = 1e-9
"""Times that differ by less are the same: decimal fractions have no exact float64."""


def at_rate(trip: Trajectory, rate_hz: float) -> Trajectory:
    """Return the trip as read at a rate, each sample the last one recorded at or before its reading.

    Parameters
    ----------
    trip
        A recorded trip.
    rate_hz
        Readings a second [Hz].

    Returns
    -------
    Trajectory
        With steps of exactly ``1 / rate_hz``, split wherever a reading is missing. Absolute times are those
        of the readings. `Reading.repaired` counts the samples taken, those over half a step old and those
        held, and those that the reader of an uneven recording had interpolated, which looks a step ahead.

    Raises
    ------
    ValueError
        Where the rate is none, or the trip was recorded more slowly.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = 0.1 * np.arange(21)
    >>> slow = at_rate(build_trajectory("made/1", t, np.stack([10 * t, 0 * t], axis=1)), 4.0)
    >>> slow.dt_s, slow.position_m[:5, 0].round(6).tolist()
    (0.25, [0.0, 2.0, 5.0, 7.0, 10.0])
    """
    if not (rate_hz > 0.0 and np.isfinite(rate_hz)):
        raise ValueError(f"a rate must be positive and finite, got {rate_hz} Hz")
    step_s = 1.0 / rate_hz
    if trip.dt_s > HOLD_STEPS * step_s:
        raise ValueError(f"recorded at {1.0 / trip.dt_s:.3g} Hz, slower than the rate of {rate_hz:g} Hz")
    delay_s = READ_DELAY_STEPS * step_s
    # The reading by which each sample has come; of several that come by one, the last is taken.
    seen_by = np.ceil((trip.t_s - delay_s - _SAME_S) / step_s).astype(np.int64)
    taken = np.append(np.diff(seen_by) > 0, True)
    # What is read for an instant behind the end would be held for want of a recording.
    taken &= seen_by * step_s <= trip.t_s[-1] + delay_s + _SAME_S
    source, reading = np.flatnonzero(taken), seen_by[taken]
    late = np.append(np.diff(reading) > 1, False)
    late &= (reading + 1) * step_s + delay_s - trip.t_s[source] <= HOLD_STEPS * step_s + _SAME_S
    source = np.concatenate([source, source[late]])
    reading = np.concatenate([reading, reading[late] + 1])
    order = np.argsort(reading, kind="stable")
    source, reading = source[order], reading[order]
    part = np.searchsorted(trip.segments, source, side="right")
    bounds = np.flatnonzero((np.diff(part) > 0) | (np.diff(reading) > 1)) + 1
    columns: dict[str, Any] = {name: column[source] for name, column in trip.columns().items()}
    columns["t_s"] = reading * step_s
    columns["segments"] = np.concatenate([[0], bounds, [source.size]]).astype(np.int64)
    age_s = reading * step_s + delay_s - trip.t_s[source]
    told = _told(trip, rate_hz, age_s, late)
    return replace(
        trip,
        **columns,
        dt_s=step_s,
        start_unix_s=None if trip.start_unix_s is None else trip.start_unix_s + delay_s,
        clock_s=None if trip.clock_s is None else trip.clock_s + delay_s,
        reading=replace(trip.reading, repaired={**trip.reading.repaired, **told}),
    )


def _told(trip: Trajectory, rate_hz: float, age_s: FloatArray, late: np.ndarray[Any, Any]) -> dict[str, int]:
    """Return what is to be counted of the samples taken."""
    found = {
        f"taken at {rate_hz:g} Hz": int(age_s.size),
        f"over half a step old at {rate_hz:g} Hz": int((age_s > 0.5 / rate_hz).sum()),
        f"held at {rate_hz:g} Hz": int(late.sum()),
        "interpolated before, with samples ahead": int(age_s.size) if trip.resampled else 0,
    }
    return {reason: count for reason, count in found.items() if count}

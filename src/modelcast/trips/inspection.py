"""What a recording is worth as ground truth, measured from its values alone.

A log can look like 10 Hz and hold much less: positions on a coarse grid, speeds held for a second, positions
that the unit only extrapolated between two fixes. `inspect` finds these. What the drive contains is counted
by `modelcast.trips.manoeuvres`.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.jumps import jumps_between
from modelcast.trips.recorder import (
    WINDOW_S,
    change_rate_hz,
    coasted_ratio,
    grid_step_m,
    held_s,
    noise_span_s,
    position_rate_hz,
    quadratic_residual_m,
    velocity_over,
)
from modelcast.trips.straight_lines import straight_lines
from modelcast.trips.trajectory import Reading, Trajectory

__all__ = [
    "MAX_CLEAN_GRID_M",
    "STOP_SPEED_MPS",
    "TripInspection",
    "inspect",
]

MAX_CLEAN_GRID_M = 0.05
"""Coarsest grid taken as truth: its error (grid / sqrt 12 an axis) is a tenth of a 20 cm threshold."""

STOP_SPEED_MPS = 0.5
"""Under this a car counts as stopped: GNSS noise and a coarse grid alone make a few decimetres a second."""

MAX_SPEED_MISMATCH_RATIO = 0.2
"""A speed column off by more than this against the positions, on the whole, is stuck or of another unit."""

_MIN_MOVING_ROWS = 10


@dataclass(frozen=True, slots=True)
class TripInspection:
    """What `inspect` found in one trip.

    Parameters
    ----------
    trip_id
        The trip's name.
    duration_s
        Time observed, gaps left out [s].
    samples
        Number of samples.
    rate_hz
        Samples a second, from the median step [Hz].
    gaps, longest_gap_s
        Number of gaps, and the longest [s] (0 where there is none).
    jumps, largest_jump_m
        Places where the trip was split because no vehicle goes on like that, and the largest distance from
        where it would have gone on to [m] (0 where there is none).
    resampled
        True where the reader interpolated uneven steps.
    moving_s
        Time in motion, over twice `STOP_SPEED_MPS` by the positions [s].
    position_rate_hz
        How often the position really takes a new value while the vehicle moves [Hz]; NaN where it never does.
    grid_axis_m
        Step of the position grid east and north [m], 0 where none shows.
    speed_rate_hz, heading_rate_hz
        How often the column really takes a new value while the vehicle moves [Hz]; None without the column,
        NaN where the vehicle never moves.
    held_s
        Median time a value of a held column lasts [s], 0 where values are fresh at every sample.
    coasted_ratio
        Where values are held: 1 where positions between two of their changes were extrapolated from the
        held velocity, 0 where they were measured; NaN where the drive cannot tell.
    fix_period_s
        Time between slow fixes that straight lines join [s]; NaN where every sample was measured.
    straight_ratio, corner_ratio, curvature_ratio
        What tells so, as in `modelcast.trips.straight_lines.StraightLines`.
    noise_p50_m, noise_p95_m
        Median and 95th percentile over windows of ``noise_span_s`` of the root mean square residual of a
        quadratic fit [m]; NaN where no part is as long.
    noise_span_s
        1 s, or four steps where these are longer: then the residual holds the motion too [s].
    speed_ratio, speed_difference_mps
        Speed column against differenced positions over 1 s: ratio of the distances, and root mean square
        difference [m/s]; NaN without the column or without motion.
    speed_is_stuck
        True where the two disagree by more than `MAX_SPEED_MISMATCH_RATIO`, or the column stays constant
        while the positions say otherwise.
    reading
        What the reader skipped and repaired, and what it took the file for.
    source
        The format it was read as.
    """

    trip_id: str
    duration_s: float
    _: KW_ONLY
    samples: int
    rate_hz: float
    gaps: int
    longest_gap_s: float
    jumps: int
    largest_jump_m: float
    resampled: bool
    moving_s: float
    position_rate_hz: float
    grid_axis_m: tuple[float, float]
    speed_rate_hz: float | None
    heading_rate_hz: float | None
    held_s: float
    coasted_ratio: float
    fix_period_s: float
    straight_ratio: float
    corner_ratio: float
    curvature_ratio: float
    noise_p50_m: float
    noise_p95_m: float
    noise_span_s: float
    speed_ratio: float
    speed_difference_mps: float
    speed_is_stuck: bool
    reading: Reading
    source: str = ""

    @property
    def grid_m(self) -> float:
        """The coarser axis of the position grid, 0 where none shows [m]."""
        return max(self.grid_axis_m)

    @property
    def values_held(self) -> bool:
        """Whether speed (or heading, without a speed) keeps each value for several samples."""
        return self.held_s > 0.0

    @property
    def is_coasted(self) -> bool:
        """Whether positions between two fixes are the recorder's own extrapolation."""
        return self.coasted_ratio > 0.5

    @property
    def is_joined(self) -> bool:
        """Whether straight lines join slow fixes."""
        return bool(np.isfinite(self.fix_period_s))

    @property
    def is_clean(self) -> bool:
        """Whether the recorded positions can serve as truth as they are."""
        return self.grid_m <= MAX_CLEAN_GRID_M and not self.values_held

    @property
    def recommended_protocol(self) -> Literal["recorded", "sensor"]:
        """Judge against the recording, or against conditioned truth with inputs from a sensor model."""
        return "recorded" if self.is_clean else "sensor"


def inspect(trip: Trajectory) -> TripInspection:
    """Quality of a trip, from its values alone.

    Parameters
    ----------
    trip
        As the reader returned it.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> path = np.stack([10.0 * t, 0.02 * t**2], axis=1)
    >>> inspect(build_trajectory("made/exact", t, path)).recommended_protocol
    'recorded'
    >>> found = inspect(build_trajectory("made/grid", t, np.round(path / 0.3) * 0.3))
    >>> round(found.grid_m, 3), found.recommended_protocol
    (0.3, 'sensor')
    """
    noise = quadratic_residual_m(trip)
    velocity = velocity_over(trip, WINDOW_S)
    by_position = np.hypot(velocity[:, 0], velocity[:, 1])
    ratio, difference, stuck = _speed_agreement(trip, by_position)
    lasting_s = held_s(trip)
    _, jumps_m = jumps_between(trip.t_s, trip.position_m, trip.segments)
    lines = straight_lines(trip)
    return TripInspection(
        trip.trip_id,
        trip.duration_s,
        samples=len(trip),
        rate_hz=1.0 / trip.dt_s,
        gaps=int(trip.gaps_s.size),
        longest_gap_s=float(trip.gaps_s.max(initial=0.0)),
        jumps=int(jumps_m.size),
        largest_jump_m=float(jumps_m.max(initial=0.0)),
        resampled=trip.resampled,
        moving_s=float((by_position > 2.0 * STOP_SPEED_MPS).sum() * trip.dt_s),
        position_rate_hz=position_rate_hz(trip),
        grid_axis_m=grid_step_m(trip, noise),
        speed_rate_hz=change_rate_hz(trip, trip.speed_mps),
        heading_rate_hz=change_rate_hz(trip, trip.heading_rad),
        held_s=lasting_s,
        coasted_ratio=coasted_ratio(trip, lasting_s) if lasting_s > 0.0 and not stuck else float("nan"),
        fix_period_s=lines.period_s,
        straight_ratio=lines.straight_ratio,
        corner_ratio=lines.corner_ratio,
        curvature_ratio=lines.curvature_ratio,
        noise_p50_m=float(np.percentile(noise, 50)) if noise.size else float("nan"),
        noise_p95_m=float(np.percentile(noise, 95)) if noise.size else float("nan"),
        noise_span_s=noise_span_s(trip),
        speed_ratio=ratio,
        speed_difference_mps=difference,
        speed_is_stuck=stuck,
        reading=trip.reading,
        source=trip.source,
    )


def _speed_agreement(trip: Trajectory, by_position_mps: FloatArray) -> tuple[float, float, bool]:
    """Ratio and root mean square difference of speed column and positions, and whether it is stuck."""
    moving = by_position_mps > 2.0 * STOP_SPEED_MPS
    if trip.speed_mps is None or moving.sum() < _MIN_MOVING_ROWS:
        return float("nan"), float("nan"), False
    column, other = trip.speed_mps[moving], by_position_mps[moving]
    ratio = float(column.sum() / other.sum())
    difference = float(np.sqrt(((column - other) ** 2).mean()))
    constant = float(np.ptp(column)) == 0.0 and float(np.ptp(other)) > 2.0 * STOP_SPEED_MPS
    wrong = abs(ratio - 1.0) > MAX_SPEED_MISMATCH_RATIO
    return ratio, difference, bool(wrong or (constant and difference > STOP_SPEED_MPS))

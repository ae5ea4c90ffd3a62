"""One vehicle's recorded trip, in one frozen value.

A `Trajectory` is made by `build_trajectory`, which decides once whether the recording counts as uniform,
resamples it where it does not, splits it at gaps and jumps, and leaves out rows where no vehicle could have
been. Everything downstream may rely on what it checked.
"""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field, fields, replace

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.trips.heading_unit import degrees_at
from modelcast.trips.jumps import settle
from modelcast.trips.understood import Understood

__all__ = [
    "GAP_STEPS",
    "JUMPED",
    "OFF_EARTH",
    "UNIFORM_TOLERANCE_RATIO",
    "Reading",
    "Trajectory",
    "build_trajectory",
]

UNIFORM_TOLERANCE_RATIO = 0.25
"""A trip counts as uniform where every step lies within this share of the median step."""

GAP_STEPS = 2.5
"""A step longer than this many median steps is a gap: the trip is split there."""

JUMPED = "position jump and back"
"""Why rows are skipped that lie where no vehicle could have been."""

OFF_EARTH = "no place on Earth"
"""Why rows are skipped that lie farther off than the Earth is large."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What happened while a trip was read: nothing is dropped without being counted here.

    Every row is a sample or skipped for one reason: ``rows == samples + sum(skipped.values())``. What is
    repaired stays a sample (or is skipped later, for a reason of its own) and is counted beside.

    Parameters
    ----------
    rows
        Rows (or records) that the file held for this vehicle.
    skipped
        Rows left out, by reason.
    repaired
        Rows put right, by reason.
    understood
        What the reader took the file for, where it had to find that out; not part of what is compared.
    """

    rows: int = 0
    skipped: Mapping[str, int] = field(default_factory=dict[str, int])
    repaired: Mapping[str, int] = field(default_factory=dict[str, int])
    understood: Understood | None = field(default=None, repr=False, compare=False)

    @property
    def samples(self) -> int:
        """Rows that became samples, before any resampling."""
        return self.rows - sum(self.skipped.values())


@dataclass(frozen=True, slots=True)
class Trajectory:
    """One vehicle's recorded trip on a local east-north plane, with strictly increasing times.

    Parameters
    ----------
    trip_id
        ``<file stem>/<vehicle>``.
    t_s
        Times from the start of the trace, (T,) [s], strictly increasing.
    position_m
        East and north, (T, 2) [m].
    segments
        Bounds of the gapless parts, (S + 1,): part k is ``segments[k] : segments[k + 1]``.
    dt_s
        The median step [s]: what windows take as their sampling interval.
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps, up_m
        Optional columns, (T,). Heading is clockwise from true north, yaw rate clockwise too, acceleration
        along the vehicle.
    origin
        The point the local frame touches, where the log was geodetic.
    start_unix_s
        Absolute time of ``t_s = 0`` where the log gives it [s].
    clock_s
        The same on the clock that all trips of its file were recorded by, whatever that counts from [s];
        None where it is not known that there is such a clock.
    source
        Name of the format it came from.
    vehicle
        Name of the vehicle where the format names the same vehicle in several trips; empty where it does not.
    resampled
        True where the recorded steps were too uneven and the samples were interpolated to ``dt_s``.
    reading
        Counts of rows read, skipped and repaired.

    Raises
    ------
    ValueError
        Where shapes differ, a value is not finite, or time does not increase.
    """

    trip_id: str
    t_s: FloatArray
    position_m: FloatArray
    _: KW_ONLY
    segments: IntArray
    dt_s: float
    speed_mps: FloatArray | None = None
    heading_rad: FloatArray | None = None
    acceleration_mps2: FloatArray | None = None
    yaw_rate_radps: FloatArray | None = None
    up_m: FloatArray | None = None
    origin: Origin | None = None
    start_unix_s: float | None = None
    clock_s: float | None = None
    source: str = ""
    vehicle: str = ""
    resampled: bool = False
    reading: Reading = field(default_factory=Reading)

    def __post_init__(self) -> None:
        count = self.t_s.size
        if self.t_s.ndim != 1 or count == 0:
            raise ValueError(f"{self.trip_id}: t_s must be (T,) with T >= 1, got shape {self.t_s.shape}")
        if self.position_m.shape != (count, 2):
            raise ValueError(f"{self.trip_id}: position_m must be ({count}, 2), got {self.position_m.shape}")
        for name, column in self.columns().items():
            if column.shape[0] != count:
                raise ValueError(f"{self.trip_id}: {name} has {column.shape[0]} samples, t_s has {count}")
            finite = np.isfinite(column)
            if not finite.all():
                at = int(np.argmin(finite.reshape(count, -1).all(axis=1)))
                raise ValueError(f"{self.trip_id}: {name} is not finite at sample {at}: {column[at]}")
        late = self.t_s[1:] <= self.t_s[:-1]
        if late.any():
            at = int(np.argmax(late)) + 1
            raise ValueError(
                f"{self.trip_id}: time does not increase at sample {at}: "
                f"{self.t_s[at]} after {self.t_s[at - 1]}"
            )
        if not (self.dt_s > 0 and np.isfinite(self.dt_s)):
            raise ValueError(f"{self.trip_id}: dt_s must be positive and finite, got {self.dt_s}")
        bounds = self.segments
        if bounds[0] != 0 or bounds[-1] != count or (np.diff(bounds) <= 0).any():
            raise ValueError(f"{self.trip_id}: segments must rise from 0 to {count}, got {bounds}")

    @property
    def gaps_s(self) -> FloatArray:
        """Time between parts where more than `GAP_STEPS` median steps are missing, (G,) [s]."""
        between = self.t_s[self.segments[1:-1]] - self.t_s[self.segments[1:-1] - 1]
        return between[between > GAP_STEPS * self.dt_s]

    def columns(self) -> dict[str, FloatArray]:
        """Return the sampled columns that are present, by name."""
        found: dict[str, FloatArray] = {}
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name != "segments" and isinstance(value, np.ndarray):
                found[item.name] = value
        return found

    def __len__(self) -> int:
        return int(self.t_s.size)

    @property
    def duration_s(self) -> float:
        """Time observed, gaps left out; each sample stands for the step that follows it [s]."""
        starts, ends = self.segments[:-1], self.segments[1:] - 1
        return float((self.t_s[ends] - self.t_s[starts]).sum() + self.dt_s * starts.size)

    @property
    def segment_start(self) -> IntArray:
        """Index of the first sample of the part each sample lies in, (T,)."""
        return np.repeat(self.segments[:-1], np.diff(self.segments))

    def moved(self, rotation_rad: float, offset_m: tuple[float, float]) -> "Trajectory":
        """Return the same trip in a frame rotated anticlockwise and then shifted.

        Parameters
        ----------
        rotation_rad
            Anticlockwise rotation of every position about the origin [rad].
        offset_m
            East and north shift applied afterwards [m].
        """
        cosine, sine = np.cos(rotation_rad), np.sin(rotation_rad)
        rotation = np.array([[cosine, sine], [-sine, cosine]])
        heading = self.heading_rad
        return replace(
            self,
            position_m=self.position_m @ rotation + np.asarray(offset_m),
            heading_rad=None if heading is None else wrap_angle_rad(heading - rotation_rad),
            origin=None,
        )


def build_trajectory(
    trip_id: str,
    t_s: npt.ArrayLike,
    position_m: npt.ArrayLike,
    *,
    speed_mps: npt.ArrayLike | None = None,
    heading_rad: npt.ArrayLike | None = None,
    acceleration_mps2: npt.ArrayLike | None = None,
    yaw_rate_radps: npt.ArrayLike | None = None,
    up_m: npt.ArrayLike | None = None,
    origin: Origin | None = None,
    start_unix_s: float | None = None,
    clock_s: float | None = None,
    source: str = "",
    vehicle: str = "",
    reading: Reading | None = None,
    piece: npt.ArrayLike | None = None,
) -> Trajectory:
    """Return the trip of these samples, split at gaps and resampled where its steps are too uneven.

    A trip counts as uniform where all steps inside its parts lie within `UNIFORM_TOLERANCE_RATIO` of the
    median step, and then keeps its own times. Otherwise each part is interpolated linearly to the median
    step. Steps over `GAP_STEPS` median steps split it, and so does a jump that no vehicle makes; rows that
    leave and come back are skipped and counted (`modelcast.trips.jumps`).

    Parameters
    ----------
    trip_id, t_s, position_m, speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps, up_m
        As in `Trajectory`; times may start anywhere and are shifted to start at 0.
    origin, start_unix_s, clock_s, source, vehicle, reading
        As in `Trajectory`.
    piece
        Numbers of the pieces that the log itself tells apart, (T,): where it changes, a part begins.

    Raises
    ------
    ValueError
        Where the samples break a rule that `Trajectory` states, most steps are faster than any vehicle, or
        headings are degrees (`modelcast.trips.heading_unit`).

    Examples
    --------
    >>> import numpy as np
    >>> t = np.array([0.0, 0.1, 0.2, 1.2, 1.3])
    >>> trip = build_trajectory("made/1", t, np.stack([10 * t, 0 * t], axis=1))
    >>> trip.segments.tolist(), round(trip.dt_s, 6), round(trip.duration_s, 6)
    ([0, 3, 5], 0.1, 0.5)
    """
    times = _owned(t_s)
    if times.size and np.isfinite(times).all():
        times = times - times[0]
    trip = Trajectory(
        trip_id,
        times,
        _owned(position_m),
        segments=np.array([0, times.size]),
        dt_s=_median_step_s(times),
        speed_mps=None if speed_mps is None else _owned(speed_mps),
        heading_rad=None if heading_rad is None else _owned(heading_rad),
        acceleration_mps2=None if acceleration_mps2 is None else _owned(acceleration_mps2),
        yaw_rate_radps=None if yaw_rate_radps is None else _owned(yaw_rate_radps),
        up_m=None if up_m is None else _owned(up_m),
        origin=origin,
        start_unix_s=start_unix_s,
        clock_s=clock_s,
        source=source,
        vehicle=vehicle,
        reading=reading if reading is not None else Reading(rows=int(times.size)),
    )
    at = None if trip.heading_rad is None else degrees_at(trip.heading_rad, trip.position_m)
    if at is not None and trip.heading_rad is not None:
        raise ValueError(
            f"{trip_id}: heading_rad is {trip.heading_rad[at]:g} at sample {at}, too large for radians: "
            "numpy.radians makes them of degrees"
        )
    trip = _split(trip, np.zeros(times.size) if piece is None else _owned(piece))
    steps = np.diff(trip.t_s)
    steps[trip.segments[1:-1] - 1] = trip.dt_s
    uneven = np.abs(steps - trip.dt_s) > UNIFORM_TOLERANCE_RATIO * trip.dt_s
    return _resampled(trip) if uneven.any() else trip


def _median_step_s(t_s: FloatArray) -> float:
    steps = np.diff(t_s)
    return float(np.median(steps)) if steps.size else 1.0


def _split(trip: Trajectory, piece: FloatArray) -> Trajectory:
    """Return the trip without glitches, split at gaps, jumps and pieces; its times start at 0 again."""
    try:
        settled = settle(trip.t_s, trip.position_m)
    except ValueError as error:
        raise ValueError(f"{trip.trip_id}: {error}") from error
    jumped = np.zeros(len(trip), dtype=np.bool_)
    jumped[settled.split] = True
    if not settled.kept.all():
        trip, jumped = _taken(trip, settled.kept, settled.off_earth), jumped[settled.kept]
        piece = piece[settled.kept]
    parted = jumped[1:] | (np.diff(piece) != 0)
    breaks = np.flatnonzero((np.diff(trip.t_s) > GAP_STEPS * trip.dt_s) | parted) + 1
    return replace(trip, segments=np.concatenate([[0], breaks, [len(trip)]]).astype(np.int64))


def _taken(trip: Trajectory, kept: BoolArray, off_earth: BoolArray) -> Trajectory:
    """Return the trip with the rows that are kept, the others counted as skipped."""
    skipped = dict(trip.reading.skipped)
    for reason, count in ((OFF_EARTH, off_earth.sum()), (JUMPED, (~kept & ~off_earth).sum())):
        if count:
            skipped[reason] = skipped.get(reason, 0) + int(count)
    first_s = float(trip.t_s[np.argmax(kept)])
    t_s = trip.t_s[kept] - first_s
    columns = {name: np.ascontiguousarray(column[kept]) for name, column in trip.columns().items()}
    return replace(
        trip,
        **{**columns, "t_s": t_s, "segments": np.array([0, t_s.size])},
        dt_s=_median_step_s(t_s),
        start_unix_s=None if trip.start_unix_s is None else trip.start_unix_s + first_s,
        clock_s=None if trip.clock_s is None else trip.clock_s + first_s,
        reading=replace(trip.reading, skipped=skipped),
    )


def _resampled(trip: Trajectory) -> Trajectory:
    """Return the trip with every part interpolated linearly to its median step."""
    times: list[FloatArray] = []
    bounds = [0]
    for first, last in zip(trip.segments[:-1], trip.segments[1:] - 1, strict=True):
        count = int(np.floor((trip.t_s[last] - trip.t_s[first]) / trip.dt_s + 1e-9)) + 1
        times.append(trip.t_s[first] + trip.dt_s * np.arange(count))
        bounds.append(bounds[-1] + count)
    t_s = np.concatenate(times)

    def at(column: FloatArray) -> FloatArray:
        return np.interp(t_s, trip.t_s, column)

    heading = trip.heading_rad
    return Trajectory(
        trip.trip_id,
        t_s,
        np.stack([at(trip.position_m[:, 0]), at(trip.position_m[:, 1])], axis=1),
        segments=np.asarray(bounds, dtype=np.int64),
        dt_s=trip.dt_s,
        speed_mps=_optional(at, trip.speed_mps),
        heading_rad=None if heading is None else wrap_angle_rad(at(np.unwrap(heading))),
        acceleration_mps2=_optional(at, trip.acceleration_mps2),
        yaw_rate_radps=_optional(at, trip.yaw_rate_radps),
        up_m=_optional(at, trip.up_m),
        origin=trip.origin,
        start_unix_s=trip.start_unix_s,
        clock_s=trip.clock_s,
        source=trip.source,
        vehicle=trip.vehicle,
        resampled=True,
        reading=trip.reading,
    )


def _owned(column: npt.ArrayLike) -> FloatArray:
    return np.ascontiguousarray(column, dtype=np.float64)


def _optional(at: Callable[[FloatArray], FloatArray], column: FloatArray | None) -> FloatArray | None:
    return None if column is None else at(column)

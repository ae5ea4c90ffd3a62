"""The stretch of a trip that the timeline and the map draw."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import MessageKind
from modelcast.study.case import TripCase
from modelcast.study.result import Manoeuvre, Timeline
from modelcast.trips.trajectory import Trajectory

__all__ = ["STRETCH_S", "Sharpest", "draw_manoeuvre", "draw_timeline", "sharpest_instant"]

STRETCH_S = 30.0
_HORIZON_S = 4.0
_LEAD_S = 0.5
_SPAN_S = 1.0
_LEAST_CHORD_M = 1.0


@dataclass(frozen=True, slots=True)
class Sharpest:
    """An instant of a trip, and how sharply the vehicle manoeuvres there.

    Parameters
    ----------
    index
        Sample.
    acceleration_mps2
        Size of the acceleration across the course over about two seconds [m/s²].
    """

    index: int
    acceleration_mps2: float


def sharpest_instant(truth: Trajectory) -> Sharpest | None:
    """The sample about which the course bends most; None where no part is long enough.

    Parameters
    ----------
    truth
        The true trip.
    """
    span = max(1, round(_SPAN_S / truth.dt_s))
    best: Sharpest | None = None
    for first, end in zip(truth.segments[:-1], truth.segments[1:], strict=True):
        if end - first < 6 * span:
            continue
        position = truth.position_m[first:end]
        bend = position[2 * span :] - 2.0 * position[span:-span] + position[: -2 * span]
        chord = position[2 * span :] - position[: -2 * span]
        length = np.maximum(np.hypot(chord[:, 0], chord[:, 1]), _LEAST_CHORD_M)
        # Across the course only: a receiver that repeats a position jumps along it.
        across = np.abs(chord[:, 0] * bend[:, 1] - chord[:, 1] * bend[:, 0]) / length
        size = across / (span * truth.dt_s) ** 2
        # Keep room for a full window before and a horizon after.
        usable = size[span : -2 * span]
        at = int(np.argmax(usable))
        if best is None or usable[at] > best.acceleration_mps2:
            best = Sharpest(int(first) + at + 2 * span, float(usable[at]))
    return best


def draw_timeline(case: TripCase, mbc: TripRuntime, walk: TripMessages, index: int) -> Timeline:
    """Every sub-model's error over the stretch about an instant.

    Parameters
    ----------
    case
        The trip.
    mbc
        The bank, ready for it.
    walk
        A rate run.
    index
        Sample in the middle of the stretch.
    """
    t_s = case.truth.t_s
    low, high = np.searchsorted(t_s, [t_s[index] - STRETCH_S / 2, t_s[index] + STRETCH_S / 2])
    part = slice(int(low), int(high))
    errors = mbc.tracking_error_m(walk)[part]
    errors[np.isinf(errors)] = np.nan
    kind = walk.kind[part]
    times = t_s[part]
    return Timeline(
        case.truth.trip_id,
        walk.policy.threshold_m,
        tuple(member.name for member in mbc.bank.members),
        times,
        errors,
        walk.in_use[part],
        times[(kind == MessageKind.UPDATE) | (kind == MessageKind.KEEP_ALIVE)],
        times[kind == MessageKind.IDENTIFICATION],
    )


def draw_manoeuvre(case: TripCase, banks: Sequence[TripRuntime], threshold_m: float, index: int) -> Manoeuvre:
    """Paths that every sub-model predicts from just before an instant, beside the truth.

    Parameters
    ----------
    case
        The trip.
    banks
        Banks ready for it; a sub-model they share is drawn once.
    threshold_m
        Error at which a path has failed [m].
    index
        Sample of the manoeuvre.
    """
    t_s = case.truth.t_s
    start = max(int(t_s.searchsorted(float(t_s[index]) - _LEAD_S)), 0)
    end = int(t_s.searchsorted(float(t_s[start]) + _HORIZON_S, side="right"))
    horizons_s = t_s[start:end] - t_s[start]
    truth_m = case.truth.position_m[start:end]
    predicted: dict[str, FloatArray] = {}
    survival: dict[str, float] = {}
    window = 1
    for ready in banks:
        ready.fit_at([start])
        window = max(window, int(ready.bank.windows.max()))
        for name, path in _paths(ready, start, horizons_s).items():
            predicted[name] = path
            error = np.hypot(*(path - truth_m).T)
            failed: IntArray = np.flatnonzero(error >= threshold_m)
            survival[name] = float(horizons_s[failed[0]]) if failed.size else np.inf
    return Manoeuvre(
        case.truth.trip_id,
        float(t_s[start]),
        case.seen.position_m[max(start - window + 1, 0) : start + 1],
        truth_m,
        horizons_s,
        predicted,
        survival,
        threshold_m,
    )


def _paths(ready: TripRuntime, start: int, horizons_s: FloatArray) -> dict[str, FloatArray]:
    history = start - ready.trip.segment_start[start] + 1
    paths: dict[str, FloatArray] = {}
    for m, member in enumerate(ready.bank.members):
        if member.window > history:
            continue
        own = ready.parameters[start : start + 1, ready.bank.offsets[m] : ready.bank.offsets[m + 1]]
        moved = member.predict(own, horizons_s, dt_s=ready.trip.dt_s)[0]
        paths[member.name] = ready.stated_m[start] + moved
    return paths

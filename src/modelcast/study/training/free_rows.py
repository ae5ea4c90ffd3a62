"""Windows that free sub-models learn from: what senders of every kind see, and the path that followed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.models.learned.features import LAG_STEP_S, SHORTEST_SPAN, FeatureMap
from modelcast.models.learned.learned_kernels import FRAME_MPS
from modelcast.models.point_kernels import POSITION_NOISE, REPORTS, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.training.inputs import window_inputs
from modelcast.study.training.views import PlayedTrip, SenderView, Viewed, view_trips

__all__ = ["FreeRows", "free_rows", "joined_rows"]


@dataclass(frozen=True, slots=True)
class FreeRows:
    """B windows of moving vehicles.

    Parameters
    ----------
    inputs
        Of the map, (B, I).
    paths_m
        True positions at the horizons less the position seen, along the newest course and to its left,
        (B, H, 2) [m].
    known
        Whether the trip goes on so long, (B, H).
    noise_m
        Position noise that the sender estimates, (B,) [m].
    reports
        What it reports (`modelcast.models.point_kernels.REPORTS`), (B,).
    shares
        How often each is drawn, (B,): kinds of senders and groups of trips count alike.
    """

    inputs: FloatArray
    paths_m: FloatArray
    known: BoolArray
    noise_m: FloatArray
    reports: FloatArray
    shares: FloatArray

    def taken(self, rows: IntArray) -> "FreeRows":
        """Some of the windows.

        Parameters
        ----------
        rows
            Which, (K,).
        """
        return FreeRows(
            self.inputs[rows],
            self.paths_m[rows],
            self.known[rows],
            self.noise_m[rows],
            self.reports[rows],
            self.shares[rows],
        )


def joined_rows(parts: Sequence[FreeRows]) -> FreeRows:
    """All windows of several parts.

    Parameters
    ----------
    parts
        At least one.
    """
    return FreeRows(
        np.concatenate([one.inputs for one in parts]),
        np.concatenate([one.paths_m for one in parts]),
        np.concatenate([one.known for one in parts]),
        np.concatenate([one.noise_m for one in parts]),
        np.concatenate([one.reports for one in parts]),
        np.concatenate([one.shares for one in parts]),
    )


def free_rows(
    group: Sequence[PlayedTrip],
    views: Sequence[tuple[SenderView, float]],
    features: FeatureMap,
    horizons_s: FloatArray,
    *,
    rows: int,
    shortest_s: float,
    seed: int,
    contexts: Mapping[str, FloatArray] | None = None,
) -> list[FreeRows]:
    """Windows of some trips in all views.

    Parameters
    ----------
    group
        The trips, played in all ways.
    views
        Kinds of senders, and the share of each.
    features
        What is taken of a window.
    horizons_s
        Times at which the path is wanted, rising (H,) [s].
    rows
        Windows of a view, at most.
    shortest_s
        So much of a trip must follow a window [s].
    seed
        Of noise and choice.
    contexts
        Context of trips by their identifier, (T, 13) each; those without have none.
    """
    found: list[FreeRows] = []
    for view, weight in views:
        viewed = list(view_trips(group, view, seed=seed))
        ends = [_ends(one, features, shortest_s) for one in viewed]
        total = sum(one.size for one in ends)
        parts: list[FreeRows] = []
        for one, all_ends in zip(viewed, ends, strict=True):
            count = min(all_ends.size, int(np.ceil(rows * all_ends.size / max(total, 1))))
            rng = child_generator(seed, "rows", one.truth.trip_id, view.name)
            chosen = np.sort(rng.permutation(all_ends)[:count])
            if chosen.size:
                context = None if contexts is None else contexts.get(one.truth.trip_id)
                parts.append(_cut(one, chosen, features, horizons_s, context))
        count = sum(len(one.inputs) for one in parts)
        if count:
            part = joined_rows(parts)
            shares = np.full(count, weight / count)
            found.append(replace(part, shares=shares))
    return found


def _ends(viewed: Viewed, features: FeatureMap, shortest_s: float) -> IntArray:
    """Samples with a full window behind and some path ahead."""
    trip = viewed.seen
    if trip.dt_s < LAG_STEP_S * SHORTEST_SPAN:
        return np.empty(0, dtype=np.int64)
    last_s = trip.t_s[np.repeat(trip.segments[1:] - 1, np.diff(trip.segments))]
    enough = np.arange(len(trip)) - trip.segment_start >= features.window_at(trip.dt_s) - 1
    return np.flatnonzero(enough & (last_s - trip.t_s >= shortest_s))


def _cut(
    viewed: Viewed, rows: IntArray, features: FeatureMap, horizons_s: FloatArray, context: FloatArray | None
) -> FreeRows:
    """Inputs and paths of the windows of moving vehicles that end at these samples."""
    seen, truth = viewed.seen, viewed.truth
    samples = sample_matrix(seen, velocity_estimator_for(seen))
    velocity = samples[:, [VELOCITY_EAST, VELOCITY_NORTH]]
    rows = rows[np.hypot(*velocity[rows].T) >= FRAME_MPS]
    if features.context and context is not None:
        samples = np.concatenate([samples, context[viewed.kept]], axis=1)
    inputs = window_inputs(samples, rows, features.window_at(seen.dt_s), features, seen.dt_s)
    at_s = seen.t_s[rows][:, None] + horizons_s
    last_s = seen.t_s[np.repeat(seen.segments[1:] - 1, np.diff(seen.segments))][rows]
    path = np.stack([np.interp(at_s, truth.t_s, truth.position_m[:, axis]) for axis in range(2)], axis=-1)
    moved = path - seen.position_m[rows][:, None]
    east, north = (velocity[rows] / np.hypot(*velocity[rows].T)[:, None]).T[:, :, None]
    along = moved[..., 0] * east + moved[..., 1] * north
    left = moved[..., 1] * east - moved[..., 0] * north
    return FreeRows(
        inputs,
        np.stack([along, left], axis=-1),
        at_s <= last_s[:, None] + 1e-6,
        samples[rows, POSITION_NOISE],
        samples[rows, REPORTS],
        np.zeros(rows.size),
    )

"""References beside every message rate: a sender that knows the future, and today's standard in Europe."""

from collections.abc import Sequence
from math import fsum

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.policy.cam import CamTriggering
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.study.case import STANDING_SPEED_MPS, TripCase
from modelcast.study.clairvoyant import clairvoyant
from modelcast.study.minimax_kernels import MOST_DEGREE
from modelcast.study.result import POOLED, REFERENCES
from modelcast.study.table import Row

__all__ = ["count_references", "pooled_references"]


def count_references(case: TripCase, thresholds_m: Sequence[float]) -> list[Row]:
    """Count the messages of every reference over what the sender of one trip sees.

    Parameters
    ----------
    case
        The trip.
    thresholds_m
        Tracking-error thresholds [m].
    """
    rows: list[Row] = []
    for degree in range(1, MOST_DEGREE + 1):
        for threshold_m in thresholds_m:
            found = clairvoyant(case.seen, degree, threshold_m)
            rows.append(
                _row(
                    case.seen.trip_id,
                    f"clairvoyant-{degree}",
                    threshold_m,
                    messages=found.starts.size,
                    least_messages=found.least_messages,
                    duration_s=case.truth.duration_s,
                    undecided=found.undecided,
                )
            )
    speed_mps, heading_rad = _motion(case)
    messages = (
        CamTriggering()
        .transmit_indices(
            case.seen.t_s,
            case.seen.position_m,
            speed_mps=speed_mps,
            heading_rad=heading_rad,
            segments=case.seen.segments,
        )
        .size
    )
    rows.append(
        _row(
            case.seen.trip_id,
            "cam",
            None,
            messages=messages,
            least_messages=messages,
            duration_s=case.truth.duration_s,
            undecided=0,
        )
    )
    return rows


def pooled_references(rows: Sequence[Row]) -> list[Row]:
    """Rows that pool the same reference and threshold over trips: sums of messages over sums of time."""
    groups: dict[tuple[str, float | None], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.reference, row.threshold_m), []).append(row)
    return [
        _row(
            POOLED,
            *key,
            messages=sum(row.messages for row in group),
            least_messages=sum(row.least_messages for row in group),
            duration_s=fsum(row.duration_s for row in group),
            undecided=sum(row.undecided for row in group),
        )
        for key, group in groups.items()
    ]


def _row(
    trip: str,
    reference: str,
    threshold_m: float | None,
    *,
    messages: int,
    least_messages: int,
    duration_s: float,
    undecided: int,
) -> Row:
    return REFERENCES.row(
        trip=trip,
        reference=reference,
        threshold_m=threshold_m,
        messages=messages,
        least_messages=least_messages,
        duration_s=duration_s,
        rate_hz=messages / duration_s,
        undecided=undecided,
    )


def _motion(case: TripCase) -> tuple[FloatArray, FloatArray]:
    """Speed and heading as the sender sees them, else from the trip's causal velocity.

    A direction from positions means nothing at standstill, so there it stays what it was (and before the
    first move it is that of the move).
    """
    seen = case.seen
    velocity_mps = sample_matrix(seen, case.estimator)[:, 2:4]
    size_mps = np.hypot(velocity_mps[:, 0], velocity_mps[:, 1])
    stuck = case.protocol == "recorded" and case.inspection.speed_is_stuck
    speed_mps = size_mps if seen.speed_mps is None or stuck else seen.speed_mps
    if seen.heading_rad is not None:
        return speed_mps, seen.heading_rad
    moving = np.flatnonzero(size_mps >= STANDING_SPEED_MPS)
    if moving.size == 0:
        return speed_mps, np.zeros_like(speed_mps)
    at = np.searchsorted(moving, np.arange(size_mps.size), side="right") - 1
    held = velocity_mps[moving[np.maximum(at, 0)]]
    return speed_mps, np.arctan2(held[:, 0], held[:, 1])

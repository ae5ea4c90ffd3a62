"""The fewest messages a sender could send that knew the future: the bound that any predictor strives for.

A message of this sender carries one polynomial of time for each axis, fitted to what the vehicle is going to
do. It serves as long as the two-dimensional error stays under the threshold at every sample.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.study import clairvoyant_kernels as kernels
from modelcast.study.minimax_kernels import MOST_DEGREE
from modelcast.trips.trajectory import Trajectory

__all__ = ["Clairvoyant", "clairvoyant"]


@dataclass(frozen=True, slots=True)
class Clairvoyant:
    """The messages of a sender that knows the future.

    Parameters
    ----------
    starts
        First samples of the stretches that one message each serves, (N,).
    undecided
        Tests that were neither proved nor refuted; each was taken as failed.
    least_messages
        The number of stretches with undecided tests taken as passed: no sender needs fewer.
    """

    starts: IntArray
    undecided: int
    least_messages: int


def clairvoyant(trip: Trajectory, degree: int, threshold_m: float) -> Clairvoyant:
    """Cover every gapless part of a trip with the longest stretches that one polynomial an axis holds.

    Parameters
    ----------
    trip
        What the sender sees.
    degree
        Degree of the polynomials: 1, 2 or 3.
    threshold_m
        Tracking error at which a message has failed; equal counts as failed [m].

    Raises
    ------
    ValueError
        Where the degree or threshold is out of range.

    Notes
    -----
    Taking the longest stretch each time is optimal. A polynomial that holds a stretch holds any part of it,
    so by induction the k-th stretch of the greedy cover ends no earlier than the k-th of any other cover.

    A stretch is only taken with a polynomial that was seen to hold it, and only refused with weights w >= 0,
    sum w = 1, whose least-squares optimum has sqrt(sum w e²) >= threshold: the greatest error of any
    polynomial is at least its weighted mean, and that is at least the optimum's (`minimax_kernels`).

    Each part starts anew, so a sender whose models outlast a gap may save one message a gap.

    References
    ----------
    C. L. Lawson, "Contributions to the theory of linear least maximum approximation", thesis, UCLA, 1961, for
    the weights; S. Boyd, L. Vandenberghe, "Convex Optimization", 2004, section 11.7, for the iteration.

    Examples
    --------
    A turn at a right angle, driven at a constant speed, takes two messages:

    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t_s = 0.1 * np.arange(100)
    >>> corner = np.stack([np.minimum(t_s, 5.0), np.maximum(t_s, 5.0)], axis=1)
    >>> clairvoyant(build_trajectory("made/1", t_s, 10.0 * corner), 1, 0.2).starts.size
    2
    """
    if not 1 <= degree <= MOST_DEGREE:
        raise ValueError(f"degree must be 1 to {MOST_DEGREE}, got {degree}")
    if not (threshold_m > 0 and np.isfinite(threshold_m)):
        raise ValueError(f"threshold_m must be positive, got {threshold_m}")
    starts = np.empty(len(trip), dtype=np.int64)
    track = (trip.t_s, trip.position_m, trip.segments, degree, threshold_m)
    found, undecided = kernels.greedy(*track, False, starts)
    least = found
    if undecided:
        least, _ = kernels.greedy(*track, True, np.empty_like(starts))
    return Clairvoyant(starts[:found].copy(), undecided, least)

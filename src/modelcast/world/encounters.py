"""Who has to look at whom: the pairs of vehicles of a frame that are close to each other."""

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.scientific import scientific

__all__ = ["near_pairs"]


def near_pairs(position_m: FloatArray, active: BoolArray, radius_m: float) -> tuple[IntArray, IntArray]:
    """Every host with every remote around it: the rows that applications take as one batch.

    Both of a pair are host once, so a pair is there twice. Whether a remote is ahead, beside or on a crossing
    course is for the applications to say.

    Parameters
    ----------
    position_m
        East and north of all slots, (V, 2) [m].
    active
        Which slots hold a vehicle, (V,); the others are in no pair.
    radius_m
        Distance up to which remotes count, this one included [m].

    Returns
    -------
    tuple of arrays
        Slots of hosts and of remotes, (N,) each, by host and then by remote.

    Raises
    ------
    ValueError
        Where shapes differ, the radius is not positive and finite, or a vehicle's place is not finite.

    Examples
    --------
    >>> places = np.array([[0.0, 0.0], [0.0, 30.0], [0.0, 90.0]])
    >>> near_pairs(places, np.array([True, True, True]), 50.0)
    (array([0, 1]), array([1, 0]))
    """
    if position_m.shape != (active.size, 2):
        raise ValueError(f"position_m must have shape {(active.size, 2)}, got {position_m.shape}")
    if not (np.isfinite(radius_m) and radius_m > 0.0):
        raise ValueError(f"radius_m must be positive and finite, got {radius_m}")
    slots = np.flatnonzero(active)
    place = position_m[slots]
    if not np.isfinite(place).all():
        raise ValueError("position_m of a slot with a vehicle is not finite: such a slot is not active")
    if slots.size < 2:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    tree = scientific("spatial", "finding who is near").cKDTree(place)
    found: IntArray = tree.query_pairs(radius_m, output_type="ndarray").astype(np.int64)
    hosts = slots[np.concatenate([found[:, 0], found[:, 1]])]
    remotes = slots[np.concatenate([found[:, 1], found[:, 0]])]
    order = np.lexsort((remotes, hosts))
    return hosts[order], remotes[order]

"""What a follower asks for: its law's word, and what is left where the law knows too little."""

import numpy as np

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw, Following
from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["desired"]


def desired(
    law: AbstractCruiseLaw, known: Following, dt_s: float, *, fallback: Acc | None = None
) -> tuple[FloatArray, BoolArray]:
    """Return the acceleration that each follower asks for, and where its law had no word, (N,) each.

    Where the law lacks something, the fallback speaks from gap and speed of the vehicle ahead; where even
    these are not known the speed is kept, as Plexe does until the first message.

    Parameters
    ----------
    law
        The law in use.
    known
        What each follower knows.
    dt_s
        Time since they were asked last [s].
    fallback
        None for `Acc` with its defaults.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from modelcast.apps.cruise.path import PathCacc
    >>> one, zero = np.ones(1), np.zeros(1)
    >>> content = Following(
    ...     20.0 * one, zero, commanded_mps2=zero, gap_m=5.0 * one, ahead_speed_mps=20.0 * one,
    ...     ahead_acceleration_mps2=zero, leader_speed_mps=20.0 * one, leader_acceleration_mps2=zero,
    ... )
    >>> desired(PathCacc(), content, 0.01)
    (array([0.]), array([False]))
    >>> deaf = replace(content, leader_speed_mps=np.full(1, np.nan))
    >>> desired(PathCacc(), deaf, 0.01)
    (array([-1.75]), array([ True]))
    """
    second = Acc() if fallback is None else fallback
    enough, enough_for_second = law.knows_enough(known), second.knows_enough(known)
    wanted = np.where(enough_for_second, second.acceleration(known, dt_s), 0.0)
    return np.where(enough, law.acceleration(known, dt_s), wanted), ~enough

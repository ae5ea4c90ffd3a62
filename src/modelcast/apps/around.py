"""A host and all remotes of its map as applications take them, row by row."""

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.station.receiver.local_dynamic_map import Beliefs

__all__ = ["believed_motions", "repeated"]

_SIZES_M = np.array([SIZES_M[kind] for kind in Kind])


def believed_motions(beliefs: Beliefs) -> Motions:
    """How remotes are believed to move, a row each; sizes that nobody stated are those of their kind.

    Parameters
    ----------
    beliefs
        Of N remotes.
    """
    usual_m = _SIZES_M[beliefs.kind]
    return Motions.of(
        beliefs.position_m,
        speed_mps=beliefs.speed_mps,
        heading_rad=beliefs.heading_rad,
        acceleration_mps2=beliefs.acceleration_mps2,
        yaw_rate_radps=beliefs.yaw_rate_radps,
        length_m=np.where(np.isnan(beliefs.length_m), usual_m[:, 0], beliefs.length_m),
        width_m=np.where(np.isnan(beliefs.width_m), usual_m[:, 1], beliefs.width_m),
        covariance_m2=beliefs.covariance_m2,
        kind=beliefs.kind,
    )


def repeated(position_m: tuple[float, float], rows: int, **motion: float) -> Motions:
    """One vehicle's motion, once for each of so many remotes.

    Parameters
    ----------
    position_m
        East and north [m].
    rows
        N.
    motion
        The other parameters of `Motions.of`.

    Examples
    --------
    >>> len(repeated((0.0, 5.0), 3, speed_mps=20.0, heading_rad=0.0))
    3
    """
    return Motions.of(np.tile(position_m, (rows, 1)), **motion)

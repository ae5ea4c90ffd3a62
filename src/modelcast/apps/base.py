"""What a safety application is: a function of how a host moves and believes remotes to move, row by row."""

import abc

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import FloatArray

__all__ = ["AbstractApplication", "motion_rows", "place_spreads"]


class AbstractApplication(abc.ABC):
    """Warns hosts of remotes. Implementations are frozen dataclasses; they keep nothing between calls."""

    @abc.abstractmethod
    def assess(self, host: Motions, remote: Motions) -> Warnings:
        """Assess N hosts and remotes, row by row.

        Parameters
        ----------
        host
            How each host moves, as it sees itself.
        remote
            How it believes the remote to move; rows with a NaN are not known, and nothing is said of them.

        Raises
        ------
        ValueError
            Where there are not as many remotes as hosts.
        """


def motion_rows(host: Motions, remote: Motions) -> tuple[FloatArray, FloatArray]:
    """Both as compiled rules take them, (N, 8) each: columns as `Motions` has them.

    Parameters
    ----------
    host, remote
        As for `AbstractApplication.assess`.

    Raises
    ------
    ValueError
        Where their numbers differ.
    """
    if len(host) != len(remote):
        raise ValueError(f"there must be a remote a host, got {len(host)} hosts and {len(remote)} remotes")
    host_rows, remote_rows = (
        np.column_stack(
            (
                own.position_m,
                own.speed_mps,
                own.heading_rad,
                own.acceleration_mps2,
                own.yaw_rate_radps,
                own.length_m,
                own.width_m,
            )
        )
        for own in (host, remote)
    )
    return host_rows, remote_rows


def place_spreads(host: Motions, remote: Motions) -> FloatArray:
    """Covariance of the remote's place as the host sees it, east, both and north, (N, 3) [m²].

    Parameters
    ----------
    host, remote
        As for `AbstractApplication.assess`; a missing covariance counts as zero.
    """
    found = np.zeros((len(host), 3))
    for own in (host, remote):
        if own.covariance_m2 is not None:
            found += own.covariance_m2[:, [0, 0, 1], [0, 1, 1]]
    return found

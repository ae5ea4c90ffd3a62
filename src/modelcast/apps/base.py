"""What a safety application is: a pure function of the host's own motion and what it believes of remotes."""

import abc

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.apps.pair_kernels import Columns, Found
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import owned

__all__ = ["AbstractApplication"]


class AbstractApplication(abc.ABC):
    """Says how urgent each pair of host and remote is; the same in every runtime."""

    def assess(self, host: Motions, remote: Motions) -> Warnings:
        """Assess pairs row by row.

        Parameters
        ----------
        host
            Own motions, N rows.
        remote
            Believed motions, N rows.

        Raises
        ------
        ValueError
            Where the numbers of rows differ.
        """
        if len(host) != len(remote):
            raise ValueError(
                f"host and remote are taken row by row, got {len(host)} and {len(remote)} rows; "
                "repeat the host for each remote"
            )
        rows = len(host)
        found = Found(np.empty(rows, dtype=np.int64), np.empty(rows), np.empty(rows), np.empty(rows))
        self._fill(_columns(host), _columns(remote), found)
        return Warnings(found.level, time_s=found.time, margin_m=found.margin, certainty=found.certainty)

    @abc.abstractmethod
    def _fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""


def _columns(motions: Motions) -> Columns:
    covariance = motions.covariance_m2
    return Columns(
        owned(motions.position_m),
        owned(motions.speed_mps),
        owned(motions.heading_rad),
        owned(motions.acceleration_mps2),
        owned(motions.yaw_rate_radps),
        owned(motions.length_m),
        owned(motions.width_m),
        np.empty((0, 2, 2)) if covariance is None else owned(covariance),
    )

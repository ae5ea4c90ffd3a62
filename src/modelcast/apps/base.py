"""What a safety application is: a pure function of the host's own motion and what it believes of remotes."""

import abc
from dataclasses import fields
from typing import ClassVar

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.apps.pair_kernels import Columns, Found
from modelcast.apps.warnings import Level, Warnings
from modelcast.core.arrays import BoolArray, owned
from modelcast.core.kinds import Kind

__all__ = ["AbstractApplication", "columns_of", "refuse_negative", "same_rows"]


class AbstractApplication(abc.ABC):
    """Says how urgent each pair of host and remote is; the same in every runtime."""

    of_people: ClassVar[bool] = False
    """Whether it is made for people; any other is made for pairs of two vehicles."""

    def assess(self, host: Motions, remote: Motions) -> Warnings:
        """Assess pairs row by row; of a pair that it is not made for, nothing is said.

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
        same_rows(host, remote)
        rows = len(host)
        found = Found(np.empty(rows, dtype=np.int64), np.empty(rows), np.empty(rows), np.empty(rows))
        self._fill(columns_of(host), columns_of(remote), found)
        if not self.of_people:
            others = _are_others(host) | _are_others(remote)
            found.level[others], found.certainty[others] = Level.NONE, 0.0
            found.time[others] = np.inf
            found.margin[others & ~np.isnan(found.margin)] = np.inf
        return Warnings(found.level, time_s=found.time, margin_m=found.margin, certainty=found.certainty)

    @abc.abstractmethod
    def _fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""


def _are_others(motions: Motions) -> BoolArray:
    """Which are no vehicles."""
    if motions.kind is None:
        return np.zeros(len(motions), dtype=np.bool_)
    return motions.kind != Kind.VEHICLE


def same_rows(host: Motions, remote: Motions) -> None:
    """Refuse motions that cannot be taken row by row.

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


def columns_of(motions: Motions) -> Columns:
    """Motions as kernels take them."""
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
        np.zeros(len(motions), dtype=np.int64) if motions.kind is None else owned(motions.kind, np.int64),
    )


def refuse_negative(application: AbstractApplication) -> None:
    """Refuse numbers of an application, a dataclass, that are negative or NaN.

    Raises
    ------
    ValueError
        Where one is.
    """
    for field in fields(application):  # type: ignore[arg-type]
        value = getattr(application, field.name)
        if isinstance(value, (int, float)) and not value >= 0.0:
            raise ValueError(f"{field.name} must not be negative, got {value}")

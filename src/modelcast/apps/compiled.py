"""Applications whose rule is compiled: motions and warnings as kernels take them."""

import abc
from typing import Any, TypeVar, cast

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.apps.motions import Motions
from modelcast.apps.pair_kernels import Columns, Found
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import owned

__all__ = ["AbstractCompiledApplication", "columns_of", "reals"]

Settings = TypeVar("Settings", bound=tuple[float, ...])


class AbstractCompiledApplication(AbstractApplication):
    """An application that fills arrays."""

    __slots__ = ()

    @abc.abstractmethod
    def fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""

    def judge(self, host: Motions, remote: Motions) -> Warnings:
        """Judge pairs row by row."""
        rows = len(host)
        found = Found(np.empty(rows, dtype=np.int64), np.empty(rows), np.empty(rows), np.empty(rows))
        self.fill(columns_of(host), columns_of(remote), found)
        return Warnings(found.level, time_s=found.time, margin_m=found.margin, certainty=found.certainty)


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


def reals(settings: Settings) -> Settings:
    """Settings as kernels take them: a whole number that a user gave is a number as any other.

    Parameters
    ----------
    settings
        A named tuple of numbers.
    """
    made: Any = type(settings)
    return cast("Settings", made(*map(float, settings)))

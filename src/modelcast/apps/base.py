"""What a safety application is: a pure function of the host's own motion and what it believes of remotes."""

import abc
from dataclasses import fields
from typing import ClassVar

import numpy as np

from modelcast.apps.motions import Motions
from modelcast.apps.warnings import Level, Warnings
from modelcast.core.arrays import BoolArray
from modelcast.core.kinds import Kind

__all__ = ["AbstractApplication", "refuse_negative", "same_rows"]


class AbstractApplication(abc.ABC):
    """Says how urgent each pair of host and remote is; the same in every runtime.

    Who writes one gives `judge`, in NumPy over all rows at once. Another package adds its own in the
    entry-point group ``modelcast.applications`` (`modelcast.apps.registry`).

    Examples
    --------
    >>> import numpy as np
    >>> class Near(AbstractApplication):
    ...     def judge(self, host, remote):
    ...         away_m = np.linalg.norm(remote.position_m - host.position_m, axis=1)
    ...         return Warnings.by_margin(away_m - 10.0)
    >>> host = Motions.of([[0.0, 0.0]] * 3, speed_mps=20.0, heading_rad=0.0)
    >>> remote = Motions.of([[0.0, 8.0], [0.0, 30.0], [0.0, np.nan]], speed_mps=20.0, heading_rad=0.0)
    >>> Near().assess(host, remote).level
    array([2, 0, 0])
    """

    of_people: ClassVar[bool] = False
    """Whether it is made for people; any other is made for pairs of two vehicles."""

    @abc.abstractmethod
    def judge(self, host: Motions, remote: Motions) -> Warnings:
        """Judge pairs row by row, whatever they are: `assess` leaves out whom it is not made for.

        Parameters
        ----------
        host
            Own motions, N rows; one that is not known is NaN.
        remote
            Believed motions, N rows. Rows stand for themselves: how many there are, and in which order,
            changes nothing.
        """

    def assess(self, host: Motions, remote: Motions) -> Warnings:
        """Assess pairs row by row; of a pair that is not known, or that it is not made for, nothing is said.

        Parameters
        ----------
        host
            Own motions, N rows.
        remote
            Believed motions, N rows.

        Raises
        ------
        ValueError
            Where the numbers of rows differ, or what is judged is no warning of these rows.
        """
        same_rows(host, remote)
        found = self.judge(host, remote)
        if len(found) != len(host):
            raise ValueError(f"{type(self).__name__} judged {len(found)} rows of {len(host)}")
        unknown = ~(_is_known(host) & _is_known(remote))
        others = unknown if self.of_people else unknown | _are_others(host) | _are_others(remote)
        if others.any():
            lost = others & (unknown | np.isnan(found.margin_m))
            found = Warnings(
                np.where(others, Level.NONE, found.level),
                time_s=np.where(others, np.inf, found.time_s),
                margin_m=np.where(lost, np.nan, np.where(others, np.inf, found.margin_m)),
                certainty=np.where(others, 0.0, found.certainty),
            )
        if not np.array_equal(found.warned, found.margin_m <= 0.0):
            raise ValueError(
                f"{type(self).__name__} must warn exactly where margin_m is not positive: "
                "Warnings.by_margin makes what agrees"
            )
        return found


def _is_known(motions: Motions) -> BoolArray:
    """Of which rows all of the motion is known."""
    total = motions.position_m.sum(axis=1) + motions.speed_mps + motions.heading_rad
    return ~np.isnan(total + motions.acceleration_mps2 + motions.yaw_rate_radps)


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


def refuse_negative(application: AbstractApplication) -> None:
    """Refuse numbers of an application, a dataclass, that are none, negative or NaN.

    Raises
    ------
    ValueError
        Where one is.
    """
    for field in fields(application):  # type: ignore[arg-type]
        value = getattr(application, field.name)
        if isinstance(field.default, float) and not isinstance(value, (int, float)):
            raise ValueError(f"{field.name} must be a number, got {value!r}")  # noqa: TRY004 - as below
        if isinstance(value, (int, float)) and not value >= 0.0:
            raise ValueError(f"{field.name} must not be negative, got {value}")

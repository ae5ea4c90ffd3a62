"""The cooperative law of California's PATH programme: a constant distance, with the leader's help."""

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar

import numpy as np

from modelcast.apps.cruise.base import AbstractCruiseLaw, ComplexArray, Following
from modelcast.core.arrays import FloatArray

__all__ = ["PathCacc"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathCacc(AbstractCruiseLaw):
    """Keep a constant distance to the vehicle ahead, and agree with the leader.

    Parameters
    ----------
    leader_weight
        C1: share of the leader against the vehicle ahead, 0 to below 1.
    damping
        xi: damping ratio, at least 1.
    bandwidth_radps
        omega_n: bandwidth of the law [rad/s].
    spacing_m
        Distance to keep, bumper to bumper [m].

    Raises
    ------
    ValueError
        Where a value is out of its range.

    Notes
    -----
    With e = spacing - gap, its rate v - v_ahead, and r = xi + sqrt(xi² - 1)::

        u = (1 - C1) a_ahead + C1 a_leader - (2 xi - C1 r) omega (v - v_ahead)
            - r omega C1 (v - v_leader) - omega² e

    The defaults are those of Plexe's example. Plexe writes the bandwidth as 0.2 Hz and puts the number 0.2
    into this formula as it stands, so it is an angular frequency there, 0.2 rad/s, and here: the name says
    so. (0.2 Hz taken at its word would be 1.26 rad/s, a far stiffer law.) Plexe's followers are told the
    acceleration that the vehicle ahead *asked for*; basic safety messages and models say the one it *has*,
    and so does this.

    References
    ----------
    R. Rajamani, Vehicle Dynamics and Control, 2nd ed., 2012, eq. 7.39; R. Rajamani, H.-S. Tan, B. K. Law,
    W.-B. Zhang, "Demonstration of integrated longitudinal and lateral control for the operation of automated
    vehicles in platoons", 2000, DOI 10.1109/87.852914. Use and defaults: M. Segata et al., "Plexe", 2014, DOI
    10.1109/VNC.2014.7013309, and its ``examples/platooning``.
    """

    name: ClassVar[str] = "path"
    needs: ClassVar[tuple[str, ...]] = (
        "gap_m", "ahead_speed_mps", "ahead_acceleration_mps2", "leader_speed_mps", "leader_acceleration_mps2",
    )  # fmt: skip

    leader_weight: float = 0.5
    damping: float = 1.0
    bandwidth_radps: float = 0.2
    spacing_m: float = 5.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.leader_weight < 1.0:
            raise ValueError(f"leader_weight must lie in [0, 1), got {self.leader_weight}")
        if not self.damping >= 1.0:
            raise ValueError(f"damping must be at least 1, got {self.damping}")
        for name in ("bandwidth_radps", "spacing_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    @property
    def gains(self) -> tuple[float, float, float]:
        """Of the speed over the vehicle ahead, over the leader, both [1/s], and of the distance [1/s²]."""
        root = self.damping + sqrt(self.damping**2 - 1.0)
        omega = self.bandwidth_radps
        return (
            (2.0 * self.damping - self.leader_weight * root) * omega,
            root * omega * self.leader_weight,
            omega**2,
        )

    def acceleration(self, known: Following, dt_s: float) -> FloatArray:
        """The formula of the notes."""
        del dt_s
        ahead, leader, distance = self.gains
        told = (1.0 - self.leader_weight) * known.ahead_acceleration_mps2
        told = told + self.leader_weight * known.leader_acceleration_mps2
        return (
            told
            - ahead * (known.speed_mps - known.ahead_speed_mps)
            - leader * (known.speed_mps - known.leader_speed_mps)
            - distance * (self.spacing_m - known.gap_m)
        )

    def gap_m(self, speed_mps: FloatArray) -> FloatArray:
        """The spacing at every speed."""
        return np.full_like(speed_mps, self.spacing_m)

    def response(
        self, s: ComplexArray, ahead: ComplexArray, leader: ComplexArray, lag_s: float
    ) -> ComplexArray:
        """Both ahead and leader, over lag s³ + s² + (k1 + k2) s + omega², as the law has them."""
        first, second, distance = self.gains
        told = ((1.0 - self.leader_weight) * s**2 + first * s + distance) * ahead
        told = told + (self.leader_weight * s**2 + second * s) * leader
        return told / (lag_s * s**3 + s**2 + (first + second) * s + distance)

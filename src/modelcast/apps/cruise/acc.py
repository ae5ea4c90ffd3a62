"""Adaptive cruise control: a constant headway from a ranging sensor, with no radio."""

from dataclasses import dataclass
from typing import ClassVar

from modelcast.apps.cruise.base import AbstractCruiseLaw, ComplexArray, Following
from modelcast.core.arrays import FloatArray

__all__ = ["Acc"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Acc(AbstractCruiseLaw):
    """Keep a constant headway to the vehicle ahead.

    Parameters
    ----------
    headway_s
        h [s]; Plexe's example has 1.2 and 0.3.
    distance_gain
        lambda [1/s].
    standstill_m
        Gap at standstill [m].

    Raises
    ------
    ValueError
        Where a value is not positive.

    Notes
    -----
    u = -(v - v_ahead + lambda (standstill + h v - gap)) / h. With a drive that lags by tau, the string is
    stable where h >= 2 tau.

    References
    ----------
    R. Rajamani, Vehicle Dynamics and Control, 2nd ed., 2012, eq. 6.18 and section 6.6. Defaults: Plexe.
    """

    name: ClassVar[str] = "acc"
    needs: ClassVar[tuple[str, ...]] = ("gap_m", "ahead_speed_mps")

    headway_s: float = 1.2
    distance_gain: float = 0.1
    standstill_m: float = 2.0

    def __post_init__(self) -> None:
        for name in ("headway_s", "distance_gain", "standstill_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    def acceleration(self, known: Following, dt_s: float) -> FloatArray:
        """The formula of the notes."""
        del dt_s
        too_near_m = self.gap_m(known.speed_mps) - known.gap_m
        closing = known.speed_mps - known.ahead_speed_mps
        return -(closing + self.distance_gain * too_near_m) / self.headway_s

    def gap_m(self, speed_mps: FloatArray) -> FloatArray:
        """Standstill gap and headway."""
        return self.standstill_m + self.headway_s * speed_mps

    def response(
        self, s: ComplexArray, ahead: ComplexArray, leader: ComplexArray, lag_s: float
    ) -> ComplexArray:
        """The ratio s + lambda over h (lag s³ + s²) + s + lambda (h s + 1), times the vehicle ahead."""
        del leader
        spring = s + self.distance_gain
        return ahead * spring / (self.headway_s * (lag_s * s**3 + s**2 + self.distance_gain * s) + spring)

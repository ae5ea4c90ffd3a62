"""Ploeg's cooperative law: a constant headway, from the vehicle ahead alone."""

from dataclasses import dataclass
from typing import ClassVar

from modelcast.apps.cruise.base import AbstractCruiseLaw, ComplexArray, Following
from modelcast.core.arrays import FloatArray

__all__ = ["Ploeg"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ploeg(AbstractCruiseLaw):
    """Keep a constant headway to the vehicle ahead, whose acceleration is fed forward.

    Parameters
    ----------
    headway_s
        h [s].
    distance_gain, speed_gain
        kp [1/s²], kd [1/s].
    standstill_m
        Gap at standstill [m].

    Raises
    ------
    ValueError
        Where a value is not positive.

    Notes
    -----
    The law says how the acceleration asked for changes; it is integrated over the time since it was asked
    last::

        h du/dt = -u + kp (gap - standstill - h v) + kd (v_ahead - v - h a) + a_ahead

    Ploeg feeds forward the acceleration that the vehicle ahead *asked for*, with which the string is stable
    at any headway. A basic safety message says the acceleration that it *has*, later by the lag of its drive:
    with a lag of 0.5 s a headway of 0.5 s then amplifies (`Ploeg.response`).

    References
    ----------
    J. Ploeg et al., "Design and experimental evaluation of cooperative adaptive cruise control", 2011, DOI
    10.1109/ITSC.2011.6082981. Defaults: Plexe's ``examples/platooning``.
    """

    name: ClassVar[str] = "ploeg"
    needs: ClassVar[tuple[str, ...]] = ("gap_m", "ahead_speed_mps", "ahead_acceleration_mps2")

    headway_s: float = 0.5
    distance_gain: float = 0.2
    speed_gain: float = 0.7
    standstill_m: float = 2.0

    def __post_init__(self) -> None:
        for name in ("headway_s", "distance_gain", "speed_gain", "standstill_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    def acceleration(self, known: Following, dt_s: float) -> FloatArray:
        """The formula of the notes, one Euler step."""
        too_far_m = known.gap_m - self.gap_m(known.speed_mps)
        falling_back = known.ahead_speed_mps - known.speed_mps - self.headway_s * known.acceleration_mps2
        wanted = self.distance_gain * too_far_m + self.speed_gain * falling_back
        change = wanted + known.ahead_acceleration_mps2 - known.commanded_mps2
        return known.commanded_mps2 + change * (dt_s / self.headway_s)

    def gap_m(self, speed_mps: FloatArray) -> FloatArray:
        """Standstill gap and headway."""
        return self.standstill_m + self.headway_s * speed_mps

    def response(
        self, s: ComplexArray, ahead: ComplexArray, leader: ComplexArray, lag_s: float
    ) -> ComplexArray:
        """s² + kd s + kp over (h s + 1)(lag s³ + s² + kd s + kp), times the vehicle ahead."""
        del leader
        spring = self.speed_gain * s + self.distance_gain
        return ahead * (s**2 + spring) / ((self.headway_s * s + 1.0) * (lag_s * s**3 + s**2 + spring))

"""Intersection movement assist: two paths cross, and both vehicles would be there at the same time."""

from dataclasses import dataclass
from math import pi, sin
from typing import final

from modelcast.apps.base import refuse_negative
from modelcast.apps.compiled import AbstractCompiledApplication, reals
from modelcast.apps.intersection_kernels import Settings, assess
from modelcast.apps.pair_kernels import Columns, Found

__all__ = ["IntersectionAssist"]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class IntersectionAssist(AbstractCompiledApplication):
    """Cautions of a remote that would meet the host where paths cross; warns when the host must act now.

    Both drive on straight along their courses with their accelerations until they stand. Where the strips
    that they sweep overlap is the conflict area; each is in it from its front's arrival to its rear's
    leaving.

    Parameters
    ----------
    least_angle_rad
        Courses that differ from the same or the opposite one by less do not cross [rad].
    apart_s
        Stays in the conflict area that are apart by more are no conflict [s].
    longest_s
        Meetings that are farther ahead are left alone [s].
    delay_s
        Reaction of driver and brakes [s].
    braking_mps2
        Deceleration that the host's driver is to get along with [m/s²].

    Raises
    ------
    ValueError
        Where a setting is negative.

    Notes
    -----
    With φ the angle between the courses, the area reaches (w_R + w_H |cos φ|) / (2 |sin φ|) to either side of
    the crossing along the host's path. Margin: way to the area less what the host needs to stop; a conflict
    warns where it is not positive, also where the host can no longer stop. `Warnings.time_s` is when the
    later one arrives. The certainty takes the meeting itself as certain: stays apart by more than `apart_s`
    are no threat.

    References
    ----------
    Rule and numbers are this project's choice. The application, its scenarios (straight crossing paths) and
    the two levels, with warnings where paths and speeds still lead to a collision, are those of NHTSA's IMA:
    Azeredo, Tiernan, Najm, Test procedures with countermeasure timing constraints for intersection movement
    and left turn assist safety applications, 2021; Harding et al., Vehicle-to-vehicle communications:
    readiness of V2V technology for application, DOT HS 812 014, 2014.

    Examples
    --------
    >>> from modelcast.apps.motions import Motions
    >>> host = Motions.of([[0.0, -70.0], [0.0, -30.0]], speed_mps=14.0, heading_rad=0.0)
    >>> remote = Motions.of([[-70.0, 0.0], [-30.0, 0.0]], speed_mps=14.0, heading_rad=1.5707963)
    >>> IntersectionAssist().assess(host, remote).level
    array([1, 2])
    """

    least_angle_rad: float = pi / 6
    apart_s: float = 1.0
    longest_s: float = 8.0
    delay_s: float = 2.05
    braking_mps2: float = 3.5

    def __post_init__(self) -> None:
        refuse_negative(self)
        if not 0.0 < self.least_angle_rad <= pi / 2:
            raise ValueError(f"least_angle_rad must be in (0, pi/2], got {self.least_angle_rad}")
        if not self.braking_mps2 > 0.0:
            raise ValueError(f"braking_mps2 must be positive, got {self.braking_mps2}")

    def fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""
        settings = Settings(
            sin(self.least_angle_rad), self.apart_s, self.longest_s, self.delay_s, self.braking_mps2
        )
        assess(reals(settings), host, remote, found)

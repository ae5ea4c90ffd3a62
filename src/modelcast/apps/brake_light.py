"""Emergency electronic brake light: somebody ahead brakes hard, seen or not."""

from dataclasses import dataclass
from math import cos, pi
from typing import final

from modelcast.apps.base import refuse_negative
from modelcast.apps.brake_light_kernels import Settings, assess
from modelcast.apps.compiled import AbstractCompiledApplication, reals
from modelcast.apps.pair_kernels import Columns, Found, Lane

__all__ = ["BrakeLight"]

_GRAVITY_MPS2 = 9.80665


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeLight(AbstractCompiledApplication):
    """Cautions of a remote ahead that brakes hard, in path or beside; warns where the host must brake.

    Ahead, and along the path, are as in `modelcast.apps.forward_collision.ForwardCollisionWarning`.

    Parameters
    ----------
    hard_braking_mps2
        Deceleration from which a remote brakes hard: 0.4 g, a hard-braking event [m/s²].
    delay_s
        Reaction of driver and brakes [s].
    braking_mps2
        Deceleration that the host's driver is to get along with [m/s²].
    lane_half_width_m
        Offset up to which a remote is in path [m].
    beside_m
        Offset up to which it is in or beside it: the lanes next to it [m].
    longest_gap_m
        Beyond it nothing is said [m].
    heading_tolerance_rad, straight_below_mps
        As in `ForwardCollisionWarning`.

    Raises
    ------
    ValueError
        Where a setting is negative.

    Notes
    -----
    Margin: gap less what the host closes until the two are nearest, if it brakes by `braking_mps2` after the
    delay and the remote goes on braking until it stands. It is infinite for remotes beside the path. The
    delay is CAMP's of the forward collision warning, 0.35 g this project's choice of a braking that is not
    yet hard.

    References
    ----------
    SAE J2945/1 (event hard braking: above 0.4 g); the use case is that of CAMP's Vehicle Safety
    Communications Applications, DOT HS 811 492B, 2011.

    Examples
    --------
    >>> from modelcast.apps.motions import Motions
    >>> host = Motions.of([[0.0, 0.0]] * 3, speed_mps=20.0, heading_rad=0.0)
    >>> remote = Motions.of(
    ...     [[0.0, 50.0], [0.0, 120.0], [3.5, 50.0]], speed_mps=15.0, heading_rad=0.0, acceleration_mps2=-5.0
    ... )
    >>> BrakeLight().assess(host, remote).level
    array([2, 1, 1])
    """

    hard_braking_mps2: float = 0.4 * _GRAVITY_MPS2
    delay_s: float = 2.05
    braking_mps2: float = 0.35 * _GRAVITY_MPS2
    lane_half_width_m: float = 1.8
    beside_m: float = 5.4
    longest_gap_m: float = 300.0
    heading_tolerance_rad: float = pi / 4
    straight_below_mps: float = 2.0

    def __post_init__(self) -> None:
        refuse_negative(self)
        if not self.braking_mps2 > 0.0:
            raise ValueError(f"braking_mps2 must be positive, got {self.braking_mps2}")

    def fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""
        cosine = cos(min(self.heading_tolerance_rad, pi))
        lane = Lane(self.beside_m, self.longest_gap_m, cosine, self.straight_below_mps)
        settings = Settings(self.hard_braking_mps2, self.delay_s, self.braking_mps2, self.lane_half_width_m)
        assess(reals(settings), reals(lane), host, remote, found)

"""Forward collision warning: the vehicle ahead in the host's path is within a published warning range."""

from dataclasses import KW_ONLY, dataclass
from math import cos, pi
from typing import cast, final

from modelcast.apps.base import refuse_negative
from modelcast.apps.compiled import AbstractCompiledApplication, reals
from modelcast.apps.forward_collision_kernels import assess
from modelcast.apps.pair_kernels import Columns, Found, Lane
from modelcast.apps.warning_ranges import AbstractWarningRange, CampLinear

__all__ = ["ForwardCollisionWarning"]


@final
@dataclass(frozen=True, slots=True)
class ForwardCollisionWarning(AbstractCompiledApplication):
    """Warns where the gap to a remote in path is not above the warning range; cautions a little earlier.

    A remote is in path where its middle lies ahead on the host's path of constant curvature, its offset from
    it is at most half a lane and its course is nearly the path's. The gap runs along the path, bumper to
    bumper.

    Parameters
    ----------
    algorithm
        Where it warns.
    lane_half_width_m
        Half a lane [m].
    longest_gap_m
        Beyond it a remote is no threat [m].
    heading_tolerance_rad
        Between the remote's course and the path's, at most pi [rad].
    straight_below_mps
        A slower host's path counts as straight: its yaw rate says little [m/s].
    caution_s
        How long before the warning, at the present closing speed, the caution comes [s].

    Raises
    ------
    ValueError
        Where a setting is negative.

    Notes
    -----
    Margin: gap less warning range. Its deviation is that of both places along the path; offset, speeds and
    accelerations count as exact.

    Examples
    --------
    >>> from modelcast.apps.motions import Motions
    >>> host = Motions.of([[0.0, 0.0]] * 2, speed_mps=[20.0] * 2, heading_rad=[0.0] * 2)
    >>> remote = Motions.of([[0.0, 60.0], [0.0, 160.0]], speed_mps=[0.0] * 2, heading_rad=[0.0] * 2)
    >>> ForwardCollisionWarning().assess(host, remote).level
    array([2, 0])
    """

    algorithm: AbstractWarningRange = CampLinear()  # noqa: RUF009 - it is frozen
    _: KW_ONLY
    lane_half_width_m: float = 1.8
    longest_gap_m: float = 200.0
    heading_tolerance_rad: float = pi / 4
    straight_below_mps: float = 2.0
    caution_s: float = 1.0

    def __post_init__(self) -> None:
        refuse_negative(self)
        given = cast("object", self.algorithm)  # a command line may set anything
        if not isinstance(given, AbstractWarningRange):
            raise TypeError(f"algorithm must be a warning range, got {given!r}")

    def fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""
        lane = Lane(
            self.lane_half_width_m,
            self.longest_gap_m,
            cos(min(self.heading_tolerance_rad, pi)),
            self.straight_below_mps,
        )
        assess(self.algorithm.rule, reals(lane), self.caution_s, host, remote, found)

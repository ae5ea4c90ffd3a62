"""Vulnerable road user warning: a vehicle and a person would meet, and one of them must act now."""

from dataclasses import dataclass
from typing import ClassVar, final

from modelcast.apps.base import refuse_negative
from modelcast.apps.compiled import AbstractCompiledApplication, reals
from modelcast.apps.pair_kernels import Columns, Found
from modelcast.apps.vulnerable_road_user_kernels import Settings, assess

__all__ = ["VulnerableRoadUserWarning"]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class VulnerableRoadUserWarning(AbstractCompiledApplication):
    """Cautions where a person would be on a vehicle's path when it comes; warns when the host must act now.

    One of each pair is a person (`modelcast.core.kinds.PEOPLE`), the other a vehicle; of other pairs nothing
    is said. The vehicle goes on along its path of constant curvature with its acceleration, the person
    straight on at constant speed, for it may stop within a step. The person is on the path while its
    rectangle is in the strip that the vehicle sweeps, ``aside_m`` wider on either side. In the vehicle the
    margin is the gap less the way that it needs to stop for the person, as in a forward collision warning; on
    the person's side, the way to the strip less the way that the person needs to stop before it.

    Parameters
    ----------
    aside_m
        Room that a vehicle keeps to people beside it [m].
    apart_s
        A person who leaves the path longer before the vehicle comes, or enters it longer after the vehicle is
        gone, does not meet it [s].
    longest_s
        Meetings that are farther ahead are left alone [s].
    straight_below_mps
        A slower vehicle's path counts as straight: its yaw rate says little [m/s].
    delay_s, braking_mps2
        Reaction of driver and brakes, and the deceleration that is to be enough [s], [m/s²].
    person_delay_s, person_braking_mps2
        The same of the person.

    Raises
    ------
    ValueError
        Where a setting is negative, or a deceleration is not positive.

    Notes
    -----
    With the person's place (way x, offset y) along the path, its velocity (u, w) there and the half sizes of
    both, the vehicle is beside the person from (x - half) to (x + half) at closing speed v - u, and the
    person in the strip while |y + w t| <= reach. A warning where the margin is not positive. On the person's
    side the deviation of the margin is that of the vehicle's place across its path; of who is in the strip
    already it is none.

    References
    ----------
    Who meets whom: the crossing and longitudinal scenarios of Euro NCAP, Test protocol - AEB/LSS VRU systems
    (pedestrians crossing from the far side, from the near side and from behind an obstruction, and walking
    along; bicyclists crossing and riding along). Delay and deceleration are those of the driver that brakes
    after a forward collision warning in its car-to-car protocol, 1.2 s and 4 m/s², from memory of that
    protocol, which was not at hand. The other numbers and the rule are ours.

    Examples
    --------
    >>> from modelcast.apps.motions import Motions
    >>> from modelcast.core.kinds import Kind
    >>> host = Motions.of([[0.0, -50.0], [0.0, -30.0]], speed_mps=13.9, heading_rad=0.0)
    >>> walks = Motions.of(
    ...     [[4.8, 0.0], [2.9, 0.0]], speed_mps=1.39, heading_rad=-1.5707963,
    ...     length_m=0.6, width_m=0.5, kind=Kind.PEDESTRIAN,
    ... )
    >>> VulnerableRoadUserWarning().assess(host, walks).level
    array([1, 2])
    >>> VulnerableRoadUserWarning().assess(walks, host).level
    array([1, 2])
    """

    of_people: ClassVar[bool] = True

    aside_m: float = 0.3
    apart_s: float = 1.0
    longest_s: float = 5.0
    straight_below_mps: float = 2.0
    delay_s: float = 1.2
    braking_mps2: float = 4.0
    person_delay_s: float = 1.0
    person_braking_mps2: float = 2.0

    def __post_init__(self) -> None:
        refuse_negative(self)
        for name in ("braking_mps2", "person_braking_mps2"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    def fill(self, host: Columns, remote: Columns, found: Found) -> None:
        """Write what is found, every row of it."""
        settings = Settings(
            self.aside_m,
            self.apart_s,
            self.longest_s,
            self.straight_below_mps,
            self.delay_s,
            self.braking_mps2,
            self.person_delay_s,
            self.person_braking_mps2,
        )
        assess(reals(settings), host, remote, found)

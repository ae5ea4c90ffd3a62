"""B platoons of N vehicles on straight roads of their own, as frames of a fleet."""

from dataclasses import KW_ONLY, dataclass, field
from math import pi

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.platoon.dynamics import Drive, PlatoonState
from modelcast.world.scenario.base import FleetFrame

__all__ = ["Platoons"]


@dataclass(frozen=True, slots=True)
class Platoons:
    """What does not change of B platoons; the vehicle in place i of platoon b has slot b N + i.

    All drive east, on roads so far apart that platoons do not hear each other.

    Parameters
    ----------
    count, vehicles
        B, and N with the leader.
    length_m
        Of a vehicle; 4 m as in Plexe's example [m].
    apart_m
        Between two roads [m].
    drive
        Drive and brakes of the followers.

    Raises
    ------
    ValueError
        Where there is no platoon, or nobody follows.

    Examples
    --------
    >>> two = Platoons(2, 3)
    >>> state = two.init(np.full((2, 2), 5.0), 20.0)
    >>> two.gap_m(state).tolist()
    [[5.0, 5.0], [5.0, 5.0]]
    >>> two.frame(state).position_m[:3].tolist()
    [[0.0, 0.0], [-9.0, 0.0], [-18.0, 0.0]]
    """

    count: int
    vehicles: int
    _: KW_ONLY
    length_m: float = 4.0
    apart_m: float = 3000.0
    drive: Drive = field(default_factory=Drive)

    def __post_init__(self) -> None:
        if self.count < 1 or self.vehicles < 2:
            raise ValueError(
                f"there must be a platoon of two vehicles or more, got {self.count} of {self.vehicles}"
            )
        for name in ("length_m", "apart_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    def init(self, gap_m: FloatArray, speed_mps: float) -> PlatoonState:
        """Platoons at t = 0, all at one speed.

        Parameters
        ----------
        gap_m
            Between each follower and the vehicle ahead, (B, N - 1) [m].
        speed_mps
            Of all [m/s].
        """
        still = np.zeros((self.count, self.vehicles))
        behind = np.zeros_like(still)
        behind[:, 1:] = np.cumsum(gap_m + self.length_m, axis=1)
        return PlatoonState(
            0.0,
            0.0 - behind,
            speed_mps=still + speed_mps,
            acceleration_mps2=still,
            commanded_mps2=still.copy(),
        )

    @property
    def pairs(self) -> tuple[IntArray, IntArray, IntArray]:
        """Slots of all followers, of the vehicle ahead of each, and of its leader, (B (N - 1),) each."""
        slots = np.arange(self.count * self.vehicles, dtype=np.int64).reshape(self.count, self.vehicles)
        leader = np.repeat(slots[:, 0], self.vehicles - 1)
        return slots[:, 1:].ravel(), slots[:, :-1].ravel(), leader

    def gap_m(self, state: PlatoonState) -> FloatArray:
        """Gap before each follower, negative where it has run into the vehicle ahead, (B, N - 1) [m].

        Parameters
        ----------
        state
            The platoons.
        """
        return state.along_m[:, :-1] - state.along_m[:, 1:] - self.length_m

    def frame(self, state: PlatoonState) -> FleetFrame:
        """All vehicles of all platoons.

        Parameters
        ----------
        state
            The platoons.
        """
        slots = self.count * self.vehicles
        place = np.empty((slots, 2))
        place[:, 0] = state.along_m.ravel()
        place[:, 1] = np.repeat(np.arange(self.count) * self.apart_m, self.vehicles)
        return FleetFrame(
            state.t_s,
            place,
            speed_mps=state.speed_mps.ravel().copy(),
            heading_rad=np.full(slots, 0.5 * pi),
            acceleration_mps2=state.acceleration_mps2.ravel().copy(),
            yaw_rate_radps=np.zeros(slots),
            length_m=np.full(slots, self.length_m),
            vehicle_id=np.arange(slots, dtype=np.int64),
            active=np.ones(slots, dtype=np.bool_),
        )

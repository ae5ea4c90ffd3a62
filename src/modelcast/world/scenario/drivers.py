"""Who drives: a population of drivers and vehicles, and one draw of it."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.world.scenario import following_kernels as kernels

__all__ = ["CITY", "HIGHWAY", "STREAM", "UNIFORM", "Drivers"]


@dataclass(frozen=True, slots=True)
class Drivers:
    """A population of drivers; a range (low, high) is drawn from evenly.

    The default ranges lie around the values of Treiber and Kesting, Traffic Flow Dynamics (2013), table 11.2
    (v0 120 km/h, T 1.0 s, s0 2 m, a 1.0 m/s², b 1.5 m/s²); the spread is ours.

    Parameters
    ----------
    desired_speed_mps
        Mean v0 on a free road [m/s].
    desired_speed_spread_ratio
        Standard deviation of v0 over its mean; drawn from a normal law cut at two deviations.
    headway_s
        Range of T [s].
    acceleration_mps2, braking_mps2
        Ranges of a and of the comfortable b.
    gap_m
        Gap at standstill s0 [m].
    length_m
        Range of car lengths [m].
    politeness
        Weight of other drivers' acceleration in a lane change, p of MOBIL.
    truck_ratio
        Share of trucks: 10 to 16 m long, v0 of 24 m/s at most, half the acceleration, T 1.2 times as long.
    pedal_noise_mps2
        Unsteadiness of the pedal: standard deviation [m/s²], correlation time 3 s. Ours.
    wander_m
        Lane-keeping error, standard deviation [m]. On roads 0.15 to 0.25 m is usual; ours.
    perception_noise
        How far drivers err in gaps and approach rates: 1 is the human driver model's size, 0 is exact.

    Raises
    ------
    ValueError
        Where a range is empty or a value has the wrong sign.
    """

    desired_speed_mps: float = 33.3
    desired_speed_spread_ratio: float = 0.1
    _: KW_ONLY
    headway_s: tuple[float, float] = (0.9, 1.7)
    acceleration_mps2: tuple[float, float] = (1.0, 1.8)
    braking_mps2: tuple[float, float] = (1.4, 2.4)
    gap_m: float = 2.0
    length_m: tuple[float, float] = (4.0, 5.0)
    politeness: float = 0.2
    truck_ratio: float = 0.1
    pedal_noise_mps2: float = 0.15
    wander_m: float = 0.15
    perception_noise: float = 1.0

    def __post_init__(self) -> None:
        for name in ("headway_s", "acceleration_mps2", "braking_mps2", "length_m"):
            low, high = getattr(self, name)
            if not 0.0 < low <= high:
                raise ValueError(f"{name} must be a range of positive numbers, low first: ({low}, {high})")
        for name in ("desired_speed_mps", "gap_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        for name in ("politeness", "pedal_noise_mps2", "wander_m", "perception_noise"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be at least 0, got {getattr(self, name)}")
        for name, bound in (("truck_ratio", 1.0), ("desired_speed_spread_ratio", 0.4)):
            if not 0.0 <= getattr(self, name) <= bound:
                raise ValueError(f"{name} must lie in 0..{bound}, got {getattr(self, name)}")

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return the traits of some drivers, (TRAITS, count), rows as in `following_kernels`.

        Parameters
        ----------
        count
            How many.
        rng
            Source of the draw.
        """
        traits = np.zeros((kernels.TRAITS, count))
        spread = np.clip(rng.standard_normal(count), -2.0, 2.0) * self.desired_speed_spread_ratio
        truck = rng.random(count) < self.truck_ratio
        traits[kernels.DESIRED_SPEED] = self.desired_speed_mps * (1.0 + spread)
        traits[kernels.HEADWAY] = rng.uniform(*self.headway_s, count) * np.where(truck, 1.2, 1.0)
        traits[kernels.ACCEL] = rng.uniform(*self.acceleration_mps2, count) * np.where(truck, 0.5, 1.0)
        traits[kernels.BRAKE] = rng.uniform(*self.braking_mps2, count)
        traits[kernels.GAP] = self.gap_m
        traits[kernels.LENGTH] = np.where(
            truck, rng.uniform(10.0, 16.0, count), rng.uniform(*self.length_m, count)
        )
        traits[kernels.POLITENESS] = self.politeness
        slow = np.minimum(traits[kernels.DESIRED_SPEED], 24.0 * (1.0 + 0.3 * spread))
        traits[kernels.DESIRED_SPEED] = np.where(truck, slow, traits[kernels.DESIRED_SPEED])
        return traits


HIGHWAY = Drivers()
"""Mixed traffic on a road without a speed limit that binds."""

CITY = Drivers(13.9, 0.08, length_m=(4.0, 4.8), truck_ratio=0.0, wander_m=0.1)
"""Cars in streets with a limit of 50 km/h."""

STREAM = Drivers(30.0, 0.03, headway_s=(0.8, 1.6), truck_ratio=0.0)
"""Cars that follow each other closely at one speed; the time gaps are those of dense motorway traffic."""

UNIFORM = Drivers(
    desired_speed_spread_ratio=0.0,
    headway_s=(1.3, 1.3),
    acceleration_mps2=(1.4, 1.4),
    braking_mps2=(2.0, 2.0),
    length_m=(4.5, 4.5),
    truck_ratio=0.0,
    pedal_noise_mps2=0.0,
    wander_m=0.0,
    perception_noise=0.0,
)
"""Drivers all alike and without error: what closed forms are about."""

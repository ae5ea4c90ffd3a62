"""Who walks and who rides: a population of pedestrians and cyclists, and one draw of it."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.kinds import CYCLIST_M
from modelcast.world.scenario.bounds import check_positive, check_range
from modelcast.world.scenario.drivers import Drivers

__all__ = ["RIDERS", "Pedestrians"]

_DEVIATIONS = 2.5


@dataclass(frozen=True, slots=True)
class Pedestrians:
    """A population of pedestrians; a range (low, high) is drawn from evenly.

    Parameters
    ----------
    speed_mps, speed_spread_mps
        Mean and standard deviation of the free walking speed, normal, cut at 2.5 deviations [m/s]: Weidmann,
        Transporttechnik der Fussgänger, ETH Zürich 1993, doi:10.3929/ethz-a-000687810.
    pace_noise_ratio
        Unsteadiness: standard deviation over the speed, correlation time 3 s. Ours.
    aside_m
        How far to either side of the footway's middle somebody walks [m].
    patience_s
        Who waited so long at a kerb turns back [s]. Ours.
    turns_back_per_minute
        How often somebody on a pavement turns back [1/min]. Ours.
    careless_ratio
        Share of crossings at which somebody steps out as soon as every vehicle can still stop at 4 m/s², and
        does not mind a signal. Ours.
    spare_s
        Start and safety in the critical gap of others [s]: crossing time plus 3 s, Highway Capacity Manual
        2010, two-way stop control, pedestrian mode.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    speed_mps: float = 1.34
    speed_spread_mps: float = 0.26
    _: KW_ONLY
    pace_noise_ratio: float = 0.06
    aside_m: float = 1.2
    patience_s: tuple[float, float] = (30.0, 90.0)
    turns_back_per_minute: float = 0.2
    careless_ratio: float = 0.1
    spare_s: float = 3.0

    def __post_init__(self) -> None:
        check_positive(self, "speed_mps", "spare_s")
        check_range(self, "patience_s", 0.0, 3600.0)
        for name, most in (
            ("speed_spread_mps", 0.35 * self.speed_mps),
            ("pace_noise_ratio", 0.3),
            ("aside_m", 1.4),
            ("turns_back_per_minute", 60.0),
            ("careless_ratio", 1.0),
        ):
            if not 0.0 <= getattr(self, name) <= most:
                raise ValueError(f"{name} must lie in 0..{most:g}, got {getattr(self, name)}")

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return the traits of some pedestrians: free speed, two offsets, patience, (4, count).

        Parameters
        ----------
        count
            How many.
        rng
            Source of the draw.
        """
        spread = np.clip(rng.standard_normal(count), -_DEVIATIONS, _DEVIATIONS)
        return np.stack(
            [
                self.speed_mps + self.speed_spread_mps * spread,
                *rng.uniform(-self.aside_m, self.aside_m, (2, count)),
                rng.uniform(*self.patience_s, count),
            ]
        )


RIDERS = Drivers(
    6.0,
    0.15,
    headway_s=(0.8, 1.4),
    acceleration_mps2=(0.6, 1.0),
    braking_mps2=(1.0, 1.6),
    gap_m=0.6,
    length_m=(CYCLIST_M[0], CYCLIST_M[0]),
    truck_ratio=0.0,
    pedal_noise_mps2=0.1,
    wander_m=0.1,
    perception_noise=0.0,
)
"""Cyclists: 21.6 km/h on the flat, Parkin and Rotheram 2010, doi:10.1016/j.tranpol.2010.03.001; the spread
and the rest are ours."""

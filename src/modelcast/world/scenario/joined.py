"""Two scenarios side by side, on one clock: they do not see each other."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.world.scenario.base import NOBODY, AbstractScenario, FleetFrame

__all__ = ["Joined"]


@dataclass(frozen=True, slots=True)
class Joined(AbstractScenario[tuple[Any, Any]]):
    """All of one scenario's slots, then all of another's.

    Identifiers of the first are even, those of the second odd.

    Parameters
    ----------
    first, second
        The scenarios.

    Examples
    --------
    >>> from modelcast.world.scenario.highway import Highway
    >>> Joined(Highway(1000.0, 20.0), Highway(500.0, 20.0)).slots
    30
    """

    first: AbstractScenario[Any]
    second: AbstractScenario[Any]

    @property
    def slots(self) -> int:
        """Number of slots V of both."""
        return self.first.slots + self.second.slots

    def init(self, rng: np.random.Generator) -> tuple[Any, Any]:
        """Return the states of both; each draws by a generator of its own."""
        own, other = rng.spawn(2)
        return self.first.init(own), self.second.init(other)

    def step(self, state: tuple[Any, Any]) -> tuple[Any, Any]:
        """Return both states a step later."""
        return self.first.step(state[0]), self.second.step(state[1])

    def frame(self, state: tuple[Any, Any]) -> FleetFrame:
        """Return all slots of both."""
        both = (self.first.frame(state[0]), self.second.frame(state[1]))

        def column(name: str) -> Any:
            return np.concatenate([getattr(one, name) for one in both])

        return FleetFrame(
            both[0].t_s,
            column("position_m"),
            speed_mps=column("speed_mps"),
            heading_rad=column("heading_rad"),
            acceleration_mps2=column("acceleration_mps2"),
            yaw_rate_radps=column("yaw_rate_radps"),
            length_m=column("length_m"),
            vehicle_id=np.concatenate(
                [np.where(one.active, 2 * one.vehicle_id + at, NOBODY) for at, one in enumerate(both)]
            ),
            active=column("active"),
            kind=np.concatenate([_kinds(one) for one in both]),
            width_m=np.concatenate([_widths(one) for one in both]),
        )


def _kinds(frame: FleetFrame) -> IntArray:
    """Kinds, also where all are vehicles, (V,)."""
    return np.zeros(len(frame), dtype=np.int64) if frame.kind is None else frame.kind


def _widths(frame: FleetFrame) -> FloatArray:
    """Widths, also where all are as wide as a car, (V,)."""
    return np.full(len(frame), SIZES_M[Kind.VEHICLE][1]) if frame.width_m is None else frame.width_m

"""What a scenario is: the state of a fleet every 0.1 s, as arrays over slots.

A fleet has a fixed number of slots V. A slot holds one vehicle at a time; where a vehicle leaves and another
takes its slot, `FleetFrame.vehicle_id` changes there, and whoever keeps state by slot begins anew. An
identifier is never used twice in a run.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["NOBODY", "STEP_S", "AbstractScenario", "FleetFrame", "run_scenario"]

STEP_S = 0.1
"""Time between frames [s]: the rate of GPS and of the basic safety message."""

NOBODY = -1
"""Identifier in a slot that holds no vehicle."""

State = TypeVar("State")


@dataclass(frozen=True, slots=True)
class FleetFrame:
    """All vehicles of a fleet at one instant; positions are those of the vehicles' middles.

    Parameters
    ----------
    t_s
        Time from the start of the run [s].
    position_m
        East and north, (V, 2) [m].
    speed_mps
        Speed over ground, never negative, (V,) [m/s].
    heading_rad
        Course, clockwise from north, in [-pi, pi), (V,) [rad].
    acceleration_mps2
        Acceleration along the course, (V,) [m/s²].
    yaw_rate_radps
        Rate of the course, clockwise, (V,) [rad/s].
    length_m
        Length of each vehicle, (V,) [m].
    vehicle_id
        Who is in the slot, `NOBODY` where nobody is, (V,).
    active
        Which slots hold a vehicle, (V,). Columns of other slots are zero.
    begins
        Whose measurement does not connect with the last, as after a jump of a receiver, (V,); None for
        nobody's. Gaps in time are seen by themselves.
    kind
        Of each road user, values of `Kind`, (V,); None where all are vehicles.
    width_m
        Of each road user, (V,) [m]; None where all are as wide as a car.

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    t_s: float
    position_m: FloatArray
    _: KW_ONLY
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    length_m: FloatArray
    vehicle_id: IntArray
    active: BoolArray
    begins: BoolArray | None = None
    kind: IntArray | None = None
    width_m: FloatArray | None = None

    def __post_init__(self) -> None:
        shape = self.active.shape
        if self.position_m.shape != (*shape, 2) or len(shape) != 1:
            raise ValueError(f"position_m must have shape {(*shape, 2)}, got {self.position_m.shape}")
        for name in ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps", "length_m"):
            column: FloatArray = getattr(self, name)
            if column.shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {column.shape}")
        if self.vehicle_id.shape != shape:
            raise ValueError(f"vehicle_id must have shape {shape}, got {self.vehicle_id.shape}")
        for name in ("begins", "kind", "width_m"):
            optional: np.ndarray[Any, Any] | None = getattr(self, name)
            if optional is not None and optional.shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {optional.shape}")

    def __len__(self) -> int:
        return int(self.active.size)


class AbstractScenario(ABC, Generic[State]):
    """Traffic that moves by itself.

    All of a run's randomness comes from one generator, which the state holds: same generator, same bytes.
    """

    @property
    @abstractmethod
    def slots(self) -> int:
        """Number of slots V."""

    @abstractmethod
    def init(self, rng: np.random.Generator) -> State:
        """State at t = 0.

        Parameters
        ----------
        rng
            Source of all randomness of the run; the state keeps it.
        """

    @abstractmethod
    def frame(self, state: State) -> FleetFrame:
        """Return the fleet as the state has it.

        Parameters
        ----------
        state
            As `init` or `step` gave it.
        """

    @abstractmethod
    def step(self, state: State) -> State:
        """Return the state `STEP_S` later; the given one keeps its arrays, and its generator moves on.

        Parameters
        ----------
        state
            As `init` or `step` gave it.
        """


def run_scenario(
    scenario: AbstractScenario[State], rng: np.random.Generator, *, duration_s: float
) -> Iterator[FleetFrame]:
    """Yield a scenario's frames from t = 0 up to, not including, a duration.

    Parameters
    ----------
    scenario
        Any scenario.
    rng
        Source of all randomness of the run.
    duration_s
        Length of the run [s].

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.world.scenario.highway import Highway
    >>> road = Highway(length_m=1000.0, density_per_km=20.0, warm_up_s=0.0)
    >>> frames = list(run_scenario(road, np.random.default_rng(1), duration_s=1.0))
    >>> len(frames), frames[3].t_s, frames[0].position_m.shape
    (10, 0.3, (20, 2))
    """
    state = scenario.init(rng)
    for number in range(round(duration_s / STEP_S)):
        if number:
            state = scenario.step(state)
        yield scenario.frame(state)

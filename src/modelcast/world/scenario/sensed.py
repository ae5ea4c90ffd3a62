"""What the vehicles of a fleet see of themselves: `modelcast.world.sensors.Sensors` over frames."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.world.scenario.base import NOBODY, FleetFrame
from modelcast.world.sensor_kernels import NEW, PART, Samples
from modelcast.world.sensors import SensorModel, Sensors, SensorState

__all__ = ["FleetSensor", "FleetSensorState", "sensed"]


@dataclass(frozen=True, slots=True)
class FleetSensorState:
    """Sensors of a fleet between two frames.

    Parameters
    ----------
    vehicle_id
        Who was in each slot, (V,).
    sensors
        Their errors, what the latency still needs, and the source of all noise.
    """

    vehicle_id: IntArray
    sensors: SensorState


@dataclass(frozen=True, slots=True)
class FleetSensor:
    """Receivers and vehicle buses of a fleet, all of one model.

    Parameters
    ----------
    model
        The errors.
    """

    model: SensorModel

    def init(self, slots: int, rng: np.random.Generator) -> FleetSensorState:
        """State before the first frame.

        Parameters
        ----------
        slots
            Number of slots V.
        rng
            Source of all noise; the state keeps it.
        """
        vehicle_id = np.full(slots, NOBODY, dtype=np.int64)
        return FleetSensorState(vehicle_id, Sensors(self.model).init(slots, rng))

    def sense(self, state: FleetSensorState, frame: FleetFrame) -> tuple[FleetFrame, FleetSensorState]:
        """Return what the vehicles see at the time of a frame, and the next state.

        Parameters
        ----------
        state
            As `init` or `sense` gave it.
        frame
            The truth, later than the last.

        Returns
        -------
        FleetFrame
            With the truth's time, identifiers and lengths, and what `Sensors` show. A vehicle that takes over
            a slot begins with errors of its own.

        Raises
        ------
        ValueError
            Where the number of slots differs, or time does not increase.
        """
        if len(frame) != state.vehicle_id.size or not frame.t_s > state.sensors.t_s:
            raise ValueError(
                f"frame must have {state.vehicle_id.size} slots and be later than {state.sensors.t_s} s, "
                f"got {len(frame)} slots at {frame.t_s} s"
            )
        columns = (frame.speed_mps, frame.heading_rad, frame.acceleration_mps2, frame.yaw_rate_radps)
        begins = np.zeros((1, len(frame)), dtype=np.uint8)
        if frame.begins is not None:
            begins[0, frame.begins] = PART
        begins[0, frame.vehicle_id != state.vehicle_id] = NEW
        motion = np.column_stack((frame.position_m, *columns))[None]
        samples = Samples(np.array([frame.t_s]), motion, begins, np.ascontiguousarray(frame.active)[None])
        (seen,), after = Sensors(self.model).sense(state.sensors, samples)
        shown = np.ascontiguousarray(seen.T)
        found = replace(
            frame,
            position_m=np.ascontiguousarray(seen[:, :2]),
            speed_mps=shown[2],
            heading_rad=shown[3],
            acceleration_mps2=shown[4],
            yaw_rate_radps=shown[5],
        )
        return found, FleetSensorState(frame.vehicle_id, after)


def sensed(
    frames: Iterable[FleetFrame], model: SensorModel, rng: np.random.Generator
) -> Iterator[tuple[FleetFrame, FleetFrame]]:
    """Yield every frame with what its vehicles see.

    Parameters
    ----------
    frames
        Frames of one run.
    model
        The errors.
    rng
        Source of all noise.

    Yields
    ------
    tuple
        Truth, seen.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.world.sensors import IDEAL
    >>> from modelcast.world.scenario.base import run_scenario
    >>> from modelcast.world.scenario.highway import Highway
    >>> frames = run_scenario(Highway(warm_up_s=0.0), np.random.default_rng(1), duration_s=0.5)
    >>> all((t.position_m == s.position_m).all() for t, s in sensed(frames, IDEAL, np.random.default_rng(2)))
    True
    """
    sensor = FleetSensor(model)
    state: FleetSensorState | None = None
    for frame in frames:
        state = sensor.init(len(frame), rng) if state is None else state
        seen, state = sensor.sense(state, frame)
        yield frame, seen

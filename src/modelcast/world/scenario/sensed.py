"""What the vehicles of a fleet see of themselves: `SensorModel` over frames, all vehicles at once.

The errors are those of `modelcast.world.sensors.sense`, in batch form: one generator a fleet, the same number
of draws each step whatever the model, so two models seen through generators of one seed differ by their
sizes only. A vehicle that takes over a slot begins with errors of its own.
"""

from collections.abc import Iterable, Iterator
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.world.scenario.base import NOBODY, FleetFrame
from modelcast.world.sensors import HEADING_HOLD_MPS, SensorModel

__all__ = ["FleetSensor", "FleetSensorState", "sensed"]

_DRAWS = 10


@dataclass(frozen=True, slots=True)
class FleetSensorState:
    """Sensors of a fleet between two frames.

    Parameters
    ----------
    vehicle_id
        Who was in each slot, (V,).
    slow
        Slow position error over its standard deviation, (V, 2).
    heading_rad
        Heading last shown, held by slow vehicles, (V,) [rad].
    t_s
        Time of the last frame [s].
    recent
        Frames of the last `latency_s`, oldest first.
    rng
        Source of all noise.
    """

    vehicle_id: IntArray
    slow: FloatArray
    _: KW_ONLY
    heading_rad: FloatArray
    t_s: float
    recent: tuple[FleetFrame, ...]
    rng: np.random.Generator


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
        return FleetSensorState(
            np.full(slots, NOBODY, dtype=np.int64),
            np.zeros((slots, 2)),
            heading_rad=np.zeros(slots),
            t_s=-np.inf,
            recent=(),
            rng=rng,
        )

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
            With the truth's time, identifiers and lengths. Delayed by linear interpolation; a vehicle shows
            its first frame until the latency is over. Speed is never negative; below `HEADING_HOLD_MPS` the
            heading keeps its last value, noise included.

        Raises
        ------
        ValueError
            Where the number of slots differs, or time does not increase.
        """
        if len(frame) != state.vehicle_id.size or not frame.t_s > state.t_s:
            raise ValueError(
                f"frame must have {state.vehicle_id.size} slots and be later than {state.t_s} s, "
                f"got {len(frame)} slots at {frame.t_s} s"
            )
        model = self.model
        noise = state.rng.standard_normal((_DRAWS, len(frame)))
        recent = _kept(state.recent, frame, model.latency_s)
        seen = _delayed(recent, frame.t_s - model.latency_s) if model.latency_s > 0.0 else frame
        fresh = frame.vehicle_id != state.vehicle_id
        slow = _advanced(state.slow, frame.t_s - state.t_s, model.slow_correlation_s, noise[2:4].T)
        slow = np.where(fresh[:, None], noise[8:10].T, slow)  # a new vehicle begins with one of its own
        course = wrap_angle_rad(seen.heading_rad + model.heading_noise_rad * noise[5])
        heading = np.where((seen.speed_mps >= HEADING_HOLD_MPS) | fresh, course, state.heading_rad)
        heading = np.where(frame.active, heading, 0.0)
        here = frame.active
        shown = replace(
            seen,
            position_m=seen.position_m
            + here[:, None] * (model.position_noise_m * noise[0:2].T + model.slow_position_noise_m * slow),
            speed_mps=np.maximum(seen.speed_mps + here * model.speed_noise_mps * noise[4], 0.0),
            heading_rad=heading,
            acceleration_mps2=seen.acceleration_mps2 + here * model.acceleration_noise_mps2 * noise[6],
            yaw_rate_radps=seen.yaw_rate_radps + here * model.yaw_rate_noise_radps * noise[7],
        )
        after = replace(
            state, vehicle_id=frame.vehicle_id, slow=slow, heading_rad=heading, t_s=frame.t_s, recent=recent
        )
        return shown, after


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


def _advanced(slow: FloatArray, elapsed_s: float, correlation_s: float, noise: FloatArray) -> FloatArray:
    """Return the slow errors after a step of the Gauss-Markov process."""
    kept = float(np.exp(-elapsed_s / correlation_s))
    return kept * slow + np.sqrt(1.0 - kept**2) * noise


def _kept(recent: tuple[FleetFrame, ...], frame: FleetFrame, latency_s: float) -> tuple[FleetFrame, ...]:
    """Return the frames that are still needed, the new one last; one of them is older than the latency."""
    if latency_s == 0.0:
        return ()
    frames = (*recent, frame)
    while len(frames) > 1 and frames[1].t_s <= frame.t_s - latency_s + 1e-9:
        frames = frames[1:]
    return frames


def _delayed(frames: tuple[FleetFrame, ...], at_s: float) -> FleetFrame:
    """Return the newest frame as it was at an earlier time, each vehicle not before its own first frame."""
    newest, older = frames[-1], frames[0]
    newer = frames[min(1, len(frames) - 1)]
    span = newer.t_s - older.t_s
    share = np.full(len(newest), np.clip((at_s - older.t_s) / span, 0.0, 1.0) if span > 0.0 else 0.0)
    known = older.vehicle_id == newest.vehicle_id
    since = np.zeros(len(newest), dtype=np.int64)
    for number in range(len(frames) - 1, 0, -1):
        there = frames[number].vehicle_id == newest.vehicle_id
        since = np.where(~known & there, number, since)
    a = np.where(known, 0, since)
    b = np.where(known, min(1, len(frames) - 1), since)
    slot = np.arange(len(newest))

    def mixed(name: str) -> FloatArray:
        columns: FloatArray = np.stack([getattr(frame, name) for frame in frames])
        weight = share.reshape(-1, *([1] * (columns.ndim - 2)))
        old = columns[a, slot]
        change = columns[b, slot] - old
        return old + weight * (wrap_angle_rad(change) if name == "heading_rad" else change)

    return replace(
        newest,
        position_m=mixed("position_m"),
        speed_mps=mixed("speed_mps"),
        heading_rad=wrap_angle_rad(mixed("heading_rad")),
        acceleration_mps2=mixed("acceleration_mps2"),
        yaw_rate_radps=mixed("yaw_rate_radps"),
    )

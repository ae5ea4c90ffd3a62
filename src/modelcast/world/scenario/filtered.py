"""What the vehicles of a fleet make of what they see: `MotionFilter` over frames, all vehicles at once."""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.sensing.motion_filter import MotionFilter
from modelcast.world.scenario.base import NOBODY, FleetFrame

__all__ = ["FleetFilter", "FleetFilterState"]


@dataclass(frozen=True, slots=True)
class FleetFilterState:
    """Filters of a fleet between two frames.

    Parameters
    ----------
    vehicle_id
        Who was in each slot, (V,).
    states, spreads
        Of the filters, (V, 6) and (V, 6, 6).
    t_s
        Time of the last frame [s].
    """

    vehicle_id: IntArray
    states: FloatArray
    _: KW_ONLY
    spreads: FloatArray
    t_s: float


@dataclass(frozen=True, slots=True)
class FleetFilter:
    """The same filter in every vehicle of a fleet.

    Parameters
    ----------
    motion
        The filter.
    """

    motion: MotionFilter

    def init(self, slots: int) -> FleetFilterState:
        """State before the first frame.

        Parameters
        ----------
        slots
            Number of slots V.
        """
        return FleetFilterState(
            np.full(slots, NOBODY, dtype=np.int64),
            np.zeros((slots, 6)),
            spreads=np.zeros((slots, 6, 6)),
            t_s=-np.inf,
        )

    def estimate(self, state: FleetFilterState, seen: FleetFrame) -> tuple[FleetFrame, FleetFilterState]:
        """Return what the vehicles take for their motion, and the next state.

        Parameters
        ----------
        state
            As `init` or `estimate` gave it.
        seen
            What the sensors show, later than the last.

        Raises
        ------
        ValueError
            Where the number of slots differs, or time does not increase.

        Notes
        -----
        A vehicle new in its slot begins anew.
        """
        if len(seen) != state.vehicle_id.size or not seen.t_s > state.t_s:
            raise ValueError(
                f"seen must have {state.vehicle_id.size} slots and be later than {state.t_s} s, "
                f"got {len(seen)} slots at {seen.t_s} s"
            )
        columns = (seen.speed_mps, seen.heading_rad, seen.acceleration_mps2, seen.yaw_rate_radps)
        table = np.column_stack((seen.position_m, *columns))
        fresh = seen.vehicle_id != state.vehicle_id
        shown, states, spreads = self.motion.step(
            seen.t_s - state.t_s if np.isfinite(state.t_s) else 1.0,
            table,
            fresh,
            states=state.states,
            spreads=state.spreads,
            active=seen.active,
        )
        frame = replace(
            seen,
            position_m=np.ascontiguousarray(shown[:, :2]),
            speed_mps=np.ascontiguousarray(shown[:, 2]),
            heading_rad=np.ascontiguousarray(shown[:, 3]),
            acceleration_mps2=np.ascontiguousarray(shown[:, 4]),
            yaw_rate_radps=np.ascontiguousarray(shown[:, 5]),
        )
        return frame, FleetFilterState(seen.vehicle_id, states, spreads=spreads, t_s=seen.t_s)

"""How a vehicle moved, read off a recording: the one input of all that finds manoeuvres.

What a manoeuvre is judged by is the recorded path, conditioned first where the inspection says that the
recording is coarse. Nothing else is smoothed here.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.trips.conditioning import condition
from modelcast.trips.inspection import TripInspection, inspect
from modelcast.trips.recorder import WINDOW_S, velocity_over
from modelcast.trips.trajectory import Trajectory

__all__ = ["Motion", "read_motion"]


@dataclass(frozen=True, slots=True)
class Motion:
    """Path and speeds of one trip.

    Parameters
    ----------
    trip
        The trip whose path counts: as recorded, or conditioned.
    speed_mps
        Recorded (or conditioned) speed, (T,) [m/s]; by the positions where there is none to be believed.
    travelled_mps
        Speed by the positions, over one second, (T,) [m/s].
    """

    trip: Trajectory
    speed_mps: FloatArray
    _: KW_ONLY
    travelled_mps: FloatArray


def read_motion(trip: Trajectory, inspection: TripInspection | None = None) -> Motion:
    """Path and speeds of a trip.

    Parameters
    ----------
    trip
        As the reader returned it.
    inspection
        Its inspection, where it is there already.
    """
    found = inspect(trip) if inspection is None else inspection
    stuck = found.speed_is_stuck
    if found.recommended_protocol == "sensor":
        trip, _ = condition(trip)
        stuck = False  # its speed is that of the path now
    velocity = velocity_over(trip, WINDOW_S)
    travelled = np.hypot(velocity[:, 0], velocity[:, 1])
    speed = travelled if trip.speed_mps is None or stuck else trip.speed_mps
    return Motion(trip, speed, travelled_mps=travelled)

"""The triggering rules of cooperative awareness messages, replayed over one trip: a reference for rates.

A station checks its rules at every sample. It generates a message where heading, position or speed has
changed enough since the last one, else where the time `T_GenCam` is up. Nothing here depends on a tracking
error, so a trip has one rate whatever the threshold.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.policy.cam_kernels import trigger

__all__ = ["CamTriggering"]


@dataclass(frozen=True, slots=True)
class CamTriggering:
    """Generation of cooperative awareness messages after ETSI EN 302 637-2, clause 6.1.3.

    Parameters
    ----------
    min_inter_transmit_time_s
        T_GenCam_Dcc, within T_GenCamMin = 100 ms and T_GenCamMax: no message comes sooner [s].
    max_inter_transmit_time_s
        T_GenCamMax: T_GenCam starts here and returns here [s].
    heading_change_rad, distance_m, speed_change_mps
        Condition 1: a change since the last message greater than 4 degrees, 4 m or 0.5 m/s
        [rad], [m], [m/s].
    timeouts
        N_GenCam: so many messages in a row for want of a change, and T_GenCam is T_GenCamMax again.

    Raises
    ------
    ValueError
        Where a time or change is not positive, the times are not in order, or ``timeouts`` is below one.

    Notes
    -----
    After a message of condition 1, T_GenCam is the time that had passed since the one before. Condition 2
    generates a message where T_GenCam has passed. The standard checks at least every T_CheckCamGen <=
    T_GenCamMin; here every sample is a check, so recordings below 10 Hz are checked less often than that.

    References
    ----------
    ETSI EN 302 637-2, "Specification of Cooperative Awareness Basic Service", clause 6.1.3.

    Examples
    --------
    At 9 m/s the 4 m are passed after half a second of samples at 10 Hz:

    >>> import numpy as np
    >>> t_s = 0.1 * np.arange(21)
    >>> position_m = np.stack([9.0 * t_s, 0.0 * t_s], axis=1)
    >>> CamTriggering().transmit_indices(
    ...     t_s, position_m, speed_mps=np.full(21, 9.0), heading_rad=np.zeros(21)
    ... ).tolist()
    [0, 5, 10, 15, 20]
    """

    min_inter_transmit_time_s: float = 0.1
    max_inter_transmit_time_s: float = 1.0
    _: KW_ONLY
    heading_change_rad: float = float(np.deg2rad(4.0))
    distance_m: float = 4.0
    speed_change_mps: float = 0.5
    timeouts: int = 3

    def __post_init__(self) -> None:
        shortest, longest = self.min_inter_transmit_time_s, self.max_inter_transmit_time_s
        if not 0 < shortest <= longest:
            raise ValueError(f"times must be positive and in order, got {shortest} and {longest}")
        for name in ("heading_change_rad", "distance_m", "speed_change_mps"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if self.timeouts < 1:
            raise ValueError(f"timeouts must be at least 1, got {self.timeouts}")

    def transmit_indices(
        self,
        t_s: FloatArray,
        position_m: FloatArray,
        *,
        speed_mps: FloatArray,
        heading_rad: FloatArray,
        segments: IntArray | None = None,
    ) -> IntArray:
        """Indices of the samples of one trip at which messages are generated.

        Parameters
        ----------
        t_s
            Sample times, (T,) rising [s].
        position_m
            East and north, (T, 2) [m].
        speed_mps, heading_rad
            As the sender sees them, (T,) [m/s], [rad].
        segments
            Bounds of the gapless parts as in `Trajectory`; each starts anew with a message. None for one
            part.
        """
        bounds = np.array([0, t_s.size]) if segments is None else segments
        transmits = np.empty(t_s.size, dtype=np.bool_)
        trigger(
            t_s,
            np.ascontiguousarray(position_m, dtype=np.float64),
            np.ascontiguousarray(speed_mps, dtype=np.float64),
            np.ascontiguousarray(heading_rad, dtype=np.float64),
            np.repeat(bounds[:-1], np.diff(bounds)),
            self.heading_change_rad,
            self.distance_m,
            self.speed_change_mps,
            self.min_inter_transmit_time_s,
            self.max_inter_transmit_time_s,
            self.timeouts,
            transmits,
        )
        return np.flatnonzero(transmits)

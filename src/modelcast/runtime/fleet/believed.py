"""What hosts of a fleet believe of remotes, pair by pair: what applications on the map of a host take."""

from dataclasses import KW_ONLY, dataclass

from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["Believed"]


@dataclass(frozen=True, slots=True, eq=False)
class Believed:
    """Beliefs of N pairs of host and remote.

    Parameters
    ----------
    held
        Whether the host has a live track of the remote, (N,).
    motion
        East and north [m], their velocities [m/s], speed [m/s], heading, clockwise from north [rad],
        acceleration along the course [m/s²] and yaw rate, clockwise [rad/s], (N, 8), in the columns of
        `modelcast.station.receiver.belief_kernels`; not a number without a track.
    age_s
        Time since the fit that the host believes by, (N,) [s]; not a number without a track.
    """

    held: BoolArray
    _: KW_ONLY
    motion: FloatArray
    age_s: FloatArray

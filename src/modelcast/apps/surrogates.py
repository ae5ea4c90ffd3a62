"""Surrogate safety measures: how near to a crash two vehicles come, in numbers that need no crash.

Along a lane: `time_to_collision_s`, `modified_time_to_collision_s`, `deceleration_to_avoid_mps2` of gaps and
closing speeds. In the plane, between rectangles at constant velocity: `time_to_collision_2d_s` and
`deceleration_to_avoid_2d_mps2`. Of whole tracks: `post_encroachment_time_s`. NaN gives NaN.
"""

import numpy as np
import numpy.typing as npt

from modelcast.apps.base import same_rows
from modelcast.apps.compiled import columns_of
from modelcast.apps.motions import Motions
from modelcast.apps.surrogate_kernels import encroachments, first_contacts
from modelcast.core.arrays import FloatArray, owned

__all__ = [
    "deceleration_to_avoid_2d_mps2",
    "deceleration_to_avoid_mps2",
    "modified_time_to_collision_s",
    "post_encroachment_time_s",
    "time_to_collision_2d_s",
    "time_to_collision_s",
]


def time_to_collision_s(gap_m: npt.ArrayLike, closing_mps: npt.ArrayLike) -> FloatArray:
    """Time until a gap is closed at its present rate, (N,) [s].

    Parameters
    ----------
    gap_m
        Bumper to bumper, (N,) [m]; where it is not positive the time is 0.
    closing_mps
        Speed of the follower less that of its leader, (N,) [m/s]; where it is not positive the time is
        infinite.

    References
    ----------
    Hayward, Near-miss determination through use of a scale of danger, Highway Research Record 384, 1972.

    Examples
    --------
    >>> time_to_collision_s([20.0, 20.0, -1.0], [5.0, -5.0, -5.0])
    array([ 4., inf,  0.])
    """
    return modified_time_to_collision_s(gap_m, closing_mps, 0.0)


def modified_time_to_collision_s(
    gap_m: npt.ArrayLike, closing_mps: npt.ArrayLike, closing_mps2: npt.ArrayLike
) -> FloatArray:
    """Time until a gap is closed if accelerations last, (N,) [s]: first root of d = Δv t + Δa t²/2.

    Parameters
    ----------
    gap_m, closing_mps
        As in `time_to_collision_s`.
    closing_mps2
        Acceleration of the follower less that of its leader, (N,) [m/s²].

    Notes
    -----
    As published, a vehicle that brakes goes on to drive backwards; where it should stand instead, see the
    time of `modelcast.apps.warnings.Warnings`.

    References
    ----------
    Ozbay, Yang, Bartin, Mudigonda, Derivation and validation of new simulation-based surrogate safety
    measure, Transportation Research Record 2083, 2008, doi:10.3141/2083-12.

    Examples
    --------
    >>> modified_time_to_collision_s([12.0, 12.0], [4.0, 4.0], [4.0, -4.0])
    array([1.64575131,        inf])
    """
    gap, speed, gain = _columns(gap_m, closing_mps, closing_mps2)
    square = speed * speed + 2.0 * gain * gap
    with np.errstate(invalid="ignore", divide="ignore"):
        below = speed + np.sqrt(square)
        time = np.where((square >= 0.0) & (below > 0.0), 2.0 * gap / below, np.inf)
    return _known(np.where(gap <= 0.0, 0.0, time), gap, speed, gain)


def deceleration_to_avoid_mps2(gap_m: npt.ArrayLike, closing_mps: npt.ArrayLike) -> FloatArray:
    """Deceleration by which a follower just misses a leader of constant speed, Δv² / (2 d), (N,) [m/s²].

    Parameters
    ----------
    gap_m, closing_mps
        As in `time_to_collision_s`; 0 where nothing is closed, infinite where the gap is closed already.

    References
    ----------
    Cooper, Ferguson, Traffic studies at T-junctions: a conflict simulation record, Traffic Engineering and
    Control 17, 1976.

    Examples
    --------
    >>> deceleration_to_avoid_mps2([20.0, 20.0], [5.0, -5.0])
    array([0.625, 0.   ])
    """
    gap, speed = _columns(gap_m, closing_mps)
    with np.errstate(divide="ignore"):
        needed = np.where(gap > 0.0, speed * speed / (2.0 * np.where(gap > 0.0, gap, 1.0)), np.inf)
    return _known(np.where(speed > 0.0, needed, 0.0), gap, speed)


def time_to_collision_2d_s(host: Motions, remote: Motions) -> FloatArray:
    """Time until two rectangles at constant velocity first touch, (N,) [s]: infinite if never, 0 if they do.

    Parameters
    ----------
    host, remote
        N rows each; accelerations, yaw rates and covariances play no part.

    Raises
    ------
    ValueError
        Where the numbers of rows differ.

    Notes
    -----
    Exact: convex shapes overlap while their projections on all normals of their edges do, and on each of the
    four axes that is one interval of time. `validation/surrogates.py` compares it with the public
    implementation of Jiao (github.com/Yiru-Jiao/Two-Dimensional-Time-To-Collision), which gives -1 for
    rectangles that overlap.

    References
    ----------
    Jiao, A fast calculation of two-dimensional Time-to-Collision, version 1.0.0, 2024: that implementation.
    """
    same_rows(host, remote)
    out = np.empty(len(host))
    first_contacts(columns_of(host), columns_of(remote), out)
    return out


def deceleration_to_avoid_2d_mps2(host: Motions, remote: Motions) -> FloatArray:
    """Deceleration of the relative motion by which rectangles just do not touch, |Δv| / (2 TTC), (N,) [m/s²].

    Parameters
    ----------
    host, remote
        As in `time_to_collision_2d_s`; 0 where they never touch, infinite where they do already.
    """
    time = time_to_collision_2d_s(host, remote)
    relative = np.linalg.norm(remote.velocity_mps - host.velocity_mps, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(time == 0.0, np.inf, relative / (2.0 * time))


def post_encroachment_time_s(
    t_s: npt.ArrayLike,
    host_m: npt.ArrayLike,
    remote_m: npt.ArrayLike,
    *,
    point_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
) -> FloatArray:
    """Time from one vehicle's leaving a conflict area to the other's arrival, (N,) [s].

    Negative where both were in it at once; NaN where one never came.

    Parameters
    ----------
    t_s
        Increasing, (T,) [s].
    host_m, remote_m
        Tracks, straight between samples, (N, T, 2) [m].
    point_m
        Middle of the area, (N, 2) or (2,) [m].
    radius_m
        Of the area, sizes of vehicles included; (N,) or one number [m].

    Raises
    ------
    ValueError
        Where shapes do not match, times do not increase or a radius is negative.

    References
    ----------
    Allen, Shin, Cooper, Analysis of traffic conflicts and collisions, Transportation Research Record 667,
    1978.

    Examples
    --------
    >>> north = [[[0.0, -20.0], [0.0, 20.0]]]
    >>> east = [[[-40.0, 0.0], [0.0, 0.0]]]
    >>> post_encroachment_time_s([0.0, 4.0], north, east, point_m=[0.0, 0.0], radius_m=2.0)
    array([1.6])
    """
    times, host, remote = (np.asarray(values, dtype=np.float64) for values in (t_s, host_m, remote_m))
    if times.ndim != 1 or host.ndim != 3 or host.shape[1:] != (times.size, 2) or host.shape != remote.shape:
        raise ValueError(
            "t_s must have shape (T,) and both tracks (N, T, 2), "
            f"got {times.shape}, {host.shape}, {remote.shape}"
        )
    point = np.array(np.broadcast_to(np.asarray(point_m, dtype=np.float64), (len(host), 2)), order="C")
    radius = np.array(np.broadcast_to(np.asarray(radius_m, dtype=np.float64), (len(host),)))
    if (np.diff(times) <= 0.0).any() or (radius < 0.0).any():
        raise ValueError("t_s must increase, and radius_m must not be negative")
    out = np.empty(len(host))
    encroachments(owned(times), owned(host), owned(remote), point, radius, out)
    return out


def _columns(*values: npt.ArrayLike) -> tuple[FloatArray, ...]:
    given = np.broadcast_arrays(*(np.asarray(one, dtype=np.float64) for one in values))
    return tuple(np.atleast_1d(one) for one in given)


def _known(values: FloatArray, *of: FloatArray) -> FloatArray:
    return np.where(np.isnan(np.sum(of, axis=0)), np.nan, values)

"""Four nodes to try: three of a platoon whose leader brakes now and then, and one that crosses their road.

Each is a whole node with sockets of its own on this machine's loopback interface; only what drives them is
made up. Followers keep to Newell's rule: each does what the vehicle ahead did, some time later and some way
behind.

References
----------
G. F. Newell, "A simplified car-following theory: a lower order model", 2002, DOI
10.1016/S0191-2615(00)00044-8.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.trips.trajectory import Trajectory, build_trajectory

__all__ = ["DEMO_S", "demo_trips", "place_at"]

DEMO_S = 600.0
"""How long the drive lasts [s]."""

_STEP_S = 0.1
_ORIGIN = Origin(48.1374, 11.5755, 520.0)
_CRUISE_MPS, _SLOW_MPS = 14.0, 3.0
_BRAKES_MPS2, _GAINS_MPS2 = 6.0, 1.5
_PERIOD_S, _FIRST_S, _SLOW_S = 30.0, 10.0, 3.0
_LATER_S, _BEHIND_M = 1.2, 8.0
_SMOOTH_S = 0.4
_CROSSES_S, _AHEAD_M, _WIDE_M = 26.0, 25.0, 120.0


def demo_trips(lasts_s: float = DEMO_S) -> Mapping[str, Trajectory]:
    """The drives by the names of their vehicles, on one clock.

    Parameters
    ----------
    lasts_s
        How long they last, positive [s].

    Examples
    --------
    >>> trips = demo_trips()
    >>> list(trips), round(trips["leader"].duration_s)
    (['leader', 'second', 'third', 'crossing'], 600)
    """
    t_s: FloatArray = _STEP_S * np.arange(round(lasts_s / _STEP_S) + 1, dtype=np.float64)
    names = ("leader", "second", "third")
    found = {name: _following(name, t_s, place) for place, name in enumerate(names)}
    found["crossing"] = _crossing(t_s)
    return MappingProxyType(found)


def place_at(trip: Trajectory, t_s: float) -> tuple[float, float]:
    """Where a drive is at a time, between two samples on the line that joins them: east and north [m].

    Parameters
    ----------
    trip
        The drive.
    t_s
        Since it began; outside, its ends [s].

    Examples
    --------
    >>> [round(one, 3) for one in place_at(demo_trips()["leader"], 0.05)]
    [0.0, 0.7]
    """
    place_m = [float(np.interp(t_s, trip.t_s, trip.position_m[:, axis])) for axis in (0, 1)]
    return place_m[0], place_m[1]


def _crossing(t_s: FloatArray) -> Trajectory:
    """On a winding road that crosses the platoon's every period, a little ahead of the leader."""
    mean_mps = float(_leader(np.array([_PERIOD_S]))[2][0]) / _PERIOD_S
    turn_radps = np.pi / _PERIOD_S
    angle = turn_radps * (t_s - _CROSSES_S)
    ahead_m = float(_leader(np.array([_CROSSES_S]))[2][0]) - mean_mps * _CROSSES_S + _AHEAD_M
    east_m, north_m = _WIDE_M * np.sin(angle), mean_mps * t_s + ahead_m
    east_mps = _WIDE_M * turn_radps * np.cos(angle)
    east_mps2 = -_WIDE_M * turn_radps**2 * np.sin(angle)
    speed_mps = np.hypot(east_mps, mean_mps)
    return build_trajectory(
        "crossing",
        t_s,
        np.stack((east_m, north_m), axis=1),
        speed_mps=speed_mps,
        heading_rad=np.arctan2(east_mps, mean_mps) % (2.0 * np.pi),
        acceleration_mps2=east_mps * east_mps2 / speed_mps,
        yaw_rate_radps=mean_mps * east_mps2 / speed_mps**2,
        origin=_ORIGIN,
    )


def _following(name: str, t_s: FloatArray, place: int) -> Trajectory:
    """So many places behind the leader, northwards."""
    speed_mps, gain_mps2, way_m = _leader(t_s - _LATER_S * place)
    return build_trajectory(
        name,
        t_s,
        np.stack((np.zeros(t_s.size), way_m - _BEHIND_M * place), axis=1),
        speed_mps=speed_mps,
        heading_rad=np.zeros(t_s.size),
        acceleration_mps2=gain_mps2,
        yaw_rate_radps=np.zeros(t_s.size),
        origin=_ORIGIN,
    )


def _leader(t_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed, acceleration and way of the leader at any times, those before 0 too, (T,) each."""
    fine_s = np.arange(round((float(np.max(t_s)) + 20.0) / 0.01)) * 0.01 - 10.0
    phase_s = np.where(fine_s < 0.0, 0.0, fine_s % _PERIOD_S)
    down_s = (_CRUISE_MPS - _SLOW_MPS) / _BRAKES_MPS2
    braked = np.clip(phase_s - _FIRST_S, 0.0, down_s)
    gained = np.clip(phase_s - _FIRST_S - down_s - _SLOW_S, 0.0, (_CRUISE_MPS - _SLOW_MPS) / _GAINS_MPS2)
    speed = _CRUISE_MPS - _BRAKES_MPS2 * braked + _GAINS_MPS2 * gained
    # Nobody's acceleration jumps: the mean over 0.4 s.
    width = round(_SMOOTH_S / 0.01)
    speed = np.convolve(np.pad(speed, width, mode="edge"), np.full(width, 1.0 / width), mode="same")[
        width:-width
    ]
    gain = np.gradient(speed, 0.01)
    way = np.concatenate([[0.0], np.cumsum(0.005 * (speed[1:] + speed[:-1]))])
    way -= np.interp(0.0, fine_s, way)
    found: list[FloatArray] = [np.asarray(np.interp(t_s, fine_s, one)) for one in (speed, gain, way)]
    return found[0], found[1], found[2]

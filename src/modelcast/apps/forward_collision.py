"""Forward collision warning: one family of algorithms that differ in what a driver is taken to do.

All of them let a delay pass in which both vehicles go on as they do, and then let the driver brake so that it
ends just behind the leader. The range that this takes is the *warning range*.

| algorithm | delay | deceleration chosen | source |
|---|---|---|---|
| ``camp-linear`` | 2.05 s | linear in the leader's deceleration, whether it moves, and the closing speed | Kiefer et al., DOT HS 808 964 (1999) |
| ``camp-linear-2`` | 2.05 s | the same form, the other set of coefficients in circulation | as above, as quoted in later work |
| ``knipling`` | 2.05 s | 0.6 g, whatever the leader does | after Knipling et al., DOT HS 807 995 (1993); figures assumed |
| ``nhtsa`` | 1.5 s | 0.75 g, whatever the leader does | Burgett et al. (1998), 16th ESV, 98-S2-P-31 |
"""  # noqa: E501 - a table

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from math import pi
from types import MappingProxyType
from typing import Literal

import numpy as np

from modelcast.apps import forward_collision_kernels as kernels
from modelcast.apps.base import AbstractApplication, motion_rows, place_spreads
from modelcast.apps.forward_collision_kernels import G_MPS2
from modelcast.apps.motions import Motions
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import FloatArray, IntArray, owned

__all__ = ["ALGORITHMS", "Algorithm", "Braking", "ForwardCollisionWarning", "warning_range_m"]

Algorithm = Literal["camp-linear", "camp-linear-2", "knipling", "nhtsa"]

_MPH = 0.44704


@dataclass(frozen=True, slots=True)
class Braking:
    """How a driver is taken to react.

    Parameters
    ----------
    delay_s
        Until the brakes bite [s].
    constant_mps2
        Deceleration before a standing leader, with its sign [m/s²].
    by_leader
        Added by the leader's acceleration.
    by_moving_mps2
        Added where the leader still moves [m/s²].
    by_closing_per_s
        Added by the closing speed [1/s].
    """

    delay_s: float
    constant_mps2: float
    by_leader: float = 0.0
    by_moving_mps2: float = 0.0
    by_closing_per_s: float = 0.0


ALGORITHMS: Mapping[str, Braking] = MappingProxyType(
    {
        "camp-linear": Braking(2.05, -0.165 * G_MPS2, 0.685, 0.080 * G_MPS2, -0.00877 * G_MPS2),
        "camp-linear-2": Braking(2.05, -0.164 * G_MPS2, 0.668, 0.078 * G_MPS2, -0.00368 * G_MPS2 / _MPH),
        "knipling": Braking(2.05, -0.6 * G_MPS2),
        "nhtsa": Braking(1.5, -0.75 * G_MPS2),
    }
)
"""What drivers are taken to do, by the name of the algorithm."""


def _require_known(algorithm: str) -> None:
    if algorithm not in ALGORITHMS:
        raise ValueError(f"algorithm must be one of {', '.join(ALGORITHMS)}, got {algorithm!r}")


def _numbers(braking: Braking, *further: float) -> FloatArray:
    found = np.zeros(kernels.SETTINGS)
    own = (
        braking.delay_s, braking.constant_mps2, braking.by_leader, braking.by_moving_mps2,
        braking.by_closing_per_s, *further,
    )  # fmt: skip
    found[: len(own)] = own
    return found


def warning_range_m(
    speed_mps: FloatArray,
    acceleration_mps2: FloatArray,
    leader_speed_mps: FloatArray,
    leader_acceleration_mps2: FloatArray,
    *,
    algorithm: Algorithm = "camp-linear",
) -> FloatArray:
    """Range between bumpers at which a driver must be warned, (N,) [m].

    Parameters
    ----------
    speed_mps, acceleration_mps2
        Of the host, (N,).
    leader_speed_mps, leader_acceleration_mps2
        Of the vehicle ahead, (N,).
    algorithm
        A name of `ALGORITHMS`.

    Raises
    ------
    ValueError
        Where the algorithm is unknown.

    Notes
    -----
    Brake onset after the delay, P for projected by it: leader standing, v_FP²/(-2 d); leader moving when
    both are as fast, (v_FP - v_LP)²/(-2 (d - a_L)); leader stopping before, v_FP²/(-2 d) - v_LP²/(-2 a_L). To
    that comes what is closed meanwhile, (v_F - v_L) t + (a_F - a_L) t²/2.

    Examples
    --------
    >>> import numpy as np
    >>> at = np.array([20.0])
    >>> warning_range_m(at, 0 * at, 0 * at, 0 * at).round(2)  # 20 m/s on a standing vehicle
    array([100.91])
    """
    _require_known(algorithm)
    columns = np.broadcast_arrays(speed_mps, acceleration_mps2, leader_speed_mps, leader_acceleration_mps2)
    speed, acceleration, leader_speed, leader_acceleration = (
        owned(np.array(column, dtype=np.float64)) for column in columns
    )
    found = np.empty(speed.size)
    kernels.range_each(
        speed, acceleration, leader_speed, leader_acceleration, _numbers(ALGORITHMS[algorithm]), found
    )
    return found


@dataclass(frozen=True, slots=True)
class ForwardCollisionWarning(AbstractApplication):
    """Warns of the vehicle ahead in the host's path.

    Parameters
    ----------
    algorithm
        A name of `ALGORITHMS`.
    half_lane_m
        A remote farther beside the host's path of constant curvature is in another lane [m]; infinite where
        it is known to be the one ahead.
    farthest_m
        A remote farther along the path is no concern [m].
    widest_turn_rad
        Nor one whose course differs by more [rad].
    caution_s
        Caution is given where a driver that takes this much longer would have to be warned [s]; 0 for never.

    Raises
    ------
    ValueError
        Where the algorithm is unknown, or a value is not positive.

    Examples
    --------
    >>> host = Motions.of([[0.0, 0.0]], speed_mps=[20.0], heading_rad=[0.0])
    >>> standing = Motions.of([[0.0, 60.0]], speed_mps=[0.0], heading_rad=[0.0])
    >>> found = ForwardCollisionWarning().assess(host, standing)
    >>> found.warns, found.margin_m.round(1), found.time_s.round(2)
    (array([ True]), array([-45.4]), array([2.78]))
    """

    algorithm: Algorithm = "camp-linear"
    _: KW_ONLY
    half_lane_m: float = 1.8
    farthest_m: float = 300.0
    widest_turn_rad: float = pi / 3
    caution_s: float = 0.7

    def __post_init__(self) -> None:
        _require_known(self.algorithm)
        for name in ("half_lane_m", "farthest_m", "widest_turn_rad"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not self.caution_s >= 0.0:
            raise ValueError(f"caution_s must not be negative, got {self.caution_s}")

    def assess(self, host: Motions, remote: Motions) -> Warnings:
        """Warn where the gap is not longer than the warning range, and the host closes in.

        Parameters
        ----------
        host, remote
            As for `AbstractApplication`.
        """
        level: IntArray = np.zeros(len(host), dtype=np.int64)
        found = np.empty((len(host), 3))
        own, other = motion_rows(host, remote)
        numbers = _numbers(
            ALGORITHMS[self.algorithm],
            self.half_lane_m, self.farthest_m, self.widest_turn_rad, self.caution_s,
        )  # fmt: skip
        kernels.assess_each(own, other, place_spreads(host, remote), numbers, level, found)
        return Warnings(level, found[:, 0], found[:, 1], found[:, 2])

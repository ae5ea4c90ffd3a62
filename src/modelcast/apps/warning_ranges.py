"""Gaps at which published forward collision warnings warn; one class an algorithm, each with its numbers.

`CampLinear` expects drivers to brake as hard as they did in CAMP's trials, `Knipling` expects one braking of
all, `Nhtsa` asks what distance a late braking would leave. All take speeds and accelerations along the path,
and a leader that has stopped stays where it is.
"""

import abc
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from types import MappingProxyType
from typing import final

import numpy as np
import numpy.typing as npt

from modelcast.apps.forward_collision_kernels import CAMP, KNIPLING, NHTSA, Rule, ranges
from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError

__all__ = [
    "WARNING_RANGES",
    "AbstractWarningRange",
    "CampCoefficients",
    "CampLinear",
    "Knipling",
    "Nhtsa",
    "get_warning_range",
]

_GRAVITY_MPS2 = 9.80665
_FOOT_M = 0.3048
_MILE_PER_HOUR_MPS = 0.44704


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be positive, got {value}")


def _not_negative(**values: float) -> None:
    for name, value in values.items():
        if not 0.0 <= value < np.inf:
            raise ValueError(f"{name} must not be negative, got {value}")


class AbstractWarningRange(abc.ABC):
    """Gap, bumper to bumper, at which a host is warned of the vehicle ahead."""

    @property
    @abc.abstractmethod
    def rule(self) -> Rule:
        """The algorithm as kernels take it."""

    def warning_range_m(
        self,
        host_speed_mps: npt.ArrayLike,
        host_acceleration_mps2: npt.ArrayLike,
        remote_speed_mps: npt.ArrayLike,
        remote_acceleration_mps2: npt.ArrayLike,
    ) -> FloatArray:
        """Gaps at which the algorithm warns, not negative, (N,) [m]; NaN where something is NaN.

        Parameters
        ----------
        host_speed_mps, remote_speed_mps
            Not negative, (N,) or one number [m/s].
        host_acceleration_mps2, remote_acceleration_mps2
            (N,) or one number [m/s²].

        Raises
        ------
        ValueError
            Where shapes do not match, or a speed is negative.

        Examples
        --------
        >>> Knipling().warning_range_m(20.0, 0.0, 0.0, 0.0).round(2)
        array([74.99])
        """
        given = [
            np.asarray(values, dtype=np.float64)
            for values in (host_speed_mps, host_acceleration_mps2, remote_speed_mps, remote_acceleration_mps2)
        ]
        columns = [np.array(values, ndmin=1) for values in np.broadcast_arrays(*given)]
        if min(np.min(columns[0], initial=0.0), np.min(columns[2], initial=0.0)) < 0.0:
            raise ValueError("speeds must not be negative; give a vehicle that reverses as one that stands")
        out = np.empty(columns[0].shape)
        ranges(self.rule, columns[0], columns[1], columns[2], columns[3], out)
        return out


@dataclass(frozen=True, slots=True)
class CampCoefficients:
    """Deceleration that drivers are expected to reach: c + c_L a_L + c_M [v_L > 0] + c_D (v_FP - v_LP).

    Parameters
    ----------
    constant_mps2
        c [m/s²].
    by_leader
        c_L.
    by_moving_mps2
        c_M, for a leader that moves [m/s²].
    by_closing_per_s
        c_D [1/s].
    """

    constant_mps2: float
    _: KW_ONLY
    by_leader: float
    by_moving_mps2: float
    by_closing_per_s: float


FEET = CampCoefficients(
    -5.308 * _FOOT_M, by_leader=0.685, by_moving_mps2=2.570 * _FOOT_M, by_closing_per_s=-0.086
)
"""Published in feet: -5.308 + 0.685 a_L + 2.570 [v_L > 0] - 0.086 (v_FP - v_LP), ft/s²."""

MILES = CampCoefficients(
    -0.164 * _GRAVITY_MPS2,
    by_leader=0.668,
    by_moving_mps2=0.078 * _GRAVITY_MPS2,
    by_closing_per_s=-0.00368 * _GRAVITY_MPS2 / _MILE_PER_HOUR_MPS,
)
"""Published in g and miles: -0.164 + 0.668 a_L - 0.00368 (v_FP - v_LP) + 0.078 [v_L > 0]."""


@final
@dataclass(frozen=True, slots=True)
class CampLinear(AbstractWarningRange):
    """CAMP's linear crash alert timing.

    Parameters
    ----------
    coefficients
        `FEET` or `MILES`.
    delay_s
        t_d: reaction of driver and brakes [s].

    Notes
    -----
    With v_P = max(v + a t_d, 0) and d_req of the coefficients, the range is max(0, BOR + r_d) where
    r_d = (v_F - v_L) t_d + (a_F - a_L) t_d² / 2 and BOR is the most that braking by d_req closes:

    - leader stopped: v_FP² / (-2 d_req);
    - speeds equal before it stops: (v_FP - v_LP)² / (-2 (d_req - a_L));
    - leader stops within: v_FP² / (-2 d_req) - v_LP² / (-2 a_L).

    The published formulas are for followers that close in: here a leader that is faster counts as equally
    fast in d_req, and BOR is not negative. A leader that stands does not accelerate.

    References
    ----------
    Kiefer et al., Development and validation of functional definitions and evaluation procedures for
    collision warning/avoidance systems, DOT HS 808 964, 1999; `FEET` as quoted in the final report of
    SAVE-IT, task 9. Both sets stand in public code of a group at the University of Central Florida (Y. P.
    Fallah, 2017), the delay there too; it takes the third case only where v_LP = 0.
    """

    coefficients: CampCoefficients = FEET
    _: KW_ONLY
    delay_s: float = 2.05

    def __post_init__(self) -> None:
        _not_negative(delay_s=self.delay_s)

    @property
    def rule(self) -> Rule:
        """CAMP's."""
        one = self.coefficients
        return Rule(
            CAMP, self.delay_s, self.delay_s, 0.0, 0.0, 0.0, 0.0, 0.0,
            one.constant_mps2, one.by_leader, one.by_moving_mps2, one.by_closing_per_s,
        )  # fmt: skip


@final
@dataclass(frozen=True, slots=True)
class Knipling(AbstractWarningRange):
    """Distance to stop behind a leader that stands or brakes to a stop.

    Parameters
    ----------
    delay_s
        Reaction of driver and brakes [s].
    braking_mps2
        Deceleration of the host that is counted on [m/s²].
    standing_mps
        A leader up to this speed stands: a mile an hour [m/s].

    Notes
    -----
    R = t_d v_F + v_F² / (2 b) for a leader that stands, less v_L² / (-2 a_L) for one that brakes and is
    slower than the host; 0 for others.

    References
    ----------
    Knipling et al., Assessment of IVHS countermeasures for collision avoidance: rear-end crashes, DOT HS 807
    995, 1993. Formula and numbers as in public code of a group at the University of Central Florida (2017);
    not checked against the report.
    """

    delay_s: float = 2.05
    _: KW_ONLY
    braking_mps2: float = 0.6 * _GRAVITY_MPS2
    standing_mps: float = _MILE_PER_HOUR_MPS

    def __post_init__(self) -> None:
        _not_negative(delay_s=self.delay_s, standing_mps=self.standing_mps)
        _positive(braking_mps2=self.braking_mps2)

    @property
    def rule(self) -> Rule:
        """Knipling's."""
        return Rule(
            KNIPLING, self.delay_s, self.delay_s, 0.0, self.braking_mps2, 0.0, 0.0, self.standing_mps,
            0.0, 0.0, 0.0, 0.0,
        )  # fmt: skip


@final
@dataclass(frozen=True, slots=True)
class Nhtsa(AbstractWarningRange):
    """NHTSA's rear-end alert: the gap at which a late braking leaves just the distance that is to be left.

    Parameters
    ----------
    braking_mps2
        Deceleration of the host that is counted on: 0.55 g for an imminent alert, 0.45 g for an intermediate
        and 0.38 g for an early one [m/s²].
    delay_s
        Until the brakes bite [s].
    braking_delay_s
        The same for a host that brakes already [s].
    brakes_mps2
        A host that slows down by more than this brakes [m/s²]; the algorithm has the brake's switch.
    rest_m, rest_s
        Distance to be left, rest_m + rest_s v_F [m], [s].

    Notes
    -----
    The host keeps its acceleration until its brakes bite, the leader keeps its own until it stands. The range
    is what the host has closed where the two are nearest after that, plus the distance to be left; 0 where
    nothing is closed.

    References
    ----------
    Burgett, Carter, Preziotti, An algorithm for rear-end collision avoidance warning systems, ESV 2001;
    Brunson, Kyle, Phamdo, Preziotti, Alert algorithm development program, DOT HS 809 526, 2002. Miss distance
    as in their abstract; numbers as in public code of a group at the University of Central Florida (2017),
    not checked against the report.
    """

    braking_mps2: float = 0.55 * _GRAVITY_MPS2
    _: KW_ONLY
    delay_s: float = 1.6
    braking_delay_s: float = 0.5
    brakes_mps2: float = 0.5
    rest_m: float = 2.0
    rest_s: float = 0.1

    def __post_init__(self) -> None:
        _positive(braking_mps2=self.braking_mps2)
        _not_negative(
            delay_s=self.delay_s, braking_delay_s=self.braking_delay_s, brakes_mps2=self.brakes_mps2,
            rest_m=self.rest_m, rest_s=self.rest_s,
        )  # fmt: skip

    @property
    def rule(self) -> Rule:
        """NHTSA's."""
        return Rule(
            NHTSA, self.delay_s, self.braking_delay_s, self.brakes_mps2, self.braking_mps2,
            self.rest_m, self.rest_s, 0.0, 0.0, 0.0, 0.0, 0.0,
        )  # fmt: skip


WARNING_RANGES: Mapping[str, AbstractWarningRange] = MappingProxyType(
    {
        "camp-linear": CampLinear(),
        "camp-linear-miles": CampLinear(MILES),
        "knipling": Knipling(),
        "nhtsa": Nhtsa(),
        "nhtsa-intermediate": Nhtsa(0.45 * _GRAVITY_MPS2),
        "nhtsa-early": Nhtsa(0.38 * _GRAVITY_MPS2),
    }
)
"""The algorithms by name."""


def get_warning_range(name: str) -> AbstractWarningRange:
    """Return an algorithm by its name.

    Raises
    ------
    ConfigError
        Where there is none of that name.
    """
    if name not in WARNING_RANGES:
        raise ConfigError(f"Unknown forward collision warning {name!r}. Known: {', '.join(WARNING_RANGES)}.")
    return WARNING_RANGES[name]

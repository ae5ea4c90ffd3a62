"""The constants of SAE J2945/1 congestion control, and the sets of them that other senders use.

The standard calls the *sending* vehicle "HV". Here, as in J2945/1's own parameter names below, "HV" and
"remote estimate" are that vehicle's words: its estimate of itself, and what it believes others to know of it.
Everywhere else in the package it is the remote.
"""

from dataclasses import astuple, dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["RELAXED_ERROR_M", "J2945Parameters", "j2945_relaxed_parameters", "j3161_parameters"]

RELAXED_ERROR_M = 0.01
"""Tracking error that calls for a message under `j2945_relaxed_parameters` [m]."""

_STANDARD_GRAVITY_MPS2 = 9.80665

_UNIT_INTERVAL = (
    "max_packet_error_ratio",
    "channel_quality_weight",
    "density_weight",
    "busy_weight",
    "power_gain",
    "min_busy_ratio",
    "max_busy_ratio",
)
_POSITIVE = (
    "per_interval_s",
    "per_sub_interval_s",
    "per_range_m",
    "density_interval_s",
    "density_coefficient",
    "rate_control_interval_s",
    "error_sensitivity",
    "critical_interval_s",
    "critical_deceleration_mps2",
)
_NOT_NEGATIVE = ("reschedule_threshold_s", "jitter_s", "time_accuracy_s", "max_successive_failures")
_ORDERED = (
    ("min_inter_transmit_time_s", "max_inter_transmit_time_s"),
    ("local_as_is_age_s", "local_max_age_s"),
    ("remote_as_is_age_s", "remote_max_age_s"),
    ("min_tracking_error_m", "max_tracking_error_m"),
)
_BELOW = (
    ("jitter_s", "min_inter_transmit_time_s"),
    ("min_busy_ratio", "max_busy_ratio"),
)
_WHOLE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class J2945Parameters:
    """Constants of SAE J2945/1, clause 6.3.8, under our names; theirs follow.

    The standard is not public. Marks say where a value comes from: [R] read in public code or on a public
    page, [V] second-hand, from a document that cites its source, [M] from memory.

    Parameters
    ----------
    per_interval_s
        vPERInterval: packets that a packet error ratio counts [R] [s].
    per_sub_interval_s
        vPERSubInterval: how often it is counted, and how fresh the last packet must be [R] [s].
    per_range_m
        vPERRange: remotes within it count, for ratio and density alike [R] [m].
    max_packet_error_ratio
        vPERMax: cap of the channel quality [R].
    channel_quality_weight
        Weight of a new mean packet error ratio: 1 takes it as it is [R]; one reading smooths with 0.1 [V].
    density_interval_s
        How often remotes are counted: at every rate control [V]; a public implementation counts once in a
        sub-interval, 1 s [R] [s].
    density_weight
        vDensityWeightFactor, lambda: weight of a new count of remotes [R]; one source prints 0.5 [R].
    density_coefficient
        vDensityCoefficient, B: density up to which the time between messages is shortest [R].
    min_inter_transmit_time_s
        Maximum inter-transmit time up to that density [R] [s].
    max_inter_transmit_time_s
        vMax_ITT [R] [s].
    rate_control_interval_s
        vTxRateCntrlInt [R] [s]. Channel busy percentage is smoothed as often (vCBPMeasInt, the same 100 ms).
    busy_weight
        vCBPWeightFactor: weight of a new channel busy ratio [R].
    local_as_is_age_s, local_max_age_s
        vHVLocalPosEstIntMin and -Max: age from which the vehicle's own position is extrapolated, and beyond
        which the tracking error is 0 [R] [s]. A public stack has 0 and 0.2 [R].
    remote_as_is_age_s, remote_max_age_s
        vHVRemotePosEstIntMin and -Max: the same for the position the remotes are believed to hold [R] [s]. A
        public stack has 0 and 3 [R].
    tracking_error_trigger
        Whether a tracking error can call for a message.
    min_tracking_error_m, max_tracking_error_m
        vTrackingErrMin, T, and vTrackingErrMax, S: error from which a message is possible, and certain [R]
        [m].
    error_sensitivity
        vErrSensitivity, alpha [R].
    squared_exponent
        Whether the exponent has the square of the error beyond T. It fits the printed 0.57 at 0.31 m best
        [V]; one digest prints it unsquared [R].
    reschedule_threshold_s
        vRescheduleTh: a message is brought forward by this or more, or not at all [R] [s].
    jitter_s
        vTxRand: bound of the random shift of a scheduled message [R] [s].
    time_accuracy_s
        vTimeAccuracy [R] [s]; here, how early a timer may be served.
    max_successive_failures
        vMaxSuccessiveFail: losses in a row that are believed; the next message counts as received [R].
    critical_interval_s
        Time between messages while a critical event goes on [V] [s].
    critical_deceleration_mps2
        Braking beyond it is a critical event: 0.4 g [V] [m/s²].
    power_control
        Whether power follows the channel busy ratio; else every message has `max_power_dbm`.
    min_power_dbm, max_power_dbm, start_power_dbm
        vRPMin, vRPMax, vRP: radiated power [R] [dBm].
    power_gain
        vSUPRAGain [R].
    min_busy_ratio, max_busy_ratio
        vMinChanUtil and vMaxChanUtil: channel busy ratio up to which power is highest, from which it is
        lowest [R].
    max_error_growth
        Ours, not the standard's: errors count for less as the smoothed density rises beyond
        `density_coefficient`, in the same proportion, and at most this much less; 1 is the standard.
    follow_up_s
        Ours too: time from a message that an error called for to a second one, which mends a loss of the
        first; 0 for none, as in the standard [s].

    Raises
    ------
    ValueError
        Where a value is out of its range.

    References
    ----------
    SAE J2945/1, "On-Board System Requirements for V2V Safety Communications", clause 6.3.8 and annex A.8.
    S. A. Ahmad, A. Hajisami, H. Krishnan, F. Ahmed-Zaid, E. Moradi-Pari, "V2V System Congestion Control
    Validation and Performance", doi:10.1109/TVT.2019.2893042. A. Rostami, H. Krishnan, M. Gruteser, "V2V
    Safety Communication Scalability Based on the SAE J2945/1 Standard" (2018).

    Examples
    --------
    >>> J2945Parameters(density_weight=0.5).density_weight
    0.5
    """

    per_interval_s: float = 5.0
    per_sub_interval_s: float = 1.0
    per_range_m: float = 100.0
    max_packet_error_ratio: float = 0.3
    channel_quality_weight: float = 1.0
    density_interval_s: float = 0.1
    density_weight: float = 0.05
    density_coefficient: float = 25.0
    min_inter_transmit_time_s: float = 0.1
    max_inter_transmit_time_s: float = 0.6
    rate_control_interval_s: float = 0.1
    busy_weight: float = 0.5
    local_as_is_age_s: float = 0.05
    local_max_age_s: float = 0.15
    remote_as_is_age_s: float = 0.05
    remote_max_age_s: float = 3.0
    tracking_error_trigger: bool = True
    min_tracking_error_m: float = 0.2
    max_tracking_error_m: float = 0.5
    error_sensitivity: float = 75.0
    squared_exponent: bool = True
    reschedule_threshold_s: float = 0.025
    jitter_s: float = 0.005
    time_accuracy_s: float = 0.001
    max_successive_failures: int = 3
    critical_interval_s: float = 0.1
    critical_deceleration_mps2: float = 0.4 * _STANDARD_GRAVITY_MPS2
    power_control: bool = True
    min_power_dbm: float = 10.0
    max_power_dbm: float = 20.0
    start_power_dbm: float = 15.0
    power_gain: float = 0.5
    min_busy_ratio: float = 0.5
    max_busy_ratio: float = 0.8
    max_error_growth: float = 1.0
    follow_up_s: float = 0.0

    def __post_init__(self) -> None:
        for name in _UNIT_INTERVAL:
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie in 0..1, got {getattr(self, name)}")
        for name in _POSITIVE:
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        for name in _NOT_NEGATIVE:
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        self._check_order()

    def _check_order(self) -> None:
        """Refuse what is out of order with another field."""
        for low, high in _ORDERED:
            if not 0 <= getattr(self, low) <= getattr(self, high):
                raise ValueError(
                    f"{low} must not exceed {high}, got {getattr(self, low)}, {getattr(self, high)}"
                )
        for low, high in _BELOW:
            if not getattr(self, low) < getattr(self, high):
                raise ValueError(
                    f"{low} must be below {high}, got {getattr(self, low)}, {getattr(self, high)}"
                )
        if not self.max_error_growth >= 1.0:
            raise ValueError(f"max_error_growth must be at least 1, got {self.max_error_growth}")
        if self.follow_up_s != 0.0 and not self.follow_up_s >= self.rate_control_interval_s:
            raise ValueError(
                f"follow_up_s must be 0, for none, or at least {self.rate_control_interval_s}, "
                f"got {self.follow_up_s}"
            )
        if not self.min_power_dbm <= self.start_power_dbm <= self.max_power_dbm:
            raise ValueError(
                f"start_power_dbm must lie between {self.min_power_dbm} and {self.max_power_dbm}, "
                f"got {self.start_power_dbm}"
            )
        intervals = self.per_interval_s / self.per_sub_interval_s
        if abs(intervals - round(intervals)) > _WHOLE:
            raise ValueError(
                f"per_interval_s must be a whole number of per_sub_interval_s, got {self.per_interval_s} "
                f"and {self.per_sub_interval_s}"
            )

    @property
    def sub_intervals(self) -> int:
        """How many sub-intervals a packet error ratio counts."""
        return round(self.per_interval_s / self.per_sub_interval_s)

    def constants(self) -> FloatArray:
        """Constants as the compiled rules take them, in the order of the fields, (36,)."""
        return np.array(astuple(self), dtype=np.float64)

    def is_critical(
        self, acceleration_mps2: FloatArray, *, antilock: BoolArray | bool, traction_loss: BoolArray | bool
    ) -> BoolArray:
        """Whether each of B vehicles has a critical event, (B,).

        Parameters
        ----------
        acceleration_mps2
            Along the course, (B,) [m/s²].
        antilock, traction_loss
            Whether antilock brakes work, or traction or stability control does, (B,) or one for all.

        Examples
        --------
        >>> J2945Parameters().is_critical(
        ...     np.array([-3.8, -4.0]), antilock=False, traction_loss=False
        ... ).tolist()
        [False, True]
        """
        return (acceleration_mps2 < -self.critical_deceleration_mps2) | antilock | traction_loss


def j3161_parameters(*, power_control: bool = False, tracking_error_trigger: bool = False) -> J2945Parameters:
    """Return the set for SAE J3161/1, congestion control over LTE-V2X: the density rule as in J2945/1.

    Parameters
    ----------
    power_control
        Whether power follows the channel busy ratio. The published description has no power control [V]; a
        public simulator has it as a switch [R].
    tracking_error_trigger
        Whether the tracking error calls for messages. The published description has none [V]; a public
        simulator and a public stack keep it [R].

    References
    ----------
    SAE J3161/1, "On-Board System Requirements for LTE-V2X V2V Safety Communications". A. Fouda, R. Berry,
    I. Vukovic, "Study of BSM Inter-Packet Gap Tails in C-V2X Networks", arXiv:2311.16904.

    Examples
    --------
    >>> j3161_parameters().power_control, j3161_parameters().density_coefficient
    (False, 25.0)
    """
    return J2945Parameters(power_control=power_control, tracking_error_trigger=tracking_error_trigger)


def j2945_relaxed_parameters(
    inter_transmit_time_s: float = 2.0,
    parameters: J2945Parameters | None = None,
    *,
    error_m: float = RELAXED_ERROR_M,
    max_error_growth: float = 6.0,
    follow_up_s: float = 0.3,
) -> J2945Parameters:
    """Return the set for senders of models: errors call for messages, and time hardly ever.

    One maximum inter-transmit time at every density, and a certain message at a small error. What density
    does to the time between messages in the standard it does to this error here. What the remotes are
    believed to hold never gets too old to be compared with: the sender still knows what their models say.

    Parameters
    ----------
    inter_transmit_time_s
        Longest time between two messages [s].
    parameters
        What everything else is taken from; None for the standard's.
    error_m
        Tracking error that calls for a message where traffic is thin, T and S in one [m].
    max_error_growth
        As in `J2945Parameters`; 6 is how much the standard's time grows.
    follow_up_s
        As in `J2945Parameters` [s].

    Raises
    ------
    ValueError
        Where a value is out of its range.

    Notes
    -----
    An error is the distance of two estimates, so `error_m` should not be less than the noise of the
    vehicle's positions. `docs/decisions/021-relaxed-timers.md` has the curve the defaults are from.

    Examples
    --------
    >>> relaxed = j2945_relaxed_parameters(5.0)
    >>> relaxed.max_inter_transmit_time_s, relaxed.min_tracking_error_m, relaxed.max_tracking_error_m
    (5.0, 0.01, 0.01)
    """
    return replace(
        J2945Parameters() if parameters is None else parameters,
        min_inter_transmit_time_s=inter_transmit_time_s,
        max_inter_transmit_time_s=inter_transmit_time_s,
        remote_max_age_s=float("inf"),
        min_tracking_error_m=error_m,
        max_tracking_error_m=error_m,
        max_error_growth=max_error_growth,
        follow_up_s=follow_up_s,
    )

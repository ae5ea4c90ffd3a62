"""The triggering rules of cooperative awareness messages, over one trip and for a fleet.

A station checks its rules at every sample. It generates a message where heading, position or speed has
changed enough since the last one, else where the time `T_GenCam` is up. Nothing here depends on a tracking
error, so a trip has one rate whatever the threshold. `CamTriggering` replays a trip, as a reference for
rates; `CooperativeAwareness` is the same rule as a policy, with the least time between messages from
decentralised congestion control.
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.station.policy import cam_kernels as kernels
from modelcast.station.policy import dcc_kernels
from modelcast.station.policy.base import (
    AbstractTransmitPolicy,
    Decisions,
    MessageKind,
    TransmitInputs,
    required,
)
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.policy_numbers import RULE_CAM, PolicyNumbers

__all__ = ["CamState", "CamTriggering", "CooperativeAwareness"]


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

    def constants(self) -> FloatArray:
        """Constants as the compiled rule takes them, (5,)."""
        return np.array(
            [
                self.heading_change_rad,
                self.distance_m,
                self.speed_change_mps,
                self.max_inter_transmit_time_s,
                float(self.timeouts),
            ]
        )

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
        kernels.trigger(
            t_s,
            owned(position_m),
            owned(speed_mps),
            owned(heading_rad),
            np.repeat(bounds[:-1], np.diff(bounds)),
            self.min_inter_transmit_time_s,
            self.constants(),
            transmits,
        )
        return np.flatnonzero(transmits)


@dataclass(frozen=True, slots=True)
class CamState:
    """State of B vehicles, as the columns that `cam_kernels` and `dcc_kernels` name.

    Parameters
    ----------
    rows
        Of the triggering rule, (B, 7).
    control
        Of congestion control, (B, 5).
    """

    rows: FloatArray
    control: FloatArray

    @property
    def share(self) -> FloatArray:
        """Share of the channel each may take under `AdaptiveDcc`, the state's number under `ReactiveDcc`."""
        return self.control[:, dcc_kernels.SHARE]


@dataclass(frozen=True, slots=True)
class CooperativeAwareness(AbstractTransmitPolicy[CamState]):
    """Cooperative awareness messages under decentralised congestion control.

    Asked at least every 100 ms (T_CheckCamGen), it needs `Motion`, and under control `Air` too: the channel
    busy ratio over the last T_CBR, and the airtime of the message.

    Parameters
    ----------
    triggering
        The rules; their least time is T_GenCam_Dcc without control, T_GenCamMin with it.
    control
        Gives T_GenCam_Dcc; None for no congestion control.

    Examples
    --------
    >>> CooperativeAwareness().control.target_busy_ratio
    0.68
    """

    triggering: CamTriggering = field(default_factory=CamTriggering)
    control: AdaptiveDcc | ReactiveDcc | None = field(default_factory=AdaptiveDcc)

    @property
    def numbers(self) -> PolicyNumbers:
        """Triggering rules and congestion control."""
        control = self.control
        return PolicyNumbers(
            RULE_CAM,
            self.triggering.constants(),
            dcc_kernels.NONE if control is None else control.code,
            np.zeros(1) if control is None else control.constants(),
            0.0 if control is None else control.first_share,
            self.triggering.min_inter_transmit_time_s,
            np.inf,
        )

    @property
    def longest_silence_s(self) -> float:
        """T_GenCamMax [s]."""
        return self.triggering.max_inter_transmit_time_s

    def init(self, vehicles: int, sub_models: int) -> CamState:  # noqa: ARG002 - any bank will do
        """Nothing sent, nothing measured."""
        rows = np.zeros((vehicles, kernels.STATE_COLUMNS))
        constants = self.triggering.constants()
        for row in rows:
            kernels.start(row, constants)
        if self.control is None:
            return CamState(rows, np.zeros((vehicles, dcc_kernels.STATE_COLUMNS)))
        return CamState(rows, self.control.rows(vehicles, np.zeros(vehicles)))

    def decide(
        self,
        state: CamState,
        inputs: TransmitInputs,
        rng: np.random.Generator,  # noqa: ARG002 - this policy draws nothing
    ) -> tuple[Decisions, CamState]:
        """Take measures where due, then check the rules; the message leaves at once."""
        motion = required(inputs.motion, "motion", "CooperativeAwareness")
        busy_ratio = airtime_s = np.zeros(inputs.t_s.size)
        code, control_constants = dcc_kernels.NONE, np.zeros(0)
        if self.control is not None:
            air = required(inputs.air, "air", "CooperativeAwareness")
            busy_ratio, airtime_s = air.channel_busy_ratio, air.airtime_s
            code, control_constants = self.control.code, self.control.constants()
        rows, control = state.rows.copy(), state.control.copy()
        sends = np.empty(rows.shape[0], dtype=np.bool_)
        seen = kernels.Vehicles(
            owned(inputs.t_s),
            owned(motion.position_m),
            owned(motion.speed_mps),
            owned(motion.heading_rad),
            owned(busy_ratio),
            owned(airtime_s),
        )
        kernels.step_each(
            rows,
            control,
            code,
            seen,
            self.triggering.min_inter_transmit_time_s,
            self.triggering.constants(),
            control_constants,
            sends,
        )
        kind = np.where(sends, MessageKind.UPDATE, MessageKind.NOTHING).astype(np.int64)
        return Decisions.at_once(kind, np.zeros_like(kind), inputs.t_s), CamState(rows, control)

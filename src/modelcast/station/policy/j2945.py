"""Congestion control of SAE J2945/1: when a vehicle sends, and with which power.

Three things call for a message. The *maximum inter-transmit time*, which grows with the number of remotes
within 100 m. The *tracking error*, with a probability that grows with it. A *critical event*, at once. Power
follows the channel busy ratio, but for messages of the last two kinds.

The rule takes the tracking error as an input and does not ask who made it: coasting from the last basic
safety message that the remotes are believed to hold (`j2945`), or the model update they are believed to hold
(`j2945-mbc`), as `tracking_error_kernels` measures either. Every vehicle believes its messages lost
with the probability that its own packet error ratios suggest.
"""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.station.policy import dcc_kernels
from modelcast.station.policy import j2945_kernels as kernels
from modelcast.station.policy.base import (
    AbstractTransmitPolicy,
    Decisions,
    MessageKind,
    TransmitInputs,
    required,
)
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.policy_numbers import RULE_J2945, PolicyNumbers

__all__ = ["J2945", "Cause", "J2945State", "max_inter_transmit_time", "transmit_probability"]


class Cause(IntEnum):
    """Why a vehicle sends."""

    NOTHING = kernels.CAUSE_NOTHING
    TIME = kernels.CAUSE_TIME
    DYNAMICS = kernels.CAUSE_DYNAMICS
    CRITICAL = kernels.CAUSE_CRITICAL


@dataclass(frozen=True, slots=True)
class J2945State:
    """State of B vehicles.

    Parameters
    ----------
    rows
        The columns that `j2945_kernels` names, (B, 15).
    cause
        `Cause` of what the last decision sent, (B,).
    """

    rows: FloatArray
    cause: IntArray

    @property
    def density(self) -> FloatArray:
        """Smoothed number of remotes within range, (B,)."""
        return self.rows[:, kernels.DENSITY]

    @property
    def channel_quality(self) -> FloatArray:
        """Probability with which a message is believed lost, (B,)."""
        return self.rows[:, kernels.CHANNEL_QUALITY]

    @property
    def max_inter_transmit_time_s(self) -> FloatArray:
        """Longest time to the next message, (B,) [s]."""
        return self.rows[:, kernels.INTER_TRANSMIT_TIME_S]

    @property
    def next_s(self) -> FloatArray:
        """When the next message is scheduled, (B,) [s]."""
        return self.rows[:, kernels.NEXT_S]

    @property
    def probability(self) -> FloatArray:
        """Transmit probability of the last rate control, (B,)."""
        return self.rows[:, kernels.PROBABILITY]


@dataclass(frozen=True, slots=True)
class J2945(AbstractTransmitPolicy[J2945State]):
    """The rules of SAE J2945/1 for B vehicles, each with timers of its own.

    Asked at ``t_s``, it answers for the interval up to ``until_s``, one rate control interval where that is
    None. A message leaves within it, at ``Decisions.send_s``. A second one that falls due in the same
    interval leaves at the start of the next; in intervals up to the shortest inter-transmit time less the
    jitter, 95 ms, there is none. An engine with steps as long as the rate control interval should ask each
    vehicle at its own phase within the step (`phases`): messages by error leave at ``t_s``, and would else
    all leave together.

    It needs `Motion`, for critical events, and `Air`. The tracking error is one column, (B, 1), against what
    the remotes are believed to hold.

    Parameters
    ----------
    parameters
        Constants; `j3161_parameters` and `j2945_relaxed_parameters` give other sets.
    start_s
        When the vehicles begin [s].
    phase_ratio
        Where in a timer's interval each vehicle begins, (B,) in [0, 1); None spreads them evenly, by a
        low-discrepancy sequence.

    Examples
    --------
    >>> J2945().init(3, 1).next_s.round(3).tolist()
    [0.0, 0.062, 0.024]
    """

    parameters: J2945Parameters = field(default_factory=J2945Parameters)
    start_s: float = 0.0
    phase_ratio: FloatArray | None = None

    @property
    def numbers(self) -> PolicyNumbers:
        """The constants of `J2945Parameters`."""
        return PolicyNumbers(
            RULE_J2945,
            self.parameters.constants(),
            dcc_kernels.NONE,
            np.zeros(1),
            0.0,
            0.0,
            self.parameters.critical_deceleration_mps2,
        )

    @property
    def longest_silence_s(self) -> float:
        """The maximum inter-transmit time [s]."""
        return self.parameters.max_inter_transmit_time_s

    def phases(self, vehicles: int) -> FloatArray:
        """Where in a timer's interval each of so many vehicles begins, (B,).

        Parameters
        ----------
        vehicles
            How many, B.

        Raises
        ------
        ValueError
            Where `phase_ratio` is not one a vehicle.
        """
        phase = np.arange(vehicles) * _GOLDEN % 1.0 if self.phase_ratio is None else self.phase_ratio
        if phase.shape != (vehicles,):
            raise ValueError(f"phase_ratio must be ({vehicles},), one a vehicle, got {phase.shape}")
        return phase

    def init(self, vehicles: int, sub_models: int) -> J2945State:  # noqa: ARG002 - any bank will do
        """Nothing sent; the first message falls due within one rate control interval."""
        phase = self.phases(vehicles)
        rows = np.empty((vehicles, kernels.STATE_COLUMNS))
        constants = self.parameters.constants()
        for row, share in zip(rows, phase, strict=True):
            kernels.start(row, self.start_s, float(share), constants)
        return J2945State(rows, np.zeros(vehicles, dtype=np.int64))

    def decide(
        self, state: J2945State, inputs: TransmitInputs, rng: np.random.Generator
    ) -> tuple[Decisions, J2945State]:
        """Run the compiled step for every vehicle; three random numbers a vehicle, whatever happens."""
        motion = required(inputs.motion, "motion", "J2945")
        air = required(inputs.air, "air", "J2945")
        vehicles = state.rows.shape[0]
        if inputs.tracking_error_m.shape != (vehicles, 1):
            raise ValueError(
                f"tracking_error_m must be ({vehicles}, 1), the error of what the remotes are believed to "
                f"hold, got {inputs.tracking_error_m.shape}"
            )
        until_s = inputs.until_s
        if until_s is None:
            until_s = inputs.t_s + self.parameters.rate_control_interval_s
        rows = state.rows.copy()
        cause = np.empty(vehicles, dtype=np.int64)
        send_s, power_dbm = np.empty(vehicles), np.empty(vehicles)
        believed = np.empty(vehicles, dtype=np.bool_)
        seen = kernels.Vehicles(
            owned(inputs.t_s),
            owned(until_s),
            owned(inputs.tracking_error_m[:, 0]),
            owned(air.channel_busy_ratio),
            owned(air.neighbours),
            owned(air.packet_error_ratio),
            np.ascontiguousarray(motion.critical),
            rng.random((vehicles, 3)),
        )
        constants = self.parameters.constants()
        kernels.step_each(rows, seen, constants, cause, send_s, power_dbm, believed)
        kind = np.where(cause != Cause.NOTHING, MessageKind.UPDATE, MessageKind.NOTHING).astype(np.int64)
        decisions = Decisions(
            kind, np.zeros_like(kind), send_s=send_s, power_dbm=power_dbm, believed=believed
        )
        return decisions, J2945State(rows, cause)


_GOLDEN = (5.0**0.5 - 1.0) / 2.0


def transmit_probability(
    tracking_error_m: FloatArray, parameters: J2945Parameters | None = None
) -> FloatArray:
    """Probability of a message for each tracking error, (B,).

    Parameters
    ----------
    tracking_error_m
        (B,) [m].
    parameters
        Constants; None for the standard's.

    Examples
    --------
    >>> transmit_probability(np.array([0.1, 0.31, 0.44, 0.5])).round(2).tolist()
    [0.0, 0.6, 0.99, 1.0]
    """
    constants = (J2945Parameters() if parameters is None else parameters).constants()
    return np.array([kernels.transmit_probability(float(error), constants) for error in tracking_error_m])


def max_inter_transmit_time(density: FloatArray, parameters: J2945Parameters | None = None) -> FloatArray:
    """Longest time between messages for each smoothed vehicle density, (B,) [s].

    Parameters
    ----------
    density
        Remotes within range, (B,).
    parameters
        Constants; None for the standard's.

    Examples
    --------
    >>> max_inter_transmit_time(np.array([10.0, 50.0, 200.0])).tolist()
    [0.1, 0.2, 0.6]
    """
    constants = (J2945Parameters() if parameters is None else parameters).constants()
    return np.array([kernels.max_inter_transmit_time(float(remotes), constants) for remotes in density])

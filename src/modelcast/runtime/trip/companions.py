"""What the companions of a recorded trip say, and whom its sender therefore believes ahead."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.models.bank import Bank
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.context.ahead_kernels import hear_and_follow
from modelcast.station.context.ahead_numbers import followers
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.heard_kernels import Messages
from modelcast.station.receiver.hearing_kernels import EVENTS, STATUSES
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap
from modelcast.station.sensing.velocity import VelocityEstimator
from modelcast.trips.trajectory import Trajectory

__all__ = ["Told", "hearing", "tell"]

_EXPIRY_S = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """Updates of one companion, K of them.

    Parameters
    ----------
    vehicle
        Its temporary id.
    sample
        Sample that each was sent at, (K,).
    t_s, stated_s
        When each was sent, and the instant it states, (K,) [s].
    stated_m
        Place it states, (K, 2) [m].
    motion
        The sample's columns, (K, 9).
    parameters
        As decoded, (K, P).
    in_use
        Sub-model in use, (K,).
    """

    vehicle: int
    sample: IntArray
    t_s: FloatArray
    stated_s: FloatArray
    stated_m: FloatArray
    motion: FloatArray
    parameters: FloatArray
    in_use: IntArray

    def heard_by(self, stated_m: FloatArray, later_s: float, lost: BoolArray) -> "Told":
        """What arrives of it at a host.

        Parameters
        ----------
        stated_m
            The places in the host's frame, (K, 2) [m].
        later_s
            How much later the companion's clock began than the host's [s].
        lost
            Which are lost, (K,).
        """
        kept = ~lost
        return replace(
            self,
            sample=self.sample[kept],
            t_s=self.t_s[kept] + later_s,
            stated_s=self.stated_s[kept] + later_s,
            stated_m=stated_m[kept],
            motion=self.motion[kept],
            parameters=self.parameters[kept],
            in_use=self.in_use[kept],
        )


def tell(
    trip: Trajectory,
    estimator: VelocityEstimator,
    bank: Bank,
    *,
    vehicle: int,
    threshold_m: float,
    keep_alive_s: float,
) -> Told:
    """Updates that a companion sends over its whole trip, identifications not among them.

    Parameters
    ----------
    trip, estimator, bank
        As for `TripRuntime`.
    vehicle
        Its temporary id.
    threshold_m, keep_alive_s
        Tracking error and silence at which it sends [m], [s].
    """
    ready = TripRuntime(trip, bank, estimator, quantised=True)
    sent = ready.run(ErrorDriven(threshold_m, identify="never", max_inter_transmit_time_s=keep_alive_s))
    at = np.flatnonzero(sent.transmits)
    content = ready.sent(sent, temporary_id=vehicle)
    return Told(
        vehicle, at, content.t_s, content.fit_s, content.stated_m, content.sample, content.parameters,
        content.in_use,
    )  # fmt: skip


def hearing(
    told: Sequence[Told],
    trip: Trajectory,
    samples: FloatArray,
    bank: Bank,
    *,
    delay_s: float,
    out: FloatArray,
) -> None:
    """Write the leader's columns of a trip's context from what its companions say.

    Parameters
    ----------
    told
        What arrives of each.
    trip, samples
        The host's trip and its samples, (T, 9).
    bank
        What companions send.
    delay_s
        From the instant of a message to its arrival [s].
    out
        The context, (T, 13).
    """
    heard = _in_order(told, delay_s)
    around = LocalDynamicMap(
        (bank.carried().complete(),), _EXPIRY_S, capacity=len(told), dt_s=trip.dt_s, max_age_s=np.inf
    )
    state = around.init()
    hear_and_follow(
        Messages(
            owned(heard.codes, np.int64),
            owned(heard.numbers),
            owned(_wide(heard.parameters, state.parameters)),
        ),
        state.slots,
        around.known,
        around.rules,
        np.zeros((2, max(STATUSES, EVENTS)), dtype=np.int64),
        followers(1),
        trip.t_s,
        samples,
        out,
    )


def _wide(parameters: FloatArray, held: FloatArray) -> FloatArray:
    """Parameters in as many columns as a map holds."""
    found = np.full((len(parameters), held.shape[1]), np.nan)
    found[:, : parameters.shape[1]] = parameters
    return found


def _in_order(told: Sequence[Told], delay_s: float) -> Heard:
    """All messages as they arrive."""
    arrival_s = np.concatenate([one.t_s for one in told]) + delay_s
    order = np.argsort(arrival_s, kind="stable")
    motion = np.concatenate([one.motion for one in told])[order]
    east, north = motion[:, VELOCITY_EAST], motion[:, VELOCITY_NORTH]
    unknown, whole = np.full(order.size, np.nan), np.zeros(order.size, dtype=np.int64)
    return Heard(
        np.full(order.size, int(HeardKind.UPDATE)),
        np.concatenate([np.full(one.t_s.size, one.vehicle) for one in told])[order],
        np.concatenate([np.arange(one.t_s.size) for one in told])[order],
        t_s=np.concatenate([one.stated_s for one in told])[order],
        received_s=arrival_s[order],
        position_m=np.concatenate([one.stated_m for one in told])[order],
        speed_mps=np.hypot(east, north),
        heading_rad=np.arctan2(east, north),
        acceleration_mps2=motion[:, ACCELERATION],
        yaw_rate_radps=motion[:, YAW_RATE],
        profile=whole,
        in_use=np.concatenate([one.in_use for one in told])[order],
        parameters=np.concatenate([one.parameters for one in told])[order],
        length_m=unknown,
        width_m=unknown,
        user=whole - 1,
    )

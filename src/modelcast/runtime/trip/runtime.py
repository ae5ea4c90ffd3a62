"""A recorded trip as one vehicle's station: samples sensed once, fits shared by every rule and threshold.

Fits happen only at the instants that some policy asks for, and are kept; a run is then cheap, so thresholds,
loss ratios and seeds cost little beyond the first.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.messages.mbc_profile import carries_all
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.runtime.trip import errors_kernels
from modelcast.runtime.trip.decided import decided_walk
from modelcast.station.arrays import Sensed, fits, lanes
from modelcast.station.policy.base import AbstractTransmitPolicy, MessageKind, at_threshold
from modelcast.station.policy.believed_loss_kernels import DEPTH
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender import fitting_kernels, speaking_kernels
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sender.lane_rules import speaking_lanes
from modelcast.station.sender.octets import SentMessages
from modelcast.station.sensing.sensing import Sensing, sensed_trip
from modelcast.station.sensing.streaming import with_states
from modelcast.station.sensing.velocity import VelocityEstimator
from modelcast.trips.trajectory import Trajectory

__all__ = ["TripMessages", "TripRuntime", "sense_trip"]


@dataclass(frozen=True, slots=True)
class TripMessages:
    """What one policy sent over one trip; all arrays have one row a sample.

    Parameters
    ----------
    policy
        The policy.
    kind
        `MessageKind` sent at each sample, (T,).
    in_use
        Sub-model in use after the sample's message, (T,).
    update_index
        Sample of the last model update, this one included, (T,).
    """

    policy: ErrorDriven
    kind: IntArray
    _: KW_ONLY
    in_use: IntArray
    update_index: IntArray

    @property
    def updates(self) -> int:
        """Model updates sent, keep-alives among them."""
        return int(((self.kind == MessageKind.UPDATE) | (self.kind == MessageKind.KEEP_ALIVE)).sum())

    @property
    def identifications(self) -> int:
        """Sub-model identifications sent."""
        return int((self.kind == MessageKind.IDENTIFICATION).sum())

    @property
    def transmits(self) -> BoolArray:
        """Samples with a message, (T,)."""
        return self.kind != MessageKind.NOTHING


def sense_trip(trip: Trajectory, estimator: VelocityEstimator, *, quantised: bool = False) -> Sensed:
    """Sense a whole trip, for all banks that are run over it.

    Parameters
    ----------
    trip
        What the sender sees.
    estimator
        The velocity that constant velocity coasts with.
    quantised
        Whether positions are stated as messages can say them, or as they were measured.
    """
    return sensed_trip(trip, Sensing.of(trip, estimator, quantised=quantised))


class TripRuntime:
    """One bank made ready for one trip: what was sensed, compiled members and the memo of fits.

    Parameters
    ----------
    trip
        What the sender sees.
    bank
        Its sub-models.
    estimator
        The velocity that constant velocity coasts with.
    selector
        Predicts which sub-model lasts; needed by policies that start with the predicted one.
    quantised
        Whether the sub-models' parameters and the positions go through the codes of the wire.
    sensed
        What `sense_trip` made of the trip, where that is at hand.
    context
        The vehicle ahead and the road at every sample, (T, 13), as `modelcast.runtime.trip.context` finds
        them, for a bank that reads them; None where nothing is known.
    decides
        A policy in NumPy that calls for the messages, at the threshold of whatever rule is run; None for the
        rules themselves.

    Raises
    ------
    ValueError
        Where the selector was trained for another bank, or there is not one row of context a sample.

    Notes
    -----
    A bank whose members all need longer windows is completed by constant velocity, which then serves where no
    other member has a full window, and only there.
    """

    def __init__(
        self,
        trip: Trajectory,
        bank: Bank,
        estimator: VelocityEstimator,
        selector: Selector | None = None,
        *,
        quantised: bool = False,
        sensed: Sensed | None = None,
        context: FloatArray | None = None,
        decides: AbstractTransmitPolicy[Any] | None = None,
    ) -> None:
        self.trip, self._decides = trip, decides
        self._decided: dict[float, TripMessages] = {}
        self.own = SenderBank.of(bank, trip.dt_s, quantised=quantised, selector=selector)
        self.bank = self.own.bank
        held = sense_trip(trip, estimator, quantised=quantised) if sensed is None else sensed
        self.sensed = with_states(held, self.own.ready, context)
        self.fits = fits(1, len(trip), members=len(self.bank.members), parameters=int(self.bank.offsets[-1]))

    @property
    def samples(self) -> FloatArray:
        """What windows are cut from, (T, 9)."""
        return np.ascontiguousarray(self.sensed.samples[0, : len(self.trip), :SAMPLE_COLUMNS])

    @property
    def stated_s(self) -> FloatArray:
        """Instants as messages state them, (T,) [s]."""
        return self.sensed.stated_s[0]

    @property
    def stated_m(self) -> FloatArray:
        """Positions as messages state them, (T, 2) [m]."""
        return self.sensed.stated_m[0]

    @property
    def parameters(self) -> FloatArray:
        """Parameters of all members by the sample they were fitted at, (T, P); zeros where they were not."""
        return self.fits.parameters[0]

    def run(self, policy: ErrorDriven) -> TripMessages:
        """Drive the trip by one policy, as `run_each` does.

        Parameters
        ----------
        policy
            Threshold, rules and longest silence.
        """
        return self.run_each([policy])[0]

    def run_each(self, policies: Sequence[ErrorDriven]) -> list[TripMessages]:
        """Drive the trip by several policies at once, fitting where one of them updates.

        Parameters
        ----------
        policies
            Threshold, rules and longest silence of each.

        Raises
        ------
        ValueError
            Where a policy starts with the predicted sub-model and there is no selector, its costs were
            counted for a bank of another size, or it is guarded and the bank lacks constant velocity.
        """
        if self._decides is not None:
            return [self._decided_at(self._decides, policy.threshold_m) for policy in policies]
        members = len(self.bank.members)
        rules = [policy if members > 1 else policy.alone for policy in policies]
        for rule in rules:
            if rule.costs is not None and rule.identify == "cheapest":
                rule.costs.check_members(members)
        guards = self.own.guards if any(rule.start == "guarded" for rule in rules) else ()
        spoken = speaking_lanes(
            rules, [0] * len(rules), guards=guards, dt_s=self.trip.dt_s, selector=self.own.selector
        )
        count = spoken.rules.vehicle.size
        older = DEPTH - 1 if spoken.rules.expects.any() else 0
        state = lanes(count, members=members, parameters=int(self.bank.offsets[-1]), older=older)
        state.loss[:] = spoken.rules.loss
        kind, in_use, update_index = (np.empty((count, len(self.trip)), dtype=np.int64) for _ in range(3))
        speaking_kernels.speak_through(
            self.own.models(guards), self.sensed, self.fits, spoken.rules, state, kind, in_use, update_index
        )
        return [
            TripMessages(policy, kind[lane], in_use=in_use[lane], update_index=update_index[lane])
            for policy, lane in zip(policies, spoken.speaks.tolist(), strict=True)
        ]

    def _decided_at(self, decides: AbstractTransmitPolicy[Any], threshold_m: float) -> TripMessages:
        """Drive the trip by a policy in NumPy at a threshold; what it did once is kept."""
        if threshold_m not in self._decided:
            rule = ErrorDriven(threshold_m, "recent", "never")
            gain = self.trip.acceleration_mps2
            known = np.zeros(len(self.trip)) if gain is None else gain
            kind, in_use, update_index = decided_walk(
                at_threshold(decides, threshold_m),
                rule if len(self.bank.members) > 1 else rule.alone,
                self.own,
                self.sensed,
                self.fits,
                t_s=self.trip.t_s,
                critical=known < -decides.numbers.critical_mps2,
                rng=child_generator(0, self.trip.trip_id, "policy"),
            )
            self._decided[threshold_m] = TripMessages(rule, kind, in_use=in_use, update_index=update_index)
        return self._decided[threshold_m]

    def sent(self, messages: TripMessages, *, temporary_id: int = 0) -> SentMessages:
        """Content of the messages of a policy, as its receivers decode it.

        Parameters
        ----------
        messages
            Of a policy over this trip.
        temporary_id
            Of the sender.
        """
        at = np.flatnonzero(messages.transmits)
        named = messages.update_index[at]
        in_use, offsets = messages.in_use[at], self.bank.offsets
        identify = messages.policy.identify if len(self.bank.members) > 1 else "never"
        fitted = self.fits.number[0, named] == named[:, None]
        if not carries_all(self.bank, identify):
            fitted &= np.arange(len(self.bank.members)) == in_use[:, None]
        held = np.repeat(fitted, np.diff(offsets), axis=1)
        return SentMessages(
            messages.kind[at],
            np.arange(at.size),
            vehicle=np.full(at.size, temporary_id),
            t_s=self.trip.t_s[at],
            sample=self.samples[at],
            stated_m=self.stated_m[named],
            in_use=in_use,
            parameters=np.where(held, self.parameters[named], 0.0),
            update=np.searchsorted(at, named),
            fit_s=self.stated_s[named],
        )

    def tracking_error_m(self, messages: TripMessages) -> FloatArray:
        """Error of every member fitted at the last update before each sample, (T, M) [m].

        Before the sample's message; infinite where a member had no full window.

        Parameters
        ----------
        messages
            Of a policy over this trip.
        """
        self.fit_at(np.unique(messages.update_index))
        errors = np.empty((len(self.trip), len(self.bank.members)))
        errors_kernels.member_errors(
            self.own.models(), self.sensed, self.fits, messages.in_use, messages.update_index, errors
        )
        return errors

    def first_served(self, indices: IntArray) -> IntArray:
        """First member in the bank's order that has a full window at each of some samples, (K,).

        Parameters
        ----------
        indices
            Samples, (K,).
        """
        self.fit_at(np.unique(indices))
        return np.argmax(self.fits.number[0, indices] == indices[:, None], axis=1)

    def fit_at(self, indices: npt.ArrayLike) -> None:
        """Fit every member at these samples, as an update there would.

        Parameters
        ----------
        indices
            Samples, (K,).
        """
        fitting_kernels.fit_each(
            self.own.models(), self.sensed, self.fits, np.ascontiguousarray(indices, dtype=np.int64)
        )

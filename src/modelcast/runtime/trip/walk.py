"""The sender's side of an evaluation: one bank walked over one trip, its fits shared by every threshold.

Fits happen only at the instants that some policy visits, and are kept; a walk is then cheap, so thresholds,
loss ratios and seeds cost little beyond the first.
"""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.members import ReadyBank
from modelcast.runtime.trip import walk_kernels
from modelcast.station.policy.base import Message
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.guard import ALLOWED, GUARD, unguarded
from modelcast.station.sensing.velocity import VelocityEstimator, sample_matrix
from modelcast.trips.trajectory import Trajectory

__all__ = ["TripBank", "Walk"]

_NOTHING: BoolArray = np.zeros(0, dtype=np.bool_)


@dataclass(frozen=True, slots=True)
class Walk:
    """What one policy did over one trip; all arrays have one row a sample.

    Parameters
    ----------
    policy
        The policy that was walked.
    kind
        `Message` sent at each sample, (T,).
    in_use
        Sub-model in use after the sample's message, (T,).
    update_index
        Sample of the last model update, this one included, (T,).
    tracking_error_m
        Error of every sub-model fitted at the last update before this sample, before its message, infinite
        where it had no full window, (T, M) [m].
    """

    policy: ErrorDriven
    kind: IntArray
    _: KW_ONLY
    in_use: IntArray
    update_index: IntArray
    tracking_error_m: FloatArray

    @property
    def updates(self) -> int:
        """Model updates sent, keep-alives among them."""
        return int(((self.kind == Message.UPDATE) | (self.kind == Message.KEEP_ALIVE)).sum())

    @property
    def identifications(self) -> int:
        """Sub-model identifications sent."""
        return int((self.kind == Message.IDENTIFICATION).sum())

    @property
    def transmits(self) -> BoolArray:
        """Samples with a message, (T,)."""
        return self.kind != Message.NOTHING


class TripBank:
    """One bank made ready for one trip: windows, compiled members and the memo of fits.

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

    Raises
    ------
    ValueError
        Where the selector was trained for another bank.

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
    ) -> None:
        self.trip = trip
        self._estimator = estimator
        self._alone: TripBank | None = None
        self.bank = bank.complete()
        self.selector = selector
        if selector is not None:
            selector.check_members(tuple(member.name for member in self.bank.members))
        self._fallback = -1 if self.bank is bank else len(bank.members)
        self.samples = sample_matrix(trip, estimator)
        self.ready = ReadyBank.of(self.bank, trip.dt_s)
        self.parameters = np.zeros((len(trip), int(self.bank.offsets[-1])))
        self.fitted = np.zeros(len(trip), dtype=np.bool_)
        self._segment_start = trip.segment_start

    def walk(self, policy: ErrorDriven) -> Walk:
        """Walk the trip with this policy, fitting where it updates.

        Parameters
        ----------
        policy
            Threshold, rules and longest silence.

        Raises
        ------
        ValueError
            Where the policy starts with the predicted sub-model and there is no selector, its costs were
            counted for a bank of another size, or it is guarded and the bank lacks constant velocity.
        """
        rules = policy if len(self.bank.members) > 1 else policy.alone
        if rules.start == "guarded" and self._fallback == 1:
            rules = replace(rules, start="order")  # one sub-model and what stands in for it: nothing to guard
        if rules.costs is not None and rules.identify == "cheapest":
            rules.costs.check_members(len(self.bank.members))
        if rules.start == "guarded":
            return self._guarded(policy, rules)
        return self._walk(policy, rules)

    def _guarded(self, policy: ErrorDriven, rules: ErrorDriven) -> Walk:
        """The walk with a guard; that of the bank without one wherever it would not have acted."""
        place = self.bank.place_of(GUARD)
        if place == self._fallback:
            raise ValueError(f"start 'guarded' needs {GUARD} as a member of its own: add it")
        if self._alone is None:
            self._alone = TripBank(self.trip, Bank((self.bank.members[place],)), self._estimator)
        free = self.walk(replace(rules, start=unguarded(rules.start)))
        alone = self._alone.walk(rules)
        behind = np.cumsum(free.transmits.astype(np.int64) - alone.transmits)
        if behind.max() < ALLOWED:
            return replace(free, policy=policy)
        return self._walk(policy, rules, place, free.transmits, alone.transmits)

    def _walk(
        self,
        policy: ErrorDriven,
        rules: ErrorDriven,
        guard: int = -1,
        free_sends: BoolArray = _NOTHING,
        guard_sends: BoolArray = _NOTHING,
    ) -> Walk:
        """Walk by ``rules``, guarded by a member where ``guard`` names one."""
        select, constants, window = self._select(rules)
        count = len(self.trip)
        kind = np.empty(count, dtype=np.int64)
        in_use = np.empty(count, dtype=np.int64)
        update_index = np.empty(count, dtype=np.int64)
        tracking_error_m = np.empty((count, len(self.bank.members)))
        walk_kernels.walk(
            self.ready.members,
            self._fallback,
            guard,
            free_sends,
            guard_sends,
            self.trip.t_s,
            self.samples,
            self._segment_start,
            self.parameters,
            self.fitted,
            select,
            constants,
            window,
            self.trip.dt_s,
            rules.start_code,
            *rules.codes,
            tracking_error_m,
            kind,
            in_use,
            update_index,
        )
        return Walk(
            policy,
            kind,
            in_use=in_use,
            update_index=update_index,
            tracking_error_m=tracking_error_m,
        )

    def _select(self, policy: ErrorDriven) -> tuple[int, FloatArray, int]:
        """The selector's address (0 for none), its constants at the policy's threshold, and its window."""
        if policy.start != "predicted":
            return 0, np.zeros(1), 1
        if self.selector is None:
            raise ValueError("start 'predicted' needs a selector: train one for this bank, or start in order")
        window = self.selector.window_at(self.trip.dt_s)
        return self.selector.address, self.selector.packed(self.trip.dt_s, policy.threshold_m), window

    def fit_at(self, indices: npt.ArrayLike) -> None:
        """Fit every member at these samples, as an update there would.

        Parameters
        ----------
        indices
            Samples, (K,).
        """
        walk_kernels.fit_each(
            self.ready.members,
            self.samples,
            self._segment_start,
            np.ascontiguousarray(indices, dtype=np.int64),
            self.parameters,
            self.fitted,
        )

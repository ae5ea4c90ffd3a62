"""The error-driven policy: speak when no sub-model tracks any more (the paper's Algorithm 1).

At every sample the sender compares its position with what each sub-model fitted at the last update
predicts.

- *Model update*: every sub-model's error has reached the threshold. All are fitted anew.
- *Sub-model identification*: the one in use has failed, another still holds. The paper names this message and
  leaves its rule open; `ErrorDriven.identify` offers five.
- *Keep-alive*: an update sent because nothing was for `ErrorDriven.max_inter_transmit_time_s`.

An error equal to the threshold counts as failed. The baseline is the same policy over a bank of constant
velocity alone, which never needs an identification.
"""

from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.station.policy import believed_loss_kernels, dcc_kernels
from modelcast.station.policy import error_driven_kernels as kernels
from modelcast.station.policy.base import AbstractTransmitPolicy, Decisions, TransmitInputs, required
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.policy_numbers import RULE_ERROR_DRIVEN, PolicyNumbers
from modelcast.station.policy.rules import BelieveRule, IdentifyRule, StartRule

__all__ = ["APPROACH_M", "LOSS_BUDGET", "ErrorDriven", "ErrorDrivenState"]

LOSS_BUDGET = 4.0 / 3.0
"""Messages that a sender which believes in losses may send, over those without losses: about what constant
velocity sends over the free model (`docs/loss.md`)."""

APPROACH_M = 20.0
"""Way that two vehicles may come closer between two messages, of senders on the air [m]: a remote that comes
from 350 m to 150 m is sent ten, and misses all with probability 1 % where 63 % are lost."""

_STARTS = {
    "order": kernels.START_ORDER,
    "keep": kernels.START_KEEP,
    "survivor": kernels.START_SURVIVOR,
    "predicted": kernels.START_PREDICTED,
    "hindsight": kernels.START_HINDSIGHT,
    "guarded": kernels.START_GUARDED,
    "recent": kernels.START_RECENT,
}
_IDENTIFIES = {
    "on-failure": kernels.IDENTIFY_ON_FAILURE,
    "final": kernels.IDENTIFY_FINAL,
    "best": kernels.IDENTIFY_BEST,
    "never": kernels.IDENTIFY_NEVER,
    "cheapest": kernels.IDENTIFY_CHEAPEST,
}

_NO_COSTS = np.zeros(kernels.COST_HEADER)


LOSS_SURVEY = J2945Parameters(max_packet_error_ratio=believed_loss_kernels.MOST_LOST)
"""How a station on the air observes losses: as SAE J2945/1 has it, with a higher cap than its 0.3."""


@dataclass(frozen=True, slots=True)
class ErrorDrivenState:
    """State of B vehicles.

    Parameters
    ----------
    in_use
        Sub-model in use, -1 before the first update, (B,).
    first_failure_s
        Age of the update at each sub-model's first failure, infinite while it has none, (B, M) [s].
    """

    in_use: IntArray
    first_failure_s: FloatArray


@dataclass(frozen=True, slots=True)
class ErrorDriven(AbstractTransmitPolicy[ErrorDrivenState]):
    """Algorithm 1 of the paper, with what it leaves open made an option.

    Parameters
    ----------
    threshold_m
        Tracking error at which a sub-model has failed [m].
    start
        Sub-model in use after an update: the first in the bank's ``order`` that has a full window (default:
        the paper's bank starts with constant velocity); the one in use before (``keep``); the one that
        lasted longest since the last update (``survivor``); or the one that should last longest by what the
        inputs say (`TransmitInputs.predicted_life`), in order where they say nothing. Who makes the inputs
        takes them from a selector (``predicted``, `modelcast.models.learned.Selector`) or from how
        predictions of the last two seconds did (``hindsight``, `modelcast.station.policy.hindsight`;
        ``guarded``, the same, and in a station a plain sub-model while the bank has fallen behind it,
        `modelcast.station.policy.guard`), or the smallest of those that erred least from one message to the
        next, older messages counting less and less (``recent``).
    identify
        ``on-failure`` (default): when the one in use fails while another holds at that instant, name the one
        with the smallest error; it leaves Algorithm 1's update rule untouched and sends the fewest messages a
        receiver can follow. ``final``: the same, but a sub-model that failed once is not used again before
        the next update, which therefore comes once each has failed at some time, not when all fail at once.
        ``best``: at every change of the best. ``never``: when the one in use fails, all are fitted anew,
        whether another still holds or not; only the one in use need be sent. ``cheapest``: when the one in
        use fails, name the one that is expected to hold longest, but only where that costs less a second than
        an update does; else all are fitted anew.
    max_inter_transmit_time_s
        Longest silence before a keep-alive [s]; None for no limit.
    costs
        What messages cost and how long they serve; needed for ``cheapest``, unused otherwise.
    believe
        What the sender takes its remotes to hold. ``sent`` (the paper): whatever it sent last. ``expected``:
        each of its last messages with the probability that it is the newest not lost; the mean of their
        errors calls for a message. Nobody is then named without an update, and the keep-alive stays.
    packet_error_ratio
        Share of its messages that the sender believes lost, 0..1, for ``expected`` over recorded trips. A
        station on the air takes what it observes instead (`modelcast.station.policy.neighbours`).
    budget
        How many times the messages of a channel without losses a sender that expects may send
        (`believed_loss_kernels.error_growth`); infinite to hold the expected error under the threshold
        whatever it costs.
    approach_m
        Way that two vehicles, both as fast as this one, may come closer between two messages [m]: the keep-
        alive of a fast one is shorter, so that those who come towards it know it in time. Infinite for
        none.
    legacy_threshold_m
        Error of legacy receivers that calls for an update whatever the sub-models do [m]: of those that coast
        place, speed and heading of the last update's Part I at constant velocity. Infinite for not minding
        them. It holds at the sender's own samples; what is lost on the way they miss as everybody does.

    Raises
    ------
    ValueError
        Where a threshold, time, way or budget is not positive, a ratio no share, a rule unknown, ``cheapest``
        has no costs, or ``expected`` starts with the survivor.

    Notes
    -----
    With p the share lost, e_k the error now of the message k before the newest, and n remembered:
    ``E = Σ (1 - p)·p^k·e_k``, the oldest standing for all before it. A message is sent when E reaches
    ``max(1, (1 + p)/((1 - p)²·m²))`` thresholds, m being the budget. At p = 0 this is Algorithm 1. SAE
    J2945/1 (6.3.8.5) draws for each message whether remotes hold it (`modelcast.station.policy.j2945`).

    Examples
    --------
    >>> ErrorDriven(0.2, max_inter_transmit_time_s=2.0).start
    'order'
    """

    threshold_m: float
    start: StartRule = "order"
    identify: IdentifyRule = "on-failure"
    max_inter_transmit_time_s: float | None = None
    costs: CostTable | None = None
    believe: BelieveRule = "sent"
    packet_error_ratio: float = 0.0
    budget: float = LOSS_BUDGET
    approach_m: float = np.inf
    legacy_threshold_m: float = np.inf

    def __post_init__(self) -> None:
        if not self.threshold_m > 0:
            raise ValueError(f"threshold_m must be positive, got {self.threshold_m}")
        if self.start not in _STARTS:
            raise ValueError(f"start must be one of {', '.join(_STARTS)}, got {self.start!r}")
        if self.identify not in _IDENTIFIES:
            raise ValueError(f"identify must be one of {', '.join(_IDENTIFIES)}, got {self.identify!r}")
        longest = self.max_inter_transmit_time_s
        if longest is not None and not longest > 0:
            raise ValueError(f"max_inter_transmit_time_s must be positive or None, got {longest}")
        if self.identify == "cheapest" and self.costs is None:
            raise ValueError("identify 'cheapest' needs costs: train a CostTable, or take another rule")
        self._check_belief()

    def _check_belief(self) -> None:
        if self.believe not in get_args(BelieveRule):
            known = ", ".join(get_args(BelieveRule))
            raise ValueError(f"believe must be one of {known}, got {self.believe!r}")
        if not 0.0 <= self.packet_error_ratio <= 1.0:
            raise ValueError(f"packet_error_ratio must be a share, 0 to 1, got {self.packet_error_ratio}")
        for name in ("budget", "approach_m", "legacy_threshold_m"):
            value: float = getattr(self, name)
            if not value > 0:
                raise ValueError(f"{name} must be positive, got {value}")
        if self.expects and self.start == "survivor":
            raise ValueError("believe 'expected' does not ask when each failed: start must not be 'survivor'")

    @property
    def alone(self) -> "ErrorDriven":
        """The same over a bank of one, which has nothing to select from."""
        return replace(self, start="order", identify="never", costs=None)

    @property
    def expects(self) -> bool:
        """Whether the error expected over all that remotes may hold calls for messages."""
        return self.believe == "expected"

    @property
    def believed_loss(self) -> float:
        """Share of messages believed lost at first."""
        return believed_loss_kernels.believed_loss(self.packet_error_ratio) if self.expects else 0.0

    @property
    def codes(self) -> tuple[float, float, int, FloatArray]:
        """The trailing arguments of the compiled step."""
        longest = self.max_inter_transmit_time_s
        costs = _NO_COSTS if self.costs is None else self.costs.packed(self.threshold_m)
        return self.threshold_m, np.inf if longest is None else longest, _IDENTIFIES[self.identify], costs

    @property
    def start_code(self) -> int:
        """The trailing argument of the compiled start rule."""
        return _STARTS[self.start]

    @property
    def numbers(self) -> PolicyNumbers:
        """How a station on the air observes losses; its lanes' rules are those of `sender.lane_rules`."""
        nothing = np.zeros(1)
        own = LOSS_SURVEY.constants() if self.expects else nothing
        return PolicyNumbers(RULE_ERROR_DRIVEN, own, dcc_kernels.NONE, nothing, 0.0, 0.0, np.inf)

    @property
    def longest_silence_s(self) -> float:
        """Time to a keep-alive, infinite without [s]."""
        return self.codes[1]

    def init(self, vehicles: int, sub_models: int) -> ErrorDrivenState:
        """Nothing in use, nothing failed."""
        return ErrorDrivenState(
            np.full(vehicles, -1, dtype=np.int64), np.full((vehicles, sub_models), np.inf)
        )

    def decide(
        self,
        state: ErrorDrivenState,
        inputs: TransmitInputs,
        rng: np.random.Generator,  # noqa: ARG002 - this policy draws nothing
    ) -> tuple[Decisions, ErrorDrivenState]:
        """Run the compiled steps for every vehicle; the message leaves at once.

        Who makes the inputs of a policy that expects gives the expected error in place of each sub-model's.
        `approach_m` needs `TransmitInputs.motion`, `legacy_threshold_m` its ``legacy_error_m``.
        """
        if self.costs is not None and self.identify == "cheapest":
            self.costs.check_members(state.first_failure_s.shape[1])
        kind = np.empty_like(state.in_use)
        in_use = np.empty_like(state.in_use)
        first_failure_s = state.first_failure_s.copy()
        scores = inputs.predicted_life
        speed_mps = np.zeros(kind.size)
        if self.approach_m < np.inf:
            speed_mps = required(inputs.motion, "motion", "ErrorDriven").speed_mps
        legacy_error_m = np.zeros(kind.size)
        if self.legacy_threshold_m < np.inf:
            legacy_error_m = required(inputs.legacy_error_m, "legacy_error_m", "ErrorDriven")
        seen = kernels.Vehicles(
            np.ascontiguousarray(inputs.tracking_error_m, dtype=np.float64),
            np.ascontiguousarray(inputs.available),
            np.full_like(first_failure_s, np.nan) if scores is None else owned(scores),
            state.in_use,
            np.ascontiguousarray(inputs.age_s, dtype=np.float64),
            np.ascontiguousarray(inputs.silence_s, dtype=np.float64),
            owned(speed_mps),
            owned(legacy_error_m),
            self.legacy_threshold_m,
        )
        threshold_m, longest_s, identify, costs = self.codes
        if self.expects:
            threshold_m *= believed_loss_kernels.error_growth(self.believed_loss, self.budget)
        kernels.step_each(
            seen,
            first_failure_s,
            self.start_code,
            threshold_m,
            longest_s,
            self.approach_m,
            identify,
            costs,
            kind,
            in_use,
        )
        return Decisions.at_once(kind, in_use, inputs.t_s), ErrorDrivenState(in_use, first_failure_s)

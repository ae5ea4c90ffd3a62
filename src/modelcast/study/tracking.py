"""Tracking at the receiver under loss: what was sent, what arrived, and how far off the host was.

Every policy of one trip meets the same losses, drawn for each instant whether or not it sends then. The first
message is always delivered. The equal-rate baselines take MBC's own rate in the same run, keep-alive
included, either its updates alone (the paper) or all its messages (fairer).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, IntArray, SingleArray
from modelcast.core.chance import child_generator
from modelcast.runtime.trip.believed_kernels import Schedules
from modelcast.runtime.trip.replay import replay
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.periodic import Periodic
from modelcast.study.case import TripCase
from modelcast.study.histogram import Histogram
from modelcast.study.matching import matched_threshold
from modelcast.study.rules import FREE_MATCHED, FREE_RECEIVER, RATE_BASES, RateBasis
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.jumps import jumps_between

__all__ = [
    "Contender",
    "FreeRuns",
    "LossRuns",
    "TrackingRun",
    "draw_losses",
    "run_tracking",
    "walks_under_loss",
]


@dataclass(frozen=True, slots=True)
class Contender:
    """Which policy a run shows, in which comparison."""

    policy: str
    bank: str
    rate_basis: str | None
    threshold_m: float


@dataclass(frozen=True, slots=True)
class Sent:
    """What one sender transmits over a trip: message, sub-model and update at each sample, (T,) each."""

    kind: IntArray
    in_use: IntArray
    update_index: IntArray


@dataclass(frozen=True, slots=True)
class TrackingRun:
    """Errors of one contender over one trip, at every loss ratio (L of them) and seed (K of them).

    Parameters
    ----------
    contender
        Whose errors.
    own_threshold_m
        Threshold the policy ran at by loss ratio, (L,) [m]; None where it has none.
    messages
        Messages sent by loss ratio, means over the seeds, (L,).
    after_m, before_m, along_m, cross_m, age_s
        Errors after and before the instant's message, their parts along and across the track [m] and the age
        of the model held [s]; NaN where the host held nothing, (L, K, T).
    gaps_s
        Gaps between receptions, one histogram a loss ratio [s].
    """

    contender: Contender
    own_threshold_m: tuple[float | None, ...]
    _: KW_ONLY
    messages: tuple[float, ...]
    after_m: SingleArray
    before_m: SingleArray
    along_m: SingleArray
    cross_m: SingleArray
    age_s: SingleArray
    gaps_s: tuple[Histogram, ...]

    @classmethod
    def stacked(cls, runs: Sequence["TrackingRun"]) -> "TrackingRun":
        """One contender's runs at one loss ratio each as one at all of them.

        Parameters
        ----------
        runs
            In the order of the ratios.
        """
        errors = {
            name: np.concatenate([getattr(run, name) for run in runs])
            for name in ("after_m", "before_m", "along_m", "cross_m", "age_s")
        }
        return cls(
            runs[0].contender,
            tuple(own_m for run in runs for own_m in run.own_threshold_m),
            messages=tuple(count for run in runs for count in run.messages),
            gaps_s=tuple(gaps for run in runs for gaps in run.gaps_s),
            **errors,
        )


def draw_losses(case: TripCase, settings: EvaluationSettings) -> BoolArray:
    """Which instants lose their message in every run, (L, K, T); the first is never lost.

    Nor is the first behind a jump of the recording: no vehicle made it, so no host had to live with it.

    Parameters
    ----------
    case
        The trip.
    settings
        Loss ratios, seeds and channel.
    """
    t_s = case.truth.t_s
    shape = (len(settings.packet_error_ratios), settings.seeds, t_s.size)
    lost = np.empty(shape, dtype=np.bool_)
    for row, ratio in enumerate(settings.packet_error_ratios):
        for run in range(settings.seeds):
            rng = child_generator(settings.seed, run, case.truth.trip_id, "loss")
            lost[row, run] = settings.channel(ratio).losses(t_s, rng)
    jumped, _ = jumps_between(t_s, case.truth.position_m, case.truth.segments)
    lost[:, :, [0, *jumped.tolist()]] = False
    return lost


def run_tracking(
    case: TripCase,
    mbc: Sequence[TripRuntime],
    baseline: TripRuntime,
    settings: EvaluationSettings,
    free: TripRuntime | None = None,
) -> Iterator[TrackingRun]:
    """Yield every contender's errors: MBC, the baseline, and four equal-rate baselines a threshold.

    Behind them come those of the free receiver, where there is one: at the same threshold, and at MBC's rate
    on either basis.

    Parameters
    ----------
    case
        The trip.
    mbc
        The bank, ready for what the sender sees: once for all loss ratios, or once for each.
    baseline
        The baseline's bank.
    settings
        Thresholds, losses, seeds and rules.
    free
        The free receiver's bank, ready for what the sender sees.
    """
    runs = LossRuns(case, baseline, settings)
    beside = None if free is None else FreeRuns(free, runs, settings.of_free)
    for threshold_m in settings.thresholds_m:
        policy = settings.policy(threshold_m, keep_alive=True)
        walks = walks_under_loss(mbc, settings, threshold_m)
        own, *rivals = runs.contended(mbc, walks, settings, threshold_m, RATE_BASES)
        yield own
        yield runs.at_threshold(policy)
        yield from rivals
        if beside is not None:
            sent = walks_under_loss([beside.ready], settings.of_free, threshold_m)
            yield beside.at_threshold(threshold_m, sent)
            yield from beside.at_equal_rate(threshold_m, sent, walks)


def walks_under_loss(
    each: Sequence[TripRuntime], settings: EvaluationSettings, threshold_m: float
) -> list[TripMessages]:
    """Drive the trip as the loss runs do: one walk that serves all loss ratios, or one a ratio.

    Parameters
    ----------
    each
        The bank, ready for what the sender sees: once for all loss ratios, or once for each.
    settings
        Rules and loss ratios.
    threshold_m
        Threshold [m].
    """
    ratios = settings.packet_error_ratios
    if len(each) > 1:
        return [
            one.run(settings.under_loss(threshold_m, ratio)) for one, ratio in zip(each, ratios, strict=True)
        ]
    expected = ratios if settings.belief == "expected" else ()
    return each[0].run_each([settings.under_loss(threshold_m, ratio) for ratio in expected or (0.0,)])


def messages_of(walks: Sequence[TripMessages], basis: RateBasis) -> tuple[int, ...]:
    """How many messages of each walk count.

    Parameters
    ----------
    walks
        What was sent.
    basis
        Updates alone, or all.
    """
    return tuple(walk.updates + (walk.identifications if basis == "total" else 0) for walk in walks)


def by_basis(
    walks: Sequence[TripMessages],
    bases: Sequence[RateBasis],
    runs_of: Callable[[RateBasis], Sequence[TrackingRun]],
) -> Iterator[TrackingRun]:
    """Yield the runs at equal rate on each basis; where two bases count the same, they are run once.

    Parameters
    ----------
    walks
        What was sent: they are to send as many.
    bases
        Which of its messages count, one after another.
    runs_of
        Runs a basis.
    """
    found: dict[tuple[int, ...], Sequence[TrackingRun]] = {}
    for basis in bases:
        counts = messages_of(walks, basis)
        if counts not in found:
            found[counts] = runs_of(basis)
        for run in found[counts]:
            yield replace(run, contender=replace(run.contender, rate_basis=basis))


class LossRuns:
    """The loss runs of one trip: all contenders meet the same losses, whichever bank they send.

    Parameters
    ----------
    case
        The trip.
    baseline
        The bank of the equal-rate baselines, of one sub-model, ready for what the sender sees.
    settings
        Losses and seeds; its bank and thresholds play no part, so that several banks may share the runs.
    """

    def __init__(self, case: TripCase, baseline: TripRuntime, settings: EvaluationSettings) -> None:
        self._case = case
        self._baseline = baseline
        self._settings = settings
        self._lost = draw_losses(case, settings)
        self._counts: dict[tuple[float, float | None], int] = {}
        self._parts: dict[int, LossRuns] = {}

    def contended(
        self,
        each: Sequence[TripRuntime],
        walks: Sequence[TripMessages],
        settings: EvaluationSettings,
        threshold_m: float,
        bases: Sequence[RateBasis],
    ) -> list[TrackingRun]:
        """The errors of one sender, then for each basis those of both readings of its equal-rate baseline.

        Parameters
        ----------
        each
            Its bank, ready for what it sees: once for all loss ratios, or once for each where loss changes
            what it knows. Then the baselines are at equal rate ratio by ratio.
        walks
            What it sent, as `walks_under_loss` gives it.
        settings
            Its rules.
        threshold_m
            Its threshold [m].
        bases
            As for `equal_rate`.
        """
        if len(each) > 1:
            parts: list[list[TrackingRun]] = []
            for at, (one, walk) in enumerate(zip(each, walks, strict=True)):
                alone = replace(settings, packet_error_ratios=(settings.packet_error_ratios[at],))
                parts.append(self._part(at).contended([one], [walk], alone, threshold_m, bases))
            return [TrackingRun.stacked(runs) for runs in zip(*parts, strict=True)]
        ready, policy = each[0], settings.policy(threshold_m, keep_alive=True)
        own = self.walked(ready, walks, Contender(settings.sender, ready.bank.name, None, threshold_m))
        return [
            own,
            *by_basis(walks, bases, lambda basis: list(self.equal_rate(policy, walks, basis))),
        ]

    def _part(self, at: int) -> "LossRuns":
        """The runs of one loss ratio alone; their losses are the same."""
        if at not in self._parts:
            ratio = self._settings.packet_error_ratios[at]
            alone = replace(self._settings, packet_error_ratios=(ratio,))
            self._parts[at] = LossRuns(self._case, self._baseline, alone)
        return self._parts[at]

    def walked(self, ready: TripRuntime, walks: Sequence[TripMessages], shown_as: Contender) -> TrackingRun:
        """The errors of one sender that walked the trip.

        Parameters
        ----------
        ready
            Its bank.
        walks
            What it sent: one that serves all loss ratios, or one a ratio.
        shown_as
            Whose errors these are.
        """
        sent = [[Sent(walk.kind, walk.in_use, walk.update_index)] for walk in walks]
        own = [walk.policy.threshold_m for walk in walks]
        return self._replay(ready, sent, shown_as=shown_as, own_threshold_m=own)

    def at_threshold(self, policy: ErrorDriven) -> TrackingRun:
        """The errors of the baseline at a threshold.

        Parameters
        ----------
        policy
            Of that threshold.
        """
        ready = self._baseline
        shown_as = Contender("baseline", ready.bank.name, None, policy.threshold_m)
        return self.walked(ready, [ready.run(policy)], shown_as)

    def equal_rate(
        self, policy: ErrorDriven, walks: Sequence[TripMessages], basis: RateBasis
    ) -> Iterator[TrackingRun]:
        """Yield the errors of both readings of the equal-rate baseline: matched, then periodic.

        Parameters
        ----------
        policy
            Its threshold names the comparison, its keep-alive holds for the matched baseline too.
        walks
            What MBC sent, as in `walked`: they are to send as many.
        basis
            Which of its messages count.
        """
        counts = messages_of(walks, basis)
        name = self._baseline.bank.name
        matched = [self._matched(policy.max_inter_transmit_time_s, messages) for messages in counts]
        yield self.walked(
            self._baseline, matched, Contender("baseline-matched", name, basis, policy.threshold_m)
        )
        sent = [[self._periodic(messages, run) for run in range(self._settings.seeds)] for messages in counts]
        yield self._replay(
            self._baseline,
            sent,
            shown_as=Contender("baseline-periodic", name, basis, policy.threshold_m),
            own_threshold_m=[None],
        )

    def _periodic(self, messages: int, run: int) -> Sent:
        """So many messages in the mean, the first at once, with the phase of this run and vehicle."""
        t_s = self._case.truth.t_s
        kind = np.zeros(t_s.size, dtype=np.int64)
        kind[0] = MessageKind.UPDATE
        if messages > 1:
            rng = child_generator(self._settings.seed, run, self._case.truth.trip_id, "phase")
            rate_hz = (messages - 1) / self._case.truth.duration_s
            kind[Periodic(rate_hz).transmit_indices(t_s, rng)] = MessageKind.UPDATE
        update_index = np.maximum.accumulate(np.where(kind > 0, np.arange(kind.size), 0))
        return Sent(kind, self._baseline.first_served(update_index), update_index)

    def _matched(self, longest_s: float | None, messages: int) -> TripMessages:
        """The baseline's walk whose count of messages comes nearest, its threshold found by bisection."""
        best = matched_threshold(lambda threshold_m: self._count(threshold_m, longest_s), messages)
        return self._baseline.run(ErrorDriven(best, max_inter_transmit_time_s=longest_s))

    def _count(self, threshold_m: float, longest_s: float | None) -> int:
        """How many messages the baseline sends at a threshold: every bisection begins with the same ones."""
        key = threshold_m, longest_s
        if key not in self._counts:
            policy = ErrorDriven(threshold_m, max_inter_transmit_time_s=longest_s)
            self._counts[key] = self._baseline.run(policy).updates
        return self._counts[key]

    def _replay(
        self,
        ready: TripRuntime,
        sent: Sequence[Sequence[Sent]],
        *,
        shown_as: Contender,
        own_threshold_m: Sequence[float | None],
    ) -> TrackingRun:
        """Replay the host over all losses.

        ``sent`` has one row that serves every loss ratio, or one a ratio; a row has one schedule that serves
        every seed, or one a seed.
        """
        case, lost, settings = self._case, self._lost, self._settings
        ratios, seeds, count = lost.shape
        runs = ratios * seeds
        rows = list(sent) * (ratios // len(sent))
        # The replay repeats schedules over the runs: of one ratio where all share them, else of every run.
        each = 1 if len(sent) == 1 else seeds // len(sent[0])
        own = [one for row in sent for one in row for _ in range(each)]
        kind = np.stack([one.kind for one in own])
        replayed = replay(
            ready,
            Schedules(
                kind, np.stack([one.in_use for one in own]), np.stack([one.update_index for one in own])
            ),
            lost.reshape(runs, count),
            case.truth.position_m,
            case.direction,
            delay_s=settings.delay_s,
            expiry_s=np.inf if settings.expiry_s is None else settings.expiry_s,
        )
        gaps = tuple(Histogram() for _ in range(ratios))
        for run, gaps_s in enumerate(replayed.gaps_s):
            gaps[run // seeds].add(gaps_s, 1)
        after_m, before_m, along_m, cross_m, age_s = replayed.errors.astype(np.float32).reshape(
            5, ratios, seeds, count
        )
        return TrackingRun(
            shown_as,
            tuple(own_threshold_m) * (ratios // len(own_threshold_m)),
            messages=tuple(sum(int(np.count_nonzero(one.kind)) for one in row) / len(row) for row in rows),
            after_m=after_m,
            before_m=before_m,
            along_m=along_m,
            cross_m=cross_m,
            age_s=age_s,
            gaps_s=gaps,
        )


class FreeRuns:
    """The loss runs of the free receiver over one trip, by the rules of the model-based sender.

    Parameters
    ----------
    ready
        Its bank, ready for what the sender sees.
    runs
        The loss runs of the trip: it meets the same losses.
    settings
        The free receiver's (`EvaluationSettings.of_free`).
    """

    def __init__(self, ready: TripRuntime, runs: LossRuns, settings: EvaluationSettings) -> None:
        self.ready = ready
        self._runs = runs
        self._settings = settings

    def at_threshold(self, threshold_m: float, sent: Sequence[TripMessages]) -> TrackingRun:
        """Its errors at a threshold.

        Parameters
        ----------
        threshold_m
            Threshold [m].
        sent
            What it sends at it, as `walks_under_loss` gives it.
        """
        return self._runs.walked(self.ready, sent, self._shown(FREE_RECEIVER, None, threshold_m))

    def at_equal_rate(
        self,
        threshold_m: float,
        sent: Sequence[TripMessages],
        walks: Sequence[TripMessages],
        bases: Sequence[RateBasis] = RATE_BASES,
    ) -> Iterator[TrackingRun]:
        """Yield its errors at the rate of another sender, one a basis, by a threshold of its own.

        Parameters
        ----------
        threshold_m
            Threshold that names the comparison [m].
        sent
            What it sends at that threshold: the search begins there.
        walks
            What the other sent, as in `LossRuns.walked`.
        bases
            Which of its messages count.
        """
        ratios = self._settings.packet_error_ratios if self._settings.belief == "expected" else (0.0,)

        def runs_of(basis: RateBasis) -> list[TrackingRun]:
            wanted = messages_of(walks, basis)
            runs = max(len(wanted), len(ratios))
            asked = zip(
                wanted * (runs // len(wanted)),
                ratios * (runs // len(ratios)),
                list(sent) * (runs // len(ratios)),
                strict=True,
            )
            matched = [self._matched(messages, ratio, first) for messages, ratio, first in asked]
            return [self._runs.walked(self.ready, matched, self._shown(FREE_MATCHED, basis, threshold_m))]

        return by_basis(walks, bases, runs_of)

    def _shown(self, policy: str, basis: RateBasis | None, threshold_m: float) -> Contender:
        return Contender(policy, self.ready.bank.name, basis, threshold_m)

    def _matched(self, messages: int, ratio: float, first: TripMessages) -> TripMessages:
        """A walk of about so many messages at a loss ratio, searched from another walk on."""
        walks = {first.policy.threshold_m: first}

        def count(threshold_m: float) -> int:
            if threshold_m not in walks:
                walks[threshold_m] = self.ready.run(self._settings.under_loss(threshold_m, ratio))
            return walks[threshold_m].updates

        return walks[matched_threshold(count, messages, start_m=first.policy.threshold_m)]

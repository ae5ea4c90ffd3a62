"""Runtimes of a trip: of a sender that may read context, and of the free receiver's, which reads none."""

from collections.abc import Sequence
from dataclasses import replace

from modelcast.models.bank import Bank
from modelcast.models.members import ReadyBank
from modelcast.runtime.trip.context import TripContexts
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.arrays import Sensed
from modelcast.study.case import TripCase
from modelcast.study.settings import EvaluationSettings

__all__ = ["case_contexts", "free_runtime", "reads_context", "trip_runtimes"]


def reads_context(bank: Bank) -> bool:
    """Whether a sub-model of a bank reads the vehicle ahead or the road.

    Parameters
    ----------
    bank
        Any bank.
    """
    return ReadyBank.of(bank, 0.1).reads_context


def case_contexts(cases: Sequence[TripCase], settings: EvaluationSettings) -> TripContexts:
    """Contexts of trips that are evaluated together.

    Parameters
    ----------
    cases
        The trips, as their senders see them.
    settings
        What is let known, the seed, and the delay where it is longer.
    """
    asked = replace(
        settings.context, seed=settings.seed, delay_s=max(settings.context.delay_s, settings.delay_s)
    )
    return TripContexts(
        [case.seen for case in cases],
        asked,
        estimators=[case.estimator for case in cases],
        recorded=[case.recorded for case in cases],
    )


def trip_runtimes(
    case: TripCase,
    settings: EvaluationSettings,
    sensed: Sensed,
    contexts: TripContexts | None = None,
    which: int = 0,
) -> tuple[TripRuntime, Sequence[TripRuntime]]:
    """The runtime of a trip for a channel without loss, and those for the loss ratios.

    Parameters
    ----------
    case, settings
        The trip, the bank and its rules, and the loss ratios (L of them).
    sensed
        What `sense_trip` made of the trip.
    contexts, which
        Contexts of all trips, and which this one is among them; without, nothing is known.

    Returns
    -------
    tuple[TripRuntime, Sequence[TripRuntime]]
        The second holds one for all ratios where loss changes nothing that the sender knows, else L.
    """

    def ready(context: bool, ratio: float = 0.0) -> TripRuntime:
        known = contexts.of(which, settings.channel(ratio)) if context and contexts is not None else None
        return TripRuntime(
            case.seen,
            settings.bank,
            case.estimator,
            settings.selector_in_use,
            quantised=settings.quantised,
            sensed=sensed,
            context=known,
            decides=settings.decides,
        )

    if contexts is None or not reads_context(settings.bank):
        alone = ready(context=False)
        return alone, (alone,)
    clean = ready(context=True)
    if not contexts.settings.leader:
        return clean, (clean,)
    return clean, [
        clean if ratio == 0.0 else ready(context=True, ratio=ratio) for ratio in settings.packet_error_ratios
    ]


def free_runtime(case: TripCase, bank: Bank | None, sensed: Sensed, *, quantised: bool) -> TripRuntime | None:
    """The runtime of the free receiver's sender; None where it is not run.

    Parameters
    ----------
    case
        The trip.
    bank
        The free receiver's, or None.
    sensed
        What `sense_trip` made of the trip.
    quantised
        Whether sender and host predict with what a message can say.
    """
    if bank is None:
        return None
    return TripRuntime(case.seen, bank, case.estimator, quantised=quantised, sensed=sensed)

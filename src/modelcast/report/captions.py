"""What each figure of the report shows, with the definitions a reader needs."""

from collections.abc import Sequence

from modelcast.report.figures.panels import MOST_READINGS
from modelcast.report.headline import (
    detail_threshold_m,
    main_bank,
    rate_basis,
    sender_label,
    thresholds_m,
)
from modelcast.report.model_words import sub_model_words
from modelcast.report.senders import BASELINE_WORDS, free_words, is_free_receiver
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import FREE_RECEIVER
from modelcast.study.wording import centimetres

__all__ = ["PROTOCOLS", "TITLES", "captions", "loss_conditions"]

TITLES = {
    "message_rate": "Message rate",
    "tracking_distribution": "Distribution of the tracking error",
    "tracking_loss": "Tracking under packet loss",
    "sub_models": "Which sub-model holds",
    "manoeuvre": "A manoeuvre",
    "trips": "Trip by trip",
}
"""Headings of the figures, by the stem of their files."""

PROTOCOLS = {
    "recorded": "the log is both input and truth, so errors of the recording itself are not seen",
    "sensor": "the truth (known, or the log, smoothed if need be) differs from what the sender's sensors see",
}
"""What the protocols of `modelcast.study.result.TripRow` mean."""


_REFERENCES = (
    " Lines: the fewest messages of a sender that knows the future and sends one polynomial of that degree "
    "for each axis, and the triggering rules of ETSI's cooperative awareness messages (EN 302 637-2), which "
    "know no threshold."
)


def captions(result: EvaluationResult) -> dict[str, str]:
    """Return the caption of every figure, by the stem of its files.

    Parameters
    ----------
    result
        The evaluation.
    """
    protocols = sorted({trip.protocol for trip in result.trips})
    label = f" (protocol: {', '.join(protocols)})" if protocols else ""
    counted = {"total": "updates and identifications", "update": "model updates alone"}[rate_basis(result)]
    conditions, sender = loss_conditions(result), sender_label(result)
    detail_m = detail_threshold_m(result)
    detail = "" if detail_m is None else f" at the threshold of {centimetres(detail_m)}"
    rivals, thinned = _rivals(result), _thinned(len(thresholds_m(result)))
    readings = (
        "Left, all run at the same threshold, and the messages of each are named; right, all send as often "
        f"as {sender} ({counted} counted), error-driven with a threshold searched for that rate, and the "
        f"baseline also periodically with a random phase. {rivals}.{thinned}"
    )
    return {
        "message_rate": (
            f"Messages per second of time observed, all trips pooled{label}, on an ideal channel without "
            f"keep-alive: {sender} with the bank {main_bank(result) or 'evaluated'} and its rivals, "
            f"error-driven at the same threshold. {rivals}. Below, the time on the air, all "
            "layers and the security header counted." + (_REFERENCES if result.references else "")
        ),
        "tracking_distribution": (
            f"Share of samples, all trips and seeds pooled{label}, whose position tracking error (PTE) is at "
            "most the value on the logarithmic axis; the PTE is the distance at the receiver between belief "
            f"and truth after the instant's message, here with {conditions}. {readings}"
        ),
        "tracking_loss": (
            "90th percentile of the PTE after the instant's message, all trips and seeds pooled"
            f"{label}, with {conditions}, on a logarithmic axis; thin bars are 95 % Student-t limits over "
            f"the seeds, taken on the logarithm. {readings}"
        ),
        "sub_models": (
            f"Error of every sub-model fitted at the last update{detail}, before the instant's message and "
            "without loss, cut off above 2.5 thresholds. Below, a strip is coloured while its sub-model "
            "stays under the threshold and grey while it fails, then come the sub-model in use and the "
            f"messages sent.{_told(() if result.timeline is None else result.timeline.members)}"
        ),
        "manoeuvre": (
            "The true path and the one each sub-model predicts from the start on, fitted to the samples "
            "before it; the map is cut to the true path, and a cross marks "
            f"where the error first reaches the threshold{_of(detail_m)}. On the "
            "right, the same errors against time, up to four thresholds."
            f"{_told(() if result.manoeuvre is None else list(result.manoeuvre.predicted_m))}"
        ),
        "trips": (
            f"Message rate without loss, and 90th percentile of the PTE after the instant's message under "
            f"loss, for each trip{label}{detail}. Left and in the middle all run at that threshold; on "
            f"the right all are error-driven at {sender}'s rate ({counted} counted), with {conditions}."
        ),
    }


def _rivals(result: EvaluationResult) -> str:
    """Who is drawn beside the evaluated sender, as far as they were run."""
    baseline = f"The baseline: {BASELINE_WORDS}"
    if is_free_receiver(result):
        return f"{baseline}. {sender_label(result)} is the free receiver itself here"
    if not any(row.policy == FREE_RECEIVER for row in (*result.rates, *result.tracking)):
        return baseline
    return f"{baseline}; the free receiver: {free_words(result.settings)}"


def _told(members: Sequence[str]) -> str:
    """What the sub-models of a figure are."""
    words = sub_model_words(members)
    return f" Sub-models: {words}." if words else ""


def _thinned(thresholds: int) -> str:
    """Say where not every threshold has its panels."""
    if thresholds <= MOST_READINGS:
        return ""
    return f" Of {thresholds} thresholds {MOST_READINGS} are drawn; the tables have all."


def _of(threshold_m: float | None) -> str:
    return "" if threshold_m is None else f" of {centimetres(threshold_m)}"


def loss_conditions(result: EvaluationResult) -> str:
    """Return the conditions of the loss runs, as far as the settings name them.

    Parameters
    ----------
    result
        The evaluation.
    """
    settings = result.settings
    burst_s, longest_s = settings.get("mean_burst_s"), settings.get("keep_alive_s")
    losses = "independent losses" if burst_s is None else f"losses in bursts of {burst_s:g} s on average"
    if "keep_alive_s" not in settings:
        return losses
    keep_alive = "no keep-alive" if longest_s is None else f"a keep-alive after {longest_s:g} s"
    return f"{losses} and {keep_alive}"

"""What each figure of the report shows, in two sentences, with the definitions a reader needs."""

from modelcast.report.headline import main_bank, rate_basis, sender_label
from modelcast.study.result import EvaluationResult

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
    equal = (
        f"The baselines send as often as {sender} ({counted} counted): one error-driven, with its threshold "
        "bisected to that rate, and one periodic with a random phase."
    )
    return {
        "message_rate": (
            f"Messages per second of time observed, all trips pooled{label}, on an ideal channel without "
            f"keep-alive: {sender} with the bank {main_bank(result) or 'evaluated'}, split into model "
            "updates and sub-model identifications, beside the baseline. The baseline is error-driven at the "
            "same threshold; it sends raw state, which its receiver extrapolates at constant velocity. "
            "Below, the time on the air of both, all layers and the security header counted."
            + (_REFERENCES if result.references else "")
        ),
        "tracking_distribution": (
            f"Share of samples, all trips and seeds pooled{label}, whose position tracking error (PTE) is at "
            "most the value on the logarithmic axis; the PTE is the distance at the receiver between belief "
            f"and truth after the instant's message, here with {conditions}. {equal}"
        ),
        "tracking_loss": (
            "90th percentile of the PTE after the instant's message, all trips and seeds pooled"
            f"{label}, with {conditions}; bands are 95 % Student-t limits over the seeds. {equal}"
        ),
        "sub_models": (
            "Error of every sub-model fitted at the last update, before the instant's message and without "
            "loss, cut off above 2.5 thresholds. Below, a strip is coloured while its sub-model stays under "
            "the threshold and grey while it fails, then come the sub-model in use and the messages sent."
        ),
        "manoeuvre": (
            "The true path and the one each sub-model predicts from the start on, fitted to the samples "
            "before it; a cross marks where the error first reaches the threshold. On the right, the same "
            "errors against time, up to four thresholds."
        ),
        "trips": (
            f"Message rate without loss, and 90th percentile of the PTE after the instant's message under "
            f"loss, for each trip{label}. On the left the baseline runs at the same threshold; on the right "
            f"it is error-driven at {sender}'s rate ({counted} counted), with {conditions}."
        ),
    }


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

"""What the senders and receivers of an evaluation do, in words made from its settings.

A result of an older modelcast, whose settings do not say so, is told as that of a bank of models.
"""

from collections.abc import Sequence

from modelcast.report.headline import sender_label
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER

__all__ = ["BASELINE_WORDS", "coasting", "expecting", "free_words", "is_free_receiver", "sender_words"]

BASELINE_WORDS = "plain messages, coasted at constant velocity"
"""What the baseline is."""

_COASTING = {
    "cv": "at constant velocity",
    "stop-and-go": "by the stop-and-go switch, a steady pace or a short change of it",
    "ca": "with their acceleration too",
    "ctra": "with their acceleration and turn as well",
    "free": "with their acceleration and turn as well",
}
"""How a plain message is coasted, by the name of the sub-model."""


def coasting(names: Sequence[str]) -> str:
    """Return how plain messages are coasted, by sub-models of these names.

    Parameters
    ----------
    names
        Of the bank that coasts them.

    Examples
    --------
    >>> coasting(["cv"]), coasting(["kerb"])
    ('at constant velocity', 'by kerb')
    """
    if len(names) == 1 and names[0] in _COASTING:
        return _COASTING[names[0]]
    return f"by {' or '.join(names)}"


def free_words(result: EvaluationResult) -> str:
    """Return what the free receiver is.

    Parameters
    ----------
    result
        An evaluation that ran it.
    """
    return f"plain messages, coasted {coasting(result.settings.get('free_names') or [FREE_RECEIVER])}"


def is_free_receiver(result: EvaluationResult) -> bool:
    """Return whether the bank evaluated is the free receiver's, which is then not run beside itself.

    Parameters
    ----------
    result
        The evaluation.
    """
    return bool(result.settings.get("is_free_receiver"))


def sender_words(result: EvaluationResult) -> str:
    """Return what the evaluated sender sends, and when.

    Parameters
    ----------
    result
        The evaluation.
    """
    settings = result.settings
    own_policy = result.sender != MODEL_SENDER
    when = f"when the policy {sender_label(result)} calls for one"
    if not settings.get("plain_messages"):
        sent = "a vehicle sends a small model of its motion"
        return (
            f"{sent}, {when}"
            if own_policy
            else f"{sent}, and the next one when that errs by more than the threshold"
        )
    when = when if own_policy else "when that errs by more than the threshold"
    names = settings.get("sub_model_names") or [FREE_RECEIVER]
    told = f"this bank sends no model; plain messages, coasted {coasting(names)}, and the next one {when}"
    return f"{told}; this is the free receiver itself" if is_free_receiver(result) else told


def expecting(result: EvaluationResult) -> list[str]:
    """Return who is told the share of messages lost and repeats for it, as rows name them; nobody by default.

    Parameters
    ----------
    result
        The evaluation.
    """
    if result.settings.get("believe") != "expected":
        return []
    run = {row.policy for row in result.tracking}
    return [name for name in (MODEL_SENDER, FREE_RECEIVER) if name in run]

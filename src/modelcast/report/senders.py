"""What the senders and receivers of an evaluation do, in words made from its settings.

A result of an older modelcast, whose settings do not say so, is told as that of a bank of models.
"""

from collections.abc import Mapping
from typing import Any

from modelcast.report.headline import sender_label
from modelcast.report.model_words import coasting
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER

__all__ = ["BASELINE_WORDS", "expecting", "free_words", "is_free_receiver", "sender_words"]

BASELINE_WORDS = "plain messages, coasted at constant velocity"
"""What the baseline is."""


def free_words(settings: Mapping[str, Any]) -> str:
    """Return what the free receiver is.

    Parameters
    ----------
    settings
        Of an evaluation or a comparison that ran it, as plain values.
    """
    return f"plain messages, coasted {coasting(settings.get('free_names') or [FREE_RECEIVER])}"


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

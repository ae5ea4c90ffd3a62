"""Frames that were heard and sent, as plain values of JSON and back."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast

from modelcast.core.rules import Keys, Text, Whole, check
from modelcast.node.recording.plain import TIME, octets_of, text_of
from modelcast.runtime.transport.base import MOST_OCTETS, Arrival

__all__ = ["Heard", "Sent", "heard_words", "read_heard", "read_sent", "sent_words"]

_OCTETS = Text(4 * MOST_OCTETS, empty=True)

_HEARD = Keys(
    {"call": Whole(0, 2**53), "now_s": TIME, "received_s": TIME, "outcome": Text(120), "octets": _OCTETS}
)

_SENT = Keys({"now_s": TIME, "message": _OCTETS, "octets": _OCTETS})


@dataclass(frozen=True, slots=True)
class Heard:
    """One frame as it arrived.

    Parameters
    ----------
    call
        Number of the call of `modelcast.node.node.Node.hear` that took it in; frames of one call share it.
    now_s
        Of that call [s].
    arrival
        The frame.
    outcome
        What became of it.
    """

    call: int
    now_s: float
    arrival: Arrival
    outcome: str


@dataclass(frozen=True, slots=True)
class Sent:
    """One frame that left.

    Parameters
    ----------
    now_s
        When it was handed over [s].
    message
        What the station said.
    octets
        The same in its envelope.
    """

    now_s: float
    message: bytes
    octets: bytes


def heard_words(
    call: int, now_s: float, arrived: Sequence[Arrival], outcomes: Sequence[str]
) -> Iterator[dict[str, Any]]:
    """Frames that one call took in."""
    for one, outcome in zip(arrived, outcomes, strict=True):
        yield {
            "call": call,
            "now_s": now_s,
            "received_s": one.received_s,
            "outcome": outcome,
            "octets": text_of(one.octets),
        }


def read_heard(words: object) -> Heard:
    """The same back.

    Raises
    ------
    ValueError
        Where it is none.
    """
    check(words, _HEARD)
    own = cast("dict[str, Any]", words)
    arrival = Arrival(octets_of(own["octets"], "$.octets"), float(own["received_s"]))
    return Heard(own["call"], float(own["now_s"]), arrival, own["outcome"])


def sent_words(now_s: float, message: bytes, frame: bytes) -> dict[str, Any]:
    """A frame that left."""
    return {
        "now_s": now_s,
        "message": text_of(message),
        "octets": text_of(frame),
    }


def read_sent(words: object) -> Sent:
    """The same back.

    Raises
    ------
    ValueError
        Where it is none.
    """
    check(words, _SENT)
    own = cast("dict[str, Any]", words)
    return Sent(
        float(own["now_s"]), octets_of(own["message"], "$.message"), octets_of(own["octets"], "$.octets")
    )

"""Compiled belief of what remotes hold where messages are lost: weights of the last messages, and the budget.

A message is lost with probability p, so a remote holds the newest with probability 1 - p, the one before with
(1 - p)·p, and so on. SAE J2945/1 draws one of these cases for each message (`j2945_kernels.assume_received`);
here the sender takes the mean over all, which draws nothing.
"""

from modelcast.core.kernel import kernel

__all__ = ["DEPTH", "MOST_LOST", "believed_loss", "error_growth", "share_held"]

DEPTH = 6
"""Messages that a sender remembers: at 40 % losses a remote holds an older one with probability 1 %."""

MOST_LOST = 0.9
"""A sender believes no more of its messages lost."""


@kernel(inlined=True)
def believed_loss(packet_error_ratio: float) -> float:
    """Share of its messages that a sender believes lost; NaN, nothing observed, counts as none."""
    return min(packet_error_ratio, MOST_LOST) if packet_error_ratio > 0.0 else 0.0


@kernel(inlined=True)
def share_held(loss: float, behind: int, oldest: bool) -> float:
    """Probability that a remote holds the message so many behind the newest.

    ``oldest`` is set for the last one remembered, which stands for all before it too: the shares add up to 1.
    """
    share: float = loss**behind
    return share if oldest else share * (1.0 - loss)


@kernel(inlined=True)
def error_growth(loss: float, budget: float) -> float:
    """By how much the expected error that calls for a message may exceed the threshold; at least 1.

    Errors that grow with the square of their age, c·a², and messages every T give an expected error of
    ``c·T²·(1 + p)/(1 - p)²`` when the next is due. Let it reach ``(1 + p)/((1 - p)²·m²)`` thresholds, and a
    sender sends m times as many messages as it would without losses.
    """
    kept = (1.0 - loss) * budget
    return max(1.0, (1.0 + loss) / (kept * kept))

"""Compiled end of a frame in modes 4 and 2: what became of it counts once, and who has it hears of it."""

from modelcast.channel.copies_kernels import Copies, forget_pairs, move_last, seek_pairs, settle, tell
from modelcast.channel.frame_kernels import Heard
from modelcast.channel.frame_link_kernels import Links
from modelcast.core.kernel import kernel

__all__ = ["tell_frame"]

_RECEIVED = 0


@kernel(inlined=True)
def tell_frame(
    v: int,
    message_id: int,
    copy: int,
    more: bool,
    first: int,
    last: int,
    end_s: float,
    links: Links,
    copies: Copies,
    heard: Heard,
    received: int,
    waiting: int,
) -> tuple[int, int]:
    """Count a frame of ``v`` at its links, ``last`` excluded; return how many receptions and waiting pairs.

    It is the ``copy``-th of its message, from 0 on, and ``more`` says that another is to come. There must be
    room for its pairs.
    """
    lone = copy == 0 and not more
    if not lone:
        if copy == 0:
            copies.span[v, 0], copies.span[v, 1] = waiting, 0
        elif more:
            waiting = move_last(copies, v, waiting)
        seek_pairs(copies, v)
    who, when, outcomes = heard.who, heard.when, heard.outcomes
    for k in range(first, last):
        j, group, outcome = int(links.receiver[k]), int(links.bin[k]), int(links.outcome[k])
        new = outcome == _RECEIVED
        if not lone:
            new, waiting = tell(copies, v, j, outcome, group, waiting, more, outcomes)
        elif group < outcomes.shape[0]:
            outcomes[group, outcome] += 1
        if new:
            who[received, 0], who[received, 1], who[received, 2] = message_id, v, j
            when[received, 0], when[received, 1] = end_s, links.mw[k]
            received += 1
    if more:
        forget_pairs(copies, v)
    elif not lone:
        settle(copies, v, outcomes)
    return received, waiting

"""Who hears the frames of a subframe or slot, and how loud: links of modes 4 and 2, with room that grows."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector

__all__ = ["Links", "links_room", "no_links"]


class Links(NamedTuple):
    """Frames at their receivers, frame after frame: who, power [mW], distance bin, and what became of it.

    The power is 0 where it is too weak to matter to anybody. ``other_mw`` is that of others on the same
    sub-channels, infinite at who sends itself.
    """

    receiver: IntVector
    mw: FloatVector
    bin: IntVector
    other_mw: FloatVector
    outcome: IntVector


@kernel
def _room(size: int) -> Links:
    return Links(
        np.empty(size, dtype=np.int64),
        np.empty(size),
        np.empty(size, dtype=np.int64),
        np.empty(size),
        np.empty(size, dtype=np.int64),
    )


@kernel
def no_links() -> Links:
    """Return links without room."""
    return _room(0)


@kernel
def links_room(links: Links, used: int, more: int) -> Links:
    """Return the same with room for more links; what became of them is yet to be written."""
    if used + more <= links.receiver.size:
        return links
    roomier = _room(2 * (used + more))
    roomier.receiver[:used], roomier.mw[:used] = links.receiver[:used], links.mw[:used]
    roomier.bin[:used] = links.bin[:used]
    return roomier

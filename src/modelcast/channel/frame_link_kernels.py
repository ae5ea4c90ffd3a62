"""Who hears the frames of a subframe or slot, and how loud: links of modes 4 and 2, with room that grows."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector

__all__ = ["Links", "links_room", "no_links"]


class Links(NamedTuple):
    """Frames at their receivers, frame after frame: who, power [mW], distance bin.

    The power is 0 where it is too weak to matter to anybody.
    """

    receiver: IntVector
    mw: FloatVector
    bin: IntVector


@kernel
def no_links() -> Links:
    """Return links without room."""
    return Links(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0, dtype=np.int64))


@kernel
def links_room(links: Links, used: int, more: int) -> Links:
    """Return the same with room for more links."""
    if used + more <= links.receiver.size:
        return links
    size = 2 * (used + more)
    roomier = Links(np.empty(size, dtype=np.int64), np.empty(size), np.empty(size, dtype=np.int64))
    roomier.receiver[:used], roomier.mw[:used] = links.receiver[:used], links.mw[:used]
    roomier.bin[:used] = links.bin[:used]
    return roomier

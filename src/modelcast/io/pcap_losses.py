"""Lost messages of captures (`pcap`): the counts of what was heard tell what was not.

A link is one temporary id in one capture; a sender that changes its id becomes two. ``secMark``, at the
capture's own time, and ``msgCnt`` of Part I tell what was lost. Messages that the capturing unit sent itself
cannot be told from those that it heard: capture what is received alone. Nothing is verified.
"""

import numpy as np

from modelcast.channel.link_record import counted_link
from modelcast.io.captured import Captured
from modelcast.io.heard_links import HeardLinks

__all__ = ["read_capture_links"]


def read_capture_links(path: str) -> HeardLinks:
    """The links of a capture, in the order in which they were first heard.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is no capture, or is damaged.
    """
    capture = Captured(path)
    heard: dict[int, list[tuple[float, int]]] = {}
    uncounted = 0
    for message in capture.messages():
        count = message.core.values()["message_count"]
        if message.t_s is None or count is None:
            uncounted += 1
        else:
            heard.setdefault(message.temporary_id, []).append((message.t_s, int(count)))
    links = [
        counted_link(
            f"the capture hears {temporary_id:08x}",
            np.array([t_s - rows[0][0] for t_s, _ in rows]),
            np.array([count for _, count in rows], dtype=np.int64),
        )
        for temporary_id, rows in heard.items()
    ]
    return HeardLinks(links, 0, uncounted, skipped=tuple(capture.told()))

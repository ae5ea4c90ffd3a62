"""Lost messages of New York City pilot events, from the counts (``msgCnt``) of what the host heard.

The host's own messages (``hostVehID`` of the event's header) are in the file too: heard over no radio. A
message that came twice or out of order lost nothing.
"""

import numpy as np

from modelcast.channel.link_record import COUNTS, counted_link
from modelcast.core.exceptions import DataFormatError
from modelcast.io.heard_links import HeardLinks
from modelcast.io.nyc_cvpd import event_number, read_event

__all__ = ["read_event_links"]


def read_event_links(path: str) -> HeardLinks:
    """The links of an event, a vehicle heard each, in order of appearance.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is no event, does not say who its host is, or a count is no whole number of 0 to 127.
    """
    event = read_event(path)
    if event.host is None:
        raise DataFormatError(
            path,
            "eventHeader names no hostVehID, so whose own messages are among these is not known",
            remedy="Put in the identifier of the vehicle that logged the event.",
        )
    heard: dict[str, list[tuple[float, float]]] = {}
    own, uncounted = False, 0
    for record, vehicle, core in event.messages:
        if vehicle == event.host:
            own = True
            continue
        t_s, count = (event_number(path, record, core, name) for name in ("T_s", "msgCnt"))
        if np.isfinite(count) and not (0 <= count < COUNTS and count == int(count)):
            raise DataFormatError(
                path,
                f"msgCnt is {count:g}, not a whole number of 0 to {COUNTS - 1}",
                row=record,
                remedy="Rows count the messages of bsmList.",
            )
        rows = heard.setdefault(vehicle, [])
        if np.isfinite(t_s) and np.isfinite(count):
            rows.append((t_s, count))
        else:
            uncounted += 1
    links = [
        counted_link(f"{event.host} hears {vehicle}", table[:, 0], table[:, 1].astype(np.int64))
        for vehicle, rows in heard.items()
        for table in [np.array(rows, dtype=np.float64).reshape(-1, 2)]
    ]
    return HeardLinks(links, int(own), uncounted)

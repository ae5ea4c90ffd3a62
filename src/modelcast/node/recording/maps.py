"""Local dynamic maps as plain values of JSON, and where one differs from another in a bit.

Columns are the little-endian octets of the arrays of `modelcast.station.receiver.local_dynamic_map.Beliefs`.
"""

from dataclasses import fields
from typing import Any, cast

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Keys, Text, Whole, check
from modelcast.node.recording.plain import TIME, octets_of, text_of
from modelcast.station.receiver.local_dynamic_map import Beliefs

__all__ = ["belief_difference", "belief_words"]

_MOST_REMOTES = 100_000


def belief_words(t_s: float, around: Beliefs) -> dict[str, Any]:
    """A map.

    Parameters
    ----------
    t_s
        Its instant [s].
    around
        The map.
    """
    columns = {one.name: text_of(getattr(around, one.name).tobytes()) for one in fields(Beliefs)}
    return {"t_s": t_s, "remotes": int(around.vehicle.size), "columns": columns}


def belief_difference(recorded: object, t_s: float, now: Beliefs) -> str:
    """Where a recorded map differs from another: the first column and remote, or empty for nowhere.

    Parameters
    ----------
    recorded
        Words of a map.
    t_s, now
        The other's instant [s], and the map.

    Raises
    ------
    ValueError
        Where the words are none of a map.
    """
    check(
        recorded,
        Keys(
            {
                "t_s": TIME,
                "remotes": Whole(0, _MOST_REMOTES),
                "columns": Keys({one.name: Text(64 * _MOST_REMOTES, empty=True) for one in fields(Beliefs)}),
            }
        ),
    )
    own = cast("dict[str, Any]", recorded)
    if own["t_s"] != t_s:
        return f"the map is of {t_s!r} s, not {own['t_s']!r} s"
    known = np.frombuffer(octets_of(own["columns"]["vehicle"], "$.columns.vehicle"), dtype="<i8")
    if known.tolist() != now.vehicle.tolist():
        only = sorted(set(known.tolist()) ^ set(now.vehicle.tolist()))[:3]
        return f"{now.vehicle.size} remotes, not {known.size}: {only} in one alone"
    for name, text in own["columns"].items():
        column: FloatArray = getattr(now, name)
        octets = octets_of(text, f"$.columns.{name}")
        if octets == column.tobytes():
            continue
        if len(octets) != column.nbytes:
            return f"{name} has {column.nbytes} octets, not {len(octets)}"
        was = np.frombuffer(octets, dtype=column.dtype).reshape(column.shape)
        row = next(at for at in range(known.size) if was[at].tobytes() != column[at].tobytes())
        return f"{name} of remote {known[row]} is {column[row].tolist()}, not {was[row].tolist()}"
    return ""

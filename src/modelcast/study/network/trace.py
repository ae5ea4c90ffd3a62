"""The trace of a run: where everybody was, what was sent and what was received, row by row.

`TRACE` describes the tables and their columns; whoever writes or documents them goes by it.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import Kind
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.station.policy.base import MessageKind
from modelcast.station.sender.message_arrays import (
    CONTENT_FIT_S,
    CONTENT_KIND,
    CONTENT_MEMBER,
    CONTENT_NUMBER,
    CONTENT_VEHICLE,
    SENDER_BITS,
)
from modelcast.study.table import Column, count, quantity, text
from modelcast.world.scenario.base import FleetFrame

__all__ = ["TRACE", "TraceColumns", "TraceObserver"]

TraceColumns = Mapping[str, npt.NDArray[Any]]
"""Columns of equal length, by name."""


_MESSAGE = (
    count("sender", "station on the air: the origin, or the roadside unit that repeats"),
    count("origin", "station that made the message"),
    count("message", "number of the message among those of its origin's slot"),
)

TRACE: Mapping[str, tuple[Column, ...]] = MappingProxyType(
    {
        "positions": (
            quantity("t_s", "s", "time from the start of the run"),
            count("vehicle", "station; no number is used twice"),
            text("kind", "vehicle, pedestrian, cyclist, road_worker or roadside"),
            quantity("east_m", "m", "east of the origin, true"),
            quantity("north_m", "m", "north of it, true"),
            quantity("speed_mps", "m/s", "speed over ground"),
            quantity("heading_rad", "rad", "course, clockwise from north"),
            quantity("acceleration_mps2", "m/s²", "along the course"),
            quantity("length_m", "m", "length"),
        ),
        "transmissions": (
            quantity("t_s", "s", "when the radio was handed the message"),
            *_MESSAGE,
            count("size_bytes", "handed to the physical layer, MAC header included", unit="octets"),
            quantity("power_dbm", "dBm", "at the antenna connector"),
            count("priority", "0, the most urgent, to 7"),
            text("kind", "update, identification or keep-alive"),
            text("model", "sub-model that receivers go on by"),
        ),
        "receptions": (
            quantity("t_s", "s", "when the last bit arrived"),
            *_MESSAGE,
            count("receiver", "station that received it"),
            quantity("distance_m", "m", "between sender and receiver; empty where one is gone"),
            quantity("age_s", "s", "since the instant of the state that the message is of"),
            quantity("rssi_dbm", "dBm", "received power; empty where the radio knows none"),
        ),
        "expired": (
            quantity("t_s", "s", "end of the step in which it was given up"),
            count("origin", "station that made the message"),
            count("message", "number of the message, which was never on the air"),
        ),
    }
)
"""Tables of a trace by name, and their columns in order."""


class TraceObserver(AbstractObserver):
    """Hands every step of a fleet over as rows, the warm-up's too.

    Parameters
    ----------
    take
        Takes the name of a table of `TRACE` and its columns, in time.
    """

    def __init__(self, take: Callable[[str, TraceColumns], None]) -> None:
        self._take = take

    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Nothing is asked."""

    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Hand over who is where, what was sent, and what was received."""
        place_m, kind = _places(loop, frame)
        self._take("positions", _positions(loop, frame, place_m, kind))
        self._take("transmissions", _transmissions(loop))
        self._take("receptions", _receptions(loop, place_m))
        expired = loop.exchange.received.expired
        content = loop.origins(expired)
        self._take(
            "expired",
            {
                "t_s": np.full(expired.size, round(frame.t_s + loop.settings.dt_s, 6)),
                "origin": _whole(content[:, CONTENT_VEHICLE]),
                "message": _whole(content[:, CONTENT_NUMBER]),
            },
        )


def _places(loop: FleetLoop, frame: FleetFrame) -> tuple[FloatArray, IntArray]:
    """Places of all stations, NaN where nobody is, and their kinds: those of vehicles, then of units."""
    place_m = np.where(frame.active[:, None], frame.position_m, np.nan)
    kind = np.full(len(frame), int(Kind.VEHICLE)) if frame.kind is None else frame.kind
    if loop.units is None:
        return place_m, kind
    fixed_m = loop.units.roadside.places_m
    return np.concatenate([place_m, fixed_m]), np.append(kind, np.full(len(fixed_m), int(Kind.ROADSIDE)))


def _positions(loop: FleetLoop, frame: FleetFrame, place_m: FloatArray, kind: IntArray) -> TraceColumns:
    here = np.flatnonzero(np.isfinite(place_m[:, 0]))
    units = np.zeros(len(place_m) - len(frame))
    names = np.array([Kind(one).name.lower() for one in range(len(Kind))])
    columns: dict[str, npt.NDArray[Any]] = {
        "t_s": np.full(here.size, frame.t_s),
        "vehicle": loop.vehicle[here],
        "kind": names[kind[here]],
        "east_m": place_m[here, 0],
        "north_m": place_m[here, 1],
    }
    for name in ("speed_mps", "heading_rad", "acceleration_mps2", "length_m"):
        columns[name] = np.append(getattr(frame, name), units)[here]
    return columns


def _message(loop: FleetLoop, sender: IntArray, content: FloatArray) -> dict[str, npt.NDArray[Any]]:
    return {
        "sender": loop.vehicle[sender],
        "origin": _whole(content[:, CONTENT_VEHICLE]),
        "message": _whole(content[:, CONTENT_NUMBER]),
    }


def _transmissions(loop: FleetLoop) -> TraceColumns:
    sent = loop.exchange.sent
    content = loop.origins(sent.message_id)
    kinds = np.array([MessageKind(one).label for one in range(len(MessageKind))])
    models = np.array(loop.model_names)
    return {
        "t_s": sent.ready_s,
        **_message(loop, sent.sender, content),
        "size_bytes": sent.size_bytes,
        "power_dbm": sent.power_dbm,
        "priority": sent.priority,
        "kind": kinds[_whole(content[:, CONTENT_KIND])],
        "model": models[_whole(content[:, CONTENT_MEMBER])],
    }


def _receptions(loop: FleetLoop, place_m: FloatArray) -> TraceColumns:
    received = loop.exchange.received
    content = loop.origins(received.message_id)
    # A sender whose slot another has taken since is known by what it said; it is somewhere else.
    message = _message(loop, received.sender, content)
    direct = received.sender == received.message_id & ((1 << SENDER_BITS) - 1)
    gone = direct & (message["sender"] != message["origin"])
    message["sender"] = np.where(direct, message["origin"], message["sender"])
    way_m = place_m[received.sender] - place_m[received.receiver]
    return {
        "t_s": received.t_s,
        **message,
        "receiver": loop.vehicle[received.receiver],
        "distance_m": np.where(gone, np.nan, np.hypot(way_m[:, 0], way_m[:, 1])),
        "age_s": received.t_s - content[:, CONTENT_FIT_S],
        "rssi_dbm": received.rssi_dbm,
    }


def _whole(column: FloatArray) -> IntArray:
    return column.astype(np.int64)

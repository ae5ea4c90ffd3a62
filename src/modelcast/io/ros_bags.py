"""Trips out of ROS 2 bags: what both kinds of storage share, the topics with positions and their fields.

A trip is a topic of ``sensor_msgs/msg/NavSatFix`` or ``nav_msgs/msg/Odometry``, ``<stem>/<topic>`` without
the leading slash; a vehicle that publishes several becomes several trips.

============================  ================================================================================
Field                         Use
============================  ================================================================================
header.stamp                  time; Unix time where it is one, from 1973 on, else that of a simulation
**NavSatFix**
latitude, longitude           position [deg]
altitude                      height [m]; NaN is missing
status.status                 -1: skipped "no fix"; all others are fixes, also -2 (not told)
**Odometry**
pose.pose.position            x, y, z [m], taken as east, north, up (REP 103) of header.frame_id: a frame that
                              begins where the vehicle was started is turned by how it stood then
pose.pose.orientation         heading, from the yaw of the quaternion; missing where that is not of length 1
twist.twist.linear            speed [m/s]: the length of x, y, whichever frame they are in
twist.twist.angular.z         yaw rate [rad/s], anticlockwise and so turned round
all others                    not used
============================  ================================================================================

A twist that is exactly zero, or an orientation that is exactly unturned, in every message of a topic was
not filled: it is missing. Where a stamp is zero, the time is that at which the message was stored, less what
the topic's other messages took from stamp to storage, in the median; repaired "stamp missing, bag time
used".

Skipped and counted: "no fix", "position unavailable" (NaN, out of range, 0, 0), "duplicate time" (the first
is kept). Repaired and counted: "out of time order"; missing values, held or left out as `rows` says. Told
under the name of the file: messages of these types in other encodings than CDR, as of ROS 1; an end that is
missing.
A message that is too short or in another form is an error with its topic and number. A bag without such a
topic is an error that names what it has.

References
----------
docs.ros.org: sensor_msgs, nav_msgs; REP 103 (axes), REP 105 (frames).
"""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.core.rules import is_clean, shown
from modelcast.io.base import OnSkipped, Tally
from modelcast.io.gathered_trips import TripRows, UsableRows, first_origin, placed_on_earth, trips_of
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, gathered
from modelcast.io.packed import recording_stem
from modelcast.io.ros_messages import COLUMNS, MESSAGES, decode_message, message_name
from modelcast.io.rows import Rows, are_numbers, with_missing
from modelcast.io.skipped import free_name
from modelcast.trips.trajectory import Trajectory

__all__ = ["AbstractBag", "BagMessage", "bag_trips"]

_BLOCK_ROWS = 16_384
_FIX = "sensor_msgs/NavSatFix"
_NO_FIX = -1.0
_NANO = 1e-9
_BAG = "bag_s"
_FIRST_UNIX_S = 1e8
"""1973: no clock of a simulation has run as long."""

_MOST_NAMED = 6


class BagMessage(NamedTuple):
    """A message as its bag has it.

    Parameters
    ----------
    number
        Among the messages of the bag, from 1.
    topic, type_name, encoding
        Of its channel.
    t_ns
        When it was stored [ns].
    data
        Its octets.
    """

    number: int
    topic: str
    type_name: str
    encoding: str
    t_ns: int
    data: bytes


class AbstractBag(ABC):
    """A bag that can be gone through again and again."""

    path: str
    """As the user named it."""

    @abstractmethod
    def messages(self) -> Iterator[BagMessage]:
        """Yield its messages in the order in which they were stored; at least those of `MESSAGES`.

        Raises
        ------
        DataFormatError
            Where it is not what its format says.
        """

    @abstractmethod
    def told(self) -> list[str]:
        """Return what is to be said of the file in whole, known once all were read."""


class _Topic(NamedTuple):
    topic: str
    message: str


class _Row(NamedTuple):
    number: int
    key: _Topic
    values: tuple[float, ...]


def bag_trips(bag: AbstractBag, source: str, on_skipped: OnSkipped, held_bytes: int) -> Iterator[Trajectory]:
    """Yield a trip per topic.

    Parameters
    ----------
    bag
        The file.
    source
        Name of the format.
    on_skipped
        As for readers.
    held_bytes
        Octets of numbers that may be gathered at a time.
    """
    rows = _Topics(bag)
    names: dict[str, str] = {}
    for one in gathered(rows, held_bytes):
        name = free_name(names, one.key.topic.strip("/") or "topic")
        names[name] = ""
        first_ns = rows.first_ns or 0
        if one.key.message == _FIX:
            usable = partial(_fixes, origin=rows.origin, first_ns=first_ns)
        else:
            usable = partial(_odometry, first_ns=first_ns)
        yield from trips_of(bag.path, source, [TripRows(name, one.rows)], usable, on_skipped)
    stem = recording_stem(bag.path)
    for (topic, encoding), count in rows.unread.items():
        tally = Tally()
        tally.skip(f"in the encoding {shown(encoding)}, not cdr", count)
        on_skipped(f"{stem}/{topic.strip('/')}", tally.why_empty())
    for told in bag.told():
        on_skipped(stem, told)


class _Topics(AbstractKeyedRows[_Topic]):
    """The messages of a bag by topic.

    `origin` is the first fix and `first_ns` when the first message was stored, once they were read; `unread`
    counts messages in other encodings.
    """

    def __init__(self, bag: AbstractBag) -> None:
        self.bag = bag
        self.path = bag.path
        self.origin: Origin | None = None
        self.first_ns: int | None = None
        self.unread: Counter[tuple[str, str]] = Counter()

    @property
    def columns(self) -> int:
        """Those of a message, and when it was stored."""
        return len(COLUMNS) + 1

    def called(self, key: _Topic) -> str:
        """The topic."""
        return f"{recording_stem(self.path)}/{key.topic.strip('/')}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[_Topic]]:
        """Yield messages in blocks of a fixed number."""
        self.unread.clear()
        others: dict[str, str] = {}
        held: list[_Row] = []
        index = 0
        for message in self.bag.messages():
            key = _Topic(message.topic, message_name(message.type_name))
            if key.message not in MESSAGES:
                others.setdefault(message.topic, message.type_name)
            elif message.encoding != "cdr":
                self.unread[message.topic, message.encoding] += 1
            else:
                self._require_clean(message)
                held.append(_Row(message.number, key, self._values(message, key) if rows else ()))
            if len(held) == _BLOCK_ROWS:
                yield self._block(index, held, rows=rows)
                index, held = index + 1, []
        if held:
            yield self._block(index, held, rows=rows)
        elif not index:
            raise self._without_topics(others)

    def _require_clean(self, message: BagMessage) -> None:
        if not is_clean(message.topic):
            raise DataFormatError(
                self.path, f"the topic {shown(message.topic)} has characters that no name has",
                row=message.number, remedy="Record it anew under another name.",
            )  # fmt: skip

    def _values(self, message: BagMessage, key: _Topic) -> tuple[float, ...]:
        if self.first_ns is None:
            self.first_ns = message.t_ns
        try:
            said = decode_message(key.message, message.data)
        except ValueError as error:
            raise DataFormatError(
                self.path, f"{message.topic}, {key.message}: {error}", row=message.number,
                remedy="Rows count the messages of the bag; leave this topic out, or record it anew.",
            ) from error  # fmt: skip
        return (*said, (message.t_ns - self.first_ns) * _NANO)

    def _block(self, index: int, held: list[_Row], *, rows: bool) -> KeyedBlock[_Topic]:
        place: dict[_Topic, int] = {}
        number = np.array([place.setdefault(row.key, len(place)) for row in held], np.int64)
        found = None
        if rows:
            table = np.array([row.values for row in held], np.float64)
            columns = {name: table[:, at] for at, name in enumerate((*COLUMNS, _BAG))}
            found = Rows(np.array([row.number for row in held], np.int64), columns)
            if self.origin is None:
                fixes = np.array([row.key.message == _FIX for row in held], np.bool_)
                self.origin = first_origin(_placed(found.taken(fixes)))
        return KeyedBlock(index, list(place), number, found)

    def _without_topics(self, others: dict[str, str]) -> DataFormatError:
        if self.unread:
            (topic, encoding), _ = self.unread.most_common(1)[0]
            problem = f"{shown(topic)} is in the encoding {shown(encoding)}, not cdr"
        else:
            named = ", ".join(
                f"{shown(topic)} of {shown(kind)}" for topic, kind in list(others.items())[:_MOST_NAMED]
            )
            more = ", ..." if len(others) > _MOST_NAMED else ""
            problem = f"holds no topic of NavSatFix or Odometry: {named or 'no messages at all'}{more}"
        return DataFormatError(
            self.path, problem, remedy="Record the vehicle's position as one of the two messages of ROS 2."
        )


def _placed(raw: Rows) -> Rows:
    """Return fixes by the names of their position, NaN where there is no fix."""
    columns = raw.columns
    none = columns["status"] == _NO_FIX
    height = columns["z"]
    return raw.having(
        latitude_deg=with_missing(columns["x"], none),
        longitude_deg=with_missing(columns["y"], none),
        altitude_m=with_missing(height, ~are_numbers(height)),
    )


def _timed(raw: Rows, tally: Tally, first_ns: int) -> tuple[FloatArray, float | None]:
    """Return times from a whole second on, (R,) [s], and that second as Unix time where it is one."""
    columns = raw.columns
    stamped = (columns["stamp_s"] != 0.0) | (columns["stamp_ns"] != 0.0)
    second, rest_ns = divmod(first_ns, 10**9)
    start_s = float(columns["stamp_s"][stamped][0]) if stamped.any() else float(second)
    stamp = (columns["stamp_s"] - start_s) + columns["stamp_ns"] * _NANO
    stored = (second - start_s) + rest_ns * _NANO + columns[_BAG]
    took = float(np.median((stored - stamp)[stamped])) if stamped.any() else 0.0
    tally.repair("stamp missing, bag time used", int((~stamped).sum()))
    return np.where(stamped, stamp, stored - took), start_s if start_s > _FIRST_UNIX_S else None


def _fixes(raw: Rows, tally: Tally, origin: Origin | None, first_ns: int) -> UsableRows:
    """Return the fixes of a topic in SI units."""
    raw = raw.without(raw.columns["status"] == _NO_FIX, "no fix", tally)
    raw = placed_on_earth(_placed(raw), tally)
    t_s, unix_s = _timed(raw, tally, first_ns)
    names = ("latitude_deg", "longitude_deg", "altitude_m")
    rows = Rows(raw.line, {"t_s": t_s, **{name: raw.columns[name] for name in names}})
    return UsableRows(rows, origin=origin, unix_offset_s=unix_s)


def _odometry(raw: Rows, tally: Tally, first_ns: int) -> UsableRows:
    """Return the poses of a topic in SI units."""
    lost = ~(are_numbers(raw.columns["x"]) & are_numbers(raw.columns["y"]))
    raw = raw.without(lost, "position unavailable", tally)
    t_s, unix_s = _timed(raw, tally, first_ns)
    columns = raw.columns
    speed, turn, yaw, up = (columns[name] for name in ("speed_mps", "turn_radps", "yaw_rad", "z"))
    still = bool(((speed == 0.0) & (turn == 0.0)).all())
    found = {
        "t_s": t_s,
        "east_m": columns["x"],
        "north_m": columns["y"],
        "up_m": with_missing(up, ~are_numbers(up)),
        "speed_mps": with_missing(speed, ~are_numbers(speed) | still),
        "heading_rad": wrap_angle_rad(0.5 * np.pi - with_missing(yaw, np.full(yaw.shape, not yaw.any()))),
        "yaw_rate_radps": -with_missing(turn, ~are_numbers(turn) | still),
    }
    return UsableRows(Rows(raw.line, found), unix_offset_s=unix_s)

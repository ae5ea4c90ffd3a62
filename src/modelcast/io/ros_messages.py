"""Two ROS 2 messages out of their octets: ``sensor_msgs/NavSatFix`` and ``nav_msgs/Odometry``.

They are written in CDR, version 1, as ROS 2's middlewares do by default. Four octets say the form: the second
is 0 for the high octet first, 1 for the low octet first. Behind them every number begins at a multiple of its
own size, counted from the fifth octet; a text is its length with a closing zero as four octets, then its
octets. Both orders of octets are read; parameter lists and version 2 (XCDR2) are not.

==============================  ==========================================================================
``NavSatFix``                   ``Odometry``
==============================  ==========================================================================
``header.stamp`` int32, uint32  the same
``header.frame_id`` text        the same
``status.status`` int8          ``child_frame_id`` text
``status.service`` uint16       ``pose.pose.position`` 3 float64
latitude, longitude, altitude   ``pose.pose.orientation`` x, y, z, w, 4 float64
  3 float64                     ``pose.covariance`` 36 float64
``position_covariance``         ``twist.twist.linear``, ``angular`` 3 float64 each
  9 float64, and its type       ``twist.covariance`` 36 float64
  uint8
==============================  ==========================================================================

References
----------
docs.ros.org: sensor_msgs/msg/NavSatFix, nav_msgs/msg/Odometry (the same in Foxy and Jazzy). OMG DDSI-RTPS
2.5, section 10.5 (the four octets); DDS-XTypes 1.3, section 7.4.1 (alignment).
"""

import math
import struct
from collections.abc import Callable, Mapping
from types import MappingProxyType

__all__ = ["COLUMNS", "MESSAGES", "decode_message", "message_name"]

_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}
_ENVELOPE_OCTETS = 4
_LONGEST_TEXT = 4096
"""Names of frames are a few letters; a longer one is damage."""

_WHOLE_STAMP = 10**9
_FIX_TAIL_OCTETS = 9 * 8 + 1
_ODOMETRY_TAIL_OCTETS = 36 * 8
_UNIT_TOLERANCE = 0.1

COLUMNS = ("stamp_s", "stamp_ns", "x", "y", "z", "status", "yaw_rad", "speed_mps", "turn_radps")
"""What `decode_message` finds, in the order of its rows; NaN where a message has it not.

``x``, ``y``, ``z`` are latitude, longitude, altitude of a fix [deg, m] and the position of an odometry [m];
yaw and turn are anticlockwise, yaw from the x axis on.
"""

_NAN = float("nan")


class _Octets:
    """A message read from front to end, never beyond it."""

    def __init__(self, data: bytes, order: str) -> None:
        self._data, self._order, self._at = data, order, _ENVELOPE_OCTETS

    def take(self, form: str, size: int) -> tuple[float, ...]:
        """Return the next numbers of one kind, from a multiple of their size on."""
        self._at += -(self._at - _ENVELOPE_OCTETS) % size
        form = f"{self._order}{form}"
        end = self._at + struct.calcsize(form)
        if end > len(self._data):
            raise ValueError(f"has {len(self._data)} octets, fewer than the {end} that its fields take")
        found = struct.unpack_from(form, self._data, self._at)
        self._at = end
        return found

    def pass_text(self) -> None:
        """Go on behind a text."""
        length = int(self.take("I", 4)[0])
        if length > _LONGEST_TEXT or self._at + length > len(self._data):
            raise ValueError(f"a name of {length} octets in a message of {len(self._data)}")
        self._at += length

    def require(self, octets: int) -> None:
        """Raise where fewer octets are left."""
        left = len(self._data) - self._at
        if left < octets:
            raise ValueError(f"ends {octets - left} octets early")


def _fix(octets: _Octets) -> tuple[float, ...]:
    (status,) = octets.take("b", 1)
    octets.take("H", 2)
    place = octets.take("3d", 8)
    octets.require(_FIX_TAIL_OCTETS)
    return (*place, float(status), _NAN, _NAN, _NAN)


def _odometry(octets: _Octets) -> tuple[float, ...]:
    octets.pass_text()
    place = octets.take("3d", 8)
    yaw_rad = _yaw_rad(*octets.take("4d", 8))
    octets.take("36d", 8)
    ahead, left, _, _, _, turn = octets.take("6d", 8)
    octets.require(_ODOMETRY_TAIL_OCTETS)
    return (*place, 0.0, yaw_rad, math.hypot(ahead, left), turn)


def _yaw_rad(x: float, y: float, z: float, w: float) -> float:
    """The yaw of a unit quaternion; NaN where it is far from one, as one that nobody set."""
    if not abs(x * x + y * y + z * z + w * w - 1.0) < _UNIT_TOLERANCE:
        return _NAN
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


MESSAGES: Mapping[str, Callable[[_Octets], tuple[float, ...]]] = MappingProxyType(
    {"sensor_msgs/NavSatFix": _fix, "nav_msgs/Odometry": _odometry}
)
"""The messages that are read, by package and name."""


def message_name(type_name: str) -> str:
    """Return the package and name of a type, whichever way a bag writes it.

    Parameters
    ----------
    type_name
        As ``sensor_msgs/msg/NavSatFix``, or ``sensor_msgs::msg::dds_::NavSatFix_`` as DDS has it.

    Examples
    --------
    >>> message_name("sensor_msgs/msg/NavSatFix"), message_name("nav_msgs::msg::dds_::Odometry_")
    ('sensor_msgs/NavSatFix', 'nav_msgs/Odometry')
    """
    parts = [part for part in type_name.replace("::", "/").split("/") if part not in {"msg", "dds_"}]
    return "/".join(parts).removesuffix("_")


def decode_message(name: str, data: bytes) -> tuple[float, ...]:
    """Return what a message says, a number for each of `COLUMNS`.

    Parameters
    ----------
    name
        One of `MESSAGES`.
    data
        Its octets.

    Raises
    ------
    ValueError
        Where it is in another form, too short, or has a stamp that is none.
    """
    order = _ORDERS.get(data[:2])
    if order is None:
        raise ValueError(
            f"begins with {data[:4].hex(' ') or 'nothing'}: plain CDR begins with 00 00 or 00 01"
        )
    octets = _Octets(data, order)
    stamp_s, stamp_ns = octets.take("iI", 4)
    if stamp_ns >= _WHOLE_STAMP:
        raise ValueError(f"its stamp has {stamp_ns:.0f} nanoseconds, a second or more")
    octets.pass_text()
    return (float(stamp_s), float(stamp_ns), *MESSAGES[name](octets))

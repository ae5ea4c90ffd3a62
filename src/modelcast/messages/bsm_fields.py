"""The fields of a basic safety message: one table, from which everything else is derived.

Order, ranges, steps and codes are those of SAE J2735 (edition of March 2016), taken from published
descriptions of the data elements, and confirmed on real messages for the fields these fill. The standard
says for elevation, the axes of the error ellipse, steering wheel and accelerations that values beyond the
range take the last code. It says nothing of speeds above 163.8 m/s, nor of vehicles beyond 10.23 m by
40.95 m: they take the last code too. Positions outside the globe and instants outside the minute become
unavailable. The yaw rate has no code for unavailable.
"""

import math
from dataclasses import replace

from modelcast.messages.fields import Field, Outside

__all__ = [
    "BASIC_SAFETY_MESSAGE",
    "CORE_BITS",
    "CORE_FIELDS",
    "CORE_INDEX",
    "CORE_OCTETS",
    "LOCAL_REGION",
    "MAX_PART_II",
    "MAX_REGIONAL",
    "MESSAGE_ID",
    "PART_II_ID",
    "PART_II_NAMES",
    "PREAMBLE_BITS",
    "REGION_ID",
    "STANDARD_GRAVITY_MPS2",
    "core_field",
]

STANDARD_GRAVITY_MPS2 = 9.80665
"""The g of the vertical acceleration [m/s²]."""

_DEGREE = math.pi / 180.0
_CONTROL = ("unavailable", "off", "on", "engaged")

CORE_FIELDS: tuple[Field, ...] = (
    Field(
        "message_count", "msgCnt", low=0, high=127, outside=Outside.REFUSE,
        meaning="counts the sender's messages, modulo 128",
    ),
    Field(
        "temporary_id", "id", low=0, high=2**32 - 1, outside=Outside.REFUSE,
        meaning="four octets that name the sender for a while",
    ),
    Field(
        "second_of_minute_s", "secMark", low=0, high=65535, known=(0, 60999), unavailable=65535,
        step=(1, 1), unit="ms", si_per_unit=1e-3, outside=Outside.UNAVAILABLE,
        meaning="instant of the position within the UTC minute; from 60 s on, a leap second",
    ),
    Field(
        "latitude_deg", "lat", low=-900000000, high=900000001, known=(-900000000, 900000000),
        unavailable=900000001, step=(1, 10**7), unit="deg", outside=Outside.UNAVAILABLE,
        meaning="WGS-84 latitude, north positive",
    ),
    Field(
        "longitude_deg", "long", low=-1799999999, high=1800000001, known=(-1799999999, 1800000000),
        unavailable=1800000001, step=(1, 10**7), unit="deg", outside=Outside.MERIDIAN,
        meaning="WGS-84 longitude, east positive",
    ),
    Field(
        "elevation_m", "elev", low=-4096, high=61439, known=(-4095, 61439), unavailable=-4096,
        step=(1, 10), unit="m", meaning="above the ellipsoid",
    ),
    Field(
        "semi_major_m", "accuracy.semiMajor", low=0, high=255, known=(0, 254), unavailable=255,
        step=(1, 20), unit="m", meaning="longer axis of the error ellipse, one standard deviation",
    ),
    Field(
        "semi_minor_m", "accuracy.semiMinor", low=0, high=255, known=(0, 254), unavailable=255,
        step=(1, 20), unit="m", meaning="shorter axis",
    ),
    Field(
        "ellipse_orientation_rad", "accuracy.orientation", low=0, high=65535, known=(0, 65534),
        unavailable=65535, step=(360, 65535), unit="deg", si_per_unit=_DEGREE, outside=Outside.TURN,
        meaning="of the longer axis, clockwise from north",
    ),
    Field(
        "transmission", "transmission", low=0, high=7, unavailable=7, outside=Outside.REFUSE,
        choices=(
            "neutral", "park", "forwardGears", "reverseGears",
            "reserved1", "reserved2", "reserved3", "unavailable",
        ),
        meaning="state of the gearbox; reverseGears tells the sign of the speed",
    ),
    Field(
        "speed_mps", "speed", low=0, high=8191, known=(0, 8190), unavailable=8191,
        step=(1, 50), unit="m/s", meaning="without sign",
    ),
    Field(
        "heading_rad", "heading", low=0, high=28800, known=(0, 28799), unavailable=28800,
        step=(1, 80), unit="deg", si_per_unit=_DEGREE, outside=Outside.TURN,
        meaning="of the motion, clockwise from north",
    ),
    Field(
        "steering_wheel_rad", "angle", low=-126, high=127, known=(-126, 126), unavailable=127,
        step=(3, 2), unit="deg", si_per_unit=_DEGREE, meaning="steering wheel, right positive",
    ),
    Field(
        "acceleration_forward_mps2", "accelSet.long", low=-2000, high=2001, known=(-2000, 2000),
        unavailable=2001, step=(1, 100), unit="m/s²", meaning="forward positive",
    ),
    Field(
        "acceleration_right_mps2", "accelSet.lat", low=-2000, high=2001, known=(-2000, 2000),
        unavailable=2001, step=(1, 100), unit="m/s²", meaning="right positive",
    ),
    Field(
        "acceleration_down_mps2", "accelSet.vert", low=-127, high=127, known=(-126, 127),
        unavailable=-127, step=(1, 50), unit="g", si_per_unit=STANDARD_GRAVITY_MPS2, meaning="down positive",
    ),
    Field(
        "yaw_rate_radps", "accelSet.yaw", low=-32767, high=32767,
        step=(1, 100), unit="deg/s", si_per_unit=_DEGREE,
        meaning="clockwise positive; no code for unavailable",
    ),
    Field(
        "wheel_brakes", "brakes.wheelBrakes", low=0, high=31, unavailable=16, outside=Outside.REFUSE,
        flags=("unavailable", "left_front", "left_rear", "right_front", "right_rear"),
        meaning="wheels that are braked",
    ),
    Field(
        "traction_control", "brakes.traction", low=0, high=3, unavailable=0, outside=Outside.REFUSE,
        choices=_CONTROL, meaning="traction control",
    ),
    Field(
        "antilock_brakes", "brakes.abs", low=0, high=3, unavailable=0, outside=Outside.REFUSE,
        choices=_CONTROL, meaning="anti-lock brakes",
    ),
    Field(
        "stability_control", "brakes.scs", low=0, high=3, unavailable=0, outside=Outside.REFUSE,
        choices=_CONTROL, meaning="stability control",
    ),
    Field(
        "brake_boost", "brakes.brakeBoost", low=0, high=2, unavailable=0, outside=Outside.REFUSE,
        choices=("unavailable", "off", "on"), meaning="brake boost",
    ),
    Field(
        "auxiliary_brakes", "brakes.auxBrakes", low=0, high=3, unavailable=0, outside=Outside.REFUSE,
        choices=("unavailable", "off", "on", "reserved"), meaning="auxiliary brakes, often the parking brake",
    ),
    Field(
        "width_m", "size.width", low=0, high=1023, known=(1, 1023), unavailable=0,
        step=(1, 100), unit="m", meaning="of the vehicle",
    ),
    Field(
        "length_m", "size.length", low=0, high=4095, known=(1, 4095), unavailable=0,
        step=(1, 100), unit="m", meaning="of the vehicle",
    ),
)  # fmt: skip
"""Part I, in the order of the wire."""

CORE_INDEX: dict[str, int] = {field.name: index for index, field in enumerate(CORE_FIELDS)}
"""Place of a field in Part I, by our name."""


def core_field(name: str, standard_name: str = "") -> Field:
    """A row of a basic safety message.

    Parameters
    ----------
    name
        Our name.
    standard_name
        Name in the standard where it stands now; empty for the same.
    """
    field = CORE_FIELDS[CORE_INDEX[name]]
    return replace(field, standard_name=standard_name) if standard_name else field


CORE_BITS = sum(field.width_bits for field in CORE_FIELDS)
"""Bits of Part I: 290."""

PREAMBLE_BITS = 3
"""Before Part I: whether extension additions, Part II and regional extensions follow."""

CORE_OCTETS = (PREAMBLE_BITS + CORE_BITS + 7) // 8
"""Both together, where nothing follows."""

MESSAGE_ID = Field("message_id", "messageId", low=0, high=32767, outside=Outside.REFUSE, meaning="of a frame")
BASIC_SAFETY_MESSAGE = 20
"""Message id of a basic safety message."""

PART_II_ID = Field("part_ii_id", "partII-Id", low=0, high=63, outside=Outside.REFUSE, meaning="of Part II")
PART_II_NAMES = {
    0: "vehicle safety extensions",
    1: "special vehicle extensions",
    2: "supplemental vehicle extensions",
}
MAX_PART_II = 8
"""Part II holds one to eight entries, where it is there."""

REGION_ID = Field("region_id", "regionId", low=0, high=255, outside=Outside.REFUSE, meaning="of an extension")
LOCAL_REGION = 128
"""First of the region ids left to local use."""
MAX_REGIONAL = 4
"""One to four regional extensions, where there are any."""

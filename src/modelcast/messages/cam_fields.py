"""The fields of a cooperative awareness message of a vehicle that are understood, and their codes.

Written from published facts of ETSI EN 302 637-2 and TS 102 894-2 (names, ranges, units), as the library that
encodes them has them. Angles of yaw are anticlockwise positive, accelerations forward positive.
"""

from typing import Final

import numpy as np

from modelcast.messages.fields import Field, Outside

__all__ = ["CAM_FIELDS", "CAM_INDEX", "CAM_ROLES", "MAX_PATH_POINTS", "PATH_FIELDS"]

_DEGREE: Final = float(np.pi / 180.0)

CAM_ROLES: Final = (
    "default",
    "publicTransport",
    "specialTransport",
    "dangerousGoods",
    "roadWork",
    "rescue",
    "emergency",
    "safetyCar",
    "agriculture",
    "commercial",
    "military",
    "roadOperator",
    "taxi",
    "reserved1",
    "reserved2",
    "reserved3",
)
"""Roles of a vehicle by their codes."""

MAX_PATH_POINTS: Final = 40

CAM_FIELDS: Final = (
    Field(
        "station_id", "header.stationID", low=0, high=2**32 - 1, outside=Outside.REFUSE,
        meaning="changes with the pseudonym",
    ),
    Field(
        "generation_s", "generationDeltaTime", low=0, high=65535, step=(1, 1000), unit="s",
        outside=Outside.TURN,
        meaning="TAI since the first of January 2004, modulo 65.536 s",
    ),
    Field(
        "station_type", "basicContainer.stationType", low=0, high=255, outside=Outside.REFUSE,
        meaning="5 is a passenger car",
    ),
    Field(
        "latitude_deg", "referencePosition.latitude", low=-900000000, high=900000001,
        known=(-900000000, 900000000), unavailable=900000001, step=(1, 10**7), unit="deg",
        outside=Outside.UNAVAILABLE, meaning="WGS-84 latitude, north positive",
    ),
    Field(
        "longitude_deg", "referencePosition.longitude", low=-1800000000, high=1800000001,
        known=(-1800000000, 1800000000), unavailable=1800000001, step=(1, 10**7), unit="deg",
        outside=Outside.UNAVAILABLE, meaning="WGS-84 longitude, east positive",
    ),
    Field(
        "altitude_m", "referencePosition.altitude.altitudeValue", low=-100000, high=800001,
        known=(-100000, 800000), unavailable=800001, step=(1, 100), unit="m", meaning="above the ellipsoid",
    ),
    Field(
        "heading_rad", "heading.headingValue", low=0, high=3601, known=(0, 3599), unavailable=3601,
        step=(1, 10), unit="deg", si_per_unit=_DEGREE, outside=Outside.TURN,
        meaning="of the motion, clockwise from north",
    ),
    Field(
        "speed_mps", "speed.speedValue", low=0, high=16383, known=(0, 16382), unavailable=16383,
        step=(1, 100), unit="m/s", meaning="without sign",
    ),
    Field(
        "length_m", "vehicleLength.vehicleLengthValue", low=1, high=1023, known=(1, 1021), unavailable=1023,
        step=(1, 10), unit="m", meaning="of the vehicle",
    ),
    Field(
        "width_m", "vehicleWidth", low=1, high=62, known=(1, 60), unavailable=62, step=(1, 10), unit="m",
        meaning="of the vehicle",
    ),
    Field(
        "acceleration_forward_mps2", "longitudinalAcceleration.longitudinalAccelerationValue", low=-160,
        high=161, known=(-160, 160), unavailable=161, step=(1, 10), unit="m/s²", meaning="forward positive",
    ),
    Field(
        "yaw_rate_radps", "yawRate.yawRateValue", low=-32766, high=32767, known=(-32766, 32766),
        unavailable=32767, step=(1, 100), unit="deg/s", si_per_unit=_DEGREE, meaning="anticlockwise positive",
    ),
)  # fmt: skip
"""Fields that `modelcast.messages.cam` reads and writes; all others are written as unavailable."""

CAM_INDEX: Final = {field.name: place for place, field in enumerate(CAM_FIELDS)}
"""Place of each field by name."""

PATH_FIELDS: Final = (
    Field(
        "delta_latitude_deg", "pathPosition.deltaLatitude", low=-131071, high=131072, known=(-131071, 131071),
        unavailable=131072, step=(1, 10**7), unit="deg", meaning="from the position of the message",
    ),
    Field(
        "delta_longitude_deg", "pathPosition.deltaLongitude", low=-131071, high=131072,
        known=(-131071, 131071), unavailable=131072, step=(1, 10**7), unit="deg", meaning="the same",
    ),
    Field(
        "delta_altitude_m", "pathPosition.deltaAltitude", low=-12700, high=12800, known=(-12700, 12799),
        unavailable=12800, step=(1, 100), unit="m", meaning="the same",
    ),
    Field(
        "age_s", "pathDeltaTime", low=0, high=65535, known=(1, 65535), unavailable=0, step=(1, 100), unit="s",
        meaning="since the vehicle was there",
    ),
)  # fmt: skip
"""Fields of a point of the path behind; 0 stands for an age that is left out."""

"""The fields of a personal safety message: one table, from which everything else is derived.

Order, ranges and codes are those of SAE J2735 (edition of March 2016), taken from published descriptions of
the data elements. Elements that a basic safety message has too are its rows (`bsm_fields`).

Notes
-----
Eighteen parts are optional. Packed encoding rules cannot step over a part without knowing its type, so those
that are not in `READ_OPTIONS` are refused by name when read, and never written.
"""

from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.fields import Field, Outside

__all__ = [
    "ACCELERATION_FIELDS",
    "OPTION_NAMES",
    "PATH_PREDICTION_FIELDS",
    "PERSONAL_SAFETY_MESSAGE",
    "PERSON_FIELDS",
    "PERSON_INDEX",
    "READ_OPTIONS",
]

PERSONAL_SAFETY_MESSAGE = 32
"""Message id of a personal safety message."""


def _same(*names: str) -> tuple[Field, ...]:
    """Rows of a basic safety message, by our names."""
    return tuple(CORE_FIELDS[CORE_INDEX[name]] for name in names)


PERSON_FIELDS: tuple[Field, ...] = (
    Field(
        "basic_type", "basicType", low=0, high=4, unavailable=0, outside=Outside.REFUSE,
        choices=("unavailable", "aPEDESTRIAN", "aPEDALCYCLIST", "aPUBLICSAFETYWORKER", "anANIMAL"),
        meaning="who carries the device",
    ),
    *_same(
        "second_of_minute_s", "message_count", "temporary_id", "latitude_deg", "longitude_deg", "elevation_m",
        "semi_major_m", "semi_minor_m", "ellipse_orientation_rad", "speed_mps", "heading_rad",
    ),
)  # fmt: skip
"""What every message holds, in the order of the wire; the elevation may be left out."""

PERSON_INDEX: dict[str, int] = {field.name: index for index, field in enumerate(PERSON_FIELDS)}
"""Place of a field in `PERSON_FIELDS`, by our name."""

ACCELERATION_FIELDS: tuple[Field, ...] = _same(
    "acceleration_forward_mps2", "acceleration_right_mps2", "acceleration_down_mps2", "yaw_rate_radps"
)
"""The optional ``accelSet``."""

PATH_PREDICTION_FIELDS: tuple[Field, ...] = (
    Field(
        "path_radius_m", "radiusOfCurve", low=-32767, high=32767, step=(1, 10), unit="m",
        meaning="of the path ahead, right positive; the last code is a straight path",
    ),
    Field(
        "path_confidence_ratio", "confidence", low=0, high=200, step=(1, 200),
        meaning="of the path ahead",
    ),
)  # fmt: skip
"""The optional ``pathPrediction``."""

OPTION_NAMES = (
    "accelSet", "pathHistory", "pathPrediction", "propulsion", "useState", "crossRequest", "crossState",
    "clusterSize", "clusterRadius", "eventResponderType", "activityType", "activitySubType", "assistType",
    "sizing", "attachment", "attachmentRadius", "animalType", "regional",
)  # fmt: skip
"""Optional parts in the order of their bits."""

READ_OPTIONS = ("accelSet", "pathPrediction", "regional")
"""Optional parts that are read and written."""

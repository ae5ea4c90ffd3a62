"""The fields of a personal safety message: one table, from which everything else is derived.

Order, ranges and codes are those of SAE J2735 (edition of March 2016), taken from published descriptions of
the data elements. Elements that a basic safety message has too are its rows (`bsm_fields`).
"""

from modelcast.messages.bsm_fields import core_field
from modelcast.messages.fields import Field, Outside
from modelcast.messages.path_history_fields import PATH_HISTORY
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Truth, record_of

__all__ = [
    "ACCELERATION_FIELDS",
    "OPTION_NAMES",
    "PART_SHAPES",
    "PATH_PREDICTION_FIELDS",
    "PERSONAL_SAFETY_MESSAGE",
    "PERSON_FIELDS",
    "PERSON_INDEX",
]

PERSONAL_SAFETY_MESSAGE = 32
"""Message id of a personal safety message."""

PERSON_FIELDS: tuple[Field, ...] = (
    Field(
        "basic_type", "basicType", low=0, high=4, unavailable=0, outside=Outside.REFUSE,
        choices=("unavailable", "aPEDESTRIAN", "aPEDALCYCLIST", "aPUBLICSAFETYWORKER", "anANIMAL"),
        meaning="who carries the device",
    ),
    core_field("second_of_minute_s"),
    core_field("message_count"),
    core_field("temporary_id"),
    core_field("latitude_deg", "position.lat"),
    core_field("longitude_deg", "position.long"),
    core_field("elevation_m", "position.elevation"),
    core_field("semi_major_m"),
    core_field("semi_minor_m"),
    core_field("ellipse_orientation_rad"),
    core_field("speed_mps"),
    core_field("heading_rad"),
)  # fmt: skip
"""What every message holds, in the order of the wire; the elevation may be left out."""

PERSON_INDEX: dict[str, int] = {field.name: index for index, field in enumerate(PERSON_FIELDS)}
"""Place of a field in `PERSON_FIELDS`, by our name."""

ACCELERATION_FIELDS: tuple[Field, ...] = tuple(
    core_field(name)
    for name in (
        "acceleration_forward_mps2", "acceleration_right_mps2", "acceleration_down_mps2", "yaw_rate_radps",
    )
)  # fmt: skip
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


def _choices(name: str, standard_name: str, *names: str) -> Number:
    """One of some names, the first of which is ``unavailable``, with room for more in later editions."""
    field = Field(
        name, standard_name, low=0, high=len(names), unavailable=0, outside=Outside.REFUSE,
        choices=("unavailable", *names),
    )  # fmt: skip
    return Number(field, extensible=True)


def _flags(name: str, standard_name: str, *names: str) -> Number:
    """Any of some names, the first of which is ``unavailable``, with room for more in later editions."""
    field = Field(
        name, standard_name, low=0, high=2 ** (len(names) + 1) - 1, unavailable=2 ** len(names),
        outside=Outside.REFUSE, flags=("unavailable", *names),
    )  # fmt: skip
    return Number(field, extensible=True)


def _truth(name: str, standard_name: str) -> Truth:
    return Truth(Field(name, standard_name, low=0, high=1, outside=Outside.REFUSE))


PART_SHAPES: tuple[AbstractShape, ...] = (
    record_of("acceleration", "accelSet", ACCELERATION_FIELDS),
    PATH_HISTORY,
    Record(
        "path_prediction",
        "pathPrediction",
        members=tuple(Number(field) for field in PATH_PREDICTION_FIELDS),
        extensible=True,
    ),
    Choice(
        "propulsion",
        "propulsion",
        alternatives=(
            _choices(
                "human", "human", "otherTypes", "onFoot", "skateboard", "pushOrKickScooter", "wheelchair"
            ),
            _choices("animal", "animal", "otherTypes", "animalMounted", "animalDrawnCarriage"),
            _choices(
                "motor", "motor", "otherTypes", "wheelChair", "bicycle", "scooter", "selfBalancingDevice"
            ),
        ),
    ),
    _flags(
        "use_state", "useState",
        "other", "idle", "listening_to_audio", "typing", "calling", "playing_games", "reading", "viewing",
    ),
    _truth("cross_request", "crossRequest"),
    _truth("cross_state", "crossState"),
    _choices("cluster_size", "clusterSize", "small", "medium", "large"),
    Number(Field("cluster_radius_m", "clusterRadius", low=0, high=100, unit="m")),
    _choices(
        "event_responder_type", "eventResponderType",
        "towOperater", "fireAndEMSWorker", "aDOTWorker", "lawEnforcement", "hazmatResponder",
        "animalControlWorker", "otherPersonnel",
    ),
    _flags(
        "activity_type", "activityType",
        "working_on_road", "setting_up_closures", "responding_to_events", "directing_traffic",
        "other_activities",
    ),
    _flags(
        "activity_sub_type", "activitySubType",
        "police_and_traffic_officers", "traffic_control_persons", "railroad_crossing_guards",
        "civil_defense_national_guard_military_police", "emergency_organization_personnel",
        "highway_service_vehicle_personnel",
    ),
    _flags("assist_type", "assistType", "other_type", "vision", "hearing", "movement", "cognition"),
    _flags(
        "sizing", "sizing",
        "small_stature", "large_stature", "erratic_moving", "slow_moving",
    ),
    _choices(
        "attachment", "attachment",
        "stroller", "bicycleTrailer", "cart", "wheelchair", "otherWalkAssistAttachments", "pet",
    ),
    Number(Field("attachment_radius_m", "attachmentRadius", low=0, high=200, step=(1, 10), unit="m")),
    _choices("animal_type", "animalType", "serviceUse", "pet", "farm"),
)  # fmt: skip
"""The optional parts in the order of their bits, without ``regional``, which stands behind them."""

OPTION_NAMES = (*(shape.standard_name for shape in PART_SHAPES), "regional")
"""The standard's names of all optional parts in the order of their bits."""

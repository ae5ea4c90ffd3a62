"""The path history of SAE J2735 (DF_PathHistory, edition of March 2016): where a station has been.

Order, ranges and codes are from published descriptions of the data elements, as in `bsm_fields`, whose rows
stand here where an element is the same.
"""

from dataclasses import replace

from modelcast.messages.bsm_fields import core_field
from modelcast.messages.fields import Field, Outside
from modelcast.messages.shapes import Number, Record, Series, record_of

__all__ = ["MAX_CRUMBS", "PATH_HISTORY"]

MAX_CRUMBS = 23
"""A path history has one point at least, and this many at most."""


def _confidence(name: str, standard_name: str, prefix: str, steps: str) -> Field:
    """A row of names from coarse to fine, that for unavailable first."""
    choices = ("unavailable", *(prefix + step for step in steps.split()))
    return Field(
        name, standard_name, low=0, high=len(choices) - 1, unavailable=0, outside=Outside.REFUSE,
        choices=choices, meaning="confidence of 95 %",
    )  # fmt: skip


def _part_of_a_date(name: str, known: tuple[int, int], *, unavailable: int) -> Number:
    """A count with one code more, for unavailable, at one end."""
    low, high = min(known[0], unavailable), max(known[1], unavailable)
    return Number(
        Field(name, name, low=low, high=high, known=known, unavailable=unavailable, outside=Outside.REFUSE)
    )


_UTC_TIME = Record(
    "utc_time",
    "utcTime",
    members=(
        _part_of_a_date("year", (1, 4095), unavailable=0),
        _part_of_a_date("month", (1, 12), unavailable=0),
        _part_of_a_date("day", (1, 31), unavailable=0),
        _part_of_a_date("hour", (0, 30), unavailable=31),
        _part_of_a_date("minute", (0, 59), unavailable=60),
        Number(core_field("second_of_minute_s", "second")),
        Number(Field("offset_s", "offset", low=-840, high=840, unit="min", si_per_unit=60.0)),
    ),
    optional=frozenset({"year", "month", "day", "hour", "minute", "second_of_minute_s", "offset_s"}),
)  # fmt: skip

_ACCURACY = record_of(
    "accuracy",
    "posAccuracy",
    tuple(core_field(name) for name in ("semi_major_m", "semi_minor_m", "ellipse_orientation_rad")),
)

_POSITION = Record(
    "initial_position",
    "initialPosition",
    members=(
        _UTC_TIME,
        Number(core_field("longitude_deg")),
        Number(core_field("latitude_deg")),
        Number(core_field("elevation_m", "elevation")),
        Number(core_field("heading_rad")),
        record_of(
            "transmission_and_speed",
            "speed",
            (core_field("transmission", "transmisson"), core_field("speed_mps")),
        ),
        _ACCURACY,
        Number(
            _confidence(
                "time_confidence",
                "timeConfidence",
                "time-",
                "100-000 050-000 020-000 010-000 002-000 001-000 000-500 000-200 000-100 000-050 000-020 "
                "000-010 000-005 000-002 000-001 000-000-5 000-000-2 000-000-1 000-000-05 000-000-02 "
                "000-000-01 000-000-005 000-000-002 000-000-001 000-000-000-5 000-000-000-2 000-000-000-1 "
                "000-000-000-05 000-000-000-02 000-000-000-01 000-000-000-005 000-000-000-002 "
                "000-000-000-001 000-000-000-000-5 000-000-000-000-2 000-000-000-000-1 000-000-000-000-05 "
                "000-000-000-000-02 000-000-000-000-01",
            )
        ),
        record_of(
            "position_confidence",
            "posConfidence",
            (
                _confidence(
                    "position",
                    "pos",
                    "a",
                    "500m 200m 100m 50m 20m 10m 5m 2m 1m 50cm 20cm 10cm 5cm 2cm 1cm",
                ),
                _confidence(
                    "elevation",
                    "elevation",
                    "elev-",
                    "500-00 200-00 100-00 050-00 020-00 010-00 005-00 002-00 001-00 000-50 000-20 000-10 "
                    "000-05 000-02 000-01",
                ),
            ),
        ),
        record_of(
            "motion_confidence",
            "speedConfidence",
            (
                _confidence(
                    "heading", "heading", "prec", "10deg 05deg 01deg 0-1deg 0-05deg 0-01deg 0-0125deg"
                ),
                _confidence("speed", "speed", "prec", "100ms 10ms 5ms 1ms 0-1ms 0-05ms 0-01ms"),
                _confidence("throttle", "throttle", "prec", "10percent 1percent 0-5percent"),
            ),
        ),
    ),
    optional=frozenset(
        {
            "utc_time", "elevation_m", "heading_rad", "transmission_and_speed", "accuracy",
            "time_confidence", "position_confidence", "motion_confidence",
        }
    ),
    extensible=True,
)  # fmt: skip

_OFFSET = Field(
    "latitude_offset_deg", "latOffset", low=-131072, high=131071, known=(-131071, 131071),
    unavailable=-131072, step=(1, 10**7), unit="deg", meaning="from the station's position, north positive",
)  # fmt: skip

_CRUMB = Record(
    "crumb",
    "PathHistoryPoint",
    members=(
        Number(_OFFSET),
        Number(
            replace(
                _OFFSET,
                name="longitude_offset_deg",
                standard_name="lonOffset",
                meaning="from the station's position, east positive",
            )
        ),
        Number(
            Field(
                "elevation_offset_m", "elevationOffset", low=-2048, high=2047, known=(-2047, 2047),
                unavailable=-2048, step=(1, 10), unit="m", meaning="from the station's position, up positive",
            )
        ),
        Number(
            Field(
                "age_s", "timeOffset", low=1, high=65535, known=(1, 65534), unavailable=65535, step=(1, 100),
                unit="s", meaning="how long ago",
            )
        ),
        Number(core_field("speed_mps")),
        _ACCURACY,
        Number(
            Field(
                "heading_rad", "heading", low=0, high=240, known=(0, 239), unavailable=240, step=(3, 2),
                unit="deg", si_per_unit=core_field("heading_rad").si_per_unit, outside=Outside.TURN,
                meaning="of the motion, clockwise from north",
            )
        ),
    ),
    optional=frozenset({"speed_mps", "accuracy", "heading_rad"}),
    extensible=True,
)  # fmt: skip

PATH_HISTORY = Record(
    "path_history",
    "pathHistory",
    members=(
        _POSITION,
        Number(
            Field(
                "gnss_status", "currGNSSstatus", low=0, high=255, unavailable=128, outside=Outside.REFUSE,
                flags=(
                    "unavailable", "is_healthy", "is_monitored", "base_station_type", "pdop_under_5",
                    "in_view_under_5", "local_corrections_present", "network_corrections_present",
                ),
            )
        ),
        Series("crumbs", "crumbData", item=_CRUMB, most=MAX_CRUMBS),
    ),
    optional=frozenset({"initial_position", "gnss_status"}),
    extensible=True,
)  # fmt: skip
"""The shape of a path history."""

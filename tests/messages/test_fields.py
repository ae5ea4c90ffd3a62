"""Claims about fields: what becomes of values, known and unknown, within the range and beyond it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.messages.bsm_fields import CORE_BITS, CORE_FIELDS, CORE_INDEX, STANDARD_GRAVITY_MPS2
from modelcast.messages.fields import Field, Outside

HALF_STEP_SLACK = 1e-6
"""A value exactly between two codes may fall to either by rounding of the conversion to steps."""

QUANTITIES = [field for field in CORE_FIELDS if field.outside is not Outside.REFUSE]


def code(name: str, value: float | None) -> int:
    return CORE_FIELDS[CORE_INDEX[name]].code_of(value)


def test_part_i_takes_290_bits() -> None:
    assert CORE_BITS == 290


@pytest.mark.parametrize("field", CORE_FIELDS, ids=lambda field: field.name)
def test_every_code_that_stands_for_a_value_survives_the_way_there_and_back(field: Field) -> None:
    first, last = field.known_codes
    step = max(1, (last - first) // 997)
    for number in {first, last, *range(first, last + 1, step)}:
        value = field.value_of(number)
        assert (value is None) == (number == field.unavailable)
        assert field.code_of(value) == number


@given(st.sampled_from(QUANTITIES), st.floats(0, 1))
def test_a_value_within_the_range_comes_back_within_half_a_step(field: Field, share: float) -> None:
    first, last = field.known_codes
    value = (first + share * (last - first)) * field.resolution
    back = field.value_of(field.code_of(value))
    assert back is not None
    off = abs(back - value)
    if field.outside is Outside.TURN:
        off = min(off, 2 * math.pi - off)
    assert off <= (0.5 + HALF_STEP_SLACK) * field.resolution


@given(st.sampled_from(QUANTITIES), st.floats())
def test_no_value_wraps(field: Field, value: float) -> None:
    """Beyond the range a quantity takes the end or becomes unavailable; angles keep their direction."""
    if math.isnan(value) and field.unavailable is None:
        with pytest.raises(ValueError, match="not known"):
            field.code_of(value)
        return
    found = field.code_of(value)
    first, last = field.known_codes
    if math.isnan(value):
        assert found == field.unavailable
    elif field.outside is Outside.CLAMP and value >= (last + 1) * field.resolution:
        assert found == last
    elif field.outside is Outside.CLAMP and value <= (first - 1) * field.resolution:
        assert found == first
    elif field.outside is Outside.UNAVAILABLE and not (
        (first - 1) * field.resolution < value < (last + 1) * field.resolution
    ):
        assert found == field.unavailable
    assert field.low <= found <= field.high


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("speed_mps", 163.80, 8190),
        ("speed_mps", 163.82, 8190),  # one more would say unavailable
        ("speed_mps", 1e300, 8190),
        ("speed_mps", -3.0, 0),
        ("speed_mps", None, 8191),
        ("heading_rad", math.radians(359.9875), 28799),
        ("heading_rad", math.radians(359.999), 0),  # not 28800, which says unavailable
        ("heading_rad", 2 * math.pi, 0),
        ("heading_rad", -math.pi / 2, 21600),
        ("heading_rad", math.inf, 28800),
        ("ellipse_orientation_rad", math.radians(359.999), 0),  # not 65535, which says unavailable
        ("latitude_deg", 90.0, 900000000),
        ("latitude_deg", 90.1, 900000001),
        ("latitude_deg", -91.0, 900000001),
        ("latitude_deg", math.nan, 900000001),
        ("longitude_deg", 180.0, 1800000000),
        ("longitude_deg", -180.0, 1800000000),  # the same meridian; the type has no code for -180
        ("longitude_deg", -180.1, 1800000001),
        ("longitude_deg", 190.0, 1800000001),
        ("elevation_m", -500.0, -4095),
        ("elevation_m", 7000.0, 61439),
        ("elevation_m", None, -4096),
        ("semi_major_m", 12.7, 254),
        ("semi_major_m", 50.0, 254),
        ("steering_wheel_rad", math.radians(-500.0), -126),
        ("steering_wheel_rad", math.radians(500.0), 126),
        ("acceleration_forward_mps2", 20.01, 2000),
        ("acceleration_right_mps2", -30.0, -2000),
        ("acceleration_down_mps2", -3 * STANDARD_GRAVITY_MPS2, -126),
        ("acceleration_down_mps2", 3 * STANDARD_GRAVITY_MPS2, 127),
        ("acceleration_down_mps2", None, -127),
        ("yaw_rate_radps", math.radians(-400.0), -32767),
        ("second_of_minute_s", 59.999, 59999),
        ("second_of_minute_s", 60.5, 60500),
        ("second_of_minute_s", 61.0, 65535),
        ("second_of_minute_s", -0.001, 65535),
        ("width_m", 0.001, 1),  # not 0, which says unavailable
        ("width_m", 11.0, 1023),
        ("length_m", None, 0),
        ("transmission", None, 7),
        ("wheel_brakes", None, 16),
    ],
)
def test_values_at_and_beyond_the_ends(name: str, value: float | None, expected: int) -> None:
    assert code(name, value) == expected


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("message_count", 128.0),
        ("message_count", 1.5),
        ("message_count", None),
        ("temporary_id", 2.0**32),
        ("temporary_id", math.nan),
        ("transmission", 8.0),
        ("brake_boost", 3.0),
        ("yaw_rate_radps", None),
    ],
)
def test_what_can_stand_for_nothing_is_refused_by_name(name: str, value: float | None) -> None:
    with pytest.raises(ValueError, match=name):
        code(name, value)


def test_reserved_seconds_are_neither_a_value_nor_unavailable() -> None:
    field = CORE_FIELDS[CORE_INDEX["second_of_minute_s"]]
    assert field.is_reserved(61000)
    assert field.value_of(61000) is None
    assert not field.is_reserved(65535)


@pytest.mark.parametrize("wrong", [{"known": (0, 9)}, {"unavailable": 9}, {"known": (5, 4)}])
def test_codes_outside_the_type_are_refused(wrong: dict) -> None:
    with pytest.raises(ValueError, match="x: "):
        Field("x", "x", low=0, high=7, **wrong)

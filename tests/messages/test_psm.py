"""Claims about personal safety messages: the octets are the standard's, and no octets do harm."""

from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.asn1 import reference_codec
from modelcast.messages.fields import Field
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm, person_codes
from modelcast.messages.psm_fields import (
    ACCELERATION_FIELDS,
    OPTION_NAMES,
    PATH_PREDICTION_FIELDS,
    PERSON_FIELDS,
    PERSON_INDEX,
    READ_OPTIONS,
)

OCTETS = st.binary(min_size=1, max_size=40) | st.binary(min_size=126, max_size=130)
REGIONAL = st.lists(st.tuples(st.integers(0, 255), OCTETS), max_size=4).map(tuple)
ADDITIONS = st.lists(st.none() | OCTETS, max_size=4).map(
    lambda found: tuple(found) if any(one is not None for one in found) else ()
)
UNKNOWN_ELEVATION = -4096


def codes_of(fields: tuple[Field, ...]) -> Any:
    return st.tuples(*(st.integers(field.low, field.high) for field in fields))


@st.composite
def messages(draw: Any, additions: Any = ADDITIONS) -> PersonalSafetyMessage:
    codes = list(draw(codes_of(PERSON_FIELDS)))
    has_elevation = draw(st.booleans())
    if not has_elevation:
        codes[PERSON_INDEX["elevation_m"]] = UNKNOWN_ELEVATION
    return PersonalSafetyMessage(
        tuple(codes),
        has_elevation=has_elevation,
        acceleration=draw(st.just(()) | codes_of(ACCELERATION_FIELDS)),
        path_prediction=draw(st.just(()) | codes_of(PATH_PREDICTION_FIELDS)),
        regional=draw(REGIONAL),
        additions=draw(additions),
        frame_additions=draw(additions),
    )


def reference(message: PersonalSafetyMessage) -> bytes:
    """Octets that asn1tools makes of a message."""
    value: dict[str, Any] = {"position": {}}
    for field, code in zip(PERSON_FIELDS, message.codes, strict=True):
        group, _, name = field.standard_name.rpartition(".")
        if field.name == "elevation_m":
            if message.has_elevation:
                value["position"]["elevation"] = code
            continue
        if name in {"lat", "long"}:
            group = "position"
        plain = field.choices[code] if field.choices else code
        if field.name == "temporary_id":
            plain = code.to_bytes(4, "big")
        (value.setdefault(group, {}) if group else value)[name] = plain
    if message.acceleration:
        value["accelSet"] = {
            field.standard_name.rpartition(".")[2]: code
            for field, code in zip(ACCELERATION_FIELDS, message.acceleration, strict=True)
        }
    if message.path_prediction:
        value["pathPrediction"] = {
            field.standard_name: code
            for field, code in zip(PATH_PREDICTION_FIELDS, message.path_prediction, strict=True)
        }
    if message.regional:
        value["regional"] = [{"regionId": i, "regExtValue": octets} for i, octets in message.regional]
    inner = reference_codec().encode("PersonalSafetyMessage", value)
    return reference_codec().encode("MessageFrame", {"messageId": 32, "value": inner})


@given(messages())
@settings(max_examples=200)
def test_a_message_comes_back_whole(message: PersonalSafetyMessage) -> None:
    assert decode_psm(encode_psm(message)) == message


@given(messages(additions=st.just(())))
@settings(max_examples=200)
def test_octets_are_those_of_the_compiled_module(message: PersonalSafetyMessage) -> None:
    assert encode_psm(message) == reference(message)


@pytest.mark.parametrize(
    ("codes", "octets"),
    [
        (tuple(field.low for field in PERSON_FIELDS), "00201c" + "00" * 9 + "01" + "00" * 18),
        (
            tuple(field.high for field in PERSON_FIELDS),
            "00201c000009fffffffffffffd6b49d201d693a400ffffffffffffffff0800",
        ),
    ],
    ids=["lowest codes are zero bits, but for the elevation that is there", "highest codes"],
)
def test_golden_octets(codes: tuple[int, ...], octets: str) -> None:
    message = PersonalSafetyMessage(codes)
    assert encode_psm(message).hex() == reference(message).hex() == octets


@given(st.binary(max_size=120))
@example(b"")
@settings(max_examples=300)
def test_any_octets_are_refused_or_encode_to_themselves(octets: bytes) -> None:
    for whole in (octets, b"\x00\x20" + octets, b"\x00\x20" + bytes([len(octets)]) + octets):
        try:
            message = decode_psm(whole)
        except CodecError:
            continue
        assert encode_psm(message) == whole


@pytest.mark.parametrize("name", [name for name in OPTION_NAMES if name not in READ_OPTIONS])
def test_a_part_that_is_not_read_is_refused_by_name(name: str) -> None:
    octets = bytearray(
        encode_psm(PersonalSafetyMessage(person_codes({"message_count": 1, "temporary_id": 2})))
    )
    bit = 1 + OPTION_NAMES.index(name)
    octets[3 + bit // 8] |= 0x80 >> bit % 8
    with pytest.raises(CodecError, match=name):
        decode_psm(bytes(octets))


def test_a_message_cut_short_is_refused_at_every_length() -> None:
    octets = encode_psm(PersonalSafetyMessage(person_codes({"message_count": 1, "temporary_id": 2})))
    for stop in range(len(octets)):
        with pytest.raises(CodecError):
            decode_psm(octets[:stop])
        if stop > 3:
            with pytest.raises(CodecError):
                decode_psm(octets[:2] + bytes([stop - 3]) + octets[3:stop])


@pytest.mark.parametrize(
    ("codes", "more", "match"),
    [
        ({"speed_mps": 1.0, "steering_wheel_rad": 0.0}, {}, "no field is called"),
        ({"elevation_m": 3.0}, {"has_elevation": False}, "left out"),
        ({}, {"acceleration": (0, 0)}, "acceleration must be 4"),
        ({}, {"path_prediction": (0, 201)}, "path_confidence_ratio"),
        ({}, {"regional": ((1, b"a"),) * 5}, "4 entries at most"),
        ({"basic_type": 5}, {}, "basic_type"),
    ],
)
def test_what_cannot_be_written_is_refused(codes: dict[str, float], more: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        PersonalSafetyMessage(person_codes({"message_count": 1, "temporary_id": 2, **codes}), **more)

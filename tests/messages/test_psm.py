"""Claims about personal safety messages: the octets are the standard's, and no octets do harm."""

import runpy
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import asn1tools
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.asn1 import module_text
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm, person_codes
from modelcast.messages.psm_codec import PsmCodec
from modelcast.messages.psm_fields import OPTION_NAMES, PART_SHAPES, PERSON_FIELDS
from modelcast.messages.psm_reference import (
    person_reference_value,
    reference_decode_psm,
    reference_encode_psm,
)
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series

from .people import ADDITIONS, messages, values_of

CHECK = Path(__file__).parents[2] / "fuzz" / "decoding.py"
check = runpy.run_path(str(CHECK))["check"]

PLAIN = PersonalSafetyMessage(person_codes({"message_count": 1, "temporary_id": 2}))
PUBLISHED = "00201a0000021bd86891de75f84da101c13f042e2214141fff00022c20"
"""The sample of the US DOT's Operational Data Environment (usdot-jpo-ode/jpo-ode, `udpsender_psm.py`)."""

SHAPES = pytest.mark.parametrize("shape", PART_SHAPES, ids=lambda shape: shape.name)


@given(messages())
@settings(max_examples=200)
def test_a_message_comes_back_whole(message: PersonalSafetyMessage) -> None:
    assert decode_psm(encode_psm(message)) == message


@given(messages(additions=st.just(())))
@settings(max_examples=200)
def test_octets_are_those_of_the_compiled_module(message: PersonalSafetyMessage) -> None:
    octets = encode_psm(message)
    assert octets == reference_encode_psm(message)
    assert reference_decode_psm(octets) == message


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Codec that pycrate makes of our module, in a process of its own: its compiler keeps global state."""
    folder = tmp_path_factory.mktemp("pycrate")
    source, compiled = folder / "modules.asn", folder / "compiled_modules.py"
    source.write_text(module_text(), encoding="ascii")
    script = (
        "import sys; from pycrate_asn1c.asnproc import compile_text, generate_modules; "
        "from pycrate_asn1c.generator import PycrateGenerator; "
        "compile_text(open(sys.argv[1]).read()); generate_modules(PycrateGenerator, sys.argv[2])"
    )
    subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-c", script, str(source), str(compiled)], check=True, capture_output=True
    )
    return runpy.run_path(str(compiled))["ModelcastPersonalSafetyMessage"].PersonalSafetyMessage


def as_pycrate(item: Any) -> Any:
    """The same value, bit strings as whole numbers."""
    match item:
        case dict():
            return {name: as_pycrate(one) for name, one in item.items()}
        case list():
            return [as_pycrate(one) for one in item]
        case (bytes() as octets, int() as width):
            return int.from_bytes(octets, "big") >> -width % 8, width
        case _:
            return item


@given(message=messages(additions=st.just(())))
@settings(max_examples=200)
def test_another_compiler_of_the_module_writes_the_same_octets(
    judge: Any, message: PersonalSafetyMessage
) -> None:
    judge.set_val(as_pycrate(person_reference_value(message)))
    octets = judge.to_uper()
    assert encode_psm(message).endswith(octets)
    judge.from_uper(octets)
    assert judge.to_uper() == octets


def test_a_published_message_holds_what_another_decoder_printed() -> None:
    """As printed beside it (usdot-jpo-ode/jpo-geojsonconverter, README): id 24779D7E, heading 111.225."""
    message = decode_psm(bytes.fromhex(PUBLISHED))
    assert encode_psm(message).hex() == PUBLISHED
    assert reference_decode_psm(bytes.fromhex(PUBLISHED)) == message
    assert not message.has_elevation
    told = {field.name: message.value(field.name) for field in PERSON_FIELDS}
    assert told["basic_type"] == 1
    assert told["second_of_minute_s"] == pytest.approx(3.564)
    assert told["message_count"] == 26
    assert told["temporary_id"] == 0x24779D7E
    assert told["latitude_deg"] == pytest.approx(40.2397377, abs=1e-9)
    assert told["longitude_deg"] == pytest.approx(-74.2761437, abs=1e-9)
    assert told["speed_mps"] == 0.0
    assert np.degrees(told["heading_rad"] or 0.0) == pytest.approx(111.225)


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
    assert encode_psm(message).hex() == reference_encode_psm(message).hex() == octets


@pytest.mark.parametrize(
    ("more", "octets"),
    [
        ({"acceleration": (0, 0, 0, 0)}, 6),
        ({"path_prediction": (32767, 200)}, 3),
        ({"parts": (("cross_state", 1),)}, 0),
        ({"parts": (("propulsion", (2, 3)), ("use_state", 0b000100000))}, 2),
        ({"parts": (("path_history", (None, None, ((0, 0, 0, 1, None, None, None),))),)}, 9),
    ],
)
def test_a_part_takes_the_bits_of_its_type(more: dict[str, Any], octets: int) -> None:
    """Beyond the 31 octets of a message without it, which has four bits to spare."""
    message = PersonalSafetyMessage(PLAIN.codes, **more)
    assert len(encode_psm(message)) == len(reference_encode_psm(message)) == 31 + octets


def refused_or_the_same(octets: bytes) -> None:
    check(octets)
    try:
        message = decode_psm(octets)
    except CodecError:
        return
    assert encode_psm(message) == octets


@given(st.binary(max_size=120))
@example(b"")
@settings(max_examples=300)
def test_any_octets_are_refused_or_encode_to_themselves(octets: bytes) -> None:
    for whole in (octets, b"\x00\x20" + octets, b"\x00\x20" + bytes([len(octets)]) + octets):
        refused_or_the_same(whole)


@given(
    messages(),
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=4),
    st.data(),
)
@settings(max_examples=200)
def test_bent_messages_are_refused_or_encode_to_themselves(
    message: PersonalSafetyMessage, bends: list[tuple[float, int]], data: st.DataObject
) -> None:
    octets = bytearray(encode_psm(message))
    for place, octet in bends:
        octets[int(place * len(octets))] = octet
    length = data.draw(st.integers(0, len(octets)) | st.just(len(octets)))
    refused_or_the_same(bytes(octets[:length]))


FULL = PersonalSafetyMessage(
    PLAIN.codes,
    acceleration=(0, 0, 0, 0),
    path_prediction=(32767, 200),
    parts=(
        ("path_history", (None, 128, ((1, -1, 0, 10, 70, (1, 2, 3), 7), (2, -2, 0, 20, None, None, None)))),
        ("propulsion", (1, 2)),
        ("use_state", 1),
        ("cross_request", 0),
        ("cross_state", 1),
        ("cluster_size", 3),
        ("cluster_radius_m", 100),
        ("event_responder_type", 7),
        ("activity_type", 1),
        ("activity_sub_type", 1),
        ("assist_type", 1),
        ("sizing", 1),
        ("attachment", 6),
        ("attachment_radius_m", 200),
        ("animal_type", 3),
    ),
    regional=((128, b"model"),),
)


def test_a_message_with_every_part_bent_at_every_bit_and_cut_at_every_octet() -> None:
    octets = encode_psm(FULL)
    assert octets == reference_encode_psm(FULL)
    for bit in range(8 * len(octets)):
        bent = bytearray(octets)
        bent[bit // 8] ^= 0x80 >> bit % 8
        refused_or_the_same(bytes(bent))
    for stop in range(len(octets)):
        with pytest.raises(CodecError):
            decode_psm(octets[:stop])
        if stop > 3:
            with pytest.raises(CodecError):
                decode_psm(octets[:2] + bytes([stop - 3]) + octets[3:stop])
    with pytest.raises(CodecError, match="left over"):
        decode_psm(octets + b"\0")


@pytest.mark.parametrize("elevation", [True, False])
def test_a_message_cut_short_is_refused_at_every_length(elevation: bool) -> None:
    octets = encode_psm(PersonalSafetyMessage(PLAIN.codes, has_elevation=elevation))
    for stop in range(len(octets)):
        with pytest.raises(CodecError):
            decode_psm(octets[:stop])
        if stop > 3:
            with pytest.raises(CodecError):
                decode_psm(octets[:2] + bytes([stop - 3]) + octets[3:stop])


@pytest.mark.parametrize(
    ("bit", "reason"),
    [
        (24 + 19, "basicType of a later edition"),
        (24 + 20, "basicType [4-7] is beyond 4|basicType"),
        (24 + 78, "extensions of position are not read"),
        (24 + 80, "regional extensions of position are not read"),
    ],
)
def test_what_cannot_be_read_is_refused_where_it_stands(bit: int, reason: str) -> None:
    octets = bytearray(encode_psm(PersonalSafetyMessage((1, *PLAIN.codes[1:]))))
    octets[bit // 8] |= 0x80 >> bit % 8
    with pytest.raises(CodecError, match=reason) as refused:
        decode_psm(bytes(octets))
    assert refused.value.offset_bits == bit


@cache
def later() -> Any:
    """A later edition of the module, with extensions where ours has their marks."""
    return asn1tools.compile_string(
        module_text()
        .replace("anANIMAL (4), ...", "anANIMAL (4), ..., aROBOT (5)")
        .replace("farm (3), ...", "farm (3), ..., wild (4)")
        .replace(
            "confidence          INTEGER (0..200),\n  ...", "confidence INTEGER (0..200),\n  ..., later NULL"
        )
        .replace(
            "motor               MotorizedPropelledType,\n  ...",
            "motor MotorizedPropelledType, ..., jet NULL",
        ),
        "uper",
    )


"""A later edition, as another compiler reads it."""


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"basicType": "aROBOT"}, "basicType of a later edition"),
        ({"animalType": "wild"}, "animalType of a later edition"),
        (
            {"pathPrediction": {"radiusOfCurve": 0, "confidence": 0, "later": None}},
            "pathPrediction of a later",
        ),
        ({"propulsion": ("jet", None)}, "propulsion of a later edition"),
    ],
)
def test_what_only_a_later_edition_has_is_refused_by_name(change: dict[str, Any], reason: str) -> None:
    inner = later().encode("PersonalSafetyMessage", person_reference_value(PLAIN) | change)
    octets = later().encode("MessageFrame", {"messageId": 32, "value": inner})
    with pytest.raises(CodecError, match=reason):
        decode_psm(octets)


def test_more_flags_than_this_edition_has_are_refused_by_name() -> None:
    octets = bytearray(encode_psm(PersonalSafetyMessage(PLAIN.codes, parts=(("use_state", 0),))))
    bit = 24 + 220  # behind what every message holds
    octets[bit // 8] |= 0x80 >> bit % 8
    with pytest.raises(CodecError, match="useState of a later edition") as refused:
        decode_psm(bytes(octets))
    assert refused.value.offset_bits == bit


@given(ADDITIONS.filter(bool))
@settings(max_examples=30)
def test_extension_additions_of_the_message_are_kept(additions: tuple[bytes | None, ...]) -> None:
    message = PersonalSafetyMessage(PLAIN.codes, additions=additions)
    assert decode_psm(encode_psm(message)).additions == additions


def test_the_module_has_every_part_where_the_table_has_it() -> None:
    module = asn1tools.parse_string(module_text())["ModelcastPersonalSafetyMessage"]
    members = module["types"]["PersonalSafetyMessage"]["members"]
    names = [member["name"] for member in members if member is not None and member.get("optional")]
    assert names == list(OPTION_NAMES)
    assert names[: len(PART_SHAPES)] == [shape.standard_name for shape in PART_SHAPES]


@SHAPES
@given(data=st.data())
@settings(max_examples=20)
def test_a_part_alone_comes_back_at_any_bit(shape: AbstractShape, data: st.DataObject) -> None:
    value = data.draw(values_of(shape))
    offset = data.draw(st.integers(0, 7))
    writer = BitWriter()
    writer.bits(0, offset)
    shape.write(writer, value)
    reader = BitReader(writer.octets())
    reader.bits(offset)
    assert shape.read(reader) == shape.checked(value) == value
    assert reader.left < 8


@pytest.mark.parametrize(
    ("codes", "more", "match"),
    [
        ({"speed_mps": 1.0, "steering_wheel_rad": 0.0}, {}, "no field is called"),
        ({"elevation_m": 3.0}, {"has_elevation": False}, "left out"),
        ({}, {"acceleration": (0, 0)}, "acceleration must be 4"),
        ({}, {"path_prediction": (0, 201)}, "path_confidence_ratio"),
        ({}, {"regional": ((1, b"a"),) * 5}, "4 entries at most"),
        ({}, {"additions": (None,)}, "at least one"),
        ({"basic_type": 5}, {}, "basic_type"),
        ({}, {"parts": (("sizing", 32),)}, "sizing must be a whole number within 0..31"),
        ({}, {"parts": (("sizing", (1,)),)}, "sizing must be a whole number"),
        ({}, {"parts": (("cross_state", 2),)}, "cross_state"),
        ({}, {"parts": (("cross_state", 1), ("cross_request", 1))}, "each once and in this order"),
        ({}, {"parts": (("cross_state", 1), ("cross_state", 1))}, "each once"),
        ({}, {"parts": (("acceleration", (0, 0, 0, 0)),)}, "parts must be some of path_history"),
        ({}, {"parts": (("propulsion", (3, 0)),)}, "propulsion must be the place of one of 3"),
        ({}, {"parts": (("propulsion", (0, 6)),)}, "human"),
        ({}, {"parts": (("path_history", (None, None, ())),)}, "crumbs must be 1 to 23"),
        ({}, {"parts": (("path_history", (None, None)),)}, "path_history must be 3 values"),
        ({}, {"parts": (("path_history", (None, None, None)),)}, "crumbs cannot be left out"),
    ],
)
def test_what_cannot_be_written_is_refused(codes: dict[str, float], more: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        PersonalSafetyMessage(person_codes({"message_count": 1, "temporary_id": 2, **codes}), **more)


def test_numbers_of_numpy_become_pythons() -> None:
    message = PersonalSafetyMessage(
        tuple(np.array(PLAIN.codes)),
        parts=(("propulsion", (1, np.int64(2))), ("attachment_radius_m", np.int64(20))),  # type: ignore[arg-type]
    )
    assert decode_psm(encode_psm(message)) == message
    assert type(message.codes[0]) is type(message.part("attachment_radius_m")) is int


def test_a_part_is_found_by_its_name() -> None:
    assert FULL.part("acceleration") == (0, 0, 0, 0)
    assert FULL.part("cross_request") == 0
    assert PLAIN.part("acceleration") is PLAIN.part("cross_request") is None
    with pytest.raises(KeyError):
        FULL.part("crossRequest")


def test_the_codec_does_what_the_functions_do() -> None:
    codec = PsmCodec()
    octets = codec.encode(FULL)
    assert octets == encode_psm(FULL)
    assert codec.decode(octets) == FULL


def test_every_kind_of_shape_is_met() -> None:
    """What the claims above draw from holds records in records, lists and choices."""

    def kinds(shape: AbstractShape) -> set[type]:
        inner: tuple[AbstractShape, ...] = ()
        match shape:
            case Record(members=members):
                inner = members
            case Series(item=item):
                inner = (item,)
            case Choice(alternatives=alternatives):
                inner = alternatives
            case _:
                pass
        return {type(shape)}.union(*map(kinds, inner))

    assert {Number, Record, Series, Choice} <= set().union(*map(kinds, PART_SHAPES))

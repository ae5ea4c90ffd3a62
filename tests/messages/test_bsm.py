"""Claims about single basic safety messages: the octets are the standard's, and no octets do harm."""

import math
import runpy
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import asn1tools
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.asn1 import module_text, reference_decode, reference_encode, reference_value
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm, encode_bsm, encode_message
from modelcast.messages.bsm_codec import BsmCodec
from modelcast.messages.bsm_document import document_of, message_of
from modelcast.messages.bsm_fields import CORE_BITS, CORE_FIELDS, CORE_INDEX
from modelcast.messages.frame import MAX_FRAME_OCTETS, MessageFrame, decode_frame, encode_frame

CHECK = Path(__file__).parents[2] / "fuzz" / "decoding.py"
check = runpy.run_path(str(CHECK))["check"]
CORES = st.tuples(*(st.integers(field.low, field.high) for field in CORE_FIELDS)).map(BsmCore)
OCTETS = st.binary(min_size=1, max_size=40) | st.binary(min_size=126, max_size=130)
ADDITIONS = st.lists(st.none() | OCTETS, max_size=4).map(
    lambda found: tuple(found) if any(one is not None for one in found) else ()
)
PART_II = st.lists(st.tuples(st.integers(0, 63), OCTETS), max_size=8).map(tuple)
REGIONAL = st.lists(st.tuples(st.integers(0, 255), OCTETS), max_size=4).map(tuple)
PLAIN = st.builds(BasicSafetyMessage, CORES, part_ii=PART_II, regional=REGIONAL)
MESSAGES = st.builds(
    BasicSafetyMessage,
    CORES,
    part_ii=PART_II,
    regional=REGIONAL,
    additions=ADDITIONS,
    frame_additions=ADDITIONS,
)
LOWEST = BsmCore(tuple(field.low for field in CORE_FIELDS))
HIGHEST = BsmCore(tuple(field.high for field in CORE_FIELDS))
RANDOM_MESSAGES = 3000
"""As many as the tests can afford; `benchmarks/bsm_codec.py` compares a million."""


@given(MESSAGES)
@settings(max_examples=200)
def test_a_message_comes_back_whole(message: BasicSafetyMessage) -> None:
    assert decode_bsm(encode_message(message)) == message


@given(PLAIN)
@settings(max_examples=200)
def test_octets_are_those_of_the_compiled_module(message: BasicSafetyMessage) -> None:
    octets = encode_message(message)
    assert octets == reference_encode(message)
    assert reference_decode(octets) == message


def test_random_cores_are_those_of_the_compiled_module() -> None:
    rng = np.random.default_rng(4)
    columns = [rng.integers(field.low, field.high + 1, RANDOM_MESSAGES) for field in CORE_FIELDS]
    for codes in np.stack(columns, axis=1).tolist():
        message = BasicSafetyMessage(BsmCore(tuple(codes)))
        octets = encode_bsm(message.core)
        assert octets == reference_encode(message)
        assert decode_bsm(octets) == reference_decode(octets) == message


@pytest.mark.parametrize(
    ("core", "octets"),
    [
        (LOWEST, "001425" + "00" * 37),
        (
            HIGHEST,
            "0014251ffffffffffffff5a4e900eb49d2007ffffffffffffffff080fdfa1fa1fefffefff7fffff8",
        ),
    ],
    ids=["lowest codes are zero bits", "highest codes"],
)
def test_golden_octets(core: BsmCore, octets: str) -> None:
    assert encode_bsm(core).hex() == octets


def test_real_messages_decode_to_the_values_another_decoder_printed(
    real_messages: list[dict[str, Any]],
) -> None:
    """Its transmission is left out: it prints neutral where the three bits say unavailable."""
    assert len(real_messages) == 60
    for real in real_messages:
        core = decode_bsm(bytes.fromhex(real["hex"])).core
        told, values = real["decoded"], core.values()
        assert values["message_count"] == told["msgCnt"]
        assert f"{int(values['temporary_id'] or 0):08x}" == told["id"]
        assert values["second_of_minute_s"] == pytest.approx(told["secMark"] * 1e-3)
        assert values["latitude_deg"] == told["position"]["latitude"]
        assert values["longitude_deg"] == told["position"]["longitude"]
        assert values["elevation_m"] == told["position"]["elevation"]
        assert values["semi_major_m"] == told["accuracy"]["semiMajor"]
        assert values["semi_minor_m"] == told["accuracy"]["semiMinor"]
        assert values["speed_mps"] == told["speed"]
        assert math.degrees(values["heading_rad"] or 0.0) == pytest.approx(told["heading"])
        assert values["steering_wheel_rad"] is told.get("angle")
        assert values["acceleration_forward_mps2"] == told["accelSet"]["accelLong"]
        assert values["acceleration_right_mps2"] == told["accelSet"]["accelLat"]
        assert values["acceleration_down_mps2"] == told["accelSet"]["accelVert"]
        assert values["yaw_rate_radps"] == told["accelSet"]["accelYaw"]
        assert (values["wheel_brakes"] is None) == told["brakes"]["wheelBrakes"]["unavailable"]
        assert values["width_m"] == told["size"]["width"] / 100
        assert values["length_m"] == told["size"]["length"] / 100
        document = document_of(BasicSafetyMessage(core))
        for ours, theirs in (
            ("traction_control", "traction"),
            ("antilock_brakes", "abs"),
            ("stability_control", "scs"),
            ("brake_boost", "brakeBoost"),
            ("auxiliary_brakes", "auxBrakes"),
        ):
            assert document[ours] == told["brakes"][theirs]


def test_real_messages_encode_to_the_same_octets(real_messages: list[dict[str, Any]]) -> None:
    for real in real_messages:
        octets = bytes.fromhex(real["hex"])
        message = decode_bsm(octets)
        assert [number for number, _ in message.part_ii] == real["partII_ids"]
        assert encode_message(message) == reference_encode(message) == octets
        assert encode_message(message_of(document_of(message))) == octets


def refused_or_the_same(octets: bytes) -> None:
    if check(octets):
        message = decode_bsm(octets)
        assert message_of(document_of(message)) == message


@given(st.binary(max_size=200))
@example(b"")
@settings(max_examples=300)
def test_any_octets_are_refused_or_encode_to_themselves(octets: bytes) -> None:
    refused_or_the_same(octets)
    refused_or_the_same(b"\x00\x14" + octets)


@given(
    MESSAGES,
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=4),
    st.data(),
)
@settings(max_examples=300)
def test_bent_messages_are_refused_or_encode_to_themselves(
    message: BasicSafetyMessage, bends: list[tuple[float, int]], data: st.DataObject
) -> None:
    octets = bytearray(encode_message(message))
    for place, octet in bends:
        octets[int(place * len(octets))] = octet
    length = data.draw(st.integers(0, len(octets)) | st.just(len(octets)))
    refused_or_the_same(bytes(octets[:length]))


@given(MESSAGES)
def test_no_message_is_the_beginning_of_another(message: BasicSafetyMessage) -> None:
    octets = encode_message(message)
    for cut in (octets[:-1], octets + b"\0", octets[: len(octets) // 2]):
        with pytest.raises(CodecError):
            decode_bsm(cut)


@pytest.mark.parametrize(
    ("octets", "bit", "reason"),
    [
        ("", 0, "1 bits needed, 0 left"),
        ("00", 1, "15 bits needed"),
        ("0014", 16, "8 bits needed"),
        ("001325" + "00" * 37, 1, "message id 19 where 20"),
        ("001400", 16, "without a message"),
        ("0014c1", 16, "fragmented"),
        ("00148025" + "00" * 37, 16, "long form"),
        ("001426" + "00" * 37, 24, "38 octets needed, 37 left"),
        ("001401ff", 27, "7 bits needed, 5 left"),
        ("001425" + "ff" * 37, 82, "lat 1247483647 is beyond 900000001"),
        ("001425" + "00" * 36 + "01", 317, "padding"),
        ("001426" + "00" * 38, 320, "1 octets left over"),
        ("001425" + "00" * 37 + "0000", 320, "2 octets left over"),
        ("00" * 20_000, 8 * MAX_FRAME_OCTETS, "at most"),
    ],
)
def test_a_refusal_tells_place_and_reason(octets: str, bit: int, reason: str) -> None:
    with pytest.raises(CodecError, match=reason) as refused:
        decode_bsm(bytes.fromhex(octets))
    assert refused.value.offset_bits == bit
    assert str(refused.value) == f"bit {bit}: {refused.value.reason}"


@pytest.mark.parametrize("index", range(len(CORE_FIELDS)), ids=lambda i: CORE_FIELDS[i].name)
def test_codes_beyond_the_type_are_refused_where_they_stand(index: int) -> None:
    """A field whose range is no power of two can hold bits that mean nothing."""
    field = CORE_FIELDS[index]
    width = field.width_bits
    before = sum(one.width_bits for one in CORE_FIELDS[:index])
    bits = ((1 << width) - 1) << (296 - 3 - before - width)
    octets = b"\x00\x14\x25" + bits.to_bytes(37, "big")
    if field.high - field.low == (1 << width) - 1:
        assert decode_bsm(octets).core.codes[index] == field.high
        return
    with pytest.raises(CodecError, match="beyond") as refused:
        decode_bsm(octets)
    assert refused.value.offset_bits == 24 + 3 + before


@given(st.lists(st.none() | OCTETS, min_size=1, max_size=3).filter(any))
@settings(max_examples=50)
def test_extension_additions_are_those_of_a_later_module(additions: list[bytes | None]) -> None:
    """A module with three more fields, as a later edition may have, compiled by asn1tools."""
    later = later_module().encode(
        "BasicSafetyMessage",
        reference_value(BasicSafetyMessage(HIGHEST))
        | {f"later{i}": octets for i, octets in enumerate(additions) if octets is not None},
    )
    message = decode_bsm(encode_frame(20, later))
    assert message.core == HIGHEST
    expected: list[bytes | None] = []
    for octets in additions:
        writer = BitWriter()
        if octets is not None:
            writer.open_type(octets)
        expected.append(writer.octets() or None)
    assert list(message.additions)[: len(additions)] == expected
    assert not any(message.additions[len(additions) :])


@cache
def later_module() -> Any:
    """A later edition of the module, with additions that ours does not know."""
    return asn1tools.compile_string(
        module_text().replace(
            "regional    SEQUENCE (SIZE (1..4)) OF RegionalExtension OPTIONAL,\n  ...",
            "regional    SEQUENCE (SIZE (1..4)) OF RegionalExtension OPTIONAL,\n  ...,\n  "
            + ",\n  ".join(f"later{i} OCTET STRING OPTIONAL" for i in range(3)),
        ),
        "uper",
    )


def test_more_than_64_additions_come_back() -> None:
    message = BasicSafetyMessage(LOWEST, additions=(*[None] * 99, b"\x01"))
    assert decode_bsm(encode_message(message)) == message


def test_the_module_has_the_ranges_of_the_table() -> None:
    """Each field's ends fit the module and one more does not: the module and the table say the same."""
    middle = [max(field.low, 0) for field in CORE_FIELDS]
    for index, field in enumerate(CORE_FIELDS):
        for code in (field.low, field.high):
            codes = (*middle[:index], code, *middle[index + 1 :])
            message = BasicSafetyMessage(BsmCore(codes))
            assert encode_message(message) == reference_encode(message), field.name
    parsed = asn1tools.parse_string(module_text())["ModelcastBasicSafetyMessage"]["types"]
    told: list[Any] = []

    def collect(name: str) -> None:
        for member in parsed[name]["members"]:
            if member["type"] in parsed and parsed[member["type"]]["type"] == "SEQUENCE":
                collect(member["type"])
            else:
                told.append(member | parsed.get(member["type"], {}))

    collect("BSMcoreData")
    assert len(told) == len(CORE_FIELDS)
    for member, field in zip(told, CORE_FIELDS, strict=True):
        if "restricted-to" in member:
            assert member["restricted-to"] == [(field.low, field.high)], field.name
        elif field.choices:
            assert tuple(name for name, _ in member["values"]) == field.choices
        elif field.flags:
            assert len(member["named-bits"]) == len(field.flags)
            assert member["size"] == [len(field.flags)]


def test_a_core_alone_takes_40_octets_and_an_extension_of_24_takes_26_more() -> None:
    core = BsmCore.from_values({"message_count": 0, "temporary_id": 0, "yaw_rate_radps": 0.0})
    assert len(encode_bsm(core)) == 40
    # Two bits of count, eight of id, eight of length, 24 octets; three bits were spare.
    assert len(encode_bsm(core, regional=[(128, bytes(24))])) == 40 + 26


@given(CORES)
def test_values_of_a_core_give_the_core_but_for_reserved_codes(core: BsmCore) -> None:
    values = core.values()
    again = BsmCore.from_values(values)
    for field, code, other in zip(CORE_FIELDS, core.codes, again.codes, strict=True):
        assert other == (field.unavailable if field.is_reserved(code) else code)
        assert core.value(field.name) == values[field.name]


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        ({"part_ii": ((64, b"1"),)}, "part_ii_id"),
        ({"part_ii": ((1, b""),)}, "1 to 16383"),
        ({"part_ii": ((1, b"1"),) * 9}, "8 entries"),
        ({"regional": ((256, b"1"),)}, "region_id"),
        ({"regional": ((-1, b"1"),)}, "region_id"),
        ({"regional": ((1, bytes(20_000)),)}, "1 to 16383"),
        ({"regional": ((1, b"1"),) * 5}, "4 entries"),
        ({"additions": (None,)}, "at least one"),
        ({"frame_additions": (b"",)}, "1 to 16383"),
        ({"additions": (b"1",) * 20_000}, "at most"),
    ],
)
def test_what_cannot_be_written_is_a_value_error(wrong: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        encode_bsm(LOWEST, **wrong)


def test_a_message_too_long_for_a_frame_is_a_value_error() -> None:
    with pytest.raises(ValueError, match="16383 octets"):
        encode_bsm(LOWEST, regional=((1, bytes(16_383)),))
    with pytest.raises(ValueError, match=str(MAX_FRAME_OCTETS)):
        encode_bsm(LOWEST, frame_additions=(bytes(16_383),))


@pytest.mark.parametrize("message_id", [-1, 32768])
def test_a_message_id_beyond_15_bits_is_a_value_error(message_id: int) -> None:
    with pytest.raises(ValueError, match="message_id"):
        encode_frame(message_id, b"1")


def test_codes_out_of_range_and_unknown_names_are_value_errors() -> None:
    with pytest.raises(ValueError, match="codes must be 25"):
        BsmCore((0,))
    with pytest.raises(ValueError, match="message_count: code 128"):
        BsmCore((128, *LOWEST.codes[1:]))
    with pytest.raises(ValueError, match=r"no field is called \['speed'\]"):
        BsmCore.from_values({"speed": 1.0})


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"speed": 1}, "no field is called speed"),
        ({"speed_mps": "fast"}, "number or null"),
        ({"speed_mps": True}, "number or null"),
        ({"message_count": 10**400}, "message_count"),
        ({"part_ii": [{"id": 10**400, "octets": "00"}]}, "part_ii_id"),
        ({"speed_mps": {"code": 8192}}, "within 0..8191"),
        ({"speed_mps": {"code": 1.0}}, "within 0..8191"),
        ({"yaw_rate_radps": None}, "yaw_rate_radps"),
        ({"message_count": 1000}, "message_count"),
        ({"transmission": "drive"}, "transmission must be one of neutral"),
        ({"wheel_brakes": "left_front"}, "wheel_brakes must be a list"),
        ({"wheel_brakes": ["front"]}, "wheel_brakes may hold"),
        ({"wheel_brakes": [[]]}, "wheel_brakes may hold"),
        ({"temporary_id": "123"}, "8 hexadecimal digits"),
        ({"temporary_id": 5}, "8 hexadecimal digits"),
        ({"message": "spat"}, "message must be 'bsm'"),
        ({"part_ii": [{"id": 1}]}, "id and octets"),
        ({"part_ii": [7]}, "id and octets"),
        ({"part_ii": [{"id": 1, "octets": "xy"}]}, "hexadecimal"),
        ({"regional": {"id": 1}}, "regional must be a list"),
        ({"additions": ["zz"]}, "hexadecimal"),
    ],
)
def test_a_document_that_is_wrong_is_a_value_error(change: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        message_of(document_of(BasicSafetyMessage(LOWEST)) | change)


@pytest.mark.parametrize(("number", "code"), [(10**400, 8190), (-(10**400), 0), (float("inf"), 8190)])
def test_a_number_beyond_all_floats_takes_the_last_code(number: float, code: int) -> None:
    document = document_of(BasicSafetyMessage(LOWEST)) | {"speed_mps": number}
    assert message_of(document).core.codes[CORE_INDEX["speed_mps"]] == code


@pytest.mark.parametrize("document", [[], 7, "bsm", None])
def test_a_document_is_an_object(document: object) -> None:
    with pytest.raises(ValueError, match="an object with fields"):
        message_of(document)


def test_the_codec_does_what_the_functions_do() -> None:
    message = BasicSafetyMessage(HIGHEST, regional=((128, b"model"),))
    codec = BsmCodec()
    octets = codec.encode(message)
    assert octets == encode_bsm(HIGHEST, regional=((128, b"model"),))
    assert codec.decode(octets) == message


@given(
    st.lists(
        st.tuples(st.integers(0, 40), st.integers(0)).map(lambda p: (p[1] % (1 << p[0]), p[0])), max_size=9
    )
)
def test_bits_come_back_in_order(parts: list[tuple[int, int]]) -> None:
    writer = BitWriter()
    for value, width in parts:
        writer.bits(value, width)
    octets = writer.octets()
    reader = BitReader(octets)
    assert [reader.bits(width) for _, width in parts] == [value for value, _ in parts]
    reader.finish()
    assert reader.left == 0


def test_lengths_take_one_octet_below_128_and_two_below_16384() -> None:
    sizes = [0, 1, 127, 128, 16_383]
    encoded: list[bytes] = []
    for size in sizes:
        writer = BitWriter()
        writer.length(size)
        encoded.append(writer.octets())
        assert BitReader(encoded[-1]).length() == size
    assert [len(one) for one in encoded] == [1, 1, 1, 2, 2]
    assert all(one < other for one, other in pairwise(encoded))


def test_a_frame_of_another_message_is_read_without_knowing_it() -> None:
    frame = decode_frame(encode_frame(240, b"anything", (None, b"later")))
    assert frame == MessageFrame(240, b"anything", (None, b"later"))
    with pytest.raises(CodecError, match="message id 240"):
        decode_bsm(encode_frame(240, b"anything"))


def test_the_width_of_part_i_is_that_of_the_octets() -> None:
    octets = encode_bsm(LOWEST)[3:]
    assert len(octets) == math.ceil((3 + CORE_BITS) / 8)

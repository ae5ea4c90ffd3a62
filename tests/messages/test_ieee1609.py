"""Claims about IEEE 1609.2 data: recognised by name; unsecured ones are opened."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.foreign_heads import head_name, wsmp_octets
from modelcast.messages.ieee1609 import (
    content_name,
    encode_unsecured,
    is_ieee1609_data,
    read_unsecured_head,
    unsecured_payload,
)
from modelcast.messages.security.signed import SignedMessage, decode_signed
from modelcast.messages.security.time64 import LAST_US, microseconds


@given(st.binary(max_size=400) | st.integers(65_000, 66_000).map(bytes))
def test_what_was_written_is_read(payload: bytes) -> None:
    data = encode_unsecured(payload)
    assert unsecured_payload(data) == payload
    head = read_unsecured_head(data)
    assert head is not None
    assert head.shortest
    assert head.stop == len(data)


@pytest.mark.parametrize(
    ("count", "begins"),
    [(0, "038000"), (127, "03807f"), (128, "03808180"), (255, "038081ff"), (256, "0380820100")],
)
def test_lengths_take_the_form_of_canonical_oer(count: int, begins: str) -> None:
    assert encode_unsecured(bytes(count)).hex() == begins + "00" * count


@given(st.integers(0, LAST_US), st.binary(min_size=1, max_size=200), st.binary(min_size=8, max_size=8))
def test_signed_messages_are_signed_ieee_1609_data(generation_us: int, payload: bytes, digest: bytes) -> None:
    octets = SignedMessage(generation_us, payload, digest, bytes(64)).octets
    assert head_name(octets) == "a signed IEEE 1609.2 SPDU (03 81)"


@given(st.sampled_from([0x80, *range(0x82, 0xC0)]), st.binary(max_size=300))
def test_other_ieee_1609_data_are_no_signed_message(tag: int, rest: bytes) -> None:
    data = bytes([3, tag]) + rest
    assert is_ieee1609_data(data)
    with pytest.raises(CodecError):
        decode_signed(data)


def test_a_time_of_more_than_64_bits_is_refused() -> None:
    with pytest.raises(ValueError, match="must be from 0"):
        microseconds(LAST_US / 1e6)


@pytest.mark.parametrize(
    ("tag", "name"),
    [
        (0x80, "an unsecured IEEE 1609.2 SPDU (03 80)"),
        (0x81, "a signed IEEE 1609.2 SPDU (03 81)"),
        (0x82, "an encrypted IEEE 1609.2 SPDU (03 82)"),
        (0x83, "a certificate request in an IEEE 1609.2 SPDU (03 83)"),
        (0x9A, "an unknown content in an IEEE 1609.2 SPDU (03 9a)"),
    ],
)
def test_every_content_has_a_name(tag: int, name: str) -> None:
    assert content_name(bytes([3, tag])) == name
    assert head_name(bytes([3, tag, 0, 0])) == name


@pytest.mark.parametrize(
    ("digits", "told"),
    [
        ("0380", "without a length"),
        ("038083ffff", "without a length"),
        ("038085", "without a length"),
        ("03800500", "payload of 5 octets, and 1 are here: cut short"),
        ("0380010000", "1 octets left over"),
        ("0381004003", "a signed IEEE 1609.2 SPDU .03 81.: its content is not read"),
        ("0014", "no IEEE 1609.2 SPDU"),
    ],
)
def test_what_is_no_unsecured_spdu_is_refused_with_its_name(digits: str, told: str) -> None:
    with pytest.raises(CodecError, match=told):
        unsecured_payload(bytes.fromhex(digits))


@given(st.binary(max_size=100))
def test_any_octets_have_a_name_or_none(data: bytes) -> None:
    name = head_name(data)
    assert name is None or name.isprintable()


@pytest.mark.parametrize(
    ("digits", "octets"),
    [
        ("03002003abcdef", 4),
        ("0300808003abcdef", 5),
        ("0b0104010c002003abcdef", 8),
        ("0301200104010c03abcdef", 8),
        ("03002004abcdef", None),
        ("02002003abcdef", None),
        ("0300", None),
        ("", None),
    ],
    ids=[
        "plain",
        "psid of two octets",
        "elements",
        "transport elements",
        "length",
        "version",
        "cut",
        "empty",
    ],
)
def test_a_wsmp_header_is_known_by_its_length(digits: str, octets: int | None) -> None:
    assert wsmp_octets(bytes.fromhex(digits)) == octets

"""Claims about messages one after another in octets."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.mbc_wire import IdentificationMessage, encode_identification
from modelcast.messages.psm import PersonalSafetyMessage, encode_psm, person_codes
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import SignedMessage
from modelcast.messages.sequence import announced_octets, begins_a_message, is_message, parts_of


def core(count: int) -> BsmCore:
    return BsmCore.from_values({"message_count": count, "temporary_id": 1, "yaw_rate_radps": 0.0})


PLAIN = encode_bsm(core(1))
LONG = encode_bsm(core(2), regional=((200, bytes(range(200))),))
PERSON = encode_psm(PersonalSafetyMessage(person_codes({"message_count": 3, "temporary_id": 4})))
CERTIFICATE = Certificate(bytes(8), 5, duration_s=60, public_key=b"\2" + bytes(32), signature=bytes(64))
SIGNED = "a signed IEEE 1609.2 SPDU (03 81)"
BEHIND = "what a signed SPDU has behind its payload, not read and not verified"
WHOLE = {
    "plain": PLAIN,
    "long": LONG,
    "identification": encode_identification(IdentificationMessage(1, 7, sub_model=2, age=130)),
    "person": PERSON,
    "person, unsecured": encode_unsecured(PERSON),
    "signed": SignedMessage(5, PLAIN, CERTIFICATE.digest, bytes(64)).octets,
    "signed with a certificate": SignedMessage(5, LONG, CERTIFICATE, bytes(64)).octets,
    "unsecured": encode_unsecured(PLAIN),
    "unsecured, long": encode_unsecured(LONG),
}


@pytest.mark.parametrize("octets", WHOLE.values(), ids=WHOLE)
def test_the_head_of_a_message_tells_its_length(octets: bytes) -> None:
    assert announced_octets(octets) == len(octets)
    signed = octets[:2] == b"\3\x81"  # the length of a signer is known when it was read
    assert announced_octets(octets[:13]) == (None if signed else len(octets))
    assert is_message(octets)
    assert begins_a_message(octets)
    assert not is_message(octets + b"\0")
    assert not is_message(octets[:-1])


@given(st.lists(st.sampled_from(list(WHOLE.values())), min_size=1, max_size=6))
def test_messages_one_after_another_are_found(messages: list[bytes]) -> None:
    parts = parts_of(b"".join(messages))
    assert [part.octets for part in parts] == messages
    assert not any(part.fault for part in parts)


@given(
    st.lists(
        st.sampled_from(list(WHOLE.values())) | st.binary(max_size=30) | st.integers(1, 50).map(bytes),
        max_size=6,
    )
)
def test_parts_are_all_octets_in_order(pieces: list[bytes]) -> None:
    data = b"".join(pieces)
    parts = parts_of(data)
    assert b"".join(part.octets for part in parts) == data
    assert all(part.octets == data[part.start : part.start + len(part.octets)] for part in parts)


@given(st.binary(max_size=300))
def test_any_octets_have_parts(data: bytes) -> None:
    assert sum(len(part.octets) for part in parts_of(data)) == len(data)


@pytest.mark.parametrize(
    ("data", "faults"),
    [
        (PLAIN + b"\n", ["", "1 octet left over: 0a"]),
        (PLAIN + bytes(60), ["", "60 octets left over: zeros"]),
        (PLAIN + b"\r\n" + LONG, ["", "2 octets in front of the message at octet 42 not read: 0d0a", ""]),
        (PLAIN + LONG[:50], ["", "50 octets left over: the beginning of a message of 244 octets, cut short"]),
        (
            b"\x03\x00\x20\x2b" + encode_unsecured(PLAIN),
            ["4 octets in front of the message at octet 4 not read: a WSMP header, 0300202b", ""],
        ),
        (
            b"\x03\x81\x00\x40" + encode_unsecured(PLAIN) + b"\x40" * 3,
            [
                f"4 octets in front of the message at octet 4 not read: {SIGNED}, 03810040",
                "",
                f"3 octets left over: {BEHIND}, 404040",
            ],
        ),
        (PLAIN[:-1], [""]),
        (b"nothing of the kind", [""]),
    ],
    ids=["line end", "padding", "between", "cut", "wsmp", "signed", "cut alone", "foreign"],
)
def test_what_is_left_over_is_counted_and_shown(data: bytes, faults: list[str]) -> None:
    assert [part.fault for part in parts_of(data)] == faults


def test_a_frame_of_another_message_does_not_hide_the_next() -> None:
    other = bytes.fromhex("001305aabbccddee")
    assert [part.octets for part in parts_of(other + PLAIN)] == [other, PLAIN]

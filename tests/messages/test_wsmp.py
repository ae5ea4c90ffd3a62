"""Claims about the WAVE short message."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.wsmp import MAX_WSM_OCTETS, ShortMessage, decode_wsm, encode_wsm, wsmp_octets


@given(st.binary(max_size=MAX_WSM_OCTETS - 5))
def test_what_was_written_is_read(payload: bytes) -> None:
    octets = encode_wsm(payload)
    assert decode_wsm(octets) == ShortMessage(0x20, payload)
    assert len(octets) - len(payload) == (4 if len(payload) < 128 else 5)
    assert wsmp_octets(octets) == len(octets) - len(payload)


@given(st.binary(max_size=2400))
def test_any_octets_are_a_short_message_or_refused(data: bytes) -> None:
    try:
        message = decode_wsm(data)
    except CodecError:
        return
    assert data.endswith(message.payload)


@pytest.mark.parametrize(
    ("digits", "psid"),
    [
        ("03002003616263", 0x20),
        ("0b0104010c002003616263", 0x20),  # a data rate in the network header
        ("0b020f01ac10010c002003616263", 0x20),  # channel and data rate
        ("0301200104010003616263", 0x20),  # an element in the transport header
        ("0300800103616263", 0x8001),  # a PSID of two octets
    ],
)
def test_extensions_are_skipped(digits: str, psid: int) -> None:
    assert decode_wsm(bytes.fromhex(digits)) == ShortMessage(psid, b"abc")


@pytest.mark.parametrize(
    ("digits", "told"),
    [
        ("", "no short message"),
        ("02002000", "no short message"),
        ("03022000", "no short message"),
        ("0b21" + "040100" * 33 + "002000", "no short message"),
        ("03002004616263", "payload of 4 octets, and 3"),
        ("0300200261626300", "2 octets left over"),
        ("030020" + "00" * 2302, "more than 2304"),
    ],
)
def test_others_are_refused(digits: str, told: str) -> None:
    with pytest.raises(CodecError, match=told):
        decode_wsm(bytes.fromhex(digits))


def test_a_message_too_long_for_a_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="2304"):
        encode_wsm(bytes(MAX_WSM_OCTETS - 4))

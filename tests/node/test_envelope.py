"""Claims about what goes round a node's messages."""

import contextlib
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.ieee1609 import encode_unsecured, unsecured_payload
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.p256 import PrivateKey
from modelcast.messages.security.signer import Signer, SignerState
from modelcast.messages.wsmp import MAX_WSM_OCTETS, decode_wsm, encode_wsm
from modelcast.node.envelope import Bare, Opened, Unsecured


@given(st.binary(min_size=1, max_size=MAX_WSM_OCTETS - 20))
def test_what_is_wrapped_is_opened_again(octets: bytes) -> None:
    for envelope in (Bare(), Unsecured()):
        frame = envelope.wrap(octets, sent_s=1.0)
        assert envelope.open(frame, received_s=1.01) == Opened(octets, "accepted")


def test_a_frame_is_as_the_wire_page_has_it() -> None:
    assert Unsecured().wrap(b"\xaa\xbb", sent_s=0.0).hex() == "03002005" + "038002" + "aabb"


@given(st.binary(max_size=300))
def test_whatever_arrives_is_opened_or_refused(frame: bytes) -> None:
    found = Unsecured().open(frame, received_s=0.0)
    assert (found.octets is None) == (found.why not in {"accepted", "not verified"})


@pytest.mark.parametrize(
    ("frame", "why"),
    [
        (b"", "no short message"),
        (bytes.fromhex("0380020014"), "no short message"),
        (bytes.fromhex("03002105038002aabb"), "another application"),
        (encode_wsm(b"\x00\x14"), "no data of IEEE 1609.2"),
        (encode_wsm(encode_unsecured(b"abc")[:-1]), "no data of IEEE 1609.2"),
        (encode_wsm(encode_unsecured(b"abc")) + b"x", "no short message"),
    ],
)
def test_what_is_no_message_of_ours_is_refused_with_why(frame: bytes, why: str) -> None:
    assert Unsecured().open(frame, received_s=0.0) == Opened(None, why)


def test_what_others_sign_is_opened_and_said_to_be_unverified() -> None:
    root = Authority.create(PrivateKey.from_random(os.urandom(48)), start_s=0, duration_s=36_000)
    key = PrivateKey.from_random(os.urandom(48))
    signer = Signer(key, root.issue(key.public_octets, start_s=0, duration_s=3600))
    signed, _ = signer.sign(SignerState(), b"payload", t_s=10.0)
    assert Unsecured().open(encode_wsm(signed), received_s=0.0) == Opened(b"payload", "not verified")


@given(st.binary(min_size=1, max_size=MAX_WSM_OCTETS - 20), st.data())
def test_a_head_with_another_octet_is_not_taken_for_ours(octets: bytes, data: st.DataObject) -> None:
    frame = bytearray(Unsecured().wrap(octets, sent_s=0.0))
    at = data.draw(st.integers(0, len(frame) - len(octets) - 1))
    frame[at] ^= data.draw(st.integers(1, 255))
    found = Unsecured().open(bytes(frame), received_s=0.0)
    with contextlib.suppress(CodecError):
        message = decode_wsm(bytes(frame))  # whatever is let in is what the wire's own reader reads
        if found.why == "accepted":
            assert (message.psid, unsecured_payload(message.payload)) == (0x20, found.octets)
            return
    assert found.why != "accepted"

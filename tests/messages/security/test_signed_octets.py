"""Claims about signed messages as octets: nothing here is verified, and no library takes part."""

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.security.certificate import CERTIFICATE_OCTETS, Certificate
from modelcast.messages.security.signed import (
    CERTIFICATE_OVERHEAD_BYTES,
    DIGEST_OVERHEAD_BYTES,
    SignedMessage,
    decode_signed,
)

CERTIFICATE = Certificate(
    bytes(range(8)), 0x01020304, duration_s=3600, public_key=b"\x02" + bytes(32), signature=b"\x55" * 64
)

certificates = st.builds(
    Certificate,
    st.binary(min_size=8, max_size=8),
    st.integers(0, 2**32 - 1),
    duration_s=st.integers(0, 2**32 - 1),
    public_key=st.binary(min_size=32, max_size=32).flatmap(
        lambda x: st.sampled_from([b"\x02" + x, b"\x03" + x])
    ),
    signature=st.binary(min_size=64, max_size=64),
)
messages = st.builds(
    SignedMessage,
    st.integers(0, 2**63 - 1),
    st.binary(min_size=1, max_size=300),
    signer=st.binary(min_size=8, max_size=8) | certificates,
    signature=st.binary(min_size=64, max_size=64),
)


@given(messages)
def test_what_was_written_is_read(message: SignedMessage) -> None:
    assert decode_signed(message.octets) == message
    more = len(message.payload) > 127
    overhead = DIGEST_OVERHEAD_BYTES if isinstance(message.signer, bytes) else CERTIFICATE_OVERHEAD_BYTES
    assert len(message.octets) == len(message.payload) + overhead + more


@given(st.binary(max_size=300) | messages.map(lambda message: message.octets), st.data())
def test_any_octets_are_a_message_or_refused(octets: bytes, data: st.DataObject) -> None:
    bent = bytearray(octets)
    for _ in range(data.draw(st.integers(0, 3))):
        if bent:
            bent[data.draw(st.integers(0, len(bent) - 1))] = data.draw(st.integers(0, 255))
    received = bytes(bent[: data.draw(st.integers(0, len(bent)))] if data.draw(st.booleans()) else bent)
    try:
        message = decode_signed(received)
    except CodecError as error:
        refusal = error
    else:
        assert message.octets == received
        return
    assert 0 <= refusal.offset_bits <= 8 * len(received)


def test_golden_octets_with_a_digest() -> None:
    message = SignedMessage(0x0102030405060708, b"pay", signer=b"12345678", signature=b"\xaa" * 64)
    assert message.octets.hex() == "02" + "0102030405060708" + "03706179" + "3132333435363738" + "aa" * 64
    assert DIGEST_OVERHEAD_BYTES == 82


def test_golden_octets_with_a_certificate() -> None:
    octets = SignedMessage(1, b"p", signer=CERTIFICATE, signature=b"\xaa" * 64).octets
    signer = "0001020304050607" + "01020304" + "00000e10" + "02" + "00" * 32 + "55" * 64
    assert octets.hex() == "03" + "0000000000000001" + "0170" + signer + "aa" * 64
    assert (CERTIFICATE_OCTETS, CERTIFICATE_OVERHEAD_BYTES) == (113, 187)


WHOLE = SignedMessage(1, b"payload", signer=CERTIFICATE, signature=bytes(64)).octets

REFUSED = {
    "nothing": (b"", 0),
    "another format": (b"\x04" + WHOLE[1:], 0),
    "no payload": (WHOLE[:9] + b"\0" + WHOLE[17:], 72),
    "length too long a form": (WHOLE[:9] + b"\x80\x07" + WHOLE[10:], 72),
    "fragmented": (WHOLE[:9] + b"\xc1" + WHOLE[10:], 72),
    "cut in the certificate": (WHOLE[:40], 136),
    "key not compressed": (WHOLE[:33] + b"\x04" + WHOLE[34:], 264),
    "cut in the signature": (WHOLE[:-1], 1040),
    "left over": (WHOLE + b"\0", 8 * len(WHOLE)),
}


@pytest.mark.parametrize(("octets", "offset_bits"), REFUSED.values(), ids=REFUSED.keys())
def test_the_fault_is_named_with_its_bit(octets: bytes, offset_bits: int) -> None:
    with pytest.raises(CodecError) as refusal:
        decode_signed(octets)
    assert refusal.value.offset_bits == offset_bits


def test_a_certificate_of_another_length_is_refused() -> None:
    with pytest.raises(CodecError, match="112 octets"):
        Certificate.from_octets(CERTIFICATE.octets[1:])


def test_a_certificate_is_good_from_its_start_to_before_its_end() -> None:
    start = CERTIFICATE.start_s
    assert [CERTIFICATE.is_good_at(start + x) for x in (-1e-6, 0, 3599.9, 3600)] == [False, True, True, False]


@pytest.mark.parametrize(
    "changed",
    [
        {"issuer": b"short"},
        {"start_s": -1},
        {"duration_s": 2**32},
        {"public_key": bytes(33)},
        {"signature": b""},
    ],
    ids=str,
)
def test_impossible_certificates_are_refused(changed: dict[str, object]) -> None:
    whole: dict[str, object] = {
        "issuer": bytes(8),
        "start_s": 0,
        "duration_s": 1,
        "public_key": b"\2" + bytes(32),
        "signature": bytes(64),
    }
    with pytest.raises(ValueError, match=next(iter(changed))):
        Certificate(**{**whole, **changed})  # type: ignore[arg-type] - what is tested


@pytest.mark.parametrize(
    "parts",
    [
        (-1, b"p", bytes(8), bytes(64)),
        (2**63, b"p", bytes(8), bytes(64)),
        (0, b"", bytes(8), bytes(64)),
        (0, bytes(16384), bytes(8), bytes(64)),
        (0, b"p", bytes(7), bytes(64)),
        (0, b"p", bytes(8), bytes(63)),
    ],
    ids=["before", "beyond", "empty", "long", "digest", "signature"],
)
def test_impossible_messages_are_refused(parts: tuple[int, bytes, bytes, bytes]) -> None:
    with pytest.raises(ValueError, match="must"):
        SignedMessage(*parts)


def test_reading_needs_no_library() -> None:
    """Hostile octets meet plain code first: what is fuzzed is what reads."""
    script = (
        "import sys, modelcast.messages.security.signed; print(*{'cryptography', 'numpy'} & set(sys.modules))"
    )
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert ended.stdout.strip() == ""

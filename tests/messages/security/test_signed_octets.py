"""Claims about signed messages as octets: nothing here is verified, and no library takes part."""

import subprocess
import sys
from functools import cache
from importlib import resources
from typing import Any, get_args

import asn1tools
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pycrate_asn1dir import ITS_IEEE1609_2

from modelcast.core.exceptions import CodecError
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.security.certificate import Certificate, DurationUnit
from modelcast.messages.security.signed import MAX_SPDU_OCTETS, SignedMessage, decode_signed, signed_octets

CERTIFICATE = Certificate(
    bytes(range(8)), 0x01020304, duration_s=3600, public_key=b"\x02" + bytes(32), signature=b"\x55" * 64
)
UNITS_S = dict(zip(get_args(DurationUnit), (1, 60, 3600, 216_000, 31_556_952), strict=True))


@cache
def ours() -> Any:
    """Codec of our own module."""
    return asn1tools.compile_string(
        resources.files("modelcast.messages.security").joinpath("ieee1609dot2.asn").read_text("ascii"), "oer"
    )


JUDGE: Any = ITS_IEEE1609_2.Ieee1609Dot2.Ieee1609Dot2Data

octets64 = st.binary(min_size=64, max_size=64)
r_tags = st.sampled_from([0x80, 0x82, 0x83])
points = st.tuples(st.sampled_from([b"\2", b"\3"]), st.binary(min_size=32, max_size=32)).map(b"".join)
psids = st.integers(0, 2**32 - 1)
durations = st.tuples(st.sampled_from(list(UNITS_S)), st.integers(0, 65535))
certificates = durations.flatmap(
    lambda duration: st.builds(
        Certificate,
        st.just(b"") | st.binary(min_size=8, max_size=8),
        st.integers(0, 2**32 - 1),
        duration_s=st.just(duration[1] * UNITS_S[duration[0]]),
        duration_unit=st.just(duration[0]),
        public_key=points,
        signature=octets64,
        psids=st.lists(psids, max_size=16).map(tuple),
        name=st.none() | st.text(st.characters(codec="utf-8"), max_size=60),
        craca_id=st.binary(min_size=3, max_size=3),
        crl_series=st.integers(0, 65535),
        r_tag=r_tags,
    )
)
messages = st.builds(
    SignedMessage,
    st.integers(0, 2**64 - 1),
    st.binary(min_size=1, max_size=300),
    signer=st.binary(min_size=8, max_size=8) | certificates,
    signature=octets64,
    psid=psids,
    r_tag=r_tags,
)


def point(tag: int, x: bytes) -> tuple[str, bytes]:
    return {0x80: "x-only", 0x82: "compressed-y-0", 0x83: "compressed-y-1"}[tag], x


def signature_value(signature: bytes, r_tag: int) -> tuple[str, dict[str, Any]]:
    return "ecdsaNistP256Signature", {"rSig": point(r_tag, signature[:32]), "sSig": signature[32:]}


def certificate_value(one: Certificate, *, null: object, defaults: dict[str, object]) -> dict[str, Any]:
    contents: dict[str, Any] = {
        "id": ("none", null) if one.name is None else ("name", one.name),
        "cracaId": one.craca_id,
        "crlSeries": one.crl_series,
        "validityPeriod": {
            "start": one.start_s,
            "duration": (one.duration_unit, one.duration_s // UNITS_S[one.duration_unit]),
        },
        "verifyKeyIndicator": (
            "verificationKey",
            ("ecdsaNistP256", point(0x80 + one.public_key[0], one.public_key[1:])),
        ),
    }
    if one.psids:
        contents["appPermissions"] = [{"psid": psid} for psid in one.psids]
    else:
        contents["certIssuePermissions"] = [{"subjectPermissions": ("all", null), **defaults}]
    return {
        "version": 3,
        "type": "explicit",
        "issuer": ("sha256AndDigest", one.issuer) if one.issuer else ("self", "sha256"),
        "toBeSigned": contents,
        "signature": signature_value(one.signature, one.r_tag),
    }


def message_value(message: SignedMessage, *, null: object, defaults: dict[str, object]) -> dict[str, Any]:
    signer = message.signer
    unsecured = {"protocolVersion": 3, "content": ("unsecuredData", message.payload)}
    signed = {
        "hashId": "sha256",
        "tbsData": {
            "payload": {"data": unsecured},
            "headerInfo": {"psid": message.psid, "generationTime": message.generation_us},
        },
        "signer": ("digest", signer)
        if isinstance(signer, bytes)
        else ("certificate", [certificate_value(signer, null=null, defaults=defaults)]),
        "signature": signature_value(message.signature, message.r_tag),
    }
    return {"protocolVersion": 3, "content": ("signedData", signed)}


@given(messages)
def test_what_was_written_is_read(message: SignedMessage) -> None:
    assert decode_signed(message.octets) == message
    assert signed_octets(message.octets + b"more") == len(message.octets)


@given(messages)
def test_another_implementation_of_the_standard_writes_the_same_octets(message: SignedMessage) -> None:
    """pycrate, from the published module: it encodes our values to our octets and reads ours."""
    JUDGE.set_val(message_value(message, null=0, defaults={}))
    assert JUDGE.to_coer() == message.octets
    JUDGE.from_coer(message.octets)
    content = JUDGE.get_val()["content"][1]
    assert content["tbsData"]["headerInfo"] == {"psid": message.psid, "generationTime": message.generation_us}
    assert content["tbsData"]["payload"]["data"]["content"] == ("unsecuredData", message.payload)
    assert JUDGE.to_coer() == message.octets


@given(messages)
def test_our_own_module_describes_the_octets(message: SignedMessage) -> None:
    given = message_value(message, null=None, defaults={})
    assert ours().encode("Ieee1609Dot2Data", given) == message.octets


@given(st.binary(max_size=500))
def test_unsecured_data_are_what_the_module_says(payload: bytes) -> None:
    given = {"protocolVersion": 3, "content": ("unsecuredData", payload)}
    assert ours().encode("Ieee1609Dot2Data", given) == encode_unsecured(payload)


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
    assert message.octets.hex() == (
        "038100" + "40038003706179" + "4001200102030405060708" + "803132333435363738" + "8080" + "aa" * 64
    )
    assert len(message.octets) - 3 == 93


def test_golden_octets_with_a_certificate() -> None:
    octets = SignedMessage(1, b"p", signer=CERTIFICATE, signature=b"\xaa" * 64).octets
    certificate = "800300" + "800001020304050607" + "1083000000" + "0000" + "01020304" + "820e10"
    certificate += "0101000120" + "808082" + "00" * 32 + "8080" + "55" * 64
    assert octets.hex() == (
        "038100" + "4003800170" + "4001200000000000000001" + "810101" + certificate + "8080" + "aa" * 64
    )
    assert len(octets) - 1 == 219


WHOLE = SignedMessage(1, b"payload", signer=CERTIFICATE, signature=bytes(64)).octets

REFUSED = {
    "nothing": (b"", 0),
    "another version": (b"\x04" + WHOLE[1:], 0),
    "another hash": (WHOLE[:2] + b"\1" + WHOLE[3:], 16),
    "no payload": (WHOLE[:6] + b"\0" + WHOLE[14:], 48),
    "length too long a form": (WHOLE[:6] + b"\x81\x07" + WHOLE[7:], 48),
    "cut in the certificate": (WHOLE[:40], 320),
    "left over": (WHOLE + b"\0", 8 * len(WHOLE)),
    "too long": (WHOLE + bytes(MAX_SPDU_OCTETS), 8 * MAX_SPDU_OCTETS),
}


@pytest.mark.parametrize(("octets", "offset_bits"), REFUSED.values(), ids=REFUSED.keys())
def test_the_fault_is_named_with_its_bit(octets: bytes, offset_bits: int) -> None:
    with pytest.raises(CodecError) as refusal:
        decode_signed(octets)
    assert refusal.value.offset_bits == offset_bits


def test_the_digest_does_not_depend_on_the_form_of_r() -> None:
    """IEEE Std 1609.2-2016 6.4.3: hashed in canonical form."""
    parts = {name: getattr(CERTIFICATE, name) for name in ("duration_s", "public_key", "signature")}
    other = Certificate(CERTIFICATE.issuer, CERTIFICATE.start_s, **parts, r_tag=0x83)
    assert other.octets != CERTIFICATE.octets
    assert other.digest == CERTIFICATE.digest


def test_a_certificate_cut_short_is_refused() -> None:
    with pytest.raises(CodecError, match="64 octets needed"):
        Certificate.from_octets(CERTIFICATE.octets[:-1])


def test_a_certificate_is_good_from_its_start_to_before_its_end() -> None:
    start = CERTIFICATE.start_s
    assert [CERTIFICATE.is_good_at(start + x) for x in (-1e-6, 0, 3599.9, 3600)] == [False, True, True, False]


@pytest.mark.parametrize(
    "changed",
    [
        {"issuer": b"short"},
        {"start_s": -1},
        {"duration_s": 65536},
        {"duration_s": 61, "duration_unit": "minutes"},
        {"duration_unit": "days"},
        {"public_key": bytes(33)},
        {"signature": b""},
        {"psids": (0,) * 17},
        {"psids": (-1,)},
        {"name": "n" * 256},
        {"craca_id": b""},
        {"crl_series": 65536},
        {"r_tag": 0x84},
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
        (2**64, b"p", bytes(8), bytes(64)),
        (0, b"", bytes(8), bytes(64)),
        (0, bytes(2305), bytes(8), bytes(64)),
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

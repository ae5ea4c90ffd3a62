"""Claims about ``docs/wire.md``: a decoder written from it agrees, its vectors are what is sent."""

import json
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.utils import encode_dss_signature
from cryptography.hazmat.primitives.hashes import SHA256
from hypothesis import given
from hypothesis import strategies as st

from modelcast.messages.bsm import decode_bsm
from modelcast.messages.psm import decode_psm
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.verifier import Outcome, Verifier, VerifierState
from modelcast.messages.wsmp import decode_wsm

ROOT = Path(__file__).parents[2]
DECODER = runpy.run_path(str(ROOT / "tests" / "wire_decoder.py"))
WHOLE: dict[str, Any] = json.loads((ROOT / "docs" / "wire-vectors.json").read_text("ascii"))
VECTORS = {one["name"]: one for one in WHOLE["vectors"]}
SIGNED = [one for name, one in VECTORS.items() if "signed, " in name]


def script(*arguments: str) -> subprocess.CompletedProcess[str]:
    path = str(ROOT / "validation" / "wire_vectors.py")
    return subprocess.run(  # noqa: S603 - our own script
        [sys.executable, path, *arguments], capture_output=True, text=True, check=False
    )


def test_the_page_and_its_vectors_are_what_their_script_writes() -> None:
    assert script("--check").returncode == 0


def test_the_decoder_from_the_page_agrees_on_random_messages() -> None:
    """A million: ``python validation/wire_vectors.py --agree 1000000``."""
    assert script("--agree", "3000").stdout == "3000 messages, 0 read otherwise\n"


def test_the_decoder_imports_nothing_of_modelcast() -> None:
    assert "import modelcast" not in (text := (ROOT / "tests" / "wire_decoder.py").read_text("utf-8"))
    assert "from modelcast" not in text


@pytest.mark.parametrize("one", VECTORS.values(), ids=VECTORS)
def test_a_vector_holds_its_frame(one: dict[str, Any]) -> None:
    found = DECODER["read"](bytes.fromhex(one["short_message"]))
    person = one.get("person_codes")
    assert found["psid"] == (0x20 if person is None else 0x27)
    assert found["data"].get("generation_us") == one["generation_us"]
    if person is not None:
        assert found["data"]["frame"]["person_codes"] == person
        assert list(decode_psm(bytes.fromhex(one["frame"])).codes) == person
    elif one["part_i_codes"] is not None:
        assert found["data"]["frame"]["codes"] == one["part_i_codes"]
        assert list(decode_bsm(bytes.fromhex(one["frame"])).core.codes) == one["part_i_codes"]
    else:
        assert found["data"]["frame"] == {
            "temporary_id": 0x01020304,
            "sequence": 7,
            "sub_model": 2,
            "age": 130,
        }


@pytest.mark.parametrize("one", SIGNED, ids=lambda one: one["name"])
def test_the_signature_of_a_vector_follows_the_rule_of_the_page(one: dict[str, Any]) -> None:
    """With the page's hash and a library alone; then by our receiver."""
    octets_of = DECODER["Octets"]
    sender = DECODER["certificate"](octets_of(bytes.fromhex(WHOLE["sender"]["certificate"])))
    authority = DECODER["certificate"](octets_of(bytes.fromhex(WHOLE["authority"]["certificate"])))
    data = DECODER["read"](bytes.fromhex(one["short_message"]))["data"]
    for signed, by, canonical in (
        (data, sender, sender["canonical"]),
        (sender, authority, authority["canonical"]),
        (authority, authority, b""),
    ):
        key = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), by["key"])
        r, s = (int.from_bytes(half, "big") for half in (signed["signature"][:32], signed["signature"][32:]))
        content = DECODER["to_be_verified"](signed["to_be_signed"], canonical)
        key.verify(encode_dss_signature(r, s), content, ec.ECDSA(SHA256()))
    assert sender["issuer"] == authority["digest"]
    assert sender["digest"].hex() == WHOLE["sender"]["digest"]
    if data["signer"] != sender["digest"]:
        assert data["signer"] == sender
        verifier = Verifier((Certificate.from_octets(bytes.fromhex(WHOLE["authority"]["certificate"])),))
        payload = decode_wsm(bytes.fromhex(one["short_message"])).payload
        verified = verifier.verify(VerifierState(), payload, t_s=one["generation_us"] / 1e6)
        assert verified.outcome is Outcome.ACCEPTED


@given(st.sampled_from(list(VECTORS.values())), st.data())
def test_bent_octets_are_read_or_refused(one: dict[str, Any], data: st.DataObject) -> None:
    octets = bytearray.fromhex(one["short_message"])
    octets[data.draw(st.integers(0, len(octets) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        DECODER["read"](bytes(octets))
    except ValueError:
        return

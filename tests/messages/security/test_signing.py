"""Claims about signing and verifying: what is accepted, and why anything else is not."""

import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.p256 import PrivateKey, PublicKey
from modelcast.messages.security.parameters import SecurityParameters
from modelcast.messages.security.replay import ReplayWindow
from modelcast.messages.security.signed import decode_signed, signed_part
from modelcast.messages.security.signer import Signer, SignerState
from modelcast.messages.security.verifier import Outcome, Verification, Verifier, VerifierState

ORDER = 0xFFFFFFFF00000000FFFFFFFFFFFFFFFFBCE6FAADA7179E84F3B9CAC2FC632551
ROOT = Authority.create(PrivateKey(11), start_s=0, duration_s=10_000)
KEY = PrivateKey(12)
SIGNER = Signer(KEY, ROOT.issue(KEY.public_octets, start_s=100, duration_s=900))
VERIFIER = Verifier((ROOT.certificate,))


def sent(
    t_s: float = 200.0, payload: bytes = b"payload", *, known: bool = False, signer: Signer = SIGNER
) -> bytes:
    """A signed message, with the digest where the receiver is taken to know the certificate."""
    state = SignerState(round(t_s * 1e6) if known else None)
    return signer.sign(state, payload, t_s=t_s)[0]


def verified(
    *octets: bytes, t_s: float = 200.0, verifier: Verifier = VERIFIER
) -> tuple[Verification, VerifierState]:
    """The last verification and the state after messages that arrive at once."""
    state = VerifierState()
    for one in octets:
        verification = verifier.verify(state, one, t_s=t_s)
    return verification, state


def copied(state: VerifierState) -> tuple[object, ...]:
    """What a state holds, to compare later."""
    return dict(state.store.senders), dict(state.windows), state.floor_us


def test_it_signs_as_rfc_6979_says() -> None:
    """Appendix A.2.5, P-256, SHA-256: message ``sample``; the octets of the signature, and the key."""
    key = PrivateKey(0xC9AFA9D845BA75166B5C215767B1D6934E50C3DB36E89B127B8A622B120F6721)
    assert (
        key.public_octets.hex() == "03" + "60fed4ba255a9d31c961eb74c6356d68c049b8923b61fa6ce669622e60f29fb6"
    )
    signature = "efd48b2aacb6a8fd1140dd9cd45e81d69d2c877b56aaf991c34d0ea84eaf3716"
    signature += "f7cb1c942d657c41d436c7a1b6e29f65f3e900dbb9aff4064dc4ab2f843acda8"
    assert key.sign(b"sample").hex() == signature
    assert PublicKey(key.public_octets).verifies(b"sample", bytes.fromhex(signature))


def test_what_was_signed_is_accepted() -> None:
    verification, state = verified(sent())
    assert verification == Verification(
        Outcome.ACCEPTED, SIGNER.certificate.digest, generation_s=200.0, payload=b"payload"
    )
    again = VERIFIER.verify(state, sent(200.1, known=True), t_s=200.1)
    assert (again.outcome, again.payload) == (Outcome.ACCEPTED, b"payload")


def test_digest_and_certificate_have_one_signature() -> None:
    assert sent()[-64:] == sent(known=True)[-64:]
    assert len(sent()) - len(sent(known=True)) == 126


def test_the_certificate_goes_along_when_more_than_450_ms_passed_since_it_last_did() -> None:
    state, attached = SignerState(), []
    for tenth in range(2000, 2013):
        octets, state = SIGNER.sign(state, b"p", t_s=tenth / 10)
        if isinstance(decode_signed(octets).signer, Certificate):
            attached.append(tenth - 2000)
    assert attached == [0, 5, 10]
    for later_us, due in ((450_000, False), (450_001, True)):
        octets, _ = SIGNER.sign(SignerState(200_000_000), b"p", t_s=(200_000_000 + later_us) / 1e6)
        assert isinstance(decode_signed(octets).signer, Certificate) is due


@pytest.mark.parametrize(
    ("t_s", "outcome"),
    [
        (199.89, Outcome.IN_FUTURE),
        (199.9, Outcome.ACCEPTED),
        (202.0, Outcome.ACCEPTED),
        (202.01, Outcome.TOO_OLD),
    ],
)
def test_a_generation_time_outside_the_tolerance_is_refused(t_s: float, outcome: Outcome) -> None:
    verification, _ = verified(sent(), t_s=t_s)
    assert verification.outcome is outcome
    assert (verification.payload is None) is (outcome is not Outcome.ACCEPTED)


def test_a_digest_of_an_unknown_certificate_is_refused() -> None:
    assert verified(sent(known=True))[0].outcome is Outcome.UNKNOWN_CERTIFICATE


def test_a_certificate_of_nobody_trusted_is_refused() -> None:
    stranger = Authority.create(PrivateKey(99), start_s=0, duration_s=10_000)
    for certificate in (
        stranger.issue(KEY.public_octets, start_s=100, duration_s=900),
        replace(SIGNER.certificate, duration_s=9000),  # issued, then altered
        replace(stranger.certificate, public_key=KEY.public_octets),
    ):
        octets = sent(signer=Signer(KEY, certificate))
        assert verified(octets)[0].outcome is Outcome.UNTRUSTED_CERTIFICATE


def test_a_sender_cannot_issue_certificates() -> None:
    own = Authority(KEY, SIGNER.certificate)
    other = PrivateKey(13)
    forged = Signer(other, own.issue(other.public_octets, start_s=100, duration_s=900))
    assert verified(sent(), sent(signer=forged))[0].outcome is Outcome.UNTRUSTED_CERTIFICATE


def test_a_key_that_is_no_point_of_the_curve_is_refused_whoever_vouches_for_it() -> None:
    for no_point in (b"\x02" + b"\xff" * 32, b"\x02" + bytes(31) + b"\1"):  # beyond the field; no square root
        octets = bytearray(sent())
        issued = ROOT.issue(no_point, start_s=100, duration_s=900).octets
        begin = octets.index(SIGNER.certificate.octets)
        octets[begin : begin + len(issued)] = issued
        assert verified(bytes(octets))[0].outcome is Outcome.UNTRUSTED_CERTIFICATE
        with pytest.raises(ValueError, match="point of P-256"):
            PublicKey(no_point)


def test_an_expired_certificate_is_refused_even_if_it_was_good_when_signed() -> None:
    octets = sent(999.9)
    assert verified(octets, t_s=999.95)[0].outcome is Outcome.ACCEPTED
    assert verified(octets, t_s=1000.0)[0].outcome is Outcome.EXPIRED


def test_an_expired_authority_vouches_for_nobody() -> None:
    short = Authority.create(PrivateKey(11), start_s=0, duration_s=150)
    certificate = replace(SIGNER.certificate, issuer=short.certificate.digest)
    certificate = replace(certificate, signature=short.key.sign(certificate.signed_part(short.certificate)))
    octets = sent(signer=Signer(KEY, certificate))
    assert verified(octets, verifier=Verifier((short.certificate,)))[0].outcome is Outcome.EXPIRED


@given(st.integers(0, len(sent(known=True)) - 1), st.integers(1, 255))
def test_any_octet_changed_is_refused(at: int, change: int) -> None:
    """But for one: whether r is told with a sign or without is not signed, and changes nothing that is."""
    _, state = verified(sent(199.0), t_s=199.5)
    octets = bytearray(sent(199.5, known=True))
    octets[at] ^= change
    if at == len(octets) - 65 and octets[at] in (0x82, 0x83):
        assert replace(decode_signed(bytes(octets)), r_tag=0x80).octets == sent(199.5, known=True)
        return
    try:
        held = copied(state)
        verification = VERIFIER.verify(state, bytes(octets), t_s=199.5)
    except CodecError:
        return
    assert verification.outcome is not Outcome.ACCEPTED
    assert copied(state) == held


def test_no_number_is_a_signature() -> None:
    octets = sent()
    for forged in (bytes(64), b"\xff" * 64, bytes(63) + b"\1"):
        assert verified(octets[:-64] + forged)[0].outcome is Outcome.BAD_SIGNATURE


def test_a_replayed_message_is_refused() -> None:
    octets = sent()
    assert verified(octets, octets)[0].outcome is Outcome.REPLAYED
    assert verified(octets, sent(known=True))[0].outcome is Outcome.REPLAYED


def test_a_second_signature_of_the_same_message_is_a_replay() -> None:
    """(r, n - s) verifies as well as (r, s): the window must not go by the signature."""
    octets = sent()
    s = int.from_bytes(octets[-32:], "big")
    twin = octets[:-32] + (ORDER - s).to_bytes(32, "big")
    assert verified(twin)[0].outcome is Outcome.ACCEPTED
    assert verified(octets, twin)[0].outcome is Outcome.REPLAYED


def test_two_messages_of_one_instant_are_both_accepted() -> None:
    assert verified(sent(), sent(payload=b"other"))[0].outcome is Outcome.ACCEPTED


def test_a_late_message_that_was_not_seen_is_accepted() -> None:
    assert verified(sent(199.5), sent(199.4))[0].outcome is Outcome.ACCEPTED


@given(st.lists(st.integers(0, 12), max_size=60), st.integers(1, 5))
def test_no_message_is_admitted_twice_in_whatever_order(times: list[int], limit: int) -> None:
    window, admitted = ReplayWindow(), []
    for generation_us in times:
        if not window.holds(generation_us, b"content"):
            window = window.admit(generation_us, b"content", limit)
            admitted.append(generation_us)
        assert len(window.seen) <= limit
    assert len(admitted) == len(set(admitted))
    assert not admitted or window.newest_us == max(admitted)


def test_what_is_refused_leaves_the_state_alone() -> None:
    _, state = verified(sent())
    for octets in (sent(), sent(150.0), sent(payload=b"other")[:-1] + b"\0"):
        held = copied(state)
        verification = VERIFIER.verify(state, octets, t_s=200.0)
        assert verification.outcome is not Outcome.ACCEPTED
        assert copied(state) == held


def test_memory_is_bounded() -> None:
    verifier = Verifier((ROOT.certificate,), SecurityParameters(certificates=3, remembered=4))
    state = VerifierState()
    for sender in range(20, 26):
        key = PrivateKey(sender)
        signer = Signer(key, ROOT.issue(key.public_octets, start_s=100, duration_s=900))
        for step in range(6):
            octets = sent(200 + sender + step / 10, signer=signer)
            verification = verifier.verify(state, octets, t_s=200 + sender + step / 10)
            assert verification.outcome is Outcome.ACCEPTED
    assert len(state.store.senders) == 3
    assert len(state.windows) <= 3
    assert all(len(window.seen) == 4 for window in state.windows.values())


def test_expired_certificates_leave_the_store() -> None:
    key = PrivateKey(30)
    late = Signer(key, ROOT.issue(key.public_octets, start_s=900, duration_s=900))
    _, state = verified(sent(999.0), t_s=999.0)
    VERIFIER.verify(state, sent(1001.0, signer=late), t_s=1001.0)
    assert list(state.store.senders) == [late.certificate.digest]


def test_malformed_octets_are_an_error_not_an_outcome() -> None:
    with pytest.raises(CodecError):
        VERIFIER.verify(VerifierState(), sent()[:-1], t_s=200.0)


def test_same_key_and_time_same_octets() -> None:
    assert sent() == sent()
    assert "12" not in repr(KEY)


def test_mistakes_of_a_caller_are_refused() -> None:
    with pytest.raises(ValueError, match="another key"):
        Signer(PrivateKey(5), SIGNER.certificate)
    with pytest.raises(ValueError, match="another key"):
        Authority(PrivateKey(5), ROOT.certificate)
    with pytest.raises(ValueError, match="good from 100 s"):
        sent(99.0)
    with pytest.raises(ValueError, match="not inside"):
        ROOT.issue(KEY.public_octets, start_s=100, duration_s=10_000)
    with pytest.raises(ValueError, match="t_s must"):
        SIGNER.sign(SignerState(), b"p", t_s=float("nan"))
    with pytest.raises(ValueError, match="secret"):
        PrivateKey(ORDER)
    with pytest.raises(ValueError, match="48 random octets"):
        PrivateKey.from_random(b"few")
    with pytest.raises(ValueError, match="remembered"):
        SecurityParameters(remembered=0)


def test_a_key_of_random_octets_is_in_range() -> None:
    assert PrivateKey.from_random(bytes(48)).secret == 1
    assert 1 <= PrivateKey.from_random(b"\xff" * 48).secret < ORDER


def test_without_the_library_the_error_names_the_extra() -> None:
    script = (
        "import sys; sys.modules['cryptography.exceptions'] = None\n"
        "from modelcast.core.exceptions import MissingExtraError\n"
        "try:\n    import modelcast.messages.security.p256\n"
        "except MissingExtraError as error:\n    print(error)"
    )
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert ended.stdout.startswith("signing needs the packages of the extra node: ")
    assert " install cantools cryptography " in ended.stdout


def test_what_is_signed_is_bound_to_the_certificate() -> None:
    other = ROOT.issue(KEY.public_octets, start_s=100, duration_s=901)
    assert signed_part(1, b"p", other) != signed_part(1, b"p", SIGNER.certificate)
    assert len(signed_part(1, b"p", other)) == 64


def test_ten_thousand_senders_within_a_second_fill_no_more_than_the_caps() -> None:
    """Twelve stand for them: windows of senders are capped as the certificates are, whatever their age."""
    verifier = Verifier((ROOT.certificate,), SecurityParameters(certificates=4))
    state, first = VerifierState(), b""
    for sender in range(40, 52):
        key = PrivateKey(sender)
        octets = sent(
            200 + sender / 1000,
            signer=Signer(key, ROOT.issue(key.public_octets, start_s=100, duration_s=900)),
        )
        first = first or octets
        verification = verifier.verify(state, octets, t_s=200.1)
        assert verification.outcome is Outcome.ACCEPTED
        assert max(len(state.windows), len(state.store.senders)) <= 4
    assert verifier.verify(state, first, t_s=200.1).outcome is Outcome.REPLAYED


def test_no_message_is_accepted_twice_when_the_clock_goes_back() -> None:
    """A sender's window is forgotten when another appears later; the floor stays when the clock goes back."""
    octets = sent(200.0)
    key = PrivateKey(30)
    other = Signer(key, ROOT.issue(key.public_octets, start_s=100, duration_s=900))
    _, state = verified(octets)
    later = VERIFIER.verify(state, sent(300.0, signer=other), t_s=300.0)
    assert later.outcome is Outcome.ACCEPTED
    assert SIGNER.certificate.digest not in state.windows
    assert VERIFIER.verify(state, octets, t_s=200.0).outcome is Outcome.REPLAYED
    assert VERIFIER.verify(state, sent(200.5), t_s=200.0).outcome is Outcome.IN_FUTURE
    assert VERIFIER.verify(state, sent(200.5), t_s=200.5).outcome is Outcome.ACCEPTED


def test_a_certificate_is_for_its_applications_only() -> None:
    blank = replace(SIGNER.certificate, psids=(0x21,))
    certificate = replace(blank, signature=ROOT.key.sign(blank.signed_part(ROOT.certificate)))
    assert verified(sent(signer=Signer(KEY, certificate)))[0].outcome is Outcome.NOT_PERMITTED


def test_an_authority_signs_no_messages_and_a_sender_is_no_authority() -> None:
    blank = replace(SIGNER.certificate, psids=())
    certificate = replace(blank, signature=ROOT.key.sign(blank.signed_part(ROOT.certificate)))
    assert verified(sent(signer=Signer(KEY, certificate)))[0].outcome is Outcome.UNTRUSTED_CERTIFICATE
    other = PrivateKey(13)
    issued = Authority(KEY, SIGNER.certificate).issue(other.public_octets, start_s=100, duration_s=900)
    trusting = Verifier((ROOT.certificate, SIGNER.certificate))
    assert verified(sent(signer=Signer(other, issued)), verifier=trusting)[0].outcome is (
        Outcome.UNTRUSTED_CERTIFICATE
    )

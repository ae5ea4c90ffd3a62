"""Measure how long signing and verifying a message take.

64 octets of payload, one thread, the garbage collector off; the shortest of the rounds, since other work may
run.
"""

import gc
import time
from collections.abc import Callable

from measured import record
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.p256 import PrivateKey, PublicKey
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.security.signer import Signer, SignerState
from modelcast.messages.security.verifier import Outcome, Verifier, VerifierState

ROUNDS, MESSAGES = 9, 500
PAYLOAD_OCTETS = 64
PAYLOAD = bytes(PAYLOAD_OCTETS)
SENDERS = 1000


def per_call_us(run: Callable[[], object], calls: int = MESSAGES) -> float:
    """Shortest time of one call over the rounds [µs]; each run makes all calls of a round."""
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter_ns()
        run()
        times.append((time.perf_counter_ns() - begin) / calls / 1e3)
    return min(times)


def main() -> None:
    """Measure and print."""
    gc.disable()
    root = Authority.create(PrivateKey(11), start_s=0, duration_s=10_000)
    signers = []
    for secret in range(100, 100 + SENDERS):
        key = PrivateKey(secret)
        signers.append(Signer(key, root.issue(key.public_octets, start_s=0, duration_s=10_000)))
    verifier = Verifier((root.certificate,))
    state = VerifierState()
    attached = [one.sign(SignerState(), PAYLOAD, t_s=100.0)[0] for one in signers]
    for octets in attached:
        verifier.verify(state, octets, t_s=100.0)
    signer = signers[0]
    messages = [
        signer.sign(SignerState(round((100.1 + i / 1e3) * 1e6)), PAYLOAD, t_s=100.1 + i / 1e3)[0]
        for i in range(MESSAGES)
    ]

    def sign() -> None:
        for i in range(MESSAGES):
            signer.sign(SignerState(100_000_000), PAYLOAD, t_s=100.1 + i / 1e6)

    def verify() -> None:
        held = VerifierState(state.store, dict(state.windows), state.floor_us)
        for octets in messages:
            verification = verifier.verify(held, octets, t_s=100.6)
            assert verification.outcome is Outcome.ACCEPTED

    def first() -> None:
        held = VerifierState()
        for octets in attached:
            verification = verifier.verify(held, octets, t_s=100.0)
            assert verification.outcome is Outcome.ACCEPTED

    data = bytes(64)
    signature = signer.key.sign(data)
    public = PublicKey(signer.key.public_octets)
    print(
        f"payload {len(PAYLOAD)}, with digest {len(messages[0])}, with certificate {len(attached[0])} bytes"
    )
    rows = {
        "bare signature": per_call_us(lambda: [signer.key.sign(data) for _ in range(MESSAGES)]),
        "bare verification": per_call_us(lambda: [public.verifies(data, signature) for _ in range(MESSAGES)]),
        "sign a message": per_call_us(sign),
        f"verify, certificate held, {SENDERS} senders": per_call_us(verify),
        f"verify, certificate new, up to {SENDERS} senders": per_call_us(first, SENDERS),
        "decode alone": per_call_us(lambda: [decode_signed(one) for one in messages]),
    }
    bare = {"sign": rows["bare signature"], "verify": rows["bare verification"]}
    for name, time_us in rows.items():
        verb = name.split(" ", 1)[0].rstrip(",")
        record(name, time_us, "µs", peer=(f"bare, {verb}", bare[verb]) if verb in bare else None)
        print(f"{name:45s} {time_us:7.1f} µs")


if __name__ == "__main__":
    main()

"""Agreement of our codec of basic safety messages with asn1tools, and how much faster it is.

Agreement: random messages, codes drawn over the whole range of every field, one in four with Part II or a
regional extension. Octets must be the same, and each codec must read the other's. Those that hold Part I
alone go through the batch too. Speed: encode and decode of cores alone, in turns with asn1tools, least of
several rounds, one thread.
"""

import argparse
import random
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from measured import record
from modelcast.messages.asn1 import (
    message_of_reference_value,
    reference_codec,
    reference_encode,
    reference_value,
)
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm, encode_bsm, encode_message
from modelcast.messages.bsm_batch import codes_of_values, decode_cores, encode_cores, values_of_codes
from modelcast.messages.bsm_fields import BASIC_SAFETY_MESSAGE, CORE_FIELDS
from modelcast.messages.fields import Field

__all__ = ["BATCH", "least", "main", "opaque", "random_codes"]

BATCH = 10_000
ROUNDS = 200
LEAST_BATCH_RATIO = 20
LEAST_SINGLE_RATIO = 3
PEER_MESSAGES = 25


def random_codes(rng: np.random.Generator, count: int, fields: Sequence[Field] = CORE_FIELDS) -> Any:
    """Return codes over the whole range of every field, (count, F)."""
    return np.stack([rng.integers(field.low, field.high + 1, count) for field in fields], axis=1)


def opaque(rng: random.Random, ids: int, most: int) -> tuple[tuple[int, bytes], ...]:
    """Return some entries of Part II or regional extensions."""
    return tuple(
        (rng.randrange(ids), rng.randbytes(rng.choice((1, 9, 24, 133)))) for _ in range(rng.randint(0, most))
    )


def compare(count: int, seed: int) -> None:
    """Compare the codecs on random messages."""
    rng = np.random.default_rng(seed)
    plain = random.Random(seed)  # noqa: S311 - not for secrets
    begin = time.perf_counter()
    done = 0
    while done < count:
        codes = random_codes(rng, min(BATCH, count - done))
        frames, lengths = encode_cores(codes)
        found = decode_cores(frames, lengths)
        assert np.array_equal(found.codes, codes)
        for row, batched in zip(codes.tolist(), frames, strict=True):
            core = BsmCore(tuple(row))
            message = BasicSafetyMessage(core)
            if plain.random() < 0.25:
                message = BasicSafetyMessage(
                    core, part_ii=opaque(plain, 64, 8), regional=opaque(plain, 256, 4)
                )
            octets = encode_message(message)
            inner_at = 4 if octets[2] & 0x80 else 3
            assert octets == reference_encode(message)
            assert decode_bsm(octets) == message
            told = reference_codec().decode("BasicSafetyMessage", octets[inner_at:])
            assert message_of_reference_value(told) == message
            if not (message.part_ii or message.regional):
                assert octets == batched.tobytes()
        done += len(codes)
    print(f"{done} random messages agree, both ways ({time.perf_counter() - begin:.0f} s)")


def least(work: Callable[[], object], count: int, best: float) -> float:
    """Return the seconds a message, or the least so far."""
    begin = time.perf_counter()
    work()
    return min(best, (time.perf_counter() - begin) / count)


def peer_encode(bodies: list[Any]) -> None:
    """Encode with asn1tools."""
    peer = reference_codec()
    for body in bodies:
        inner = peer.encode("BasicSafetyMessage", body)
        peer.encode("MessageFrame", {"messageId": BASIC_SAFETY_MESSAGE, "value": inner})


def peer_decode(some: list[bytes]) -> None:
    """Decode with asn1tools."""
    peer = reference_codec()
    for octets in some:
        frame: Any = peer.decode("MessageFrame", octets)
        peer.decode("BasicSafetyMessage", frame["value"])


def speed(seed: int) -> bool:
    """Time the codecs in turns and return whether the ratios are as they should be."""
    codes = random_codes(np.random.default_rng(seed), BATCH)
    frames, lengths = encode_cores(codes)
    some = [frame.tobytes() for frame in frames[:PEER_MESSAGES]]
    cores = [decode_bsm(octets).core for octets in some]
    bodies = [reference_value(BasicSafetyMessage(core)) for core in cores]
    values = np.nan_to_num(values_of_codes(codes))
    works: dict[str, tuple[Callable[[], object], int]] = {
        "asn1tools encode": (lambda: peer_encode(bodies), PEER_MESSAGES),
        "asn1tools decode": (lambda: peer_decode(some), PEER_MESSAGES),
        "single encode": (lambda: [encode_bsm(core) for core in cores], PEER_MESSAGES),
        "single decode": (lambda: [decode_bsm(octets) for octets in some], PEER_MESSAGES),
        "batch encode": (lambda: encode_cores(codes), BATCH),
        "batch decode": (lambda: decode_cores(frames, lengths), BATCH),
        "batch values to codes": (lambda: codes_of_values(values), BATCH),
        "batch codes to values": (lambda: values_of_codes(codes), BATCH),
    }
    seconds = dict.fromkeys(works, np.inf)
    for _ in range(ROUNDS):
        for name, (work, count) in works.items():
            seconds[name] = least(work, count, seconds[name])
    for name, one in seconds.items():
        print(f"  {name:22} {one * 1e6:8.3f} µs a message")
    peer_s = seconds["asn1tools encode"] + seconds["asn1tools decode"]
    batch = peer_s / (seconds["batch encode"] + seconds["batch decode"])
    single = peer_s / (seconds["single encode"] + seconds["single decode"])
    for how, ratio in (("batch", batch), ("single", single)):
        cost_us = 1e6 * float(seconds[f"{how} encode"] + seconds[f"{how} decode"])
        record(f"encode and decode, {how}", cost_us, "µs a message", peer=("asn1tools", ratio * cost_us))
    print(f"encode and decode are {batch:.0f} times as fast in batches of {BATCH}, {single:.1f} times singly")
    return bool(batch >= LEAST_BATCH_RATIO and single >= LEAST_SINGLE_RATIO)


def main() -> int:
    """Run both studies and return 1 where the codec is slower than it should be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    quick = speed(given.seed)
    compare(given.messages, given.seed)
    return 0 if quick else 1


if __name__ == "__main__":
    sys.exit(main())

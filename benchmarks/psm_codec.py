"""Speed of the codec of personal safety messages beside that of basic ones, and its agreement with asn1tools.

Agreement: random messages, codes drawn over the whole range of every field, one in two without its elevation,
one in four with some optional parts. Octets must be the same, and each codec must read the other's. Those
without optional parts go through the batch too. Speed: messages with what every message holds, singly and in
batch, personal and basic in turns within a round, least of several rounds, one thread. The ratio is messages
a second over those of the basic safety message.
"""

import argparse
import random
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bsm_codec import BATCH, least, opaque, random_codes
from measured import record
from modelcast.messages.bsm import BsmCore, decode_bsm, encode_bsm
from modelcast.messages.bsm_batch import codes_of_values, decode_cores, encode_cores, values_of_codes
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm
from modelcast.messages.psm_batch import (
    decode_people,
    encode_people,
    person_codes_of_values,
    person_values_of_codes,
)
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS, PERSON_INDEX
from modelcast.messages.psm_reference import reference_decode_psm, reference_encode_psm
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth, Value

__all__ = ["main"]

ROUNDS = 200
SINGLE = 200
LEAST_RATIO = 1.0
ELEVATION = PERSON_INDEX["elevation_m"]
UNKNOWN_ELEVATION = PERSON_FIELDS[ELEVATION].code_of(None)


def random_value(rng: random.Random, shape: AbstractShape) -> Value:
    """Return a value of a shape."""
    match shape:
        case Number(field) | Truth(field):
            return rng.randint(field.low, field.high)
        case Record():
            return tuple(
                None if member.name in shape.optional and rng.random() < 0.5 else random_value(rng, member)
                for member in shape.members
            )
        case Series():
            return tuple(random_value(rng, shape.item) for _ in range(rng.randint(1, shape.most)))
        case Choice():
            place = rng.randrange(len(shape.alternatives))
            return place, random_value(rng, shape.alternatives[place])
        case _:
            raise TypeError(shape)


def random_message(rng: random.Random, codes: tuple[int, ...], *, elevation: bool) -> PersonalSafetyMessage:
    """Return a message with some optional parts."""
    parts: dict[str, Any] = {
        shape.name: random_value(rng, shape) for shape in PART_SHAPES if rng.random() < 0.5
    }
    return PersonalSafetyMessage(
        codes,
        has_elevation=elevation,
        acceleration=parts.pop("acceleration", ()),
        path_prediction=parts.pop("path_prediction", ()),
        parts=tuple(parts.items()),
        regional=opaque(rng, 256, 4),
    )


def compare(count: int, seed: int) -> None:
    """Compare the codecs on random messages."""
    rng = np.random.default_rng(seed)
    plain = random.Random(seed)  # noqa: S311 - not for secrets
    begin = time.perf_counter()
    done = 0
    while done < count:
        codes = random_codes(rng, min(BATCH, count - done), PERSON_FIELDS)
        there = rng.random(len(codes)) < 0.5
        codes[~there, ELEVATION] = UNKNOWN_ELEVATION
        frames, lengths = encode_people(codes, there)
        found = decode_people(frames, lengths)
        assert np.array_equal(found.codes, codes)
        assert np.array_equal(found.has_elevation, there)
        rows = zip(codes.tolist(), there.tolist(), frames, lengths.tolist(), strict=True)
        for row, elevation, frame, length in rows:
            message = PersonalSafetyMessage(tuple(row), has_elevation=elevation)
            assert encode_psm(message) == frame[:length].tobytes()
            if plain.random() < 0.25:
                message = random_message(plain, tuple(row), elevation=elevation)
            octets = encode_psm(message)
            assert octets == reference_encode_psm(message)
            assert decode_psm(octets) == reference_decode_psm(octets) == message
        done += len(codes)
    print(f"{done} random messages agree, both ways ({time.perf_counter() - begin:.0f} s)")


def speed(seed: int) -> bool:
    """Time both codecs in turns and return whether that of people is as fast."""
    rng = np.random.default_rng(seed)
    vehicles, people = random_codes(rng, BATCH, CORE_FIELDS), random_codes(rng, BATCH, PERSON_FIELDS)
    vehicle_frames, vehicle_lengths = encode_cores(vehicles)
    person_frames, person_lengths = encode_people(people)
    vehicle_values = np.nan_to_num(values_of_codes(vehicles))
    person_values = np.nan_to_num(person_values_of_codes(people))
    cores = [BsmCore(tuple(row)) for row in vehicles[:SINGLE].tolist()]
    messages = [PersonalSafetyMessage(tuple(row)) for row in people[:SINGLE].tolist()]
    core_octets = [encode_bsm(core) for core in cores]
    octets = [encode_psm(message) for message in messages]
    works: dict[str, tuple[int, Callable[[], object], Callable[[], object]]] = {
        "single encode": (
            SINGLE,
            lambda: [encode_bsm(core) for core in cores],
            lambda: [encode_psm(message) for message in messages],
        ),
        "single decode": (
            SINGLE,
            lambda: [decode_bsm(one) for one in core_octets],
            lambda: [decode_psm(one) for one in octets],
        ),
        "batch encode": (BATCH, lambda: encode_cores(vehicles), lambda: encode_people(people)),
        "batch decode": (
            BATCH,
            lambda: decode_cores(vehicle_frames, vehicle_lengths),
            lambda: decode_people(person_frames, person_lengths),
        ),
        "batch values to codes": (
            BATCH,
            lambda: codes_of_values(vehicle_values),
            lambda: person_codes_of_values(person_values),
        ),
        "batch codes to values": (
            BATCH,
            lambda: values_of_codes(vehicles),
            lambda: person_values_of_codes(people),
        ),
    }
    seconds = dict.fromkeys(works, (np.inf, np.inf))
    for _ in range(ROUNDS):
        for name, (count, vehicle, person) in works.items():
            basic, personal = seconds[name]
            seconds[name] = least(vehicle, count, basic), least(person, count, personal)
    print(f"  {'µs a message':22} {'basic':>8} {'personal':>9} {'ratio':>6}")
    for name, (basic, personal) in seconds.items():
        record(name, 1e6 * personal, "µs a message", peer=("the basic safety message", 1e6 * basic))
        print(f"  {name:22} {basic * 1e6:8.3f} {personal * 1e6:9.3f} {basic / personal:6.2f}")
    return all(basic / personal >= LEAST_RATIO for basic, personal in seconds.values())


def main() -> int:
    """Run both studies and return 1 where the codec is slower than that of basic safety messages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    quick = speed(given.seed)
    compare(given.messages, given.seed)
    return 0 if quick else 1


if __name__ == "__main__":
    sys.exit(main())

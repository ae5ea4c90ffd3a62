"""How fast are model updates sized and quantised in batch? Exit code 1 where under a million a second.

The updates are of the shipped profile, with a random Part I and random coefficients.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from measured import record
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Outside
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.models.profile import default_profile

BATCH = 10_000
ROUNDS = 100
SINGLE = 500
LEAST_PER_S = 1e6


def updates(codec: UpdateCodec, count: int) -> np.ndarray:
    """Rows of parameters within the ranges of their fields."""
    rng = np.random.default_rng(0)
    core = [
        rng.integers(*field.known_codes, count, endpoint=True).astype(float)
        * (1.0 if field.outside is Outside.REFUSE else field.resolution)
        for field in CORE_FIELDS
    ]
    layouts = codec.profile.layouts
    in_use = rng.integers(0, len(layouts), count).astype(float)
    fields = [field for layout in layouts for field in layout.fields]
    coefficients = [rng.uniform(field.low, field.high, count) * field.step for field in fields]
    return np.stack([*core, in_use, *coefficients], axis=1)


def fastest_s(work: Callable[[], object]) -> float:
    """Shortest of all rounds [s]."""
    found = np.inf
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        work()
        found = min(found, time.perf_counter() - begin)
    return found


def main() -> int:
    """Time both, and single messages beside them."""
    codec = UpdateCodec(WireProfile.of_profile(default_profile()))
    rows = updates(codec, BATCH)
    some = [codec.message_of(row) for row in rows[:SINGLE].tolist()]
    octets = [codec.encode(message) for message in some]
    quantise_s = fastest_s(lambda: codec.quantise(rows)) / BATCH
    size_s = fastest_s(lambda: codec.sizes(rows)) / BATCH
    encode_s = fastest_s(lambda: [codec.encode(message) for message in some]) / SINGLE
    decode_s = fastest_s(lambda: [codec.decode(data) for data in octets]) / SINGLE
    print(f"quantise {1e6 * quantise_s:.3f} µs, size {1e6 * size_s:.3f} µs an update, batch of {BATCH}")
    print(f"encode {1e6 * encode_s:.1f} µs, decode {1e6 * decode_s:.1f} µs, one at a time")
    for what, cost_s in (
        ("quantise", quantise_s),
        ("size", size_s),
        ("encode singly", encode_s),
        ("decode singly", decode_s),
    ):
        record(what, 1e6 * cost_s, "µs an update")
    per_s = 1.0 / (quantise_s + size_s)
    print(f"{per_s / 1e6:.2f} million updates a second quantised and sized")
    return 0 if per_s >= LEAST_PER_S else 1


if __name__ == "__main__":
    sys.exit(main())

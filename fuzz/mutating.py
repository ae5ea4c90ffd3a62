"""Mutants of a JSON document: what a careless or hostile hand makes of a file.

`mutant` is a function of the document and a random generator, so that any mutant can be made again. It
changes values in place of one another, scales and negates numbers, writes those that no file should hold,
lengthens, shortens and nests lists, drops, adds, renames and doubles keys, reaches into base64
arrays, and damages the text itself.
"""

import base64
import copy
import json
import random
import struct
from collections.abc import Callable
from contextlib import suppress
from typing import Any

__all__ = ["mutant"]

_NUMBERS = (
    0, 1, -1, 2, 3, 7, 8, 9, 10, 16, 20, 59, 60, 61, 64, 100, 101, 1000, 65_536, 1_000_000, 10**9, 2**31,
    2**53, 2**63, 10**30, 0.0, -0.0, 1e-300, 1e-15, 1e-9, 1e-6, 1e-3, 0.05, 0.1, 0.2, 0.5, 1.5, 2.5, 60.0,
    1e3, 1e4, 1e6, 1e9, 1e15, 1e300, 1.7e308, float("nan"), float("inf"), float("-inf"),
)  # fmt: skip
_TEXTS = ("", "inf", "-inf", "cv", "ctra", "learned", "guarded", "predicted", "cheapest", "best", "a" * 5000,
          "\x1b[2J", "\u202e", "\ud800", "/dev/zero", "/usr", "..", "NaN", "1", "true")  # fmt: skip
_KEYS = ("is", "schema", "float32", "shape", "model", "samples", "label", "extra", "__class__", "networks")
_CLASSES = (
    "AxisKernel", "ConstantAcceleration", "ConstantTurnRateAcceleration", "ConstantTurnRateVelocity",
    "ConstantVelocity", "GaussianProcess", "Hyperparameters", "LearnedTrajectory", "Network", "PredictedPath",
    "Regimes", "Selector", "Trusted", "VehicleProcess", "Bank", "Path", "object",
)  # fmt: skip
_ARRAY_VALUES = (0.0, -1.0, 1.0, 1e-30, 1e6, 2e6, 1e30, 3e38, float("nan"), float("inf"), float("-inf"))

Place = tuple[Any, Any]
"""What holds a value, and its key or index there."""


def mutant(document: Any, rng: random.Random) -> bytes:
    """Octets of a file that the document might have become.

    Parameters
    ----------
    document
        Plain values; left alone.
    rng
        Where chance comes from.
    """
    kind = rng.random()
    if kind < 0.06:
        return _damaged(_text(document).encode("utf-8", "surrogatepass"), rng)
    changed = copy.deepcopy(document)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        places = _places(changed, rng)
        if not places:
            break
        rng.choice(_CHANGES)(rng.choice(places), places, rng)
    text = _text(changed)
    if kind < 0.10:
        text = _doubled(text, rng)
    return text.encode("utf-8", "surrogatepass")


def _text(document: Any) -> str:
    return json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def _places(document: Any, rng: random.Random) -> list[Place]:
    """Values that may change, by a walk that leaves out most of every long list and of the record."""
    found: list[Place] = []
    waiting: list[Any] = [document]
    while waiting:
        holder = waiting.pop()
        if isinstance(holder, dict):
            keys = [key for key in holder if key != "record" or rng.random() < 0.05]
        else:
            keys = list(range(len(holder)))
            keys = keys if len(keys) <= 6 else rng.sample(keys, 6)
        for key in keys:
            found.append((holder, key))
            if isinstance(holder[key], dict | list):
                waiting.append(holder[key])
    return found


def _replace(place: Place, _places: list[Place], rng: random.Random) -> None:
    holder, key = place
    holder[key] = rng.choice(
        (
            rng.choice(_NUMBERS),
            rng.choice(_NUMBERS),
            rng.choice(_TEXTS),
            None,
            True,
            False,
            [],
            {},
            [rng.choice(_NUMBERS)] * rng.choice((1, 2, 3, 100)),
            {"is": rng.choice(_CLASSES)},
        )
    )


def _scale(_place: Place, places: list[Place], rng: random.Random) -> None:
    numbers = [(h, k) for h, k in places if type(h[k]) in (int, float)]
    if not numbers:
        return
    holder, key = rng.choice(numbers)
    value = holder[key]
    if rng.random() < 0.5:
        holder[key] = value * rng.choice((-1, 0.5, 0.9, 1.1, 2, 10, 1000, 1e-3, 1e-9, 1e9))
    else:
        holder[key] = value + rng.choice((-1, 1, 0.5, 2, -2, 10))
    if isinstance(value, int) and rng.random() < 0.7:
        with suppress(OverflowError, ValueError):
            holder[key] = int(holder[key])


def _number(_place: Place, places: list[Place], rng: random.Random) -> None:
    numbers = [(h, k) for h, k in places if type(h[k]) in (int, float, bool)]
    if numbers:
        holder, key = rng.choice(numbers)
        holder[key] = rng.choice(_NUMBERS)


def _length(_place: Place, places: list[Place], rng: random.Random) -> None:
    lists = [h[k] for h, k in places if isinstance(h[k], list)]
    if not lists:
        return
    items = rng.choice(lists)
    choice = rng.random()
    if choice < 0.3 and items:
        del items[rng.randrange(len(items))]
    elif choice < 0.6 and items:
        items.insert(rng.randrange(len(items) + 1), copy.deepcopy(rng.choice(items)))
    elif choice < 0.7 and items:
        items[:] = items * rng.choice((2, 5, 30))
    elif choice < 0.8:
        items.clear()
    elif choice < 0.9:
        rng.shuffle(items)
    elif items:
        at = rng.randrange(len(items))
        items[at] = [items[at]]


def _keys(_place: Place, places: list[Place], rng: random.Random) -> None:
    mappings = [h[k] for h, k in places if isinstance(h[k], dict)] + [
        h for h, _ in places if isinstance(h, dict)
    ]
    if not mappings:
        return
    holder = rng.choice(mappings)
    choice = rng.random()
    if choice < 0.4 and holder:
        del holder[rng.choice(list(holder))]
    elif choice < 0.7:
        holder[rng.choice(_KEYS)] = rng.choice((1, None, "x", [], {}))
    elif holder:
        old = rng.choice(list(holder))
        holder[rng.choice(_KEYS)] = holder.pop(old)


def _swap(place: Place, places: list[Place], rng: random.Random) -> None:
    (one, a), (other, b) = place, rng.choice(places)
    one[a] = copy.deepcopy(other[b])


def _class(_place: Place, places: list[Place], rng: random.Random) -> None:
    named = [h for h, k in places if k == "is"]
    if named:
        rng.choice(named)["is"] = rng.choice(_CLASSES)


def _array(_place: Place, places: list[Place], rng: random.Random) -> None:
    arrays = [h for h, k in places if k == "float32" and isinstance(h[k], str)]
    if not arrays:
        return
    array = rng.choice(arrays)
    try:
        raw = bytearray(base64.b64decode(array["float32"]))
    except ValueError:
        return
    choice = rng.random()
    if choice < 0.5 and len(raw) >= 4:
        at = 4 * rng.randrange(len(raw) // 4)
        raw[at : at + 4] = struct.pack("<f", rng.choice(_ARRAY_VALUES))
    elif choice < 0.7:
        raw = raw[: rng.randrange(len(raw) + 1)]
    elif choice < 0.8:
        raw += bytes(4 * rng.choice((1, 96, 1000)))
    elif "shape" in array:
        array["shape"] = rng.choice(([len(raw) // 4], [1, len(raw) // 4], [0], [-1], [2**40], [], "4", [1.5]))
    array["float32"] = base64.b64encode(bytes(raw)).decode("ascii")


def _deep(place: Place, _places: list[Place], rng: random.Random) -> None:
    holder, key = place
    value = holder[key]
    for _ in range(rng.choice((1, 2, 5, 20, 40))):
        value = [value] if rng.random() < 0.5 else {"is": "Trusted", "model": value, "horizon_s": "inf"}
    holder[key] = value


_CHANGES: tuple[Callable[[Place, list[Place], random.Random], None], ...] = (
    _replace, _scale, _scale, _scale, _number, _number, _length, _length, _keys, _swap, _class, _array,
    _array, _deep,
)  # fmt: skip


def _doubled(text: str, rng: random.Random) -> str:
    """The text with one key twice."""
    key = rng.choice(("schema", "label", "members", "command", "seeds", "paths"))
    return text.replace("{", '{"' + key + '":' + rng.choice(("1", "[]", '"x"')) + ",", 1)


def _damaged(octets: bytes, rng: random.Random) -> bytes:
    """Octets flipped, cut, put in or repeated; brackets beyond measure; numbers of thousands of digits."""
    raw = bytearray(octets)
    choice = rng.random()
    at = rng.randrange(len(raw))
    if choice < 0.4:
        for _ in range(rng.choice((1, 1, 4, 50))):
            raw[rng.randrange(len(raw))] = rng.randrange(256)
        return bytes(raw)
    if choice < 0.55:
        return bytes(raw[:at])
    put = rng.choice(
        (
            b"[" * 100_000,
            b'{"a":' * 100_000,
            b"9" * 5000,
            b"1e999",
            b"-Infinity",
            b"\x00",
            b"\xff\xfe",
            b'"',
            b"," * 1000,
            b"[]," * 400_000,
            b" " * (1 << 24),
        )
    )
    return bytes(raw[:at]) + put + bytes(raw[at:])

"""A second decoder of what goes on the air, from ``docs/wire.md`` alone; it imports nothing of modelcast.

It reads Part I's table out of the page. `read` gives plain values, or raises ValueError.
"""

import hashlib
import re
from pathlib import Path
from typing import Any

__all__ = ["read", "to_be_verified"]

PAGE = Path(__file__).parents[1] / "docs" / "wire.md"
ROW = re.compile(r"^\| `(\w+)` \| `[\w.]+` \| (\d+) \| (-?\d+) \| (-?\d+) \|", re.MULTILINE)
PART_I = [(name, int(w), int(low), int(high)) for name, w, low, high in ROW.findall(PAGE.read_text("utf-8"))]
FIELDS = {name: (width, low, high) for name, width, low, high in PART_I}
BEFORE_PLACE = ("second_of_minute_s", "message_count", "temporary_id")
PLACE = ("latitude_deg", "longitude_deg")
BEHIND_PLACE = ("semi_major_m", "semi_minor_m", "ellipse_orientation_rad", "speed_mps", "heading_rad")
ACCELERATION = (
    "acceleration_forward_mps2", "acceleration_right_mps2", "acceleration_down_mps2", "yaw_rate_radps",
)  # fmt: skip
LONGEST = 2304
UNITS_S = {0x82: 1, 0x83: 60, 0x84: 3600, 0x85: 216_000, 0x86: 31_556_952}


class Octets:
    """Octets from front to back."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, count: int) -> bytes:
        if self.at + count > len(self.data):
            raise ValueError("too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def number(self, count: int) -> int:
        return int.from_bytes(self.take(count), "big")

    def expect(self, digits: str) -> None:
        wanted = bytes.fromhex(digits)
        if self.take(len(wanted)) != wanted:
            raise ValueError(f"not {digits}")

    def among(self, *values: int) -> int:
        found = self.number(1)
        if found not in values:
            raise ValueError(f"{found} is not among {values}")
        return found

    def length(self) -> int:
        first = self.number(1)
        if first < 0x80:
            return first
        count = first - 0x80
        if not 1 <= count <= 4:
            raise ValueError("length")
        value = self.number(count)
        if value < 0x80 or value < 1 << 8 * (count - 1):
            raise ValueError("length too long")
        return value

    def whole(self) -> int:
        octets = self.take(self.length())
        if not octets or (octets[0] == 0 and len(octets) > 1):
            raise ValueError("number")
        return int.from_bytes(octets, "big")

    def short(self) -> int:
        """Count or length of a short message: leading ones say how many octets follow."""
        first = self.number(1)
        more = next((i for i in range(4) if not first << i & 0x80), None)
        if more is None:
            raise ValueError("count")
        self.at -= 1
        return self.number(1 + more) & ((1 << 7 + 7 * more) - 1)

    def finish(self) -> None:
        if self.at != len(self.data):
            raise ValueError("left over")


class Bits:
    """Bits from front to back."""

    def __init__(self, data: bytes) -> None:
        self.left = 8 * len(data)
        self.value = int.from_bytes(data, "big")

    def take(self, count: int) -> int:
        if count > self.left:
            raise ValueError("too short")
        self.left -= count
        return self.value >> self.left & ((1 << count) - 1)

    def length(self) -> int:
        first = self.take(8)
        if first < 0x80:
            return first
        value = (first & 0x3F) << 8 | self.take(8)
        if first >= 0xC0 or value < 0x80:
            raise ValueError("length")
        return value

    def octets(self, count: int) -> bytes:
        return self.take(8 * count).to_bytes(count, "big")

    def finish(self) -> None:
        if self.left > 7 or self.take(self.left):
            raise ValueError("left over")


def read(data: bytes) -> dict[str, Any]:
    """A short message with all that it holds."""
    if len(data) > LONGEST:
        raise ValueError("too long")
    octets = Octets(data)
    if octets.among(0x03, 0x0B) == 0x0B:
        extensions(octets)
    transport = octets.among(0, 1)
    begin = octets.at
    octets.short()
    psid = int.from_bytes(data[begin : octets.at], "big")
    if transport:
        extensions(octets)
    payload = octets.take(octets.short())
    octets.finish()
    return {"psid": psid, "data": data_1609(payload)}


def extensions(octets: Octets) -> None:
    count = octets.short()
    if count > 32:
        raise ValueError("too many extensions")
    for _ in range(count):
        octets.take(1)
        octets.take(octets.short())


def data_1609(data: bytes) -> dict[str, Any]:
    octets = Octets(data)
    octets.expect("03")
    if octets.among(0x80, 0x81) == 0x80:
        payload = octets.take(octets.length())
        octets.finish()
        return {"frame": frame(payload)}
    octets.expect("00")
    begin = octets.at
    octets.expect("400380")
    payload = octets.take(octets.length())
    octets.expect("40")
    psid, generation_us = octets.whole(), octets.number(8)
    signed = data[begin : octets.at]
    if octets.among(0x80, 0x81) == 0x80:
        signer: Any = octets.take(8)
    else:
        octets.expect("0101")
        signer = certificate(octets)
    signature = signed_by(octets)
    octets.finish()
    return {
        "frame": frame(payload),
        "psid": psid,
        "generation_us": generation_us,
        "signer": signer,
        "signature": signature,
        "to_be_signed": signed,
    }


def signed_by(octets: Octets) -> bytes:
    octets.expect("80")
    octets.among(0x80, 0x82, 0x83)
    return octets.take(64)


def certificate(octets: Octets) -> dict[str, Any]:
    start_at = octets.at
    octets.expect("800300")
    issuer = b""
    if octets.among(0x80, 0x81) == 0x80:
        issuer = octets.take(8)
    else:
        octets.expect("00")
    begin = octets.at
    contents = octets.among(0x10, 0x08)
    name = octets.take(octets.length()).decode() if octets.among(0x81, 0x83) == 0x81 else None
    octets.take(5)
    start_s = octets.number(4)
    duration_s = UNITS_S[octets.among(*UNITS_S)] * octets.number(2)
    psids: list[int] = []
    if contents == 0x10:
        for _ in range(octets.whole()):
            octets.expect("00")
            psids.append(octets.whole())
    else:
        octets.expect("01010081")
    octets.expect("8080")
    key = bytes([octets.among(0x82, 0x83) - 0x80]) + octets.take(32)
    signed = octets.data[begin : octets.at]
    canonical = octets.data[start_at : octets.at] + b"\x80\x80"
    signature = signed_by(octets)
    canonical += signature
    return {
        "issuer": issuer, "name": name, "start_s": start_s, "duration_s": duration_s, "psids": psids,
        "key": key, "signature": signature, "to_be_signed": signed, "canonical": canonical,
        "digest": hashlib.sha256(canonical).digest()[-8:],
    }  # fmt: skip


def to_be_verified(to_be_signed: bytes, canonical: bytes) -> bytes:
    """The octets whose SHA-256 is signed; no octets for the certificate of who is its own issuer."""
    return hashlib.sha256(to_be_signed).digest() + hashlib.sha256(canonical).digest()


def frame(data: bytes) -> dict[str, Any]:
    head = Bits(data)
    if head.take(1):
        raise ValueError("extended frame")
    message_id = head.take(15)
    body = head.octets(head.length())
    if head.left:
        raise ValueError("left over")
    bits = Bits(body)
    if message_id == 240:
        names = (("temporary_id", 32), ("sequence", 7), ("sub_model", 3), ("age", 14))
        found: dict[str, Any] = {name: bits.take(width) for name, width in names}
    elif message_id == 20:
        found = safety(bits)
    elif message_id == 32:
        found = personal(bits)
    else:
        raise ValueError("message id")
    bits.finish()
    return found


def safety(bits: Bits) -> dict[str, Any]:
    extended, part_ii, regional = bits.take(1), bits.take(1), bits.take(1)
    if extended:
        raise ValueError("a later edition")
    codes = [coded(bits, name) for name, *_ in PART_I]
    found: dict[str, Any] = {"codes": codes, "part_ii": []}
    if part_ii:
        found["part_ii"] = [(bits.take(6), bits.octets(bits.length())) for _ in range(bits.take(3) + 1)]
    return found | extended_by(bits, there=regional == 1)


def personal(bits: Bits) -> dict[str, Any]:
    if bits.take(1):
        raise ValueError("a later edition")
    accelerates, others, regional = bits.take(1), bits.take(16), bits.take(1)
    if others:
        raise ValueError("parts that the page does not tell")
    if bits.take(1):
        raise ValueError("a type of a later edition")
    codes = [bits.take(3)]
    if codes[0] > 4:
        raise ValueError("type")
    codes += [coded(bits, name) for name in BEFORE_PLACE]
    if bits.take(1):
        raise ValueError("extended place")
    elevated = bits.take(1)
    if bits.take(1):
        raise ValueError("extended place")
    codes += [coded(bits, name) for name in PLACE]
    codes.append(coded(bits, "elevation_m") if elevated else -4096)
    codes += [coded(bits, name) for name in BEHIND_PLACE]
    acceleration = [coded(bits, name) for name in ACCELERATION] if accelerates else []
    return {"person_codes": codes, "acceleration": acceleration} | extended_by(bits, there=regional == 1)


def coded(bits: Bits, name: str) -> int:
    width, low, high = FIELDS[name]
    code = bits.take(width) + low
    if code > high:
        raise ValueError(name)
    return code


def extended_by(bits: Bits, *, there: bool) -> dict[str, Any]:
    found: dict[str, Any] = {"regional": [], "model": None}
    if there:
        found["regional"] = [(bits.take(8), bits.octets(bits.length())) for _ in range(bits.take(2) + 1)]
    for region, octets in found["regional"]:
        if region == 128:
            found["model"] = model(Bits(octets))
    return found


def model(bits: Bits) -> dict[str, Any]:
    found: dict[str, Any] = {
        "profile": bits.take(24),
        "sub_model": bits.take(3),
        "all": bits.take(1),
        "coefficients": bits.octets(bits.take(7)),
    }
    bits.finish()
    return found

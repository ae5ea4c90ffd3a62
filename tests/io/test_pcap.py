"""Claims about captures: every form gives the same messages, and tshark reads what is written."""

import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io.message_file import pieces_of
from modelcast.io.pcap import CapturedFrame, frames_of, is_capture, pcap_octets, short_message_of
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.security.signed import SignedMessage
from modelcast.messages.wsmp import encode_wsm

BSM = encode_bsm(BsmCore.from_values({"message_count": 1, "temporary_id": 0xA1B2C3D4, "yaw_rate_radps": 0.0}))
DATA = SignedMessage(5, BSM, bytes(8), bytes(64)).octets
WSM = encode_wsm(DATA)
SNAP = bytes.fromhex("aaaa03000000")
QOS = bytes.fromhex("8800") + bytes(22) + bytes(2)
PLAIN = bytes.fromhex("0800") + bytes(22)
LINKS = {
    "ethernet": (1, bytes(12) + b"\x88\xdc" + WSM),
    "ethernet with VLAN": (1, bytes(12) + b"\x81\x00\x00\x05\x88\xdc" + WSM),
    "802.11, SNAP": (105, QOS + SNAP + b"\x88\xdc" + WSM),
    "802.11, EPD": (105, PLAIN + b"\x88\xdc" + WSM),
    "radiotap": (127, bytes.fromhex("0000080000000000") + QOS + SNAP + b"\x88\xdc" + WSM),
    "radiotap with check sequence": (
        127,
        bytes.fromhex("000009000200000010") + QOS + SNAP + b"\x88\xdc" + WSM + bytes(4),
    ),
    "user 0, WSMP": (147, WSM),
    "user 0, 1609.2": (147, DATA),
}


def classic(
    link: int, frame: bytes, order: str = "<", magic: int = 0xA1B2C3D4, parts: int = 500_000
) -> bytes:
    head = struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 65535, link)
    return head + struct.pack(order + "IIII", 1_700_000_000, parts, len(frame), len(frame)) + frame


def block(kind: int, body: bytes, order: str) -> bytes:
    body += bytes(-len(body) % 4)
    size = struct.pack(order + "I", 12 + len(body))
    return struct.pack(order + "I", kind) + size + body + size


def blocks(link: int, frame: bytes, order: str = "<", *, simple: bool = False) -> bytes:
    ticks = 1_700_000_000_500_000
    out = block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1), order)
    out += block(1, struct.pack(order + "HHI", link, 0, 65535), order)
    out += block(0xBAD, b"other", order)
    if simple:
        return out + block(3, struct.pack(order + "I", len(frame)) + frame, order)
    stamp = (0, ticks >> 32, ticks & 0xFFFFFFFF, len(frame), len(frame))
    return out + block(6, struct.pack(order + "IIIII", *stamp) + frame, order)


@pytest.mark.parametrize(("link", "frame"), LINKS.values(), ids=LINKS)
def test_every_form_gives_the_same_message(link: int, frame: bytes) -> None:
    timed = {
        "classic": classic(link, frame),
        "big endian": classic(link, frame, ">"),
        "nanoseconds": classic(link, frame, "<", 0xA1B23C4D, 500_000_000),
        "pcapng": blocks(link, frame),
        "pcapng, big endian": blocks(link, frame, ">"),
    }
    for content in timed.values():
        assert is_capture(content)
        (found,) = frames_of(content)
        assert found == CapturedFrame(1, 1_700_000_000_500_000_000, link, frame)
        assert [piece.octets for piece in pieces_of(content)] == [DATA]
    (found,) = frames_of(blocks(link, frame, simple=True))
    assert found == CapturedFrame(1, None, link, frame)


@pytest.mark.parametrize("link", [1, 105, 127, 228])
def test_other_frames_are_counted_and_told(link: int) -> None:
    (piece,) = pieces_of(classic(link, bytes(60)))
    assert piece.fault == f"no WAVE short message (link type {link})"
    assert not piece.octets


def test_what_was_not_captured_is_told() -> None:
    content = bytearray(classic(1, LINKS["ethernet"][1]))
    content[36:40] = struct.pack("<I", len(LINKS["ethernet"][1]) + 7)
    assert next(pieces_of(bytes(content))).fault == "7 octets were not captured"


@given(st.sampled_from([classic(127, LINKS["radiotap"][1]), blocks(1, LINKS["ethernet"][1])]), st.data())
def test_any_octets_are_frames_or_refused(content: bytes, data: st.DataObject) -> None:
    bent = bytearray(content[: data.draw(st.integers(0, len(content)))])
    for _ in range(data.draw(st.integers(0, 3))):
        if bent:
            bent[data.draw(st.integers(0, len(bent) - 1))] = data.draw(st.integers(0, 255))
    try:
        for frame in frames_of(bytes(bent)):
            short_message_of(frame)
    except DataFormatError:
        return


@given(st.lists(st.tuples(st.integers(0, 2**32 * 10**9 - 1), st.binary(max_size=300)), max_size=5))
def test_what_is_written_is_read(messages: list[tuple[int, bytes]]) -> None:
    frames = list(frames_of(b"".join(pcap_octets(messages))))
    assert [(frame.t_ns, short_message_of(frame)) for frame in frames] == messages


@pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
@pytest.mark.parametrize("data", [DATA, encode_unsecured(BSM)], ids=["signed", "unsecured"])
def test_tshark_follows_it_to_the_payload(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "sent.pcap"
    path.write_bytes(b"".join(pcap_octets([(1_700_000_000 * 10**9, encode_wsm(data))])))
    fields = ("frame.protocols", "ieee1609dot2.unsecuredData", "_ws.malformed")
    asked = [part for field in fields for part in ("-e", field)]
    ended = subprocess.run(  # noqa: S603 - our own file
        ["tshark", "-r", str(path), "-T", "fields", "-E", "separator=;", *asked],  # noqa: S607
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ended.stdout.strip() == f"eth:ethertype:wsmp:ieee1609dot2;{BSM.hex()};"

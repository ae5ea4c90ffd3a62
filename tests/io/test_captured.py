"""Claims about messages in captures: what is opened, what is counted, what was lost."""

from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.captured import Captured
from modelcast.io.loss_logs import read_loss_logs
from modelcast.io.pcap import pcap_octets
from modelcast.io.trips import read_trips
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.security.signed import SignedMessage
from modelcast.messages.wsmp import encode_wsm

START_S = 1_700_000_030


def octets(at: int, *, sender: int = 7, mark: bool = True) -> bytes:
    values = {
        "message_count": at % 128,
        "temporary_id": sender,
        "second_of_minute_s": (START_S + 0.1 * at) % 60.0 if mark else None,
        "latitude_deg": 48.0 + 1e-5 * at,
        "longitude_deg": 11.0,
        "speed_mps": 11.0,
        "heading_rad": 0.0,
        "acceleration_forward_mps2": 0.0,
        "yaw_rate_radps": 0.0,
    }
    return encode_bsm(BsmCore.from_values(values))


def signed(payload: bytes) -> bytes:
    return SignedMessage(5, payload, signer=bytes(8), signature=bytes(64)).octets


def behind_unread(payload: bytes) -> bytes:
    """A signed message whose signer is a certificate of a kind that is not read: implicit."""
    whole = signed(payload)
    begin = len(whole) - 9 - 66
    return whole[:begin] + b"\x81\x01\x01\x80\x03\x01" + bytes(range(60)) + whole[-66:]


def capture(path: Path, frames: list[tuple[float, bytes]]) -> Path:
    path.write_bytes(b"".join(pcap_octets((round(t_s * 1e9), frame) for t_s, frame in frames)))
    return path


def test_a_payload_in_front_of_what_is_not_read_is_in_the_trip(tmp_path: Path) -> None:
    wraps = (encode_unsecured, signed, behind_unread)
    frames = [(START_S + 0.1 * at + 0.001, encode_wsm(wraps[at % 3](octets(at)))) for at in range(300)]
    told: dict[str, str] = {}
    path = capture(tmp_path / "heard.pcap", frames)
    (trip,) = read_trips(path, on_skipped=told.__setitem__)
    assert len(trip) == 300
    assert told == {"heard": "100 messages behind signatures or certificates that are not read"}


def test_every_record_is_one_of_five_kinds(tmp_path: Path) -> None:
    found = Captured(
        str(
            capture(
                tmp_path / "mixed.pcap",
                [
                    (START_S, encode_wsm(encode_unsecured(octets(0)))),
                    (START_S, encode_wsm(behind_unread(octets(1)))),
                    (START_S, encode_wsm(encode_unsecured(bytes.fromhex("00f007000000010e8082")))),
                    (START_S, encode_wsm(b"\x03\x82" + bytes(40))),
                ],
            )
        )
    )
    assert [message.number for message in found.messages()] == [1, 2]
    assert dict(found.kinds) == {"read": 1, "behind": 1, "no message": 2}
    assert found.told() == [
        "1 messages behind signatures or certificates that are not read",
        "2 short messages without a basic safety message",
    ]


def test_what_a_capture_does_not_hold_is_told_as_lost(tmp_path: Path) -> None:
    """Losses put in are found, one by one and in bursts, sender by sender."""
    rng = np.random.default_rng(5)
    lost = {sender: rng.random(400) < 0.25 for sender in (7, 8)}
    frames: list[tuple[float, bytes]] = []
    for sender, rows in lost.items():
        rows[[0, -1]] = False
        frames += [
            (START_S + 0.1 * at + 0.002, encode_wsm(behind_unread(octets(at, sender=sender))))
            for at in np.flatnonzero(~rows)
        ]
    frames += [(START_S + 1.0, encode_wsm(encode_unsecured(octets(10, sender=9, mark=False))))]
    (log,) = read_loss_logs([capture(tmp_path / "road.pcap", frames)])
    found = {link.name[-8:]: link.lost for link in log.channel.links}
    assert set(found) == {"00000007", "00000008"}
    for sender, rows in lost.items():
        assert np.array_equal(found[f"{sender:08x}"], rows)
    assert log.heard.uncounted == 1
    assert "1 message without time or count" in log.as_text()
    heard = sum(int((~rows).sum()) for rows in lost.values())
    assert f"met: {heard} messages behind signatures or certificates" in log.as_text()


def test_a_capture_that_tells_no_losses_is_refused(tmp_path: Path) -> None:
    empty = capture(tmp_path / "empty.pcap", [])
    with pytest.raises(DataFormatError, match="holds no message"):
        read_loss_logs([empty])
    short = capture(
        tmp_path / "short.pcap",
        [(START_S + 0.1 * at, encode_wsm(encode_unsecured(octets(at)))) for at in range(20)],
    )
    with pytest.raises(DataFormatError, match="in a row"):
        read_loss_logs([short])
    cut = tmp_path / "cut.pcap"
    cut.write_bytes(short.read_bytes()[:-5])
    with pytest.raises(DataFormatError, match="record 20"):
        read_loss_logs([cut])

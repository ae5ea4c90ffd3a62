"""Claims about a recording gone through again: the same to the bit, and whatever is not is found."""

import base64
import json
import random
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import zstandard
from mcap.reader import make_reader
from mcap.writer import Writer

from modelcast.cli.app import USAGE, run
from modelcast.cli.node import sender_of_config
from modelcast.core.exceptions import DataFormatError
from modelcast.io.mcap_records import MOST_CHUNK_OCTETS
from modelcast.messages.security.time64 import since_2004_s
from modelcast.node.config import NodeConfig, Pseudonyms, Security, Sending
from modelcast.node.credentials import make_credentials
from modelcast.node.recording.reader import RecordReader
from modelcast.node.recording.replay import replay_recording

from .three_cars import UTC_S, drive

Change = Callable[[str, dict[str, Any]], dict[str, Any] | None]


def rewritten(path: Path, into: Path, change: Change, *, first: str = "") -> Path:
    """The same recording with other words; a message that becomes None is left out."""
    with path.open("rb") as file, into.open("wb") as out:
        writer = Writer(out)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels: dict[str, int] = {}
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            topic = channel.topic
            words = change(topic, json.loads(message.data))
            if words is None:
                continue
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "json", schema)
            data = json.dumps(words).encode()
            writer.add_message(channels[topic], message.log_time, data, message.log_time)
        if first:
            extra = writer.register_channel(first, "json", schema)
            writer.add_message(extra, 0, b"{}", 0)
        writer.finish()
    return into


def only(topic: str, number: int, **changes: Any) -> Change:
    """Change one message of a topic."""
    seen = 0

    def change(name: str, words: dict[str, Any]) -> dict[str, Any]:
        nonlocal seen
        if name == topic:
            seen += 1
            if seen == number:
                for key, value in changes.items():
                    words[key] = value(words[key]) if callable(value) else value
        return words

    return change


def same(_topic: str, words: dict[str, Any]) -> dict[str, Any]:
    return words


def test_a_recording_gives_the_same_map_to_the_bit(recording: Path) -> None:
    visited: list[float] = []
    found = replay_recording(recording, sender_of_config, visit=lambda _, state: visited.append(state.t_s))
    assert (found.steps, found.difference, found.cut_off, found.skipped) == (80, "", False, {})
    assert found.heard > 10
    assert found.sent > 5
    assert visited == [0.1 * step for step in range(80)]


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["mbc", "j2945", "j2945-mbc"])
def test_so_does_one_of_every_kind_of_sender(policy: str, tmp_path: Path) -> None:
    config = NodeConfig(sending=Sending(policy=policy), pseudonyms=Pseudonyms(least_s=1.0, most_s=2.0))
    for path in drive(tmp_path, steps=50, recorded=2, config=config):
        found = replay_recording(path, sender_of_config)
        assert (found.steps, found.difference) == (50, "")


def flipped(text: str) -> str:
    """The lowest bit of the first octet of base64."""
    octets = bytearray(base64.b64decode(text))
    octets[0] ^= 1
    return base64.b64encode(bytes(octets)).decode()


def flip(column: str) -> Change:
    """A bit of a column of the 60th map."""

    def change(own: dict[str, str]) -> dict[str, str]:
        return own | {column: flipped(own[column])}

    return only("/beliefs", 60, columns=change)


def renamed(name: int) -> int:
    """Another temporary id."""
    return name ^ 1


def aside(motion: dict[str, Any]) -> dict[str, Any]:
    """The same motion, three metres beside."""
    return motion | {"position_m": [motion["position_m"][0] + 3.0, 0.0]}


def without_begin(topic: str, words: dict[str, Any]) -> dict[str, Any] | None:
    """All but what the node is made again from."""
    return None if topic == "/about" else words


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (only("/step", 30, temporary_id=renamed), "step 30 .*: temporary_id is"),
        (only("/step", 30, warnings=[{"application": "ima", "vehicle": 1, "level": 2}]), "30 .*: warnings"),
        (only("/heard", 5, outcome="otherwise"), "the frame received at .*: 'accepted', not 'otherwise'"),
        (only("/sent", 4, message="AAAA"), "differs from octet 1 on"),
        (flip("speed_mps"), "step 60 .*: speed_mps of remote"),
        (flip("vehicle"), "step 60 .*: . remotes, not ."),
        (only("/beliefs", 60, t_s=5.91), "the map is of"),
    ],
)  # fmt: skip
def test_one_bit_is_found_where_it_is(recording: Path, tmp_path: Path, change: Change, told: str) -> None:
    bent = rewritten(recording, tmp_path / "bent.mcap", change)
    with pytest.raises(AssertionError, match=told):
        expect_same(bent)


def expect_same(path: Path) -> None:
    found = replay_recording(path, sender_of_config)
    if found.difference:
        raise AssertionError(found.difference)


def test_what_the_node_does_depends_on_what_is_fed(recording: Path, tmp_path: Path) -> None:
    """A frame left out, another motion, another seed: each is found, so each was used."""
    seen = 0

    def fewer(topic: str, words: dict[str, Any]) -> dict[str, Any] | None:
        nonlocal seen
        seen += topic == "/heard"
        return None if topic == "/heard" and seen == 2 else words

    moved = only("/step", 20, motion=aside)
    for change in (fewer, moved, only("/about", 1, names_seed="c0ffee")):
        with pytest.raises(AssertionError):
            expect_same(rewritten(recording, tmp_path / "other.mcap", change))
    expect_same(rewritten(recording, tmp_path / "other.mcap", same))


def test_a_message_more_or_fewer_is_found(recording: Path, tmp_path: Path) -> None:
    seen = 0

    def change(topic: str, words: dict[str, Any]) -> dict[str, Any] | None:
        nonlocal seen
        seen += topic == "/sent"
        return None if topic == "/sent" and seen == 2 else words

    with pytest.raises(AssertionError, match="sent"):
        expect_same(rewritten(recording, tmp_path / "fewer.mcap", change))
    silent = only("/step", 1, motion=None)
    with pytest.raises(AssertionError):
        expect_same(rewritten(recording, tmp_path / "silent.mcap", silent))


def test_a_recording_cut_off_is_compared_as_far_as_it_goes(recording: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[: int(0.6 * recording.stat().st_size)])
    found = replay_recording(cut, sender_of_config)
    assert (found.difference, found.cut_off) == ("", True)
    assert 20 < found.steps < 80


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (without_begin, "does not begin with /about"),
        (only("/about", 1, schema=2), "made by a newer modelcast"),
        (only("/about", 1, profile=5), "had the number 5, and has"),
        (only("/about", 1, config=["[air]", "speed = 3"]), "a configuration that this one refuses"),
        (only("/about", 1, names_seed="-1"), "not negative"),
        (only("/step", 2, t_s=-5.0), "a node cannot go through it"),
        (only("/step", 2, motion={}), "/step, message .*motion"),
        (only("/heard", 1, octets="%"), "must be base64"),
        (only("/heard", 1, octets="A" * 20_000), "/heard, message"),
        (only("/beliefs", 1, columns={}), "/beliefs, message"),
    ],
)
def test_what_is_no_recording_is_refused_with_its_place(
    recording: Path, tmp_path: Path, change: Change, told: str
) -> None:
    bent = rewritten(recording, tmp_path / "bent.mcap", change)
    with pytest.raises(DataFormatError, match=told) as caught:
        replay_recording(bent, sender_of_config)
    assert "bent.mcap" in str(caught.value)


def test_a_chunk_that_unpacks_to_more_than_is_held_is_not_unpacked(recording: Path, tmp_path: Path) -> None:
    """Its size is stated twice, by the chunk and by zstd; neither is believed alone."""
    bomb = zstandard.compress(bytes(MOST_CHUNK_OCTETS + 1))
    for stated, told in ((MOST_CHUNK_OCTETS + 1, "more than"), (1000, "does not unpack to its 1000 octets")):
        content = struct.pack("<QQQII", 0, 0, stated, 0, 4) + b"zstd" + struct.pack("<Q", len(bomb)) + bomb
        path = tmp_path / "bomb.mcap"
        head = recording.read_bytes()[:8]
        path.write_bytes(head + struct.pack("<BQ", 6, len(content)) + content)
        with RecordReader(path) as reader, pytest.raises(DataFormatError, match=told):
            list(reader.messages())


def test_a_record_longer_than_is_held_is_not_read(recording: Path, tmp_path: Path) -> None:
    path = tmp_path / "long.mcap"
    with path.open("wb") as file:
        file.write(recording.read_bytes()[:8] + struct.pack("<BQ", 6, MOST_CHUNK_OCTETS + 1))
        file.truncate(MOST_CHUNK_OCTETS + 100)
    with RecordReader(path) as reader, pytest.raises(DataFormatError, match="a record of"):
        list(reader.messages())


def test_the_command_says_identical_or_what_differs(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["replay", str(recording)]) == 0
    assert "80 steps" in capsys.readouterr().out
    bent = rewritten(
        recording, tmp_path / "bent.mcap", only("/heard", 5, outcome="otherwise"), first="/camera"
    )
    assert run(["replay", str(bent)]) == 1
    assert "then a difference: the frame received at" in capsys.readouterr().out
    more = rewritten(recording, tmp_path / "more.mcap", same, first="/camera")
    assert run(["replay", str(more)]) == 0
    assert "1 messages of /camera are none of a recording" in capsys.readouterr().out
    more.write_bytes(more.read_bytes()[:-200])
    assert run(["replay", str(tmp_path / "none.mcap")]) == USAGE
    more.write_text("hello")
    assert run(["replay", str(more)]) == USAGE
    assert "more.mcap: is no MCAP. It must be an MCAP that modelcast node recorded" in capsys.readouterr().err
    assert run(["replay", str(recording), "--on-air", "--times", "0"]) == USAGE
    assert "--times must be positive" in capsys.readouterr().err


def test_a_signed_drive_is_verified_again_without_its_keys(tmp_path: Path) -> None:
    start_s = int(since_2004_s(UTC_S)) - 10
    folder, draw = tmp_path / "keys", random.Random(1)  # noqa: S311 - of a test
    credentials = make_credentials(folder, count=5, start_s=start_s, duration_s=86_400, random=draw.randbytes)
    config = NodeConfig(
        security=Security(mode="signed", folder=str(folder)), pseudonyms=Pseudonyms(least_s=2.0, most_s=3.0)
    )
    (path,) = drive(tmp_path / "written", config=config, credentials=credentials)
    assert not any(one.key.secret.to_bytes(32, "big") in path.read_bytes() for one in credentials.own)
    shutil.rmtree(folder)
    found = replay_recording(path, sender_of_config)
    assert (found.difference, found.steps) == ("", 80)
    assert min(found.heard, found.sent) > 10

"""Claims about what a recording holds, and about what is left of it when something goes wrong."""

import base64
import json
import resource
import shutil
import signal
import subprocess
from collections import Counter
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from modelcast.apps.warnings import Level
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.pcap import frames_of, short_message_of
from modelcast.node.config import NodeConfig, Page, Record
from modelcast.node.inputs.motion import Motion
from modelcast.node.node import NodeState, Warned
from modelcast.node.recording.about import About, about_words, read_about
from modelcast.node.recording.frames import read_heard, read_sent
from modelcast.node.recording.making import about_node, config_of
from modelcast.node.recording.reader import RecordReader
from modelcast.node.recording.recorder import Recorder
from modelcast.node.recording.steps import read_step, step_words
from modelcast.node.recording.topics import TOPICS
from modelcast.station.sender.sender import named_sender
from modelcast.station.station import Station

from .three_cars import UTC_S, Car, drive

ANY = st.floats(allow_nan=True, allow_infinity=True)
NOBODY = Station("mbc").believe(0.0)


@contextmanager
def files_of_at_most(octets: int) -> Generator[None]:
    """A disk on which no file grows beyond so much: writing more is an error of the system."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (octets, before[1]))
    handled = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handled)


def about_of_a_node(config: NodeConfig) -> About:
    origin = Origin(48.0, 11.0)
    return about_node(
        config, named_sender("mbc"), utc_at_zero_s=UTC_S, origin=origin, names_seed=1, station_seed=2
    )


def topics_of(path: Path) -> Counter[str]:
    with RecordReader(path) as reader:
        return Counter(message.topic for message in reader.messages())


def test_the_mcap_library_reads_every_topic_as_json_of_its_schema(recording: Path) -> None:
    with recording.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert {(one.name, one.encoding) for one in summary.schemas.values()} == {
            (topic.schema, "jsonschema") for topic in TOPICS
        }
        seen: Counter[str] = Counter()
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert channel.message_encoding == "json"
            wanted = json.loads(schema.data)["properties"]
            said = json.loads(message.data, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
            assert wanted.keys() <= said.keys()
            seen[channel.topic] += 1
    assert seen == topics_of(recording)
    assert seen["/step"] == seen["/beliefs"] == 80
    assert seen["/page"] == seen["/remotes"] == 16
    assert seen["/location"] == 76  # four steps knew no place
    assert min(seen.values()) >= 1


def test_foxglove_finds_places_where_the_node_was(recording: Path) -> None:
    with recording.open("rb") as file:
        both: dict[int, list[dict[str, object]]] = {}
        for _, channel, message in make_reader(file).iter_messages(topics=["/location", "/step", "/remotes"]):
            said = json.loads(message.data)
            if channel.topic == "/remotes":
                found = json.loads(said["geojson"])
                assert found["type"] == "FeatureCollection"
                for feature in found["features"]:
                    longitude, latitude = feature["geometry"]["coordinates"]
                    assert abs(longitude - 11.0) < 0.1
                    assert abs(latitude - 48.0) < 0.1
            else:
                both.setdefault(message.log_time, []).append(said)
    for t_ns, pair in both.items():
        if len(pair) == 2:
            step, fix = pair
            assert step["motion"]["place_deg"] == [fix["latitude"], fix["longitude"]]  # type: ignore[index]
            assert fix["timestamp"] == {"sec": t_ns // 10**9, "nsec": t_ns % 10**9}
            assert fix["position_covariance_type"] in {1, 3}
            assert len(fix["position_covariance"]) == 9  # type: ignore[arg-type]


def test_the_capture_holds_the_same_frames_at_the_same_times(recording: Path) -> None:
    expected: list[tuple[int, bytes]] = []
    with RecordReader(recording) as reader:
        for message in reader.messages():
            if message.topic == "/heard":
                expected.append((message.t_ns, read_heard(reader.words(message)).arrival.octets))
            elif message.topic == "/sent":
                expected.append((message.t_ns, read_sent(reader.words(message)).octets))
    capture = recording.with_suffix(".pcap").read_bytes()
    assert [(frame.t_ns, short_message_of(frame)) for frame in frames_of(capture)] == expected
    assert len(expected) > 20


@pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
def test_tshark_follows_every_frame_to_the_message(recording: Path) -> None:
    asked = ["-e", "frame.protocols", "-e", "ieee1609dot2.unsecuredData", "-e", "_ws.malformed"]
    ended = subprocess.run(  # noqa: S603 - our own file
        ["tshark", "-r", str(recording.with_suffix(".pcap")), "-T", "fields", "-E", "separator=;", *asked],  # noqa: S607
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = ended.stdout.split()
    with RecordReader(recording) as reader:
        own = [
            read_sent(reader.words(one)).message.hex() for one in reader.messages() if one.topic == "/sent"
        ]
    assert len(lines) == sum(1 for _ in frames_of(recording.with_suffix(".pcap").read_bytes()))
    assert all(line.startswith("eth:ethertype:wsmp:ieee1609dot2;") and line.endswith(";") for line in lines)
    said = [line.split(";")[1] for line in lines]
    assert set(own) <= set(said)


def test_a_file_cut_anywhere_gives_its_whole_chunks(recording: Path, tmp_path: Path) -> None:
    whole, cut = recording.read_bytes(), tmp_path / "cut.mcap"
    with RecordReader(recording) as reader:
        messages = [(one.place.chunk, one.topic, one.data) for one in reader.messages()]
        assert not reader.cut_off
    starts = sorted({one[0] for one in messages})
    assert len(starts) >= 8  # a chunk a second: no more than that is lost
    ends = [*starts[1:], len(whole)]
    for at in range(8, len(whole), 997):
        cut.write_bytes(whole[:at])
        with RecordReader(cut) as reader:
            found = [(one.place.chunk, one.topic, one.data) for one in reader.messages()]
        complete = sum(1 for end in ends if end <= at)
        assert found[: len(messages)] == messages[: len(found)]
        assert {one[0] for one in found} >= set(starts[:complete])


@pytest.mark.slow
def test_at_the_quota_recording_ends_with_a_summary_and_the_node_goes_on(tmp_path: Path) -> None:
    ended: list[str] = []

    def look(cars: list[Car]) -> None:
        assert cars[0].recorder is not None
        ended.append(cars[0].recorder.ended)

    (tmp_path / "older.mcap").write_bytes(bytes(30_000))
    (path,) = drive(tmp_path, steps=200, most_octets=90_000, after=look)
    written = sum(one.stat().st_size for one in tmp_path.iterdir())
    assert 45_000 < written <= 90_000
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == sum(topics_of(path).values())
    assert 10 < topics_of(path)["/step"] < 200
    assert len(ended) == 200


def test_the_quota_counts_what_was_there_before(tmp_path: Path) -> None:
    (tmp_path / "older.pcap").write_bytes(bytes(50_000))
    (path,) = drive(tmp_path, steps=3, most_octets=50_000)
    assert topics_of(path) == Counter()
    assert sum(one.stat().st_size for one in tmp_path.iterdir()) < 60_000


@pytest.mark.slow
def test_on_a_full_disk_whole_chunks_are_left_and_the_node_goes_on(tmp_path: Path) -> None:
    steps: list[str] = []

    def look(cars: list[Car]) -> None:
        assert cars[0].recorder is not None
        steps.append(cars[0].recorder.ended)

    with files_of_at_most(30_000):
        (path,) = drive(tmp_path, steps=200, after=look)
    assert len(steps) == 200
    assert path.stat().st_size <= 30_000
    with RecordReader(path) as reader:
        found = Counter(message.topic for message in reader.messages())
        assert not reader.cut_off
    assert 10 < found["/step"] < 200
    with path.open("rb") as file:  # the library of others reads it to its end too
        assert sum(1 for _ in make_reader(file).iter_messages()) == sum(found.values())
    capture = path.with_suffix(".pcap").read_bytes()
    assert len(list(frames_of(capture))) >= found["/heard"] + found["/sent"] - 30


def test_why_it_ended_is_told(tmp_path: Path) -> None:
    about = about_of_a_node(NodeConfig())
    with Recorder(tmp_path, about, begin_s=0.0, most_octets=1.0) as small:
        pass
    assert small.ended == "the quota is reached"
    with files_of_at_most(100), Recorder(tmp_path, about, begin_s=0.0, most_octets=1e9) as full:
        pass
    assert full.ended == "File too large"
    assert full.path != small.path  # of the same second: neither is written over
    with pytest.raises(OSError, match="exist"):
        Recorder(small.path, about, begin_s=0.0, most_octets=1e9)


def test_who_hands_over_more_than_can_be_written_is_not_held_up(tmp_path: Path) -> None:
    """The thread cannot begin to write before this call gives it time; handing over never waits."""
    about = about_of_a_node(NodeConfig())
    with Recorder(tmp_path, about, begin_s=0.0, most_octets=1e12) as recorder:
        frame = bytes(60 << 20)
        recorder.sent(0.0, frame, frame)
        recorder.sent(0.1, frame, frame)
    assert recorder.ended == "the disk is too slow"
    assert topics_of(recorder.path)["/about"] == 1


def test_neither_token_nor_anything_else_of_the_page_is_written(tmp_path: Path) -> None:
    config = NodeConfig(page=Page(token="sixteen-letters-of-it"), record=Record(folder=str(tmp_path)))  # noqa: S106
    about = about_of_a_node(config)
    assert "sixteen" not in json.dumps(about_words(about))
    assert config_of(about, "x").record == config.record


@given(st.tuples(*[ANY] * 14), st.booleans(), st.integers(0, 2**32 - 1))
def test_a_step_is_read_as_it_was_written_to_the_bit(
    numbers: tuple[float, ...],
    flag: bool,
    name: int,
) -> None:
    one = iter(numbers)
    motion = Motion(
        t_s=1.5, mode="gnss", place_deg=(next(one), next(one)), position_m=(next(one), next(one)),
        speed_mps=next(one), heading_rad=next(one), acceleration_mps2=next(one), yaw_rate_radps=next(one),
        derived=frozenset({"speed_mps"}), covariance_m2=np.array([[next(one), next(one)], [next(one), 0.1]]),
        ellipse_known=flag, age_s=next(one), begins=not flag, altitude_m=next(one), steering_rad=next(one),
        brake=None,
    )  # fmt: skip
    warned = Warned("fcw", 3, Level(1), time_s=1.0, margin_m=2.0, certainty=0.5)
    text = json.dumps(
        step_words(NodeState(1.5, name, motion, around=NOBODY, warnings=(warned,))), allow_nan=False
    )
    found = read_step(json.loads(text))
    assert (found.t_s, found.temporary_id) == (1.5, name)
    assert found.motion is not None
    for field in Motion.__dataclass_fields__:
        was, now = getattr(motion, field), getattr(found.motion, field)
        if isinstance(was, (float, tuple, np.ndarray)):
            was, now = np.array(was), np.array(now)
            assert np.array_equal(was, now, equal_nan=True)
            assert np.array_equal(np.signbit(was[~np.isnan(was)]), np.signbit(now[~np.isnan(was)]))
        else:
            assert was == now


@given(st.floats(0.0, 1e10), st.tuples(*[st.floats(-90.0, 90.0)] * 3), st.integers(0, 2**128 - 1))
def test_what_a_node_is_made_again_from_is_read_as_it_was_written(
    utc_s: float, place: tuple[float, float, float], seed: int
) -> None:
    about = About(
        version="1.0", policy="mbc", profile=7, utc_at_zero_s=utc_s, origin=Origin(*place), names_seed=seed,
        station_seed=seed // 2, config=("[vehicle]", 'name = "ä"'),
    )  # fmt: skip
    assert read_about(json.loads(json.dumps(about_words(about)))) == about


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short recording, for those who bend it."""
    (path,) = drive(tmp_path_factory.mktemp("small"), steps=12)
    return path


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_a_bent_file_is_an_error_or_reads_on(small: Path, data: st.DataObject) -> None:
    """Nothing but the project's own error leaves the reader, whatever a file holds."""
    bent = bytearray(small.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        bent[data.draw(st.integers(8, len(bent) - 1))] = data.draw(st.integers(0, 255))
    path = small.with_name("bent.mcap")
    path.write_bytes(bytes(bent))
    with suppress(DataFormatError), RecordReader(path) as reader:
        for message in reader.messages():
            reader.words(message)


def test_base64_that_is_none_is_named(recording: Path) -> None:
    with RecordReader(recording) as reader:
        words = next(reader.words(one) for one in reader.messages() if one.topic == "/sent")
    assert base64.b64decode(words["message"]) == read_sent(words).message
    with pytest.raises(ValueError, match=r"\$\.message must be base64"):
        read_sent(words | {"message": "ab!"})

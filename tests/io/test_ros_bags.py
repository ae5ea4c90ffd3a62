"""ROS 2 bags: two messages, two kinds of storage, one trip a topic."""

import io
import sqlite3
import struct

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from modelcast.core.exceptions import DataFormatError
from modelcast.io.registry import get_reader
from modelcast.io.trips import read_trips

COUNT = 12


def fixes(made, messages, bag_step_ns=10**8):
    return [
        ("/gps/fix", made.fix_type, made.bag_start_ns + bag_step_ns * at + 10**6, data)
        for at, data in enumerate(messages)
    ]


def poses(made, messages):
    return [
        ("/odom", made.odometry_type, made.bag_start_ns + 10**8 * at, data)
        for at, data in enumerate(messages)
    ]


def trips_of(made, rows, **changed: object):
    return list(read_trips(made.write("b.mcap", made.mcap(rows, **changed))))


def same(one, other):
    for first, second in zip(one, other, strict=True):
        assert first.trip_id.rpartition("b/")[2] == second.trip_id.rpartition("b/")[2]
        for column, again in zip(first.columns().values(), second.columns().values(), strict=True):
            assert column.tobytes() == again.tobytes()
        assert first.start_unix_s == second.start_unix_s


def test_a_topic_is_a_trip_in_si_units(made):
    fix, odometry = read_trips(made.valid("ros2-mcap"))
    assert [fix.trip_id, odometry.trip_id] == ["bag_0/gps/fix", "bag_0/odom"]
    assert fix.start_unix_s == pytest.approx(1_700_000_000.25, abs=1e-6)
    assert np.diff(fix.t_s) == pytest.approx(0.1, abs=1e-9)
    assert fix.origin.latitude_deg == 42.0
    assert odometry.origin is None
    assert odometry.position_m[1].tolist() == [1.0, 2.0]
    assert odometry.speed_mps == pytest.approx(10.0)
    assert odometry.heading_rad == pytest.approx(np.pi / 2 - 0.5)
    assert odometry.yaw_rate_radps == pytest.approx(-0.25), "clockwise"


def test_both_kinds_of_storage_give_the_same_trips(made):
    same(trips_of(made, made.bag_rows()), list(read_trips(made.db3("b.db3", made.bag_rows()))))


def test_the_order_of_octets_changes_nothing(made):
    first = fixes(made, [made.fix(at) for at in range(COUNT)]) + poses(
        made, [made.odometry(at) for at in range(COUNT)]
    )
    high = fixes(made, [made.fix(at, order=">") for at in range(COUNT)])
    high += poses(made, [made.odometry(at, order=">") for at in range(COUNT)])
    same(trips_of(made, first), trips_of(made, high))


@pytest.mark.parametrize(
    ("word", "pack"),
    [
        ("zstd", zstandard.compress),
        ("zstd", lambda data: zstandard.ZstdCompressor(write_content_size=False).compress(data)),
        ("lz4", lz4.frame.compress),
        ("lz4", lambda data: lz4.frame.compress(data, store_size=False)),
    ],
)
def test_packed_chunks_are_read_as_plain_ones(made, word, pack):
    same(trips_of(made, made.bag_rows()), trips_of(made, made.bag_rows(), word=word, pack=pack))


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_what_another_program_wrote_is_read_alike(made, compression, chunked):
    """The writer of mcap, with summaries and indices, in chunks and without."""
    content = io.BytesIO()
    writer = Writer(content, chunk_size=1000, compression=compression, use_chunking=chunked)
    writer.start("ros2")
    channels = {}
    for topic, kind, t_ns, data in made.bag_rows():
        if topic not in channels:
            schema = writer.register_schema(kind, "ros2msg", b"")
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        writer.add_message(channels[topic], log_time=t_ns, publish_time=t_ns, data=data)
    writer.finish()
    same(trips_of(made, made.bag_rows()), list(read_trips(made.write("b.mcap", content.getvalue()))))


@pytest.mark.parametrize("name", ["ros2-mcap", "ros2-db3", "interaction", "ngsim", "ode-bsm", "cv-pilot"])
def test_a_small_limit_takes_more_passes_for_the_same_trips(made, name):
    path = made.valid(name)
    reader = get_reader(name)
    whole = list(reader.read(str(path)))
    parts = list(reader.within(1400).read(str(path)))
    assert {trip.trip_id for trip in whole} == {trip.trip_id for trip in parts}
    by_name = {trip.trip_id: trip for trip in parts}
    same(whole, [by_name[trip.trip_id] for trip in whole])
    with pytest.raises(DataFormatError, match=r"has over .* rows"):
        list(reader.within(200).read(str(path)))


def test_a_missing_stamp_is_the_time_of_storage_less_the_usual_delay(made):
    messages = [made.fix(at, stamp_ns=0 if at in {0, 5} else None) for at in range(COUNT)]
    (trip,) = trips_of(made, fixes(made, messages))
    assert np.diff(trip.t_s) == pytest.approx(0.1, abs=1e-9)
    assert dict(trip.reading.repaired) == {"stamp missing, bag time used": 2}
    (trip,) = trips_of(made, fixes(made, [made.fix(at, stamp_ns=0) for at in range(COUNT)]))
    assert trip.start_unix_s == pytest.approx(1_700_000_000.251, abs=1e-6)
    assert dict(trip.reading.repaired) == {"stamp missing, bag time used": COUNT}


def test_the_clock_of_a_simulation_is_no_unix_time(made):
    (trip,) = trips_of(made, fixes(made, [made.fix(at, stamp_ns=10**8 * (at + 1)) for at in range(COUNT)]))
    assert trip.start_unix_s is None
    assert np.diff(trip.t_s) == pytest.approx(0.1)


def test_messages_without_a_fix_are_counted_and_give_no_origin(made):
    messages = [made.fix(at, status=-1 if at < 2 else 0) for at in range(COUNT)]
    (trip,) = trips_of(made, fixes(made, messages))
    assert dict(trip.reading.skipped) == {"no fix": 2}
    assert trip.position_m[0] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert len(trips_of(made, fixes(made, [made.fix(at, status=-2) for at in range(COUNT)]))[0]) == COUNT


def test_what_nobody_filled_is_missing(made):
    (trip,) = trips_of(
        made, poses(made, [made.odometry(at, twist=False, yaw_rad=0.0) for at in range(COUNT)])
    )
    assert (trip.speed_mps, trip.yaw_rate_radps, trip.heading_rad) == (None, None, None)
    standing = [made.odometry(at, twist=at > 3) for at in range(COUNT)]
    (trip,) = trips_of(made, poses(made, standing))
    assert trip.speed_mps[0] == 0.0


def test_messages_in_another_encoding_are_told(made):
    rows = made.bag_rows()
    path = made.db3("b.db3", rows)
    with sqlite3.connect(path) as base:
        base.execute("UPDATE topics SET serialization_format = 'ros1' WHERE name = '/odom'")
    base.close()
    told = {}
    (trip,) = read_trips(path, on_skipped=told.__setitem__)
    assert trip.trip_id == "b/gps/fix"
    assert told == {"b/odom": "no usable row: 12 in the encoding 'ros1', not cdr"}
    with pytest.raises(DataFormatError, match="is in the encoding 'json', not cdr"):
        trips_of(made, rows, encoding="json")


def test_a_bag_without_such_a_topic_names_those_that_it_has(made):
    with pytest.raises(
        DataFormatError, match=r"holds no topic of NavSatFix or Odometry: '/imu' of 'sensor_msgs/msg/Imu'"
    ):
        trips_of(made, [("/imu", "sensor_msgs/msg/Imu", 1, b"")])
    with pytest.raises(DataFormatError, match="no messages at all"):
        trips_of(made, [])


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "row 1: /gps/fix, sensor_msgs/NavSatFix: begins with nothing"),
        (bytes([0, 3, 0, 0]) + bytes(200), "begins with 00 03 00 00: plain CDR"),
        (bytes([0, 1, 0, 0]) + bytes(20), "has 24 octets, fewer than"),
        (
            bytes([0, 1, 0, 0]) + struct.pack("<iII", 5, 0, 2**31) + bytes(200),
            "a name of 2147483648 octets in",
        ),
        (bytes([0, 1, 0, 0]) + struct.pack("<iII", 5, 10**9, 1) + bytes(200), "1000000000 nanoseconds"),
    ],
)
def test_a_message_that_is_none_is_told_with_its_number(made, data, told):
    with pytest.raises(DataFormatError, match=told):
        trips_of(made, fixes(made, [data]))


def test_a_name_of_a_topic_is_short_and_can_be_shown(made):
    """Each channel's name is kept, and a packed chunk can hold a long one in a few octets."""
    with pytest.raises(DataFormatError, match="a name of 2000 octets"):
        trips_of(made, [("/" + "x" * 1999, made.fix_type, 1, made.fix(0))])
    with pytest.raises(DataFormatError, match=r"row 1: the topic .* has characters that no name has"):
        trips_of(made, [("/a\nb", made.fix_type, 1, made.fix(0))])


def test_a_message_without_its_last_octet_is_refused(made):
    for rows in (fixes(made, [made.fix(0)[:-1]]), poses(made, [made.odometry(0)[:-1]])):
        with pytest.raises(DataFormatError, match="ends 1 octets early"):
            trips_of(made, rows)


def test_a_file_cut_off_is_read_as_far_as_it_goes(made):
    content = made.mcap(made.bag_rows())
    told = {}
    trips = list(read_trips(made.write("b.mcap", content[:-5]), on_skipped=told.__setitem__))
    assert len(trips) == 2
    assert told == {"b": "the end of the file is missing: it was read as far as it goes"}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda chunk: chunk[:16] + struct.pack("<Q", 2**40) + chunk[24:],
            "unpacks to 1099511627776 octets, more than",
        ),
        (lambda chunk: chunk[:24] + struct.pack("<I", 77) + chunk[28:], "its CRC-32 is another one"),
        (
            lambda chunk: chunk[:28] + struct.pack("<I", 3) + b"xor" + chunk[32:],
            "compression 'xor'; zstd, lz4 and none",
        ),
    ],
)
def test_a_chunk_that_is_not_what_it_says_is_refused(made, change, told):
    content = made.mcap(made.bag_rows())
    at = content.index(b"\x06", 30)
    at = next(
        place
        for place in range(8, len(content))
        if content[place] == 6 and content[place + 1 + 8 : place + 25] == bytes(16)
    )
    (length,) = struct.unpack_from("<Q", content, at + 1)
    chunk = change(content[at + 9 : at + 9 + length])
    bent = content[:at] + struct.pack("<BQ", 6, len(chunk)) + chunk + content[at + 9 + length :]
    with pytest.raises(DataFormatError, match=told):
        list(read_trips(made.write("b.mcap", bent)))


@pytest.mark.parametrize(
    ("word", "pack"),
    [("zstd", zstandard.compress), ("lz4", lambda data: lz4.frame.compress(data, store_size=False))],
)
def test_a_chunk_that_unpacks_to_more_than_it_says_is_not_unpacked(made, word, pack):
    bomb = made.mcap(made.bag_rows(), word=word, pack=lambda data: pack(data + bytes(10**6)))
    with pytest.raises(DataFormatError, match="does not unpack to its"):
        list(read_trips(made.write("b.mcap", bomb)))


def test_tables_that_are_none_are_not_asked(made):
    """A view can run for ever."""
    path = made.db3("b.db3", made.bag_rows())
    with sqlite3.connect(path) as base:
        base.execute("ALTER TABLE messages RENAME TO hidden")
        base.execute("CREATE VIEW messages AS SELECT * FROM hidden")
    base.close()
    with pytest.raises(DataFormatError, match="has no plain table 'messages'"):
        list(read_trips(path))


def test_values_of_another_type_are_refused(made):
    path = made.db3("b.db3", made.bag_rows())
    with sqlite3.connect(path) as base:
        base.execute("UPDATE messages SET timestamp = 'soon' WHERE id = 3")
    base.close()
    with pytest.raises(DataFormatError, match="message 3 of '/gps/fix' is stored at 'soon'"):
        list(read_trips(path))


def test_a_journal_beside_the_file_is_told(made):
    path = made.db3("b.db3", made.bag_rows())
    made.write("b.db3-wal", b"x" * 100)
    told = {}
    assert len(list(read_trips(path, on_skipped=told.__setitem__))) == 2
    assert told == {"b": "100 octets of a journal, b.db3-wal, are not read"}


def test_another_file_of_sqlite_is_no_bag(made):
    path = made.folder / "notes.db3"
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE notes(id INTEGER PRIMARY KEY)")
    base.close()
    with pytest.raises(DataFormatError, match="has no plain table 'topics'"):
        list(read_trips(path))

"""Claims: what is newest reaches a reader, a log is wound to any time, a foreign file is refused by line."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.dashboard.document import read_road, read_snapshot, snapshot_text
from modelcast.dashboard.feed import KINDS, LiveFeed
from modelcast.dashboard.log import LONGEST_LINE_BYTES, SnapshotLog, SnapshotLogWriter
from modelcast.dashboard.meter import MessageMeter
from modelcast.dashboard.seen_paths import SeenPaths
from modelcast.dashboard.slot import LatestSlot
from modelcast.dashboard.snapshot import Snapshot

MakeSnapshot = Callable[..., Snapshot]


def test_a_slot_gives_the_newest_of_each_kind_in_the_order_of_kinds() -> None:
    slot = LatestSlot(("road", "snapshot"))
    for text in ("1", "2", "3"):
        slot.put("snapshot", text)
    slot.put("road", "r")

    async def taken() -> list[str]:
        return [await slot.take(), await slot.take()]

    assert asyncio.run(taken()) == ["r", "3"]
    assert slot.replaced == 2


def test_who_waits_for_an_empty_slot_gets_what_comes() -> None:
    async def waited() -> str:
        slot = LatestSlot(KINDS)
        waiting = asyncio.create_task(slot.take())
        await asyncio.sleep(0)
        assert not waiting.done()
        slot.put("snapshot", "now")
        return await waiting

    assert asyncio.run(waited()) == "now"


def test_who_comes_later_gets_the_road_and_the_newest_snapshot(make_snapshot: MakeSnapshot) -> None:
    feed = LiveFeed("test")
    assert not feed.watched
    for step in range(40):
        feed.publish(make_snapshot(0.1 * step))
    slot = LatestSlot(KINDS)
    feed.attach(slot)
    assert feed.watched
    road, newest = asyncio.run(slot.take()), asyncio.run(slot.take())
    assert read_snapshot(newest).t_s == pytest.approx(3.9)
    assert len(read_road(road)) == 4  # the host and three remotes, each on its way
    feed.detach(slot)
    feed.publish(make_snapshot(4.0))
    assert slot.replaced == 0
    assert not feed.watched


def test_a_road_is_given_again_only_where_it_has_grown(make_snapshot: MakeSnapshot) -> None:
    feed, slot = LiveFeed("test"), LatestSlot(KINDS)
    feed.attach(slot)

    def drive() -> None:
        for step in range(100):
            feed.publish(make_snapshot(0.1 * step))

    for _ in range(2):  # what grew in the last two seconds of a drive is given as the next begins
        drive()
    assert asyncio.run(slot.take()).startswith('{"kind":"road"')
    drive()
    assert asyncio.run(slot.take()).startswith('{"kind":"snapshot"')


@pytest.fixture
def log(tmp_path: Path, make_snapshot: MakeSnapshot) -> Path:
    """A log of 50 snapshots, every 0.2 s from 1 s on."""
    path = tmp_path / "drive.jsonl"
    with SnapshotLogWriter(path) as writer:
        for step in range(50):
            writer.write(make_snapshot(1.0 + 0.2 * step))
    return path


def test_a_log_gives_the_snapshot_of_any_time(log: Path) -> None:
    with SnapshotLog(log) as opened:
        assert len(opened) == 50
        assert (opened.span.first_s, opened.span.last_s) == (1.0, pytest.approx(10.8))
        assert opened.span.step_s == pytest.approx(0.2)
        for asked_s, found_s in ((-np.inf, 1.0), (1.19, 1.0), (1.2, 1.2), (5.05, 5.0), (np.inf, 10.8)):
            assert read_snapshot(opened.text_at(asked_s)).t_s == pytest.approx(found_s)


def test_a_log_gives_its_road_and_its_first_snapshot_to_who_comes(log: Path) -> None:
    slot = LatestSlot(KINDS)
    with SnapshotLog(log) as opened:
        opened.attach(slot)
        assert len(read_road(asyncio.run(slot.take()))) == 3
        assert read_snapshot(asyncio.run(slot.take())).t_s == 1.0


def test_a_line_cut_off_at_the_end_is_left_out_and_counted(log: Path) -> None:
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines[:10]) + lines[10][:-40])
    with SnapshotLog(log) as opened:
        assert (len(opened), opened.cut_off) == (10, 1)


def test_a_line_that_is_no_snapshot_is_named(log: Path, make_snapshot: MakeSnapshot) -> None:
    good = snapshot_text(make_snapshot(1.0))
    for wrong, row, what in (
        ("hello\n", 2, "no snapshot and no road"),
        (good + "\n", 2, "after 1.0"),
        ('{"kind":"road","schema":1,"lines_dm":7}\n', 2, "lines_dm"),
        ("x" * (LONGEST_LINE_BYTES + 1) + "\n", 2, "octets"),
    ):
        log.write_text(good + "\n" + wrong)
        with pytest.raises(DataFormatError, match=f"row {row}: .*{what}"):
            SnapshotLog(log)


def test_a_line_that_only_begins_like_a_snapshot_is_named_when_it_is_shown(
    log: Path, make_snapshot: MakeSnapshot
) -> None:
    log.write_text(snapshot_text(make_snapshot(1.0)) + '\n{"kind":"snapshot","t_s":2.0,"schema":1}\n')
    with SnapshotLog(log) as opened, pytest.raises(DataFormatError, match="row 2"):
        opened.text_at(2.0)


def test_an_empty_file_is_no_log(tmp_path: Path) -> None:
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(DataFormatError, match="no snapshot"):
        SnapshotLog(tmp_path / "empty")


def test_a_log_takes_no_snapshot_of_an_earlier_time(tmp_path: Path, make_snapshot: MakeSnapshot) -> None:
    with SnapshotLogWriter(tmp_path / "log") as writer:
        writer.write(make_snapshot(1.0))
        with pytest.raises(ValueError, match="t_s must increase"):
            writer.write(make_snapshot(1.0))


def test_a_way_driven_again_adds_nothing_and_the_other_direction_does() -> None:
    seen = SeenPaths()
    way = [2.0 * step for step in range(50)]
    for vehicle in (1, 2):
        for east_m in way:
            seen.add([(vehicle, east_m, 0.0)])
        seen.add([])
    once = seen.points
    assert len(seen.lines_m()) == 1
    for east_m in reversed(way):
        seen.add([(3, east_m, 0.0)])
    assert len(seen.lines_m()) == 2
    assert seen.points == pytest.approx(2 * once, abs=2)


def test_a_jump_breaks_a_way() -> None:
    seen = SeenPaths()
    for step in range(20):
        seen.add([(1, 5.0 * step + 500.0 * (step >= 10), 0.0)])
    assert [line[:, 0].tolist() for line in seen.lines_m()] == [
        [5.0 * step for step in range(10)],
        [500.0 + 5.0 * step for step in range(10, 20)],
    ]


def test_no_more_points_are_kept_than_there_is_room_for() -> None:
    seen = SeenPaths(most_points=50)
    for step in range(400):
        seen.add([(1, 5.0 * step, 0.0), (2, 5.0 * step, 100.0)])
    assert seen.points <= 50
    assert sum(len(line) for line in seen.lines_m()) == seen.points


def test_rates_are_those_of_the_window_alone() -> None:
    meter = MessageMeter(window_s=1.0)
    for step in range(100):
        meter.sent(0.02 * step, 100)
    assert meter.counters(1.999).sent_per_s == 50.0
    assert meter.counters(1.999).sent_bytes_per_s == 5000.0
    assert meter.counters(2.499).sent_per_s == 25.0
    assert meter.counters(9.0).sent_per_s == 0.0


def test_refused_messages_are_counted_by_reason_and_for_good() -> None:
    meter = MessageMeter()
    meter.refused("late", 2)
    meter.refused("late")
    assert meter.counters(100.0).rejected == {"late": 3}

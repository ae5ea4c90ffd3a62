"""Claims about a recording on the page: any time can be asked for, and errors are those of the truth."""

import asyncio
from pathlib import Path

import numpy as np
import pytest

from modelcast.cli.app import USAGE, run
from modelcast.core.exceptions import DataFormatError
from modelcast.dashboard.document import read_road, read_snapshot
from modelcast.dashboard.feed import KINDS
from modelcast.dashboard.slot import LatestSlot
from modelcast.node.recording.feed import RecordingFeed
from modelcast.node.recording.reader import RecordReader
from modelcast.node.recording.steps import read_step

from .three_cars import drive


def test_any_time_can_be_asked_for(recording: Path) -> None:
    with RecordingFeed(recording) as feed:
        assert (len(feed), feed.name, feed.cut_off) == (16, recording.name, False)
        assert (feed.span.first_s, feed.span.last_s, feed.span.step_s) == (0.0, 7.5, 0.5)
        for asked_s, given_s in ((-9.0, 0.0), (0.49, 0.0), (0.5, 0.5), (3.14, 3.0), (7.5, 7.5), (1e9, 7.5)):
            assert read_snapshot(feed.text_at(asked_s)).t_s == given_s
        with RecordReader(recording) as reader:
            texts = [one.data.decode() for one in reader.messages() if one.topic == "/page"]
        assert [feed.text_at(t_s) for t_s in (0.0, 2.5, 7.5)] == [texts[0], texts[5], texts[15]]


def test_whoever_attaches_gets_the_road_and_the_first(recording: Path) -> None:
    with RecordingFeed(recording) as feed:
        slot = LatestSlot(KINDS)

        async def looked() -> list[str]:
            feed.attach(slot)
            first = [await slot.take(), await slot.take()]
            feed.seek(slot, 4.2)
            feed.detach(slot)
            return [*first, await slot.take()]

        road, first, later = asyncio.run(looked())
        assert sum(len(line) for line in read_road(road)) > 20
        assert (read_snapshot(first).t_s, read_snapshot(later).t_s) == (0.0, 4.0)


def test_errors_are_distances_to_where_the_other_was(two: list[Path]) -> None:
    with RecordReader(two[1]) as reader:
        steps = [read_step(reader.words(one)) for one in reader.messages() if one.topic == "/step"]
    places = {round(one.t_s, 3): one.motion.position_m for one in steps if one.motion is not None}
    name = steps[0].temporary_id
    judged = 0
    with RecordingFeed(two[0], [two[1]]) as feed, RecordingFeed(two[0]) as alone:
        for t_s in np.arange(0.0, 8.0, 0.5).tolist():
            remotes = read_snapshot(feed.text_at(t_s)).remotes
            for row, vehicle in enumerate(remotes.vehicle.tolist()):
                if vehicle != name or t_s not in places:
                    assert np.isnan(remotes.error_m[row])
                    continue
                distance_m = float(np.hypot(*(remotes.position_m[row] - places[t_s])))
                assert remotes.error_m[row] == pytest.approx(distance_m, abs=0.01)
                judged += 1
            assert np.isnan(read_snapshot(alone.text_at(t_s)).remotes.error_m).all()
    assert judged > 10


def test_what_holds_no_snapshot_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = drive(tmp_path, steps=0)
    with pytest.raises(DataFormatError, match="holds no snapshot"):
        RecordingFeed(path)
    assert run(["view", str(path)]) == USAGE
    assert "Record for a second or longer" in capsys.readouterr().err


def test_truths_go_with_a_recording(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log"
    log.write_text("{}\n")
    assert run(["view", str(log), "--truth", str(recording)]) == USAGE
    assert "--truth goes with a recording" in capsys.readouterr().err
    assert run(["view", str(recording), "--truth", str(log)]) == USAGE
    assert "log: is no MCAP" in capsys.readouterr().err

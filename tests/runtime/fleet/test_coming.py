"""Claims: a frame that is taken in ahead of its step changes nothing that is carried, counted or believed."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.runtime.fleet.coming import with_next
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

SETTINGS = NetworkSettings(warm_up_s=0.0)


def traffic(duration_s: float) -> Iterator[FleetFrame]:
    """A short road, which many leave and enter."""
    return run_scenario(Highway(300.0, 130.0, warm_up_s=5.0), np.random.default_rng(2), duration_s=duration_s)


@pytest.fixture(scope="module", name="frames")
def _frames() -> list[FleetFrame]:
    """Some measurements begin anew as well."""
    found = list(traffic(4.0))
    assert len({int(who) for frame in found for who in frame.vehicle_id}) > len(found[0]) + 5
    for step in (11, 12, 25):
        begins = np.zeros(len(found[0]), dtype=np.bool_)
        begins[step::3] = True
        found[step] = replace(found[step], begins=begins)
    return found


def loop_of(first: FleetFrame, sender: str, threads: int) -> FleetLoop:
    sensor = FleetSensor(SensorModel())
    return FleetLoop(first, named_sender(sender), Dsrc(), SETTINGS, seed=4, sensor=sensor, threads=threads)


def told_of(frames: list[FleetFrame], sender: str, threads: int, *, ahead: bool) -> list[Any]:
    """All that a loop says, of every step and at the end."""
    loop = loop_of(frames[0], sender, threads)
    found: list[Any] = []
    for frame, coming in with_next(frames, are_told=ahead):
        received, row = loop.step(frame, coming)
        found += [row, received.message_id, received.receiver, received.t_s, received.rssi_dbm]
    every = np.arange(len(frames[0]))
    return [
        *found,
        *loop.tally,
        *loop.sent,
        *loop.contents,
        *loop.tables,
        loop.tracks.held,
        loop.own_motion(every),
    ]


@pytest.mark.parametrize("sender", ["j2945-mbc", "mbc"])
def test_a_step_that_knows_the_next_frame_carries_the_same(frames: list[FleetFrame], sender: str) -> None:
    wanted = told_of(frames, sender, 1, ahead=False)
    assert loop_of(frames[0], sender, 2).senses_ahead
    for ahead in (False, True):
        for one, other in zip(wanted, told_of(frames, sender, 2, ahead=ahead), strict=True):
            np.testing.assert_array_equal(one, other)


def test_another_frame_than_was_to_come_is_refused(frames: list[FleetFrame]) -> None:
    loop = loop_of(frames[0], "mbc", 2)
    loop.step(frames[0], frames[1])
    with pytest.raises(ValueError, match="was to come"):
        loop.step(replace(frames[1], speed_mps=frames[1].speed_mps + 1.0))


class Counting(AbstractObserver):
    """How many frames the run had taken at each of its steps."""

    def __init__(self, taken: list[FleetFrame]) -> None:
        self.taken, self.found = taken, list[int]()

    def before(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Look at nothing."""

    def after(self, loop: FleetLoop, frame: FleetFrame) -> None:
        """Count the frames."""
        del loop, frame
        self.found.append(len(self.taken))


@pytest.mark.parametrize("is_seen", [False, True])
def test_where_somebody_looks_on_frames_are_taken_as_they_are_due(*, is_seen: bool) -> None:
    taken = list[FleetFrame]()

    def frames() -> Iterator[FleetFrame]:
        for frame in traffic(1.0):
            taken.append(frame)
            yield frame

    steps = list[int]()
    observer = Counting(taken)
    run_network(
        frames(), named_sender("mbc"), Dsrc(), SETTINGS, seed=1, threads=2,
        observer=observer if is_seen else None, progress=lambda _: steps.append(len(taken)),
    )  # fmt: skip
    due = list(range(1, 11))
    assert steps == (due if is_seen else [*due[1:], 10])
    assert observer.found == (due if is_seen else [])


def test_every_frame_comes_with_the_one_after_it(frames: list[FleetFrame]) -> None:
    few = frames[:3]
    assert [(a.t_s, b and b.t_s) for a, b in with_next(few, are_told=True)] == [
        (0.0, 0.1),
        (0.1, 0.2),
        (0.2, None),
    ]
    assert [b for _, b in with_next(few, are_told=False)] == [None] * 3
    assert list(with_next([], are_told=True)) == []

"""Claims about kinds of road users in snapshots."""

import json
from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.kinds import Kind
from modelcast.dashboard.demo import DemoDrive
from modelcast.dashboard.document import read_snapshot, snapshot_text
from modelcast.dashboard.snapshot import Snapshot
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.peopled_grid import PeopledGrid


@pytest.fixture(scope="module", name="snapshot")
def _snapshot() -> Snapshot:
    """A town with people after 4 s, as a host knows it that hears everything."""
    town = PeopledGrid(Grid(2, 2, 15.0, junctions="priority", warm_up_s=5.0), 6, 3)
    *_, last = DemoDrive(town, 0.0, bank="cv", sensor="ideal").snapshots(4.0)
    return last


def test_a_snapshot_tells_pedestrians_and_cyclists_and_keeps_them(snapshot: Snapshot):
    kinds = snapshot.remotes.kind
    assert kinds is not None
    counts = [int((kinds == kind).sum()) for kind in (Kind.PEDESTRIAN, Kind.CYCLIST)]
    assert counts == [6, 3]
    again = read_snapshot(snapshot_text(snapshot)).remotes.kind
    assert again is not None
    np.testing.assert_array_equal(again, kinds)


def test_a_log_without_kinds_opens(snapshot: Snapshot):
    plain = replace(snapshot, remotes=replace(snapshot.remotes, kind=None))
    assert "kind" not in json.loads(snapshot_text(plain))["remotes"]
    assert read_snapshot(snapshot_text(plain)).remotes.kind is None


@pytest.mark.parametrize("wrong", [[0], [9] * 12, ["cyclist"] * 12, [None] * 12, 1])
def test_kinds_that_are_none_are_refused(snapshot: Snapshot, wrong: object):
    document = json.loads(snapshot_text(snapshot))
    document["remotes"]["kind"] = wrong
    with pytest.raises(ValueError, match="kind"):
        read_snapshot(json.dumps(document))


def test_kinds_of_another_number_are_refused(snapshot: Snapshot):
    with pytest.raises(ValueError, match="kind"):
        replace(snapshot.remotes, kind=np.zeros(1, dtype=np.int64))

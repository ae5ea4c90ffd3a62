"""Claims: the drive to try the page with is what its stations heard, the same for the same seed."""

from itertools import islice

import numpy as np
import pytest

from modelcast.dashboard.demo import DemoDrive
from modelcast.dashboard.document import read_snapshot, snapshot_text
from modelcast.dashboard.snapshot import Snapshot
from modelcast.world.scenario.grid import Grid

SMALL = Grid(columns=2, rows=2, density_per_km=12.0, junctions="priority")
LOSS_SPREAD = 0.05
"""Of the share lost over some two thousand messages: four standard deviations of 0.3 are 0.04."""


@pytest.fixture(scope="module")
def drive() -> list[Snapshot]:
    """Sixty seconds of a small town at a loss of 0.3."""
    return list(DemoDrive(SMALL, 0.3, bank="ctra+cv", sensor="ideal").snapshots(60.0))


@pytest.mark.slow
def test_the_same_seed_gives_the_same_texts(drive: list[Snapshot]) -> None:
    again = islice(DemoDrive(SMALL, 0.3, bank="ctra+cv", sensor="ideal").snapshots(60.0), 40)
    assert [snapshot_text(one) for one in again] == [snapshot_text(one) for one in drive[:40]]


@pytest.mark.slow
def test_every_text_is_read_back(drive: list[Snapshot]) -> None:
    for one in drive[::50]:
        assert snapshot_text(read_snapshot(snapshot_text(one))) == snapshot_text(one)


def test_the_share_that_is_lost_is_the_channel_s(drive: list[Snapshot]) -> None:
    last = drive[-1]
    assert last.counters.loss_ratio == pytest.approx(0.3, abs=LOSS_SPREAD)
    assert np.nanmean(last.remotes.loss_ratio) == pytest.approx(0.3, abs=2 * LOSS_SPREAD)


def test_messages_shown_are_those_that_are_counted(drive: list[Snapshot]) -> None:
    """Over a window of two seconds both are the same messages, whatever was lost."""
    at = 400
    heard = drive[at].remotes.messages.sum() - drive[at - 20].remotes.messages.sum()
    assert drive[at].remotes.vehicle.size == drive[at - 20].remotes.vehicle.size
    assert drive[at].counters.received_per_s == pytest.approx(heard / 2.0, rel=0.15)


def test_without_loss_and_noise_the_error_is_that_of_the_threshold(drive: list[Snapshot]) -> None:
    lossless = list(DemoDrive(SMALL, 0.0, bank="ctra+cv", sensor="ideal").snapshots(20.0))
    errors_m = np.concatenate([one.remotes.error_m for one in lossless[50:]])
    assert lossless[-1].counters.loss_ratio == 0.0
    assert np.quantile(errors_m, 0.9) < 0.25
    assert np.quantile(np.concatenate([one.remotes.error_m for one in drive[50:]]), 0.99) > 0.25


def test_the_host_is_no_remote_of_its_own_and_names_are_of_the_bank(drive: list[Snapshot]) -> None:
    for one in drive[::100]:
        assert one.host is not None
        assert one.host.temporary_id not in one.remotes.vehicle
    *own, of_people = drive[-1].remotes.names  # the last is what people's plain messages are coasted by
    assert (own, of_people) == (["Part I", "ctra", "cv"], "stop-and-go")

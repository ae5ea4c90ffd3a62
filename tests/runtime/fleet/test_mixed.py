"""Claims about fleets in which vehicles send by different senders and read messages in different ways."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import FloatArray
from modelcast.runtime.fleet.arrays import TRACK_MESSAGE
from modelcast.runtime.fleet.bins_kernels import bin_of
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.mix import Draw, Mix
from modelcast.runtime.fleet.mixed import pairing
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel

SETTINGS = NetworkSettings(warm_up_s=1.0)
HALF_RADIO = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.full((2, 20), 0.5), bin_m=500.0))
MASK = (1 << at.SENDER_BITS) - 1


@pytest.fixture(scope="module")
def frames() -> list[FleetFrame]:
    road = Highway(500.0, 40.0, warm_up_s=20.0)
    return list(run_scenario(road, np.random.default_rng(1), duration_s=6.0))


def run(frames: list[FleetFrame], who: Sender | Mix, threads: int = 1) -> NetworkRun:
    return run_network(frames, who, Dsrc(), SETTINGS, seed=3, threads=threads)


def counts(one: NetworkRun) -> list[FloatArray]:
    found = (*one.tally, one.outcomes, one.series, one.recent, one.sent.causes, one.sent.total)
    return [np.asarray(column, dtype=np.float64) for column in found]


@pytest.mark.parametrize("name", ["baseline", "mbc", "j2945", "j2945-mbc", "cam"])
def test_two_groups_of_one_sender_are_that_sender(frames: list[FleetFrame], name: str) -> None:
    """Whoever is in which group sends the same messages, and hosts count the same errors."""
    sender = named_sender(name)
    alone, split = run(frames, sender), run(frames, Mix((sender, sender), (0.4, 0.6)))
    for one, other in zip(counts(alone), counts(split), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)  # sums of floats in another order
    assert [group.name for group in split.groups] == [name, name]
    assert sum(group.vehicle_s for group in split.groups) == pytest.approx(alone.vehicle_s)
    share = split.groups[0].sent.total[at.MESSAGES] / alone.sent.total[at.MESSAGES]
    assert 0.3 < share < 0.5
    assert split.mixed.error.sum(axis=0).tolist() == alone.tally.error.tolist()
    assert (split.mixed.pairs[[pairing(g, Reading.MODEL) for g in (0, 1)]].sum(axis=1) > 0).all()
    assert split.mixed.pairs[[pairing(g, Reading.FREE) for g in (0, 1)]].sum() == 0
    assert alone.mixed.error.size == 0


def test_the_number_of_threads_changes_nothing(frames: list[FleetFrame]) -> None:
    mix = Mix((named_sender("j2945"), named_sender("j2945-mbc")), (0.5, 0.5), readings=(0.3, 0.3, 0.4))
    one, two = run(frames, mix), run(frames, mix, threads=2)
    for a, b in zip((*counts(one), *one.mixed), (*counts(two), *two.mixed), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("names", [("baseline", "mbc"), ("j2945", "j2945-mbc"), ("cam", "free")])
def test_what_is_counted_is_what_hosts_believe_set_against_the_truth(
    frames: list[FleetFrame], names: tuple[str, str]
) -> None:
    """Pair by pair, from the beliefs of each, with losses."""
    mix = Mix(tuple(named_sender(name) for name in names), (0.5, 0.5), readings=(0.3, 0.3, 0.4))
    loop = FleetLoop(frames[0], mix, HALF_RADIO, SETTINGS, seed=5)
    for frame in frames[:-1]:
        loop.step(frame)
    loop.forget_counts()
    last, here = frames[-1], np.flatnonzero(frames[-1].active)
    stayed = here[frames[-2].active[here] & (frames[-2].vehicle_id[here] == last.vehicle_id[here])]
    assert stayed.size == here.size > 10
    host, remote = (one.ravel() for one in np.meshgrid(here, here, indexing="ij"))
    host, remote = host[host != remote], remote[host != remote]
    believed = loop.believed(host, remote)
    expected = np.zeros_like(loop.mixed.error)
    pairs = np.zeros_like(loop.mixed.pairs)
    for k, (h, r) in enumerate(zip(host.tolist(), remote.tolist(), strict=True)):
        which = pairing(int(loop.group[r]), Reading(int(loop.reading[h])))
        away = int(np.hypot(*(last.position_m[h] - last.position_m[r])) / SETTINGS.distance_bin_m)
        if away >= SETTINGS.distances:
            continue
        pairs[which, away] += 1
        if believed.held[k]:
            error_m = float(np.hypot(*(believed.motion[k, :2] - last.position_m[r])))
            expected[which, away, bin_of(error_m)] += 1
    loop.step(last)
    assert loop.mixed.pairs.tolist() == pairs.tolist()
    assert loop.mixed.held.tolist() == expected.sum(axis=2).tolist()
    assert (expected.sum(axis=(1, 2)) > 0).all()
    assert np.abs(loop.mixed.error - expected).sum() <= 4  # an error on the edge of a bin


def test_shares_are_met_from_the_first_frame_on_and_nested() -> None:
    ids, new = np.arange(100, 140), np.ones(40, dtype=np.bool_)
    sender = named_sender("bsm-10hz")
    before = np.zeros(40, dtype=np.bool_)
    for share in (0.25, 0.5, 0.75):
        draw = Draw(Mix((sender, sender), (share, 1.0 - share), readings=(0.25, 0.25, 0.5)), seed=7)
        group, reading = np.zeros(40, dtype=np.int64), np.zeros(40, dtype=np.int64)
        draw.place(ids, new, group, reading)
        assert (group == 0).sum() == 40 * share
        assert [int((reading == one).sum()) for one in Reading] == [10, 10, 20]
        assert (before <= (group == 0)).all()
        before = group == 0
        again = group.copy()
        draw.place(ids[::-1].copy(), new, again, reading)
        assert again.tolist() == group[::-1].tolist()  # whoever comes back in another slot stays what it is


def test_newcomers_one_by_one_meet_the_share_in_the_long_run() -> None:
    sender = named_sender("bsm-10hz")
    draw = Draw(Mix((sender, sender), (0.3, 0.7)), seed=7)
    group, reading = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
    drawn = list[int]()
    for one in range(1000):
        draw.place(np.array([one]), np.ones(1, dtype=np.bool_), group, reading)
        drawn.append(int(group[0]))
    assert np.mean(drawn) == pytest.approx(0.7, abs=0.05)  # 3.5 standard deviations


def test_who_knows_no_model_passes_identifications_over() -> None:
    road = Highway(500.0, 40.0, warm_up_s=20.0)
    frames = list(run_scenario(road, np.random.default_rng(2), duration_s=12.0))
    sender = named_sender("mbc", bank=named_bank("ctra+gp-intercept+cv").bank, threshold_m=0.05)
    mix, sensor = Mix((sender,), readings=(0.3, 0.3, 0.4)), FleetSensor(SensorModel())
    loop = FleetLoop(frames[0], mix, HALF_RADIO, SETTINGS, seed=5, sensor=sensor)
    held = dict.fromkeys(Reading, 0)
    for frame in frames:
        loop.step(frame)
        for host in np.flatnonzero(frame.active).tolist():
            messages = loop.tracks.held[host, :, TRACK_MESSAGE]
            ids = messages[messages >= 0].astype(np.int64)
            rows = loop.contents.rows[ids & MASK, (ids >> at.SENDER_BITS) % at.MESSAGES_KEPT]
            named = (rows[:, at.CONTENT_KIND] == IDENTIFICATION).sum()
            held[Reading(int(loop.reading[host]))] += int(named)
    assert held[Reading.MODEL] > 0
    assert held[Reading.LEGACY] == held[Reading.FREE] == 0


def test_legacy_receivers_of_constant_velocity_believe_what_model_receivers_do(
    frames: list[FleetFrame],
) -> None:
    sender = named_sender("bsm-10hz")
    model, legacy = run(frames, sender), run(frames, Mix((sender,), readings=(1.0, 0.0, 0.0)))
    np.testing.assert_array_equal(model.tally.held, legacy.tally.held)
    moved = np.abs(np.cumsum(model.tally.error - legacy.tally.error, axis=1)).sum()
    assert moved <= 1e-3 * model.tally.held.sum()  # errors on the edge of a bin


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"shares": (0.5, 0.4)}, "shares must be shares that sum to 1"),
        ({"shares": (1.5, -0.5)}, "shares must be shares that sum to 1"),
        ({"shares": (1.0,)}, "shares must be one a sender, got 1 of 2"),
        ({"senders": (), "shares": ()}, "shares must be one a sender, got 0 of 0"),
        ({"readings": (0.5, 0.5)}, "readings must be legacy, free and model"),
        ({"readings": (0.5, 0.5, 0.5)}, "readings must be shares that sum to 1"),
    ],
)
def test_shares_that_are_none_are_refused(changes: dict[str, object], text: str) -> None:
    sender = named_sender("bsm-10hz")
    mix = Mix((sender, sender), (0.5, 0.5))
    with pytest.raises(ValueError, match=text):
        replace(mix, **changes)  # type: ignore[arg-type]

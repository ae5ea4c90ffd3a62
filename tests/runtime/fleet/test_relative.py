"""Claims about errors relative to where hosts take themselves to be, and about which hosts count."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.members import ReadyBank
from modelcast.runtime.fleet.arrays import Tally
from modelcast.runtime.fleet.belief_words_kernels import Tracking, found_bins, gone_words
from modelcast.runtime.fleet.bins_kernels import BINS, bin_of
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.study.network.measure import binned_quantiles
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import IDEAL, SensorModel

ALL_ARRIVE = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.ones((2, 20)), bin_m=500.0))
SETTINGS = NetworkSettings(warm_up_s=2.0, start_spread_s=0.0)
FIXED_M = replace(IDEAL, slow_position_noise_m=3.0, slow_correlation_s=1e12)
"""Every vehicle is wrong by some metres, for good."""

STATED_M = 0.02
"""A message states its place in steps of 1e-7 degree, 1.1 cm; a bias moves it to other steps."""

BIN = 2.0 ** (1.0 / 32.0)
"""Ratio of the edges of a bin, at most."""


@pytest.fixture(scope="module")
def frames() -> list[FleetFrame]:
    """A ring: nobody comes or leaves."""
    road = Highway(600.0, 50.0, form="ring", warm_up_s=10.0)
    return list(run_scenario(road, np.random.default_rng(1), duration_s=5.0))


def run(frames: list[FleetFrame], model: SensorModel, policy: str = "bsm-10hz", **given: Any) -> Tally:
    return run_network(
        frames, named_sender(policy), ALL_ARRIVE, given.get("settings", SETTINGS), seed=2,
        sensor=FleetSensor(model),
    ).tally  # fmt: skip


def quantiles(counts: IntArray) -> FloatArray:
    return np.array(binned_quantiles(counts.sum(axis=0), (0.1, 0.5, 0.9, 0.99)))


@pytest.mark.parametrize("policy", ["bsm-10hz", "mbc"])
def test_with_a_sensor_that_is_right_both_errors_are_one(frames: list[FleetFrame], policy: str) -> None:
    tally = run(frames, IDEAL, policy)
    assert tally.relative.sum(axis=1).tolist() == tally.error.sum(axis=1).tolist()
    assert quantiles(tally.relative) == pytest.approx(quantiles(tally.error), abs=3e-4)


def test_a_bias_that_all_share_moves_every_place_and_no_relative_one(frames: list[FleetFrame]) -> None:
    """All shared and no white noise: as relative as without a bias, and as wrong as the one bias is long."""
    right = run(frames, IDEAL)
    shared = run(frames, replace(FIXED_M, shared_slow_ratio=1.0))
    assert quantiles(shared.relative) == pytest.approx(quantiles(right.relative), abs=STATED_M, rel=BIN - 1.0)
    assert np.ptp(quantiles(shared.error)) < 0.5 < quantiles(shared.error)[0]


def test_a_bias_of_each_ones_own_is_twice_as_much_variance_in_relative_places(
    frames: list[FleetFrame],
) -> None:
    """Two independent errors add: the median of a relative one is that of a place times the root of 2."""
    own = run(frames, FIXED_M)
    ratio = quantiles(own.relative)[1] / quantiles(own.error)[1]
    assert ratio == pytest.approx(np.sqrt(2.0), rel=0.2)


MIX = Mix((named_sender("bsm-10hz"), named_sender("mbc")), (0.5, 0.5), readings=(0.3, 0.3, 0.4))


@pytest.mark.parametrize("who", [named_sender("mbc"), MIX], ids=["mbc", "mixed"])
def test_relative_errors_are_those_of_all_that_hosts_believe(
    frames: list[FleetFrame], who: Sender | Mix
) -> None:
    """Pair by pair, each as its host reads: believed place less own place, against the same of the truth."""
    settings = replace(SETTINGS, warm_up_s=0.0)
    half = TabulatedRadio(ReceptionTable(np.array([0.0, 1e6]), np.full((2, 20), 0.3), bin_m=500.0))
    loop = FleetLoop(frames[0], who, half, settings, seed=2, sensor=FleetSensor(FIXED_M))
    for frame in frames[:30]:
        loop.step(frame)
    loop.forget_counts()
    every = np.arange(len(frames[0]))
    host, remote = (grid.ravel() for grid in np.meshgrid(every, every, indexing="ij"))
    host, remote = host[host != remote], remote[host != remote]
    believed = loop.believed(host, remote)
    loop.step(frames[30])
    truth_m, own_m = frames[30].position_m, loop.own_motion(every)[:, :2]
    away_m = np.linalg.norm(truth_m[remote] - truth_m[host], axis=1)
    near = believed.held & (away_m < 300.0)
    wrong = (believed.motion[:, :2] - own_m[host]) - (truth_m[remote] - truth_m[host])
    found = np.linalg.norm(wrong[near], axis=1)
    counts: IntArray = np.bincount([bin_of(value) for value in found], minlength=BINS)
    assert found.size > 100
    assert np.abs(np.cumsum(loop.tally.relative.sum(axis=0)) - np.cumsum(counts)).max() <= 0.02 * found.size


def test_a_mixed_fleet_counts_relative_errors_of_every_pairing(frames: list[FleetFrame]) -> None:
    sensor = FleetSensor(replace(FIXED_M, shared_slow_ratio=1.0))
    found = run_network(frames, MIX, ALL_ARRIVE, SETTINGS, seed=2, sensor=sensor)
    assert found.tally.relative.sum(axis=1).tolist() == found.tally.held.tolist()
    right = run_network(frames, MIX, ALL_ARRIVE, SETTINGS, seed=2, sensor=FleetSensor(IDEAL))
    assert quantiles(found.tally.relative)[:2] == pytest.approx(
        quantiles(right.tally.relative)[:2], abs=STATED_M, rel=BIN - 1.0
    )


@pytest.mark.parametrize("who", [named_sender("bsm-10hz"), named_sender("mbc"), MIX])
def test_hosts_on_two_halves_of_the_road_count_what_all_of_them_do(
    frames: list[FleetFrame], who: Sender | Mix
) -> None:
    """What is counted is no cause of what happens: two windows that part the hosts add up to the whole."""
    everywhere, western, eastern = None, (-1e6, 0.0), (np.nextafter(0.0, 1.0), 1e6)
    whole, west, east = (
        run_network(
            frames,
            who,
            Dsrc(),
            replace(SETTINGS, counted_m=window),
            seed=2,
            sensor=FleetSensor(SensorModel()),
        )
        for window in (everywhere, western, eastern)
    )
    for name in ("error", "relative", "age", "gap", "held", "pairs"):
        parts = [getattr(one.tally, name) for one in (west, east)]
        np.testing.assert_array_equal(sum(parts), getattr(whole.tally, name), err_msg=name)
        assert all(part.sum() > 0 for part in parts)
    busy = [one.busy_ratio for one in (west, east)]
    assert min(busy) < whole.busy_ratio < max(busy)


def test_an_error_of_an_earlier_step_is_worked_out_anew() -> None:
    """Another thread may have written one of the two words alone."""
    now = Tracking(
        ReadyBank.of(BASELINE_BANK, 0.1).members, 0.7, 7, 5.0, 25.0, (2, 6), np.zeros(1, dtype=np.int64),
        np.zeros((1, 2)), np.zeros((1, 2)), np.ones(1, dtype=np.bool_), np.zeros(1, dtype=np.bool_), np.inf,
    )  # fmt: skip
    belief, error = gone_words(now)
    _, before = gone_words(now._replace(step=6))
    assert found_bins(now, belief, error)
    assert not found_bins(now, belief, before)
    assert not found_bins(now, -1, error)


def test_a_window_that_does_not_rise_is_refused() -> None:
    with pytest.raises(ValueError, match="counted_m must rise"):
        NetworkSettings(counted_m=(5.0, 5.0))

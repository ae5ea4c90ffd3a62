"""Claims: how many threads share the work changes nothing, and parts count every pair once."""

from typing import Any

import numpy as np
import pytest

from modelcast.channel.cells_kernels import build_cells
from modelcast.channel.dsrc import Dsrc
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.fleet.tracking_kernels import count_pairs
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel


def _numbers(threads: int) -> list[Any]:
    """All that one run counts."""
    road = Highway(500.0, 200.0, warm_up_s=2.0)
    run = run_network(
        run_scenario(road, np.random.default_rng(0), duration_s=2.0),
        named_sender("j2945-mbc"),
        Dsrc(),
        NetworkSettings(warm_up_s=0.0),
        seed=0,
        sensor=FleetSensor(SensorModel()),
        threads=threads,
    )
    return [*run.tally, *run.sent, run.series]


@pytest.mark.parametrize("threads", [2, 3])
def test_the_counts_are_equal_bit_for_bit_whatever_the_number_of_threads(threads: int) -> None:
    alone, shared = _numbers(1), _numbers(threads)
    for one, other in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_every_pair_is_counted_once_for_each_of_the_two_that_counts_as_host(share: float) -> None:
    rng = np.random.default_rng(1)
    place_m, counted = rng.uniform(0.0, 900.0, (120, 2)), rng.random(120) < share
    place_m[::7] = np.nan
    pairs, parts = np.zeros(10, dtype=np.int64), 8
    for part in range(parts):
        count_pairs(build_cells(place_m, 250.0), (part, parts), 25.0, counted, pairs)
    away_m = np.linalg.norm(place_m[:, None] - place_m[None, :], axis=2)
    away_m[np.diag_indices(len(place_m))] = np.nan
    away_m[~counted] = np.nan
    wanted, _ = np.histogram(away_m, np.arange(11) * 25.0)
    np.testing.assert_array_equal(pairs, wanted)

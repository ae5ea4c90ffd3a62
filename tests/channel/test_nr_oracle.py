"""The compiled NR radio against the same rules in plain Python (`nr_oracle`): the same frames, one by one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from tests.channel.nr_oracle import Oracle

from modelcast.channel.nr import Nr
from modelcast.channel.nr_parameters import NrParameters
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import Grant, Transmissions

STEEP = Propagation(LogDistance(3.0), None, None)
"""Reservations are heard over 110 m, frames over 200 m."""

SECONDS = 0.7
LOUDNESS_DB = 1e-5
"""Exponentials of the kernels are good to this."""

RADIOS: dict[str, dict[str, Any]] = {
    "periodic": {"keep_ratio": 0.4},
    "dynamic": {"dynamic": True},
    "apart": {"overlapping": False, "keep_ratio": 0.0, "reselect_after": 2, "antenna_gain_db": 3.0},
    "twice": {"transmissions": 2, "keep_ratio": 0.2},
    "thrice": {"transmissions": 3, "spacing_khz": 30, "bandwidth_mhz": 20, "longest_ms": 300},
    "often": {"interval_ms": 20, "last_ms": 90.0, "keep_ratio": 0.4},
    "short": {"spacing_khz": 30, "interval_ms": 50, "last_ms": 20.0, "mcs": 16, "longest_ms": 100},
}


def traffic(seed: int, vehicles: int, messages: int, largest: int) -> tuple[Transmissions, np.ndarray]:
    """Messages at random times, in part with wishes, and places on 300 m of road."""
    rng = np.random.default_rng(seed)
    ready_s = np.sort(rng.uniform(0.0, SECONDS - 0.2, messages))
    next_s = np.where(rng.random(messages) < 0.5, np.inf, ready_s + rng.uniform(0.001, 0.4, messages))
    sent = Transmissions(
        rng.integers(0, vehicles, messages),
        ready_s,
        size_bytes=rng.integers(20, largest, messages),
        power_dbm=rng.uniform(13.0, 23.0, messages),
        message_id=np.arange(messages, dtype=np.int64),
        next_s=next_s,
        grant=rng.choice([int(one) for one in Grant], messages, p=[0.7, 0.2, 0.1]),
    )
    return sent, np.column_stack([rng.uniform(0.0, 300.0, vehicles), rng.uniform(0.0, 20.0, vehicles)])


@pytest.mark.parametrize("changes", RADIOS.values(), ids=RADIOS.keys())
@settings(max_examples=2, phases=(Phase.explicit, Phase.generate))  # a whole run has no smaller one
@given(seed=st.integers(0, 10_000), vehicles=st.integers(3, 14), crowd=st.booleans())
def test_frames_are_those_of_the_slow_radio(
    changes: dict[str, Any], seed: int, vehicles: int, crowd: bool
) -> None:
    """Receptions with their times and powers, outcomes by distance, what expired, and the random numbers."""
    parameters = replace(NrParameters(bins=40), **changes)
    radio = Nr(parameters, STEEP)
    sent, place_m = traffic(seed, vehicles, 180 if crowd else 50, min(parameters.largest_bytes, 500))
    state = radio.init(vehicles, np.random.default_rng(seed))
    heard, state = radio.step(state, sent, place_m, SECONDS)
    slow = Oracle(radio, place_m, np.random.default_rng(seed))
    slow.run(sent, round(SECONDS * 1e3 * parameters.slots_a_ms))
    keys = list(zip(heard.message_id.tolist(), heard.receiver.tolist(), strict=True))
    assert sorted(keys) == sorted((number, j) for number, j, *_ in slow.received)
    told = {(number, j): (t_s, rssi_dbm) for number, j, t_s, rssi_dbm in slow.received}
    assert heard.t_s == pytest.approx([told[key][0] for key in keys])
    assert heard.rssi_dbm == pytest.approx([told[key][1] for key in keys], abs=LOUDNESS_DB)
    assert heard.outcomes.tolist() == slow.outcomes.tolist()
    assert heard.expired.tolist() == slow.expired
    assert state.random[0] == slow.random[0]

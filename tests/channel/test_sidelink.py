"""Claims about LTE-V2X mode 4 alone; what holds of every radio is in `test_radio_conformance.py`."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.channel.error_models import ThresholdErrorModel
from modelcast.channel.in_band_emission import in_band_emission
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import Receptions, Transmissions
from modelcast.channel.sidelink import Sidelink, SidelinkState
from modelcast.channel.sidelink_grant_kernels import BAND
from modelcast.channel.sidelink_parameters import SidelinkParameters

CLEAR = Propagation(LogDistance(2.0), None, None)


def plain(**changes: Any) -> Sidelink:
    return Sidelink(replace(SidelinkParameters(), **changes), CLEAR, ThresholdErrorModel(5.0))


def batch(sender: list[int], ready_s: list[float], *, size: int = 80, power: float = 23.0) -> Transmissions:
    number = len(sender)
    return Transmissions(
        np.array(sender, dtype=np.int64),
        np.array(ready_s),
        size_bytes=np.full(number, size, dtype=np.int64),
        power_dbm=np.full(number, power),
        message_id=100 + np.arange(number, dtype=np.int64),
    )


def line(*east_m: float) -> np.ndarray:
    return np.column_stack([np.array(east_m), np.zeros(len(east_m))])


def periodic(
    radio: Sidelink, place_m: np.ndarray, seconds: float, senders: int, seed: int = 0
) -> tuple[list[Receptions], SidelinkState]:
    """Everybody of the first ``senders`` sends every 100 ms at a phase of his own."""
    rng = np.random.default_rng(seed)
    phase_s = np.sort(rng.uniform(0.0, 0.1, senders))
    state = radio.init(place_m.shape[0], rng)
    heard: list[Receptions] = []
    for k in range(round(seconds * 10)):
        case = batch(list(range(senders)), (0.1 * k + phase_s).tolist())
        one, state = radio.step(state, case, place_m, round(0.1 * (k + 1), 3))
        heard.append(one)
    return heard, state


def test_a_message_goes_out_within_its_selection_window_on_a_whole_subframe() -> None:
    radio = plain(first_ms=4, last_ms=20)
    delays_ms = set()
    for seed in range(60):
        state = radio.init(2, np.random.default_rng(seed))
        heard, _ = radio.step(state, batch([0], [0.0105]), line(0.0, 50.0), 0.1)
        (delay_ms,) = 1e3 * heard.t_s - 10 - 1
        assert delay_ms == pytest.approx(round(delay_ms), abs=1e-6)
        delays_ms.add(round(delay_ms))
    assert min(delays_ms) >= 4
    assert max(delays_ms) <= 20
    assert len(delays_ms) > 10


def test_a_resource_is_kept_for_the_counter_and_then_left() -> None:
    """With keep ratio 0 a run of equal phases lasts 5 to 15 messages."""
    heard, _ = periodic(plain(keep_ratio=0.0), line(0.0, 50.0), 12.0, 1)
    phases = np.array([round(1e3 * one.t_s[0]) % 100 for one in heard if one.size])
    edges = np.flatnonzero(np.diff(phases)) + 1
    runs = np.diff(np.concatenate([[0], edges]))
    assert runs.size >= 5
    assert runs.min() >= 4  # the first of a run may be sent one interval late
    assert runs.max() <= 16


def test_with_keep_ratio_one_a_resource_is_never_left() -> None:
    heard, _ = periodic(plain(keep_ratio=1.0), line(0.0, 50.0), 6.0, 1)
    assert len({round(1e3 * one.t_s[0]) % 100 for one in heard if one.size}) == 1


def test_one_shot_reserves_nothing() -> None:
    heard, state = periodic(plain(one_shot=True), line(0.0, 50.0), 6.0, 1)
    assert len({round(1e3 * t_s) % 100 for one in heard for t_s in one.t_s}) > 20
    assert not np.any(state.reserved)


def test_sensing_keeps_neighbours_apart() -> None:
    """Twenty who hear each other and have 500 resources: once settled, hardly anything collides."""
    place_m = np.column_stack([np.linspace(0.0, 200.0, 20), np.zeros(20)])
    total = np.zeros(5)
    for seed in range(6):
        heard, _ = periodic(plain(), place_m, 4.0, 20, seed)
        total += np.sum([one.outcomes for one in heard[20:]], axis=(0, 1))
    share = total / total.sum()
    assert share[4] < 0.01
    assert share[0] > 0.98


def test_busy_ratio_counts_sub_channels_above_the_threshold() -> None:
    """One message in 100 subframes of five sub-channels, too far for its leakage to count."""
    radio = plain()
    _, state = periodic(radio, line(0.0, 1500.0, 20000.0), 3.0, 1)
    ratio = radio.channel_busy_ratio(state)
    assert ratio[1] == pytest.approx(1 / 500)
    assert ratio[0] == ratio[2] == 0.0


def test_the_longest_busy_window_is_what_a_vehicle_remembers() -> None:
    """Ten messages in a second of 5000 sub-channels; nobody remembers more."""
    radio = plain(busy_window_ms=1000)
    _, state = periodic(radio, line(0.0, 1500.0), 3.0, 1)
    assert radio.channel_busy_ratio(state)[1] == pytest.approx(10 / 5000)
    with pytest.raises(ValueError, match=r"busy_window_ms must lie within 1\.\.1000, got 1001"):
        plain(busy_window_ms=1001)


def test_leakage_is_all_inside_and_weak_outside() -> None:
    leak = in_band_emission(5, 10)
    for length in range(1, 6):
        for first in range(6 - length):
            inside = np.zeros(5, dtype=np.bool_)
            inside[first : first + length] = True
            assert np.all(leak[length - 1, first, inside] == 1.0)
            outside = leak[length - 1, first, ~inside]
            assert np.all(outside < 0.02)
            assert np.all(outside > 10**-3.9)


def test_a_near_sender_on_another_sub_channel_drowns_a_far_one() -> None:
    """Leakage is about 20 dB down; 40 dB of difference in power makes it count."""
    radio = plain(sub_channels=2, first_ms=1, last_ms=20)
    place_m = line(0.0, 2.0, 400.0)  # the first listens
    lost = shared = 0
    for seed in range(200):
        state = radio.init(3, np.random.default_rng(seed))
        heard, after = radio.step(state, batch([1, 2], [0.0101, 0.0102]), place_m, 0.05)
        bands = after.sensed[:, 0].reshape(-1, radio.parameters.sub_channels)
        busiest = np.flatnonzero((bands > 1e-9).any(axis=1))
        at_listener = set(heard.sender[heard.receiver == 0].tolist())
        shared += busiest.size == 1 and 2 not in at_listener
        lost += 2 not in at_listener
    assert lost > 0
    assert lost >= shared


def test_sizes_decide_the_sub_channels() -> None:
    parameters = SidelinkParameters(mcs=7)
    assert parameters.length(np.array([1, 100, 190, 300])).tolist() == [1, 1, 2, 3]


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), vehicles=st.integers(2, 60), messages=st.integers(1, 120))
def test_a_grant_stays_inside_the_pool(seed: int, vehicles: int, messages: int) -> None:
    rng = np.random.default_rng(seed)
    case = Transmissions(
        rng.integers(0, vehicles, messages),
        np.sort(rng.uniform(0.0, 0.2, messages)),
        size_bytes=rng.integers(50, 400, messages),
        power_dbm=rng.uniform(10.0, 23.0, messages),
        message_id=np.arange(messages, dtype=np.int64),
    )
    place_m = np.column_stack([rng.uniform(0.0, 2000.0, vehicles), rng.uniform(0.0, 20.0, vehicles)])
    radio = Sidelink()
    _, after = radio.step(radio.init(vehicles, rng), case, place_m, 0.4)
    assert not np.any(after.grant[:, BAND] > 4)


def test_steps_that_do_not_fit_are_refused() -> None:
    radio = plain()
    state = radio.init(2, np.random.default_rng(0))
    place_m = line(0.0, 10.0)
    with pytest.raises(ValueError, match="whole number of milliseconds"):
        radio.step(state, batch([], []), place_m, 0.10005)
    with pytest.raises(ValueError, match="must fit into"):
        radio.step(state, batch([0], [0.0], size=900), place_m, 0.1)


@pytest.mark.parametrize(
    "change",
    [
        {"mcs": 99},
        {"interval_ms": 30},
        {"first_ms": 5},
        {"last_ms": 10},
        {"keep_ratio": 1.5},
        {"sub_channels": 0},
        {"sub_channels": 21, "blocks": 4},
        {"sub_channels": 11},
        {"blocks": 0},
        {"control_blocks": -1},
        {"control_blocks": 101},
        {"least_sub_channels": 6},
        {"reselect_after": 0},
        {"reselect_after": 10},
        {"one_shot_most": 2**70},
        {"busy_window_ms": 0},
        {"busy_window_ms": 1001},
        {"bins": 0},
        {"bins": 100_001},
        {"bin_m": 0.0},
        {"bin_m": 0.05},
        {"bin_m": np.inf},
        {"margin_db": -1.0},
        {"margin_db": np.inf},
        {"reserved_dbm": np.nan},
        {"control_db": -301.0},
        {"noise_figure_db": 1e6},
        {"sensitivity_dbm": -np.inf},
        {"load_dbm": 301.0},
        {"antenna_gain_db": np.inf},
        {"max_power_dbm": 1e300},
    ],
)
def test_impossible_parameters_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        replace(SidelinkParameters(), **change)  # type: ignore[arg-type]

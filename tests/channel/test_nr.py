"""Claims about NR-V2X mode 2 alone; what holds of every radio is in `test_radio_conformance.py`."""

import os
import subprocess
import sys
import textwrap
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.error_models import TabulatedErrorModel, ThresholdErrorModel
from modelcast.channel.in_band_emission import EmissionMask, in_band_emission
from modelcast.channel.nr import Nr, NrState
from modelcast.channel.nr_parameters import NrParameters
from modelcast.channel.nr_transport_block import SlotShape, transport_block_bits
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import OUTCOMES, Grant, Receptions, Transmissions
from modelcast.channel.radio_words import get_radio

CLEAR = Propagation(LogDistance(2.0), None, None)
PAIR = np.array([[0.0, 0.0], [50.0, 0.0]])
ROW = np.column_stack([np.linspace(0.0, 200.0, 20), np.zeros(20)])
"""Twenty who hear each other."""


def plain(**changes: Any) -> Nr:
    return Nr(replace(NrParameters(), **changes), CLEAR, ThresholdErrorModel(5.0))


def batch(
    sender: list[int],
    ready_s: list[float],
    *,
    size: int = 80,
    grant: Grant = Grant.ANY,
    gap_s: float = np.inf,
) -> Transmissions:
    """Messages at 23 dBm with the numbers 100, 101, ...; each says that the next comes after ``gap_s``."""
    number = len(sender)
    return Transmissions(
        np.array(sender, dtype=np.int64),
        np.array(ready_s),
        size_bytes=np.full(number, size, dtype=np.int64),
        power_dbm=np.full(number, 23.0),
        message_id=100 + np.arange(number, dtype=np.int64),
        next_s=np.array(ready_s) + gap_s,
        grant=np.full(number, int(grant)),
    )


def drive(
    radio: Nr,
    place_m: np.ndarray,
    seconds: float,
    senders: int,
    *,
    uneven: bool = False,
    size: int = 80,
    seed: int = 0,
) -> tuple[list[Receptions], NrState]:
    """Ten messages a second of each: every 100 ms, or after 50 ms and an exponential time of 50 ms."""
    rng = np.random.default_rng(seed)
    count = round(seconds * 20)
    gaps_s = 0.05 + rng.exponential(0.05, (senders, count)) if uneven else np.full((senders, count), 0.1)
    times_s = rng.uniform(0.0, 0.1, senders)[:, None] + np.cumsum(gaps_s, axis=1)
    who, when_s = np.repeat(np.arange(senders), count), times_s.ravel()
    order = np.argsort(when_s, kind="stable")
    who, when_s = who[order], when_s[order]
    state = radio.init(place_m.shape[0], rng)
    heard: list[Receptions] = []
    for k in range(round(seconds * 10)):
        inside = (when_s >= 0.1 * k) & (when_s < 0.1 * (k + 1))
        case = batch(who[inside].tolist(), when_s[inside].tolist(), size=size)
        one, state = radio.carry(state, case, place_m, round(0.1 * (k + 1), 3))
        heard.append(one)
    return heard, state


def shares(heard: list[Receptions]) -> dict[str, float]:
    """What became of pairs, after two seconds, by name."""
    counts = np.sum([one.outcomes.sum(axis=0) for one in heard[20:]], axis=0)
    return dict(zip(OUTCOMES, (counts / counts.sum()).tolist(), strict=True))


def phases(heard: list[Receptions]) -> list[int]:
    """In which of 100 slots of a millisecond messages ended."""
    return [round(1e3 * one.t_s[0]) % 100 for one in heard if one.size]


@pytest.mark.parametrize(("spacing_khz", "slot_ms"), [(15, 1.0), (30, 0.5)])
def test_a_message_goes_out_within_its_window_on_a_whole_slot(spacing_khz: int, slot_ms: float) -> None:
    radio = plain(spacing_khz=spacing_khz, first_ms=4.0, last_ms=20.0)
    delays_ms = set[float]()
    for seed in range(80):
        state = radio.init(2, np.random.default_rng(seed))
        heard, _ = radio.step(state, batch([0], [0.0101]), PAIR, 0.1)
        delay_ms = 1e3 * float(heard.t_s[0]) - 10.0 - slot_ms  # from the slot in which it became ready
        assert delay_ms / slot_ms == pytest.approx(round(delay_ms / slot_ms), abs=1e-6)
        delays_ms.add(round(delay_ms, 3))
    assert min(delays_ms) == 4.0
    assert max(delays_ms) == 20.0


def test_a_resource_is_kept_for_the_counter_and_then_left() -> None:
    """With keep ratio 0 a run of equal phases lasts 5 to 15 messages."""
    heard, _ = drive(plain(keep_ratio=0.0), PAIR, 20.0, 1)
    found = np.array(phases(heard))
    runs = np.diff(np.concatenate([[0], np.flatnonzero(np.diff(found)) + 1]))
    assert runs.size >= 10
    assert set(runs.tolist()) <= set(range(5, 16))


def test_with_keep_ratio_one_a_resource_is_never_left() -> None:
    heard, _ = drive(plain(keep_ratio=1.0), PAIR, 6.0, 1)
    assert len(set(phases(heard))) == 1


@pytest.mark.parametrize("turns", [1, 3])
def test_a_resource_without_messages_is_given_up_after_so_many_turns(turns: int) -> None:
    for given_up, after in ((turns, -1), (0, 0)):
        radio = plain(reselect_after=given_up, keep_ratio=1.0)
        state = radio.init(2, np.random.default_rng(1))
        _, state = radio.step(state, batch([0], [0.0]), PAIR, 0.1)
        _, before = radio.step(state, batch([], []), PAIR, round(0.1 * turns, 3))
        assert before.slots[0, 0] >= 0
        _, later = radio.step(before, batch([], []), PAIR, round(0.1 * turns + 0.15, 3))
        assert min(int(later.slots[0, 0]), 0) == after


def test_dynamic_grants_reserve_nothing_and_move() -> None:
    heard, state = drive(plain(dynamic=True), PAIR, 6.0, 1)
    assert len(set(phases(heard))) > 20
    assert not np.any(state.reserved[:, 1])  # the sender itself only knows when it was deaf
    assert np.all(np.isin(state.reserved[:, 0], [0.0, np.inf]))


def test_a_one_shot_grant_is_that_of_a_dynamic_radio() -> None:
    said = replace(batch([0, 1], [0.0, 0.03]), grant=np.full(2, int(Grant.ONE_SHOT)))
    asked, _ = plain().step(plain().init(2, np.random.default_rng(1)), said, PAIR, 0.3)
    radio = plain(dynamic=True)
    own, after = radio.step(radio.init(2, np.random.default_rng(1)), batch([0, 1], [0.0, 0.03]), PAIR, 0.3)
    assert asked.t_s.tolist() == own.t_s.tolist()
    assert np.all(after.slots < 0)


@pytest.mark.parametrize(
    ("gap_s", "interval_ms"), [(0.0301, 31), (0.03, 30), (0.1, 100), (0.12, 200), (0.9, 300), (np.inf, 100)]
)
def test_a_periodic_grant_comes_back_when_the_next_message_is_ready(gap_s: float, interval_ms: int) -> None:
    """After the shortest interval there is that is not shorter than the gap, the longest one at most."""
    radio = plain(longest_ms=300, keep_ratio=1.0)
    state = radio.init(2, np.random.default_rng(2))
    heard, after = radio.step(state, batch([0], [0.0], grant=Grant.PERIODIC, gap_s=gap_s), PAIR, 0.101)
    sent_in, due_in = round(1e3 * heard.t_s[0]) - 1, int(after.slots[0, 0])
    assert (due_in - sent_in) % interval_ms == 0
    assert max(101, sent_in + 1) <= due_in < 101 + interval_ms


def test_a_held_resource_takes_the_interval_of_each_message() -> None:
    """Announced and kept: 100 ms, then 500, then 40."""
    radio = plain(longest_ms=1000, keep_ratio=1.0)
    state, start_s, due_in = radio.init(2, np.random.default_rng(1)), 0.0, -1
    for interval_ms in (100, 500, 40):
        case = batch([0], [start_s], grant=Grant.PERIODIC, gap_s=1e-3 * interval_ms)
        heard, state = radio.step(state, case, PAIR, round(start_s + 0.101, 3))
        sent_in = round(1e3 * float(heard.t_s[0])) - 1
        assert due_in in (-1, sent_in)
        due_in = sent_in + interval_ms
        uses = {(due_in + more) % radio.constants.ahead for more in range(0, 100, interval_ms)}
        known = set(np.flatnonzero(state.reserved[:, 1].any(axis=1)).tolist())
        assert known == {one for one in uses if one > round(1e3 * start_s) + 100}
        start_s = round(1e-3 * (due_in - 50), 3)


def test_a_new_interval_does_not_lead_onto_what_others_reserved() -> None:
    """Vehicle 1 holds the slot that the new interval of vehicle 0 leads to, and all of it."""
    radio = plain(keep_ratio=1.0, blocks=50, longest_ms=300)
    met = 0
    for seed in range(20):
        state = radio.init(3, np.random.default_rng(seed))
        place_m = np.vstack([PAIR, [[100.0, 0.0]]])
        first = batch([0, 1], [0.0, 0.0], grant=Grant.PERIODIC, gap_s=0.2)
        _, state = radio.step(state, first, place_m, 0.150)
        zero, one = state.slots[:2, 0].tolist()
        if one <= zero:
            continue
        met += 1
        again = batch([0], [1e-3 * (zero - 50)], grant=Grant.PERIODIC, gap_s=1e-3 * (one - zero))
        _, before = radio.step(state, batch([], []), place_m, round(1e-3 * (zero - 50), 3))
        _, after = radio.step(before, again, place_m, round(1e-3 * (zero + 1), 3))
        assert after.slots[0, 0] == -1
        assert after.slots[1, 0] == one
    assert met >= 3


def test_a_reservation_keeps_others_off() -> None:
    """Who hears it and has all other resources too does not choose it; who does not hear it may."""
    radio = plain(keep_ratio=1.0, bandwidth_mhz=10, blocks=50, last_ms=20.0, interval_ms=20)
    for seed in range(40):
        state = radio.init(3, np.random.default_rng(seed))
        place_m = np.array([[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]])
        heard, _ = radio.step(state, batch([0, 1, 0, 1], [0.0, 0.0205, 0.021, 0.0415]), place_m, 0.1)
        sent = {(int(one), round(1e3 * t_s)) for one, t_s in zip(heard.sender, heard.t_s, strict=True)}
        phase = {one: {ms % 20 for sender, ms in sent if sender == one} for one in (0, 1)}
        assert len(phase[0]) == 1
        assert not phase[0] & phase[1]


@pytest.mark.parametrize(("interval_ms", "uses"), [(20, 5), (30, 4), (99, 2), (100, 1)])
def test_an_interval_below_t2_reserves_all_its_uses_up_to_t2(interval_ms: int, uses: int) -> None:
    """TS 38.214, 8.1.4: the ceiling of T2 = 100 ms over the interval."""
    radio = plain(interval_ms=interval_ms, keep_ratio=1.0)
    for seed in range(10):
        state = radio.init(2, np.random.default_rng(seed))
        heard, after = radio.step(state, batch([0], [0.0]), PAIR, 0.101)
        sent_in = round(1e3 * float(heard.t_s[0])) - 1
        to_come = [sent_in + use * interval_ms for use in range(1, uses + 1)]
        known = np.flatnonzero(after.reserved[:, 1].any(axis=1)).tolist()
        assert known == sorted(one % radio.constants.ahead for one in to_come if one > 100)


def test_sensing_keeps_neighbours_apart_and_dynamic_grants_do_not() -> None:
    """Twenty with 400 resources: once settled, hardly anything collides."""
    sensed, blind = (shares(drive(plain(dynamic=dynamic), ROW, 8.0, 20)[0]) for dynamic in (False, True))
    assert sensed["concurrent"] < 0.01
    assert blind["concurrent"] > 2.0 * sensed["concurrent"]
    assert sensed["received"] > blind["received"] > 0.6


def test_uneven_traffic_does_worse_than_even_traffic_on_reserved_resources() -> None:
    """A message waits long for its resource, and the next one often comes before it: 18 % are lost."""
    even, uneven = (drive(plain(), ROW, 8.0, 20, uneven=uneven)[0] for uneven in (False, True))
    lapsed = sum(one.expired.size for one in uneven) / (20 * 80)
    assert sum(one.expired.size for one in even) == 0
    assert lapsed == pytest.approx(
        0.184, abs=0.03
    )  # the chance that 50 ms + Exp(50 ms) is below U(0, 100 ms)
    assert shares(uneven)["received"] < shares(even)["received"]


def test_a_dynamic_grant_with_a_short_window_loses_no_uneven_message_at_the_sender() -> None:
    heard, _ = drive(plain(dynamic=True, last_ms=50.0), ROW, 4.0, 20, uneven=True)
    assert sum(one.expired.size for one in heard) == 0


def test_a_second_copy_reaches_some_that_the_first_did_not() -> None:
    """A message counts once, however many copies arrive."""
    once, twice = (
        drive(plain(transmissions=copies, keep_ratio=0.0), ROW[:8], 6.0, 8)[0] for copies in (1, 2)
    )
    assert shares(twice)["received"] > shares(once)["received"]
    for one in twice:
        pairs = one.message_id * 8 + one.receiver + 1000 * 8 * (1e3 * one.t_s).astype(np.int64)
        assert np.unique(pairs).size == pairs.size
    total = sum(one.outcomes.sum() for one in twice) / sum(one.outcomes.sum() for one in once)
    assert total == pytest.approx(1.0, abs=0.02)  # what waits at the end


def test_who_leaves_between_copies_leaves_room_for_the_others() -> None:
    """Without the compiler, which does not see a row beyond an array: more heard a copy than are left."""
    program = """
    import warnings
    import numpy as np
    from modelcast.channel.nr import Nr
    from modelcast.channel.nr_parameters import NrParameters
    from modelcast.channel.propagation import Propagation
    from modelcast.channel.radio import Transmissions

    warnings.simplefilter("ignore")  # words of chance overflow
    radio = Nr(NrParameters(transmissions=3, last_ms=40.0), Propagation(shadowing=None, fading=None))
    place_m = np.column_stack([np.linspace(0.0, 100.0, 30), np.zeros(30)])
    left_m = place_m.copy()
    left_m[6:] = np.nan

    def batch(number):
        return Transmissions(
            np.arange(number),
            np.full(number, 0.001),
            size_bytes=np.full(number, 60),
            power_dbm=np.full(number, 20.0),
            message_id=np.arange(number),
        )

    for seed in (14, 16, 27):
        _, state = radio.step(radio.init(30, np.random.default_rng(seed)), batch(6), place_m, 0.015)
        print(state.copy_span[:, 1].max() > 2 * 6)
        radio.step(state, batch(0), left_m, 0.14)
    """
    found = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", textwrap.dedent(program)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.stderr == ""
    assert found.stdout == 3 * "True\n"


@given(seed=st.integers(0, 10_000), copies=st.integers(2, 3), spacing_khz=st.sampled_from((15, 30)))
def test_copies_are_in_order_in_slots_of_their_own_within_reach_of_one_control_message(
    seed: int, copies: int, spacing_khz: int
) -> None:
    radio = plain(transmissions=copies, spacing_khz=spacing_khz)
    _, after = radio.step(radio.init(2, np.random.default_rng(seed)), batch([0], [0.0]), PAIR, 0.001)
    slots = after.slots[0]
    assert np.all(np.diff(slots) > 0)
    assert slots[-1] - slots[0] < 32


def test_busy_ratio_counts_sub_channels_above_the_threshold() -> None:
    """One message of one sub-channel in 100 slots of five, too far for its leakage to count."""
    far = np.array([[0.0, 0.0], [900.0, 0.0], [90000.0, 0.0]])
    radio = plain()
    _, state = drive(radio, far, 3.0, 1)
    ratio = radio.channel_busy_ratio(state)
    assert ratio[1] == pytest.approx(1 / 500)
    assert ratio[0] == ratio[2] == 0.0


def test_noise_above_the_threshold_is_busy_for_everybody() -> None:
    """Also for who hears nothing: noise of a sub-channel is -102.4 dBm."""
    far = np.array([[0.0, 0.0], [50.0, 0.0], [90000.0, 0.0]])
    for load_dbm, heard_of, silent in ((-103.0, 1.0, 1.0), (-102.0, 5 / 500, 0.0)):
        radio = plain(load_dbm=load_dbm)
        _, state = drive(radio, far, 3.0, 1)
        assert radio.channel_busy_ratio(state)[1:] == pytest.approx([heard_of, silent])


def test_sizes_decide_the_sub_channels_as_in_the_reference() -> None:
    """300 bytes: 23 blocks and 6.39 dB at MCS 7, 17 and 9.99 dB at MCS 11."""
    for mcs, blocks, sub_channels, needed_db in ((7, 23, 3, 6.39), (11, 17, 2, 9.99)):
        parameters, size = NrParameters(mcs), np.array([300])
        assert parameters.blocks_of(size).tolist() == [blocks]
        assert parameters.length(size).tolist() == [sub_channels]
        assert parameters.threshold_db(size) == pytest.approx([needed_db], abs=0.006)


def test_a_message_is_received_from_the_sinr_on_that_its_rate_needs() -> None:
    """Alone, half a decibel above and below."""
    radio = Nr(NrParameters(), CLEAR)
    needed_db = float(radio.parameters.threshold_db(np.array([300]))[0])
    noise_dbm = 10.0 * np.log10(2 * radio.constants.pool.noise_mw)
    for more_db, received in ((0.5, 1), (-0.5, 0)):
        loss_db = 23.0 - noise_dbm - needed_db - more_db
        away_m = 10.0 ** ((loss_db - 47.86) / 20.0)
        place_m = np.array([[0.0, 0.0], [away_m, 0.0]])
        heard, _ = radio.step(
            radio.init(2, np.random.default_rng(0)), batch([0], [0.0], size=300), place_m, 0.2
        )
        assert heard.size == received


@given(bits=st.floats(24.0, 200_000.0), rate=st.floats(0.1, 0.95))
def test_a_transport_block_is_near_what_the_resources_hold_and_whole_octets(bits: float, rate: float) -> None:
    found = transport_block_bits(bits, rate)
    assert found % 8 == 0
    assert found == pytest.approx(bits, rel=0.11, abs=8.0)


def test_transport_blocks_are_those_of_the_standards_table() -> None:
    """TS 38.214, 5.1.3.2: from the table up to 3824 bits, then by code block segments."""
    for bits, rate, size in (
        (24, 0.5, 24),
        (100, 0.5, 96),
        (3824, 0.5, 3824),
        (3825, 0.5, 3840),
        (20000, 0.2, 19992),
        (20000, 0.5, 19968),
    ):
        assert transport_block_bits(bits, rate) == size
    assert SlotShape().block_bits(1, 11) == 0  # control takes all


def test_a_wider_channel_leaks_by_its_own_width() -> None:
    """The general limit is 10 log(N/L) below -25 dB; with no relief it is higher than in LTE-V2X."""
    mask = EmissionMask(0.08)
    narrow, wide = (in_band_emission(5, 10, mask=mask, total_blocks=total) for total in (50, 500))
    assert np.all(wide[0, 0, 2:] < narrow[0, 0, 2:])
    assert narrow[0, 0, 3] == pytest.approx(0.2 * 10**-2.5)  # one of five sub-channels, no image, no carrier
    assert np.all(in_band_emission(5, 10, mask=EmissionMask())[0, 0] >= in_band_emission(5, 10)[0, 0])


def test_the_preset_is_the_radio_of_the_reference() -> None:
    radio = get_radio("nr:preset=wilab,mcs=7")
    assert isinstance(radio, Nr)
    assert radio.error_model is None
    assert radio.constants.pool.noise_mw / 1.8 == pytest.approx(10**-10.8, rel=0.01)  # -108 dBm in 1 MHz
    curved = get_radio("nr:mcs=7,error_model=nr-mcs7")
    assert isinstance(curved, Nr)
    assert curved.error_model == TabulatedErrorModel.nr_mcs7()


def test_steps_that_do_not_fit_are_refused() -> None:
    state = plain().init(2, np.random.default_rng(0))
    with pytest.raises(ValueError, match="whole number of slots of 1000 us"):
        plain().step(state, batch([], []), PAIR, 0.1005)
    plain(spacing_khz=30).step(
        plain(spacing_khz=30).init(2, np.random.default_rng(0)), batch([], []), PAIR, 0.1005
    )
    with pytest.raises(ValueError, match="1024 bytes at most, got 1025"):
        plain().step(state, batch([0], [0.0], size=1025), PAIR, 0.1)


@pytest.mark.parametrize(
    "change",
    [
        {"mcs": 29},
        {"spacing_khz": 60},
        {"bandwidth_mhz": 5},
        {"blocks": 11},
        {"blocks": 75},
        {"control_symbols": 4},
        {"control_blocks": 11},
        {"reference_elements": 6},
        {"interval_ms": 150},
        {"longest_ms": 50},
        {"first_ms": 0.5},
        {"last_ms": 0.9},
        {"last_ms": 1001.0},
        {"first_ms": 2.6, "last_ms": 2.9},
        {"first_ms": 1.5},
        {"last_ms": 20.25, "spacing_khz": 30},
        {"keep_ratio": 1.5},
        {"free_ratio": -0.1},
        {"transmissions": 4},
        {"reselect_after": -1},
        {"busy_window_ms": 0},
        {"busy_window_ms": 10**30},
        {"reselect_after": 10**30},
        {"bins": 100_001},
        {"bin_m": 0.0},
        {"bin_m": 1e-9},
        {"bin_m": np.inf},
        {"bin_m": np.nan},
        {"sensitivity_dbm": np.nan},
        {"reserved_dbm": -np.inf},
        {"control_db": 301.0},
        {"noise_figure_db": 1e6},
        {"load_dbm": -1e9},
        {"antenna_gain_db": 1e6},
        {"max_power_dbm": np.inf},
        {"margin_db": -0.1},
        {"margin_db": 1e6},
    ],
)
def test_impossible_parameters_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="must"):
        replace(NrParameters(), **change)

"""Claims about IEEE 802.11p broadcast alone; what holds of every radio is in `test_radio_conformance.py`."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc, DsrcState
from modelcast.channel.dsrc_parameters import BIT_RATES, AccessCategory, DsrcParameters
from modelcast.channel.dsrc_station_kernels import AIR, MESSAGE
from modelcast.channel.error_models import TabulatedErrorModel, ThresholdErrorModel
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import Receptions, Transmissions
from modelcast.channel.sidelink import Sidelink
from modelcast.core.exceptions import ModelcastWarning

CLEAR = Propagation(LogDistance(2.0), None, None)
"""Free space, no luck: 300 m lose 97.4 dB."""

AIRTIME_S = 448e-6
"""300 bytes at 6 Mb/s."""


def plain(**changes: Any) -> Dsrc:
    parameters = replace(DsrcParameters(margin_db=10.0), **changes)
    return Dsrc(parameters, CLEAR, ThresholdErrorModel(6.0))


def batch(sender: list[int], ready_s: list[float], *, size: int = 300, power: float = 20.0) -> Transmissions:
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


def run(radio: Dsrc, case: Transmissions, place_m: np.ndarray, seed: int = 1) -> tuple[Receptions, DsrcState]:
    return radio.step(radio.init(place_m.shape[0], np.random.default_rng(seed)), case, place_m, 0.1)


def test_airtimes_are_those_of_the_standard() -> None:
    airtime_us = 1e6 * DsrcParameters().airtime_s(np.array([180, 250, 350]))
    assert airtime_us.round(6).tolist() == [288.0, 384.0, 512.0]
    for rate_mbps, rate in BIT_RATES.items():
        assert rate.bits_per_symbol == pytest.approx(rate_mbps * 8)
        assert rate.bits_per_symbol == 48 * rate.bits_per_subcarrier * rate.code_rate


def test_interframe_spaces_are_those_of_the_standard() -> None:
    spaces_us = [1e6 * DsrcParameters(access=AccessCategory(n, 15)).aifs_s for n in (2, 3, 6, 9)]
    assert np.round(spaces_us, 6).tolist() == [58.0, 71.0, 110.0, 149.0]


def test_a_lone_message_goes_out_at_once_and_arrives_after_its_airtime() -> None:
    heard, _ = run(plain(), batch([0], [0.01]), line(0.0, 100.0))
    assert heard.t_s == pytest.approx([0.01 + AIRTIME_S])
    assert (heard.message_id.tolist(), heard.sender.tolist(), heard.receiver.tolist()) == ([100], [0], [1])


def test_a_vehicle_that_finds_the_medium_busy_waits_for_aifs_and_whole_slots() -> None:
    """The second frame begins AIFS and 0..15 slots after the end of the first; both arrive."""
    starts = set()
    for seed in range(40):
        heard, _ = run(plain(), batch([0, 1], [0.01, 0.0101]), line(0.0, 50.0, 100.0), seed)
        assert sorted(heard.message_id.tolist()) == [100, 100, 101, 101]
        gap_s = heard.t_s.max() - AIRTIME_S - (0.01 + AIRTIME_S)
        slots = (gap_s - 110e-6) / 13e-6
        assert slots == pytest.approx(round(slots), abs=1e-4)
        starts.add(round(slots))
    assert min(starts) >= 0
    assert max(starts) <= 15
    assert len(starts) > 8


def test_a_countdown_freezes_while_another_sends_and_resumes() -> None:
    """Of two that wait for the same end, the later counts idle slots only: at most the window in all."""
    for seed in range(20):
        case = batch([0, 1, 2], [0.01, 0.0101, 0.0102])
        heard, _ = run(plain(), case, line(0.0, 30.0, 60.0, 90.0), seed)
        ends_s = sorted(set(np.round(heard.t_s, 9).tolist()))
        if len(ends_s) < 3:
            continue  # both chose the same slot
        idle_s = (ends_s[1] - AIRTIME_S - ends_s[0]) + (ends_s[2] - AIRTIME_S - ends_s[1])
        slots = (idle_s - 2 * 110e-6) / 13e-6
        assert slots == pytest.approx(round(slots), abs=1e-3)
        assert round(slots) <= 15


@pytest.mark.parametrize(("senders", "waits"), [([0], False), ([2], False), ([0, 2], True)])
def test_the_power_of_all_frames_together_holds_the_medium_busy(senders: list[int], *, waits: bool) -> None:
    """One weak frame is at -71.4 dBm, two are at -68.4 dBm; the bound is -70 dBm and nothing is decoded."""
    radio = plain(sensitivity_dbm=-50.0, decodable_dbm=-50.0, energy_dbm=-70.0)
    case = batch([*senders, 1], [*(0.01 + 1e-6 * k for k in range(len(senders))), 0.0101])
    heard, _ = run(radio, case, line(0.0, 150.0, 300.0, 151.0))
    own = heard.t_s[(heard.sender == 1) & (heard.receiver == 3)]
    began_s = float(own[0]) - AIRTIME_S
    assert (began_s >= 0.01 + AIRTIME_S + 110e-6) if waits else (began_s == pytest.approx(0.0101))


def test_two_that_begin_within_the_sensing_time_are_concurrent() -> None:
    """Neither hears the other, and a third hears at most the stronger."""
    heard, _ = run(plain(), batch([0, 1], [0.01, 0.010004]), line(0.0, 400.0, 40.0))
    assert heard.receiver.tolist() == [2]
    assert heard.sender.tolist() == [0]
    assert heard.outcomes.sum(axis=0).tolist()[:2] == [1, 2]
    assert heard.outcomes[:, 4].sum() == 1  # at the third, the weaker was lost to a sender of the same slot


def test_hidden_senders_collide_in_the_middle() -> None:
    """Out of each other's range, both in range of the middle: SINR 0 dB there."""
    radio = plain(sensitivity_dbm=-80.0, decodable_dbm=-80.0, preamble_db=-20.0, energy_dbm=-40.0)
    heard, _ = run(radio, batch([0, 1], [0.01, 0.0101]), line(0.0, 440.0, 220.0))
    assert heard.size == 0
    assert heard.outcomes[:, 3].sum() == 2
    assert heard.outcomes[:, 1].sum() == 2  # the two senders themselves


def test_interference_counts_for_the_part_of_the_frame_it_lasts() -> None:
    """Mean interference over the payload decides in the threshold model: a short overlap is survived."""
    radio = plain(sensitivity_dbm=-80.0, decodable_dbm=-80.0, energy_dbm=-40.0)
    place_m = line(0.0, 420.0, 190.0)
    late, _ = run(radio, batch([0, 1], [0.01, 0.01 + 0.9 * AIRTIME_S]), place_m)
    early, _ = run(radio, batch([0, 1], [0.01, 0.01 + 0.3 * AIRTIME_S]), place_m)
    assert 100 in late.message_id.tolist()
    assert 100 not in early.message_id.tolist()


def test_after_a_spoilt_frame_a_vehicle_waits_longer() -> None:
    """The middle loses a frame to a hidden sender: AIFS, 120 us and 0..15 slots before its own."""
    radio = plain(sensitivity_dbm=-80.0, decodable_dbm=-80.0, energy_dbm=-40.0, capture_s=0.0)
    waits_us = set()
    for seed in range(30):
        case = batch([0, 1, 2], [0.01, 0.0101, 0.0102])
        heard, _ = run(radio, case, line(0.0, 440.0, 220.0), seed)
        own = heard.t_s[heard.message_id == 102]
        assert own.size == 2
        waits_us.add(round(1e6 * (own[0] - AIRTIME_S - (0.01 + AIRTIME_S)) - 110 - 120))
    assert all(wait_us >= 0 and wait_us % 13 == 0 and wait_us <= 15 * 13 for wait_us in waits_us)
    assert len(waits_us) > 5


def test_a_stronger_frame_takes_a_receiver_over_in_the_preamble_only() -> None:
    radio = plain(sensitivity_dbm=-80.0, decodable_dbm=-80.0, energy_dbm=-40.0, capture_s=32e-6)
    place_m = line(0.0, 420.0, 370.0)
    within, _ = run(radio, batch([0, 1], [0.01, 0.010025]), place_m)
    after, _ = run(radio, batch([0, 1], [0.01, 0.010045]), place_m)
    assert within.message_id.tolist() == [101]
    assert after.size == 0


def test_busy_ratio_is_the_share_of_the_window_on_the_air() -> None:
    radio = plain()
    place_m = line(0.0, 100.0, 2500.0)
    _, state = run(radio, batch([0, 0, 0], [0.01, 0.02, 0.0999]), place_m)
    ratio = radio.channel_busy_ratio(state)
    assert ratio[:2] == pytest.approx((2 * AIRTIME_S + 1e-4) / 0.1)
    assert ratio[2] == 0.0
    _, state = radio.step(state, batch([], []), place_m, 0.2)
    assert radio.channel_busy_ratio(state)[:2] == pytest.approx((AIRTIME_S - 1e-4) / 0.1)


def test_all_at_once_ends_with_every_message_sent_or_on_its_way() -> None:
    """A hundred messages at one instant: heap, pool and store grow, and every pair is counted."""
    vehicles = 100
    place_m = np.column_stack([np.linspace(0.0, 300.0, vehicles), np.zeros(vehicles)])
    radio = Dsrc(DsrcParameters(bins=20))
    heard, state = run(radio, batch(list(range(vehicles)), [0.01] * vehicles), place_m)
    assert not np.any(state.message[:, MESSAGE] >= 0)
    assert not np.any(state.message[:, AIR] >= 0)
    assert heard.outcomes.sum() == vehicles * (vehicles - 1)


@pytest.mark.parametrize("change", [{"rate_mbps": 7.0}, {"slot_s": 0.0}, {"sensing_s": 1.0}, {"bins": 0}])
def test_impossible_parameters_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        replace(DsrcParameters(), **change)  # type: ignore[arg-type]


def test_frames_that_begin_at_once_spoil_each_other_where_that_is_asked_for() -> None:
    """The listener is at 20 m from one sender, 380 m from the other, 25 dB weaker: ties alone decide.

    Whoever begins second takes the near listener over if it is near itself: it is heard all the same.
    """
    place_m = line(0.0, 400.0, 20.0)
    for spoil in (False, True):
        radio = plain(ties_spoil=spoil)
        for first, second in ((0, 1), (1, 0)):
            for apart_s in (0.0, 1e-9):
                heard, _ = run(radio, batch([first, second], [0.01, 0.01 + apart_s]), place_m)
                lost = spoil and first == 0 and apart_s == 0.0
                assert (0 in heard.sender[heard.receiver == 2]) != lost


def test_a_message_waits_for_aifs_from_its_arrival_where_that_is_asked_for() -> None:
    """On an idle medium: 0 to 3 slots, behind AIFS or not."""
    for waits, least_s in ((False, 0.0), (True, 110e-6)):
        radio = plain(immediate_access=False, aifs_on_arrival=waits, access=AccessCategory(6, 3))
        slots = set()
        for seed in range(40):
            heard, _ = run(radio, batch([0], [0.01]), line(0.0, 50.0), seed)
            slots.add(round(float((heard.t_s[0] - 0.01 - AIRTIME_S - least_s) / 13e-6), 3))
        assert slots == {0.0, 1.0, 2.0, 3.0}


def test_waiting_from_arrival_needs_a_countdown() -> None:
    with pytest.raises(ValueError, match="immediate_access"):
        DsrcParameters(aifs_on_arrival=True)


@pytest.mark.parametrize("radio", [Dsrc, Sidelink])
def test_fading_is_not_drawn_beside_a_curve_that_holds_it(radio: type[Dsrc] | type[Sidelink]) -> None:
    """`within` leaves it away, with a curve made without fading it stays; who gives both is told."""
    curve = TabulatedErrorModel.highway_los()
    quiet = radio(propagation=Propagation(fading=None), error_model=curve)
    assert quiet.within(Propagation()).propagation == Propagation(fading=None)
    assert replace(quiet, error_model=replace(curve, faded=False)).within(Propagation()).propagation.fading
    assert replace(quiet, error_model=ThresholdErrorModel(6.0)).within(Propagation()).propagation.fading
    with pytest.warns(ModelcastWarning, match="twice"):
        radio(propagation=Propagation(), error_model=curve)

"""Roadside units beside a fleet: they change nothing unless they relay, and copies are what they are."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.erasure import Ideal
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.path_loss import WinnerB1
from modelcast.channel.propagation import Propagation, RaisedAntennas
from modelcast.channel.radio import Transmissions
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.roadside import Roadside
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.relay import RelayRule
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway

MIDDLE = Roadside(np.array([[250.0, 20.0]]))
SETTINGS = NetworkSettings(warm_up_s=1.0)


def run(roadside: Roadside | None, *, range_m: float = 1000.0, threads: int = 1) -> NetworkRun:
    """Some cars on a road of 500 m, without losses up to a range."""
    frames = run_scenario(Highway(500.0, 30.0, warm_up_s=0.0), np.random.default_rng(1), duration_s=4.0)
    radio = ErasureRadio(Ideal(), range_m)
    return run_network(
        frames, named_sender("bsm-10hz"), radio, SETTINGS, seed=1, threads=threads, roadside=roadside
    )


def same(one: NetworkRun, other: NetworkRun) -> None:
    for counts, expected in zip(one.tally, other.tally, strict=True):
        np.testing.assert_array_equal(counts, expected)
    np.testing.assert_array_equal(one.sent.total, other.sent.total)


def test_a_unit_that_only_hears_changes_nothing_of_the_fleet() -> None:
    with_unit = run(MIDDLE)
    same(with_unit, run(None))
    assert with_unit.roadside is not None
    assert run(None).roadside is None


def test_a_unit_hears_all_that_is_sent_in_reach_and_tracks_all_there() -> None:
    found = run(MIDDLE).roadside
    assert found is not None
    np.testing.assert_array_equal(found.sent, found.delivered)
    assert found.sent.sum() > 0
    assert (found.tally.held <= found.tally.pairs).all()
    assert found.tally.held.sum() > 0.99 * found.tally.pairs.sum()  # who has just come was not heard yet
    assert found.unit_s == pytest.approx(3.0)
    assert found.repeated == 0


def test_without_losses_copies_change_nothing_that_hosts_hold() -> None:
    """They are older than what is held, the same, or the host's own; only newcomers learn by them."""
    relayed = run(replace(MIDDLE, relay=RelayRule(within_m=np.inf, rate_hz=1000.0)))
    plain = run(None)
    np.testing.assert_array_equal(relayed.tally.pairs, plain.tally.pairs)
    more = relayed.tally.held - plain.tally.held
    assert (more >= 0).all()
    assert more.sum() <= 0.01 * plain.tally.held.sum()
    assert np.abs(relayed.tally.age - plain.tally.age).sum() <= 0.01 * plain.tally.age.sum()
    assert relayed.roadside is not None
    assert relayed.roadside.repeated == pytest.approx(plain.sent.total[at.MESSAGES], rel=0.05)


def test_vehicles_out_of_reach_of_one_another_hold_each_other_by_a_relay() -> None:
    """Without it they do only while they have not forgotten those that drove away."""
    plain = run(None, range_m=150.0)
    relayed = run(replace(MIDDLE, relay=RelayRule(rate_hz=1000.0)), range_m=150.0)
    far = slice(7, 10)  # from 175 m on
    assert relayed.tally.held[far].sum() > 2 * plain.tally.held[far].sum()
    assert relayed.tally.held[:6].sum() >= plain.tally.held[:6].sum()


def test_the_number_of_threads_changes_nothing() -> None:
    relaying = replace(MIDDLE, relay=RelayRule())
    same(run(relaying, threads=2), run(relaying))


def test_what_cannot_be_had_is_refused() -> None:
    with pytest.raises(ValueError, match="places_m must be"):
        Roadside(np.zeros((0, 2)))
    with pytest.raises(ValueError, match="finite"):
        Roadside(np.array([[np.nan, 0.0]]))
    frames = run_scenario(Highway(500.0, 20.0, warm_up_s=0.0), np.random.default_rng(1), duration_s=0.2)
    senders = Mix((named_sender("bsm-10hz"), named_sender("baseline")), (0.5, 0.5))
    with pytest.raises(ValueError, match="mixed fleet"):
        run_network(frames, senders, ErasureRadio(Ideal()), SETTINGS, seed=1, roadside=MIDDLE)


def heard_dbm(radio: Dsrc, sender: int, receiver: int) -> float:
    """Power of a frame at 150 m, of two stations of which the second may be raised."""
    state = radio.init(2, np.random.default_rng(1))
    frame = Transmissions(
        np.array([sender]),
        np.array([0.01]),
        size_bytes=np.array([100]),
        power_dbm=np.array([20.0]),
        message_id=np.array([0]),
    )
    received, _ = radio.step(state, frame, np.array([[0.0, 0.0], [150.0, 0.0]]), 0.1)
    assert received.receiver.tolist() == [receiver]
    return float(received.rssi_dbm[0])


def test_a_raised_antenna_is_worth_what_the_path_loss_says_both_ways() -> None:
    raised = WinnerB1(other_antenna_m=6.0)
    far_m = np.array([150.0])
    worth_db = float((WinnerB1().loss_db(far_m) - raised.loss_db(far_m))[0])
    plain = Propagation(shadowing=None, fading=None)
    high = replace(plain, raised=RaisedAntennas(1, raised, 3.0))
    for ends in ((0, 1), (1, 0)):
        gained = heard_dbm(Dsrc(propagation=high), *ends) - heard_dbm(Dsrc(propagation=plain), *ends)
        assert gained == pytest.approx(worth_db + 3.0, abs=0.05)


def test_beyond_both_break_points_ten_times_the_effective_height_is_worth_what_the_formula_says() -> None:
    """From 1.5 m to 6 m, a metre of it lost to traffic: 17.3 log(5 / 0.5)."""
    far_m = np.array([300.0, 800.0])
    worth_db = WinnerB1().loss_db(far_m) - WinnerB1(other_antenna_m=6.0).loss_db(far_m)
    np.testing.assert_allclose(worth_db, 17.3, rtol=1e-12)


def test_one_height_at_both_ends_is_the_formula_for_two_alike() -> None:
    far_m = np.array([5.0, 50.0, 500.0])
    both = WinnerB1(antenna_m=1.5, other_antenna_m=1.5)
    np.testing.assert_allclose(both.loss_db(far_m), WinnerB1().loss_db(far_m), rtol=1e-14)

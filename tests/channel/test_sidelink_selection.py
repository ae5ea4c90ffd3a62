"""Claims about the choice of a resource in mode 4, each against a slow choice in plain Python."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.channel.error_models import ThresholdErrorModel
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import Transmissions
from modelcast.channel.sidelink import Sidelink
from modelcast.channel.sidelink_grant_kernels import BAND, NEXT
from modelcast.channel.sidelink_parameters import MEMORY, SidelinkParameters, wilab_sidelink_parameters
from modelcast.channel.sidelink_selection_kernels import select_resource

CLEAR = Propagation(LogDistance(2.0), None, None)
DRAWS = 400
"""Enough to meet each of at most 13 candidates: all are missed with a chance below 1e-13."""


def radio_of(parameters: SidelinkParameters | None = None, **changes: Any) -> Sidelink:
    return Sidelink(replace(parameters or SidelinkParameters(), **changes), CLEAR, ThresholdErrorModel(5.0))


def message(size: int, ready_s: float = 0.0005) -> Transmissions:
    return Transmissions(
        np.array([0]),
        np.array([ready_s]),
        size_bytes=np.array([size]),
        power_dbm=np.array([23.0]),
        message_id=np.array([1]),
    )


def as_kept(sensed: np.ndarray) -> np.ndarray:
    """What vehicles sensed by subframe, (1000, V, C), as a state has it, (100, V, 10 C)."""
    vehicles = sensed.shape[1]
    seconds = sensed.reshape(10, 100, vehicles, -1).transpose(1, 2, 0, 3)
    return np.ascontiguousarray(seconds.reshape(100, vehicles, -1))


def chosen_by(
    radio: Sidelink, now: int, length: int, sensed: np.ndarray, reserved: np.ndarray, *, random: np.ndarray
) -> tuple[int, int]:
    """Subframe and first sub-channel of one choice."""
    interval = radio.parameters.interval_ms
    when, band, _, _ = select_resource(
        0, now, length, interval, False, as_kept(sensed), reserved, random, radio.constants
    )
    return when, band


def candidates(
    radio: Sidelink, now: int, length: int, sensed: np.ndarray, reserved: np.ndarray
) -> set[tuple[int, int]]:
    """The resources among which chance decides, by the rules one after the other."""
    p = radio.parameters
    step = 1 if p.overlapping else length
    places = [
        (now + n, first)
        for n in range(p.first_ms, min(p.last_ms, p.interval_ms) + 1)
        for first in range(0, p.sub_channels - length + 1, step)
    ]
    mean_mw: dict[tuple[int, int], float] = {}
    rsrp_mw: dict[tuple[int, int], float] = {}
    for when, first in places:
        past = [
            [sensed[(when - 100 * k) % MEMORY, 0, s] for k in range(1, 11)]
            for s in range(first, first + length)
        ]
        mean_mw[when, first] = sum(map(sum, past))
        rsrp = max(reserved[when % p.interval_ms, 0, s] for s in range(first, first + length))
        if p.reserved_by_mean and rsrp > 0.0:
            rsrp = max(sum(one) / 10.0 for one in past) / (12 * p.blocks)
        rsrp_mw[when, first] = rsrp
    possible = [one for one in places if np.isfinite(mean_mw[one])]
    among = len(possible) if p.best_of_possible else len(places)
    wanted = min(int(np.ceil(p.best_ratio * among)), len(possible))
    limit_dbm = p.reserved_dbm
    while len(free := [one for one in possible if rsrp_mw[one] <= 10 ** (0.1 * limit_dbm)]) < wanted:
        limit_dbm += 10.0 * np.log10(2.0)
    return set(sorted(free, key=mean_mw.__getitem__)[:wanted])


def surroundings(radio: Sidelink, seed: int, sent: int) -> tuple[np.ndarray, np.ndarray]:
    """Power sensed and reserved as chance has it, all different; ``sent`` subframes of its own."""
    rng = np.random.default_rng(seed)
    p = radio.parameters
    sensed = 10.0 ** (0.1 * rng.uniform(-110.0, -70.0, (MEMORY, 1, p.sub_channels)))
    sensed[rng.choice(MEMORY, sent, replace=False)] = np.inf
    reserved = 10.0 ** (0.1 * rng.uniform(-130.0, -90.0, (p.interval_ms, 1, p.sub_channels)))
    reserved[rng.random((p.interval_ms, 1, p.sub_channels)) < 0.3] = 0.0
    return sensed.astype(np.float32), reserved.astype(np.float32)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    by_mean=st.booleans(),
    of_possible=st.booleans(),
    overlapping=st.booleans(),
    length=st.integers(1, 3),
    sent=st.sampled_from([0, 3, 60]),
)
def test_chance_decides_among_the_resources_that_the_rules_leave(
    seed: int, *, by_mean: bool, of_possible: bool, overlapping: bool, length: int, sent: int
) -> None:
    radio = radio_of(
        reserved_by_mean=by_mean,
        best_of_possible=of_possible,
        overlapping=overlapping,
        last_ms=20,
        sub_channels=3,
    )
    sensed, reserved = surroundings(radio, seed, sent)
    left = candidates(radio, 777, length, sensed, reserved)
    random = np.array([seed], dtype=np.uint64)
    chosen = {chosen_by(radio, 777, length, sensed, reserved, random=random) for _ in range(DRAWS)}
    assert chosen == left


def test_the_share_of_possible_resources_is_smaller_where_the_vehicle_was_sending() -> None:
    """Of 20 resources it sensed 10: a fifth of all is four, of those it sensed two."""
    sensed = np.full((MEMORY, 1, 1), 1e-9, dtype=np.float32)
    sensed[1:11] = np.inf
    reserved = np.zeros((100, 1, 1), dtype=np.float32)
    sensed *= np.linspace(1.0, 2.0, MEMORY, dtype=np.float32)[:, None, None]
    for of_possible, wanted in ((False, 4), (True, 2)):
        radio = radio_of(best_of_possible=of_possible, last_ms=20, sub_channels=1)
        random = np.array([5], dtype=np.uint64)
        chosen = {chosen_by(radio, 0, 1, sensed, reserved, random=random) for _ in range(DRAWS)}
        assert len(chosen) == wanted


def test_a_reservation_made_of_late_counts_by_a_tenth_where_the_mean_decides() -> None:
    """All but two resources are reserved 8 dB above the bound, heard once: their mean is 2 dB below."""
    once_mw = 10 ** (0.1 * (-110.0 + 8.0)) * 120
    sensed = np.zeros((MEMORY, 1, 1), dtype=np.float32)
    sensed[MEMORY - 100 + 3 : MEMORY - 100 + 21] = once_mw
    sensed[1:3] = once_mw  # of another second: heard as loud, never reserved
    reserved = np.zeros((100, 1, 1), dtype=np.float32)
    reserved[3:21] = once_mw / 120
    quietest = np.arange(3, 21)
    sensed[MEMORY - 100 + quietest] *= np.linspace(0.9, 0.95, 18, dtype=np.float32)[:, None, None]
    found = {}
    for by_mean in (False, True):
        radio = radio_of(reserved_by_mean=by_mean, last_ms=20, sub_channels=1, best_ratio=0.1)
        random = np.array([5], dtype=np.uint64)
        chosen = {chosen_by(radio, 0, 1, sensed, reserved, random=random) for _ in range(DRAWS)}
        found[by_mean] = {when for when, _ in chosen}
    assert found == {False: {1, 2}, True: {3, 4}}


def test_equally_quiet_resources_are_equally_likely() -> None:
    """Nothing sensed at all, without noise: a fifth is kept, and every resource may be in it."""
    radio = radio_of(noise_counts=False, last_ms=20, sub_channels=1)
    sensed = np.zeros((MEMORY, 1, 1), dtype=np.float32)
    reserved = np.zeros((100, 1, 1), dtype=np.float32)
    random = np.array([5], dtype=np.uint64)
    chosen = [chosen_by(radio, 0, 1, sensed, reserved, random=random)[0] for _ in range(4000)]
    share = np.bincount(chosen, minlength=21)[1:] / 4000
    assert np.abs(share - 0.05).max() < 0.02  # five standard deviations


def test_power_below_the_noise_reads_zero_where_noise_does_not_count() -> None:
    """Three vehicles: one sends, one hears it well, one is so far that it is weaker than noise."""
    place_m = np.array([[0.0, 0.0], [100.0, 0.0], [60_000.0, 0.0]])
    for counts in (True, False):
        radio = radio_of(noise_counts=counts, margin_db=40.0)
        noise_mw = radio.constants.pool.noise_mw
        assert radio.range_m < place_m[2, 0] or radio.range_m > place_m[1, 0]
        _, after = radio.step(radio.init(3, np.random.default_rng(1)), message(80), place_m, 0.2)
        sensed = after.sensed[:, 1:]
        quiet = noise_mw if counts else 0.0
        assert sensed[:, 0].max() > 1e3 * noise_mw
        assert sensed[:, 1] == pytest.approx(quiet, abs=noise_mw)
        assert np.median(sensed) == pytest.approx(quiet)
        assert counts or not np.any((sensed > 0.0) & (sensed < noise_mw))


def test_a_vehicle_that_chooses_first_by_chance_minds_no_reservation_once() -> None:
    """Three phases of four are loud and reserved: chance alone takes one of them three times in four."""
    loud, place_m = np.arange(25, 100), np.array([[0.0, 0.0], [50.0, 0.0]])
    for by_chance, least, most in ((False, 0, 0), (True, 120, 180)):
        radio = radio_of(first_by_chance=by_chance, sub_channels=1)
        first = later = 0
        for seed in range(200):
            state = radio.init(2, np.random.default_rng(seed))
            state.sensed[loud, 0] = 1e-6
            state.reserved[loud, 0] = 1e-8
            _, state = radio.step(state, message(80), place_m, 0.001)
            first += int(state.grant[0, NEXT]) % 100 in loud
            state.grant[0, BAND] = -1
            _, state = radio.step(state, message(80, 0.0015), place_m, 0.002)
            later += int(state.grant[0, NEXT]) % 100 in loud
        assert least <= first <= most
        assert later == 0


def test_a_message_takes_sub_channels_that_it_does_not_fill() -> None:
    """300 bytes fill two sub-channels; of the third only leakage is heard, and it is reserved too."""
    radio = radio_of(wilab_sidelink_parameters())
    assert radio.parameters.length(np.array([1, 300])).tolist() == [3, 3]
    place_m = np.array([[0.0, 0.0], [100.0, 0.0]])
    heard, after = radio.step(radio.init(2, np.random.default_rng(1)), message(300), place_m, 0.101)
    assert heard.receiver.tolist() == [1]
    at = round(1e3 * heard.t_s[0]) - 1
    mw = after.sensed[at % 100, 1].reshape(10, -1)[at // 100]
    assert mw[0] == pytest.approx(mw[1])
    assert 2.0 * mw[0] == pytest.approx(10 ** (0.1 * heard.rssi_dbm[0]), rel=1e-5)
    assert np.all(mw[2:] < 0.02 * mw[0])
    assert np.count_nonzero(after.reserved[at % 100, 1]) == 3


def test_a_message_that_becomes_ready_in_its_own_subframe_does_not_push_the_last_one_out() -> None:
    """Of 400 vehicles four or so choose the last subframe of the window: the one of the next message."""
    place_m = np.column_stack([np.linspace(0.0, 16e6, 400), np.zeros(400)])
    radio = radio_of()
    state = radio.init(400, np.random.default_rng(3))
    expired, waited = 0, 0
    for k in range(6):
        batch = Transmissions(
            np.arange(400),
            np.full(400, 0.1 * k + 0.0505),
            size_bytes=np.full(400, 80),
            power_dbm=np.full(400, 23.0),
            message_id=np.arange(400) + 1000 * k,
        )
        heard, state = radio.step(state, batch, place_m, round(0.1 * (k + 1), 3))
        expired += heard.expired.size
        waited += np.count_nonzero(state.grant[:, NEXT] % 100 == 50)
    assert waited > 0
    assert expired == 0


@pytest.mark.parametrize(
    "change", [{"least_sub_channels": 0}, {"least_sub_channels": 6}, {"control_blocks": -1}]
)
def test_impossible_sizes_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="must"):
        replace(SidelinkParameters(), **change)

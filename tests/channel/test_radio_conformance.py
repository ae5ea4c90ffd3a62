"""The contract of a radio, over every radio: any traffic, state in, state out, nothing from nowhere."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.dsrc_parameters import DsrcParameters
from modelcast.channel.erasure import GilbertElliott, IndependentErasure
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.error_models import ThresholdErrorModel
from modelcast.channel.external_radio import AbstractExternalRadio, AbstractRadioSimulator, CarriedFrames
from modelcast.channel.frame_radio import AbstractFrameRadio
from modelcast.channel.nr import Nr
from modelcast.channel.nr_parameters import NrParameters
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import ORDINARY, OUTCOMES, AbstractRadio, Grant, Receptions, Transmissions
from modelcast.channel.sidelink import Sidelink
from modelcast.channel.sidelink_parameters import SidelinkParameters
from modelcast.channel.tabulated import TabulatedRadio, measured_table
from modelcast.core.parts import Parts

CLEAR = Propagation(LogDistance(2.0), None, None)
"""Free space, no luck: 300 m lose 97.4 dB."""

LAST_S, QUIET_S = 0.2, 0.6
"""All traffic is ready before the one; by the other all of it has been sent."""

ROUNDING_S = 1e-9
"""Sums of times in double precision."""

TABLE_STEP_DB = 0.01
"""Path loss is tabulated every 0.5 m."""


@dataclass(frozen=True)
class Case:
    """A radio, and what the contract needs to know of it."""

    radio: AbstractRadio[Any]
    airtime_s: Callable[[np.ndarray], np.ndarray]
    """Of sizes (N,), (N,)."""
    range_m: float
    largest_bytes: int = 600
    heeds: tuple[str, ...] = ()
    """Which wishes of a transmission change what it does."""


@dataclass(frozen=True)
class FrameCase(Case):
    """A radio that simulates every frame: it knows powers, and a vehicle that sends is deaf."""

    sensitivity_dbm: float = 0.0
    clear: Callable[[float], AbstractRadio[Any]] = Dsrc
    """The radio with a given sensitivity [dBm] in free space, without luck."""


def dsrc() -> FrameCase:
    radio = Dsrc(DsrcParameters(bins=40, weak_margin_db=10.0))  # as for all, so that gain is gain

    def clear(sensitivity_dbm: float) -> Dsrc:
        return Dsrc(DsrcParameters(sensitivity_dbm=sensitivity_dbm), CLEAR, ThresholdErrorModel(6.0))

    return FrameCase(
        radio,
        radio.parameters.airtime_s,
        radio.range_m,
        sensitivity_dbm=radio.parameters.sensitivity_dbm,
        clear=clear,
    )


def sidelink(*heeds: str, **changes: Any) -> FrameCase:
    radio = Sidelink(SidelinkParameters(bins=80, **changes))

    def clear(sensitivity_dbm: float) -> Sidelink:
        parameters = SidelinkParameters(sensitivity_dbm=sensitivity_dbm, **changes)
        return Sidelink(parameters, CLEAR, ThresholdErrorModel(5.0))

    return FrameCase(
        radio,
        lambda size_bytes: np.full(size_bytes.shape, 1e-3),
        radio.range_m,
        largest_bytes=400,
        sensitivity_dbm=radio.parameters.sensitivity_dbm,
        clear=clear,
        heeds=("grant", *heeds),
    )


def nr(**changes: Any) -> FrameCase:
    """One that heeds which grant is asked for, since its own settings say another."""
    parameters = replace(NrParameters(bins=80), **changes)
    radio = Nr(parameters)

    def clear(sensitivity_dbm: float) -> Nr:
        deaf = replace(parameters, sensitivity_dbm=sensitivity_dbm, bins=10)
        return Nr(deaf, CLEAR, ThresholdErrorModel(5.0))

    return FrameCase(
        radio,
        lambda size_bytes: np.full(size_bytes.shape, 1e-3 / parameters.slots_a_ms),
        radio.range_m,
        largest_bytes=min(parameters.largest_bytes, 400),
        heeds=() if parameters.dynamic else ("grant",),
        sensitivity_dbm=parameters.sensitivity_dbm,
        clear=clear,
    )


def tabulated() -> Case:
    table = measured_table()
    radio = TabulatedRadio(table)
    return Case(radio, radio.airtime_s, table.bin_m * table.reception_ratios.shape[1])


def erasure(channel: IndependentErasure | GilbertElliott) -> Case:
    return Case(ErasureRadio(channel, 500.0), lambda size_bytes: 40e-6 + 8e-6 * size_bytes / 6.0, 500.0)


class Tosses(AbstractRadioSimulator):
    """A simulator in plain Python: every pair in reach loses with a chance of 0.3, as its own dice say."""

    def __init__(self, stations: int, seed: int, reach_m: float) -> None:
        self.stations, self.dice, self.reach_m = stations, np.random.default_rng(seed), reach_m
        self.now_s = 0.0

    def carry(self, transmissions: Transmissions, position_m: np.ndarray, until_t_s: float) -> CarriedFrames:
        """Toss for every pair."""
        rows: list[tuple[int, int, float, int]] = []
        busy_s, ended, expired = np.zeros(self.stations), list[int](), list[int]()
        for number, sender, ready_s in zip(
            transmissions.message_id.tolist(),
            transmissions.sender.tolist(),
            transmissions.ready_s.tolist(),
            strict=True,
        ):
            luck = self.dice.random(self.stations)
            if np.isnan(position_m[sender]).any():
                expired.append(number)
                continue
            ended.append(number)
            for receiver in range(self.stations):
                apart_m = np.hypot(*(position_m[receiver] - position_m[sender]))
                if receiver == sender or not apart_m < self.reach_m:
                    continue
                lost = luck[receiver] < 0.3
                rows.append((number, receiver, ready_s, OUTCOMES.index("hidden") if lost else 0))
                busy_s[receiver] += 1e-4
        found, span_s = np.array(rows).reshape(-1, 4), max(until_t_s - self.now_s, 1e-9)
        self.now_s = until_t_s
        return CarriedFrames(
            found[:, 0].astype(np.int64),
            found[:, 1].astype(np.int64),
            end_s=found[:, 2],
            rssi_dbm=np.full(len(rows), np.nan),
            outcome=found[:, 3].astype(np.int64),
            ended=np.array(ended, dtype=np.int64),
            expired=np.array(expired, dtype=np.int64),
            busy_ratio=np.minimum(busy_s / span_s, 1.0),
        )


class TossRadio(AbstractExternalRadio):
    """The radio that `Tosses` is."""

    def start(self, stations: int, seed: int) -> AbstractRadioSimulator:
        """Start with these dice."""
        return Tosses(stations, seed, self.reach_m)


FRAME_RADIOS = {
    "dsrc": dsrc(),
    "sidelink": sidelink(),
    "sidelink-one-shot": sidelink(one_shot=True),
    "sidelink-deployed": sidelink("next_s", transmissions=2, interleaved=True, interval_by_next=True),
    "sidelink-by-next": sidelink("next_s", interval_by_next=True, grant_by_next=True),
    "nr": nr(),
    "nr-dynamic": nr(dynamic=True),
    "nr-copies": nr(transmissions=3, spacing_khz=30, bandwidth_mhz=20),
}
RADIOS: dict[str, Case] = {
    **FRAME_RADIOS,
    "tabulated": tabulated(),
    "erasure": erasure(IndependentErasure(0.3)),
    "erasure-bursts": erasure(GilbertElliott(0.3)),
}

EXTERNAL = {"external": Case(TossRadio(), lambda size_bytes: np.zeros(size_bytes.shape), 500.0)}
"""Radios of other simulators: their clock only goes forward."""

ALL = RADIOS | EXTERNAL

every_radio = pytest.mark.parametrize("case", ALL.values(), ids=ALL.keys())
every_radio_of_states = pytest.mark.parametrize("case", RADIOS.values(), ids=RADIOS.keys())
every_frame_radio = pytest.mark.parametrize("case", FRAME_RADIOS.values(), ids=FRAME_RADIOS.keys())


def batch(sender: list[int], ready_s: list[float], power_dbm: float = 20.0) -> Transmissions:
    """Return messages of 80 bytes with the numbers 100, 101, ..."""
    number = len(sender)
    return Transmissions(
        np.array(sender, dtype=np.int64),
        np.array(ready_s, dtype=np.float64),
        size_bytes=np.full(number, 80, dtype=np.int64),
        power_dbm=np.full(number, power_dbm),
        message_id=100 + np.arange(number, dtype=np.int64),
    )


def line(*east_m: float) -> np.ndarray:
    return np.column_stack([np.array(east_m), np.zeros(len(east_m))])


def random_traffic(
    seed: int,
    vehicles: int,
    messages: int,
    *,
    last_s: float = LAST_S,
    largest: int = 400,
) -> tuple[Transmissions, np.ndarray]:
    """Return messages with the numbers 0, 1, ... at random times, and places on 3 km of road."""
    rng = np.random.default_rng(seed)
    traffic = Transmissions(
        rng.integers(0, vehicles, messages),
        np.sort(rng.uniform(0.0, last_s, messages)),
        size_bytes=rng.integers(50, largest, messages),
        power_dbm=rng.uniform(10.0, 23.0, messages),
        message_id=np.arange(messages, dtype=np.int64),
    )
    return traffic, np.column_stack([rng.uniform(0.0, 3000.0, vehicles), rng.uniform(0.0, 20.0, vehicles)])


def part(traffic: Transmissions, inside: np.ndarray) -> Transmissions:
    """Return the messages where ``inside`` (N,) holds."""
    return replace(traffic, **{one.name: getattr(traffic, one.name)[inside] for one in fields(traffic)})


def joined(pieces: list[Receptions]) -> Receptions:
    """Return what several intervals in a row gave."""
    columns = {
        one.name: [getattr(piece, one.name) for piece in pieces]
        for one in fields(Receptions)
        if one.name != "outcomes"
    }
    whole = {name: np.concatenate(held) for name, held in columns.items()}
    outcomes = np.sum([piece.outcomes for piece in pieces], axis=0)
    return Receptions(whole.pop("message_id"), whole.pop("sender"), outcomes=outcomes, **whole)


def run(
    radio: AbstractRadio[Any],
    traffic: Transmissions,
    place_m: np.ndarray,
    seed: int = 1,
) -> Receptions:
    """Carry the traffic, and go on until all of it has been sent."""
    state = radio.init(place_m.shape[0], np.random.default_rng(seed))
    heard, state = radio.step(state, traffic, place_m, LAST_S)
    rest, _ = radio.step(state, batch([], []), place_m, QUIET_S)
    return joined([heard, rest])


def assert_same(one: Any, other: Any) -> None:
    """Two dataclasses hold the same numbers, where those are compared."""
    for name in (held.name for held in fields(one) if held.compare):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name


any_traffic = given(
    seed=st.integers(0, 10_000),
    vehicles=st.integers(2, 80),
    messages=st.integers(1, 300),
    last_s=st.sampled_from((0.05, LAST_S)),
)


@every_radio
@settings(max_examples=25)
@any_traffic
def test_each_reception_has_its_one_transmission(
    case: Case, seed: int, vehicles: int, messages: int, last_s: float
) -> None:
    """It comes from who sent it, to another, once, in order of time, not before its last bit."""
    traffic, place_m = random_traffic(seed, vehicles, messages, last_s=last_s, largest=case.largest_bytes)
    heard = run(case.radio, traffic, place_m, seed)
    assert np.array_equal(traffic.sender[heard.message_id], heard.sender)
    assert np.all(heard.sender != heard.receiver)
    pairs = heard.message_id * vehicles + heard.receiver
    assert np.unique(pairs).size == pairs.size
    assert np.all(np.diff(heard.t_s) >= 0)
    ready_s = traffic.ready_s + case.airtime_s(traffic.size_bytes)
    assert np.all(heard.t_s >= ready_s[heard.message_id] - ROUNDING_S)
    assert not set(heard.expired.tolist()) & set(heard.message_id.tolist())


@every_radio
@settings(max_examples=25)
@any_traffic
def test_each_pair_in_reach_of_a_frame_has_one_outcome(
    case: Case, seed: int, vehicles: int, messages: int, last_s: float
) -> None:
    traffic, place_m = random_traffic(seed, vehicles, messages, last_s=last_s, largest=case.largest_bytes)
    heard = run(case.radio, traffic, place_m, seed)
    sent = np.ones(messages, dtype=np.bool_)
    sent[heard.expired] = False
    apart_m = np.hypot(*(place_m[:, None] - place_m[None]).transpose(2, 0, 1))
    near = (apart_m <= case.range_m).sum(axis=1) - 1
    assert heard.outcomes.sum() == near[traffic.sender[sent]].sum()
    assert heard.outcomes[:, 0].sum() == heard.size


@every_frame_radio
@settings(max_examples=25)
@any_traffic
def test_who_sends_hears_nothing_meanwhile(
    case: FrameCase, seed: int, vehicles: int, messages: int, last_s: float
) -> None:
    """No frame that a vehicle receives overlaps a frame of its own that anybody received."""
    traffic, place_m = random_traffic(seed, vehicles, messages, last_s=last_s, largest=case.largest_bytes)
    heard = run(case.radio, traffic, place_m, seed)
    airtime_s = case.airtime_s(traffic.size_bytes)
    assert_half_duplex(heard, airtime_s[heard.message_id])


@every_frame_radio
def test_a_crowd_that_sends_all_the_time_is_half_duplex(case: FrameCase) -> None:
    """Thirty in reach of each other send every 100 ms for three seconds."""
    phase_s = np.sort(np.random.default_rng(0).uniform(0.0, 0.1, 30))
    place_m = line(*np.linspace(0.0, 200.0, 30))
    state = case.radio.init(30, np.random.default_rng(0))
    pieces: list[Receptions] = []
    for k in range(30):
        heard, state = case.radio.step(
            state, batch(list(range(30)), (0.1 * k + phase_s).tolist()), place_m, round(0.1 * (k + 1), 3)
        )
        pieces.append(heard)
    heard = joined(pieces)
    assert heard.size > 10_000
    assert_half_duplex(heard, np.full(heard.size, case.airtime_s(np.array([80]))[0]))


def assert_half_duplex(heard: Receptions, airtime_s: np.ndarray) -> None:
    """Check the receptions of every vehicle against what others received from it; airtimes are (R,)."""
    for vehicle in np.unique(heard.sender):
        own, got = heard.sender == vehicle, heard.receiver == vehicle
        end_s, first = np.unique(heard.t_s[own], return_index=True)
        start_s = end_s - airtime_s[own][first]
        from_s, to_s = heard.t_s[got] - airtime_s[got], heard.t_s[got]
        overlap = (from_s[:, None] < end_s - ROUNDING_S) & (to_s[:, None] > start_s + ROUNDING_S)
        assert not overlap.any()


@every_frame_radio
@settings(max_examples=25)
@any_traffic
def test_nobody_receives_more_than_was_sent_or_less_than_it_can_hear(
    case: FrameCase, seed: int, vehicles: int, messages: int, last_s: float
) -> None:
    """Whatever fading and shadowing do; each power belongs to its own message."""
    traffic, place_m = random_traffic(seed, vehicles, messages, last_s=last_s, largest=case.largest_bytes)
    heard = run(case.radio, traffic, place_m, seed)
    assert np.all(heard.rssi_dbm >= case.sensitivity_dbm - 1e-9)
    assert np.all(heard.rssi_dbm <= traffic.power_dbm[heard.message_id])


@every_frame_radio
def test_in_free_space_power_arrives_less_the_path_loss(case: FrameCase) -> None:
    place_m = line(0.0, 30.0, 100.0, 250.0)
    heard = run(case.clear(-95.0), batch([0], [0.01], power_dbm=20.0), place_m)
    assert sorted(heard.receiver.tolist()) == [1, 2, 3]
    loss_db = 47.86 + 20.0 * np.log10(place_m[heard.receiver, 0])
    assert heard.rssi_dbm == pytest.approx(20.0 - loss_db, abs=TABLE_STEP_DB)


@every_frame_radio
def test_beyond_sensitivity_nothing_is_heard(case: FrameCase) -> None:
    heard = run(case.clear(-60.0), batch([0], [0.01]), line(0.0, 200.0))
    assert heard.size == 0
    assert heard.outcomes[:, 2].sum() == 1


@every_radio
@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), low=st.floats(0.0, 20.0), more=st.floats(0.1, 3.0))
def test_more_power_never_means_fewer_receptions_when_alone(
    case: Case, seed: int, low: float, more: float
) -> None:
    place_m = np.random.default_rng(seed).uniform(0.0, 900.0, (50, 2))
    weak, strong = (
        run(case.radio, batch([0], [0.01], power_dbm=power_dbm), place_m, seed)
        for power_dbm in (low, low + more)
    )
    assert set(weak.receiver.tolist()) <= set(strong.receiver.tolist())


@every_frame_radio
@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_luck_does_not_depend_on_who_else_is_in_reach(case: FrameCase, seed: int) -> None:
    """Ten more listeners change nothing for the others."""
    place_m = np.random.default_rng(seed).uniform(0.0, 900.0, (50, 2))
    few, many = (run(case.radio, batch([0], [0.01]), place_m[:number], seed) for number in (40, 50))
    among = many.receiver < 40
    assert dict(zip(few.receiver.tolist(), few.rssi_dbm.tolist(), strict=True)) == dict(
        zip(many.receiver[among].tolist(), many.rssi_dbm[among].tolist(), strict=True)
    )


@every_radio
@settings(max_examples=10)
@any_traffic
def test_one_seed_gives_one_result(
    case: Case, seed: int, vehicles: int, messages: int, last_s: float
) -> None:
    traffic, place_m = random_traffic(seed, vehicles, messages, last_s=last_s, largest=case.largest_bytes)
    assert_same(run(case.radio, traffic, place_m, seed), run(case.radio, traffic, place_m, seed))


@every_radio
def test_another_seed_gives_another_result(case: Case) -> None:
    traffic, place_m = random_traffic(5, 60, 200)
    one, other = (run(case.radio, traffic, place_m, seed) for seed in (1, 2))
    assert not np.array_equal(one.outcomes, other.outcomes)


@every_radio_of_states
def test_the_given_state_and_generator_are_left_alone(case: Case) -> None:
    """Also one in the middle of traffic; `init` draws once, whatever the size of the fleet."""
    traffic, place_m = random_traffic(5, 40, 200, last_s=0.05)
    rng, other = np.random.default_rng(0), np.random.default_rng(0)
    state = case.radio.init(40, rng)
    case.radio.init(3, other)
    drawn = rng.bit_generator.state
    assert drawn == other.bit_generator.state
    later = replace(traffic, ready_s=traffic.ready_s + 0.05)
    for end_s, messages in ((0.05, traffic), (0.1, later)):
        kept = {one.name: np.copy(getattr(state, one.name)) for one in fields(state)}
        first, after = case.radio.step(state, messages, place_m, end_s)
        again, twin = case.radio.step(state, messages, place_m, end_s)
        assert_same(first, again)
        assert_same(after, twin)
        for name, value in kept.items():
            assert np.array_equal(getattr(state, name), value, equal_nan=True), name
        state = after
    assert rng.bit_generator.state == drawn


@every_radio
def test_carrying_gives_what_stepping_gives(case: Case) -> None:
    """In whatever parts."""
    traffic, place_m = random_traffic(6, 40, 200, last_s=0.05)
    state, spent = (case.radio.init(40, np.random.default_rng(0)) for _ in range(2))
    for end_s, messages in ((0.05, traffic), (0.1, batch([], [])), (0.3, batch([], []))):
        heard, state = case.radio.step(state, messages, place_m, end_s)
        carried, spent = case.radio.carry(spent, messages, place_m, end_s, Parts(3))
        assert_same(heard, carried)
        assert_same(state, spent)


@every_radio
@pytest.mark.parametrize("threads", [1, 2])
def test_telling_gives_what_carrying_gives(case: Case, threads: int) -> None:
    """Told of in order, and all of it before the interval is over, whichever thread tells."""
    traffic, place_m = random_traffic(6, 40, 200, last_s=0.05)
    state, twin = (case.radio.init(40, np.random.default_rng(0)) for _ in range(2))
    with ThreadPoolExecutor(threads) as pool:
        parts = Parts(3, pool) if threads > 1 else Parts(3)
        for end_s, messages in ((0.05, traffic), (0.1, batch([], [])), (0.3, batch([], []))):
            heard, state = case.radio.carry(state, messages, place_m, end_s)
            told = list[Receptions]()
            given = (twin, messages, place_m, end_s, parts)
            received, twin = case.radio.carry_and_tell(*given, told.append)
            assert_same(heard, received)
            assert_same(state, twin)
            pieces = Receptions.joined(told, outcomes=heard.outcomes, expired=heard.expired)
            assert_same(heard, pieces)


@every_frame_radio
def test_cutting_time_into_pieces_changes_nothing(case: FrameCase) -> None:
    """What straddles a step goes on: forty steps and one step give the same receptions and counts."""
    traffic, place_m = random_traffic(11, 60, 400, last_s=0.05)
    state = case.radio.init(60, np.random.default_rng(3))
    whole, _ = case.radio.step(state, traffic, place_m, 0.12)
    pieces: list[Receptions] = []
    for k in range(40):
        until_s = 0.12 * (k + 1) / 40
        inside = (traffic.ready_s >= state.t_s) & (traffic.ready_s < until_s)
        heard, state = case.radio.step(state, part(traffic, inside), place_m, until_s)
        pieces.append(heard)
    cut = joined(pieces)
    assert cut.t_s == pytest.approx(whole.t_s)
    assert cut.outcomes.tolist() == whole.outcomes.tolist()
    assert sorted(cut.expired.tolist()) == sorted(whole.expired.tolist())


@every_radio
def test_an_absent_vehicle_neither_sends_nor_hears(case: Case) -> None:
    heard = run(case.radio, batch([0, 1], [0.01, 0.02]), line(0.0, np.nan, 20.0))
    assert heard.receiver.tolist() == [2]
    assert heard.message_id.tolist() == [100]
    assert heard.expired.tolist() == [101]
    assert heard.outcomes.sum() == 1


@every_frame_radio
def test_a_newer_message_takes_the_place_of_one_that_waits(case: FrameCase) -> None:
    """The first is on the air, or far from it, when the second vehicle has two messages in a row."""
    heard = run(case.radio, batch([0, 1, 1], [0.01, 0.01005, 0.0101]), line(0.0, 30.0))
    assert heard.expired.tolist() == [101]
    assert sorted(heard.message_id.tolist()) == [100, 102]


@every_radio
def test_busy_ratios_lie_within_0_and_1_and_are_0_without_traffic(case: Case) -> None:
    traffic, place_m = random_traffic(9, 60, 300, last_s=0.1)
    state = case.radio.init(60, np.random.default_rng(0))
    assert case.radio.channel_busy_ratio(state).tolist() == [0.0] * 60
    _, after = case.radio.step(state, traffic, place_m, 0.1)
    ratio = case.radio.channel_busy_ratio(after)
    assert ratio.shape == (60,)
    assert np.all((ratio >= 0.0) & (ratio <= 1.0))
    assert ratio.max() > 0.0
    ratio[:] = -1.0
    assert case.radio.channel_busy_ratio(after).min() >= 0.0


@every_radio
def test_steps_that_do_not_fit_the_state_are_refused(case: Case) -> None:
    state = case.radio.init(2, np.random.default_rng(0))
    place_m = line(0.0, 10.0)
    for traffic, where, until_s, match in (
        (batch([0], [0.2]), place_m, 0.1, "ready_s must lie"),
        (batch([2], [0.0]), place_m, 0.1, "sender must be below"),
        (batch([0], [0.0]), place_m[:1], 0.1, "position_m must be"),
        (batch([], []), place_m, -0.1, "until_t_s"),
    ):
        with pytest.raises(ValueError, match=match):
            case.radio.step(state, traffic, where, until_s)
    with pytest.raises(ValueError, match="vehicles"):
        case.radio.init(0, np.random.default_rng(0))


@every_frame_radio
def test_more_power_than_the_radio_has_is_refused(case: FrameCase) -> None:
    state = case.radio.init(2, np.random.default_rng(0))
    with pytest.raises(ValueError, match="max_power_dbm"):
        case.radio.step(state, batch([0], [0.0], power_dbm=30.0), line(0.0, 10.0), 0.1)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"ready_s": np.array([0.2, 0.1])}, "must not fall"),
        ({"size_bytes": np.array([0, 10])}, "at least 1"),
        ({"message_id": np.array([-1, 1])}, "not be negative"),
        ({"power_dbm": np.array([np.nan, 1.0])}, "finite"),
        ({"sender": np.array([1])}, "one length"),
        ({"priority": np.array([0, 8])}, r"priority must lie within 0\.\.7"),
        ({"priority": np.array([1])}, "one length"),
        ({"grant": np.array([-1, 0])}, "grant must lie"),
        ({"next_s": np.array([0.01, 1.0])}, "after ready_s"),
        ({"next_s": np.array([np.nan, 1.0])}, "after ready_s"),
    ],
)
def test_impossible_transmissions_are_refused(change: dict[str, np.ndarray], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        replace(batch([0, 1], [0.01, 0.02]), **change)


def test_what_a_sender_leaves_out_radios_see_in_full() -> None:
    traffic = batch([0, 1], [0.01, 0.02])
    assert traffic.priority.tolist() == [ORDINARY, ORDINARY]
    assert traffic.next_s.tolist() == [np.inf, np.inf]
    assert traffic.grant.tolist() == [Grant.ANY, Grant.ANY]
    assert batch([], []).priority.size == 0


@every_radio
def test_what_a_radio_does_not_heed_changes_nothing(case: Case) -> None:
    """Priority, next message and kind of grant, save those that a case names."""
    traffic, place_m = random_traffic(4, 40, 200, largest=case.largest_bytes)
    said = {
        "priority": np.arange(200) % 8,
        "next_s": traffic.ready_s + 0.1,
        "grant": np.full(200, int(Grant.ONE_SHOT)),
    }
    unheeded = {name: column for name, column in said.items() if name not in case.heeds}
    assert_same(run(case.radio, traffic, place_m), run(case.radio, replace(traffic, **unheeded), place_m))


def test_every_radio_of_the_package_has_a_case(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    """Who adds a radio adds it to `RADIOS` or `FRAME_RADIOS`; a radio of frames to the latter."""
    assert concrete_classes(AbstractRadio) == {type(case.radio) for case in RADIOS.values()}
    assert concrete_classes(AbstractFrameRadio) == {type(case.radio) for case in FRAME_RADIOS.values()}


def crowd(stations: int = 40) -> np.ndarray:
    """Stations along 700 m and 60 m, so that a weak one is out of reach of many."""
    return np.random.default_rng(4).uniform((0.0, 0.0), (700.0, 60.0), (stations, 2))


def heard_by(radio: AbstractRadio[Any], gain_db: np.ndarray, power_dbm: float) -> Receptions:
    """What is heard of one message of station 0 among a crowd with these antennas."""
    state = radio.init(gain_db.size, np.random.default_rng(3))
    received, _ = radio.step(
        radio.fit_antennas(state, gain_db), batch([0], [0.01], power_dbm), crowd(gain_db.size), 0.4
    )
    return received


@every_radio_of_states
def test_a_vehicles_antenna_is_where_gains_begin(case: Case) -> None:
    """Gains of zero change nothing; more than a vehicle's, or one too few, are refused."""
    state = case.radio.init(3, np.random.default_rng(1))
    place_m = line(0.0, 40.0, 80.0)
    before, _ = case.radio.step(state, batch([0, 1], [0.0, 0.03]), place_m, 0.3)
    after, _ = case.radio.step(
        case.radio.fit_antennas(state, np.zeros(3)), batch([0, 1], [0.0, 0.03]), place_m, 0.3
    )
    assert np.array_equal(before.receiver, after.receiver)
    assert np.array_equal(before.rssi_dbm, after.rssi_dbm, equal_nan=True)
    with pytest.raises(ValueError, match="not above 0 dB"):
        case.radio.fit_antennas(state, np.array([0.0, 0.5, 0.0]))


@every_frame_radio
def test_a_weak_antenna_costs_its_gain_whoever_has_it(case: FrameCase) -> None:
    """10 dB at the sender, at all receivers, or less power are one and the same; at both ends it is 20 dB."""
    weak = np.full(40, -10.0)
    at_sender, at_others = np.where(np.arange(40) == 0, weak, 0.0), np.where(np.arange(40) == 0, 0.0, weak)
    quieter = heard_by(case.radio, np.zeros(40), 10.0)
    assert 5 < quieter.size < 39
    for found, expected in (
        (heard_by(case.radio, at_sender, 20.0), quieter),
        (heard_by(case.radio, at_others, 20.0), quieter),
        (heard_by(case.radio, weak, 20.0), heard_by(case.radio, np.zeros(40), 0.0)),
    ):
        loudness = dict(zip(found.receiver.tolist(), found.rssi_dbm.tolist(), strict=True))
        assert loudness == pytest.approx(
            dict(zip(expected.receiver.tolist(), expected.rssi_dbm.tolist(), strict=True)), abs=1e-6
        )


@every_frame_radio
def test_a_weak_antenna_is_no_matter_of_the_others(case: FrameCase) -> None:
    """Who has a vehicle's antenna hears a vehicle as loud, whatever phones stand about."""
    some = np.where(np.arange(40) % 3 == 1, -10.0, 0.0)
    alone, beside = heard_by(case.radio, np.zeros(40), 20.0), heard_by(case.radio, some, 20.0)
    full = {n: loud for n, loud in zip(alone.receiver.tolist(), alone.rssi_dbm.tolist(), strict=True)
            if some[n] == 0.0}  # fmt: skip
    kept = {n: loud for n, loud in zip(beside.receiver.tolist(), beside.rssi_dbm.tolist(), strict=True)
            if some[n] == 0.0}  # fmt: skip
    assert full
    assert kept == full

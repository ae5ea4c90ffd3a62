"""Another simulator as the radio: the same stations, the same figures, nothing believed unchecked."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.dsrc_parameters import DsrcParameters
from modelcast.channel.erasure import Ideal
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.external_radio import AbstractExternalRadio, AbstractRadioSimulator, CarriedFrames
from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway

NOBODY = np.empty(0, dtype=np.int64)


class Inside(AbstractRadioSimulator):
    """A radio of ours as another simulator: it keeps its state to itself, and tells of what was received."""

    def __init__(self, radio: AbstractRadio[Any], stations: int, seed: int) -> None:
        self.radio, self.state = radio, radio.init(stations, np.random.default_rng(seed))

    def carry(self, transmissions: Transmissions, position_m: np.ndarray, until_t_s: float) -> CarriedFrames:
        """Step the radio."""
        heard, self.state = self.radio.carry(self.state, transmissions, position_m, until_t_s)
        return CarriedFrames(
            heard.message_id,
            heard.receiver,
            end_s=heard.t_s,
            rssi_dbm=heard.rssi_dbm,
            outcome=np.zeros(heard.size, dtype=np.int64),
            ended=np.unique(heard.message_id),
            expired=heard.expired,
            busy_ratio=self.radio.channel_busy_ratio(self.state),
        )


class Outer(AbstractExternalRadio):
    """The radio that a simulator is; ``starts`` says which, of how many stations and which seed."""

    starts: Callable[[int, int], AbstractRadioSimulator]

    def start(self, stations: int, seed: int) -> AbstractRadioSimulator:
        """Start it."""
        return self.starts(stations, seed)


def outer(starts: Callable[[int, int], AbstractRadioSimulator], **settings: Any) -> AbstractExternalRadio:
    """A radio whose simulator is started so."""
    return type("Named", (Outer,), {"starts": staticmethod(starts)})(**settings)


class Seeded(AbstractRadio[Any]):
    """A radio of ours that takes its seed as an external one gets it."""

    def __init__(self, radio: AbstractRadio[Any]) -> None:
        self.radio = radio

    def init(self, vehicles: int, rng: np.random.Generator) -> Any:
        """State from the seed alone."""
        return self.radio.init(vehicles, np.random.default_rng(int(rng.integers(1, 2**31))))

    def step(
        self, state: Any, transmissions: Transmissions, position_m: np.ndarray, until_t_s: float
    ) -> tuple[Receptions, Any]:
        """Step the radio."""
        return self.radio.step(state, transmissions, position_m, until_t_s)

    def channel_busy_ratio(self, state: Any) -> np.ndarray:
        """As the radio says."""
        return self.radio.channel_busy_ratio(state)


def batch(sender: list[int], ready_s: list[float], first: int = 100) -> Transmissions:
    number = len(sender)
    return Transmissions(
        np.array(sender, dtype=np.int64),
        np.array(ready_s, dtype=np.float64),
        size_bytes=np.full(number, 300, dtype=np.int64),
        power_dbm=np.full(number, 20.0),
        message_id=first + np.arange(number, dtype=np.int64),
    )


def line(*east_m: float) -> np.ndarray:
    return np.column_stack([np.array(east_m), np.zeros(len(east_m))])


def driven(policy: str, radio: AbstractRadio[Any]) -> NetworkRun:
    frames = run_scenario(Highway(300.0, 100.0, warm_up_s=2.0), np.random.default_rng(4), duration_s=4.0)
    return run_network(frames, named_sender(policy), radio, NetworkSettings(warm_up_s=1.0), seed=9)


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["j2945", "j2945-mbc"])
def test_the_closed_loop_over_a_radio_outside_is_that_over_the_radio_itself(policy: str) -> None:
    """To the last bit: messages, tracks, counts of what was received, busy ratios of every step.

    Distances of a frame are those of the interval in which it ends, not in which it began.
    """
    own = driven(policy, Seeded(Dsrc()))
    other = driven(policy, outer(lambda stations, seed: Inside(Dsrc(), stations, seed)))
    assert own.sent.total[0] > 500
    for one, two in ((own.sent, other.sent), (own.tally, other.tally)):
        for name in one._fields:
            assert np.array_equal(getattr(one, name), getattr(two, name), equal_nan=True), name
    assert np.array_equal(own.series, other.series, equal_nan=True)
    assert own.outcomes[:, 0].sum() == other.outcomes[:, 0].sum()
    assert (own.expired, own.busy_ratio) == (other.expired, other.busy_ratio)


def test_counts_by_distance_are_those_of_the_radio_itself() -> None:
    """A radio that loses nothing tells of every pair, so that all of its counts can be compared."""
    radio = ErasureRadio(Ideal(), 600.0)
    place_m = np.random.default_rng(2).uniform(0.0, 900.0, (30, 2))
    place_m[7] = np.nan
    twin = outer(lambda stations, seed: Inside(radio, stations, seed), bins=12, max_power_dbm=30.0)
    states = [one.init(30, np.random.default_rng(1)) for one in (radio, twin)]
    for k in range(3):
        traffic = batch([3, 7, 1, 3], [0.1 * k, 0.1 * k, 0.1 * k + 0.05, 0.1 * k + 0.06], first=10 * k)
        (ours, states[0]), (theirs, states[1]) = (
            one.step(state, traffic, place_m, 0.1 * (k + 1))
            for one, state in zip((radio, twin), states, strict=True)
        )
        for name in (one.name for one in fields(Receptions)):
            assert np.array_equal(getattr(ours, name), getattr(theirs, name), equal_nan=True), name
        assert ours.size > 20


def test_a_simulator_does_not_go_back() -> None:
    radio = outer(lambda stations, seed: Inside(Dsrc(), stations, seed))
    before = radio.init(2, np.random.default_rng(0))
    _, after = radio.step(before, batch([0], [0.01]), line(0.0, 9.0), 0.1)
    with pytest.raises(ValueError, match=r"gone on from 0\.0 s and cannot go back"):
        radio.step(before, batch([0], [0.01]), line(0.0, 9.0), 0.1)
    heard, _ = radio.step(after, batch([1], [0.11], first=200), line(0.0, 9.0), 0.2)
    assert heard.receiver.tolist() == [0]


def test_two_runs_have_a_simulator_each() -> None:
    radio = outer(lambda stations, seed: Inside(Dsrc(), stations, seed))
    one, other = (radio.init(2, np.random.default_rng(0)) for _ in range(2))
    radio.step(one, batch([0], [0.01]), line(0.0, 9.0), 0.1)
    heard, _ = radio.step(other, batch([0], [0.01]), line(0.0, 9.0), 0.1)
    assert heard.size == 1


def test_antennas_weaker_than_a_vehicles_are_refused() -> None:
    radio = outer(lambda stations, seed: Inside(Dsrc(), stations, seed))
    state = radio.init(2, np.random.default_rng(0))
    assert radio.fit_antennas(state, np.zeros(2)) is state
    with pytest.raises(ValueError, match="no antennas weaker"):
        radio.fit_antennas(state, np.array([0.0, -3.0]))


def test_more_power_than_the_radio_has_is_refused() -> None:
    radio = outer(lambda stations, seed: Inside(Dsrc(), stations, seed), max_power_dbm=19.0)
    with pytest.raises(ValueError, match=r"max_power_dbm = 19\.0"):
        radio.step(radio.init(2, np.random.default_rng(0)), batch([0], [0.01]), line(0.0, 9.0), 0.1)


@pytest.mark.parametrize("settings", [{"distance_bin_m": 0.0}, {"bins": 0}, {"distance_bin_m": np.inf}])
def test_bins_that_are_none_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="distance_bin_m and bins"):
        outer(lambda stations, seed: Inside(Dsrc(), stations, seed), **settings)


class Says(AbstractRadioSimulator):
    """A simulator that says the same whatever it is asked."""

    def __init__(self, said: CarriedFrames) -> None:
        self.said = said

    def carry(self, transmissions: Transmissions, position_m: np.ndarray, until_t_s: float) -> CarriedFrames:
        """Say it."""
        del transmissions, position_m, until_t_s
        return self.said


TRUTH = CarriedFrames(
    np.array([100, 100]),
    np.array([1, 2]),
    end_s=np.array([0.02, 0.02]),
    rssi_dbm=np.array([-60.0, -95.0]),
    outcome=np.array([0, 3]),
    ended=np.array([100]),
    expired=np.array([101]),
    busy_ratio=np.array([0.1, 0.2, 0.3]),
)


def told(said: CarriedFrames) -> tuple[Receptions, Any]:
    """What the radio makes of it: station 0 has sent 100, station 1 has 101."""
    radio = outer(lambda *_: Says(said))
    state = radio.init(3, np.random.default_rng(0))
    return radio.step(state, batch([0, 1], [0.01, 0.012]), line(0.0, 60.0, 120.0), 0.1)


def test_what_a_simulator_says_is_taken_as_said() -> None:
    heard, state = told(TRUTH)
    assert heard.sender.tolist() == [0]
    assert heard.receiver.tolist() == [1]
    assert heard.rssi_dbm.tolist() == [-60.0]
    assert heard.expired.tolist() == [101]
    assert heard.outcomes[1:3].tolist() == [[1, 0, 0, 0, 0], [0, 0, 0, 1, 0]]
    assert heard.outcomes.sum() == 2
    assert state.busy_ratio.tolist() == [0.1, 0.2, 0.3]


def test_receptions_are_in_order_of_time_whatever_the_order_of_rows() -> None:
    heard, _ = told(replace(TRUTH, end_s=np.array([0.03, 0.02]), outcome=np.array([0, 0])))
    assert heard.receiver.tolist() == [2, 1]
    assert heard.t_s.tolist() == [0.02, 0.03]
    assert heard.rssi_dbm.tolist() == [-95.0, -60.0]


def test_numbers_of_messages_need_not_rise() -> None:
    """Station 0 has sent 100 before station 1, and station 1 has sent 7 after that."""
    said = replace(TRUTH, message_id=np.array([100, 7]), receiver=np.array([1, 0]), outcome=np.array([0, 0]))
    radio = outer(lambda *_: Says(replace(said, ended=np.array([7, 100]), expired=NOBODY)))
    traffic = replace(batch([0, 1], [0.01, 0.012]), message_id=np.array([100, 7]))
    state = radio.init(3, np.random.default_rng(0))
    heard, _ = radio.step(state, traffic, line(0.0, 60.0, 120.0), 0.1)
    assert heard.sender.tolist() == [0, 1]


def test_beyond_the_bins_is_heard_and_not_counted() -> None:
    """The end of the last bin is beyond it."""
    radio = outer(lambda *_: Says(replace(TRUTH, outcome=np.array([0, 0]))), distance_bin_m=60.0, bins=2)
    state = radio.init(3, np.random.default_rng(0))
    heard, _ = radio.step(state, batch([0, 1], [0.01, 0.012]), line(0.0, 60.0, 120.0), 0.1)
    assert heard.size == 2
    assert heard.outcomes[:, 0].tolist() == [0, 1]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"message_id": np.array([100, 102])}, "message_id must name messages on their way, got 102"),
        ({"ended": np.array([100, 7])}, "ended must name messages on their way, got 7"),
        ({"expired": np.array([99])}, "expired must name messages on their way, got 99"),
        ({"ended": NOBODY}, "rows must be those of messages in ended"),
        ({"expired": np.array([100])}, "must end or expire once"),
        ({"expired": np.array([101, 101])}, "must end or expire once"),
        ({"receiver": np.array([0, 2])}, "no station receives its own message"),
        ({"receiver": np.array([1, 1])}, "one row"),
        ({"receiver": np.array([1, 3])}, r"receiver must lie within 0\.\.2, got 1\.\.3"),
        ({"receiver": np.array([-1, 2])}, r"receiver must lie within 0\.\.2"),
        ({"outcome": np.array([0, 5])}, r"outcome must lie within 0\.\.4, got 0\.\.5"),
        ({"end_s": np.array([0.02, 0.11])}, r"end_s must be finite and not after 0\.1 s"),
        ({"end_s": np.array([0.02, np.nan])}, "end_s must be finite"),
        ({"end_s": np.array([0.02])}, "must have one length"),
        ({"busy_ratio": np.array([0.1, 0.2])}, r"busy_ratio must be \(3,\)"),
        ({"busy_ratio": np.array([0.1, 0.2, 1.1])}, r"busy_ratio must lie within 0\.\.1"),
        ({"busy_ratio": np.array([0.1, 0.2, np.nan])}, r"busy_ratio must lie within 0\.\.1"),
    ],
)
def test_what_cannot_be_is_refused_with_the_radio_and_the_time(change: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=rf"^Named at 0\.1 s: .*{match}"):
        told(replace(TRUTH, **change))


def test_a_message_is_owed_until_it_is_told_of() -> None:
    """A frame that ends in a later interval is its sender's still; once told of, it is not told again."""
    silent = replace(
        TRUTH,
        message_id=NOBODY, receiver=NOBODY, end_s=np.empty(0), rssi_dbm=np.empty(0), outcome=NOBODY,
        ended=NOBODY, expired=NOBODY,
    )  # fmt: skip
    simulator = Says(silent)
    radio, place_m = outer(lambda *_: simulator), line(0.0, 60.0, 120.0)
    state = radio.init(3, np.random.default_rng(0))
    heard, state = radio.step(state, batch([0, 1], [0.01, 0.012]), place_m, 0.1)
    assert heard.size == heard.expired.size == 0
    simulator.said = TRUTH
    heard, state = radio.step(state, batch([], []), place_m, 0.2)
    assert heard.sender.tolist() == [0]
    with pytest.raises(ValueError, match="messages on their way, got 100"):
        radio.step(state, batch([], []), place_m, 0.3)


def test_a_dsrc_with_other_bins_is_counted_in_its_own() -> None:
    """Bins are the external radio's: twenty of 10 m here, whatever the simulator behind counts by."""
    inner = Dsrc(DsrcParameters(bin_m=100.0))
    radio = outer(lambda stations, seed: Inside(inner, stations, seed), distance_bin_m=10.0, bins=20)
    state = radio.init(2, np.random.default_rng(0))
    heard, _ = radio.step(state, batch([0], [0.01]), line(0.0, 25.0), 0.1)
    assert heard.outcomes.shape == (20, 5)
    assert radio.bin_m == 10.0
    assert heard.outcomes[2].tolist() == [1, 0, 0, 0, 0]

"""A policy in NumPy decides in the station as a compiled rule does; what a station cannot do is refused."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import PolicyError
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.fleet import Fleet, Sending
from modelcast.station.policy.base import AbstractTransmitPolicy, Decisions, MessageKind, TransmitInputs
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.policy_numbers import RULE_PLAIN
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.sensing.velocity import REPORTED
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway

CARS, STEPS = 5, 200
AWAY = range(90, 110)
"""Steps at which the third car is not there: it comes back as a new one."""


@dataclass(frozen=True, slots=True)
class InNumPy(AbstractTransmitPolicy[Any]):
    """A policy of ours, asked by `decide` as another package's is."""

    rule: AbstractTransmitPolicy[Any]

    @property
    def longest_silence_s(self) -> float:
        """Of the rule [s]."""
        return self.rule.longest_silence_s

    def init(self, vehicles: int, sub_models: int) -> Any:
        """Of the rule."""
        return self.rule.init(vehicles, sub_models)

    def decide(self, state: Any, inputs: TransmitInputs, rng: np.random.Generator) -> tuple[Decisions, Any]:
        """By the rule."""
        return self.rule.decide(state, inputs, rng)


@dataclass(frozen=True, slots=True)
class Says(AbstractTransmitPolicy[FloatArray]):
    """Says the same at every instant."""

    kind: int = MessageKind.UPDATE
    in_use: int = -1
    late_s: float = 0.0
    power_dbm: float = np.nan
    rows: int = 0

    @property
    def longest_silence_s(self) -> float:
        """A step [s]."""
        return 0.1

    def init(self, vehicles: int, sub_models: int) -> FloatArray:  # noqa: ARG002
        """Calls so far."""
        return np.zeros(vehicles + self.rows)

    def decide(
        self,
        state: FloatArray,
        inputs: TransmitInputs,
        rng: np.random.Generator,  # noqa: ARG002
    ) -> tuple[Decisions, FloatArray]:
        """Say it."""
        kind = np.full(inputs.t_s.shape, self.kind)
        said = Decisions.at_once(kind, np.full(kind.shape, self.in_use), inputs.t_s)
        power_dbm = np.full(kind.shape, self.power_dbm)
        return replace(said, send_s=said.send_s + self.late_s, power_dbm=power_dbm), state + 1.0


def drive(sender: Sender, steps: int = STEPS) -> list[Sending]:
    """Let cars that accelerate and turn send."""
    fleet, rng, car = Fleet(sender, slots=CARS, seed=3), np.random.default_rng(1), np.arange(CARS)
    place_m, speed = 100.0 * rng.normal(size=(CARS, 2)), rng.uniform(5.0, 20.0, CARS)
    heading, bend = rng.uniform(0.0, 6.0, CARS), 0.2 * rng.normal(size=CARS)
    sent: list[Sending] = []
    for step in range(steps):
        acceleration, yaw_rate = np.sin(0.07 * step + car), bend * np.sin(0.03 * step)
        place_m = place_m + 0.1 * speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
        speed, heading = np.maximum(speed + 0.1 * acceleration, 0.0), heading + 0.1 * yaw_rate
        here = car != 2 if step in AWAY else car >= 0
        sent += fleet.sense(
            0.1 * step,
            car[here],
            place_m[here],
            speed_mps=speed[here],
            heading_rad=heading[here],
            acceleration_mps2=acceleration[here],
            yaw_rate_radps=yaw_rate[here],
        )
    return sent


@pytest.mark.parametrize("longest_s", [1.0, 0.5])
def test_an_error_driven_rule_in_numpy_sends_the_octets_of_the_compiled_one(longest_s: float) -> None:
    """With a bank of one nothing is left to the station, so both must agree to the bit, keep-alives too."""
    compiled = named_sender("baseline", threshold_m=0.2, keep_alive_s=longest_s)
    assert isinstance(compiled.policy, ErrorDriven)
    in_numpy = replace(compiled, policy=InNumPy(compiled.policy.alone))
    assert in_numpy.policy.numbers.rule == RULE_PLAIN
    sent = drive(compiled)
    assert {one.kind for one in sent} == {MessageKind.UPDATE, MessageKind.KEEP_ALIVE}
    silent = [replace(one, next_s=np.inf) for one in sent]  # a rule in NumPy does not say when it sends next
    assert drive(in_numpy) == silent


def test_a_timer_in_numpy_sends_as_often_as_the_compiled_one() -> None:
    """The error it is asked about is of the sample, not of the instant: a few messages move."""
    compiled = named_sender("j2945")
    counts = [len(drive(one)) for one in (compiled, replace(compiled, policy=InNumPy(compiled.policy)))]
    assert counts[1] == pytest.approx(counts[0], rel=0.01)


def test_what_is_named_is_sent_and_else_the_station_chooses() -> None:
    sender = named_sender("j2945-mbc")
    cv = [member.name for member in sender.bank.members].index("cv")
    named, free = (drive(replace(sender, policy=Says(in_use=one)), 60) for one in (cv, -1))
    assert {one.vehicle for one in named} == set(range(CARS))
    assert {len(one.octets) for one in named} != {len(one.octets) for one in free}
    assert len(named) == len(free) == 60 * CARS


def test_a_message_that_falls_due_after_the_step_waits_for_the_next() -> None:
    sent = drive(replace(named_sender("baseline"), policy=Says(late_s=0.09), jitter_s=0.0), 20)
    times_s = np.sort([one.send_s for one in sent if one.vehicle == 1])
    assert np.diff(times_s) == pytest.approx(0.1, abs=1e-9)
    assert times_s.size in {19, 20}


@pytest.mark.parametrize(
    ("policy", "told"),
    [
        (Says(kind=MessageKind.IDENTIFICATION), "kind must be nothing, an update or a keep-alive, got 2"),
        (Says(kind=7), "kind must be nothing"),
        (Says(in_use=1), "in_use must be -1, for the station's choice, or a sub-model below 1, got 1"),
        (Says(in_use=-2), "in_use must be -1"),
        (Says(late_s=0.1), "send_s must be within t_s and until_s"),
        (Says(late_s=-0.01), "send_s must be within t_s and until_s"),
        (Says(power_dbm=20.5), "power_dbm must be NaN or at most 20 dBm, got 20.5"),
        (Says(power_dbm=np.inf), "power_dbm must be NaN or at most 20 dBm"),
        (Says(in_use=0.5), "in_use must be an array of int64, got float64"),  # type: ignore[arg-type]
        (Says(kind=1.5), "kind must be an array of int64, got float64"),  # type: ignore[arg-type]
        (Says(rows=1), r"state must have 5 rows, got shape \(6,\)"),
    ],
)
def test_what_a_station_cannot_do_is_refused_by_the_policy_s_name(policy: Says, told: str) -> None:
    with pytest.raises(PolicyError, match=f"Says: .*{told}"):
        drive(replace(named_sender("baseline"), policy=policy), 3)


@dataclass(frozen=True, slots=True)
class Counting(Says):
    """Says so, and counts in steps of a half what began as whole numbers."""

    def init(self, vehicles: int, sub_models: int) -> Any:  # noqa: ARG002
        """Nothing yet."""
        return (np.zeros(vehicles, dtype=np.int64),)

    def decide(self, state: Any, inputs: TransmitInputs, rng: np.random.Generator) -> tuple[Decisions, Any]:
        """Count."""
        return Says.decide(self, np.zeros(state[0].size), inputs, rng)[0], (state[0] + 0.5,)


def test_a_state_that_would_be_cut_is_refused_by_the_policy_s_name() -> None:
    with pytest.raises(PolicyError, match=r"Counting: state\[0\] began as int64 and cannot hold float64"):
        drive(replace(named_sender("baseline"), policy=Counting()), 3)


def test_power_is_as_asked_for_but_no_more_than_the_sender_s() -> None:
    sender = replace(named_sender("baseline"), policy=Says(power_dbm=14.0))
    assert {one.power_dbm for one in drive(sender, 5)} == {14.0}
    assert {one.power_dbm for one in drive(sender.at_power(10.0), 5)} == {10.0}
    assert {one.power_dbm for one in drive(replace(sender, policy=Says()), 5)} == {20.0}


def test_threads_and_repetition_change_nothing_on_the_air() -> None:
    sender = named_sender("mbc")
    assert isinstance(sender.policy, ErrorDriven)
    sender = replace(sender, policy=InNumPy(ErrorDriven(0.2, max_inter_transmit_time_s=1.0).alone))
    road = Highway(500.0, 20.0, warm_up_s=20.0)
    frames = list(run_scenario(road, np.random.default_rng(1), duration_s=4.0))
    runs = [
        run_network(iter(frames), sender, Dsrc(), NetworkSettings(warm_up_s=1.0), seed=1, threads=threads)
        for threads in (1, 1, 3)
    ]
    assert runs[0].series[:, 1].sum() > 30.0
    for other in runs[1:]:
        np.testing.assert_array_equal(other.series, runs[0].series)


def test_a_recorded_trip_is_driven_as_by_the_compiled_rule() -> None:
    drive_ = generate_drive(seed=4, duration_s=90.0).truth
    rule = ErrorDriven(0.3, max_inter_transmit_time_s=1.0).alone
    walks = [
        TripRuntime(drive_, BASELINE_BANK, REPORTED, quantised=True, decides=decides).run(rule)
        for decides in (None, InNumPy(rule))
    ]
    assert walks[0].updates > 20
    for column in ("kind", "in_use", "update_index"):
        np.testing.assert_array_equal(getattr(walks[1], column), getattr(walks[0], column))

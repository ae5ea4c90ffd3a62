"""The contract of a transmit policy, over every policy: a fleet of any size, state in, state out."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.station.policy.base import (
    AbstractTransmitPolicy,
    Air,
    Decisions,
    MessageKind,
    Motion,
    TransmitInputs,
)
from modelcast.station.policy.cam import CamTriggering, CooperativeAwareness
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_parameters import (
    J2945Parameters,
    j2945_relaxed_parameters,
    j3161_parameters,
)
from modelcast.station.policy.measured_cam import MeasuredCam
from modelcast.station.policy.periodic import Periodic

VEHICLES, STEPS = 6, 80
PHASE_RATIO = np.linspace(0.0, 0.9, VEHICLES)

POLICIES: dict[str, AbstractTransmitPolicy[Any]] = {
    "bsm-10hz": Periodic(10.0),
    "periodic": Periodic(3.3),
    "error-driven": ErrorDriven(0.3),
    "error-driven-keep-alive": ErrorDriven(0.3, "survivor", "best", max_inter_transmit_time_s=1.0),
    "error-driven-expecting": ErrorDriven(
        0.3, identify="never", believe="expected", packet_error_ratio=0.3, approach_m=20.0
    ),
    "j2945": J2945(phase_ratio=PHASE_RATIO),
    "j2945-other-readings": J2945(
        J2945Parameters(
            density_weight=0.5, squared_exponent=False, channel_quality_weight=0.1, density_interval_s=1.0
        ),
        phase_ratio=PHASE_RATIO,
    ),
    "j2945-mbc-relaxed": J2945(j2945_relaxed_parameters(2.0), phase_ratio=PHASE_RATIO),
    "j3161": J2945(j3161_parameters(), phase_ratio=PHASE_RATIO),
    "cam": CooperativeAwareness(),
    "cam-reactive": CooperativeAwareness(control=ReactiveDcc()),
    "cam-fast-control": CooperativeAwareness(control=AdaptiveDcc(gain=0.1, relaxation=0.5)),
    "cam-uncontrolled": CooperativeAwareness(CamTriggering(0.2), control=None),
    "cam-road": MeasuredCam(),
    "cam-road-uncontrolled": MeasuredCam(control=None),
}


class Dealt(np.random.Generator):
    """Deals out numbers written down beforehand, a row a vehicle: the same alone and in a fleet."""

    def __init__(self, numbers: FloatArray, rows: slice) -> None:
        super().__init__(np.random.PCG64(0))
        self._numbers, self._rows, self._at = numbers, rows, 0

    def random(self, size: Any = None, **_: Any) -> Any:
        """Next numbers of the vehicles: (B, 3), or (B,) where one each is asked for."""
        dealt = self._numbers[self._at, self._rows]
        self._at += 1
        return dealt if isinstance(size, tuple) else dealt[:, 0]


@pytest.fixture(params=POLICIES.values(), ids=POLICIES.keys(), name="policy")
def _policy(request: pytest.FixtureRequest) -> AbstractTransmitPolicy[Any]:
    return request.param


def traffic(seed: int = 0, step_s: float = 0.05) -> list[TransmitInputs]:
    """Inputs of a fleet that moves at random, asked every step whatever it sends."""
    rng = np.random.default_rng(seed)
    speed = 10.0 + np.cumsum(rng.normal(0.0, 0.2, (STEPS, VEHICLES)), axis=0)
    heading = np.cumsum(rng.normal(0.0, 0.02, (STEPS, VEHICLES)), axis=0)
    way = np.stack([np.sin(heading), np.cos(heading)], axis=2)
    position = np.cumsum(step_s * speed[:, :, None] * way, axis=0)
    full = np.full
    return [
        TransmitInputs(
            full(VEHICLES, step_s * step),
            rng.uniform(0.0, 2.0, VEHICLES),
            silence_s=rng.uniform(0.0, 2.0, VEHICLES) if step else full(VEHICLES, np.inf),
            tracking_error_m=rng.uniform(0.0, 0.5, (VEHICLES, 1)) if step else full((VEHICLES, 1), np.inf),
            available=np.ones((VEHICLES, 1), dtype=np.bool_),
            until_s=full(VEHICLES, step_s * (step + 1)),
            motion=Motion(
                position[step],
                speed[step],
                heading_rad=heading[step],
                critical=rng.random(VEHICLES) < 0.02,
            ),
            air=Air(
                rng.uniform(0.2, 1.0, VEHICLES),
                rng.integers(0, 200, VEHICLES).astype(np.float64),
                packet_error_ratio=rng.choice([np.nan, 0.1, 0.6], VEHICLES),
                airtime_s=full(VEHICLES, 4e-4),
            ),
        )
        for step in range(STEPS)
    ]


def part(record: Any, rows: slice) -> Any:
    """Inputs of some of the vehicles."""
    values = {
        field.name: part(value, rows) if isinstance(value, Motion | Air) else value[rows]
        for field in fields(record)
        if (value := getattr(record, field.name)) is not None
    }
    return type(record)(**values)


def run(
    policy: AbstractTransmitPolicy[Any], inputs: list[TransmitInputs], rng: np.random.Generator
) -> list[Decisions]:
    """Decisions of the whole fleet in the inputs."""
    state = policy.init(inputs[0].t_s.size, 1)
    decisions = []
    for now in inputs:
        decision, state = policy.decide(state, now, rng)
        decisions.append(decision)
    return decisions


def arrays(value: Any) -> list[np.ndarray[Any, Any]]:
    """Copies of all arrays in a state."""
    if isinstance(value, np.ndarray):
        return [value.copy()]
    return [getattr(value, field.name).copy() for field in fields(value)]


def same(one: Decisions, other: Decisions, rows: slice) -> bool:
    """Whether decisions of some vehicles are those of all, to the bit."""
    return all(
        np.array_equal(getattr(one, f.name)[rows], getattr(other, f.name), equal_nan=f.name == "power_dbm")
        for f in fields(one)
    )


def test_decisions_are_complete(policy: AbstractTransmitPolicy[Any]) -> None:
    inputs = traffic()
    sent = np.zeros(VEHICLES)
    for now, decision in zip(inputs, run(policy, inputs, np.random.default_rng(0)), strict=True):
        assert now.until_s is not None
        for field in fields(decision):
            assert getattr(decision, field.name).shape == (VEHICLES,)
        sends = decision.kind != MessageKind.NOTHING
        sent += sends
        assert set(decision.kind.tolist()) <= set(MessageKind)
        assert (np.isinf(decision.send_s) == ~sends).all()
        assert (decision.send_s[sends] >= now.t_s[sends]).all()
        assert (decision.send_s[sends] < now.until_s[sends]).all()
        assert not decision.believed[~sends].any()
        assert np.isnan(decision.power_dbm[~sends]).all()
    assert (sent > 0).all()


def test_every_vehicle_sends_within_a_second_of_its_start(policy: AbstractTransmitPolicy[Any]) -> None:
    early = run(policy, traffic()[:20], np.random.default_rng(0))
    assert np.any([decision.kind > 0 for decision in early], axis=0).all()


def test_the_given_state_and_inputs_are_left_alone(policy: AbstractTransmitPolicy[Any]) -> None:
    rng = np.random.default_rng(0)
    state = policy.init(VEHICLES, 1)
    for now in traffic()[:30]:
        before, given_before = arrays(state), [now.t_s.copy(), now.tracking_error_m.copy()]
        _, after = policy.decide(state, now, rng)
        assert all(np.array_equal(a, b) for a, b in zip(before, arrays(state), strict=True))
        assert all(
            np.array_equal(a, b) for a, b in zip(given_before, [now.t_s, now.tracking_error_m], strict=True)
        )
        state = after


def test_a_vehicle_decides_alike_alone_and_in_a_fleet(name: str, policy: AbstractTransmitPolicy[Any]) -> None:
    inputs = traffic()
    numbers = np.random.default_rng(7).random((STEPS, VEHICLES, 3))
    fleet = run(policy, inputs, Dealt(numbers, slice(None)))
    for vehicle in range(VEHICLES):
        row = slice(vehicle, vehicle + 1)
        one = policy
        if isinstance(policy, J2945):
            one = J2945(policy.parameters, phase_ratio=PHASE_RATIO[row])
        alone = run(one, [part(now, row) for now in inputs], Dealt(numbers, row))
        for together, single in zip(fleet, alone, strict=True):
            assert same(together, single, row), name


def test_the_same_seed_gives_the_same_decisions(policy: AbstractTransmitPolicy[Any]) -> None:
    inputs = traffic(3)
    first, second = (run(policy, inputs, np.random.default_rng(5)) for _ in range(2))
    assert all(same(one, other, slice(None)) for one, other in zip(first, second, strict=True))


def test_random_numbers_do_not_depend_on_what_is_decided(policy: AbstractTransmitPolicy[Any]) -> None:
    """So that policies compared under one seed meet the same chance."""
    ends = []
    for seed in (1, 2):
        rng = np.random.default_rng(9)
        run(policy, traffic(seed), rng)
        ends.append(rng.random())
    assert ends[0] == ends[1]


@pytest.mark.parametrize("missing", ["motion", "air"])
def test_a_missing_part_of_the_inputs_is_refused_by_name(missing: str) -> None:
    values = {f.name: getattr(traffic()[0], f.name) for f in fields(TransmitInputs)}
    inputs = TransmitInputs(**{**values, missing: None})
    for policy in (J2945(), CooperativeAwareness()):
        with pytest.raises(ValueError, match=missing):
            policy.decide(policy.init(VEHICLES, 1), inputs, np.random.default_rng(0))


@pytest.fixture(name="name")
def _name(request: pytest.FixtureRequest) -> str:
    """Name of the test's policy, for messages."""
    return request.node.name


def test_every_policy_is_held_to_the_contract(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    assert concrete_classes(AbstractTransmitPolicy) == {type(policy) for policy in POLICIES.values()}

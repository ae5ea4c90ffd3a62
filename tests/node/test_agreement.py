"""Claim: a node on the virtual transport says and believes what the evaluation says, byte for byte.

It holds where an evaluation takes speed, heading, acceleration and yaw rate as they are recorded. Where one
is missing, a node makes it from earlier fixes, and an evaluation by its own estimator (docs/recording.md).
"""

from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from modelcast.io.trips import read_trips
from modelcast.node.agreement import node_agreement, states_its_motion
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

RULES = [
    ("default", "guarded/never"),
    ("paper", "guarded/never"),
    ("ctra", "survivor/on-failure"),
    ("gp-intercept+cv", "keep/on-failure"),
    ("learned+imm+cv", "order/on-failure"),
]


def agrees(trip: Trajectory, bank: str, rules: str, *, most: float, seed: int = 0) -> int:
    """Messages that were compared."""
    start, identify = rules.split("/")
    policy = ErrorDriven(most, start, identify)  # type: ignore[arg-type]
    found = node_agreement(make_case(trip, EvaluationSettings()), named_bank(bank).bank, policy, seed=seed)
    assert found.agrees, (trip.trip_id, bank, rules, found)
    assert found.judged > 0.5 * len(trip)
    return found.messages


@pytest.mark.parametrize(
    ("bank", "rules"), [RULES[0], *(pytest.param(*rest, marks=pytest.mark.slow) for rest in RULES[1:])]
)
def test_a_made_trip_is_the_same(bank: str, rules: str) -> None:
    assert agrees(generate_drive(4, 90.0).truth, bank, rules, most=0.2, seed=3) > 10


@pytest.mark.slow
@pytest.mark.parametrize("source", ["spmd/bsm_p1_dev.csv", "nyc_cvpd"])
def test_real_trips_are_the_same(data_folder: Path, source: str) -> None:
    trips = [
        trip
        for trip in islice(read_trips(data_folder / source), 20)
        if states_its_motion(make_case(trip, EvaluationSettings()))
    ]
    assert trips
    for trip in trips[:2]:
        for bank, rules in RULES[:2]:
            agrees(trip, bank, rules, most=0.3)


def test_a_bit_of_the_motion_is_found() -> None:
    """The comparison is not of nothing: where the recording moves, so does what is expected."""
    trip = generate_drive(4, 90.0).truth
    bent = replace(trip, acceleration_mps2=None)
    policy, named = ErrorDriven(0.2, "guarded", "never"), named_bank("default")
    case = make_case(bent, EvaluationSettings())
    assert not states_its_motion(case)
    found = node_agreement(case, named.bank, policy)
    assert "byte" in found.sent
    assert found.host
    assert not found.agrees

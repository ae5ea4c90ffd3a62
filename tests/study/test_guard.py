"""Claims about the guard: what a bank may cost a trip, and that it acts only where it is needed."""

from itertools import product

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import derivative_process, vehicle_process
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory

CTRA = ConstantTurnRateAcceleration()
BANK = Bank((ConstantAcceleration(), CTRA, ConstantVelocity()))
ONE_GUARD = Bank((ConstantAcceleration(), ConstantTurnRateVelocity(), ConstantVelocity()))


def walked(trip: Trajectory, bank: Bank, start: str, threshold_m: float = 0.3) -> TripMessages:
    ready = TripRuntime(trip, bank, velocity_estimator_for(trip))
    return ready.run(ErrorDriven(threshold_m, start, "never", 2.0))  # pyright: ignore[reportArgumentType]


def jerking(seed: int, hold: int) -> Trajectory:
    """A car whose acceleration turns round every so many samples: what it did last it does not do next."""
    rng = np.random.default_rng(seed)
    signs = np.repeat((-1.0) ** np.arange(600 // hold + 1), hold)[:600]
    acceleration_mps2 = 3.0 * signs * rng.uniform(0.6, 1.4, 600)
    speed_mps = 15.0 + np.cumsum(acceleration_mps2) * 0.1
    along_m = np.cumsum(speed_mps) * 0.1
    return build_trajectory(
        "made/1", 0.1 * np.arange(600), np.column_stack([along_m, np.zeros(600)]), speed_mps=speed_mps
    )


@pytest.mark.parametrize(
    ("seed", "hold", "threshold_m"), [*product(range(6), (3, 4, 7, 12), (0.2, 0.3, 0.5))]
)
def test_a_bank_that_always_comes_too_late_costs_a_few_messages_at_most(
    seed: int, hold: int, threshold_m: float
) -> None:
    """Six by one guard; by two, which may take turns in being the better one, ten of the better."""
    trip = jerking(seed, hold)
    alone = [walked(trip, bank, "order", threshold_m).updates for bank in (BASELINE_BANK, Bank((CTRA,)))]
    assert walked(trip, ONE_GUARD, "guarded", threshold_m).updates <= alone[0] + 6
    assert walked(trip, BANK, "guarded", threshold_m).updates <= min(alone) + 10


def test_unguarded_it_costs_many_times_as_much() -> None:
    trip = jerking(3, 4)
    baseline = walked(trip, BASELINE_BANK, "order").updates
    for bank, most in ((BANK, 10), (ONE_GUARD, 5)):
        assert walked(trip, bank, "hindsight").updates >= baseline + 40
        assert walked(trip, bank, "guarded").updates <= baseline + most


def test_once_in_step_the_sender_sends_with_constant_velocity() -> None:
    trip = jerking(1, 4)
    alone, guarded = walked(trip, BASELINE_BANK, "order"), walked(trip, ONE_GUARD, "guarded")
    behind = np.cumsum(guarded.transmits) - np.cumsum(alone.transmits)
    last = int(np.flatnonzero(np.diff(behind))[-1])  # from then on nothing is lost or gained
    assert last < len(trip) // 2
    assert guarded.kind[last + 2 :].tolist() == alone.kind[last + 2 :].tolist()
    assert set(guarded.in_use[last + 2 :]) == {2}
    both = last + 1 + int(np.argmax(alone.transmits[last + 1 :]))
    assert guarded.update_index[both:].tolist() == alone.update_index[both:].tolist()


def test_once_in_step_with_a_plain_sub_model_the_sender_sends_as_that_does_alone() -> None:
    trip = jerking(0, 6)
    alone, guarded = walked(trip, Bank((CTRA,)), "order"), walked(trip, BANK, "guarded")
    behind = np.cumsum(guarded.transmits) - np.cumsum(alone.transmits)
    last = int(np.flatnonzero(np.diff(behind))[-1])
    assert last < len(trip) // 2
    assert guarded.kind[last + 2 :].tolist() == alone.kind[last + 2 :].tolist()
    assert set(guarded.in_use[last + 2 :]) == {1}


def test_a_bank_that_never_falls_behind_is_not_guarded(drive: Trajectory) -> None:
    free, guarded = walked(drive, BANK, "hindsight"), walked(drive, BANK, "guarded")
    alone = walked(drive, BASELINE_BANK, "order")
    assert (np.cumsum(free.transmits) - np.cumsum(alone.transmits)).max() < 2
    assert guarded.kind.tolist() == free.kind.tolist()
    assert guarded.in_use.tolist() == free.in_use.tolist()
    assert MessageKind.IDENTIFICATION not in guarded.kind


def test_one_sub_model_and_what_stands_in_for_it_have_nothing_to_guard(drive: Trajectory) -> None:
    lone = Bank((vehicle_process(),))
    assert walked(drive, lone, "guarded").kind.tolist() == walked(drive, lone, "order").kind.tolist()
    two = Bank((vehicle_process(), derivative_process()))
    with pytest.raises(ValueError, match="needs cv as a member of its own"):
        walked(drive, two, "guarded")
    with pytest.raises(ValueError, match="needs cv in the bank, got gp-vehicle, gp-derivative"):
        EvaluationSettings(bank=two, start="guarded", identify="never")


def test_a_guarded_bank_needs_constant_velocity() -> None:
    bank = Bank((ConstantAcceleration(), ConstantTurnRateAcceleration()))
    with pytest.raises(ValueError, match="start 'guarded' needs cv in the bank, got ca, ctra: add it"):
        EvaluationSettings(bank=bank, start="guarded", identify="never")
    with pytest.raises(ValueError, match="the bank has no cv, only ca, ctra"):
        walked(jerking(0, 5), bank, "guarded")

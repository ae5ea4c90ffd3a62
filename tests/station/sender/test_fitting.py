"""Claims about fits: parameters as receivers hold them, once a sample, where there is a window to fit."""

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration
from modelcast.models.point_kernels import (
    ACCELERATION,
    EAST,
    NORTH,
    SAMPLE_COLUMNS,
    VELOCITY_EAST,
    VELOCITY_NORTH,
)
from modelcast.station.arrays import Fits, Sensed, fits, sensed
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sender.fitting_kernels import distance_to, fit, fit_each

DT_S, RING = 0.1, 4
CA, CV, GP = ConstantAcceleration(), ConstantVelocity(), GaussianProcess(3, "intercept")
BANK = Bank((CV, CA, GP))
SPEED_STEP_MPS = 0.02
"""Of a code of speed."""


def measured(taken: int, vehicles: int = 2) -> Sensed:
    """So many samples of cars that speed up, each at speeds of its own."""
    s = sensed(vehicles, RING)
    for v in range(vehicles):
        for number in range(taken):
            speed = 10.003 + 7.0 * v + 0.2 * number
            sample = np.zeros(SAMPLE_COLUMNS)
            sample[EAST], sample[NORTH] = 1.0 * number, 0.5 * number
            sample[VELOCITY_EAST], sample[VELOCITY_NORTH] = speed, 0.0
            sample[ACCELERATION] = 2.003
            at = number % RING
            for place in (at, at + RING):
                s.samples[v, place], s.t_s[v, place] = sample, DT_S * number
            s.stated_s[v, at], s.stated_m[v, at] = DT_S * number, sample[:2]
            s.history[v, at] = number + 1
        s.taken[v] = taken
    return s


def empty(bank: SenderBank, ring: int = 3, vehicles: int = 2) -> Fits:
    return fits(vehicles, ring, members=len(bank.bank.members), parameters=int(bank.bank.offsets[-1]))


def test_a_fit_goes_through_the_codes_of_its_message() -> None:
    """A speed of 17.203 m/s is code 860 of 2 cm/s: 17.2 m/s; an acceleration of 2.003 m/s² is 2."""
    bank, s = SenderBank.of(BANK, DT_S), measured(2)
    held, offsets = empty(bank), bank.bank.offsets
    assert fit(bank.models(), s, held, 1, 1, 1)
    first, last = offsets[1], offsets[2]
    np.testing.assert_allclose(held.parameters[1, 1, first:last], [17.2, 0.0, 2.0], atol=1e-9)
    assert held.codes[1, 1, first:last].tolist() == [860, 7200, 200]
    assert held.number[1].tolist() == [[-1, -1, -1], [-1, 1, -1], [-1, -1, -1]]
    assert not held.parameters[0].any()
    assert not held.parameters[1, [0, 2]].any()
    assert not held.parameters[1, 1, :first].any()


def test_without_codes_a_fit_stays_as_it_is() -> None:
    bank, s = SenderBank.of(BANK, DT_S, quantised=False), measured(2)
    held = empty(bank)
    assert fit(bank.models(), s, held, 1, 1, 1)
    first, last = bank.bank.offsets[1:3]
    assert held.parameters[1, 1, first:last].tolist() == pytest.approx([17.203, 0.0, 2.003], abs=1e-12)
    assert not held.codes.any()
    assert held.number[1, 1, 1] == 1


@pytest.mark.parametrize("quantised", [False, True])
@pytest.mark.parametrize("column", [VELOCITY_EAST, VELOCITY_NORTH, ACCELERATION])
def test_a_fit_with_a_parameter_that_is_no_number_failed(quantised: bool, column: int) -> None:
    """Whichever it is, the first as well as the last; and it is tried again."""
    bank, s = SenderBank.of(BANK, DT_S, quantised=quantised), measured(2)
    held = empty(bank)
    good = s.samples.copy()
    s.samples[1, :, column] = np.nan
    assert not fit(bank.models(), s, held, 1, 1, 1)
    assert (held.number == -1).all()
    s.samples[:] = good
    assert fit(bank.models(), s, held, 1, 1, 1)


def test_a_fit_is_made_once_a_sample_and_its_place_is_that_of_a_ring() -> None:
    bank, s = SenderBank.of(BANK, DT_S), measured(6)
    held = empty(bank)
    assert fit(bank.models(), s, held, 0, 4, 0)
    assert held.number[0, :, 0].tolist() == [-1, 4, -1]
    held.parameters[0, 1, :2] = 99.0
    assert fit(bank.models(), s, held, 0, 4, 0)
    assert held.parameters[0, 1, :2].tolist() == [99.0, 99.0]
    assert fit(bank.models(), s, held, 0, 5, 0)
    np.testing.assert_allclose(held.parameters[0, 2, :2], [11.0, 0.0], atol=SPEED_STEP_MPS)


def test_all_that_have_a_full_window_are_fitted_at_each_sample_asked_for() -> None:
    """A window of three samples is full at the third; before, nothing of its place is touched."""
    bank, s = SenderBank.of(BANK, DT_S, quantised=False), measured(4)
    held, offsets = empty(bank, ring=5), bank.bank.offsets
    held.parameters[:] = 55.0
    fit_each(bank.models(), s, held, np.array([1, 2, 3]))
    assert held.number[0].tolist() == [[-1] * 3, [1, 1, -1], [2, 2, 2], [3, 3, 3], [-1] * 3]
    assert (held.parameters[0, 1, offsets[2] :] == 55.0).all()
    assert (held.parameters[0, 0] == 55.0).all()
    assert (held.parameters[1] == 55.0).all()
    for number in (1, 2, 3):
        speed = 10.003 + 0.2 * number
        assert held.parameters[0, number, :5].tolist() == pytest.approx(
            [speed, 0.0, speed, 0.0, 2.003], abs=1e-12
        )


def test_what_could_not_be_fitted_is_no_number_at_the_place_of_its_sample_in_the_ring() -> None:
    """Sample 5 has the third of three places."""
    bank, s = SenderBank.of(BANK, DT_S, quantised=False), measured(6)
    held, offsets = empty(bank), bank.bank.offsets
    s.samples[0, :, VELOCITY_NORTH] = np.nan
    fit_each(bank.models(), s, held, np.array([5]))
    assert np.isnan(held.parameters[0, 2, offsets[:2]]).all()
    assert not held.parameters[0, :2].any()
    assert held.number[0, :, :2].tolist() == [[-1, -1]] * 3


def test_the_past_of_another_vehicle_makes_no_window_full() -> None:
    bank, s = SenderBank.of(BANK, DT_S), measured(3)
    for others in (1, 3):
        s.history[0, 2], s.history[1, 2] = 4 - others, others
        held = empty(bank)
        fit_each(bank.models(), s, held, np.array([2]))
        assert held.number[0, 2].tolist() == [2, 2, 2 if others == 1 else -1]


def test_distances_are_those_between_a_prediction_from_its_origin_and_the_sample() -> None:
    """From (100, 200) at 4 s, 3 m/s east and 4 m/s north: two seconds later (106, 208)."""
    models, scratch = SenderBank.of(Bank((CA, CV)), DT_S).models(), np.empty(2)
    sample = np.zeros(SAMPLE_COLUMNS)
    for east, north, expected in ((106.0, 208.0, 0.0), (103.0, 204.0, 5.0), (106.0, 196.0, 12.0)):
        sample[EAST], sample[NORTH] = east, north
        origin = np.array([4.0, 100.0, 200.0])
        found = distance_to(models, 1, np.array([3.0, 4.0]), origin, 6.0, sample, scratch)
        assert found == pytest.approx(expected, abs=1e-9)

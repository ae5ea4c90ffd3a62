"""Claims about the tracking error against what remotes are believed to hold."""

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateVelocity
from modelcast.models.members import ReadyBank
from modelcast.station.policy import tracking_error_kernels as kernels
from modelcast.station.policy.j2945_parameters import J2945Parameters, j2945_relaxed_parameters

CV = ConstantVelocity()
STANDARD = J2945Parameters()


def tracking_error_m(
    now_s: float,
    local: list[float],
    fit_s: float,
    parameters: list[float],
    *,
    place_m: tuple[float, float] = (0.0, 0.0),
    model: AbstractSubModel = CV,
    standard: J2945Parameters = STANDARD,
) -> float:
    """Error of a vehicle whose remotes are believed to hold a model fitted at a place."""
    members = ReadyBank.of(Bank((model,)), 0.1).members
    given = np.array(parameters), now_s, np.array(local), fit_s, *place_m
    return kernels.tracking_error_of_model(members, 0, *given, standard.constants(), np.empty(2))


@pytest.mark.parametrize(
    ("local_age_s", "sent_age_s", "error_m"),
    # Sent: at 0 m with 10 m/s east. Own estimate: at 6 m north with 20 m/s north.
    # Own as is below 50 ms, extrapolated up to 150 ms, then no error; theirs 50 ms and 3 s.
    [
        (0.00, 0.00, 6.0),
        (0.04, 0.04, 6.0),
        (0.10, 0.04, 8.0),  # 6 + 2
        (0.15, 0.00, 9.0),  # 6 + 3
        (0.16, 0.00, 0.0),
        (0.00, 0.80, 10.0),  # 8 east, 6 north
        (0.10, 0.60, 10.0),  # 6 east, 6 + 2 north
        (0.00, 3.00, float(np.hypot(30.0, 6.0))),
        (0.00, 3.01, 0.0),
    ],
)
def test_each_estimate_counts_by_its_age(local_age_s: float, sent_age_s: float, error_m: float) -> None:
    now_s = 10.0
    local = [now_s - local_age_s, 0.0, 6.0, 0.0, 20.0]
    assert tracking_error_m(now_s, local, now_s - sent_age_s, [10.0, 0.0]) == pytest.approx(error_m, abs=1e-9)


def test_ages_are_selectable() -> None:
    """Theirs 4 s old: 4 m east; own 1 m east when extrapolated, 0 m as is."""
    local = [9.9, 0.0, 0.0, 10.0, 0.0]
    for standard, error_m in (
        (j2945_relaxed_parameters(5.0), 3.0),
        (J2945Parameters(local_as_is_age_s=0.15, remote_max_age_s=9.0), 4.0),
    ):
        found_m = tracking_error_m(10.0, local, 6.0, [1.0, 0.0], standard=standard)
        assert found_m == pytest.approx(error_m)


def test_who_holds_nothing_is_infinitely_far_off() -> None:
    local = [1.0, 3.0, 4.0, 0.0, 0.0]
    assert tracking_error_m(1.0, local, -np.inf, [0.0, 0.0]) == np.inf
    assert tracking_error_m(1.0, local, 1.0, [0.0, 0.0]) == 5.0


def test_any_model_is_an_estimator() -> None:
    """Remotes are where their model, in batch, puts the vehicle; the own place is coasted to now."""
    rng = np.random.default_rng(0)
    for model in (CV, ConstantTurnRateVelocity()):
        for _ in range(5):
            fit_s, place_m = rng.uniform(0.0, 1.4), rng.normal(size=2)
            parameters = rng.normal(size=len(model.parameter_names))
            local = [rng.uniform(1.36, 1.44), *rng.normal(size=4)]
            theirs_m = place_m + model.predict_at(parameters[None], np.array([1.5 - fit_s]), dt_s=0.1)[0]
            own_m = np.array(local[1:3]) + (1.5 - local[0]) * np.array(local[3:])
            found_m = tracking_error_m(
                1.5, local, fit_s, parameters.tolist(), place_m=tuple(place_m), model=model
            )
            assert found_m == pytest.approx(np.hypot(*(theirs_m - own_m)), abs=1e-12)


def test_coasting_is_constant_velocity() -> None:
    state = np.array([2.0, 1.0, -1.0, 10.0, 5.0])
    assert kernels.coast(2.5, state) == pytest.approx((6.0, 1.5))

"""Claims about the tracking error against what remotes are believed to hold."""

import numpy as np
import pytest

from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateVelocity
from modelcast.models.members import ReadyBank
from modelcast.station.policy import belief_kernels
from modelcast.station.policy.belief import Belief
from modelcast.station.policy.j2945_parameters import J2945Parameters, j2945_relaxed_parameters

CV = ConstantVelocity()
ALL = np.array([True])


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
    now = 10.0
    belief = Belief.nothing(1, CV).renewed(
        ALL,
        fit_s=np.array([now - sent_age_s]),
        position_m=np.zeros((1, 2)),
        parameters=np.array([[10.0, 0.0]]),
    )
    local = np.array([[now - local_age_s, 0.0, 6.0, 0.0, 20.0]])
    error = belief.tracking_error_m(CV, np.array([now]), local, dt_s=0.1)
    assert error[0] == pytest.approx(error_m, abs=1e-9)


def test_ages_are_selectable() -> None:
    belief = Belief.nothing(1, CV).renewed(
        ALL, fit_s=np.array([6.0]), position_m=np.zeros((1, 2)), parameters=np.array([[1.0, 0.0]])
    )
    local = np.array([[9.9, 0.0, 0.0, 10.0, 0.0]])
    now = np.array([10.0])
    # Theirs 4 s old: 4 m east; own 1 m east when extrapolated, 0 m as is.
    relaxed = j2945_relaxed_parameters(5.0)
    assert belief.tracking_error_m(CV, now, local, dt_s=0.1, standard=relaxed)[0] == pytest.approx(3.0)
    held = J2945Parameters(local_as_is_age_s=0.15, remote_max_age_s=9.0)
    assert belief.tracking_error_m(CV, now, local, dt_s=0.1, standard=held)[0] == pytest.approx(4.0)


def test_who_holds_nothing_is_infinitely_far_off_and_only_the_believed_is_renewed() -> None:
    local = np.array([[1.0, 3.0, 4.0, 0.0, 0.0]] * 2)
    now = np.ones(2)
    before = Belief.nothing(2, CV)
    after = before.renewed(
        np.array([True, False]), fit_s=now, position_m=np.zeros((2, 2)), parameters=np.zeros((2, 2))
    )
    assert np.isinf(before.tracking_error_m(CV, now, local, dt_s=0.1)).all()
    assert after.tracking_error_m(CV, now, local, dt_s=0.1).tolist() == [5.0, np.inf]


def test_any_model_is_an_estimator_and_the_compiled_form_agrees() -> None:
    """A vehicle on a circle: turning remotes are right where coasting ones are off."""
    rng = np.random.default_rng(0)
    now, standard = np.full(5, 1.5), J2945Parameters()
    for model in (CV, ConstantTurnRateVelocity()):
        members = ReadyBank.of(Bank((model,)), 0.1).members
        belief = Belief(
            rng.uniform(0.0, 1.45, 5),
            rng.normal(size=(5, 2)),
            rng.normal(size=(5, len(model.parameter_names))),
        )
        local = np.column_stack([rng.uniform(1.3, 1.5, 5), rng.normal(size=(5, 4))])
        errors = belief.tracking_error_m(model, now, local, dt_s=0.1)
        for i in range(5):
            compiled = belief_kernels.tracking_error_of_model(
                members,
                0,
                belief.parameters[i],
                now[i],
                local[i],
                belief.fit_s[i],
                belief.position_m[i, 0],
                belief.position_m[i, 1],
                standard.constants(),
                np.empty(2),
            )
            assert compiled == pytest.approx(errors[i], abs=1e-12)


def test_coasting_is_constant_velocity() -> None:
    state = np.array([2.0, 1.0, -1.0, 10.0, 5.0])
    assert belief_kernels.coast(2.5, state) == pytest.approx((6.0, 1.5))

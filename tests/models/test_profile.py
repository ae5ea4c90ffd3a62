"""Claims about profiles: their text, their identity, and what is refused."""

import hashlib
import importlib.resources
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.models.bank import Bank
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import (
    GaussianProcess,
    Hyperparameters,
    VehicleProcess,
    derivative_process,
    vehicle_process,
)
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import LearnedTrajectory
from modelcast.models.plain import PLAIN_CLASSES, from_plain, to_plain
from modelcast.models.profile import (
    Profile,
    default_profile,
    people_profile,
    profile_from_text,
    shipped_profile,
)
from modelcast.models.regimes import Regimes
from modelcast.models.reserved import UNTRAINED
from modelcast.models.shipped import profile_path
from modelcast.models.stop_and_go import StopAndGo
from modelcast.models.trusted import Trusted
from modelcast.station.banks import bank_from_text

REGIMES = Regimes(
    (VehicleProcess("gp-regime-1"), VehicleProcess("gp-regime-2", velocities=True)),
    ((15.0, 0.2, 0.5), (3.0, 1.2, 0.1)),
    scales=(6.0, 0.5, 1.0),
    shares=(0.75, 0.25),
)


def example() -> Profile:
    table = Calibration(
        "ctra",
        np.array([1.0, 2.0]),
        unmodelled=0.1,
        factors=np.ones((2, 2)),
        radii=np.array([[1.0, 2.0, 2.5]] * 2),
        instants=9,
    )
    fixed = GaussianProcess(
        form="intercept", hyperparameters=Hyperparameters(2.0, 1e-4, linear_ratio_per_s2=1.0)
    )
    return Profile(
        Bank((Trusted(ConstantTurnRateAcceleration(), 1.5), ConstantVelocity()), "mine"),
        shelf=(vehicle_process(), derivative_process(), fixed),
        regimes=REGIMES,
        calibrations={"ctra": table},
        record={"trips": ["a"], "seed": 3},
    )


def test_a_profile_survives_its_text() -> None:
    profile = example()
    again = profile_from_text(profile.text)
    assert again == profile
    assert again.bank == profile.bank
    assert again.shelf == profile.shelf
    assert again.regimes == profile.regimes
    assert again.sub_model("gp-regime-2") == REGIMES.members[1]
    assert again.text == profile.text


def test_a_regimes_sub_model_may_stand_in_the_bank_too() -> None:
    profile = Profile(Bank((*REGIMES.members, ConstantVelocity())), regimes=REGIMES)
    assert profile_from_text(profile.text) == profile
    assert [member.name for member in profile.sub_models] == ["gp-regime-1", "gp-regime-2", "cv"]


@pytest.mark.parametrize(
    "name",
    [
        "cv",
        "gp-linear",
        "gp-anchored",
        "gp(rbf)",
        "gp(linear+rbf)",
        "gp(",
        "gp(x)",
        "paper",
        "regimes",
        "default",
        "trained",
        "a+b",
        "a(",
        "a)",
    ],
)
def test_no_sub_model_takes_a_name_that_means_another_on_the_command_line(name: str) -> None:
    member = VehicleProcess(name)
    fixed = GaussianProcess(hyperparameters=Hyperparameters(2.0, 1e-4, linear_ratio_per_s2=1.0), label=name)
    for one in (member, fixed, Trusted(member, 1.5)):
        with pytest.raises(ValueError, match="may be named"):
            Profile(Bank((ConstantTurnRateAcceleration(),)), added=(one,))
        with pytest.raises(ValueError, match="may be named"):
            Profile(Bank((ConstantTurnRateAcceleration(),)), shelf=(one,))
    plain = json.loads(Profile(Bank((ConstantTurnRateAcceleration(),))).text)
    plain["added"] = {"members": to_plain((member,)), "record": {}}
    with pytest.raises(ValueError, match="may be named"):
        profile_from_text(json.dumps(plain))


@pytest.mark.parametrize("name", [*UNTRAINED, "gp(linear+rbf)", "gp(rbf+linear)", "gp(matern32*linear)"])
def test_what_a_name_means_without_a_profile_may_stand_in_one(name: str) -> None:
    bank = bank_from_text(name, window=12)
    assert profile_from_text(Profile(bank).text).bank == bank


def test_a_closed_form_has_only_its_own_expressions_name() -> None:
    """The intercept form is another process, whatever its label says."""
    other = GaussianProcess(form="intercept", label="gp(linear+rbf)")
    with pytest.raises(ValueError, match="another sub-model"):
        Profile(Bank((other,)))


def test_a_profile_without_regimes_keeps_the_bytes_it_had_before_there_were_any() -> None:
    plain = json.loads(Profile(example().bank).text)
    assert "regimes" not in plain
    assert profile_from_text(json.dumps(plain)).regimes is None


def test_what_a_plain_message_means_is_part_of_the_identity_and_must_be_free() -> None:
    """Without the key a profile keeps its bytes; a process says more than Part I does."""
    members = (ConstantTurnRateAcceleration(), ConstantVelocity(), GaussianProcess())
    silent, named = Profile(Bank(members)), Profile(Bank(members, plain="cv"))
    assert "plain" not in json.loads(silent.text)
    assert json.loads(named.text)["plain"] == "cv"
    assert named.identity != silent.identity
    assert profile_from_text(named.text).bank.plain_place == 1
    for name in (members[2].name, "ctrv", ""):
        text = json.dumps({**json.loads(silent.text), "plain": name})
        with pytest.raises(ValueError, match=r"^\$\.plain"):
            profile_from_text(text)


def test_its_identity_is_the_hash_of_its_bytes_and_changes_with_any_of_them() -> None:
    profile = example()
    assert profile.identity == hashlib.sha256(profile.text.encode()).hexdigest()
    other = Profile(profile.bank, shelf=profile.shelf, calibrations=profile.calibrations, record={"seed": 4})
    assert other.identity != profile.identity


def test_the_shipped_profile_is_canonical_and_all_but_its_guard_are_plain_messages() -> None:
    path = importlib.resources.files("modelcast") / "profiles" / "default.json"
    profile = default_profile()
    assert path.read_text(encoding="utf-8") == profile.text
    assert [member.name for member in profile.bank.members] == ["free-predictive", "free", "ctra", "cv"]
    assert profile.bank.sent_plain == (True, True, True, False)
    assert profile.bank.window == 1
    assert set(profile.calibrations) == {member.name for member in profile.bank.members}
    assert isinstance(profile.sub_model("learned"), LearnedTrajectory)
    assert profile.sub_model("none") is None
    assert profile.selector is not None
    assert profile.selector.members == tuple(member.name for member in profile.bank.members)


def test_the_shipped_profile_of_people_is_canonical_and_holds_no_trained_weights() -> None:
    profile = people_profile()
    assert profile_path("people").read_text(encoding="utf-8") == profile.text
    assert [type(member) for member in profile.sub_models] == [StopAndGo]
    assert profile.bank.sent_plain == (True,)
    assert "float32" not in profile.text
    assert profile.training_trips == ()
    with pytest.raises(ValueError, match="default, people"):
        shipped_profile("horses")


def test_the_shipped_profile_says_what_it_was_trained_on() -> None:
    """Data whose licence lets a profile that was trained on it be passed on, and no other."""
    record = default_profile().record
    others = [trip["trip"] for trip in record["trips"] if trip["format"] == "parquet"]
    assert [trip.partition("/")[0] for trip in others] == ["boreas_2021-08-05"]
    known = {"openacc", "spmd-bsm", "comma2k19", "nyc-cvpd", "parquet"}
    assert {trip["format"] for trip in record["trips"]} <= known
    assert record["figures"]["counted_on"] == "training trips"
    regimes = default_profile().regimes
    assert regimes is not None
    trained = {"gp-vehicle", "gp-derivative", "gp-trained", *(one.name for one in regimes.members)}
    assert set(record["processes"]) == trained


def changed(**keys: Any) -> str:
    return json.dumps({**json.loads(example().text), **keys})


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "no JSON"),
        ("[]", "a mapping with 'schema'"),
        (changed(schema=99), "schema 99"),
        (changed(members=[]), r"\$\.members must be a list of 1 to 8"),
        (changed(members=[{"is": "Path"}]), "'Path'"),
        (changed(members=[{"is": "Trusted"}]), "Trusted"),
        (changed(members=[{"is": "ConstantVelocity", "mass": 1}]), "mass"),
        (changed(members=["cv"]), r"\$\.members\[0\] must be a mapping"),
        (changed(members=[{"is": "AxisKernel"}]), r"\$\.members\[0\] must be a sub-model"),
        (changed(calibrations={"ctra": {}}), "sub_model, .* missing"),
        (changed(calibrations={"other": example().calibrations["ctra"].as_plain()}), "other"),
        (changed(record=3), r"\$\.record must be a mapping"),
        (changed(costs=[]), r"\$\.costs must be a mapping"),
        (changed(selector={"is": "ConstantVelocity"}), "selector"),
        (changed(regimes={"is": "ConstantVelocity"}), "regimes"),
        (changed(regimes={**to_plain(REGIMES), "shares": [1.0]}), r"\$\.regimes\.shares must be a list of 2"),
        (changed(shelf=[{"is": "VehicleProcess", "label": "gp-regime-1"}]), "twice: gp-regime-1"),
        ('{"schema":1}', "missing"),
    ],
)
def test_a_text_that_is_no_profile_is_refused_by_what_is_wrong(text: str, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        profile_from_text(text)


@pytest.mark.parametrize(
    "array",
    [
        {"float32": "####", "shape": [1]},
        {"float32": "AAAAAA==", "shape": [2]},
        {"float32": 3, "shape": [1]},
        {"float32": "AAAAAA==", "shape": [1], "more": 1},
    ],
)
def test_a_damaged_array_is_refused(array: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"^\$"):
        from_plain(array)


@given(
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers(-1000, 1000)
        | st.floats(allow_nan=False)
        | st.sampled_from(["a", "cv"]),
        lambda inner: (
            st.lists(inner, max_size=3).map(tuple)
            | st.dictionaries(st.sampled_from(["x", "y"]), inner, max_size=2)
        ),
        max_leaves=6,
    )
)
def test_plain_values_come_back_as_they_were(value: Any) -> None:
    assert from_plain(json.loads(json.dumps(to_plain(value), allow_nan=False))) == value


def test_only_listed_classes_and_numbers_are_written() -> None:
    with pytest.raises(TypeError, match="object"):
        to_plain(object())
    with pytest.raises(ValueError, match="NaN"):
        to_plain(float("nan"))
    assert "Bank" not in PLAIN_CLASSES

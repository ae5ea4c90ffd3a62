"""Claims about banks by name."""

from dataclasses import replace
from pathlib import Path

import pytest

from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.core.exceptions import ConfigError
from modelcast.io.profile import write_profile
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import AxisKernel, VehicleProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.profile import Profile, default_profile, people_profile
from modelcast.models.trusted import Trusted
from modelcast.station.banks import bank_from_text, free_bank, named_bank

NAMES = [
    "cv",
    "ca",
    "ctrv",
    "ctra",
    "gp-anchored",
    "gp-intercept",
    "gp-adaptive",
    "gp-linear",
    "gp-trained",
    "gp-vehicle",
    "gp-derivative",
    "learned",
    "free",
    "free-predictive",
    "free-context",
    "shs",
    "hdp-hmm",
    "gp-regime-1",
    "gp-regime-2",
    "gp-regime-3",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_gives_the_sub_model_of_that_name_and_window(name: str) -> None:
    (member,) = bank_from_text(name, window=15).members
    assert member.name == name
    own = {"learned": 21, "free": 13, "free-predictive": 21, "free-context": 21}
    assert member.window == (15 if name.startswith("gp") else own.get(name, 1))


def test_the_context_comes_before_the_members_of_the_profiles_bank() -> None:
    profile = default_profile()
    named = named_bank("default+context")
    expected = ["free-context", *(member.name for member in profile.bank.members)]
    assert [member.name for member in named.bank.members] == expected
    assert (named.start, named.identify) == (profile.start, profile.identify)
    assert all(named.bank.sent_plain[:4])
    without = replace(profile, shelf=())
    with pytest.raises(ConfigError, match="no sub-model free-context; train one"):
        named_bank("default+context", profile=without)


def test_all_of_them_fit_into_one_bank() -> None:
    assert len(bank_from_text("+".join(NAMES)).members) == len(NAMES)


def test_regimes_stands_for_their_members_alone_and_among_others() -> None:
    alone = named_bank("regimes")
    assert alone.bank.name == "regimes"
    assert [member.name for member in alone.bank.members] == NAMES[-3:]
    assert (alone.start, alone.identify) == ("hindsight", "never")
    joined = bank_from_text("ctra+regimes")
    assert [member.name for member in joined.members] == ["ctra", *NAMES[-3:]]


def test_trained_values_come_from_the_profile_in_use() -> None:
    """The shipped one, or the one named; a longer window keeps them."""
    mine = Trusted(ConstantTurnRateAcceleration(), 0.5)
    process = VehicleProcess("gp-vehicle", AxisKernel(7.0, 3.0))
    profile = Profile(Bank((mine,), "mine"), shelf=(process,), start="keep", identify="final")
    assert bank_from_text("gp-vehicle", profile=profile).members == (process,)
    assert bank_from_text("gp-vehicle", profile=profile, window=15).members == (replace(process, samples=15),)
    assert bank_from_text("gp-vehicle").members == (default_profile().sub_model("gp-vehicle"),)
    named = named_bank("default", profile=profile)
    assert (named.bank, named.start, named.identify) == (profile.bank, "keep", "final")
    with pytest.raises(ConfigError, match=r"named 'learned'; there are cv, .* and gp-vehicle"):
        bank_from_text("learned", profile=profile)
    with pytest.raises(ConfigError, match="no regimes"):
        bank_from_text("regimes", profile=profile)


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        ConfigError,
        match=r"no sub-model is named 'gp'; there are cv, .*free-context, .*gp-regime-3, shs and hdp-hmm",
    ):
        bank_from_text("gp")


def test_a_profile_named_beside_a_bank_is_used_and_counts_as_an_input(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    process = VehicleProcess("gp-vehicle", AxisKernel(7.0, 3.0))
    write_profile(Profile(Bank((ConstantTurnRateAcceleration(),)), shelf=(process,)), path)
    options = EvaluateOptions(bank="gp-vehicle", profile=str(path))
    assert options.settings().bank.members == (process,)
    assert options.files == (path,)
    assert EvaluateOptions.from_plain(options.as_plain()) == options
    compared = CompareOptions(("gp-vehicle", "default"), profile=str(path))
    assert [one.name for one in compared.candidates()] == ["gp-vehicle", "default"]
    assert compared.files == (path,)
    with pytest.raises(ConfigError, match=r"missing\.json"):
        EvaluateOptions(profile=str(tmp_path / "missing.json")).settings()


def test_free_is_the_profiles_best_receiver_of_plain_messages_or_ctra() -> None:
    """By itself, and among others."""
    bare, own = Profile(Bank((ConstantVelocity(),))), VehicleProcess("free")
    holding = replace(bare, added=(own,))
    for profile, member in ((bare, ConstantTurnRateAcceleration()), (holding, own)):
        bank = free_bank(profile)
        assert (bank.name, bank.members) == ("free", (member,))
        assert named_bank("free", profile=profile).bank == bank
        assert named_bank("cv+free", profile=profile).bank.members == (ConstantVelocity(), member)


def test_the_profile_of_people_is_named_like_the_default_one() -> None:
    assert profile_in_use("people") is people_profile()
    assert profile_in_use("default") is profile_in_use(None)
    own = bank_in_use("people", profile=profile_in_use(None))
    assert own.bank is people_profile().bank
    assert bank_in_use("default", profile=profile_in_use("people")).bank is own.bank
    assert [path.name for path in EvaluateOptions(bank="people", profile="people").files] == [
        "people.json"
    ] * 2

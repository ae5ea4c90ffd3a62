"""Claims about banks by name."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import modelcast
from modelcast.cli.app import run
from modelcast.cli.banks import bank_in_use, profile_in_use
from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.core.exceptions import ConfigError
from modelcast.io.profile import write_profile
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import AxisKernel, VehicleProcess
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.profile import Profile, default_profile, people_profile, profile_from_text
from modelcast.models.sub_models import SUB_MODELS
from modelcast.models.trusted import Trusted
from modelcast.station.banks import bank_from_text, free_bank, named_bank
from modelcast.study.compare.candidate import FixedCandidate

SCALED = """
from dataclasses import dataclass
from tests.models.numpy_models import Coasting

@dataclass(frozen=True, slots=True)
class Scaled(Coasting):
    gain: float = 1.0
    note: str = ""
    name = "scaled"

    def fit_batch(self, windows):
        return self.gain * windows.velocities_mps[:, -1]
"""

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


@pytest.fixture
def scaled(other_package: Callable[..., Path]) -> None:
    """A package with a sub-model that has settings."""
    other_package("strange", {SUB_MODELS.name: {"scaled": "scaled_model:Scaled"}}, {"scaled_model": SCALED})


def gain_of(bank: Bank) -> float:
    """The setting of the first member."""
    return getattr(bank.members[0], "gain", np.nan)


@pytest.mark.usefixtures("scaled")
def test_a_word_of_a_bank_sets_the_fields_of_another_package_s_sub_model() -> None:
    for text in ("scaled:gain=0.5+cv", "scaled:gain=0.5,note=a.json"):
        bank = EvaluateOptions(bank=text).settings().bank
        assert (gain_of(bank), bank.members[0].name) == (0.5, "scaled")
        assert profile_from_text(Profile(bank).text).bank.members[0] == bank.members[0]
    assert gain_of(bank_from_text("scaled")) == 1.0
    assert isinstance(bank_from_text("scaled:gain=2", trusted_horizon_s=1.0).members[0], Trusted)


@pytest.mark.usefixtures("scaled")
def test_two_settings_are_two_things_to_compare() -> None:
    words = ("scaled:gain=0.5", "scaled:gain=2+cv")
    found = CompareOptions(bank=words).candidates()
    assert [one.name for one in found] == list(words)
    assert [gain_of(one.bank) for one in found if isinstance(one, FixedCandidate)] == [0.5, 2]


@pytest.mark.slow
@pytest.mark.usefixtures("scaled")
def test_a_profile_is_trained_with_it_as_it_is_set(tmp_path: Path) -> None:
    trips, out = [tmp_path / f"{seed}.csv" for seed in range(3)], tmp_path / "mine.json"
    for seed, path in enumerate(trips):
        modelcast.write_csv([modelcast.generate_drive(seed=seed, duration_s=90.0).truth], path)
    words = ["train", *map(str, trips), "--out", str(out), "--bank", "scaled:gain=2+cv", "--quiet"]
    assert run(words) == 0
    assert gain_of(profile_in_use(out).bank) == 2


@pytest.mark.usefixtures("scaled")
@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("scaled:gian=2+cv", "'scaled' of strange refuses its settings: .*gian.* It takes fault, gain, note"),
        ("scaled:gain+cv", "'gain' is not KEY=VALUE"),
        ("scaled:gain=2+scaled:gain=3", "sub-models of a bank must have distinct names, got scaled, scaled"),
        ("cv:gain=2", "'cv:gain=2': settings are for sub-models of other packages, here scaled"),
        ("nobody:gain=2", "'nobody:gain=2': settings are for sub-models of other packages, here scaled"),
    ],
)
def test_settings_that_do_not_fit_are_refused_with_the_bank(text: str, told: str) -> None:
    with pytest.raises(ConfigError, match=f"^--bank {re.escape(text)}: .*{told}"):
        bank_from_text(text)

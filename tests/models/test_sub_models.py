"""Claims about sub-models that other packages register: by name, and in and out of profiles."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError, ModelcastWarning, SubModelError
from modelcast.models.bank import Bank
from modelcast.models.profile import Profile, profile_from_text
from modelcast.models.sub_models import SUB_MODELS, registered_model
from modelcast.station.banks import bank_from_text, named_bank, profile_number_of

MODULE = """
from dataclasses import dataclass, field
import numpy as np
from tests.models.numpy_models import Coasting, Smoothed

@dataclass(frozen=True, slots=True)
class Drifting(Coasting):
    weights: object = field(default_factory=lambda: np.array([1.0, 0.5]))
    name = "drifting"

@dataclass(frozen=True, slots=True)
class Cursed(Coasting):
    name = "cursed"
    fault: str = "rows"

@dataclass(frozen=True, slots=True)
class Broken(Coasting):
    name = "broken"
    fault: str = "raises"

@dataclass(frozen=True, slots=True)
class Whole(Coasting):
    name = "paper"
"""
POINTS = {
    "drifting": "strange_models:Drifting",
    "cursed": "strange_models:Cursed",
    "broken": "strange_models:Broken",
    "other-name": "strange_models:Drifting",
    "paper": "strange_models:Whole",
    "number": "builtins:int",
}


@pytest.fixture(autouse=True)
def _package(other_package: Callable[..., Path]) -> None:
    other_package("strange", {SUB_MODELS.name: POINTS}, {"strange_models": MODULE})


def test_a_profile_gives_it_back_with_its_arrays() -> None:
    profile = Profile(Bank((registered_model("drifting"),)))
    again = profile_from_text(profile.text)
    assert again == profile
    assert again.bank.members[0].weights.tolist() == [1.0, 0.5]  # type: ignore[attr-defined]
    assert profile_number_of(profile.bank) == profile_number_of(again.bank)


def test_what_a_profile_would_round_is_refused() -> None:
    member = registered_model("drifting", weights=np.array([0.1, 0.5]))
    with pytest.raises(ValueError, match="field weights of the sub-model drifting would come back"):
        _ = Profile(Bank((member,))).text


def test_a_bank_of_it_was_trained_on_nothing_of_the_profile() -> None:
    assert named_bank("drifting+cv").trained_on == frozenset()
    assert named_bank("drifting+free").trained_on


def test_one_whose_rows_change_one_another_is_told_when_it_is_named() -> None:
    with pytest.warns(ModelcastWarning, match="sub-model cursed change one another"):
        bank_from_text("cursed+cv")


@pytest.mark.parametrize(
    ("name", "kind", "told"),
    [
        ("broken", SubModelError, "The sub-model broken failed in fit_batch: ZeroDivisionError"),
        ("other-name", ConfigError, "must be a frozen dataclass of that name, got Drifting named 'drifting'"),
        ("paper", ConfigError, "on the command line that is a whole bank"),
        ("number", ConfigError, "The sub-model registered as 'number' is no AbstractSubModel: 0"),
        ("nobody", ConfigError, "Unknown sub-model 'nobody'"),
    ],
)
def test_what_is_none_is_refused_with_its_name(name: str, kind: type[Exception], told: str) -> None:
    with pytest.raises(kind, match=re.escape(told)):
        registered_model(name)


def test_a_bank_sets_what_its_word_says() -> None:
    found = bank_from_text("drifting:fault=none-such+cv")
    assert (found.name, found.members[0].fault) == ("drifting:fault=none-such+cv", "none-such")  # type: ignore[attr-defined]
    assert [member.name for member in found.members] == ["drifting", "cv"]
    assert profile_number_of(found) != profile_number_of(bank_from_text("drifting+cv"))
    with pytest.raises(ConfigError, match=r"refuses its settings: .*'falt'.* It takes fault, weights"):
        bank_from_text("drifting:falt=rows+cv")
    with pytest.raises(ConfigError, match="'fault' is not KEY=VALUE"):
        bank_from_text("drifting:fault+cv")
    with pytest.raises(ConfigError, match="no sub-model is named 'cv:samples=3'"):
        bank_from_text("cv:samples=3")

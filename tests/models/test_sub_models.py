"""Claims about sub-models that other packages register: by name, and in and out of profiles."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import numpy as np
import pytest
from tests.models.numpy_models import Coasting

from modelcast.cli.brought import brought
from modelcast.core.exceptions import ConfigError, ModelcastWarning, SubModelError
from modelcast.models.bank import Bank
from modelcast.models.learned import FeatureMap, Perceptron
from modelcast.models.profile import Profile, profile_from_text
from modelcast.models.sub_models import SUB_MODELS, registered_model
from modelcast.models.trusted import Trusted
from modelcast.station.banks import bank_from_text, named_bank, profile_number_of

MODULE = """
from dataclasses import dataclass, field
import numpy as np
from modelcast.models.constant_velocity import ConstantVelocity
from tests.models.numpy_models import Coasting, Smoothed

@dataclass(frozen=True, slots=True)
class Drifting(Coasting):
    weights: object = field(default_factory=lambda: np.array([1.0, 0.5]))
    name = "drifting"

@dataclass(frozen=True, slots=True)
class Holding(Coasting):
    held: object = None
    name = "holding"

@dataclass(frozen=True, slots=True)
class Cursed(Coasting):
    name = "cursed"
    fault: str = "rows"

@dataclass(frozen=True, slots=True)
class Broken(Coasting):
    name = "broken"
    fault: str = "raises"

@dataclass(frozen=True, slots=True)
class Hollow(Coasting):
    name = "hollow"

    @property
    def parameter_names(self):
        raise LookupError("no table")

@dataclass(frozen=True, slots=True)
class Leaving(Coasting):
    name = "leaving"
    fault: str = "leaves"

@dataclass(frozen=True, slots=True)
class Gone(Coasting):
    name = "gone"

    @property
    def window(self):
        raise SystemExit(3)

@dataclass(frozen=True, slots=True)
class Sealed(Coasting):
    name = "sealed"

    def __reduce__(self):
        raise SystemExit(3)

@dataclass(frozen=True, slots=True)
class Bare(ConstantVelocity):
    name = "bare"

    def point_functions(self, dt_s):
        raise RuntimeError("no compiler")

@dataclass(frozen=True, slots=True)
class Whole(Coasting):
    name = "paper"
"""
POINTS = {
    "holding": "strange_models:Holding",
    "drifting": "strange_models:Drifting",
    "cursed": "strange_models:Cursed",
    "broken": "strange_models:Broken",
    "hollow": "strange_models:Hollow",
    "leaving": "strange_models:Leaving",
    "gone": "strange_models:Gone",
    "sealed": "strange_models:Sealed",
    "bare": "strange_models:Bare",
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
    with pytest.raises(
        ValueError, match=r"drifting would not come back .* weights would come back with other"
    ):
        _ = Profile(Bank((member,))).text


def network(scale: float = 1.0) -> Perceptron:
    """A dataclass of arrays, whose numbers fit in 32 bits."""
    inputs = FeatureMap(20).inputs
    return Perceptron(
        np.inf,
        centre=np.zeros(inputs),
        width=np.ones(inputs),
        weights_1=np.zeros((inputs, 1)),
        bias_1=np.zeros(1),
        weights_2=np.zeros((1, 1)),
        bias_2=np.zeros(1),
        weights_3=np.zeros((1, 2)),
        bias_3=np.array([0.5, 2.0]) * scale,
    )


def test_a_profile_gives_back_what_holds_arrays_deep_inside() -> None:
    profile = Profile(Bank((registered_model("holding", held=(network(), {"near": (network(2.0), 3)})),)))
    again = profile_from_text(profile.text)
    assert again == profile
    assert again.bank.members[0].held[1]["near"][0].bias_3.tolist() == [1.0, 4.0]  # type: ignore[attr-defined]


@dataclass(frozen=True, slots=True)
class Part:
    """A dataclass of the package's own."""

    gain: float = 0.5


class Count(IntEnum):
    """A number with a name."""

    TWO = 2


@pytest.mark.parametrize(
    ("held", "told"),
    [
        (network(0.1), "held.bias_3 would come back with other numbers"),
        ((1, {"a": network(0.1)}), "held[1]['a'].bias_3 would come back"),
        (np.float64(0.5), "held is np.float64(0.5) (float64) and would come back as float"),
        (np.str_("a"), "(str_) and would come back as str"),
        (Count.TWO, "(Count) and would come back as int"),
        ("inf", "held is 'inf' (str) and would come back as float"),
        ([1, 2], "(list) and would come back as tuple"),
        (np.array([1, 2]), "held is an array of int64 and would come back as float64"),
        (Part(), "as it is: held: a profile holds no Part: Part(gain=0.5)"),
        ((1, {"a": [Part()]}), "as it is: held[1]['a'][0]: a profile holds no Part"),
        ((0.5, float("nan")), "as it is: held[1]: a profile holds no NaN"),
        (np.array(0.5), "as it is: held is an array of shape ()"),
        ({"a": np.zeros((2, 0))}, "as it is: held['a'] is an array of shape (2, 0)"),
        (np.array(["fast"]), "as it is: held: could not convert"),
        ({"is": 3}, "as it is: the key 'is' of held has a meaning of its own"),
        ((1, {"float32": 0.5}), "as it is: the key 'float32' of held[1] has a meaning"),
        (Trusted(Coasting(), 1.0), "as it is: held.model: a profile holds no Coasting"),
        ({1: 2}, "the key 1 of held would come back as text"),
    ],
    ids=str,
)
def test_what_a_profile_would_change_is_refused_by_its_place(held: object, told: str) -> None:
    member = registered_model("holding", held=held)
    with pytest.raises(
        ValueError, match=f"^the sub-model holding would not come back.*{re.escape(told)}.*; fields hold"
    ):
        _ = Profile(Bank((member,))).text


def test_a_sub_model_inside_another_is_kept_and_refused_by_the_place_in_it() -> None:
    kept = registered_model("holding", held=(registered_model("drifting"),))
    again = profile_from_text(Profile(Bank((kept,))).text).bank.members[0]
    assert again.held[0].weights.tolist() == [1.0, 0.5]  # type: ignore[attr-defined]
    rounded = registered_model("holding", held=(registered_model("drifting", weights=np.array([0.1])),))
    told = re.escape("as it is: held[0].weights would come back with other numbers")
    with pytest.raises(ValueError, match=f"^the sub-model holding .*{told}.*; fields hold") as refused:
        _ = Profile(Bank((rounded,))).text
    assert str(refused.value).count("; fields hold") == 1


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
        ("hollow", ConfigError, "'hollow' of strange 1.2 cannot be used: LookupError: no table"),
        ("bare", ConfigError, "'bare' of strange 1.2 cannot be used: RuntimeError: no compiler"),
        ("leaving", SubModelError, "The sub-model leaving failed in fit_batch: SystemExit: 3"),
        ("gone", ConfigError, "'gone' of strange 1.2 cannot be used: SystemExit: 3"),
        ("sealed", SubModelError, "must pickle: 3"),
        ("nobody", ConfigError, "Unknown sub-model 'nobody'"),
    ],
)
def test_what_is_none_is_refused_with_its_name(name: str, kind: type[Exception], told: str) -> None:
    with pytest.raises(kind, match=re.escape(told)):
        registered_model(name)


def test_doctor_tells_of_all_where_one_ends_the_process() -> None:
    found = {one.name: one.problem for one in brought() if one.group == SUB_MODELS.name}
    assert set(found) == set(POINTS)
    assert "failed in fit_batch: SystemExit: 3" in found["leaving"]
    assert "cannot be used: SystemExit: 3" in found["gone"]
    assert not found["drifting"]


def test_a_bank_sets_what_its_word_says() -> None:
    found = bank_from_text("drifting:fault=none-such+cv")
    assert (found.name, found.members[0].fault) == ("drifting:fault=none-such+cv", "none-such")  # type: ignore[attr-defined]
    assert [member.name for member in found.members] == ["drifting", "cv"]
    assert profile_number_of(found) != profile_number_of(bank_from_text("drifting+cv"))
    with pytest.raises(ConfigError, match=r"refuses its settings: .*'falt'.* It takes fault, weights"):
        bank_from_text("drifting:falt=rows+cv")
    with pytest.raises(ConfigError, match="'fault' is not KEY=VALUE"):
        bank_from_text("drifting:fault+cv")
    with pytest.raises(ConfigError, match="settings are for sub-models of other packages"):
        bank_from_text("cv:samples=3")

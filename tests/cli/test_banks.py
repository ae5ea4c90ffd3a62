"""Claims about banks by name."""

import pytest

from modelcast.cli.banks import bank_from_text
from modelcast.core.exceptions import ConfigError

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
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_gives_the_sub_model_of_that_name_and_window(name: str) -> None:
    (member,) = bank_from_text(name, window=15).members
    assert member.name == name
    assert member.window == (15 if name.startswith("gp") else 21 if name == "learned" else 1)


def test_all_of_them_fit_into_one_bank() -> None:
    assert len(bank_from_text("+".join(NAMES)).members) == len(NAMES)


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"no sub-model is named 'gp'; there are cv, .* and learned"):
        bank_from_text("gp")

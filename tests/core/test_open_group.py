"""What other packages add: found by name with its package, refused with a reason."""

import re

import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.core.open_group import OpenGroup, Origin

COUNTERS = OpenGroup("example.counters", dict, called="counter", own={"plain": "collections:Counter"})
GROUP = COUNTERS.name


def test_ours_and_those_of_other_packages_are_known_by_name(other_package):
    other_package("second", {GROUP: {"zebra": "builtins:dict", "ant": "builtins:dict"}})
    assert COUNTERS.names() == ("ant", "zebra", "plain")
    assert COUNTERS.made("ant", a=1) == {"a": 1}
    assert COUNTERS.made("plain", "aab")["a"] == 2


def test_what_another_package_adds_says_from_where_it_comes(other_package):
    other_package("second", {GROUP: {"ant": "builtins:dict"}}, version="4.5")
    assert COUNTERS.origin("ant") == Origin("second", "4.5")
    assert str(COUNTERS.origin("ant")) == "second 4.5"
    assert COUNTERS.origin("plain") is None


def test_package_found_twice_on_the_path_counts_once(other_package, monkeypatch):
    site = other_package("second", {GROUP: {"ant": "builtins:dict"}})
    monkeypatch.syspath_prepend(f"{site}/.")
    assert COUNTERS.made("ant") == {}


@pytest.mark.parametrize("name", ["ant", "plain"])
def test_name_that_two_packages_register_is_refused_with_both(other_package, name):
    other_package("second", {GROUP: {name: "builtins:dict"}})
    other_package("third", {GROUP: {name: "builtins:dict"}})
    with pytest.raises(ConfigError, match=r"registered by .*(second and by third|third and by second)\."):
        COUNTERS.made(name)


def test_name_of_ours_cannot_be_replaced(other_package):
    other_package("second", {GROUP: {"plain": "builtins:dict"}})
    assert COUNTERS.names() == ("plain",)
    with pytest.raises(ConfigError, match="'plain' is registered by modelcast and by second"):
        COUNTERS.made("plain")


def test_unknown_name_lists_the_known_ones_and_where_to_add(other_package):
    other_package("second", {GROUP: {"ant": "builtins:dict"}})
    with pytest.raises(ConfigError, match=re.escape("Unknown counter 'bee'. Known: ant, plain.")):
        COUNTERS.made("bee")
    with pytest.raises(ConfigError, match="Unknown counter 'bee'"):
        COUNTERS.origin("bee")


MODULES = {
    "broken_counter": "1 / 0\n",
    "leaving_counter": "raise SystemExit(3)\n",
    "failing_counter": """
class Worn:
    def __repr__(self): raise OSError("no name")
def fails(): raise RuntimeError("no luck")
def imports(): import there_is_no_such_module
def leaves(): raise SystemExit(3)
def stops(): raise KeyboardInterrupt
""",
}


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("broken_counter:Ant", "ZeroDivisionError: division by zero"),
        ("no_such_module:Ant", "ModuleNotFoundError"),
        ("collections:Ant", "AttributeError"),
        ("leaving_counter:Ant", "SystemExit: 3"),
    ],
)
def test_package_that_does_not_load_is_named(other_package, value, told):
    other_package("second", {GROUP: {"ant": value}}, MODULES)
    with pytest.raises(ConfigError, match=f"'ant' of second does not load from '{value}': {told}"):
        COUNTERS.made("ant")


@pytest.mark.parametrize(
    ("maker", "told"),
    [
        ("fails", "RuntimeError: no luck"),
        ("imports", "ModuleNotFoundError: No module named 'there_is_no_such_module'"),
        ("leaves", "SystemExit: 3"),
    ],
)
def test_whatever_a_maker_raises_is_told_with_package_version_entry_point_and_cause(
    other_package, maker, told
):
    other_package("second", {GROUP: {"ant": f"failing_counter:{maker}"}}, MODULES)
    expected = f"The counter 'ant' of second 1.2 cannot be made by 'failing_counter:{maker}': {told}"
    with pytest.raises(ConfigError, match=re.escape(expected)):
        COUNTERS.made("ant")


def test_a_maker_is_interrupted_as_anything_is(other_package):
    other_package("second", {GROUP: {"ant": "failing_counter:stops"}}, MODULES)
    with pytest.raises(KeyboardInterrupt):
        COUNTERS.made("ant")


def test_thing_that_cannot_be_shown_is_refused_by_its_class(other_package):
    other_package("second", {GROUP: {"ant": "failing_counter:Worn"}}, MODULES)
    with pytest.raises(ConfigError, match="registered as 'ant' is no dict: <Worn instance at"):
        COUNTERS.made("ant")


def test_thing_of_another_kind_is_refused(other_package):
    other_package("second", {GROUP: {"ant": "builtins:list"}})
    with pytest.raises(ConfigError, match=r"registered as 'ant' is no dict: \[\]"):
        COUNTERS.made("ant")


def test_settings_that_another_package_refuses_come_with_its_name(other_package):
    other_package("second", {GROUP: {"ant": "fractions:Fraction"}})
    with pytest.raises(
        ConfigError,
        match=r"'ant' of second refuses its settings: Invalid literal.* It takes numerator, denominator",
    ):
        COUNTERS.made("ant", "x")

"""Claims about where random numbers come from."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.chance import child_generator

keys = st.lists(st.integers(0, 2**31) | st.text(max_size=12), max_size=4)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**63), key=keys)
def test_the_same_seed_and_key_give_the_same_numbers(seed: int, key: list[int | str]) -> None:
    assert np.array_equal(child_generator(seed, *key).random(4), child_generator(seed, *key).random(4))


def test_every_part_of_the_key_matters_and_so_does_its_place() -> None:
    generators = [
        child_generator(0, 0, "car", "loss"),
        child_generator(1, 0, "car", "loss"),
        child_generator(0, 1, "car", "loss"),
        child_generator(0, 0, "bus", "loss"),
        child_generator(0, 0, "car", "phase"),
        child_generator(0, 0, "loss", "car"),
        child_generator(0, "car", "loss"),
        child_generator(0),
    ]
    assert len({generator.random() for generator in generators}) == len(generators)


def test_numbers_are_the_same_on_every_machine() -> None:
    """A golden value: names are hashed by CRC-32, which unlike Python's own hash does not change."""
    assert child_generator(0, 1, "car", "loss").integers(10**9) == 652049969


def test_children_are_independent_of_each_other() -> None:
    one, other = (child_generator(0, run, "car", "loss").standard_normal(20_000) for run in (0, 1))
    assert abs(np.corrcoef(one, other)[0, 1]) < 4 / np.sqrt(20_000)

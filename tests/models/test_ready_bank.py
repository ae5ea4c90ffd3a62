"""Claims about a bank made ready: its tables are made once, and addresses stay in their process."""

import pickle

import numpy as np

from modelcast.models.bank import Bank
from modelcast.models.base import made_functions
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.members import ReadyBank
from modelcast.models.profile import default_profile


def test_tables_are_made_once() -> None:
    bank = default_profile().bank.carried()
    ready = ReadyBank.of(bank, 0.1)
    assert ready.members is ready.members
    assert made_functions(bank.members[0], 0.1) is made_functions(bank.members[0], 0.1)
    assert made_functions(bank.members[0], 0.1) is not made_functions(bank.members[0], 0.2)


def test_one_sub_model_is_not_taken_for_another_that_is_equal() -> None:
    one, other = ConstantVelocity(), ConstantVelocity()
    assert one == other
    assert made_functions(one, 0.1) is not made_functions(other, 0.1)


def test_addresses_are_left_behind_where_a_bank_goes_to_another_process() -> None:
    ready = ReadyBank.of(Bank((ConstantVelocity(),)), 0.1)
    first = ready.members
    there = pickle.loads(pickle.dumps(ready))  # noqa: S301 - just made
    assert there.members is not first
    for name, column in there.members._asdict().items():
        assert np.array_equal(column, getattr(first, name)), name

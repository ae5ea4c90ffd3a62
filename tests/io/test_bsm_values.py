"""Values of core data: codes and units mean what the codec says that they mean."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.io.bsm_values import CORE_COLUMNS, core_in_si, instants_ms
from modelcast.messages.bsm_fields import CORE_FIELDS

FIELDS = {field.name: field for field in CORE_FIELDS}


@given(data=st.data(), column=st.sampled_from(list(CORE_COLUMNS)))
def test_a_code_has_the_value_that_the_codec_gives_it_in_either_form(data, column):
    field = FIELDS[CORE_COLUMNS[column]]
    code = data.draw(st.integers(field.low, field.high))
    expected = field.value_of(code)
    in_units = code * field.step[0] / field.step[1]
    raw = {name: np.zeros(2) for name in CORE_COLUMNS} | {column: np.array([code, in_units])}
    found = core_in_si(raw, codes=np.array([True, False]))[column]
    if expected is None:
        assert np.isnan(found).all()
    else:
        unlucky = in_units == field.unavailable
        assert found[0] == pytest.approx(expected)
        assert unlucky or found[1] == pytest.approx(expected)


@given(instant=st.integers(0, 10**12), late=st.integers(-29_000, 29_000))
def test_an_instant_is_found_again_from_its_mark_and_a_stamp_within_half_a_minute(instant, late):
    (found,) = instants_ms(np.array([float(instant + late)]), np.array([float(instant % 60_000)]))
    assert found == instant

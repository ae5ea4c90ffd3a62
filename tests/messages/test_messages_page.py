"""Claims about the page that describes the messages field by field."""

from pathlib import Path

import pytest

from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Field

PAGE = (Path(__file__).parents[2] / "docs" / "messages.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("field", CORE_FIELDS, ids=lambda field: field.name)
def test_the_page_has_the_row_of_the_table(field: Field) -> None:
    first, last = field.known_codes
    begins = f"| `{field.name}` | `{field.standard_name}` | {field.width_bits} | {first}..{last} |"
    (row,) = (line for line in PAGE.splitlines() if line.startswith(begins))
    step, unavailable, _beyond = (cell.strip() for cell in row.strip("|").split("|")[4:])
    assert unavailable == ("" if field.unavailable is None else str(field.unavailable))
    if field.unit:
        number, unit = step.split()
        numerator, _, denominator = number.partition("/")
        assert float(numerator) / float(denominator or 1) == pytest.approx(field.step[0] / field.step[1])
        assert unit == field.unit

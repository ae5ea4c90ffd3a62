"""Claims about the page that describes the messages field by field."""

from pathlib import Path

import pytest

from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Field
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth

PAGE = (Path(__file__).parents[2] / "docs" / "messages.md").read_text(encoding="utf-8")
VEHICLES, PEOPLE = PAGE.split("## Personal safety message")


@pytest.mark.parametrize(
    ("field", "page"),
    [*((field, VEHICLES) for field in CORE_FIELDS), *((field, PEOPLE) for field in PERSON_FIELDS)],
    ids=lambda given: given.name if isinstance(given, Field) else "",
)
def test_the_page_has_the_row_of_the_table(field: Field, page: str) -> None:
    first, last = field.known_codes
    begins = f"| `{field.name}` | `{field.standard_name}` | {field.width_bits} | {first}..{last} |"
    (row,) = (line for line in page.splitlines() if line.startswith(begins))
    step, unavailable, _beyond = (cell.strip() for cell in row.strip("|").split("|")[4:])
    assert unavailable == ("" if field.unavailable is None else str(field.unavailable))
    if field.unit:
        number, unit = step.split()
        numerator, _, denominator = number.partition("/")
        assert float(numerator) / float(denominator or 1) == pytest.approx(field.step[0] / field.step[1])
        assert unit == field.unit


def bits(shape: AbstractShape) -> tuple[int, int]:
    """Fewest and most bits of a part."""
    match shape:
        case Number(field):
            return (field.width_bits + shape.extensible,) * 2
        case Truth():
            return 1, 1
        case Record():
            ahead = shape.extensible + len(shape.optional)
            least = sum(bits(one)[0] for one in shape.members if one.name not in shape.optional)
            return ahead + least, ahead + sum(bits(one)[1] for one in shape.members)
        case Series():
            ahead = (shape.most - 1).bit_length()
            return ahead + bits(shape.item)[0], ahead + shape.most * bits(shape.item)[1]
        case Choice():
            ahead = 1 + (len(shape.alternatives) - 1).bit_length()
            each = [bits(one) for one in shape.alternatives]
            return ahead + min(least for least, _ in each), ahead + max(most for _, most in each)
        case _:
            raise AssertionError(shape)


@pytest.mark.parametrize("shape", PART_SHAPES, ids=lambda shape: shape.name)
def test_the_page_has_the_row_of_every_optional_part(shape: AbstractShape) -> None:
    begins = f"| `{shape.name}` | `{shape.standard_name}` |"
    (row,) = (line for line in PEOPLE.splitlines() if line.startswith(begins))
    told, holds = (cell.strip() for cell in row.strip("|").split("|")[2:])
    least, most = bits(shape)
    assert told in {str(least), f"{least} or {most}", f"{least} and more"}
    assert told.isdigit() == (least == most)
    names: tuple[str, ...] = ()
    match shape:
        case Number(field):
            names = field.choices or field.flags
        case Record(members=members):
            names = tuple(member.name for member in members)
        case Choice(alternatives=alternatives):
            names = tuple(one.name for one in alternatives)
        case _:
            pass
    assert all(f"`{name}`" in holds for name in names)

"""Messages of people for the tests: drawn from the one description of their fields."""

from typing import Any

from hypothesis import strategies as st

from modelcast.messages.fields import Field
from modelcast.messages.psm import PersonalSafetyMessage
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS, PERSON_INDEX
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth

__all__ = ["ADDITIONS", "UNKNOWN_ELEVATION", "codes_of", "messages", "values_of"]

OCTETS = st.binary(min_size=1, max_size=40) | st.binary(min_size=126, max_size=130)
REGIONAL = st.lists(st.tuples(st.integers(0, 255), OCTETS), max_size=4).map(tuple)
ADDITIONS = st.lists(st.none() | OCTETS, max_size=4).map(
    lambda found: tuple(found) if any(one is not None for one in found) else ()
)
UNKNOWN_ELEVATION = -4096


def codes_of(fields: tuple[Field, ...]) -> Any:
    """Codes of fields, over the whole range of each."""
    return st.tuples(*(st.integers(field.low, field.high) for field in fields))


def values_of(shape: AbstractShape) -> Any:
    """Values of a shape."""
    match shape:
        case Number(field) | Truth(field):
            return st.integers(field.low, field.high)
        case Record():
            return st.tuples(
                *(
                    values_of(member) | st.none() if member.name in shape.optional else values_of(member)
                    for member in shape.members
                )
            )
        case Series():
            return st.lists(values_of(shape.item), min_size=1, max_size=shape.most).map(tuple)
        case Choice():
            return st.one_of(
                *(st.tuples(st.just(i), values_of(one)) for i, one in enumerate(shape.alternatives))
            )
    raise AssertionError(shape)


VALUES = {shape.name: values_of(shape) for shape in PART_SHAPES}


@st.composite
def messages(draw: Any, additions: Any = ADDITIONS) -> PersonalSafetyMessage:
    """Whole messages."""
    codes = list(draw(codes_of(PERSON_FIELDS)))
    has_elevation = draw(st.booleans())
    if not has_elevation:
        codes[PERSON_INDEX["elevation_m"]] = UNKNOWN_ELEVATION
    names = draw(st.sets(st.sampled_from(list(VALUES))))
    parts = {name: draw(value) for name, value in VALUES.items() if name in names}
    return PersonalSafetyMessage(
        tuple(codes),
        has_elevation=has_elevation,
        acceleration=parts.pop("acceleration", ()),
        path_prediction=parts.pop("path_prediction", ()),
        parts=tuple(parts.items()),
        regional=draw(REGIONAL),
        additions=draw(additions),
        frame_additions=draw(additions),
    )

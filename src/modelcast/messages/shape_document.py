"""Parts of messages in plain documents: a record is an object, a list a list, a choice an object of one.

Members left out of a record that may be left out are absent from it; others that are not known are null.
"""

from collections.abc import Mapping
from typing import Any, cast

from modelcast.core.rules import shown
from modelcast.messages.field_document import code_of_document, field_document, given_list
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth, Value

__all__ = ["shape_document", "value_of_document"]


def shape_document(shape: AbstractShape, value: Value) -> Any:
    """Plain value of a part.

    Parameters
    ----------
    shape
        Its shape.
    value
        Of that shape.
    """
    match shape:
        case Number(field):
            return field_document(field, cast("int", value))
        case Truth():
            return bool(value)
        case Record(members=members):
            pairs = zip(members, cast("tuple[Value | None, ...]", value), strict=True)
            return {member.name: shape_document(member, one) for member, one in pairs if one is not None}
        case Series(item=item):
            return [shape_document(item, one) for one in cast("tuple[Value, ...]", value)]
        case Choice(alternatives=alternatives):
            place, one = cast("tuple[int, Value]", value)
            return {alternatives[place].name: shape_document(alternatives[place], one)}
        case _:
            raise TypeError(f"no document of {shape}")


def value_of_document(shape: AbstractShape, given: object) -> Value:
    """Value of a part that a plain value stands for.

    Parameters
    ----------
    shape
        The part's shape.
    given
        As `shape_document` makes.

    Raises
    ------
    ValueError
        Where it has the wrong type, an unknown name or no code, or lacks what cannot be left out.
    """
    match shape:
        case Number(field):
            return code_of_document(field, given)
        case Truth():
            if not isinstance(given, bool):
                raise ValueError(f"{shape.name} must be true or false, got {shown(given)}")  # noqa: TRY004
            return int(given)
        case Record():
            return _record(shape, given)
        case Series(item=item):
            return tuple(value_of_document(item, one) for one in given_list(shape.name, given))
        case Choice(alternatives=alternatives):
            return _choice(shape.name, alternatives, given)
        case _:
            raise TypeError(f"no document of {shape}")


def _record(shape: Record, given: object) -> Value:
    if not isinstance(given, Mapping):
        raise ValueError(f"{shape.name} must be an object, got {shown(given)}")  # noqa: TRY004
    found = cast("Mapping[str, object]", given)
    names = [member.name for member in shape.members]
    unknown = sorted(found.keys() - set(names))
    if unknown:
        raise ValueError(f"{shape.name} has no {', '.join(unknown)}; it has {', '.join(names)}")
    return tuple(
        None
        if member.name in shape.optional and member.name not in found
        else value_of_document(member, found.get(member.name))
        for member in shape.members
    )


def _choice(name: str, alternatives: tuple[AbstractShape, ...], given: object) -> Value:
    found = cast("Mapping[str, object]", given if isinstance(given, Mapping) else {})
    names = [one.name for one in alternatives]
    if len(found) != 1 or not found.keys() <= set(names):
        told = shown(cast("object", given))
        raise ValueError(f"{name} must be an object of one of {', '.join(names)}, got {told}")
    ((chosen, one),) = found.items()
    place = names.index(chosen)
    return place, value_of_document(alternatives[place], one)

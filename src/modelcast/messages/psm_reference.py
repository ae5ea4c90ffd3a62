"""Personal safety messages by the second codec, asn1tools, from the description of their fields.

Only tests call it; see `asn1`.
"""

from typing import Any, cast

from modelcast.messages.asn1 import code_of_item, reference_codec, standard_item
from modelcast.messages.psm import PersonalSafetyMessage
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS, PERSON_INDEX, PERSONAL_SAFETY_MESSAGE
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth, Value

__all__ = [
    "person_of_reference_value",
    "person_reference_value",
    "reference_decode_psm",
    "reference_encode_psm",
]

_ELEVATION = PERSON_FIELDS[PERSON_INDEX["elevation_m"]]


def person_reference_value(message: PersonalSafetyMessage) -> dict[str, Any]:
    """Value of the module's type ``PersonalSafetyMessage`` as asn1tools takes it.

    Parameters
    ----------
    message
        One without extension additions: the module has none.

    Raises
    ------
    ValueError
        Where it has some.
    """
    if message.additions or message.frame_additions:
        raise ValueError("the module has no extension additions: encode them with encode_psm")
    value: dict[str, Any] = {}
    for field, code in zip(PERSON_FIELDS, message.codes, strict=True):
        group, _, name = field.standard_name.rpartition(".")
        if message.has_elevation or field is not _ELEVATION:
            (value.setdefault(group, {}) if group else value)[name] = standard_item(field, code)
    for shape in PART_SHAPES:
        part = message.part(shape.name)
        if part is not None:
            value[shape.standard_name] = _item(shape, part)
    if message.regional:
        value["regional"] = [{"regionId": i, "regExtValue": octets} for i, octets in message.regional]
    return value


def _item(shape: AbstractShape, value: Value) -> Any:
    match shape:
        case Number(field):
            return standard_item(field, cast("int", value))
        case Record(members=members):
            pairs = zip(members, cast("tuple[Value | None, ...]", value), strict=True)
            return {member.standard_name: _item(member, one) for member, one in pairs if one is not None}
        case Series(item=item):
            return [_item(item, one) for one in cast("tuple[Value, ...]", value)]
        case Choice(alternatives=alternatives):
            place, one = cast("tuple[int, Value]", value)
            return alternatives[place].standard_name, _item(alternatives[place], one)
        case _:
            return bool(value)


def person_of_reference_value(value: Any) -> PersonalSafetyMessage:
    """Message of a value of the module's type ``PersonalSafetyMessage`` as asn1tools gives it.

    Parameters
    ----------
    value
        As `person_reference_value` makes it.
    """
    codes: list[int] = []
    has_elevation = True
    for field in PERSON_FIELDS:
        item = value
        for name in field.standard_name.split("."):
            item = item.get(name)
        if item is None:
            has_elevation = False
        codes.append(field.code_of(None) if item is None else code_of_item(field, item))
    parts = {
        shape.name: _value(shape, value[shape.standard_name])
        for shape in PART_SHAPES
        if shape.standard_name in value
    }
    return PersonalSafetyMessage(
        tuple(codes),
        has_elevation=has_elevation,
        acceleration=cast("tuple[int, ...]", parts.pop("acceleration", ())),
        path_prediction=cast("tuple[int, ...]", parts.pop("path_prediction", ())),
        parts=tuple(parts.items()),
        regional=tuple((one["regionId"], one["regExtValue"]) for one in value.get("regional", ())),
    )


def _value(shape: AbstractShape, item: Any) -> Value:
    match shape:
        case Number(field):
            return code_of_item(field, item)
        case Record(members=members):
            return tuple(
                _value(member, item[member.standard_name]) if member.standard_name in item else None
                for member in members
            )
        case Series(item=inner):
            return tuple(_value(inner, one) for one in item)
        case Choice(alternatives=alternatives):
            names = [one.standard_name for one in alternatives]
            place = names.index(item[0])
            return place, _value(alternatives[place], item[1])
        case Truth():
            return int(item)
        case _:
            raise TypeError(shape)


def reference_encode_psm(message: PersonalSafetyMessage) -> bytes:
    """Octets that asn1tools makes of a message.

    Parameters
    ----------
    message
        One without extension additions.
    """
    inner = reference_codec().encode("PersonalSafetyMessage", person_reference_value(message))
    return reference_codec().encode("MessageFrame", {"messageId": PERSONAL_SAFETY_MESSAGE, "value": inner})


def reference_decode_psm(data: bytes) -> PersonalSafetyMessage:
    """Message that asn1tools finds in octets; what it raises on others is its own affair.

    Parameters
    ----------
    data
        Octets of a personal safety message in its frame, without extension additions.
    """
    frame: Any = reference_codec().decode("MessageFrame", data)
    return person_of_reference_value(reference_codec().decode("PersonalSafetyMessage", frame["value"]))

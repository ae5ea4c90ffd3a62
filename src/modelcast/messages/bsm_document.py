"""A basic safety message as a plain document: the names and SI units of `bsm_fields`, for JSON.

::

    {"message": "bsm", "message_count": 83, "temporary_id": "31325433", "second_of_minute_s": 11.096,
     "latitude_deg": 40.5657882, ..., "transmission": "forwardGears", "wheel_brakes": ["left_front"], ...,
     "part_ii": [{"id": 0, "octets": "05f1"}], "regional": [{"id": 128, "octets": "00"}]}

Unavailable quantities are null. Names stand for the codes of enumerations and the bits of bit strings. A code
that the standard reserves is ``{"code": 61000}``; any field may be given so. Writing the message of a
document of a message gives the same octets.
"""

from collections.abc import Mapping, Sequence
from typing import Any, cast

from modelcast.core.rules import shown
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, Content
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.fields import Field

__all__ = ["document_of", "message_of"]

_KIND = "bsm"
_REST = ("part_ii", "regional", "additions", "frame_additions")


def document_of(message: BasicSafetyMessage) -> dict[str, Any]:
    """Plain values of a message; parts it does not have are left out.

    Parameters
    ----------
    message
        Any message.
    """
    document: dict[str, Any] = {"message": _KIND}
    for field, code in zip(CORE_FIELDS, message.core.codes, strict=True):
        document[field.name] = _plain(field, code)
    for name, contents in (("part_ii", message.part_ii), ("regional", message.regional)):
        if contents:
            document[name] = [{"id": number, "octets": octets.hex()} for number, octets in contents]
    for name, additions in (
        ("additions", message.additions),
        ("frame_additions", message.frame_additions),
    ):
        if additions:
            document[name] = [None if octets is None else octets.hex() for octets in additions]
    return document


def _plain(field: Field, code: int) -> Any:
    if field.choices:
        return field.choices[code]
    if field.flags:
        most = len(field.flags) - 1
        return [name for bit, name in enumerate(field.flags) if code >> (most - bit) & 1]
    if field.name == "temporary_id":
        return f"{code:08x}"
    if field.is_reserved(code):
        return {"code": code}
    value = field.value_of(code)
    return int(value) if field.name == "message_count" and value is not None else value


def message_of(document: object) -> BasicSafetyMessage:
    """Message that a document describes; quantities are rounded to the nearest code.

    Parameters
    ----------
    document
        A mapping as `document_of` makes. Quantities left out or null are unavailable.

    Raises
    ------
    ValueError
        Where a name is unknown, a value has the wrong type or no code, or a field without a code for
        unavailable is left out.
    """
    if not isinstance(document, Mapping):
        raise ValueError(f"a message is an object with fields, got {shown(document)}")  # noqa: TRY004
    given = cast("Mapping[str, object]", document)
    unknown = sorted(given.keys() - CORE_INDEX.keys() - {"message", *_REST})
    if unknown:
        raise ValueError(f"no field is called {', '.join(unknown)}; the fields are {', '.join(CORE_INDEX)}")
    if given.get("message", _KIND) != _KIND:
        raise ValueError(f"message must be '{_KIND}', got {shown(given['message'])}")
    _refuse_missing(given)
    core = BsmCore(tuple(_code(field, given.get(field.name)) for field in CORE_FIELDS))
    part_ii, regional = (_contents(name, given.get(name)) for name in _REST[:2])
    additions, frame_additions = (_additions(name, given.get(name)) for name in _REST[2:])
    return BasicSafetyMessage(
        core, part_ii=part_ii, regional=regional, additions=additions, frame_additions=frame_additions
    )


def _refuse_missing(given: Mapping[str, object]) -> None:
    """Name all fields at once that are not given and have no code for that."""
    missing = [
        field.name for field in CORE_FIELDS if field.unavailable is None and given.get(field.name) is None
    ]
    if missing:
        others = f", nor {', '.join(missing[1:])}" if missing[1:] else ""
        raise ValueError(f"{missing[0]} is not known{others}, and there is no code for that: give a value")


def _code(field: Field, given: object) -> int:
    if isinstance(given, Mapping):
        code = cast("Mapping[str, object]", given).get("code")
        if type(code) is not int or not field.low <= code <= field.high:
            raise ValueError(
                f"{field.name}: a code is a whole number within {field.low}..{field.high}, got {shown(code)}"
            )
        return code
    if given is None:
        return field.code_of(None)
    if field.choices:
        if given not in field.choices:
            raise ValueError(f"{field.name} must be one of {', '.join(field.choices)}, got {shown(given)}")
        return field.choices.index(cast("str", given))
    if field.flags:
        return _flags(field, given)
    if field.name == "temporary_id":
        return int.from_bytes(octets_of_digits(field.name, given, count=4), "big")
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f"{field.name} must be a number or null, got {shown(given)}")  # noqa: TRY004
    return field.code_of(given)


def _flags(field: Field, given: object) -> int:
    names = _list(field.name, given)
    for name in names:
        if name not in field.flags:
            raise ValueError(f"{field.name} may hold {', '.join(field.flags)}, got {shown(name)}")
    return sum(1 << bit for bit, name in enumerate(reversed(field.flags)) if name in names)


def _list(name: str, given: object) -> Sequence[object]:
    if not isinstance(given, list | tuple):
        raise ValueError(f"{name} must be a list, got {shown(given)}")  # noqa: TRY004
    return cast("Sequence[object]", given)


def _contents(name: str, given: object) -> tuple[Content, ...]:
    found: list[Content] = []
    for entry in _list(name, [] if given is None else given):
        parts = cast("Mapping[str, object]", entry if isinstance(entry, Mapping) else {})
        number = parts.get("id")
        if type(number) is not int or set(parts) != {"id", "octets"}:
            raise ValueError(f"{name} holds objects with id and octets, got {shown(cast('object', entry))}")
        found.append((number, octets_of_digits(f"{name}, id {number}: octets", parts["octets"])))
    return tuple(found)


def _additions(name: str, given: object) -> tuple[bytes | None, ...]:
    entries = _list(name, [] if given is None else given)
    return tuple(None if entry is None else octets_of_digits(name, entry) for entry in entries)

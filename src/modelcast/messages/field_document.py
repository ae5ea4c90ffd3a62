"""Fields and octets of messages in plain documents: what all kinds of messages share.

A code is a number in SI units, null where unavailable, a name, a list of names, hexadecimal digits, or
``{"code": 61000}`` where the standard reserves it; any field may be given so.
"""

from collections.abc import Mapping, Sequence
from typing import Any, cast

from modelcast.core.rules import shown
from modelcast.messages.contents import Content
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.fields import Field, Outside

__all__ = [
    "additions_document",
    "additions_of",
    "code_of_document",
    "contents_document",
    "contents_of",
    "field_document",
    "given_list",
    "given_message",
    "refuse_missing",
]


def field_document(field: Field, code: int) -> Any:
    """Plain value of a code.

    Parameters
    ----------
    field
        The field.
    code
        Its code.
    """
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
    return int(value) if field.outside is Outside.REFUSE and value is not None else value


def code_of_document(field: Field, given: object) -> int:
    """Code that a plain value stands for, the nearest one where it is a quantity.

    Parameters
    ----------
    field
        The field.
    given
        As `field_document` makes; None for unavailable.

    Raises
    ------
    ValueError
        Where it has the wrong type or no code.
    """
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
    names = given_list(field.name, given)
    for name in names:
        if name not in field.flags:
            raise ValueError(f"{field.name} may hold {', '.join(field.flags)}, got {shown(name)}")
    return sum(1 << bit for bit, name in enumerate(reversed(field.flags)) if name in names)


def given_message(
    document: object, kind: str, fields: Sequence[Field], others: Sequence[str]
) -> Mapping[str, object]:
    """The document of a message, its names known.

    Parameters
    ----------
    document
        Anything.
    kind
        What its ``message`` must be, where it is there.
    fields
        Fields that it may have.
    others
        Other names that it may have.

    Raises
    ------
    ValueError
        Where it is no mapping, of another kind, or has an unknown name.
    """
    if not isinstance(document, Mapping):
        raise ValueError(f"a message is an object with fields, got {shown(document)}")  # noqa: TRY004
    given = cast("Mapping[str, object]", document)
    names = [field.name for field in fields]
    unknown = sorted(given.keys() - {"message", *names, *others})
    if unknown:
        raise ValueError(f"no field is called {', '.join(unknown)}; the fields are {', '.join(names)}")
    if given.get("message", kind) != kind:
        raise ValueError(f"message must be '{kind}', got {shown(given['message'])}")
    return given


def refuse_missing(fields: Sequence[Field], given: Mapping[str, object]) -> None:
    """Name all fields at once that are not given and have no code for that.

    Parameters
    ----------
    fields
        The fields.
    given
        Plain values by our names.

    Raises
    ------
    ValueError
        Where there are any.
    """
    missing = [field.name for field in fields if field.unavailable is None and given.get(field.name) is None]
    if missing:
        *first, last = missing
        named = f"{', '.join(first)} and {last}" if first else last
        raise ValueError(f"{named} must be given; all other fields may be left out, as not available")


def given_list(name: str, given: object) -> Sequence[object]:
    """A list in a document.

    Parameters
    ----------
    name
        What the caller calls it.
    given
        Anything.

    Raises
    ------
    ValueError
        Where it is none.
    """
    if not isinstance(given, list | tuple):
        raise ValueError(f"{name} must be a list, got {shown(given)}")  # noqa: TRY004
    return cast("Sequence[object]", given)


def contents_document(contents: Sequence[Content]) -> list[dict[str, Any]]:
    """Plain value of contents.

    Parameters
    ----------
    contents
        Id and octets of each.
    """
    return [{"id": number, "octets": octets.hex()} for number, octets in contents]


def contents_of(name: str, given: object) -> tuple[Content, ...]:
    """Contents that a plain value stands for.

    Parameters
    ----------
    name
        What the caller calls them.
    given
        As `contents_document` makes; None for none.

    Raises
    ------
    ValueError
        Where it is anything else.
    """
    found: list[Content] = []
    for entry in given_list(name, [] if given is None else given):
        parts = cast("Mapping[str, object]", entry if isinstance(entry, Mapping) else {})
        number = parts.get("id")
        if type(number) is not int or set(parts) != {"id", "octets"}:
            raise ValueError(f"{name} holds objects with id and octets, got {shown(cast('object', entry))}")
        found.append((number, octets_of_digits(f"{name}, id {number}: octets", parts["octets"])))
    return tuple(found)


def additions_document(additions: Sequence[bytes | None]) -> list[str | None]:
    """Plain value of extension additions.

    Parameters
    ----------
    additions
        Octets of each, None where absent.
    """
    return [None if octets is None else octets.hex() for octets in additions]


def additions_of(name: str, given: object) -> tuple[bytes | None, ...]:
    """Extension additions that a plain value stands for.

    Parameters
    ----------
    name
        What the caller calls them.
    given
        As `additions_document` makes; None for none.

    Raises
    ------
    ValueError
        Where it is anything else.
    """
    entries = given_list(name, [] if given is None else given)
    return tuple(None if entry is None else octets_of_digits(name, entry) for entry in entries)

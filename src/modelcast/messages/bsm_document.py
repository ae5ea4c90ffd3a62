"""A basic safety message as a plain document: the names and SI units of `bsm_fields`, for JSON.

::

    {"message": "bsm", "message_count": 83, "temporary_id": "31325433", "second_of_minute_s": 11.096,
     "latitude_deg": 40.5657882, ..., "transmission": "forwardGears", "wheel_brakes": ["left_front"], ...,
     "part_ii": [{"id": 0, "octets": "05f1"}], "regional": [{"id": 128, "octets": "00"}]}

Unavailable quantities are null. Names stand for the codes of enumerations and the bits of bit strings. A code
that the standard reserves is ``{"code": 61000}``; any field may be given so. Writing the message of a
document of a message gives the same octets.
"""

from typing import Any, Final

from modelcast.messages.bsm import BasicSafetyMessage, BsmCore
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.field_document import (
    additions_document,
    additions_of,
    code_of_document,
    contents_document,
    contents_of,
    field_document,
    given_message,
    refuse_missing,
)

__all__ = ["document_of", "message_of"]

_KIND: Final = "bsm"
_CONTENTS: Final = ("part_ii", "regional")
_ADDITIONS: Final = ("additions", "frame_additions")


def document_of(message: BasicSafetyMessage) -> dict[str, Any]:
    """Plain values of a message; parts it does not have are left out.

    Parameters
    ----------
    message
        Any message.
    """
    document: dict[str, Any] = {"message": _KIND}
    for field, code in zip(CORE_FIELDS, message.core.codes, strict=True):
        document[field.name] = field_document(field, code)
    for name in _CONTENTS:
        contents = getattr(message, name)
        if contents:
            document[name] = contents_document(contents)
    for name in _ADDITIONS:
        additions = getattr(message, name)
        if additions:
            document[name] = additions_document(additions)
    return document


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
    given = given_message(document, _KIND, CORE_FIELDS, (*_CONTENTS, *_ADDITIONS))
    refuse_missing(CORE_FIELDS, given)
    core = BsmCore(tuple(code_of_document(field, given.get(field.name)) for field in CORE_FIELDS))
    part_ii, regional = (contents_of(name, given.get(name)) for name in _CONTENTS)
    additions, frame_additions = (additions_of(name, given.get(name)) for name in _ADDITIONS)
    return BasicSafetyMessage(
        core, part_ii=part_ii, regional=regional, additions=additions, frame_additions=frame_additions
    )

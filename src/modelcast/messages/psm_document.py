"""A personal safety message as a plain document: the names and SI units of `psm_fields`, for JSON.

::

    {"message": "psm", "basic_type": "aPEDALCYCLIST", "second_of_minute_s": 11.096, "message_count": 83,
     "temporary_id": "31325433", "latitude_deg": 40.5657882, ..., "heading_rad": 1.2,
     "path_prediction": {"path_radius_m": 12.3, "path_confidence_ratio": 0.5},
     "propulsion": {"motor": "bicycle"}, "use_state": ["calling"], "cross_state": true,
     "regional": [{"id": 128, "octets": "00"}]}

As in the document of a basic safety message (`bsm_document`). Optional parts that are absent are left out,
and so is an elevation that is; null is one that is there and not known. Writing the message of a document of
a message gives the same octets.
"""

from typing import Any, Final, cast

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
from modelcast.messages.psm import PersonalSafetyMessage
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS
from modelcast.messages.shape_document import shape_document, value_of_document

__all__ = ["PERSON_KIND", "person_document", "person_of"]

PERSON_KIND: Final = "psm"
"""What ``message`` is in the document of one."""

_ELEVATION: Final = "elevation_m"
_ADDITIONS: Final = ("additions", "frame_additions")


def person_document(message: PersonalSafetyMessage) -> dict[str, Any]:
    """Plain values of a message; parts it does not have are left out.

    Parameters
    ----------
    message
        Any message.
    """
    document: dict[str, Any] = {"message": PERSON_KIND}
    for field, code in zip(PERSON_FIELDS, message.codes, strict=True):
        if message.has_elevation or field.name != _ELEVATION:
            document[field.name] = field_document(field, code)
    for shape in PART_SHAPES:
        part = message.part(shape.name)
        if part is not None:
            document[shape.name] = shape_document(shape, part)
    if message.regional:
        document["regional"] = contents_document(message.regional)
    for name in _ADDITIONS:
        additions = getattr(message, name)
        if additions:
            document[name] = additions_document(additions)
    return document


def person_of(document: object) -> PersonalSafetyMessage:
    """Message that a document describes; quantities are rounded to the nearest code.

    Parameters
    ----------
    document
        A mapping as `person_document` makes. Quantities left out or null are unavailable.

    Raises
    ------
    ValueError
        Where a name is unknown, a value has the wrong type or no code, or a field without a code for
        unavailable is left out.
    """
    names = [shape.name for shape in PART_SHAPES]
    given = given_message(document, PERSON_KIND, PERSON_FIELDS, (*names, "regional", *_ADDITIONS))
    refuse_missing(PERSON_FIELDS, given)
    codes = tuple(code_of_document(field, given.get(field.name)) for field in PERSON_FIELDS)
    parts = {
        shape.name: value_of_document(shape, given[shape.name])
        for shape in PART_SHAPES
        if shape.name in given
    }
    additions, frame_additions = (additions_of(name, given.get(name)) for name in _ADDITIONS)
    return PersonalSafetyMessage(
        codes,
        has_elevation=_ELEVATION in given,
        acceleration=cast("tuple[int, ...]", parts.pop("acceleration", ())),
        path_prediction=cast("tuple[int, ...]", parts.pop("path_prediction", ())),
        parts=tuple(parts.items()),
        regional=contents_of("regional", given.get("regional")),
        additions=additions,
        frame_additions=frame_additions,
    )

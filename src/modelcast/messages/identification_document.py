"""An identification as a plain document, for JSON.

::

    {"message": "identification", "temporary_id": "00000001", "sequence": 7, "sub_model": 2, "age_s": 1.3}

Writing the identification of a document of one gives the same octets.
"""

from collections.abc import Mapping
from typing import Any

from modelcast.core.rules import shown
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.mbc_wire import AGE, IdentificationMessage

__all__ = ["IDENTIFICATION_KIND", "identification_document", "identification_of"]

IDENTIFICATION_KIND = "identification"
_NAMES = ("temporary_id", "sequence", "sub_model", "age_s")


def identification_document(message: IdentificationMessage) -> dict[str, Any]:
    """Plain values of an identification.

    Parameters
    ----------
    message
        The identification.

    Examples
    --------
    >>> identification_document(IdentificationMessage(1, 7, sub_model=2, age=130))["age_s"]
    1.3
    """
    return {
        "message": IDENTIFICATION_KIND,
        "temporary_id": f"{message.temporary_id:08x}",
        "sequence": message.sequence,
        "sub_model": message.sub_model,
        "age_s": message.age_s,
    }


def identification_of(document: Mapping[str, object]) -> IdentificationMessage:
    """Identification that a document describes.

    Parameters
    ----------
    document
        As `identification_document` makes; all names are needed.

    Raises
    ------
    ValueError
        Where a name is missing or unknown, or a value has the wrong type or no code.
    """
    if set(document) != {"message", *_NAMES}:
        raise ValueError(f"an identification has {', '.join(_NAMES)}, got {shown(list(document))}")
    temporary_id, sequence, sub_model, age_s = (document[name] for name in _NAMES)
    octets = octets_of_digits("temporary_id", temporary_id, count=4)
    if type(sequence) is not int or type(sub_model) is not int:
        raise ValueError(
            f"sequence and sub_model must be whole numbers, got {shown(sequence)}, {shown(sub_model)}"
        )
    if isinstance(age_s, bool) or not isinstance(age_s, int | float):
        raise ValueError(f"age_s must be a number, got {shown(age_s)}")  # noqa: TRY004
    return IdentificationMessage(
        int.from_bytes(octets, "big"),
        sequence,
        sub_model=sub_model,
        age=AGE.code_of(age_s),
    )

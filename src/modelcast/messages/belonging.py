"""Which application of IEEE 1609 a message belongs to: vehicles' safety, or that of vulnerable road users.

A certificate names the applications that its key may sign for. So the number tells a person's device from a
vehicle: a device that may only speak for people cannot pass for a vehicle.
"""

from typing import Final

from modelcast.core.kinds import PEOPLE, Kind
from modelcast.messages.bsm_fields import BASIC_SAFETY_MESSAGE, MESSAGE_ID
from modelcast.messages.psids import PEOPLE_PSID, PSIDS, SAFETY_PSID
from modelcast.messages.psm_fields import PERSONAL_SAFETY_MESSAGE

__all__ = ["belongs_to", "psid_of", "psid_of_kind"]

_OF_MESSAGES: Final = {BASIC_SAFETY_MESSAGE: SAFETY_PSID, PERSONAL_SAFETY_MESSAGE: PEOPLE_PSID}


def psid_of_kind(kind: Kind) -> int:
    """The application that a road user speaks in.

    Parameters
    ----------
    kind
        Its kind.
    """
    return PEOPLE_PSID if kind in PEOPLE else SAFETY_PSID


def psid_of(message: bytes, own: int) -> int:
    """The application of a message that somebody sends; of an identification the sender's own.

    Parameters
    ----------
    message
        In its frame.
    own
        The application that the sender speaks in.

    Examples
    --------
    >>> [psid_of(bytes([0, number]), PEOPLE_PSID) for number in (20, 32, 240)]
    [32, 39, 39]
    """
    return _OF_MESSAGES.get(MESSAGE_ID.high & int.from_bytes(message[:2], "big"), own)


def belongs_to(message: bytes, psid: int) -> bool:
    """Whether a message may come in an application.

    Parameters
    ----------
    message
        In its frame.
    psid
        The application.

    Examples
    --------
    >>> [belongs_to(bytes([0, number]), SAFETY_PSID) for number in (20, 32, 240)]
    [True, False, True]
    """
    return psid in PSIDS and psid_of(message, psid) == psid

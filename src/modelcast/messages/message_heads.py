"""Where a message that a model rides in has what it states: the head of each kind of message.

A basic safety message states Part I. A personal safety message states the same of a person, without what a
person has not: gear, steering wheel, brakes, size. So receivers take both by one row of codes, that of Part
I, and a head says where its columns stand. The acceleration set of a personal safety message is optional;
with and without it are two heads.

What stands behind a head is the same in all: regional extensions, one of which may hold a model.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from modelcast.core.kinds import PEOPLE, Kind
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm
from modelcast.messages.bsm_fields import (
    BASIC_SAFETY_MESSAGE,
    CORE_FIELDS,
    CORE_INDEX,
    MAX_REGIONAL,
    MESSAGE_ID,
    PREAMBLE_BITS,
)
from modelcast.messages.field_columns import field_layout
from modelcast.messages.fields import Field
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm
from modelcast.messages.psm_fields import (
    ACCELERATION_FIELDS,
    OPTION_NAMES,
    PERSON_FIELDS,
    PERSON_INDEX,
    PERSONAL_SAFETY_MESSAGE,
)
from modelcast.messages.update_kernels import NO_COLUMN, TYPE_COLUMN, HeadTable
from modelcast.models.bank import Bank
from modelcast.models.payload import CORE_PARAMETERS

__all__ = [
    "HEADS",
    "KINDS_OF_TYPES",
    "MessageHead",
    "check_speaks",
    "decode_safety",
    "head_table",
    "heads_of_members",
    "kind_of",
    "part_one_of",
]

_LONG_LENGTH: Final = 128
_CLOSED: Final[tuple[int, int, int]] = (0, 0, 1)
"""A bit that is zero: extensions, an elevation, regional extensions of the position."""

KINDS_OF_TYPES: Final = (Kind.PEDESTRIAN, Kind.PEDESTRIAN, Kind.CYCLIST, Kind.ROAD_WORKER, Kind.PEDESTRIAN)
"""Kind of road user by the code of ``basicType``; one who does not say, and an animal, count as on foot."""


@dataclass(frozen=True, slots=True)
class MessageHead:
    """What stands in a message in front of its regional extensions.

    Parameters
    ----------
    message_id
        Of its frame.
    preamble, preamble_bits
        Bits that say which parts there are, that of regional extensions, the last, left out; how many.
    rows
        Lowest code, span of codes and bits of all that is written behind, (R, 3).
    columns
        Place in Part I of each, `update_kernels.TYPE_COLUMN` for the type of person,
        `update_kernels.NO_COLUMN` for a bit that is zero, (R,).
    """

    message_id: int
    preamble: int
    preamble_bits: int
    rows: tuple[tuple[int, int, int], ...]
    columns: tuple[int, ...]

    @property
    def bits(self) -> int:
        """Bits of the message in front of its regional extensions."""
        return self.preamble_bits + sum(width for _, _, width in self.rows)

    def frame_octets(self, extension_octets: int = 0) -> int:
        """Octets of a frame.

        Parameters
        ----------
        extension_octets
            Of one regional extension with its id and length; 0 where there is none.

        Examples
        --------
        >>> [head.frame_octets() for head in HEADS], [head.frame_octets(7) for head in HEADS]
        ([40, 29, 35], [47, 36, 42])
        """
        count_bits = (MAX_REGIONAL - 1).bit_length() if extension_octets else 0
        value = (self.bits + count_bits + 8 * extension_octets + 7) // 8
        return value + (3 if value < _LONG_LENGTH else 4)


def _person_head(*, accelerates: bool) -> MessageHead:
    """Head of a personal safety message that states no elevation."""
    rows: list[tuple[int, int, int]] = [_CLOSED]
    columns = [NO_COLUMN]
    fields: tuple[Field, ...] = PERSON_FIELDS + (ACCELERATION_FIELDS if accelerates else ())
    for field in fields:
        if field.name == "latitude_deg":  # a position's extension, elevation and regional extensions
            rows += [_CLOSED] * 3
            columns += [NO_COLUMN] * 3
        if field.name != "elevation_m":
            rows.append(field_layout(field))
            columns.append(TYPE_COLUMN if field.name == "basic_type" else CORE_INDEX[field.name])
    preamble = 1 << len(OPTION_NAMES) - 1 if accelerates else 0
    return MessageHead(PERSONAL_SAFETY_MESSAGE, preamble, 1 + len(OPTION_NAMES), tuple(rows), tuple(columns))


HEADS: Final = (
    MessageHead(
        BASIC_SAFETY_MESSAGE,
        0,
        PREAMBLE_BITS,
        tuple(field_layout(field) for field in CORE_FIELDS),
        tuple(range(len(CORE_FIELDS))),
    ),
    _person_head(accelerates=False),
    _person_head(accelerates=True),
)
"""Of a basic safety message, of a personal one, and of one with accelerations."""

_VEHICLE, _PERSON, _ACCELERATES = range(3)
_UNAVAILABLE: Final = tuple(
    0 if field.unavailable is None else int(field.unavailable) for field in CORE_FIELDS
)


def check_speaks(kind: Kind) -> None:
    """Refuse a kind of road user that has no message of its own.

    Parameters
    ----------
    kind
        Of a station that sends.

    Raises
    ------
    ValueError
        Where it is neither a vehicle nor a person.
    """
    if kind != Kind.VEHICLE and kind not in PEOPLE:
        names = ", ".join(one.name.lower() for one in (Kind.VEHICLE, *PEOPLE))
        raise ValueError(f"kind must be one that states its motion ({names}), got {kind!r}")


def heads_of_members(bank: Bank, kind: Kind, *, carries_all: bool) -> tuple[int, ...]:
    """Place in `HEADS` of an update's head by the sub-model in use.

    A personal safety message has the acceleration set where a sub-model that it carries takes acceleration or
    yaw rate from Part I; a message that carries all has it where any does.

    Parameters
    ----------
    bank
        The sub-models.
    kind
        Of the sender.
    carries_all
        Whether the coefficients of all sub-models go out.

    Raises
    ------
    ValueError
        Where the kind has no message of its own.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> bank = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    >>> heads_of_members(bank, Kind.CYCLIST, carries_all=False)
    (2, 1)
    """
    check_speaks(kind)
    members = bank.carried().members
    if kind == Kind.VEHICLE:
        return (_VEHICLE,) * len(members)
    need = [not set(CORE_PARAMETERS[2:]).isdisjoint(member.parameter_names) for member in members]
    if carries_all:
        need = [any(need)] * len(need)
    return tuple(_ACCELERATES if one else _PERSON for one in need)


def head_table() -> HeadTable:
    """The heads as kernels take them."""
    return HeadTable(
        message_id=np.array([head.message_id for head in HEADS], np.int64),
        preamble=np.array([head.preamble for head in HEADS], np.int64),
        preamble_bits=np.array([head.preamble_bits for head in HEADS], np.int64),
        first=np.cumsum([0, *(len(head.rows) for head in HEADS)], dtype=np.int64),
        layout=np.array([row for head in HEADS for row in head.rows], np.int64),
        columns=np.array([column for head in HEADS for column in head.columns], np.int64),
        unavailable=np.array(_UNAVAILABLE, np.int64),
        kinds=np.array(KINDS_OF_TYPES, np.int64),
    )


def decode_safety(data: bytes) -> BasicSafetyMessage | PersonalSafetyMessage:
    """Read a basic or personal safety message in its frame.

    Parameters
    ----------
    data
        The octets of the frame, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are neither of the two.
    """
    is_person = MESSAGE_ID.high & int.from_bytes(data[:2], "big") == PERSONAL_SAFETY_MESSAGE
    return decode_psm(data) if is_person else decode_bsm(data)


def kind_of(message: BasicSafetyMessage | PersonalSafetyMessage) -> Kind:
    """Kind of road user that sent a message.

    Parameters
    ----------
    message
        The message.
    """
    if isinstance(message, BasicSafetyMessage):
        return Kind.VEHICLE
    return KINDS_OF_TYPES[message.codes[PERSON_INDEX["basic_type"]]]


def part_one_of(message: BasicSafetyMessage | PersonalSafetyMessage) -> BsmCore:
    """What a message states, as Part I; what it does not state is unavailable, and its yaw rate 0.

    Parameters
    ----------
    message
        The message.

    Examples
    --------
    >>> from modelcast.messages.psm import person_codes
    >>> walks = PersonalSafetyMessage(person_codes({"message_count": 7, "temporary_id": 1, "speed_mps": 1.4}))
    >>> part_one_of(walks).value("speed_mps"), part_one_of(walks).value("length_m")
    (1.4, None)
    """
    if isinstance(message, BasicSafetyMessage):
        return message.core
    codes = list(_UNAVAILABLE)
    for field, code in zip(PERSON_FIELDS, message.codes, strict=True):
        if field.name in CORE_INDEX:
            codes[CORE_INDEX[field.name]] = code
    for field, code in zip(ACCELERATION_FIELDS, message.acceleration, strict=bool(message.acceleration)):
        codes[CORE_INDEX[field.name]] = code
    return BsmCore(tuple(codes))

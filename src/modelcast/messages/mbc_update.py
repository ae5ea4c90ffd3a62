"""A model update as a message: what is in it, how long it is, and what a receiver makes of its octets.

`read_update` is what a receiver does with a basic safety message: it finds the model, or says why there is
none it can use, and then the state of Part I is left, from which it coasts as its bank says
(`modelcast.models.plain_meaning`).
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from enum import IntEnum
from operator import index
from typing import Final

from modelcast.core.exceptions import CodecError
from modelcast.core.kinds import Kind
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore
from modelcast.messages.bsm_fields import (
    LOCAL_REGION,
    MAX_PART_II,
    MAX_REGIONAL,
    PART_II_ID,
    REGION_ID,
)
from modelcast.messages.frame import read_header
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_wire import (
    MAX_COEFFICIENT_OCTETS,
    PROFILE,
    SUB_MODEL,
    ModelExtension,
    decode_extension,
)
from modelcast.messages.message_heads import HEADS, MessageHead, decode_safety, kind_of, part_one_of
from modelcast.messages.psm import PersonalSafetyMessage, regional_bit

__all__ = [
    "ReceivedUpdate",
    "UpdateMessage",
    "UpdateReading",
    "extension_octets",
    "extension_of",
    "read_update",
    "update_octets",
]

_HEADER_BITS: Final = PROFILE.width_bits + SUB_MODEL.width_bits + 1 + MAX_COEFFICIENT_OCTETS.bit_length()
_LONG_LENGTH: Final = 128


@dataclass(frozen=True, slots=True)
class UpdateMessage:
    """A model update: Part I and the model, as codes on the wire.

    Parameters
    ----------
    core
        Part I.
    sub_model, carries_all
        As in `ModelExtension`.
    codes
        Codes of the coefficients carried, one tuple for each sub-model of `WireProfile.carried`.
    """

    core: BsmCore
    sub_model: int
    _: KW_ONLY
    carries_all: bool
    codes: tuple[tuple[int, ...], ...]


class UpdateReading(IntEnum):
    """What a receiver found in octets; of one message that was read, one of the first three."""

    MODEL = 0
    """A model of a profile that is held."""
    PLAIN = 1
    """Part I without a model."""
    UNKNOWN_PROFILE = 2
    """Part I, and a model of another profile."""
    INCOMPLETE = 3
    """Part I lacks position, instant, speed or heading: there is nothing to predict from."""
    FAULTY = 4
    """Neither a basic nor a personal safety message, or a model that is none of its profile."""


@dataclass(frozen=True, slots=True)
class ReceivedUpdate:
    """A basic or personal safety message as a receiver understands it.

    Parameters
    ----------
    message
        The whole message.
    reading
        Whether there is a model to predict with; if not, Part I is left.
    extension
        The model's octets, where there is one.
    profile
        Its profile, where it is known.
    update
        The model, where it is known.
    """

    message: BasicSafetyMessage | PersonalSafetyMessage
    reading: UpdateReading
    _: KW_ONLY
    extension: ModelExtension | None = None
    profile: WireProfile | None = None
    update: UpdateMessage | None = None

    @property
    def core(self) -> BsmCore:
        """What the message states, as Part I."""
        return part_one_of(self.message)

    @property
    def kind(self) -> Kind:
        """Kind of road user that sent it."""
        return kind_of(self.message)


def extension_octets(coefficient_bits: int) -> int:
    """Octets that a model takes in a basic safety message, region id and length included.

    Parameters
    ----------
    coefficient_bits
        Bits of the coefficients carried.

    Examples
    --------
    >>> extension_octets(0), extension_octets(66)
    (7, 16)
    """
    return 2 + (_HEADER_BITS + 8 * (-(-coefficient_bits // 8)) + 7) // 8


def update_octets(coefficient_bits: int, head: MessageHead = HEADS[0]) -> int:
    """Octets of a model update in its frame.

    Parameters
    ----------
    coefficient_bits
        Bits of the coefficients carried.
    head
        Of the message that it rides in; a vehicle's where not given.

    Examples
    --------
    >>> update_octets(0), update_octets(66), update_octets(66, HEADS[1])
    (47, 56, 45)
    """
    return head.frame_octets(extension_octets(coefficient_bits))


def extension_of(update: UpdateMessage, profile: WireProfile) -> ModelExtension:
    """The model of an update as it stands in its message.

    Parameters
    ----------
    update
        The update.
    profile
        Its profile.

    Raises
    ------
    ValueError
        Where it does not fit the profile.
    """
    members = profile.carried(update.sub_model, carries_all=update.carries_all)
    if not 0 <= update.sub_model < len(profile.layouts):
        raise ValueError(f"sub_model must be within 0..{len(profile.layouts) - 1}, got {update.sub_model}")
    writer = BitWriter()
    for member, codes in zip(members, update.codes, strict=True):
        for field, code in zip(profile.layouts[member].fields, codes, strict=True):
            if not (hasattr(code, "__index__") and field.low <= code <= field.high):
                raise ValueError(
                    f"{field.name}: code {code} must lie within {field.low}..{field.high}, whole"
                )
            writer.bits(index(code) - field.low, field.bits)
    return ModelExtension(
        profile.number, update.sub_model, carries_all=update.carries_all, coefficients=writer.octets()
    )


def _update_of(core: BsmCore, extension: ModelExtension, profile: WireProfile) -> UpdateMessage:
    """The model from octets; offsets of errors count from the extension's value."""
    if extension.sub_model >= len(profile.layouts):
        at = PROFILE.width_bits
        raise CodecError(f"sub-model {extension.sub_model} of {len(profile.layouts)}", at)
    members = profile.carried(extension.sub_model, carries_all=extension.carries_all)
    wanted = -(-sum(profile.layouts[member].bits for member in members) // 8)
    if len(extension.coefficients) != wanted:
        at = _HEADER_BITS - MAX_COEFFICIENT_OCTETS.bit_length()
        raise CodecError(f"{len(extension.coefficients)} octets of coefficients, not {wanted}", at)
    reader = BitReader(extension.coefficients)
    codes = tuple(
        tuple(reader.bits(field.bits) + field.low for field in profile.layouts[member].fields)
        for member in members
    )
    try:
        reader.finish()
    except CodecError as fault:
        raise CodecError(fault.reason, _HEADER_BITS + fault.offset_bits) from None
    return UpdateMessage(core, extension.sub_model, carries_all=extension.carries_all, codes=codes)


def _value_bit(data: bytes, message: BasicSafetyMessage | PersonalSafetyMessage, place: int) -> int:
    """Bit of a frame at which the value of one of its regional extensions begins."""
    at = 8 * read_header(data).start
    if isinstance(message, PersonalSafetyMessage):
        at += regional_bit(message)
    else:
        at += HEADS[0].bits
        if message.part_ii:
            at += (MAX_PART_II - 1).bit_length()
            at += sum(PART_II_ID.width_bits + _open_bits(octets) for _, octets in message.part_ii)
    at += (MAX_REGIONAL - 1).bit_length()
    at += sum(REGION_ID.width_bits + _open_bits(octets) for _, octets in message.regional[:place])
    octets = message.regional[place][1]
    return at + REGION_ID.width_bits + _open_bits(octets) - 8 * len(octets)


def _open_bits(octets: bytes) -> int:
    return 8 * len(octets) + (8 if len(octets) < _LONG_LENGTH else 16)


def read_update(data: bytes, profiles: Mapping[int, WireProfile]) -> ReceivedUpdate:
    """Read a basic or personal safety message and the model in it.

    Parameters
    ----------
    data
        The octets of its frame, no more and no fewer.
    profiles
        Profiles known here, by number.

    Raises
    ------
    CodecError
        Where they are neither of the two, or its model is none, or none of that profile. A profile that is
        not known is no error: see `UpdateReading`.
    """
    message = decode_safety(data)
    places = [place for place, (region, _) in enumerate(message.regional) if region == LOCAL_REGION]
    if not places:
        return ReceivedUpdate(message, UpdateReading.PLAIN)
    try:
        extension = decode_extension(message.regional[places[0]][1])
        profile = profiles.get(extension.profile)
        if profile is None:
            return ReceivedUpdate(message, UpdateReading.UNKNOWN_PROFILE, extension=extension)
        update = _update_of(part_one_of(message), extension, profile)
    except CodecError as fault:
        begin = _value_bit(data, message, places[0])
        raise CodecError(f"model: {fault.reason}", begin + fault.offset_bits) from None
    return ReceivedUpdate(message, UpdateReading.MODEL, extension=extension, profile=profile, update=update)

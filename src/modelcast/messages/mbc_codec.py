"""The codecs of model updates and identifications, for those who know the profile and those who don't.

`read_update` is what a receiver does with a basic safety message: it finds the model, or says why there is
none it can use, and then the state of Part I is left, from which anybody coasts at constant velocity.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from enum import Enum
from itertools import pairwise
from typing import Final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm, encode_bsm
from modelcast.messages.bsm_batch import codes_of_values, values_of_codes
from modelcast.messages.bsm_fields import (
    CORE_BITS,
    CORE_FIELDS,
    LOCAL_REGION,
    MAX_PART_II,
    MAX_REGIONAL,
    PART_II_ID,
    REGION_ID,
)
from modelcast.messages.codec import AbstractCodec
from modelcast.messages.frame import read_header
from modelcast.messages.mbc_wire import (
    AGE,
    MAX_COEFFICIENT_OCTETS,
    PROFILE,
    SUB_MODEL,
    IdentificationMessage,
    ModelExtension,
    decode_extension,
    decode_identification,
    encode_extension,
    encode_identification,
    profile_number,
)
from modelcast.models.bank import Bank
from modelcast.models.payload import PayloadLayout
from modelcast.models.profile import Profile

__all__ = [
    "IDENTIFICATION_OCTETS",
    "IdentificationCodec",
    "ReceivedUpdate",
    "UpdateCodec",
    "UpdateMessage",
    "UpdateReading",
    "WireProfile",
    "extension_octets",
    "read_update",
    "update_octets",
]

_CORE = len(CORE_FIELDS)
_HEADER_BITS: Final = PROFILE.width_bits + SUB_MODEL.width_bits + 1 + MAX_COEFFICIENT_OCTETS.bit_length()
_PREAMBLE_BITS: Final = 3
_LONG_LENGTH: Final = 128
IDENTIFICATION_OCTETS: Final = len(encode_identification(IdentificationMessage(0, 0, sub_model=0, age=0)))
"""Octets of every identification in its frame."""


@dataclass(frozen=True, slots=True)
class WireProfile:
    """What the wire needs of a profile: its number, and how each sub-model of its bank is carried.

    Parameters
    ----------
    number
        `mbc_wire.profile_number`.
    layouts
        One for each sub-model, 1 to 8.

    Raises
    ------
    ValueError
        Where the number or the count is out of its range, or the coefficients of all sub-models do not fit.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> WireProfile.of(Bank((ConstantVelocity(),)), 0x44136F).layouts
    (PayloadLayout(fields=()),)
    """

    number: int
    layouts: tuple[PayloadLayout, ...]

    def __post_init__(self) -> None:
        PROFILE.code_of(self.number)
        if not 1 <= len(self.layouts) <= SUB_MODEL.high + 1:
            raise ValueError(f"a profile has 1 to {SUB_MODEL.high + 1} sub-models, got {len(self.layouts)}")
        octets = -(-sum(layout.bits for layout in self.layouts) // 8)
        if octets > MAX_COEFFICIENT_OCTETS:
            raise ValueError(f"coefficients take {MAX_COEFFICIENT_OCTETS} octets at most, here {octets}")

    @classmethod
    def of(cls, bank: Bank, number: int) -> "WireProfile":
        """Profile of a bank.

        Parameters
        ----------
        bank
            Its sub-models.
        number
            Number of the profile they are from.

        Raises
        ------
        ValueError
            Where a sub-model cannot be carried.
        """
        layouts: list[PayloadLayout] = []
        for member in bank.members:
            layout = member.payload_layout
            if layout is None:
                raise ValueError(f"{member.name} has no payload layout: messages cannot carry it")
            layouts.append(layout)
        return cls(number, tuple(layouts))

    @classmethod
    def of_profile(cls, profile: Profile) -> "WireProfile":
        """Profile by its own bytes.

        Parameters
        ----------
        profile
            The profile.

        Raises
        ------
        ValueError
            Where a sub-model cannot be carried.
        """
        return cls.of(profile.bank, profile_number(profile.text.encode("utf-8")))

    def carried(self, sub_model: int, *, carries_all: bool) -> tuple[int, ...]:
        """Sub-models whose coefficients a message holds.

        Parameters
        ----------
        sub_model, carries_all
            As in `ModelExtension`.
        """
        return tuple(range(len(self.layouts))) if carries_all else (sub_model,)


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


class UpdateReading(Enum):
    """What a receiver found in a basic safety message beside Part I."""

    MODEL = "a model"
    PLAIN = "no model"
    UNKNOWN_PROFILE = "a model of a profile that is not known here"


@dataclass(frozen=True, slots=True)
class ReceivedUpdate:
    """A basic safety message as a receiver understands it.

    Parameters
    ----------
    message
        The whole message.
    reading
        Whether there is a model to predict with; if not, constant velocity from Part I is left.
    extension
        The model's octets, where there is one.
    profile
        Its profile, where it is known.
    update
        The model, where it is known.
    """

    message: BasicSafetyMessage
    reading: UpdateReading
    _: KW_ONLY
    extension: ModelExtension | None = None
    profile: WireProfile | None = None
    update: UpdateMessage | None = None


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


def update_octets(coefficient_bits: int) -> int:
    """Octets of a model update in its frame.

    Parameters
    ----------
    coefficient_bits
        Bits of the coefficients carried.

    Examples
    --------
    >>> update_octets(0), update_octets(66)
    (47, 56)
    """
    count_bits = (MAX_REGIONAL - 1).bit_length()
    bits = _PREAMBLE_BITS + CORE_BITS + count_bits + 8 * extension_octets(coefficient_bits)
    value = (bits + 7) // 8
    return value + (3 if value < _LONG_LENGTH else 4)


def _extension_of(update: UpdateMessage, profile: WireProfile) -> ModelExtension:
    """The model as octets; refuses what does not fit the profile."""
    members = profile.carried(update.sub_model, carries_all=update.carries_all)
    if not 0 <= update.sub_model < len(profile.layouts):
        raise ValueError(f"sub_model must be within 0..{len(profile.layouts) - 1}, got {update.sub_model}")
    writer = BitWriter()
    for member, codes in zip(members, update.codes, strict=True):
        for field, code in zip(profile.layouts[member].fields, codes, strict=True):
            if not field.low <= code <= field.high:
                raise ValueError(f"{field.name}: code {code} must lie within {field.low}..{field.high}")
            writer.bits(code - field.low, field.bits)
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


def _value_bit(data: bytes, message: BasicSafetyMessage, place: int) -> int:
    """Bit of a frame at which the value of one of its regional extensions begins."""
    at = 8 * read_header(data).start + _PREAMBLE_BITS + CORE_BITS
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
    """Read a basic safety message and the model in it.

    Parameters
    ----------
    data
        The octets of its frame, no more and no fewer.
    profiles
        Profiles known here, by number.

    Raises
    ------
    CodecError
        Where they are not a basic safety message, or its model is none, or none of that profile. A profile
        that is not known is no error: see `UpdateReading`.
    """
    message = decode_bsm(data)
    places = [place for place, (region, _) in enumerate(message.regional) if region == LOCAL_REGION]
    if not places:
        return ReceivedUpdate(message, UpdateReading.PLAIN)
    try:
        extension = decode_extension(message.regional[places[0]][1])
        profile = profiles.get(extension.profile)
        if profile is None:
            return ReceivedUpdate(message, UpdateReading.UNKNOWN_PROFILE, extension=extension)
        update = _update_of(message.core, extension, profile)
    except CodecError as fault:
        begin = _value_bit(data, message, places[0])
        raise CodecError(f"model: {fault.reason}", begin + fault.offset_bits) from None
    return ReceivedUpdate(message, UpdateReading.MODEL, extension=extension, profile=profile, update=update)


@dataclass(frozen=True, slots=True)
class UpdateCodec(AbstractCodec[UpdateMessage]):
    """Model updates of one profile, as modelcast sends them: Part I, the model, and nothing else.

    The parameters of the batch methods are the values of Part I in the order of `CORE_FIELDS`, then the
    sub-model in use, then the coefficients of all sub-models in turn; SI units, (B, 26 + C). In a copy that
    was received, coefficients that were not carried are not a number.

    Parameters
    ----------
    profile
        The profile.
    carries_all
        Whether batches carry the coefficients of all sub-models, or of the one in use alone.
    """

    profile: WireProfile
    carries_all: bool = False

    def encode(self, message: UpdateMessage) -> bytes:
        """Octets of an update."""
        octets = encode_extension(_extension_of(message, self.profile))
        return encode_bsm(message.core, regional=((LOCAL_REGION, octets),))

    def decode(self, data: bytes) -> UpdateMessage:
        """Update in octets."""
        found = read_update(data, {self.profile.number: self.profile})
        message = found.message
        after_core = 8 * read_header(data).start + _PREAMBLE_BITS + CORE_BITS
        if found.update is None:
            raise CodecError(f"{found.reading.value} where one of this profile is expected", after_core)
        if message.part_ii or len(message.regional) > 1 or message.additions or message.frame_additions:
            raise CodecError("more than Part I and a model", after_core)
        return found.update

    def message_of(self, row: Sequence[float]) -> UpdateMessage:
        """Update of one row of parameters.

        Parameters
        ----------
        row
            26 + C values.

        Raises
        ------
        ValueError
            Where a value cannot be written.
        """
        values = np.asarray(row, dtype=np.float64)[None]
        core = BsmCore(tuple(codes_of_values(values[:, :_CORE])[0].tolist()))
        sub_model = self._in_use(values)[0]
        members = self.profile.carried(int(sub_model), carries_all=self.carries_all)
        codes = tuple(
            tuple(self.profile.layouts[member].codes_of(values[:, columns])[0].tolist())
            for member, columns in enumerate(self._columns())
            if member in members
        )
        return UpdateMessage(core, int(sub_model), carries_all=self.carries_all, codes=codes)

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values that a receiver holds, (B, 26 + C)."""
        in_use = self._in_use(parameters)
        held = np.full(parameters.shape, np.nan)
        held[:, :_CORE] = values_of_codes(codes_of_values(parameters[:, :_CORE]))
        held[:, _CORE] = in_use
        for member, columns in enumerate(self._columns()):
            rows = slice(None) if self.carries_all else np.flatnonzero(in_use == member)
            held[rows, columns] = self.profile.layouts[member].quantise(parameters[rows, columns])
        return held

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,)."""
        in_use = self._in_use(parameters)
        bits = [layout.bits for layout in self.profile.layouts]
        each = [update_octets(sum(bits) if self.carries_all else own) for own in bits]
        return np.array(each, dtype=np.int64)[in_use]

    def _columns(self) -> list[slice]:
        """Columns of each sub-model's coefficients."""
        ends = _CORE + 1 + np.cumsum([0] + [len(layout.fields) for layout in self.profile.layouts])
        return [slice(first, end) for first, end in pairwise(ends.tolist())]

    def _in_use(self, parameters: FloatArray) -> IntArray:
        wanted = self._columns()[-1].stop
        if parameters.ndim != 2 or parameters.shape[1] != wanted:
            raise ValueError(f"parameters must be (B, {wanted}), got {parameters.shape}")
        given = parameters[:, _CORE]
        known = (given >= 0) & (given < len(self.profile.layouts)) & (given == np.floor(given))
        if not known.all():
            raise ValueError(
                f"the sub-model must be within 0..{len(self.profile.layouts) - 1}, got {given[~known][0]}"
            )
        return given.astype(np.int64)


@dataclass(frozen=True, slots=True)
class IdentificationCodec(AbstractCodec[IdentificationMessage]):
    """Identifications.

    The parameters of the batch methods are temporary id, sequence, sub-model and age [s], (B, 4).

    Examples
    --------
    >>> codec = IdentificationCodec()
    >>> codec.quantise(np.array([[1.0, 7.0, 2.0, 1.299]])).tolist(), codec.sizes(np.zeros((3, 4))).tolist()
    ([[1.0, 7.0, 2.0, 1.3]], [10, 10, 10])
    """

    def encode(self, message: IdentificationMessage) -> bytes:
        """Octets of an identification."""
        return encode_identification(message)

    def decode(self, data: bytes) -> IdentificationMessage:
        """Identification in octets."""
        return decode_identification(data)

    def message_of(self, row: Sequence[float]) -> IdentificationMessage:
        """Identification of one row of parameters.

        Parameters
        ----------
        row
            Temporary id, sequence, sub-model, age [s].
        """
        temporary_id, sequence, sub_model, age_s = row
        return IdentificationMessage(
            int(temporary_id), int(sequence), sub_model=int(sub_model), age=AGE.code_of(age_s)
        )

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values that a receiver holds, (B, 4)."""
        held = np.array(parameters, dtype=np.float64)
        held[:, 3] = np.clip(np.rint(held[:, 3] * AGE.step[1]), AGE.low, AGE.high) / AGE.step[1]
        return held

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,): always 10."""
        return np.full(len(parameters), IDENTIFICATION_OCTETS, np.int64)

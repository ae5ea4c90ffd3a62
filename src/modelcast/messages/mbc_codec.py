"""The codecs of model updates and identifications: octets of one message, values and sizes of a batch."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import CodecError
from modelcast.messages import field_kernels
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, encode_bsm
from modelcast.messages.bsm_batch import CORE_MEANING, codes_of_values
from modelcast.messages.bsm_fields import CORE_BITS, CORE_FIELDS, LOCAL_REGION, PREAMBLE_BITS
from modelcast.messages.code_table import coefficient_meaning
from modelcast.messages.codec import AbstractCodec
from modelcast.messages.field_columns import field_meaning
from modelcast.messages.frame import read_header
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import (
    UpdateMessage,
    UpdateReading,
    extension_of,
    read_update,
    update_octets,
)
from modelcast.messages.mbc_wire import (
    AGE,
    SEQUENCE,
    SUB_MODEL,
    TEMPORARY_ID,
    IdentificationMessage,
    decode_identification,
    encode_extension,
    encode_identification,
)

__all__ = ["IDENTIFICATION_OCTETS", "IdentificationCodec", "UpdateCodec"]

_CORE = len(CORE_FIELDS)
IDENTIFICATION_OCTETS: Final = len(encode_identification(IdentificationMessage(0, 0, sub_model=0, age=0)))
"""Octets of every identification in its frame."""
_IDENTIFICATION: Final = (TEMPORARY_ID, SEQUENCE, SUB_MODEL, AGE)
_IDENTIFICATION_MEANING: Final = np.array([field_meaning(field) for field in _IDENTIFICATION])


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
        octets = encode_extension(extension_of(message, self.profile))
        return encode_bsm(message.core, regional=((LOCAL_REGION, octets),))

    def decode(self, data: bytes) -> UpdateMessage:
        """Update in octets."""
        found = read_update(data, {self.profile.number: self.profile})
        message = found.message
        if not isinstance(message, BasicSafetyMessage):
            raise CodecError("a personal safety message where a basic one is expected", 1)
        after_core = 8 * read_header(data).start + PREAMBLE_BITS + CORE_BITS
        if found.update is None:
            what = "no model" if found.reading is UpdateReading.PLAIN else "a model of another profile"
            raise CodecError(f"{what} where one of this profile is expected", after_core)
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
        (sub_model,) = self._in_use(values).tolist()
        ends = np.cumsum([_CORE + 1] + [len(layout.fields) for layout in self.profile.layouts]).tolist()
        codes = tuple(
            tuple(self.profile.layouts[m].codes_of(values[:, ends[m] : ends[m + 1]])[0].tolist())
            for m in self.profile.carried(sub_model, carries_all=self.carries_all)
        )
        return UpdateMessage(core, sub_model, carries_all=self.carries_all, codes=codes)

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values that a receiver holds, (B, 26 + C)."""
        in_use, layouts = self._in_use(parameters), self.profile.layouts
        own = [coefficient_meaning(field) for layout in layouts for field in layout.fields]
        owner = np.full(_CORE + 1 + len(own), -1)
        if not self.carries_all:
            owner[_CORE + 1 :] = np.repeat(range(len(layouts)), [len(layout.fields) for layout in layouts])
        held = np.array(parameters, np.float64, order="C")
        meaning = np.array([*CORE_MEANING, field_meaning(SUB_MODEL), *own])
        row, at = field_kernels.quantise(held, meaning, owner, in_use)
        if row >= 0:
            if at > _CORE:
                raise ValueError(f"row {row}: every coefficient carried must be a number: none means unknown")
            codes_of_values(parameters[:, :_CORE])  # raises, and says what is wrong
        return held

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,)."""
        in_use = self._in_use(parameters)
        bits = [layout.bits for layout in self.profile.layouts]
        each = [update_octets(sum(bits) if self.carries_all else own) for own in bits]
        return np.array(each, dtype=np.int64)[in_use]

    def _in_use(self, parameters: FloatArray) -> IntArray:
        wanted = _CORE + 1 + sum(len(layout.fields) for layout in self.profile.layouts)
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

        Raises
        ------
        ValueError
            Where a value has no code.
        """
        temporary_id, sequence, sub_model, age = (
            field.code_of(value) for field, value in zip(_IDENTIFICATION, row, strict=True)
        )
        return IdentificationMessage(temporary_id, sequence, sub_model=sub_model, age=age)

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values that a receiver holds, (B, 4)."""
        self._check(parameters)
        held = np.array(parameters, np.float64, order="C")
        row, at = field_kernels.quantise(
            held, _IDENTIFICATION_MEANING, np.full(len(_IDENTIFICATION), -1), np.zeros(len(held), np.int64)
        )
        if row >= 0:
            _IDENTIFICATION[at].code_of(float(parameters[row, at]))  # raises, and says what is wrong
        return held

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,): always 10."""
        self._check(parameters)
        return np.full(len(parameters), IDENTIFICATION_OCTETS, np.int64)

    def _check(self, parameters: FloatArray) -> None:
        if parameters.ndim != 2 or parameters.shape[1] != len(_IDENTIFICATION):
            raise ValueError(f"parameters must be (B, {len(_IDENTIFICATION)}), got {parameters.shape}")

"""The codec of personal safety messages: what people send."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.codec import AbstractCodec
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm
from modelcast.messages.psm_batch import (
    PERSON_FRAME_OCTETS,
    person_codes_of_values,
    person_values_of_codes,
)

__all__ = ["PsmCodec"]


@dataclass(frozen=True, slots=True)
class PsmCodec(AbstractCodec[PersonalSafetyMessage]):
    """Personal safety messages in unaligned packed encoding rules.

    The parameters of the batch methods are the values of what every message holds, in SI units and in the
    order of `PERSON_FIELDS`; messages in batch hold that alone, the elevation included.

    Examples
    --------
    >>> values = np.full((1, 12), np.nan)
    >>> values[0, [0, 2, 3, 10]] = 2.0, 7.0, 1.0, 4.205
    >>> codec = PsmCodec()
    >>> codec.quantise(values)[0, 10].round(6).tolist(), codec.sizes(values).tolist()
    (4.2, [31])
    """

    def encode(self, message: PersonalSafetyMessage) -> bytes:
        """Octets of a message."""
        return encode_psm(message)

    def decode(self, data: bytes) -> PersonalSafetyMessage:
        """Message in octets."""
        return decode_psm(data)

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values that a receiver holds, (B, 12)."""
        return person_values_of_codes(person_codes_of_values(parameters))

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,): always 31."""
        return np.full(len(parameters), PERSON_FRAME_OCTETS, np.int64)

"""The codec of plain basic safety messages: what the baseline sends."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.bsm import BasicSafetyMessage, decode_bsm, encode_message
from modelcast.messages.bsm_batch import CORE_FRAME_OCTETS, codes_of_values, values_of_codes
from modelcast.messages.codec import AbstractCodec

__all__ = ["BsmCodec"]


@dataclass(frozen=True, slots=True)
class BsmCodec(AbstractCodec[BasicSafetyMessage]):
    """Basic safety messages in unaligned packed encoding rules.

    The parameters of the batch methods are the values of Part I, in SI units and in the order of
    `CORE_FIELDS`; messages in batch hold Part I alone.

    Examples
    --------
    >>> values = np.full((1, 25), np.nan)
    >>> values[0, [0, 1, 10, 16]] = 7.0, 1.0, 12.345, 0.001
    >>> codec = BsmCodec()
    >>> codec.quantise(values)[0, [10, 16]].round(6).tolist(), codec.sizes(values).tolist()
    ([12.34, 0.001047], [40])
    """

    def encode(self, message: BasicSafetyMessage) -> bytes:
        """Octets of a message."""
        return encode_message(message)

    def decode(self, data: bytes) -> BasicSafetyMessage:
        """Message in octets."""
        return decode_bsm(data)

    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Values of Part I that a receiver holds, (B, 25)."""
        return values_of_codes(codes_of_values(parameters))

    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each frame, (B,): always 40."""
        return np.full(len(parameters), CORE_FRAME_OCTETS, np.int64)

"""In-band emission: what a sender leaks into the sub-channels of a pool that it does not use."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["LTE_V2X", "EmissionMask", "in_band_emission"]


@dataclass(frozen=True, slots=True)
class EmissionMask:
    """The mask of a technology.

    Parameters
    ----------
    error_vector_ratio
        Error vector magnitude of the modulation: .175 for QPSK, .125 for 16-QAM, .08 for 64-QAM.
    slope_db, floor_db, image_db, carrier_db
        What senders are taken to do better than the limits, {W, X, Y, Z} of TR 36.885 [dB].
    """

    error_vector_ratio: float = 0.175
    _: KW_ONLY
    slope_db: float = 0.0
    floor_db: float = 0.0
    image_db: float = 0.0
    carrier_db: float = 0.0


LTE_V2X = EmissionMask(slope_db=3.0, floor_db=6.0, image_db=3.0, carrier_db=3.0)
"""QPSK with {3, 6, 3, 3} dB; TR 36.885."""


def in_band_emission(
    sub_channels: int, blocks: int, *, mask: EmissionMask = LTE_V2X, total_blocks: int | None = None
) -> FloatArray:
    """Power that a sender leaks into each sub-channel, over its own there, (lengths, firsts, sub-channels).

    Parameters
    ----------
    sub_channels
        Sub-channels of the pool; row k is for messages of k + 1 of them.
    blocks
        Resource blocks in each; pairs of them in LTE.
    mask
        Of the technology.
    total_blocks
        Resource blocks of the channel; the first ones are the pool. None for those of the pool.

    Notes
    -----
    The mask of 3GPP TS 36.101, table 6.5.2A.3.1-1, which TS 38.101-1, 6.4E.2.3, has too: the larger of
    -25 - 10 log(N/L) - X and 20 log EVM - 3 - 5(d - 1)/L - W for a block d blocks away, and -25 - Y more on
    the image of the used blocks. Carrier leakage (-25 - Z) falls on the middle one or two blocks. Averaged
    over the blocks of a sub-channel.
    """
    used = sub_channels * blocks
    total = used if total_blocks is None else total_blocks
    block = np.arange(used)
    image_ratio = 10.0 ** ((-25.0 - mask.image_db) / 10.0)
    carrier_ratio = 10.0 ** ((-25.0 - mask.carrier_db) / 10.0)
    table = np.zeros((sub_channels, sub_channels, sub_channels))
    for length in range(1, sub_channels + 1):
        for first in range(sub_channels - length + 1):
            start, stop, width = first * blocks, (first + length) * blocks - 1, length * blocks
            away = np.maximum(start - block, block - stop)
            general = -25.0 - 10.0 * np.log10(total / width) - mask.floor_db
            slope = 20.0 * np.log10(mask.error_vector_ratio) - 3.0 - 5.0 * (away - 1) / width - mask.slope_db
            leak = 10.0 ** (0.1 * np.maximum(general, slope))
            image = total - 1 - block
            leak = leak + np.where((image >= start) & (image <= stop), image_ratio, 0.0)
            middle = (block == (total - 1) // 2) | (block == total // 2)
            leak = np.where(away <= 0, 1.0, leak + np.where(middle, carrier_ratio, 0.0))
            table[length - 1, first] = leak.reshape(sub_channels, blocks).mean(axis=1)
    return table

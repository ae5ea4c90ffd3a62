"""How many bits fit into the resource blocks of an NR sidelink slot, by modulation and coding.

Of the 14 symbols of a slot the first (gain control) and the last (guard) carry nothing. From the rest go the
reference signals and the two stages of control information.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

__all__ = ["MCS_TABLE", "SlotShape", "transport_block_bits"]

MCS_TABLE: tuple[tuple[int, float], ...] = tuple(
    (bits, rate / 1024.0)
    for bits, rates in (
        (2, (120, 157, 193, 251, 308, 379, 449, 526, 602, 679)),
        (4, (340, 378, 434, 490, 553, 616, 658)),
        (6, (438, 466, 517, 567, 616, 666, 719, 772, 822, 873, 910, 948)),
    )
    for rate in rates
)
"""Bits a symbol and code rate by MCS, 0 to 28; TS 38.214, table 5.1.3.1-1 (64-QAM)."""

_SYMBOLS = 12
_SUBCARRIERS = 12
_SECOND_STAGE_BITS = 72
"""Format 2-B with its checksum; TS 38.212, 8.4.1."""

_SECOND_STAGE_OFFSET = 1.125
_SECOND_STAGE_MOST = 0.5
"""beta and alpha of TS 38.212, 8.4.4; as WiLabV2Xsim has them."""

_TABLE: tuple[int, ...] = (
    *range(24, 192, 8),
    *range(192, 384, 16),
    *(384, 408, 432, 456, 480, 504, 528, 552, 576, 608, 640, 672, 704, 736, 768, 808, 848, 888, 928, 984),
    *(1032, 1064, 1128, 1160, 1192, 1224, 1256, 1288, 1320, 1352, 1416, 1480, 1544, 1608, 1672, 1736, 1800),
    *(1864, 1928, 2024, 2088, 2152, 2216, 2280, 2408, 2472, 2536, 2600, 2664, 2728, 2792, 2856, 2976, 3104),
    *(3240, 3368, 3496, 3624, 3752, 3824),
)
"""Transport block sizes up to 3824 bits; TS 38.214, table 5.1.3.2-1."""


@dataclass(frozen=True, slots=True)
class SlotShape:
    """What of a slot is not data.

    Parameters
    ----------
    control_symbols, control_blocks
        Of the first stage of control information, once a message: 2 or 3 symbols of so many resource blocks.
    reference_elements
        Of demodulation reference signals in every resource block: 12 to 24.
    """

    control_symbols: int = 3
    control_blocks: int = 10
    _: KW_ONLY
    reference_elements: int = 24

    def elements(self, blocks: int, mcs: int) -> int:
        """Resource elements for data in so many resource blocks of a slot; none where control takes all."""
        bits, rate = MCS_TABLE[mcs]
        whole = _SUBCARRIERS * _SYMBOLS * blocks
        data = whole - self.reference_elements * blocks
        coded = np.ceil(_SECOND_STAGE_BITS * _SECOND_STAGE_OFFSET / (bits * rate))
        second = min(int(coded), int(np.ceil(_SECOND_STAGE_MOST * (data - self.reference_elements * blocks))))
        first = self.control_symbols * self.control_blocks * _SUBCARRIERS
        return max(data - first - second, 0)

    def block_bits(self, blocks: int, mcs: int) -> int:
        """Bits of the transport block in so many resource blocks."""
        bits, rate = MCS_TABLE[mcs]
        return transport_block_bits(self.elements(blocks, mcs) * bits * rate, rate)


def transport_block_bits(information_bits: float, code_rate: float) -> int:
    """Size of the transport block for what the resources hold; TS 38.214, 5.1.3.2 [bit].

    Parameters
    ----------
    information_bits
        Resource elements times bits a symbol times code rate, one layer.
    code_rate
        0..1.

    Examples
    --------
    >>> transport_block_bits(2384.4, 526 / 1024), transport_block_bits(5000.0, 0.5)
    (2408, 4992)
    """
    if information_bits < _TABLE[0]:
        return 0
    if information_bits <= _TABLE[-1]:
        step = 2.0 ** max(3, int(np.floor(np.log2(information_bits))) - 6)
        rounded = max(24.0, step * np.floor(information_bits / step))
        return next(size for size in _TABLE if size >= rounded)
    step = 2.0 ** (int(np.floor(np.log2(information_bits - 24.0))) - 5)
    rounded = max(3840.0, step * np.floor((information_bits - 24.0) / step + 0.5))
    most = 3816.0 if code_rate <= 0.25 else 8424.0
    parts = 1 if code_rate > 0.25 and rounded <= most else int(np.ceil((rounded + 24.0) / most))
    return 8 * parts * int(np.ceil((rounded + 24.0) / (8.0 * parts))) - 24

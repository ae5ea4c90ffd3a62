"""Constants of NR-V2X sidelink mode 2, by document: numerology, pool, selection, thresholds."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.in_band_emission import EmissionMask
from modelcast.channel.nr_transport_block import MCS_TABLE, SlotShape
from modelcast.channel.parameter_bounds import check_bounds
from modelcast.core.arrays import FloatArray, IntArray

__all__ = [
    "INTERVALS_MS",
    "MOST_COPIES",
    "RESERVED_SPAN",
    "NrParameters",
    "wilab_nr_parameters",
]

_BLOCKS = {15: {10: 52, 20: 106, 30: 160, 40: 216}, 30: {10: 24, 20: 51, 30: 78, 40: 106}}
"""Resource blocks of a channel by subcarrier spacing [kHz] and width [MHz]; TS 38.101-1, table 5.3.2-1."""

_POOL_BLOCKS = (10, 12, 15, 20, 25, 50, 75, 100)
"""Resource blocks a sub-channel may have; TS 38.331, sl-SubchannelSize."""

_ERROR_VECTORS = {2: 0.175, 4: 0.125, 6: 0.08}
"""Error vector magnitude by bits a symbol; TS 38.101-1, table 6.4.2.1-1."""

_EFFICIENCY = 0.4
"""Share of the capacity of a channel that a sidelink reaches; TR 36.942, A.2."""

_MOST = 100_000
"""Of turns without a message, and of milliseconds of a window."""

RESERVED_SPAN = 32
"""Slots within which one message's control information can point at its copies; TS 38.214, 8.1.5."""

INTERVALS_MS = (*range(1, 100), *range(100, 1001, 100))
"""Resource reservation intervals there are; TS 38.331, SL-ResourceReservePeriod [ms]."""

MOST_COPIES = 3
"""Resources that it can point at, its own included; the same clause."""


@dataclass(frozen=True, slots=True)
class NrParameters:
    """Constants of the radio, by document.

    Parameters
    ----------
    mcs
        0 to 28, of TS 38.214, table 5.1.3.1-1. Where an error model is given it must be for it.
    spacing_khz
        Subcarrier spacing: 15 or 30; slots of 1 or 0.5 ms [kHz].
    bandwidth_mhz
        Of the channel: 10, 20, 30 or 40 [MHz].
    blocks
        Resource blocks of a sub-channel; as many sub-channels as fit.
    control_symbols, control_blocks, reference_elements
        As in `SlotShape`; no more control blocks than a sub-channel has.
    overlapping
        Whether a resource may begin at every sub-channel (TS 38.214); else only at multiples of its length.
    interval_ms
        Resource reservation interval: 1 to 99, or 100, 200, ... 1000 [ms].
    longest_ms
        Longest interval that a sender may have by saying when its next message comes; it costs memory [ms].
    first_ms, last_ms
        T1 and T2: a message goes out so long after it is ready; whole slots, at least one [ms].
    keep_ratio
        Chance to keep the resource when the counter runs out; 0, .2, .4, .6 or .8.
    dynamic
        Choose a resource for every message and reserve none for the next one, where a sender does not say.
    transmissions
        Times that every message is sent, 1 to 3: blind retransmission.
    reselect_after
        A resource is given up after so many turns in a row without a message; 0 for never.
    free_ratio
        Share of the resources that must be left by exclusion: 0.2 (sl-TxPercentageList: .2, .35, .5). Of
        those that the vehicle could know of, as with ``best_of_possible`` of `SidelinkParameters`; TS 38.214,
        8.1.4, step 7, takes it of all.
    reserved_dbm
        A reservation excludes where it was received stronger, over 15 kHz; raised by 3 dB until enough are
        left [dBm].
    reserved_by_total
        Whether a reservation counts by all power on the resource that announced it, not by its own alone, as
        WiLabV2Xsim has it.
    control_db
        Least SINR at which control information is understood [dB].
    noise_figure_db
        9 dB in TR 37.885 [dB].
    sensitivity_dbm
        Weakest frame that is received [dBm]. The error model decides before that.
    load_dbm
        The channel busy ratio counts sub-channels with more, noise included [dBm].
    busy_window_ms
        100 ms (sl-TimeWindowSizeCBR).
    antenna_gain_db
        Of either end [dB].
    max_power_dbm, margin_db, bin_m, bins
        As in `DsrcParameters`.

    Notes
    -----
    The selection is that of TS 38.214, 8.1.4, for one interval: what was reserved excludes, and chance
    decides among the rest. There is no ranking by power. A reservation with an interval below T2 excludes all
    its uses up to T2, and these stay excluded where the sender leaves the resource before. A slot in which
    the vehicle sent is excluded one ``interval_ms`` later only, since it heard nothing then.

    References
    ----------
    3GPP TS 38.214, 8.1; TS 38.321, 5.22.1; TS 38.215, 5.1.27 (busy ratio); TR 37.885. Thresholds of -110 and
    -94 dBm, 0 dB and the default MCS are those common in simulators (WiLabV2Xsim).
    """

    mcs: int = 11
    spacing_khz: int = 15
    _: KW_ONLY
    bandwidth_mhz: int = 10
    blocks: int = 10
    control_symbols: int = 3
    control_blocks: int = 10
    reference_elements: int = 24
    overlapping: bool = True
    interval_ms: int = 100
    longest_ms: int = 100
    first_ms: float = 1.0
    last_ms: float = 100.0
    keep_ratio: float = 0.8
    dynamic: bool = False
    transmissions: int = 1
    reselect_after: int = 0
    free_ratio: float = 0.2
    reserved_dbm: float = -110.0
    reserved_by_total: bool = False
    control_db: float = 0.0
    noise_figure_db: float = 9.0
    sensitivity_dbm: float = -105.0
    load_dbm: float = -94.0
    busy_window_ms: int = 100
    antenna_gain_db: float = 0.0
    max_power_dbm: float = 23.0
    margin_db: float = 10.0
    bin_m: float = 50.0
    bins: int = 10

    def __post_init__(self) -> None:
        if not 0 <= self.mcs < len(MCS_TABLE):
            raise ValueError(f"mcs must lie within 0..{len(MCS_TABLE) - 1}, got {self.mcs}")
        if self.spacing_khz not in _BLOCKS:
            raise ValueError(f"spacing_khz must be one of {sorted(_BLOCKS)}, got {self.spacing_khz}")
        widths = _BLOCKS[self.spacing_khz]
        if self.bandwidth_mhz not in widths:
            raise ValueError(f"bandwidth_mhz must be one of {sorted(widths)}, got {self.bandwidth_mhz}")
        if self.blocks not in _POOL_BLOCKS or self.blocks > self.channel_blocks:
            raise ValueError(
                f"blocks must be one of {_POOL_BLOCKS}, {self.channel_blocks} at most, got {self.blocks}"
            )
        self._check_slot()
        self._check_selection()
        check_bounds(self)
        if not 1 <= self.busy_window_ms <= _MOST:
            raise ValueError(f"busy_window_ms must lie within 1..{_MOST}, got {self.busy_window_ms}")

    def _check_slot(self) -> None:
        if self.control_symbols not in (2, 3):
            raise ValueError(f"control_symbols must be 2 or 3, got {self.control_symbols}")
        if not 1 <= self.control_blocks <= self.blocks:
            raise ValueError(f"control_blocks must lie within 1..{self.blocks}, got {self.control_blocks}")
        if not 12 <= self.reference_elements <= 24:
            raise ValueError(f"reference_elements must lie within 12..24, got {self.reference_elements}")

    def _check_selection(self) -> None:
        for name in ("interval_ms", "longest_ms"):
            if getattr(self, name) not in INTERVALS_MS:
                raise ValueError(f"{name} must be 1..99 or 100, 200, ... 1000, got {getattr(self, name)}")
        if not self.interval_ms <= self.longest_ms:
            raise ValueError(f"longest_ms must be at least interval_ms, got {self.longest_ms}")
        self._check_window()
        for name in ("keep_ratio", "free_ratio"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie within 0..1, got {getattr(self, name)}")
        if not 1 <= self.transmissions <= MOST_COPIES:
            raise ValueError(f"transmissions must lie within 1..{MOST_COPIES}, got {self.transmissions}")
        if not 0 <= self.reselect_after <= _MOST:
            raise ValueError(f"reselect_after must lie within 0..{_MOST}, got {self.reselect_after}")

    def _check_window(self) -> None:
        shortest_ms = 1.0 / self.slots_a_ms
        if not shortest_ms <= self.first_ms <= self.last_ms <= 1000.0:
            raise ValueError(
                f"first_ms and last_ms must rise within {shortest_ms}..1000, "
                f"got {self.first_ms} and {self.last_ms}"
            )
        for name in ("first_ms", "last_ms"):
            if getattr(self, name) % shortest_ms != 0:
                raise ValueError(
                    f"{name} must be a whole number of slots of {shortest_ms} ms, got {getattr(self, name)}"
                )

    @property
    def slots_a_ms(self) -> int:
        """Slots in a millisecond: 1 or 2."""
        return self.spacing_khz // 15

    @property
    def channel_blocks(self) -> int:
        """Resource blocks of the channel."""
        return _BLOCKS[self.spacing_khz][self.bandwidth_mhz]

    @property
    def sub_channels(self) -> int:
        """Sub-channels of the pool."""
        return self.channel_blocks // self.blocks

    @property
    def sub_channel_hz(self) -> float:
        """Width of a sub-channel [Hz]."""
        return self.blocks * 12e3 * self.spacing_khz

    @property
    def shape(self) -> SlotShape:
        """What of a slot is not data."""
        return SlotShape(
            self.control_symbols, self.control_blocks, reference_elements=self.reference_elements
        )

    @property
    def emission(self) -> EmissionMask:
        """What a sender leaks, at the limits of TS 38.101-1."""
        return EmissionMask(_ERROR_VECTORS[MCS_TABLE[self.mcs][0]])

    @property
    def largest_bytes(self) -> int:
        """Size of the largest message that fits into all sub-channels."""
        return self.shape.block_bits(self.sub_channels * self.blocks, self.mcs) // 8

    def blocks_of(self, size_bytes: IntArray) -> IntArray:
        """Resource blocks that messages need, (N,); one more than there are where none would do.

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).
        """
        most = self.sub_channels * self.blocks
        held = np.array([self.shape.block_bits(blocks, self.mcs) for blocks in range(most + 1)])
        held = np.maximum.accumulate(held)  # the rounding of sizes must not make more blocks hold less
        found: IntArray = np.searchsorted(held, 8 * np.asarray(size_bytes)).astype(np.int64)
        return found

    def length(self, size_bytes: IntArray) -> IntArray:
        """Sub-channels that messages take, (N,).

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).

        Examples
        --------
        >>> import numpy as np
        >>> NrParameters(7).length(np.array([100, 190, 300])).tolist()
        [1, 2, 3]
        """
        return -(-self.blocks_of(size_bytes) // self.blocks)

    def threshold_db(self, size_bytes: IntArray) -> FloatArray:
        """Least SINR at which messages are received where nothing else is said, (N,) [dB].

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).

        Notes
        -----
        10 log(2^(b/0.4) - 1) with b bits a second and hertz over the blocks that the message needs: 0.4 of
        the capacity (TR 36.942). It is what WiLabV2Xsim takes where it has no curve. That lies 7 to 8
        dB above the bound of white noise at MCS 7 and 11, which leaves room for fading: none is drawn beside
        it.

        Examples
        --------
        >>> import numpy as np
        >>> [round(float(NrParameters(mcs).threshold_db(np.array([300]))[0]), 2) for mcs in (7, 11)]
        [6.39, 9.99]
        """
        needed = np.minimum(self.blocks_of(size_bytes), self.sub_channels * self.blocks)
        bits = np.array([self.shape.block_bits(int(blocks), self.mcs) for blocks in needed], dtype=float)
        elements = np.array([self.shape.elements(int(blocks), self.mcs) for blocks in needed], dtype=float)
        rate = 14.0 / 15.0 * bits / elements  # 168 elements in 180 kHz and 1 ms
        return np.asarray(10.0 * np.log10(2.0 ** (rate / _EFFICIENCY) - 1.0), dtype=np.float64)


def wilab_nr_parameters() -> NrParameters:
    """Return NR-V2X as WiLabV2Xsim 6.2 has it by default on its highway, at MCS 11 with keep ratio 0.4.

    10 MHz of 15 kHz, resources at multiples of their length only, reservations by all power on the resource,
    3 dB antennas, noise figure 6 dB, no sensitivity beside the error model. It leaves no weak signal out; 20
    dB below the noise is near enough.
    """
    return NrParameters(
        11,
        overlapping=False,
        keep_ratio=0.4,
        reserved_by_total=True,
        noise_figure_db=6.0,
        antenna_gain_db=3.0,
        sensitivity_dbm=-120.0,
        margin_db=20.0,
    )

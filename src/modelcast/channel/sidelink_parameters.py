"""Constants of LTE-V2X mode 4, by document: sizes, windows, thresholds."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.parameter_bounds import check_bounds
from modelcast.core.arrays import IntArray

__all__ = [
    "BITS_PER_BLOCK",
    "BLOCK_HZ",
    "COUNTER",
    "COUNTERS",
    "MEMORY",
    "STEP",
    "SidelinkParameters",
    "j3161_sidelink_parameters",
    "wilab_sidelink_parameters",
]

BITS_PER_BLOCK: dict[int, float] = {
    0: 26.8,
    1: 35.6,
    2: 43.6,
    3: 58.0,
    4: 70.8,
    5: 86.8,
    6: 104.4,
    7: 123.6,
    8: 139.6,
    9: 155.6,
    10: 174.8,
}
"""Bits a resource-block pair by MCS: transport block of 20 pairs over 20; TS 36.213, table 7.1.7.2.1-1.

From memory. Other sizes differ by a few per cent."""

BLOCK_HZ = 180e3
"""Width of a resource-block pair; TS 36.211."""

COUNTERS = {20: (25, 75), 50: (10, 30)}
COUNTER = (5, 15)
"""Bounds of the reselection counter by reservation interval [ms], and from 100 ms on; TS 36.321, 5.14.1.1."""

MEMORY = 1000
STEP = 100
"""Subframes of the sensing window, and how far apart those are that are averaged; TS 36.213, 14.1.1.6."""

_MOST_SUB_CHANNELS, _MOST_BLOCKS = 20, 100
"""Largest numSubchannel of TS 36.331, from memory, and the resource-block pairs of 20 MHz."""

_WHOLE = {
    "sub_channels": (1, _MOST_SUB_CHANNELS),
    "blocks": (1, _MOST_BLOCKS),
    "control_blocks": (0, _MOST_BLOCKS),
    "reselect_after": (1, 9),
    "one_shot_most": (1, 1000),
    "busy_window_ms": (1, MEMORY),
}
"""Bounds of whole numbers."""


@dataclass(frozen=True, slots=True)
class SidelinkParameters:
    """Constants of the radio, by document.

    Parameters
    ----------
    mcs
        A key of `BITS_PER_BLOCK`. The error model must be for it.
    sub_channels, blocks
        Sub-channels of the pool, 20 at most, and resource-block pairs in each; 10 MHz has 50 pairs, 20 MHz
        100, and no pool has more.
    control_blocks
        Pairs for the control part, adjacent to the data: 2.
    least_sub_channels
        A message takes at least so many sub-channels, whether it fills them or not.
    overlapping
        Whether a resource may begin at every sub-channel (TS 36.213); else only at multiples of its length.
    interval_ms
        Resource reservation interval: 20, 50, or a multiple of 100 up to 1000 [ms].
    first_ms, last_ms
        T1 <= 4 and T2 in 20..100: a message goes out so many subframes after it is ready [ms].
    keep_ratio
        Chance to keep the resource when the counter runs out; 0, .2, .4, .6 or .8.
    one_shot
        Choose a resource for every message and reserve nothing; a message that asks for a `Grant` gets it.
    transmissions
        1, or 2 for a blind retransmission of every message, at most 15 subframes from the first copy. Copies
        are not combined: a receiver holds the message where it receives any of them.
    interleaved
        Send a message now and then by a one-shot though its reserved turn fits, so that those who share a
        resource do not collide for ever; the turn passes unused, and the reservation stays (SAE J3161/1).
    one_shot_least, one_shot_most
        Bounds of the counter of messages up to such a one-shot, drawn anew after each: 2 and 6 (A. Fouda, R.
        Berry, I. Vukovic, arXiv:2110.00056; from memory).
    interval_by_next
        Announce with each message the interval with which the resource comes back for the next one: the
        shortest, from `interval_ms` on, that is not over before that message is ready, by `Transmissions`'
        ``next_s``; it is given up where another announced the place it would come back to. A message without
        ``next_s`` has `interval_ms`.
    grant_by_next
        Reserve only where the next message is expected within the longest interval announced; else a
        message is a one-shot, and the resource it was sent in is not kept. For messages that ask for no
        `Grant`.
    longest_interval_ms
        Longest interval where it is chosen by the next message, a multiple of 100 up to 1000 [ms].
    reselect_after
        A resource is given up after so many turns in a row without a message (sl-ReselectAfter, 1..9).
    best_ratio
        Share of the resources among which chance decides: 0.2.
    best_of_possible
        Whether the share is of the resources the vehicle could sense; TS 36.213 counts those too in whose
        subframes it was sending, 14.1.1.6.
    first_by_chance
        Whether a vehicle's first resource is chosen without sensing.
    noise_counts
        Whether noise is part of the power sensed, as in TS 36.214, 5.1.28. Else what is below the noise reads
        zero, and such resources are equally good.
    reserved_dbm
        A reservation counts where its reference signal is stronger, an element; raised by 3 dB until enough
        resources are left [dBm].
    reserved_by_mean
        Whether that compares the mean power sensed there in the last second, over ten times a hundred
        subframes, in place of the reservation's reference signal. A resource reserved of late then counts by
        a tenth.
    control_db
        Least SINR at which a reservation is understood; common in simulators, from memory [dB].
    noise_figure_db
        9 dB in TR 36.885 [dB].
    sensitivity_dbm
        Weakest frame that is received [dBm]. The error model decides before that, save with good luck.
    load_dbm
        The channel busy ratio counts sub-channels with more; TS 36.214, 5.1.30, with the -94 dBm of ETSI TS
        103 574 [dBm].
    busy_window_ms
        100 subframes; at most the 1000 that a vehicle remembers.
    antenna_gain_db
        Of either end [dB].
    max_power_dbm, margin_db, bin_m, bins
        As in `DsrcParameters`, the margin below the noise of the pairs that a message fills; powers and
        ratios lie within -300..300 dB, the margin within 0..300 dB, a bin is at least 0.1 m wide, and there
        are at most 100 000.

    References
    ----------
    3GPP TS 36.213, clause 14; TS 36.321, 5.14.1.1; TS 36.214, 5.1.28 to 5.1.30; R. Molina-Masegosa and J.
    Gozalvez, "LTE-V for sidelink 5G V2X vehicular communications", 2017, DOI 10.1109/MVT.2017.2752798.
    """

    mcs: int = 5
    sub_channels: int = 5
    _: KW_ONLY
    blocks: int = 10
    control_blocks: int = 2
    least_sub_channels: int = 1
    overlapping: bool = True
    interval_ms: int = 100
    first_ms: int = 1
    last_ms: int = 100
    keep_ratio: float = 0.8
    one_shot: bool = False
    transmissions: int = 1
    interleaved: bool = False
    one_shot_least: int = 2
    one_shot_most: int = 6
    interval_by_next: bool = False
    grant_by_next: bool = False
    longest_interval_ms: int = 1000
    reselect_after: int = 1
    best_ratio: float = 0.2
    best_of_possible: bool = False
    first_by_chance: bool = False
    noise_counts: bool = True
    reserved_dbm: float = -110.0
    reserved_by_mean: bool = False
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
        if self.mcs not in BITS_PER_BLOCK:
            raise ValueError(f"mcs must be one of {sorted(BITS_PER_BLOCK)}, got {self.mcs}")
        self._check_sizes()
        check_bounds(self)
        if self.interval_ms not in (20, 50, *range(100, 1001, 100)):
            raise ValueError(f"interval_ms must be 20, 50 or 100, 200, ... 1000, got {self.interval_ms}")
        if not 1 <= self.first_ms <= 4 or not 20 <= self.last_ms <= 100:
            raise ValueError(
                f"first_ms must lie within 1..4, last_ms within 20..100, got {self.first_ms}, {self.last_ms}"
            )
        for name in ("keep_ratio", "best_ratio"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie within 0..1, got {getattr(self, name)}")
        self._check_grants()

    def _check_sizes(self) -> None:
        for name, (least, most) in _WHOLE.items():
            if not least <= getattr(self, name) <= most:
                raise ValueError(f"{name} must lie within {least}..{most}, got {getattr(self, name)}")
        if self.sub_channels * self.blocks > _MOST_BLOCKS:
            raise ValueError(
                f"sub_channels times blocks must be {_MOST_BLOCKS} at most, "
                f"got {self.sub_channels} times {self.blocks}"
            )
        if not 1 <= self.least_sub_channels <= self.sub_channels:
            raise ValueError(
                f"least_sub_channels must lie within 1..{self.sub_channels}, got {self.least_sub_channels}"
            )

    def _check_grants(self) -> None:
        if self.transmissions not in (1, 2):
            raise ValueError(f"transmissions must be 1 or 2, got {self.transmissions}")
        if not 1 <= self.one_shot_least <= self.one_shot_most:
            raise ValueError(
                f"one_shot_least must lie within 1..one_shot_most, got {self.one_shot_least} and "
                f"{self.one_shot_most}"
            )
        longest_ms = self.longest_interval_ms
        if longest_ms not in range(100, 1001, 100) or longest_ms < self.interval_ms:
            raise ValueError(
                f"longest_interval_ms must be 100, 200, ... 1000 and at least interval_ms, got {longest_ms}"
            )
        if self.interleaved and self.one_shot:
            raise ValueError("interleaved one-shots need reservations: one_shot must be False")

    @property
    def horizon_ms(self) -> int:
        """Longest interval that is announced [ms]."""
        return self.longest_interval_ms if self.interval_by_next else self.interval_ms

    @property
    def sub_channel_hz(self) -> float:
        """Width of a sub-channel [Hz]."""
        return self.blocks * BLOCK_HZ

    def length(self, size_bytes: IntArray) -> IntArray:
        """Sub-channels that messages take, (N,).

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).

        Examples
        --------
        >>> import numpy as np
        >>> SidelinkParameters(mcs=7).length(np.array([100, 190, 300])).tolist()
        [1, 2, 3]
        """
        return np.maximum(-(-self.blocks_of(size_bytes) // self.blocks), self.least_sub_channels)

    def blocks_of(self, size_bytes: IntArray) -> IntArray:
        """Resource-block pairs that messages fill, control included, (N,).

        Parameters
        ----------
        size_bytes
            Sizes of the messages, (N,).
        """
        data = np.ceil(8.0 * np.asarray(size_bytes) / BITS_PER_BLOCK[self.mcs]).astype(np.int64)
        return data + self.control_blocks

    @property
    def largest_bytes(self) -> int:
        """Size of the largest message that fits into all sub-channels; 0 where not even its control does."""
        most = np.arange(int(self.sub_channels * self.blocks * BITS_PER_BLOCK[self.mcs]) // 8 + 2)
        return max(int(np.count_nonzero(self.length(most) <= self.sub_channels)) - 1, 0)


def wilab_sidelink_parameters() -> SidelinkParameters:
    """Mode 4 as WiLabV2Xsim 6.1 has it, at MCS 7, 300 bytes and 10 MHz.

    Notes
    -----
    Facts of that simulator's public code and of its output: a message has its whole power on its data, 20 of
    50 pairs, and takes three of five sub-channels, so one fits a subframe; sensed power below the noise is
    set to zero; a reservation is compared by the mean power of a second; the first resource is chosen by
    chance; the best fifth is of the resources sensed. The range up to which it counts pairs, 1.41 times the
    distance at which the median SNR meets the threshold, tells the pairs that bear the power. Its packet
    error is a step at 8.47 dB (`ThresholdErrorModel`). It leaves no weak signal out, which would take every
    pair on the road: here they end 13 dB below the noise. With 10 or 20 dB the largest difference from its
    figures over ten seeds is 0.008 in place of 0.006.
    """
    return SidelinkParameters(
        7,
        5,
        control_blocks=0,
        least_sub_channels=3,
        overlapping=False,
        keep_ratio=0.4,
        best_of_possible=True,
        first_by_chance=True,
        noise_counts=False,
        reserved_by_mean=True,
        noise_figure_db=6.0,
        antenna_gain_db=3.0,
        sensitivity_dbm=-120.0,
        margin_db=13.0,
    )


def j3161_sidelink_parameters() -> SidelinkParameters:
    """Return LTE-V2X as deployed in the United States: SAE J3161/1 over 20 MHz (channel 183).

    100 resource blocks in ten sub-channels, every message sent twice, one-shots interleaved with
    reservations, an interval that follows the timers of congestion control, 20 dBm at most.

    Notes
    -----
    The standard is not public. That it interleaves one-shots and retransmits blindly is published; the ten
    sub-channels, the bounds of the counter and MCS 5 are ours, from memory of what its studies simulate. A
    reservation survives eight turns without a message: congestion control may send every sixth only.

    References
    ----------
    SAE J3161/1, "On-Board System Requirements for LTE-V2X V2V Safety Communications". A. Fouda, R. Berry, I.
    Vukovic, "Interleaved One-shot Semi-Persistent Scheduling for BSM Transmissions in C-V2X Networks",
    arXiv:2110.00056, and "Study of BSM Inter-Packet Gap Tails in C-V2X Networks", arXiv:2311.16904.

    Examples
    --------
    >>> deployed = j3161_sidelink_parameters()
    >>> deployed.sub_channels * deployed.blocks, deployed.transmissions, deployed.interleaved
    (100, 2, True)
    """
    return SidelinkParameters(
        5,
        10,
        transmissions=2,
        interleaved=True,
        interval_by_next=True,
        longest_interval_ms=600,
        reselect_after=9,
        max_power_dbm=20.0,
    )

"""Decentralised congestion control of ETSI TS 102 687: how long a station must wait between its messages.

`AdaptiveDcc` is the linear controller (LIMERIC) that moves every station's share of the channel until the
channel busy ratio meets a target. `ReactiveDcc` is a table from channel busy ratio to message rate.
"""

from dataclasses import KW_ONLY, astuple, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.policy import dcc_kernels as kernels

__all__ = ["AdaptiveDcc", "ReactiveDcc"]


@dataclass(frozen=True, slots=True)
class AdaptiveDcc:
    """The adaptive approach of ETSI TS 102 687 V1.2.1, clause 5.4, with the values of its table 3.

    Parameters
    ----------
    relaxation
        alpha: share given up at every update [read in public code].
    gain
        beta: how strongly the share answers the gap to the target [read in public code].
    target_busy_ratio
        CBR_target [read in public code].
    min_share, max_share
        delta_min and delta_max: share of time a station may be on the air [read in public code].
    max_rise, max_fall
        G+_max and G-_max: bounds of one answer [read in public code].
    busy_weight
        Weight of the new measures against the smoothed ratio, step 1 [read in public code].
    measures_an_update
        Measures between two updates: 200 ms at a measure every 100 ms [read in public code].
    shortest_s, longest_s
        Bounds of the time between two messages, equation B.1 [read in public code] [s].
    measuring_interval_s
        T_CBR [read in public code] [s].
    start_share
        delta before the first update; the clause leaves it open, and this is ours: None for `max_share`.

    Raises
    ------
    ValueError
        Where a value is out of its range.

    Notes
    -----
    At every update CBR := (1-w)·CBR + w·(mean of the last two measures), then
    delta := (1 - alpha)·delta + clamp(beta·(CBR_target - CBR), G-_max, G+_max), within its bounds. With N
    stations that all hear each other, CBR = N·delta and the fixed point is
    delta = beta·CBR_target / (alpha + N·beta), where no bound is met.

    References
    ----------
    ETSI TS 102 687 V1.2.1, clause 5.4 and annex B. J. B. Kenney, G. Bansal, C. E. Rohrs, "LIMERIC: a
    linear message rate control algorithm for vehicular DSRC systems", doi:10.1145/2030698.2030702.

    Examples
    --------
    >>> round(AdaptiveDcc().fixed_share(100), 5)
    0.006
    """

    relaxation: float = 0.016
    gain: float = 0.0012
    target_busy_ratio: float = 0.68
    _: KW_ONLY
    min_share: float = 0.0006
    max_share: float = 0.03
    max_rise: float = 0.0005
    max_fall: float = -0.00025
    busy_weight: float = 0.5
    measures_an_update: int = 2
    shortest_s: float = 0.025
    longest_s: float = 1.0
    measuring_interval_s: float = 0.1
    start_share: float | None = None

    def __post_init__(self) -> None:
        for name in ("relaxation", "gain", "target_busy_ratio", "busy_weight"):
            if not 0 < getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie in (0, 1], got {getattr(self, name)}")
        if not 0 < self.min_share <= self.max_share <= 1:
            raise ValueError(f"shares must be in order in (0, 1], got {self.min_share} and {self.max_share}")
        if not self.max_fall < 0 < self.max_rise:
            raise ValueError(
                f"max_fall must be negative and max_rise positive, got {self.max_fall}, {self.max_rise}"
            )
        if not (0 < self.shortest_s <= self.longest_s and self.measuring_interval_s > 0):
            raise ValueError(f"times must be positive and in order, got {self.shortest_s}, {self.longest_s}")
        if self.measures_an_update < 1:
            raise ValueError(f"measures_an_update must be at least 1, got {self.measures_an_update}")
        if self.start_share is not None and not self.min_share <= self.start_share <= self.max_share:
            raise ValueError(f"start_share must lie between the shares, got {self.start_share}")

    @property
    def code(self) -> int:
        """Which approach it is, to the compiled step."""
        return kernels.ADAPTIVE

    def constants(self) -> FloatArray:
        """Constants as the compiled rules take them, (12,)."""
        return np.array(astuple(self)[:-1], dtype=np.float64)

    @property
    def first_share(self) -> float:
        """Share of the channel before the first update."""
        return self.max_share if self.start_share is None else self.start_share

    def rows(self, vehicles: int, start_s: FloatArray) -> FloatArray:
        """State before the first measure, (B, 5); the first is due at ``start_s`` (B,) [s]."""
        rows = np.zeros((vehicles, kernels.STATE_COLUMNS))
        rows[:, kernels.SHARE] = self.first_share
        rows[:, kernels.DUE_S] = start_s
        return rows

    def fixed_share(self, stations: int) -> float:
        """Share of the channel at which that many stations settle, where no bound is met."""
        return self.gain * self.target_busy_ratio / (self.relaxation + stations * self.gain)


@dataclass(frozen=True, slots=True)
class ReactiveDcc:
    """The reactive approach of ETSI TS 102 687 V1.2.1, clause 5.3: a table of states.

    Parameters
    ----------
    bounds_ratio
        Channel busy ratio at which each state but the first begins, (S-1,) rising. The table prints ranges
        of whole percent, below 30, 30-39, 40-49, 50-60, above 60 [second-hand]; here the next state begins
        where the next range does.
    intervals_s
        Shortest time between messages in each state, (S,) [second-hand] [s].
    measuring_interval_s
        T_CBR [read in public code] [s].
    neighbouring_only
        Whether a measure moves the state by one at most [from memory]; by default it is looked up.

    Raises
    ------
    ValueError
        Where lengths or order are wrong.

    References
    ----------
    ETSI TS 102 687 V1.2.1, clause 5.3 and annex A, for messages of up to 1 ms airtime.

    Examples
    --------
    >>> ReactiveDcc().interval_s(0.45)
    0.4
    """

    bounds_ratio: tuple[float, ...] = (0.30, 0.40, 0.50, 0.60)
    intervals_s: tuple[float, ...] = (0.1, 0.2, 0.4, 0.5, 1.0)
    _: KW_ONLY
    measuring_interval_s: float = 0.1
    neighbouring_only: bool = False

    def __post_init__(self) -> None:
        if len(self.intervals_s) != len(self.bounds_ratio) + 1:
            raise ValueError(
                f"intervals_s must be one more than bounds_ratio, got {len(self.intervals_s)} "
                f"and {len(self.bounds_ratio)}"
            )
        for name in ("bounds_ratio", "intervals_s"):
            values = getattr(self, name)
            if not all(a < b for a, b in zip((0.0, *values), values, strict=False)):
                raise ValueError(f"{name} must be positive and rise, got {values}")
        if not self.measuring_interval_s > 0:
            raise ValueError(f"measuring_interval_s must be positive, got {self.measuring_interval_s}")

    @property
    def code(self) -> int:
        """Which approach it is, to the compiled step."""
        return kernels.REACTIVE

    def constants(self) -> FloatArray:
        """Constants as the compiled rules take them, (2 + 2S - 1,)."""
        return np.array(
            [float(self.neighbouring_only), self.measuring_interval_s, *self.bounds_ratio, *self.intervals_s]
        )

    @property
    def first_share(self) -> float:
        """Number of the first state, which stands where `AdaptiveDcc` keeps its share."""
        return 0.0

    def rows(self, vehicles: int, start_s: FloatArray) -> FloatArray:
        """State before the first measure, (B, 5): the relaxed one; the first is due at ``start_s`` [s]."""
        rows = np.zeros((vehicles, kernels.STATE_COLUMNS))
        rows[:, kernels.DUE_S] = start_s
        return rows

    def interval_s(self, channel_busy_ratio: float) -> float:
        """Shortest time between messages at a channel busy ratio [s]."""
        return self.intervals_s[int(np.searchsorted(self.bounds_ratio, channel_busy_ratio, side="right"))]

"""What the closed loop tracks and counts."""

from dataclasses import dataclass

__all__ = ["NetworkSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkSettings:
    """What is tracked and counted.

    Parameters
    ----------
    warm_up_s
        Left out of all counts but the series [s].
    dt_s
        Step of the frames [s].
    reach_m
        A host passes over remotes that state a place farther away [m].
    expiry_s
        Silence after which a track counts as lost [s]; at least twice what the sender's rule allows is taken.
    start_spread_s
        The vehicles of the first frame begin to send within this time [s]; None for the longest silence that
        the rule allows. Else all would go on sending together.
    distance_bin_m, distances
        Width [m] and number of the bins of distance.
    middle_bins
        First and end bin of the headline distances, 50 m to 150 m by default; also those of the series of
        tracking errors.
    counted_m
        Hosts count whose place is from the first to the second, east [m]: their tracks, gaps, pairs and how
        busy they find the channel; None for all. What is sent, and what becomes of frames, is counted whole.
    step_slack_s
        How far steps may be from `dt_s`, as those of recorded trips are [s].

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    warm_up_s: float = 5.0
    dt_s: float = 0.1
    reach_m: float = 350.0
    expiry_s: float = 5.0
    start_spread_s: float | None = None
    distance_bin_m: float = 25.0
    distances: int = 12
    middle_bins: tuple[int, int] = (2, 6)
    counted_m: tuple[float, float] | None = None
    step_slack_s: float = 1e-6

    def __post_init__(self) -> None:
        for name in ("dt_s", "reach_m", "expiry_s", "distance_bin_m", "distances"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not self.warm_up_s >= 0:
            raise ValueError(f"warm_up_s must not be negative, got {self.warm_up_s}")
        first, end = self.middle_bins
        if not 0 <= first < end <= self.distances:
            raise ValueError(f"middle_bins must be in order within {self.distances}, got {self.middle_bins}")
        if self.counted_m is not None and not self.counted_m[0] < self.counted_m[1]:
            raise ValueError(f"counted_m must rise, got {self.counted_m}")

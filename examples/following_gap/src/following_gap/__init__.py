"""A warning of following too closely, by the time gap to the vehicle ahead."""

from dataclasses import dataclass

import numpy as np

from modelcast import AbstractApplication, Motions, Warnings

__all__ = ["FollowingGap"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowingGap(AbstractApplication):
    """Warns where the host would reach the place of the vehicle ahead in less than a time gap.

    Parameters
    ----------
    least_s
        Time gap below which it warns [s].
    caution_s
        Time gap below which it cautions [s].
    half_width_m
        Offset from the host's course up to which a remote is ahead in its lane [m].
    """

    least_s: float = 0.8
    caution_s: float = 1.2
    half_width_m: float = 1.8

    def __post_init__(self) -> None:
        if not 0.0 < self.least_s <= self.caution_s:
            raise ValueError(f"least_s must lie within 0..caution_s, got {self.least_s} and {self.caution_s}")

    def judge(self, host: Motions, remote: Motions) -> Warnings:
        """Judge N pairs, a row each."""
        east_m, north_m = (remote.position_m - host.position_m).T
        sine, cosine = np.sin(host.heading_rad), np.cos(host.heading_rad)
        ahead_m = east_m * sine + north_m * cosine
        aside_m = np.abs(east_m * cosine - north_m * sine)
        same_way = np.cos(remote.heading_rad - host.heading_rad) > 0.7
        follows = (ahead_m > 0.0) & (aside_m < self.half_width_m) & same_way
        gap_m = ahead_m - 0.5 * (host.length_m + remote.length_m)
        return Warnings.by_margin(
            np.where(follows, gap_m - self.least_s * host.speed_mps, np.inf),
            cautions=follows & (gap_m < self.caution_s * host.speed_mps),
        )

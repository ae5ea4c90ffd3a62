"""What a study of platoons compares."""

from dataclasses import dataclass, field

import numpy as np

from modelcast.apps.cruise.base import AbstractCruiseLaw
from modelcast.apps.cruise.path import PathCacc
from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.runtime.platoon.drive import DriveSettings
from modelcast.station.policy.error_driven import LOSS_BUDGET
from modelcast.station.sender.names import SENDERS
from modelcast.study.cruise.senders import has_threshold, is_sender
from modelcast.world.platoon.leaders import AbstractLeader, Sinusoid

__all__ = ["CRUISE_SENDERS", "CruiseSettings", "Loss"]

CRUISE_SENDERS = ("bsm-10hz", "baseline", "free", "mbc", "j2945", "j2945-mbc")
"""Senders compared where none is named."""


@dataclass(frozen=True, slots=True)
class Loss:
    """How messages are lost on every link.

    Parameters
    ----------
    ratio
        Share of messages lost, 0..1.
    burst_s
        Mean time for which a link is gone; 0 for losses that are independent [s].
    """

    ratio: float
    burst_s: float = 0.0

    @property
    def channel(self) -> Ideal | IndependentErasure | GilbertElliott:
        """The channel of one link.

        Raises
        ------
        ValueError
            Where the ratio lies outside 0..1, or the time is negative or not finite.
        """
        if self.ratio == 0.0:
            return Ideal()
        return GilbertElliott(self.ratio, self.burst_s) if self.burst_s else IndependentErasure(self.ratio)


@dataclass(frozen=True, slots=True, kw_only=True)
class CruiseSettings:
    """What is compared, and on which platoons.

    Parameters
    ----------
    senders
        Names that `platoon_sender` knows.
    thresholds_m
        Of those that a tracking error calls; the others are run once [m].
    losses
        All of them for every sender.
    platoons, vehicles
        Platoons driven at once, each with a chance of its own, and vehicles of each, the leader among them.
    leader, law, drive
        What the leader drives, by which law the others follow, and how the loop runs.
    keep_alive_s
        Longest silence of the senders that errors call [s].
    approach_m
        Of the same, the way that two vehicles as fast as the sender may come closer between two messages [m].
        Infinite by default: that rule is for those who meet, and within a platoon nobody does. At 100 km/h
        its 20 m alone would ask for 2.8 messages a second.
    budget
        Of `free` and `mbc`, messages under loss over those of a channel without losses, as in `ErrorDriven`.
    most_age_s
        What is older is not taken for knowledge; the expiry of tracks holds besides [s].
    seed
        Of all chance.

    Raises
    ------
    ValueError
        Where a name is unknown, nothing is to be compared, a value is out of its range, or the run ends
        before disturbances begin.
    """

    senders: tuple[str, ...] = CRUISE_SENDERS
    thresholds_m: tuple[float, ...] = (0.2,)
    losses: tuple[Loss, ...] = (Loss(0.0), Loss(0.2), Loss(0.4), Loss(0.6), Loss(0.8), Loss(0.9))
    platoons: int = 8
    vehicles: int = 8
    leader: AbstractLeader = field(default_factory=Sinusoid)
    law: AbstractCruiseLaw = field(default_factory=PathCacc)
    drive: DriveSettings = field(default_factory=DriveSettings)
    keep_alive_s: float = 1.0
    approach_m: float = np.inf
    budget: float = LOSS_BUDGET
    most_age_s: float = 5.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in self.senders:
            if not is_sender(name):
                raise ValueError(
                    f"sender must be one of {', '.join(SENDERS)}, or bsm-Nhz or free-Nhz with N from 0.1 "
                    f"to 10, got {name!r}"
                )
        for name in ("senders", "thresholds_m", "losses"):
            held = getattr(self, name)
            if not held or len(set(held)) != len(held):
                raise ValueError(f"{name} must name at least one, and none twice, got {held}")
        for name in ("keep_alive_s", "approach_m", "budget", "most_age_s"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not min(self.thresholds_m) > 0.0:
            raise ValueError(f"thresholds_m must be positive, got {self.thresholds_m}")
        for loss in self.losses:
            _ = loss.channel
        self._check_platoons()

    def _check_platoons(self) -> None:
        if self.platoons < 1 or self.vehicles < 3:
            raise ValueError(
                "string stability takes a platoon of 3 vehicles or more, "
                f"got {self.platoons} of {self.vehicles}"
            )
        least_s = self.drive.settle_s + 5.0
        if not self.drive.duration_s >= least_s:
            raise ValueError(
                f"duration_s must be at least {least_s}: disturbances begin at {self.drive.settle_s} s, "
                f"got {self.drive.duration_s}"
            )
        if self.seed < 0:
            raise ValueError(f"seed must not be negative, got {self.seed}")

    @property
    def contenders(self) -> tuple[tuple[str, float | None], ...]:
        """Senders with their threshold, None for those that have none."""
        return tuple(
            (name, threshold_m)
            for name in self.senders
            for threshold_m in (self.thresholds_m if has_threshold(name) else (None,))
        )

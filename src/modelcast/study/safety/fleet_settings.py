"""What an evaluation of safety applications in simulated traffic is asked to do."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.station.receiver.reading import Reading
from modelcast.study.safety.settings import NEAR_M

__all__ = ["FleetSafetySettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetSafetySettings:
    """What hosts of a fleet warn of, and how that is scored.

    Parameters
    ----------
    applications
        What warns, by name.
    readings
        How hosts read messages; several are assessed side by side, of the same hosts and remotes.
    radius_m
        Remotes farther away than this are in no pair [m].
    hosts_ratio
        Share of the vehicles that are hosts, drawn by their identifiers; all of them send.
    warm_up_s
        Left out [s].
    near_m
        As `modelcast.study.safety.settings.NEAR_M` [m].
    merge_s, grace_s
        As in `modelcast.study.safety.settings.SafetySettings` [s].
    seed
        Of the draw of hosts.

    Raises
    ------
    ValueError
        Where there is no application or reading, or a value is out of its range.
    """

    applications: Mapping[str, AbstractApplication]
    readings: tuple[Reading, ...] = (Reading.MODEL,)
    radius_m: float = 150.0
    hosts_ratio: float = 1.0
    warm_up_s: float = 5.0
    near_m: float = NEAR_M
    merge_s: float = 1.0
    grace_s: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.applications:
            raise ValueError("applications must hold at least one, as fcw")
        if not self.readings or len(set(self.readings)) != len(self.readings):
            raise ValueError(f"readings must be at least one, each once, got {self.readings}")
        for name in ("radius_m", "near_m", "merge_s", "grace_s"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not 0.0 < self.hosts_ratio <= 1.0:
            raise ValueError(f"hosts_ratio must lie in (0, 1], got {self.hosts_ratio}")
        if not (np.isfinite(self.warm_up_s) and self.warm_up_s >= 0.0):
            raise ValueError(f"warm_up_s must be finite and not negative, got {self.warm_up_s}")

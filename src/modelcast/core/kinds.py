"""What kind of road user a station is, and how large such a one is."""

from collections.abc import Mapping
from enum import IntEnum
from types import MappingProxyType

__all__ = ["CYCLIST_M", "PEDESTRIAN_M", "PEOPLE", "SIZES_M", "Kind"]


class Kind(IntEnum):
    """Kinds of stations; people's numbers are those of J2735's personal device user types."""

    VEHICLE = 0
    PEDESTRIAN = 1
    CYCLIST = 2
    ROAD_WORKER = 3
    ROADSIDE = 4


PEOPLE = (Kind.PEDESTRIAN, Kind.CYCLIST, Kind.ROAD_WORKER)
"""Vulnerable road users."""

PEDESTRIAN_M = (0.6, 0.5)
"""Length, along the stride, and width of a pedestrian [m]: about an adult test target in mid-stride."""

CYCLIST_M = (1.9, 0.6)
"""Length and width of a cyclist [m]: about a bicyclist test target, 1.9 m, with its handlebar."""

SIZES_M: Mapping[Kind, tuple[float, float]] = MappingProxyType(
    {
        Kind.VEHICLE: (4.5, 1.8),
        Kind.PEDESTRIAN: PEDESTRIAN_M,
        Kind.CYCLIST: CYCLIST_M,
        Kind.ROAD_WORKER: PEDESTRIAN_M,
        Kind.ROADSIDE: (0.3, 0.3),
    }
)
"""Length and width of each kind where nothing else is known [m]."""

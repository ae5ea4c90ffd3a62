"""What kind of road user a station is."""

from enum import IntEnum

__all__ = ["PEOPLE", "Kind"]


class Kind(IntEnum):
    """Kinds of stations; people's numbers are those of J2735's personal device user types."""

    VEHICLE = 0
    PEDESTRIAN = 1
    CYCLIST = 2
    ROAD_WORKER = 3
    ROADSIDE = 4


PEOPLE = (Kind.PEDESTRIAN, Kind.CYCLIST, Kind.ROAD_WORKER)
"""Vulnerable road users."""

"""What searches for a capacity found."""

from dataclasses import dataclass

from modelcast.study.network.capacity import Capacity

__all__ = ["CapacityFound"]


@dataclass(frozen=True, slots=True)
class CapacityFound:
    """The capacity of one radio and policy at one limit.

    Parameters
    ----------
    radio, policy
        Names.
    limit_m
        Tracking error that p99 stays under [m].
    capacity
        What was found.
    """

    radio: str
    policy: str
    limit_m: float
    capacity: Capacity

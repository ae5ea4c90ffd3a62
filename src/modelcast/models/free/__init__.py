"""Free sub-models: all that a receiver needs of them stands in Part I, and costs no byte.

What a plain message means to its receivers is fixed: constant turn rate and acceleration from speed, heading,
acceleration and yaw rate, up to a trusted horizon. What a sender can choose is how it estimates those four
values, and, within the accuracy that is asked of them, which it states.
"""

from modelcast.models.free.estimates import Estimates
from modelcast.models.free.free_motion import FreeMotion
from modelcast.models.free.limits import Limits

__all__ = ["Estimates", "FreeMotion", "Limits"]

"""Vehicle processes before any training: round numbers, where a search starts.

What ``gp-vehicle`` and ``gp-derivative`` mean on the command line is in a profile
(`modelcast.models.profile.Profile.sub_model`), as is every other hyper-parameter that was learned.
"""

from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.vehicle import VehicleProcess

__all__ = ["derivative_process", "vehicle_process"]

_AXIS = AxisKernel(5.0, 25.0)
"""A lengthscale of 5 s, and 1 m/s² (25 m over its square) of acceleration."""

_STRAIGHT_AFTER_S = 2.5
_DEGREE = 3


def vehicle_process(samples: int = 10) -> VehicleProcess:
    """Positions along and across the course, ``gp-vehicle``.

    Parameters
    ----------
    samples
        Window length n.
    """
    return VehicleProcess(
        "gp-vehicle",
        _AXIS,
        across=_AXIS,
        samples=samples,
        degree=_DEGREE,
        straight_after_s=_STRAIGHT_AFTER_S,
    )


def derivative_process(samples: int = 10) -> VehicleProcess:
    """Positions and velocities along and across the course, ``gp-derivative``.

    Parameters
    ----------
    samples
        Window length n.
    """
    return VehicleProcess(
        "gp-derivative",
        _AXIS,
        across=_AXIS,
        samples=samples,
        velocities=True,
        degree=_DEGREE,
        straight_after_s=_STRAIGHT_AFTER_S,
    )

"""The safety applications by name, as a command line asks for them."""

from collections.abc import Mapping
from types import MappingProxyType

from modelcast.apps.base import AbstractApplication
from modelcast.apps.brake_light import BrakeLight
from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.intersection import IntersectionAssist
from modelcast.apps.vulnerable_road_user import VulnerableRoadUserWarning
from modelcast.core.exceptions import ConfigError

__all__ = ["APPLICATIONS", "get_application"]

APPLICATIONS: Mapping[str, AbstractApplication] = MappingProxyType(
    {
        "fcw": ForwardCollisionWarning(),
        "eebl": BrakeLight(),
        "ima": IntersectionAssist(),
        "vru": VulnerableRoadUserWarning(),
    }
)
"""Forward collision warning, emergency electronic brake light, intersection movement assist, and the warning
of and for vulnerable road users."""


def get_application(name: str) -> AbstractApplication:
    """Return an application by its name.

    Raises
    ------
    ConfigError
        Where there is none of that name.

    Examples
    --------
    >>> get_application("ima").longest_s
    8.0
    """
    if name not in APPLICATIONS:
        raise ConfigError(f"Unknown safety application {name!r}. Known: {', '.join(APPLICATIONS)}.")
    return APPLICATIONS[name]

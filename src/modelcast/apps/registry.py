"""The safety applications by name, as a command line asks for them.

Other packages add theirs through the entry-point group ``modelcast.applications``: each entry point loads a
class derived from `modelcast.apps.base.AbstractApplication` whose arguments all have defaults.
"""

from modelcast.apps.base import AbstractApplication
from modelcast.core.open_group import OpenGroup

__all__ = ["APPLICATIONS", "get_application"]

APPLICATIONS = OpenGroup(
    "modelcast.applications",
    AbstractApplication,
    called="application",
    own={
        "fcw": "modelcast.apps.forward_collision:ForwardCollisionWarning",
        "eebl": "modelcast.apps.brake_light:BrakeLight",
        "ima": "modelcast.apps.intersection:IntersectionAssist",
        "vru": "modelcast.apps.vulnerable_road_user:VulnerableRoadUserWarning",
    },
)
"""Forward collision warning, emergency electronic brake light, intersection movement assist, the warning of
and for vulnerable road users; and those of other packages."""


def get_application(text: str) -> AbstractApplication:
    """Return an application by its name.

    Parameters
    ----------
    text
        ``NAME``, or ``NAME:KEY=VALUE,KEY=VALUE`` with settings of its own.

    Raises
    ------
    ConfigError
        Where there is none of that name, or it refuses its settings.

    Examples
    --------
    >>> get_application("ima").longest_s, get_application("ima:longest_s=5").longest_s
    (8.0, 5)
    """
    return APPLICATIONS.made_from(text)

"""Safety applications by name."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from modelcast.apps.base import AbstractApplication
from modelcast.apps.forward_collision import ForwardCollisionWarning

__all__ = ["APPLICATIONS", "named_application"]

APPLICATIONS: Mapping[str, type[AbstractApplication]] = MappingProxyType({"fcw": ForwardCollisionWarning})
"""The applications by the names that users give."""


def named_application(name: str, **settings: Any) -> AbstractApplication:
    """The application of that name.

    Parameters
    ----------
    name
        One of `APPLICATIONS`.
    settings
        Of it, by the names of its fields.

    Raises
    ------
    ValueError
        Where there is no such name or setting, or a value is out of its range.

    Examples
    --------
    >>> named_application("fcw", caution_s=0.5).caution_s
    0.5
    """
    if name not in APPLICATIONS:
        raise ValueError(f"application must be one of {', '.join(APPLICATIONS)}, got {name!r}")
    kind: Any = APPLICATIONS[name]
    known = {field for field in kind.__dataclass_fields__ if field != "_"}
    unknown = sorted(set(settings) - known)
    if unknown:
        raise ValueError(f"{name} has no {', '.join(unknown)}; it has {', '.join(sorted(known))}")
    return kind(**settings)

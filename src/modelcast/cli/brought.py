"""What other packages bring, in all groups, and whether it can be had; `modelcast doctor` shows it."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from operator import attrgetter
from types import MappingProxyType

from modelcast.core.exceptions import ModelcastError
from modelcast.core.open_group import OpenGroup, registered

__all__ = ["Brought", "brought"]

_MAKERS = MappingProxyType(
    {
        "modelcast.applications": "modelcast.apps.registry:APPLICATIONS.made",
        "modelcast.policies": "modelcast.station.sender.names:POLICIES.made",
        "modelcast.radios": "modelcast.channel.registry:RADIOS.made",
        "modelcast.readers": "modelcast.io.registry:READERS.made",
        "modelcast.sub_models": "modelcast.models.sub_models:registered_model",
    }
)
"""What makes a thing of a group by its name alone, where things are made without arguments."""


@dataclass(frozen=True, slots=True)
class Brought:
    """Something that another package brings.

    Parameters
    ----------
    group, name
        The entry-point group, and the name in it.
    package, version
        Of the distribution.
    problem
        Why it cannot be had; empty where it can.
    """

    group: str
    name: str
    package: str
    version: str
    problem: str


def brought() -> Iterator[Brought]:
    """Yield what other packages bring, by group and name; each is loaded, and made where it takes nothing."""
    for group in sorted(name for name in entry_points().groups if name.startswith("modelcast.")):
        for name, points in sorted(registered(group).items()):
            problem = _problem(group, name)
            for point in points:
                about = ("unknown", "") if point.dist is None else (point.dist.name, point.dist.version)
                yield Brought(group, name, *about, problem)


def _problem(group: str, name: str) -> str:
    try:
        if group in _MAKERS:
            module, _, maker = _MAKERS[group].partition(":")
            attrgetter(maker)(import_module(module))(name)
        else:
            OpenGroup(group, object, called=group, own={}).loaded(name)
    except ModelcastError as error:
        return str(error)
    return ""

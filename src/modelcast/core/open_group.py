"""What other packages may add: named things, ours and theirs, behind one entry-point group each.

A package adds one in its ``pyproject.toml``::

    [project.entry-points."modelcast.radios"]
    two-ray = "two_ray.radio:TwoRay"

The right side is what `OpenGroup.made` calls, most often the class itself; its settings are keywords.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from inspect import signature
from typing import Any, Generic, TypeVar

from modelcast.core.exceptions import ConfigError
from modelcast.core.named_settings import named_settings
from modelcast.core.near_names import near
from modelcast.core.rules import shown

__all__ = ["OpenGroup", "Origin", "registered"]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Origin:
    """The package that brings something.

    Parameters
    ----------
    package
        Name of the distribution.
    version
        Its version.
    """

    package: str
    version: str

    def __str__(self) -> str:
        return f"{self.package} {self.version}"


@dataclass(frozen=True, slots=True)
class OpenGroup(Generic[T]):
    """The named things of one kind: those of modelcast, and those other packages register.

    Parameters
    ----------
    name
        The entry-point group, ``modelcast.readers`` for one.
    kind
        The class all of them are instances of.
    called
        What one is called in messages, ``format`` for one.
    own
        Those of modelcast: where each is, as ``module:attribute``, by name.

    Examples
    --------
    >>> from modelcast.core.open_group import OpenGroup
    >>> counters = OpenGroup("example.counters", dict, called="counter", own={"plain": "collections:Counter"})
    >>> counters.names()
    ('plain',)
    >>> counters.made("plain")
    Counter()
    >>> counters.made("other")
    Traceback (most recent call last):
    modelcast.core.exceptions.ConfigError: Unknown counter 'other'. Known: plain. Packages add theirs in the \
entry-point group 'example.counters'.
    """

    name: str
    kind: type[T]
    _: KW_ONLY
    called: str
    own: Mapping[str, str]

    def names(self) -> tuple[str, ...]:
        """Return all names: those of other packages, then ours."""
        return (*self.foreign_names(), *self.own)

    def foreign_names(self) -> tuple[str, ...]:
        """Return the names that other packages add, in alphabetical order."""
        return tuple(sorted(registered(self.name).keys() - self.own.keys()))

    def origin(self, name: str) -> Origin | None:
        """Return the package a thing comes from, None for ours.

        Raises
        ------
        ConfigError
            As `loaded`.
        """
        if name in self.own:
            return None
        brought = self._point(name).dist
        return Origin("unknown", "unknown") if brought is None else Origin(brought.name, brought.version)

    def loaded(self, name: str) -> Any:
        """Return what stands behind a name, not yet called.

        Raises
        ------
        ConfigError
            Where nothing of that name is known, two packages add one, a package adds one that is ours, or
            it cannot be imported.
        """
        if name in self.own and name not in registered(self.name):
            module, _, attribute = self.own[name].partition(":")
            return getattr(import_module(module), attribute)
        point = self._point(name)
        try:
            return point.load()
        except (Exception, SystemExit) as error:  # whatever the import of another package raises
            raise ConfigError(
                f"The {self.called} {name!r} of {_owner(point)} does not load from {point.value!r}: "
                f"{type(error).__name__}: {error}"
            ) from error

    def made(self, name: str, *arguments: Any, **settings: Any) -> T:
        """Return what a name stands for, called with these arguments.

        Raises
        ------
        ConfigError
            As `loaded`; where the call is refused; where another package's fails, whatever it raises; where
            it gives something of another kind.
        """
        maker: Callable[..., Any] = self.loaded(name)
        ours = name in self.own
        try:
            thing = maker(*arguments, **settings)
        except (AttributeError, TypeError, ValueError) as error:
            if ours and not settings:
                raise
            owner = "modelcast" if ours else _owner(self._point(name))
            raise ConfigError(
                f"The {self.called} {name!r} of {owner} refuses its settings: {error}{_settings_of(maker)}"
            ) from error
        except (Exception, SystemExit) as error:
            if ours:
                raise
            raise ConfigError(
                f"The {self.called} {name!r} of {self.origin(name)} cannot be made by "
                f"{self._point(name).value!r}: {type(error).__name__}: {error}"
            ) from error
        if not isinstance(thing, self.kind):
            raise ConfigError(
                f"The {self.called} registered as {name!r} is no {self.kind.__name__}: {shown(thing)}"
            )
        return thing

    def made_from(self, text: str, *arguments: Any) -> T:
        """Return what a user's word stands for, called with these arguments and the word's settings.

        Parameters
        ----------
        text
            ``NAME`` or ``NAME:KEY=VALUE,KEY=VALUE``, as `modelcast.core.named_settings` takes it apart.
        arguments
            Those of `made`.

        Raises
        ------
        ConfigError
            As `made`; where the word has another form.

        Examples
        --------
        >>> counters = OpenGroup("example.counters", dict, called="counter", own={"plain": "builtins:dict"})
        >>> counters.made_from("plain:size_m=3")
        {'size_m': 3}
        """
        name, settings = named_settings(text)
        return self.made(name, *arguments, **settings)

    def origins(self, texts: Iterable[str]) -> dict[str, str]:
        """Return package and version of those that other packages bring, by kind and word.

        Parameters
        ----------
        texts
            As for `made_from`.

        Raises
        ------
        ConfigError
            As for `origin`.
        """
        found = {text: self.origin(named_settings(text)[0]) for text in texts}
        return {f"{self.called} {text}": str(origin) for text, origin in found.items() if origin is not None}

    def _point(self, name: str) -> EntryPoint:
        """The one entry point of a name that is not ours."""
        points = registered(self.name).get(name, ())
        if not points:
            known = self.names()
            raise ConfigError(
                f"Unknown {self.called} {name!r}{near(name, known)}. Known: {', '.join(known)}. "
                f"Packages add theirs in the entry-point group {self.name!r}."
            )
        owners = ["modelcast"] if name in self.own else []
        owners += [_owner(point) for point in points]
        if len(owners) > 1:
            raise ConfigError(
                f"The {self.called} {name!r} is registered by {' and by '.join(owners)}. "
                "Uninstall all but one."
            )
        return points[0]


@cache
def registered(group: str) -> Mapping[str, tuple[EntryPoint, ...]]:
    """Return the entry points of a group by name, each once however often it stands on the path."""
    found: dict[str, dict[tuple[str, str], EntryPoint]] = {}
    for point in entry_points(group=group):
        found.setdefault(point.name, {}).setdefault((_owner(point), point.value), point)
    return {name: tuple(points.values()) for name, points in found.items()}


def _settings_of(maker: Callable[..., Any]) -> str:
    """Which settings there are, as a sentence; nothing where that cannot be told."""
    try:
        known = signature(maker).parameters
    except (TypeError, ValueError):
        return ""
    return f". It takes {', '.join(known)}" if known else ". It takes none"


def _owner(point: EntryPoint) -> str:
    """The package an entry point stands in."""
    return "an unnamed package" if point.dist is None else point.dist.name

"""Settings of a radio as flat keys: every simple field of its dataclass and of the parts it is made of.

A radio's form has fields and families. A field is a number, a word or a switch of the radio or of its
``parameters``. A family is a part that comes in kinds, as the path loss does: its selector names the kind,
and each kind has fields of its own. So a radio with a new field has a new key, and nothing is listed twice.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, fields, is_dataclass, replace
from types import MappingProxyType, NoneType, UnionType
from typing import Any, Literal, NamedTuple, Union, cast, get_args, get_origin, get_type_hints

from modelcast.core.exceptions import ConfigError
from modelcast.core.near_names import listed, near

__all__ = ["Family", "Kind", "RadioForm", "Setting", "shown", "simple_fields"]

_PLAIN = (bool, int, float, str, NoneType)
_NONE = "none"
_BEYOND = 2**63
"""Compiled loops hold whole numbers below this."""


class Setting(NamedTuple):
    """One key that a user may set.

    ``place`` is the field it fills, and the place in it where that is a tuple; ``kinds`` are the types its
    value may have, or for a word the words there are; ``default`` is what it is where it is not set.
    """

    key: str
    place: tuple[str, int | None]
    kinds: tuple[Any, ...]
    default: Any

    def checked(self, value: Any) -> Any:
        """The value as the field takes it.

        Raises
        ------
        ConfigError
            Where it is of another type.
        """
        if type(value) is int and abs(value) >= _BEYOND:
            raise ConfigError(f"{self.key} must be {self.wanted} within 64 bits, got {value}")
        words = [one for one in self.kinds if not isinstance(one, type)]
        if words:
            if value in words and not isinstance(value, bool):
                return value
        elif type(value) in self.kinds and not (isinstance(value, float) and not math.isfinite(value)):
            return value
        elif type(value) is int and float in self.kinds:
            return float(value)
        raise ConfigError(f"{self.key} must be {self.wanted}, got {shown(value)}")

    @property
    def wanted(self) -> str:
        """What its value must be, in words."""
        names = {
            bool: "yes or no",
            int: "a whole number",
            float: "a number",
            str: "a word",
            NoneType: _NONE,
        }
        kinds = [one for one in self.kinds if not (one is int and float in self.kinds)]
        return " or ".join(names[one] if isinstance(one, type) else str(one) for one in kinds)


def shown(value: Any) -> str:
    """A value as a user writes it.

    Parameters
    ----------
    value
        A number, a text, a truth value or nothing.
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}".replace("e+0", "e").replace("e+", "e")
    return _NONE if value is None else str(value)


def _kinds(hint: Any) -> tuple[Any, ...]:
    """Types that a simple field's value may have, words of a `Literal`; none where it is not simple."""
    if get_origin(hint) is Literal:
        return get_args(hint)
    parts = get_args(hint) if get_origin(hint) in {UnionType, Union} else (hint,)
    return tuple(parts) if parts and all(one in _PLAIN for one in parts) else ()


def simple_fields(
    thing: Any, *, called: Mapping[str, str] = MappingProxyType({}), hidden: tuple[str, ...] = ()
) -> Iterator[Setting]:
    """Yield the settings of a dataclass instance, whose values are the defaults.

    Parameters
    ----------
    thing
        The instance.
    called
        Keys of fields that have another name than the field; of a tuple's places, ``field.0`` and so on,
        which have a key only where they are listed here.
    hidden
        Fields without a key.
    """
    hints: dict[str, Any] = get_type_hints(cast("Any", type(thing)))
    for one in fields(thing):
        if not one.init or one.name in hidden:
            continue
        value = getattr(thing, one.name)
        if kinds := _kinds(hints[one.name]):
            yield Setting(called.get(one.name, one.name), (one.name, None), kinds, value)
        elif isinstance(value, tuple):
            for k, part in enumerate(cast("tuple[Any, ...]", value)):
                if key := called.get(f"{one.name}.{k}"):
                    yield Setting(key, (one.name, k), (float,), part)


def _with_settings(thing: Any, settings: Mapping[Setting, Any]) -> Any:
    """The instance with these fields set."""
    changes: dict[str, Any] = {}
    for setting, value in settings.items():
        name, at = setting.place
        held = changes.get(name, getattr(thing, name))
        changes[name] = value if at is None else (*held[:at], value, *held[at + 1 :])
    return replace(thing, **changes) if changes else thing


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of a family's part.

    Parameters
    ----------
    base
        Gives the part with its defaults, from the radio's parameters; None where there is no part.
    called, hidden
        As for `simple_fields`.
    needed
        Keys that have no default.
    """

    base: Callable[[Any], Any]
    _: KW_ONLY
    called: Mapping[str, str] = field(default_factory=dict[str, str])
    hidden: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()

    def settings(self, parameters: Any, instance: Any = None) -> tuple[Setting, ...]:
        """The settings of this kind; ``instance`` has the defaults where it is given."""
        made = self.base(parameters) if instance is None else instance
        if made is None:
            return ()
        return tuple(simple_fields(made, called=self.called, hidden=self.hidden))


@dataclass(frozen=True, slots=True)
class Family:
    """A part that comes in kinds.

    Parameters
    ----------
    selector
        The key that names the kind.
    kinds
        By name.
    default
        Name of the kind where none is named; None where the radio has one without a name.
    held
        The part that the radio has where nothing is set.
    parameters
        Those of the radio where nothing is set: the keys that a kind has do not depend on what is set.
    """

    selector: str
    kinds: Mapping[str, Kind]
    default: str | None
    held: Any
    parameters: Any = None

    def settings_of(self, name: str | None) -> tuple[Setting, ...]:
        """Settings of a kind."""
        if name is None:
            return ()
        return self.kinds[name].settings(self.parameters, self.held if name == self.default else None)

    def keys(self) -> dict[str, list[str]]:
        """Names of the kinds that have a key, by key."""
        found: dict[str, list[str]] = {}
        for name in self.kinds:
            for setting in self.settings_of(name):
                found.setdefault(setting.key, []).append(name)
        return found

    def kind_of(self, part: Any) -> str | None:
        """Name of the kind that a part is of, None where it is of none; None is the radio's own part."""
        if part == self.held:
            return self.default
        bases = {name: kind.base(self.parameters) for name, kind in self.kinds.items()}
        same = [name for name, base in bases.items() if base == part]
        alike = [name for name, base in bases.items() if type(base) is type(part)]
        return next(iter((*same, *alike)), self.default if part is None else None)

    def chosen(self, given: Mapping[str, Any], default: str | None) -> str | None:
        """The kind that settings mean: the named one, the default, or the only one that has their keys.

        Raises
        ------
        ConfigError
            Where the selector names none, or a key belongs to another kind.
        """
        own = {key: names for key, names in self.keys().items() if key in given}
        if self.selector in given:
            word = given[self.selector]
            name = _NONE if word is None or word is False else str(word)
            if name not in self.kinds:
                meant = near(name, self.kinds)
                raise ConfigError(f"{self.selector} must be {listed(self.kinds)}, got {shown(word)}{meant}")
        else:
            name = default
            if any(name not in names for names in own.values()):
                common = [one for one in self.kinds if all(one in names for names in own.values())]
                name = common[0] if len(common) == 1 else name
        for key, names in own.items():
            if name not in names:
                raise ConfigError(f"{key} goes with {self.selector}={' or '.join(names)}")
        return name

    def made(self, given: Mapping[str, Any], parameters: Any, held: Any) -> Any:
        """The part with these settings; ``held`` where they change nothing of it.

        Raises
        ------
        ConfigError
            As `chosen`; where a value is of another type, or one is missing.
        """
        if self.selector not in given and not self.keys().keys() & given.keys():
            return held
        held_kind = self.kind_of(held)
        name = self.chosen(given, held_kind)
        if name is None:
            return held
        kind = self.kinds[name]
        if missing := [key for key in kind.needed if key not in given]:
            raise ConfigError(f"{self.selector}={name} needs {' and '.join(missing)}")
        # A part of the kind that is held already keeps what is not set.
        keeps = name == held_kind and self.selector not in given
        base = held if keeps and held is not None else kind.base(parameters)
        settings = {one.key: one for one in kind.settings(parameters)}
        return _with_settings(
            base, {settings[key]: settings[key].checked(given[key]) for key in settings.keys() & given.keys()}
        )


@dataclass(frozen=True, slots=True)
class RadioForm:
    """All keys of a radio, and what they fill.

    Parameters
    ----------
    radio
        With its defaults.
    families
        By the field of the radio they are in, and the field of that: ``propagation``, ``path_loss``; the
        second is empty where the field itself is the part.
    placed
        Gives the radio with changed fields where waves get about as told (None: as in the radio itself).
    follow
        What else changes with the families of a field of the radio: from the field before and after.
    """

    radio: Any
    families: Mapping[tuple[str, str], Family]
    placed: Callable[[Any, Mapping[str, Any], Any], Any]
    follow: Mapping[str, Callable[[Any, Any], Any]]

    @property
    def parameters(self) -> Any:
        """The radio's parameters, None where it has none."""
        return getattr(self.radio, "parameters", None)

    def fields(self) -> dict[str, tuple[str, Setting]]:
        """Settings outside families, by key, with the part of the radio they are in (empty for its own)."""
        found = {one.key: ("", one) for one in simple_fields(self.radio)}
        if is_dataclass(self.parameters):
            found |= {one.key: ("parameters", one) for one in simple_fields(self.parameters)}
        return found

    def keys(self) -> tuple[str, ...]:
        """All keys: selectors with those of their kinds, then the others."""
        found: dict[str, None] = {}
        for family in self.families.values():
            found |= dict.fromkeys((family.selector, *family.keys()))
        return (*self.fields(), *found)

    def check_keys(self, given: Mapping[str, Any]) -> None:
        """Refuse keys that there are none of.

        Raises
        ------
        ConfigError
            With the nearest keys, and all.
        """
        known = self.keys()
        for key in given:
            if key not in known:
                meant = near(key, known)
                raise ConfigError(f"there is no setting {key!r}{meant}. Settings: {', '.join(sorted(known))}")

    def made(self, given: Mapping[str, Any], propagation: Any = None) -> Any:
        """The radio with these settings.

        Parameters
        ----------
        given
            Values by key.
        propagation
            What the settings of propagation begin with; None for the radio's own.

        Raises
        ------
        ConfigError
            Where a key is unknown, does not go with another, or a value is of another type.
        ValueError
            Where a value is out of its range.
        """
        self.check_keys(given)
        own: dict[str, dict[Setting, Any]] = {"": {}, "parameters": {}}
        for key, (part, setting) in self.fields().items():
            if key in given:
                own[part][setting] = setting.checked(given[key])
        parameters = self._parameters(given, own["parameters"])
        changes = {} if parameters is None else {"parameters": parameters}
        for (part, name), family in self.families.items():
            if not name:
                changes[part] = family.made(given, parameters, getattr(self.radio, part))
        radio = self.placed(_with_settings(self.radio, own[""]), changes, propagation)
        parts: dict[str, Any] = {}
        for (part, name), family in self.families.items():
            if name and part != "parameters":
                whole = parts.get(part, getattr(radio, part))
                parts[part] = replace(whole, **{name: family.made(given, parameters, getattr(whole, name))})
        for part, whole in parts.items():
            parts[part] = self.follow[part](getattr(radio, part), whole)
        return replace(radio, **parts) if parts else radio

    def _parameters(self, given: Mapping[str, Any], own: Mapping[Setting, Any]) -> Any:
        """The parameters with these settings, None where the radio has none."""
        if not is_dataclass(self.parameters):
            return None
        parameters = _with_settings(self.parameters, own)
        made = {
            name: family.made(given, parameters, getattr(parameters, name))
            for (part, name), family in self.families.items()
            if part == "parameters"
        }
        return replace(parameters, **made) if made else parameters

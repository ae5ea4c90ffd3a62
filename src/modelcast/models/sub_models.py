"""The sub-models that a name alone stands for: those in closed form, and those other packages register.

A package adds one in its ``pyproject.toml``, as a class that needs no arguments::

    [project.entry-points."modelcast.sub_models"]
    chord = "modelcast_chord:Chord"

The name is the sub-model's own. Banks may then be made of it, with settings of its fields in the same word
(`modelcast.core.named_settings`), and profiles hold it (`modelcast.models.plain`).
"""

from collections.abc import Iterable
from dataclasses import is_dataclass
from types import MappingProxyType
from typing import Any

from modelcast.core.exceptions import ConfigError, ModelcastError
from modelcast.core.named_settings import named_settings
from modelcast.core.open_group import OpenGroup
from modelcast.models.base import AbstractSubModel
from modelcast.models.numpy_model import AbstractNumpySubModel
from modelcast.models.reserved import KINEMATIC, check_name
from modelcast.models.wrapped import unwrapped

__all__ = [
    "SUB_MODELS",
    "model_of_word",
    "names_registered",
    "registered_model",
    "registered_name",
    "sub_model_origins",
]

SUB_MODELS: OpenGroup[AbstractSubModel] = OpenGroup(
    "modelcast.sub_models",
    AbstractSubModel,
    called="sub-model",
    own=MappingProxyType(
        {name: f"{type(one).__module__}:{type(one).__qualname__}" for name, one in KINEMATIC.items()}
    ),
)
"""All of them."""

_DT_S = 0.1
"""Interval at which a sub-model is looked at when it is first named [s]."""


def registered_model(name: str, **fields: Any) -> AbstractSubModel:
    """Return a sub-model that another package registers.

    It is looked at here: one in NumPy whether it works and whether the rows of its batches stand alone, any
    other whether it has its compiled functions.

    Parameters
    ----------
    name
        The registered one.
    fields
        Fields of the class; its own values where left out.

    Raises
    ------
    ConfigError
        Where none has that name, its package does not load or refuses the fields, or it calls itself
        something else; where a property of it fails.
    SubModelError
        Where it fails on made-up windows.
    """
    member = SUB_MODELS.made(name, **fields)
    try:
        _look_at(member, name)
    except ModelcastError:
        raise
    except (Exception, SystemExit) as error:  # whatever a property of another package's class raises
        raise ConfigError(
            f"The sub-model {name!r} of {SUB_MODELS.origin(name)} cannot be used: "
            f"{type(error).__name__}: {error}"
        ) from error
    return member


def names_registered(word: str) -> bool:
    """Whether a word of a bank names what another package registers, with settings or without.

    Parameters
    ----------
    word
        ``NAME`` or ``NAME:KEY=VALUE,KEY=VALUE``; anything else names nothing.
    """
    return word.partition(":")[0] in SUB_MODELS.foreign_names()


def model_of_word(word: str) -> AbstractSubModel:
    """Return the sub-model that a word of a bank names, with the word's settings as its fields.

    Parameters
    ----------
    word
        As for `names_registered`.

    Raises
    ------
    ConfigError, SubModelError
        As for `registered_model`; where the word has another form.
    """
    name, fields = named_settings(word)
    return registered_model(name, **fields)


def _look_at(member: AbstractSubModel, name: str) -> None:
    """Refuse what is no sub-model of that name, or does not work."""
    if not is_dataclass(member) or member.name != name:
        raise ConfigError(
            f"The sub-model registered as {name!r} by {SUB_MODELS.origin(name)} must be a frozen dataclass "
            f"of that name, got {type(member).__name__} named {member.name!r}."
        )
    try:
        check_name(member)
    except ValueError as error:
        raise ConfigError(f"The sub-model {name!r} of {SUB_MODELS.origin(name)}: {error}") from error
    if isinstance(member, AbstractNumpySubModel):
        member.row_dependence(_DT_S)
    else:
        member.point_functions(_DT_S)


def registered_name(kind: type[object]) -> str:
    """Return the name under which another package registers a class; empty where none does.

    Parameters
    ----------
    kind
        Any class.

    Raises
    ------
    ConfigError
        Where a package that registers one does not load.
    """
    return next((name for name in SUB_MODELS.foreign_names() if SUB_MODELS.loaded(name) is kind), "")


def sub_model_origins(members: Iterable[AbstractSubModel]) -> dict[str, str]:
    """Return package and version of the sub-models that other packages register, by ``sub-model NAME``.

    Packages that register none of these are not loaded.

    Parameters
    ----------
    members
        Of a bank or a profile, wrapped or not.

    Raises
    ------
    ConfigError
        As for `modelcast.core.open_group.OpenGroup.loaded`.
    """
    foreign = SUB_MODELS.foreign_names()
    inside = {member.name: unwrapped(member) for member in members if member.name in foreign}
    return SUB_MODELS.origins(name for name, one in inside.items() if SUB_MODELS.loaded(name) is type(one))

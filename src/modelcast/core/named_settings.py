"""How a user names something and sets it, in one word: ``NAME`` or ``NAME:KEY=VALUE,KEY=VALUE``."""

import re
from types import MappingProxyType
from typing import Any

from modelcast.core.exceptions import ConfigError

__all__ = ["named_settings"]

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_RESERVED = "+@"
_WORDS = MappingProxyType({"true": True, "yes": True, "false": False, "no": False, "none": None})
_FORM = "NAME or NAME:KEY=VALUE,KEY=VALUE"


def named_settings(text: str) -> tuple[str, dict[str, Any]]:
    """Take a word apart into a name and settings.

    A value is a whole number, a number, ``true`` or ``yes``, ``false`` or ``no``, ``none``, else a text.

    Parameters
    ----------
    text
        The word. It holds no ``+`` and no ``@``, which join the senders of a mixed fleet.

    Raises
    ------
    ConfigError
        Where it is no such word, or sets a key twice.

    Examples
    --------
    >>> named_settings("dsrc")
    ('dsrc', {})
    >>> named_settings("disc:range_m=300,sharp=true,edge=1e-3")
    ('disc', {'range_m': 300, 'sharp': True, 'edge': 0.001})
    """
    name, marked, rest = text.partition(":")
    if not _NAME.fullmatch(name) or any(one in text for one in _RESERVED):
        raise ConfigError(f"{text!r} is not {_FORM}, without {' and '.join(_RESERVED)}")
    settings: dict[str, Any] = {}
    for pair in rest.split(",") if marked else ():
        key, given, value = pair.partition("=")
        if not given or not value or not _KEY.fullmatch(key):
            raise ConfigError(f"{text!r}: {pair!r} is not KEY=VALUE; the form is {_FORM}")
        if key in settings:
            raise ConfigError(f"{text!r} sets {key} twice")
        settings[key] = _value(value)
    return name, settings


def _value(text: str) -> int | float | bool | str | None:
    if text in _WORDS:
        return _WORDS[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text

"""Radios as a command line asks for them: ``NAME:KEY=VALUE,KEY=VALUE``, with presets.

Our own radios take every key of their form (`modelcast.channel.radio_parts`). Those of other packages take
their keywords.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import AbstractRadio
from modelcast.channel.radio_parts import radio_form
from modelcast.channel.radio_presets import PRESETS
from modelcast.channel.radio_settings import RadioForm, shown
from modelcast.channel.registry import RADIOS
from modelcast.core.exceptions import ConfigError
from modelcast.core.named_settings import named_settings
from modelcast.core.near_names import listed, near

__all__ = ["RadioKey", "get_radio", "radio_keys"]

PRESET = "preset"


class RadioKey(NamedTuple):
    """A setting as it is listed: where it belongs, what it may be, and what it is where it is not set."""

    key: str
    goes_with: str
    values: str
    default: str


def get_radio(text: str, propagation: Propagation | None = None) -> AbstractRadio[Any]:
    """Return a radio by its name.

    Parameters
    ----------
    text
        ``NAME``, or ``NAME:KEY=VALUE,KEY=VALUE`` with settings of its own. ``preset=NAME`` comes first,
        wherever it stands, and the other settings change it.
    propagation
        How waves get from vehicle to vehicle; settings change it. None for the radio's own.

    Raises
    ------
    ConfigError
        Where there is none of that name, or it refuses its settings.

    Examples
    --------
    >>> get_radio("ideal:range_m=300").range_m
    300.0
    >>> found = get_radio("dsrc:preset=wilab,antenna_gain_db=0")
    >>> found.parameters.antenna_gain_db, found.error_model
    (0.0, ThresholdErrorModel(threshold_db=6.5))
    """
    name, given = named_settings(text)
    if name not in RADIOS.own or not given:
        found = RADIOS.made_from(text)
        return found if propagation is None else found.within(propagation)
    form = radio_form(RADIOS.made(name))
    try:
        return form.made(_with_preset(name, given, form), propagation)
    except (ConfigError, ValueError, ArithmeticError, MemoryError) as error:
        raise ConfigError(f"The radio {name!r} refuses its settings: {error}") from error


def _with_preset(name: str, given: Mapping[str, Any], form: RadioForm) -> dict[str, Any]:
    """Settings with the preset's before them; another kind of a part takes nothing from the preset's."""
    settings = {key: value for key, value in given.items() if key != PRESET}
    if PRESET not in given:
        return settings
    known, word = PRESETS.get(name, {}), str(given[PRESET])
    if word not in known:
        there = f"it has {listed(known)}" if known else "it has none"
        raise ConfigError(f"there is no preset {word!r}{near(word, known)}: {there}")
    form.check_keys(settings)
    preset = dict(known[word].settings)
    for family in form.families.values():
        selector = family.selector
        named = {key: value for key, value in settings.items() if key == selector}
        meant = family.chosen(preset, family.default)
        if family.chosen(named, meant) != meant:
            own = family.keys()
            preset = {key: value for key, value in preset.items() if key != selector and key not in own}
    return {**preset, **settings}


def radio_keys(name: str) -> tuple[RadioKey, ...]:
    """Return all settings of one of our radios, in order.

    Parameters
    ----------
    name
        Of the radio.

    Raises
    ------
    ConfigError
        Where there is none of that name, or it is another package's.

    Examples
    --------
    >>> [one.key for one in radio_keys("ideal")]
    ['range_m', 'channel', 'ratio', 'mean_burst_s']
    """
    if name not in RADIOS.own:
        raise ConfigError(
            f"The settings of {name!r} are its package's. Listed are those of {listed(RADIOS.own)}"
        )
    form = radio_form(RADIOS.made(name))
    rows = [RadioKey(PRESET, "", listed(PRESETS[name]), "none")] if name in PRESETS else []
    rows += [
        RadioKey(key, "", setting.wanted, shown(setting.default))
        for key, (_, setting) in form.fields().items()
    ]
    for family in form.families.values():
        rows.append(RadioKey(family.selector, "", listed(family.kinds), family.default or "the radio's own"))
        for key, kinds in family.keys().items():
            kind = family.default if family.default in kinds else kinds[0]
            first = {one.key: one for one in family.settings_of(kind)}[key]
            goes_with = "" if len(kinds) == len(family.kinds) else f"{family.selector}={' or '.join(kinds)}"
            needed = key in family.kinds[kind].needed
            rows.append(RadioKey(key, goes_with, first.wanted, "needed" if needed else shown(first.default)))
    return tuple(rows)

"""What a result was made with, as a reader sees it: names in words, values with their units.

Settings that have their default value are folded. What holds pages of numbers, as a trained sub-model does,
is named; its numbers are in the files that programs read.
"""

import ast
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import degrees, isinf
from typing import Any, NamedTuple, cast

from modelcast.core.cells import Cells, escape
from modelcast.study.wording import centimetres

__all__ = ["setting_rows", "settings_section"]

_LONGEST = 240
_WHOLE = "whole in summary.json"

_UNITS: Mapping[str, tuple[str, float]] = {
    "mps2": (" m/s²", 1.0),
    "radps": (" °/s", degrees(1.0)),
    "mps": (" m/s", 1.0),
    "rad": ("°", degrees(1.0)),
    "m": (" m", 1.0),
    "s": (" s", 1.0),
    "hz": (" Hz", 1.0),
    "dbm": (" dBm", 1.0),
    "db": (" dB", 1.0),
    "bytes": (" bytes", 1.0),
    "ratio": (" %", 100.0),
    "ratios": (" %", 100.0),
}
"""Unit and factor by the last part of a name."""

_UNIT_OF = {
    "burst": "s",
    "delay": "s",
    "expiry": "s",
    "keep_alive": "s",
    "later": "m",
    "legacy_threshold": "m",
    "near": "m",
    "per": "ratio",
    "threshold": "m",
}
"""Unit of options of the command line, whose names do not say it."""

_NAMES_OF = {"sub_models": "sub_model_names", "free": "free_names"}
"""Which setting holds the names of another's sub-models."""

_OTHER_NUMBERS = " (not the shipped numbers)"
"""What is said of sub-models that are named as the default's are, and are not those."""

_CALL = re.compile(r"^[A-Z]\w*\(.*\)$", re.DOTALL)


def settings_section(settings: Mapping[str, Any], defaults: Mapping[str, Any] | None = None) -> str:
    """Return settings as markup: what was asked for, what has its default value folded, what is not given.

    Parameters
    ----------
    settings
        As plain values.
    defaults
        The same of what nobody asked for; where None, nothing is folded.
    """
    known = {one.name: one for one in _flat(defaults or {})}
    shown: list[list[str]] = []
    folded: list[list[str]] = []
    absent: list[str] = []
    for one in _flat(settings):
        text, usual = _text(one.name, one.shown), known.get(one.name)
        if not text:
            absent.append(_words(one.name))
        elif usual is not None and usual.value == one.value:
            folded.append([_words(one.name), text])
        else:
            is_alike = usual is not None and usual.shown == one.shown
            shown.append([_words(one.name), f"{text}{_OTHER_NUMBERS}" if is_alike else text])
    parts = [Cells(["setting", "value"], shown).html()] if shown else []
    if folded:
        table = Cells(["setting", "value"], folded).html()
        parts.append(f"<details><summary>As by default ({len(folded)})</summary>{table}</details>")
    if absent:
        parts.append(f'<p class="note">Not given: {escape(", ".join(absent))}.</p>')
    return f'<div class="settings">{"".join(parts)}</div>'


def setting_rows(settings: Mapping[str, Any]) -> list[list[str]]:
    """Return settings that are given as rows of name and value.

    Parameters
    ----------
    settings
        As plain values.

    Examples
    --------
    >>> setting_rows({"seed": 0, "sensor": {"heading_noise_rad": 0.0034906585, "latency_s": 0.1}})
    [['seed', '0'], ['sensor: heading noise', '0.2°'], ['sensor: latency', '0.1 s']]
    >>> setting_rows({"thresholds_m": [0.2, 0.5], "policy": "Above(limit_m=0.5, gain=2.0)", "cost": None})
    [['thresholds', '20, 50 cm'], ['policy', 'above: limit 0.5 m, gain 2']]
    >>> setting_rows({"keep_alive": 2.0, "per": [0.0, 0.4]})
    [['keep alive', '2 s'], ['per', '0, 40 %']]
    """
    rows = [[_words(one.name), _text(one.name, one.shown)] for one in _flat(settings)]
    return [row for row in rows if row[1]]


class _Setting(NamedTuple):
    """A setting by its dotted name: its value, and what is shown of it, which may be names alone."""

    name: str
    value: Any
    shown: Any


def _flat(settings: Mapping[str, Any], prefix: str = "") -> Iterable[_Setting]:
    """Settings by dotted name; sub-models are shown by their names, where these are known."""
    hidden = {names for told, names in _NAMES_OF.items() if told in settings and settings.get(names)}
    for name, value in settings.items():
        if name in hidden:
            continue
        if isinstance(value, Mapping):
            yield from _flat(cast("Mapping[str, Any]", value), f"{prefix}{name}.")
        else:
            names = settings.get(_NAMES_OF[name]) if name in _NAMES_OF else None
            yield _Setting(f"{prefix}{name}", value, names or value)


def _unit_of(name: str) -> str:
    """The last part of a name where that is a unit, or what the option is in; else nothing."""
    if name in _UNIT_OF:
        return _UNIT_OF[name]
    last = name.rpartition("_")[2]
    return last if last in _UNITS and last != name else ""


def _words(name: str) -> str:
    """A dotted name in words, without its unit."""
    *groups, own = name.split(".")
    unit = _unit_of(own)
    if unit and unit not in {"ratio", "ratios", "bytes"}:
        own = own.removesuffix(f"_{unit}")
    return ": ".join(part.replace("_", " ") for part in (*groups, own))


def _text(name: str, value: object) -> str:
    """A value as people read it, with its unit; nothing where there is none."""
    own = name.rpartition(".")[2]
    if value is None or value in ("", [], ()):
        return ""
    if isinstance(value, list | tuple):
        values = cast("Sequence[object]", value)
        if own == "thresholds_m" and all(isinstance(one, float) for one in values):
            return f"{', '.join(centimetres(cast('float', one)).removesuffix(' cm') for one in values)} cm"
        unit = _UNITS[_unit_of(own)][0] if _unit_of(own) else ""
        return _shortened(", ".join(_one(own, one).removesuffix(unit) for one in values) + unit)
    return _shortened(_one(own, value))


def _one(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        sign, factor = _UNITS.get(_unit_of(name), ("", 1.0))
        if isinf(value):
            return "none" if value > 0 else "-∞"
        return (
            f"{factor * value:.4g}{sign}" if isinstance(value, float) or factor != 1.0 else f"{value}{sign}"
        )
    text = str(value)
    return _told(text) if _CALL.match(text) else text


def _told(text: str) -> str:
    """What an object printed as Python is, and those of its fields that are one number or word each."""
    try:
        body = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError):
        return f"{_spaced(text.partition('(')[0])} ({_WHOLE})"
    return _object(body) if isinstance(body, ast.Call) else text


def _object(call: ast.Call) -> str:
    name = _spaced(call.func.id if isinstance(call.func, ast.Name) else ast.unparse(call.func))
    fields: list[str] = []
    is_whole = not call.args
    for keyword in call.keywords:
        found = _field(keyword)
        is_whole &= found is not None
        fields += [] if found is None else [found]
    fields += [] if is_whole else [_WHOLE]
    return f"{name}: {', '.join(fields)}" if fields else name


def _field(keyword: ast.keyword) -> str | None:
    """One field with its value; None where it holds more than one."""
    name, node = keyword.arg or "", keyword.value
    if isinstance(node, ast.Call) and not node.args:
        return f"{_words(name)} ({_object(node)})"
    reads: tuple[Callable[[], object], ...] = (
        lambda: ast.literal_eval(node),
        lambda: float(ast.unparse(node)),
    )
    for read in reads:
        try:
            value = read()
        except (ValueError, TypeError, SyntaxError):
            continue
        if isinstance(value, str | int | float | bool):
            return f"{_words(name)} {_one(name, value)}"
    return None


def _spaced(name: str) -> str:
    """A class's name in words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).lower()


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}… ({_WHOLE})"

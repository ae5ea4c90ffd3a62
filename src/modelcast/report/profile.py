"""What ``modelcast profile`` shows: what a profile holds, and what two have not in common."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from modelcast.core.cells import Cells
from modelcast.messages.mbc_wire import profile_number
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.plain import REGISTERED, from_plain
from modelcast.models.predicted_path import carried_layout
from modelcast.models.profile import Profile
from modelcast.models.sub_models import SUB_MODELS, registered_name
from modelcast.models.wrapped import unwrapped
from modelcast.report.console_table import console_table
from modelcast.report.literal import literal

__all__ = [
    "Difference",
    "difference_table",
    "profile_differences",
    "profile_document",
    "profile_report",
]

_KEPT_APART = ("trips", "figures")
"""Keys of the training record that are told on their own."""

_LISTS = ("members", "shelf", "regimes", "added")


@dataclass(frozen=True, slots=True)
class Difference:
    """One place at which two profiles differ.

    Parameters
    ----------
    place
        Keys from the outside in, joined by dots; sub-models by their names.
    first, second
        What stands there, in few words; empty where nothing does.
    """

    place: str
    first: str
    second: str


def profile_document(profile: Profile) -> dict[str, Any]:
    """What a profile holds, as plain values.

    Parameters
    ----------
    profile
        Any profile.

    Examples
    --------
    >>> from modelcast.models.profile import people_profile
    >>> document = profile_document(people_profile())
    >>> document["bank"], [member["name"] for member in document["members"]]
    ('people', ['stop-and-go'])
    """
    sizes = SizeModel().each_update_bytes(profile.bank, profile.identify)
    members = [
        {**_sub_model(one, profile), "update_octets": int(octets)}
        for one, octets in zip(profile.bank.members, sizes, strict=True)
    ]
    regimes = () if profile.regimes is None else profile.regimes.members
    place = profile.bank.plain_place
    return {
        "bank": profile.bank.name,
        "sha256": profile.identity,
        "wire_number": f"{profile_number(profile.named_bytes):06x}",
        "start": profile.start,
        "identify": profile.identify,
        "plain_messages": None if place < 0 else profile.bank.members[place].name,
        "identification_octets": SizeModel().identification_bytes,
        "selector": profile.selector is not None,
        "costs": bool(profile.costs),
        "members": members,
        **{
            name: [_alone(one, profile) for one in found]
            for name, found in (("shelf", profile.shelf), ("regimes", regimes), ("added", profile.added))
        },
        "training": _training(profile),
    }


def profile_report(profile: Profile, name: str) -> tuple[RenderableType, ...]:
    """What a profile holds, as tables.

    Parameters
    ----------
    profile
        Any profile.
    name
        What the user calls it.
    """
    document = profile_document(profile)
    heads = ("sub-model", "kind", "where", "carried", "bits", "octets", "window", "trusted", "calibrated")
    rows: list[tuple[str, ...]] = []
    for where in _LISTS:
        for one in document[where]:
            calibrated = one["calibrated_to_s"]
            rows.append(
                (
                    *(one["name"], one["kind"], "bank" if where == "members" else where, one["carried"]),
                    *(str(one["bits"]), str(one["update_octets"]), str(one["window"])),
                    "always" if one["trusted_horizon_s"] is None else f"{one['trusted_horizon_s']:g} s",
                    "-" if calibrated is None else f"to {calibrated:g} s",
                )
            )
    table = console_table(Cells(heads, rows, 4), f"{name}: bank {document['bank']}", keys=1)
    coasted = document["plain_messages"] or "constant velocity"
    lines = [
        f"sha256 {document['sha256']}; on the air {document['wire_number']}",
        f"rules {document['start']}/{document['identify']}; plain messages are coasted by {coasted}",
        f"an identification takes {document['identification_octets']} octets",
        *_training_lines(document["training"]),
    ]
    return table, *map(literal, lines)


def profile_differences(first: Profile, second: Profile) -> tuple[Difference, ...]:
    """Where two profiles differ, in the order of their places.

    Parameters
    ----------
    first, second
        Any two profiles.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> one, other = (Profile(Bank((ConstantVelocity(spread),))) for spread in (1.0, 2.0))
    >>> [(at.place, at.first, at.second) for at in profile_differences(one, other)]
    [('members.cv.acceleration_spread_mps2', '1.0', '2.0')]
    """
    return tuple(_differences("", _named(first), _named(second)))


def difference_table(found: Sequence[Difference], names: tuple[str, str]) -> RenderableType:
    """Differences as a table, or a line that there are none.

    Parameters
    ----------
    found
        From `profile_differences`.
    names
        What the user calls the two.
    """
    if not found:
        return literal(f"{names[0]} and {names[1]} hold the same")
    table = Table(title=literal(f"{len(found)} differences"), title_justify="left")
    for column in ("place", *names):
        table.add_column(literal(column), overflow="fold")
    for one in found:
        table.add_row(*(literal(text or "-") for text in (one.place, one.first, one.second)))
    return table


def _alone(member: AbstractSubModel, profile: Profile) -> dict[str, Any]:
    """A sub-model outside the bank, with the size of its update in a bank of its own."""
    (octets,) = SizeModel().each_update_bytes(Bank((member,)), "never")
    return {**_sub_model(member, profile), "update_octets": int(octets)}


def _sub_model(member: AbstractSubModel, profile: Profile) -> dict[str, Any]:
    """What a sub-model is to whoever sends or receives it."""
    layout = carried_layout(member)
    own = member.payload_layout
    calibration = profile.calibrations.get(member.name)
    horizon_s, turn_s = member.trusted_horizon_s, member.trusted_turn_s
    return {
        "name": member.name,
        "kind": _kind(member),
        "window": member.window,
        "parameters": len(member.parameter_names),
        "carried": "as its path" if own is None else "by fields" if own.fields else "by Part I",
        "bits": layout.bits,
        "trusted_horizon_s": horizon_s if np.isfinite(horizon_s) else None,
        "trusted_turn_s": turn_s if np.isfinite(turn_s) else None,
        "calibrated_to_s": None if calibration is None else float(calibration.horizons_s[-1]),
    }


def _kind(member: AbstractSubModel) -> str:
    """The class inside all that goes round it, and the package it is from where that is another."""
    member = unwrapped(member)
    name = registered_name(type(member))
    return f"{type(member).__name__}, {SUB_MODELS.origin(name)}" if name else type(member).__name__


def _training(profile: Profile) -> dict[str, Any]:
    """The training record: its trips in short, then its settings."""
    trips: Sequence[Mapping[str, Any]] = profile.record.get("trips", ())
    formats = [str(trip.get("format", "unknown")) for trip in trips]
    figures: Mapping[str, Any] = profile.record.get("figures", {})
    return {
        "trips": len(trips),
        "fingerprints": len(profile.training_trips),
        "duration_s": float(sum(trip.get("duration_s", 0.0) for trip in trips)),
        "formats": {name: formats.count(name) for name in sorted(set(formats))},
        "counted_on": figures.get("counted_on"),
        "settings": {key: one for key, one in profile.record.items() if key not in _KEPT_APART},
        "added": dict(profile.added_record),
    }


def _training_lines(training: Mapping[str, Any]) -> list[str]:
    """The training record in a few lines."""
    if not training["trips"]:
        lines = ["no training trips are recorded"]
    else:
        formats = ", ".join(f"{count} of {name}" for name, count in training["formats"].items())
        lines = [
            f"trained on {training['trips']} trips of {training['duration_s'] / 3600.0:.2f} h: {formats}"
        ]
    if training["counted_on"] is not None:
        lines.append(f"messages counted on {training['counted_on']}")
    for name, settings in (*training["settings"].items(), *training["added"].items()):
        plain = cast("Mapping[str, Any]", settings if isinstance(settings, Mapping) else {"": settings})
        simple = {key: one for key, one in plain.items() if not isinstance(one, Mapping | list | tuple)}
        if simple:
            told = ", ".join(f"{key} {one}".strip() for key, one in simple.items())
            lines.append(f"{name}: {told}")
    return lines


def _named(profile: Profile) -> dict[str, Any]:
    """A profile's text as mappings all the way to each sub-model's fields, lists of sub-models by name."""
    document: dict[str, Any] = json.loads(profile.text)
    added = document.pop("added", {"members": [], "record": {}})
    document["added"], document["added_record"] = added["members"], added["record"]
    document["order"] = [member.name for member in profile.bank.members]
    lists = ("members", profile.bank.members), ("shelf", profile.shelf), ("added", profile.added)
    for key, models in lists:
        document[key] = dict(zip((one.name for one in models), document[key], strict=True))
    if profile.regimes is not None:
        named = zip(
            (one.name for one in profile.regimes.members), document["regimes"]["members"], strict=True
        )
        document["regimes"]["members"] = dict(named)
    return document


def _differences(place: str, first: Any, second: Any) -> list[Difference]:
    """Differences from a place on."""
    if first == second:
        return []
    if _is_branch(first) and _is_branch(second):
        one, other = cast("dict[str, Any]", first), cast("dict[str, Any]", second)
        found: list[Difference] = []
        for key in dict.fromkeys((*one, *other)):
            inner = f"{place}.{key}" if place else key
            if key in one and key in other:
                found += _differences(inner, one[key], other[key])
            else:
                found.append(Difference(inner, _told(one.get(key)), _told(other.get(key))))
        return found
    texts = _told(first), _told(second)
    if texts[0] == texts[1]:
        texts = texts[0], f"{texts[1]}, {_apart(first, second)}"
    return [Difference(place, *texts)]


def _is_branch(value: Any) -> bool:
    return isinstance(value, dict) and "float32" not in value


_MOST_TOLD = 60


def _told(value: Any) -> str:
    """A value in few words."""
    if value is None:
        return ""
    if isinstance(value, dict):
        mapping = cast("dict[str, Any]", value)
        if "float32" in mapping:
            return f"array {'x'.join(map(str, mapping['shape']))}"
        if mapping.get("is") == REGISTERED:
            return f"{mapping['name']} of {mapping['package']} {mapping['version']}"
        return str(mapping["is"]) if "is" in mapping else f"{len(mapping)} entries"
    text = json.dumps(value)
    if isinstance(value, list) and len(text) > _MOST_TOLD:
        return f"{len(cast('list[Any]', value))} entries"
    return text.strip('"') if len(text) <= _MOST_TOLD else f"{text[:_MOST_TOLD]}..."


def _apart(first: Any, second: Any) -> str:
    """How two values that are told alike differ."""
    if isinstance(first, dict):
        one, other = from_plain(first), from_plain(second)
        return f"up to {float(np.abs(one - other).max()):.3g} apart"
    if isinstance(first, list):
        one, other = cast("list[Any]", first), cast("list[Any]", second)
        return f"{sum(a != b for a, b in zip(one, other, strict=True))} of them other"
    return "other"

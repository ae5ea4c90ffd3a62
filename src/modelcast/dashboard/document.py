"""Snapshots and roads as JSON texts: whole numbers in columns, so that a thousand remotes stay small.

The tables in ``docs/node-page.md`` are the format. What is read is judged field by field: a log may come from
anybody.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.json_text import parse_json, schema_of
from modelcast.core.kinds import Kind
from modelcast.core.rules import Each, FieldError, Keys, Maybe, Number, Table, Text, Whole, check
from modelcast.core.rules.scalars import Anything
from modelcast.dashboard.snapshot import Counters, Host, Remotes, Snapshot, WarningShown

__all__ = [
    "MOST_REMOTES",
    "SCHEMA",
    "read_road",
    "read_snapshot",
    "road_text",
    "snapshot_text",
]

SCHEMA = 1
"""Of these documents."""

MOST_REMOTES = 10_000
"""Of one snapshot."""

_MOST_AHEAD = 20
_MOST_POINTS = 20_000
_FAR = 2**31
_TIME_S = Number(-1e10, 1e10)
_WHOLE = Whole(-_FAR, _FAR)
_UNSIGNED = Whole(0, 2**53)

_SCALES: Mapping[str, float] = {
    "heading_mrad": 1e3, "speed_cmps": 1e2, "angle_mrad": 1e3, "age_ms": 1e3, "silent_ms": 1e3,
    "messages": 1.0, "loss_permille": 1e3, "error_mm": 1e3,
}  # fmt: skip
_FIELDS = {
    "heading_mrad": "heading_rad", "speed_cmps": "speed_mps", "angle_mrad": "angle_rad", "age_ms": "age_s",
    "silent_ms": "silent_s", "messages": "messages", "loss_permille": "loss_ratio", "error_mm": "error_m",
}  # fmt: skip
_PLACES = ("east_cm", "north_cm", "major_cm", "minor_cm")

_HOST = Keys(
    {
        "id": Whole(0, 2**32 - 1),
        "east_cm": _WHOLE,
        "north_cm": _WHOLE,
        "heading_mrad": Maybe(_WHOLE),
        "speed_cmps": Maybe(_WHOLE),
        "inputs": Text(80, empty=True),
    }
)
_WARNING = Keys({"level": Whole(1, 2), "kind": Text(40), "id": Whole(0, 2**32 - 1), "begun_s": _TIME_S})
_RATE, _SHARE = Maybe(Number(0.0, 1e12)), Maybe(Number(0.0, 1.0))
_COUNTERS = Keys(
    {
        "sent_per_s": _RATE,
        "received_per_s": _RATE,
        "sent_bytes_per_s": _RATE,
        "received_bytes_per_s": _RATE,
        "loss_ratio": _SHARE,
        "channel_busy_ratio": _SHARE,
        "rejected": Table(_UNSIGNED, 32),
    }
)
_REMOTES = Keys(
    {
        "ahead_ms": Each(Whole(1, 60_000), 0, _MOST_AHEAD),
        "names": Each(Text(80), 0, 256),
        **dict.fromkeys(("id", "model", "path_cm", *_PLACES, *_SCALES), Each(Anything(), 0, MOST_REMOTES)),
    },
    {"kind": Each(Anything(), 0, MOST_REMOTES)},
)
_SNAPSHOT = Keys(
    {
        "kind": Text(20),
        "t_s": _TIME_S,
        "schema": _UNSIGNED,
        "host": Maybe(_HOST),
        "remotes": _REMOTES,
        "warnings": Each(_WARNING, 0, 1000),
        "counters": _COUNTERS,
    }
)
_ROAD = Keys(
    {
        "kind": Text(20),
        "schema": _UNSIGNED,
        "lines_dm": Each(Each(_WHOLE, 4, 2 * _MOST_POINTS), 0, _MOST_POINTS),
    }
)


def snapshot_text(snapshot: Snapshot) -> str:
    """One line of JSON; it begins with its kind and its time.

    Parameters
    ----------
    snapshot
        What is shown.
    """
    remotes, host, counters = snapshot.remotes, snapshot.host, snapshot.counters
    offsets = np.nan_to_num((remotes.path_m - remotes.position_m[:, None]) * 100.0)
    document = {
        "kind": "snapshot",
        "t_s": round(snapshot.t_s, 3),
        "schema": SCHEMA,
        "host": None
        if host is None
        else {
            "id": host.temporary_id,
            "east_cm": round(host.position_m[0] * 100.0),
            "north_cm": round(host.position_m[1] * 100.0),
            "heading_mrad": _whole(host.heading_rad * 1e3),
            "speed_cmps": _whole(host.speed_mps * 1e2),
            "inputs": host.inputs,
        },
        "remotes": {
            "ahead_ms": np.rint(remotes.ahead_s * 1e3).astype(np.int64).tolist(),
            "names": list(remotes.names),
            "id": remotes.vehicle.tolist(),
            "model": remotes.model.tolist(),
            "east_cm": _rounded(remotes.position_m[:, 0] * 100.0),
            "north_cm": _rounded(remotes.position_m[:, 1] * 100.0),
            "major_cm": _rounded(remotes.semi_axes_m[:, 0] * 100.0),
            "minor_cm": _rounded(remotes.semi_axes_m[:, 1] * 100.0),
            "path_cm": _rounded(offsets),
            **{key: _rounded(getattr(remotes, _FIELDS[key]) * scale) for key, scale in _SCALES.items()},
            **({} if remotes.kind is None else {"kind": remotes.kind.tolist()}),
        },
        "warnings": [
            {"level": one.level, "kind": one.kind, "id": one.vehicle, "begun_s": round(one.begun_s, 3)}
            for one in snapshot.warnings
        ],
        "counters": {
            "sent_per_s": _short(counters.sent_per_s),
            "received_per_s": _short(counters.received_per_s),
            "sent_bytes_per_s": _short(counters.sent_bytes_per_s),
            "received_bytes_per_s": _short(counters.received_bytes_per_s),
            "loss_ratio": _short(counters.loss_ratio),
            "channel_busy_ratio": _short(counters.channel_busy_ratio),
            "rejected": dict(counters.rejected),
        },
    }
    return json.dumps(document, separators=(",", ":"), allow_nan=False)


def read_snapshot(text: str) -> Snapshot:
    """The snapshot that a text describes.

    Parameters
    ----------
    text
        As `snapshot_text` wrote it, or anything.

    Raises
    ------
    ValueError
        Where it is none; a `FieldError` says where.
    """
    document = _document(text, "snapshot", _SNAPSHOT)
    host, counters = document["host"], document["counters"]
    return Snapshot(
        float(document["t_s"]),
        None
        if host is None
        else Host(
            host["id"],
            (host["east_cm"] / 100.0, host["north_cm"] / 100.0),
            heading_rad=_known(host["heading_mrad"]) / 1e3,
            speed_mps=_known(host["speed_cmps"]) / 1e2,
            inputs=host["inputs"],
        ),
        remotes=_read_remotes(document["remotes"]),
        warnings=tuple(
            WarningShown(one["level"], one["kind"], one["id"], float(one["begun_s"]))
            for one in document["warnings"]
        ),
        counters=Counters(
            **{key: _known(value) for key, value in counters.items() if key != "rejected"},
            rejected=counters["rejected"],
        ),
    )


def road_text(lines_m: Sequence[FloatArray]) -> str:
    """A road as one line of JSON.

    Parameters
    ----------
    lines_m
        Ways that were seen to be driven, east and north, (P, 2) each [m].
    """
    lines = [_rounded(line.reshape(-1) * 10.0) for line in lines_m]
    return json.dumps({"kind": "road", "schema": SCHEMA, "lines_dm": lines}, separators=(",", ":"))


def read_road(text: str) -> list[FloatArray]:
    """The ways that a text describes, (P, 2) each [m].

    Parameters
    ----------
    text
        As `road_text` wrote it, or anything.

    Raises
    ------
    ValueError
        Where it is none; a `FieldError` says where.
    """
    lines: list[list[int]] = _document(text, "road", _ROAD)["lines_dm"]
    for at, line in enumerate(lines):
        if len(line) % 2:
            raise FieldError(f"$.lines_dm[{at}]", len(line), "as many eastings as northings")
    return [np.array(line, dtype=np.float64).reshape(-1, 2) / 10.0 for line in lines]


def _document(text: str, kind: str, rule: Keys) -> dict[str, Any]:
    document = parse_json(text)
    schema_of(document, SCHEMA)
    check(document, rule)
    if document["kind"] != kind:
        raise FieldError("$.kind", document["kind"], f"'{kind}'")
    return cast("dict[str, Any]", document)


def _read_remotes(given: dict[str, Any]) -> Remotes:
    ids, paths = cast("list[Any]", given["id"]), cast("list[Any]", given["path_cm"])
    count = len(ids)
    ahead_s = np.array(given["ahead_ms"], dtype=np.float64) / 1e3
    if len(paths) != count:
        raise FieldError("$.remotes.path_cm", len(paths), f"{count} paths, one an id")
    if (np.diff(ahead_s) <= 0.0).any():
        raise FieldError("$.remotes.ahead_ms", given["ahead_ms"], "rising times")
    vehicle = _read_column(given, "id", count, low=0, high=2**32 - 1).astype(np.int64)
    if np.unique(vehicle).size != count:
        raise FieldError("$.remotes.id", "an id", "ids that stand once")
    model = _read_column(given, "model", count, low=0, high=len(given["names"]) - 1).astype(np.int64)
    places = {
        key: _read_column(given, key, count, low=0 if key in _PLACES[2:] else -_FAR) / 100.0
        for key in _PLACES
    }
    position_m = np.stack([places["east_cm"], places["north_cm"]], axis=1)
    others = {
        _FIELDS[key]: _read_column(given, key, count, optional=True) / scale for key, scale in _SCALES.items()
    }
    kind = None
    if "kind" in given:
        kind = _read_column(given, "kind", count, low=min(Kind), high=max(Kind)).astype(np.int64)
    for at, path in enumerate(paths):
        check(path, Each(Each(_WHOLE, 2, 2), ahead_s.size, ahead_s.size), f"$.remotes.path_cm[{at}]")
    offsets = np.array(paths, dtype=np.float64).reshape(count, ahead_s.size, 2) / 100.0
    return Remotes(
        vehicle,
        position_m,
        semi_axes_m=np.stack([places["major_cm"], places["minor_cm"]], axis=1),
        ahead_s=ahead_s,
        path_m=position_m[:, None] + offsets,
        names=tuple(given["names"]),
        model=model,
        kind=kind,
        **others,
    )


def _read_column(
    given: Mapping[str, Any],
    key: str,
    count: int,
    *,
    low: int = -_FAR,
    high: int = _FAR,
    optional: bool = False,
) -> FloatArray:
    column: list[int | None] = given[key]
    rule = Whole(low, high)
    check(column, Each(Maybe(rule) if optional else rule, count, count), f"$.remotes.{key}")
    return np.array([np.nan if one is None else one for one in column], dtype=np.float64)


def _rounded(values: FloatArray) -> list[Any]:
    """Whole numbers within the format's bounds, None where there is none."""
    missing = np.isnan(values)
    whole = np.clip(np.rint(np.where(missing, 0.0, values)), -_FAR, _FAR).astype(np.int64)
    if not missing.any():
        return whole.tolist()
    found = whole.astype(object)
    found[missing] = None
    return found.tolist()


def _whole(value: float) -> int | None:
    return round(value) if np.isfinite(value) else None


def _short(value: float) -> float | None:
    return round(float(value), 3) if np.isfinite(value) else None


def _known(value: float | None) -> float:
    return np.nan if value is None else float(value)

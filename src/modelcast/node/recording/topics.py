"""Topics of a recording, each with the JSON schema that other programs are told (docs/recording.md).

``foxglove.LocationFix`` and ``foxglove.GeoJSON`` are schemas that Foxglove draws by their names, with
the fields that its documentation lists.
"""

import json
from dataclasses import dataclass
from typing import Any

__all__ = [
    "ABOUT",
    "BELIEFS",
    "HEARD",
    "LOCATION",
    "PAGE",
    "REMOTES",
    "SAMPLES",
    "SENT",
    "STEP",
    "TOPICS",
    "Topic",
]

_NUMBER: dict[str, Any] = {"type": ["number", "string", "null"]}
_PLAIN, _WHOLE, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_BASE64 = {"type": "string", "contentEncoding": "base64"}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _object(**properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


@dataclass(frozen=True, slots=True)
class Topic:
    """One kind of message in a recording.

    Parameters
    ----------
    name
        As other programs list it.
    schema
        Name of its schema.
    document
        The schema, JSON of a JSON Schema.
    """

    name: str
    schema: str
    document: str


def _topic(name: str, title: str, /, **properties: dict[str, Any]) -> Topic:
    return Topic(name, title, json.dumps({"title": title, **_object(**properties)}))


ABOUT = _topic(
    "/about",
    "modelcast.About",
    schema=_WHOLE,
    version=_TEXT,
    policy=_TEXT,
    profile=_WHOLE,
    utc_at_zero_s=_PLAIN,
    origin=_list(_PLAIN),
    names_seed=_TEXT,
    station_seed=_TEXT,
    config=_list(_TEXT),
)
SAMPLES = _topic("/samples", "modelcast.Samples", now_s=_PLAIN, samples=_list({"type": "object"}))
STEP = _topic(
    "/step",
    "modelcast.Step",
    t_s=_PLAIN,
    temporary_id=_WHOLE,
    motion={
        "type": ["object", "null"],
        "properties": {
            "mode": _TEXT, "speed_mps": _NUMBER, "heading_rad": _NUMBER, "acceleration_mps2": _NUMBER,
            "yaw_rate_radps": _NUMBER, "position_m": _list(_NUMBER),
            "place_deg": _list(_NUMBER), "age_s": _NUMBER,
        },
    },
    warnings=_list({"type": "object"}),
)  # fmt: skip
BELIEFS = _topic(
    "/beliefs",
    "modelcast.Beliefs",
    t_s=_PLAIN,
    remotes=_WHOLE,
    columns={"type": "object", "additionalProperties": _BASE64},
)
HEARD = _topic(
    "/heard",
    "modelcast.Heard",
    call=_WHOLE,
    now_s=_PLAIN,
    received_s=_PLAIN,
    outcome=_TEXT,
    octets=_BASE64,
)
SENT = _topic("/sent", "modelcast.Sent", now_s=_PLAIN, message=_BASE64, octets=_BASE64)
PAGE = _topic("/page", "modelcast.Snapshot", t_s=_PLAIN, remotes={"type": "object"})
LOCATION = _topic(
    "/location",
    "foxglove.LocationFix",
    timestamp=_object(sec=_WHOLE, nsec=_WHOLE),
    frame_id=_TEXT,
    latitude=_PLAIN,
    longitude=_PLAIN,
    altitude=_PLAIN,
    position_covariance=_list(_PLAIN),
    position_covariance_type=_WHOLE,
)
REMOTES = _topic("/remotes", "foxglove.GeoJSON", geojson=_TEXT)

TOPICS = (ABOUT, SAMPLES, STEP, BELIEFS, HEARD, SENT, PAGE, LOCATION, REMOTES)
"""All of them."""

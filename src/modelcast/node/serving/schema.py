"""The messages of the step protocol, as `step_protocol.toml` describes them: to octets, and checked back."""

import importlib.resources
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from math import prod
from typing import Any, Literal, cast

import numpy as np

from modelcast.core.exceptions import MissingExtraError
from modelcast.runtime.external.exchange import MOST_APPLICATIONS
from modelcast.runtime.external.refusal import FieldError

try:
    import msgpack
except ModuleNotFoundError as error:
    raise MissingExtraError("the step protocol", "node") from error

__all__ = ["Field", "FrameError", "MessageType", "Schema", "named_values", "step_protocol"]

_ARRAY = re.compile(r"([uif][148])\[([A-Z])((?:,[0-9])*)\]")
_MOST_KEYS, _MOST_TEXTS, _MOST_TEXT_BYTES = 64, MOST_APPLICATIONS, 4096
_SHOWN_OF_KEY = 32
_PLAIN: dict[str, type[Any]] = {
    "integer": int,
    "number": float,
    "text": str,
    "flag": bool,
    "octets": bytes,
    "texts": list,
}


class FrameError(ValueError):
    """Octets that are no message at all."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Parameters
    ----------
    name, type, text
        As in the file.
    unit
        Empty for none.
    optional
        Whether it may be left out.
    default
        What it is then; None for nothing.
    """

    name: str
    type: str
    text: str
    unit: str = ""
    optional: bool = False
    default: Any = None

    @property
    def may_lack(self) -> bool:
        """Whether a message without it is one."""
        return self.optional or self.default is not None

    def array(self) -> tuple[np.dtype[Any], str, tuple[int, ...]] | None:
        """Numbers, letter of the length and shape of a row of an array; None where it is none."""
        found = _ARRAY.fullmatch(self.type)
        if found is None:
            return None
        row = tuple(int(one) for one in found[3].split(",") if one)
        return np.dtype(f"<{found[1]}"), found[2], row

    def wire(self, value: Any) -> Any:
        """The value as it travels.

        Parameters
        ----------
        value
            An array for an array.

        Raises
        ------
        FieldError
            Where a whole number has no place in the field's numbers.
        """
        own = self.array()
        if own is None:
            return value
        given = np.asarray(value)
        if own[0].kind in "iu" and given.size:
            bounds = np.iinfo(own[0])
            outside = (given < bounds.min) | (given > bounds.max)
            if outside.any():
                raise FieldError(
                    self.name, repr(given[outside].flat[0].item()), f"within {bounds.min} to {bounds.max}"
                )
        return np.ascontiguousarray(given, dtype=own[0]).tobytes()

    def read(self, value: Any, lengths: dict[str, int]) -> Any:
        """The value as it came, or say what is wrong with it.

        Parameters
        ----------
        value
            Of a message.
        lengths
            Lengths by letter as known so far; a new one is entered.

        Raises
        ------
        FieldError
            Where it has another type or length.
        """
        own = self.array()
        if own is None:
            return self._read_plain(value)
        dtype, letter, row = own
        each = dtype.itemsize * prod(row)
        if not isinstance(value, bytes) or len(value) % each:
            raise FieldError(
                self.name, _described(value), f"{self.type}: a binary whose octets are a multiple of {each}"
            )
        count = len(value) // each
        wanted = lengths.setdefault(letter, count)
        if count != wanted:
            raise FieldError(self.name, f"{count} rows", f"{wanted} rows, as the others of {letter}")
        return np.frombuffer(value, dtype=dtype).reshape(-1, *row)

    def _read_plain(self, value: Any) -> Any:
        kind = _PLAIN[self.type]
        if kind is float and type(value) is int and abs(value) < 2**53:
            return float(value)
        if type(value) is not kind or (kind is list and not _are_texts(value)):
            raise FieldError(self.name, _described(value), f"a field of type {self.type}")
        return value


@dataclass(frozen=True, slots=True)
class MessageType:
    """One message of the protocol.

    Parameters
    ----------
    name, text
        As in the file.
    origin
        Who sends it.
    fields
        By name, in order.
    answer
        Name of the message that answers it; empty for an answer.
    """

    name: str
    text: str
    origin: Literal["client", "server"]
    fields: Mapping[str, Field]
    answer: str = ""


@dataclass(frozen=True, slots=True)
class Schema:
    """All messages of one version of the protocol.

    Parameters
    ----------
    protocol
        The version.
    frame_bytes
        Longest message.
    messages
        By name.
    """

    protocol: int
    frame_bytes: int
    messages: Mapping[str, MessageType]

    def pack(self, name: str, values: Mapping[str, Any]) -> bytes:
        """A message as octets, without the length before it; a value of None is left out.

        Parameters
        ----------
        name
            Of the message.
        values
            Of its fields.
        """
        known = self.messages[name].fields
        given = {key: known[key].wire(value) for key, value in values.items() if value is not None}
        return cast("bytes", msgpack.packb({"type": name, **given}))

    def unpack(self, octets: bytes, origin: Literal["client", "server"]) -> tuple[str, dict[str, Any]]:
        """The name and the fields of a message; arrays are views of the octets.

        Parameters
        ----------
        octets
            Whatever came.
        origin
            Who sent it.

        Raises
        ------
        FrameError
            Where it is no map of MessagePack.
        FieldError
            Where there is no such message, or a field is missing, unknown or not what it must be.
        """
        found = _opened(octets, self.frame_bytes)
        name = found.pop("type", None)
        known = [one.name for one in self.messages.values() if one.origin == origin]
        if not isinstance(name, str) or name not in known:
            raise FieldError("type", _described(name), f"one of {', '.join(known)}")
        own = self.messages[name].fields
        for key in sorted(found.keys() - own.keys()):
            raise FieldError(key[:_SHOWN_OF_KEY], "a field", f"left out: {name} has none of that name")
        lengths: dict[str, int] = {}
        values: dict[str, Any] = {}
        for key, field in own.items():
            if key in found:
                values[key] = field.read(found[key], lengths)
            elif not field.may_lack:
                raise FieldError(key, "nothing", f"there: {name} needs it, {field.type}")
            elif field.default is not None:
                values[key] = field.default
        return name, values


def _opened(octets: bytes, frame_bytes: int) -> dict[str, Any]:
    """The map that octets hold."""
    if len(octets) > frame_bytes:
        raise FrameError(f"a frame of {len(octets)} octets: at most {frame_bytes}")
    try:
        found = cast(
            "Any",
            msgpack.unpackb(
                octets,
                object_pairs_hook=_once_each,
                max_map_len=_MOST_KEYS,
                max_array_len=_MOST_TEXTS,
                max_str_len=_MOST_TEXT_BYTES,
                max_ext_len=0,
            ),
        )
    except (ValueError, msgpack.UnpackException) as error:
        raise FrameError(f"no map of MessagePack: {error or type(error).__name__}") from error
    if not isinstance(found, dict):
        raise FrameError(f"no map of MessagePack, but {_described(found)}")
    return cast("dict[str, Any]", found)


def _once_each(pairs: Sequence[tuple[Any, Any]]) -> dict[str, Any]:
    """A map whose keys are texts, each there once."""
    found = dict(pairs)
    if len(found) != len(pairs) or not all(isinstance(key, str) for key in found):
        raise ValueError("keys are texts, each once")
    return found


def _are_texts(values: Any) -> bool:
    return all(type(one) is str for one in values)


def _described(value: Any) -> str:
    """A value in few words, however large."""
    if isinstance(value, bytes):
        return f"a binary of {len(value)} octets"
    if isinstance(value, (list, dict)):
        return f"a {'list' if isinstance(value, list) else 'map'} of {len(value)}"  # type: ignore[arg-type]
    return "nothing" if value is None else repr(value)


def named_values(record: Any) -> dict[str, Any]:
    """The fields of a dataclass by name, none copied.

    Parameters
    ----------
    record
        Of `modelcast.runtime.external.exchange`.
    """
    return {one.name: getattr(record, one.name) for one in fields(record)}


@lru_cache(maxsize=1)
def step_protocol() -> Schema:
    """The protocol as this version of modelcast speaks it.

    Examples
    --------
    >>> spoken = step_protocol()
    >>> octets = spoken.pack("map", {"t_s": 1.0, "host": np.array([3, 8])})
    >>> name, values = spoken.unpack(octets, "client")
    >>> name, values["t_s"], values["host"].tolist()
    ('map', 1.0, [3, 8])
    """
    text = (importlib.resources.files("modelcast.node.serving") / "step_protocol.toml").read_text("utf-8")
    document = tomllib.loads(text)
    return Schema(
        document["protocol"],
        document["frame_bytes"],
        {
            one["name"]: MessageType(
                one["name"],
                one["text"],
                one["from"],
                {field["name"]: Field(**field) for field in one["fields"]},
                one.get("answer", ""),
            )
            for one in document["message"]
        },
    )

"""Basic safety messages as the operational data environment (jpo-ode) writes them: ``OdeBsmJson``.

JSON objects, one a line, with line breaks inside, or in an array. A trip is a sender's temporary id,
``<stem>/<id>``; who changes the id becomes two trips, and nothing was verified. ``coreData`` stands in
``payload.data``, or in ``payload.data.value.BasicSafetyMessage`` (also below ``MessageFrame``), in one of two
forms. Numbers may be texts.

=================================  ==========================  ==============================================
Converted, J2735 2016 on           As on the air, whole        Use
                                   numbers
=================================  ==========================  ==============================================
id                                 id                          the trip
secMark [ms]                       the same                    time in the minute
position.latitude, .longitude      lat, long [1e-7 deg]        position
  [deg]
position.elevation [m]             elev [0.1 m]                height
speed [m/s]                        speed [0.02 m/s]            speed
heading [deg]                      heading [0.0125 deg]        heading, clockwise from north
accelSet.accelLong [m/s²]          accelSet.long [0.01 m/s²]   acceleration
accelSet.accelYaw [deg/s]          accelSet.yaw [0.01 deg/s]   yaw rate, clockwise positive
=================================  ==========================  ==============================================

``metadata`` has the rest of the time: ``recordGeneratedAt``, where it is blank ``odeReceivedAt``. A message
is of the instant next to it that has its place in the minute; where it was logged over half a minute later,
as in files that were sent on in one piece without ``recordGeneratedAt``, that is another minute. Time is Unix
time where the stamps are of UTC; stamps without a zone, or with one by name (Tampa's ``[ET]``), give no
absolute time. Which vehicle logged a message (``bsmSource``) is not used: one that several heard is in the
trip once.

Skipped and counted: "time missing" (no mark, as 65535, or no stamp), "position unavailable" (as 90.0000001,
180.0000001, or 0, 0), "duplicate time" (the first is kept), a cut last object ("partial last line").
Repaired and counted: "out of time order"; unavailable values (null, left out, the standard's code for it, or
none that a message can carry, as a heading of 450), held or left out as `rows` says. Other messages (TIM,
SPaT, MAP) are told with their number under the name of the file.

References
----------
github.com/usdot-jpo-ode/jpo-ode: schema-bsm.json, the samples under data, and what is made of the standard's
codes (plugin j2735, builders). SAE J2735, DF_BSMcoreData.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, cast

from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import is_clean, shown
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.bsm_trips import AbstractBsmLog, BsmRow, bsm_trips
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.json_records import JsonRecords
from modelcast.io.log_stamps import LogClock
from modelcast.io.packed import recording_stem
from modelcast.io.rows import LARGEST
from modelcast.trips.trajectory import Trajectory

__all__ = ["OdeBsmReader"]

_STAMPS = ("recordGeneratedAt", "odeReceivedAt")
_CONVERTED = (
    ("position", "latitude"), ("position", "longitude"), ("position", "elevation"),
    ("", "speed"), ("", "heading"), ("accelSet", "accelLong"), ("accelSet", "accelYaw"),
)  # fmt: skip
_CODES = (
    ("", "lat"), ("", "long"), ("", "elev"),
    ("", "speed"), ("", "heading"), ("accelSet", "long"), ("accelSet", "yaw"),
)  # fmt: skip
"""Where the values of `CORE_COLUMNS` stand in the two forms of the core data."""

_LONGEST_NAME = 64
_MOST_KINDS = 16
"""J2735 has about as many kinds of messages."""

_REMEDY = "Rows count the objects of the file; correct or remove this one."


@dataclass(frozen=True, slots=True)
class OdeBsmReader(AbstractHoldingReader):
    """Reads OdeBsmJson; the module's docstring has the fields and the repairs."""

    name: ClassVar[str] = "ode-bsm"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is JSON that begins with a message and what the environment says of it."""
        del path
        start = head.removeprefix(b"\xef\xbb\xbf").lstrip()
        words = (b'"metadata"', b'"payload"', b'"coreData"')
        return start.startswith((b"{", b"[")) and all(word in head for word in words)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per temporary id, in the order in which they appear."""
        log = _OdeLog(path)
        yield from bsm_trips(log, self.name, on_skipped, self.held_bytes)
        tally = Tally()
        for kind, count in log.others.items():
            tally.skip(f"of another kind ({kind})", count)
        if log.others:
            on_skipped(recording_stem(path), tally.why_empty())


@dataclass(slots=True)
class _OdeLog(AbstractBsmLog):
    """The messages of a file; `others` counts those that are none, by what they say they are."""

    path: str
    clock: LogClock = field(default_factory=LogClock)
    others: Counter[str] = field(default_factory=Counter[str])
    _cut: bool = False

    @property
    def cut(self) -> bool:
        """As the objects."""
        return self._cut

    @property
    def utc(self) -> bool:
        """As the stamps."""
        return bool(self.clock.utc)

    def messages(self, *, numbers: bool) -> Iterator[BsmRow]:
        """Yield the basic safety messages."""
        self.others.clear()
        records = JsonRecords(self.path)
        for number, record in enumerate(records.objects(), start=1):
            metadata, payload = (self._part(number, record, name) for name in ("metadata", "payload"))
            core = _core_of(payload)
            if core is None:
                kind = str(payload.get("dataType", "unnamed")).rpartition(".")[2]
                if "bsm" in kind.lower():
                    raise self._wrong(number, "a basic safety message has no coreData")
                self.others[kind if self._is_name(kind) else "unnamed"] += 1
                continue
            yield self._row(number, metadata, core, numbers=numbers)
        self._cut = records.cut

    def _is_name(self, kind: str) -> bool:
        """Whether a kind of message can be told by its own word."""
        known = kind in self.others or len(self.others) < _MOST_KINDS
        return known and is_clean(kind) and len(kind) <= _LONGEST_NAME

    def _row(
        self, number: int, metadata: Mapping[str, Any], core: Mapping[str, Any], *, numbers: bool
    ) -> BsmRow:
        sender = core.get("id")
        if not isinstance(sender, str) or not 0 < len(sender) <= _LONGEST_NAME or not is_clean(sender):
            raise self._wrong(number, f"id is {shown(sender)}, not a name")
        if not numbers:
            return BsmRow(number, sender, 0.0, 0.0, False, ())
        try:
            stamp_ms = self.clock.first_of(_texts(metadata))
        except ValueError as error:
            raise self._wrong(number, f"the time of the message is {error}") from error
        codes = "position" not in core
        values = tuple(
            self._number(number, core if not inside else core.get(inside), name)
            for inside, name in (_CODES if codes else _CONVERTED)
        )
        return BsmRow(number, sender, stamp_ms, self._number(number, core, "secMark"), codes, values)

    def _part(self, number: int, record: Mapping[str, Any], name: str) -> Mapping[str, Any]:
        part = record.get(name)
        if not isinstance(part, dict):
            raise self._wrong(number, f"has no {name}, as every message of the environment has")
        return cast("dict[str, Any]", part)

    def _number(self, number: int, holder: object, name: str) -> float:
        """Return a member as a number, NaN where it is left out, null or blank."""
        if holder is None:
            return float("nan")
        if not isinstance(holder, dict):
            raise self._wrong(number, f"{name} should stand in an object, not in {shown(holder)}")
        given: object = cast("dict[str, object]", holder).get(name)
        value = given
        if isinstance(value, str):
            try:
                value = float(value) if value.strip() else None
            except ValueError:
                value = True
        if value is None:
            return float("nan")
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
            raise self._wrong(number, f"{name} is {shown(given)}, not a finite number")
        return float(value)

    def _wrong(self, number: int, problem: str) -> DataFormatError:
        return DataFormatError(self.path, problem, row=number, remedy=_REMEDY)


def _texts(metadata: Mapping[str, Any]) -> Iterator[str | None]:
    """Yield the stamps of a message, the best first."""
    for name in _STAMPS:
        given: object = metadata.get(name)
        if given is not None and not isinstance(given, str):
            raise ValueError(f"{shown(given)}: no text")
        yield given


def _core_of(payload: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the core data of a payload, None where it has none."""
    inner: object = payload.get("data")
    for name in ("MessageFrame", "value", "BasicSafetyMessage"):
        if isinstance(inner, dict) and name in inner:
            inner = cast("dict[str, object]", inner)[name]
    core = cast("dict[str, object]", inner).get("coreData") if isinstance(inner, dict) else None
    return cast("dict[str, Any]", core) if isinstance(core, dict) else None

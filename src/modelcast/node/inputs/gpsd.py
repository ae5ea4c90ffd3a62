"""Fixes from gpsd by its JSON socket: a client of its own, since what ships with gpsd waits and queues.

==========  =========================================  ==================================================
Report      Attribute                                  Use
==========  =========================================  ==================================================
TPV         mode                                       below 2 is no fix
            time                                       UTC of the fix
            lat, lon [deg], altHAE [m]                 place
            speed [m/s], track [deg]                   motion over ground
            epx, epy, else eph [m]                     error ellipse, taken as 95 % limits
            device                                     one is listened to, until it is silent for 2 s
SKY         uSat, hdop                                 shown; it may come before or after a TPV
VERSION     release                                    shown; also the answer that proves the peer alive
DEVICES     devices                                    shown
==========  =========================================  ==================================================

Where gpsd states no error, the ellipse is unavailable (NaN): a message says so, and
`modelcast.node.inputs.motion` reckons with its stated default. Each TPV is read when it comes and replaces
what waits beyond 32, so minutes of backlog cannot build up; one that is old by its own time is refused
where fixes are judged.

References
----------
gpsd_json(5), protocol 3: every response is one object with a "class" and ends with a line end; the order of
attributes and of reports says nothing. gpsd's hacking guide: drivers report errors as 95 % limits.
"""

import math
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any, cast, final

from modelcast.core.json_text import parse_json
from modelcast.node.inputs.base import AbstractSource, Mailbox
from modelcast.node.inputs.line_stream import LineStream, StreamRules, tcp
from modelcast.node.inputs.samples import GnssFix, Sample, measured_at

__all__ = ["GpsdSource", "read_report", "read_tpv"]

_WATCH = b'?WATCH={"enable":true,"json":true};\n'
_ASK = b"?VERSION;\n"
_AXIS_95 = 1.959964
"""Standard deviations within which 95 % of a normal error on one axis lie."""
_PLANE_95 = 2.447747
"""The same of the distance on a plane: the root of 2 ln 20."""
_MOST_WAITING = 32
_SWITCH_S = 2.0
_LARGEST_M = 1e5


@final
class GpsdSource(AbstractSource):
    """A gpsd, watched.

    Parameters
    ----------
    host, port
        Where it listens.
    now_s
        The node's clock [s].
    utc_at_zero_s
        UTC at its 0 [s].
    rules
        How the connection is kept; the default gives up after 2 s of silence, asks after 1 s, and is back
        0.5 s after gpsd is.
    """

    def __init__(
        self,
        host: str,
        port: int,
        *,
        now_s: Callable[[], float],
        utc_at_zero_s: float,
        rules: StreamRules | None = None,
    ) -> None:
        self._now_s = now_s
        self._utc_at_zero_s = utc_at_zero_s
        self._box = Mailbox(most=_MOST_WAITING)
        self._device: tuple[str, float] = ("", -math.inf)
        kept = StreamRules(hello=_WATCH, ping=_ASK) if rules is None else rules
        self._stream = LineStream(tcp(host, port), self.hear, self._box, kept)
        self.release = ""
        """What gpsd calls its version."""
        self.satellites: int | None = None
        """Used for the newest fix, where it says."""
        self.newest_utc: tuple[float, float] | None = None
        """When the newest dated report came, and the UTC it says [s], for whoever steers a clock."""

    async def start(self) -> None:
        """Begin to watch."""
        await self._stream.start()

    async def stop(self) -> None:
        """Leave."""
        await self._stream.stop()

    def take(self, now_s: float) -> list[Sample]:
        """Fixes since the last call."""
        return self._box.take(now_s)

    def counts(self) -> Mapping[str, int]:
        """Fixes, connections, reports by class, and what was passed over by reason."""
        return self._box.counts()

    def hear(self, line: bytes) -> None:
        """Take in a line of gpsd's.

        Parameters
        ----------
        line
            Without its end.

        Raises
        ------
        ValueError
            Where it is no report of gpsd's.
        """
        report = read_report(line)
        kind = report["class"]
        if kind == "TPV":
            self._hear_fix(report)
        elif kind == "SKY":
            used = report.get("uSat")
            self.satellites = used if type(used) is int else None
            self._box.count("SKY")
        elif kind == "VERSION":
            self.release = str(report.get("release", ""))[:40]
            self._box.count("VERSION")
        else:
            self._box.count(kind if kind in {"DEVICES", "DEVICE", "WATCH", "ERROR"} else "other report")

    def _hear_fix(self, report: Mapping[str, Any]) -> None:
        received_s, utc_s = self._now_s(), _utc_s(report)
        if math.isfinite(utc_s):
            self.newest_utc = (received_s, utc_s)
        try:
            measured_s = measured_at(received_s, utc_s, self._utc_at_zero_s)
        except ValueError:
            self._box.count("ahead")
            return
        fix = read_tpv(report, received_s=received_s, measured_s=measured_s)
        if fix is None:
            self._box.count("no fix")
            return
        device, heard_s = self._device
        named = str(report.get("device", ""))
        if named != device and received_s - heard_s < _SWITCH_S:
            self._box.count("other device")
            return
        self._device = (named, received_s)
        self._box.put([fix])


def read_report(line: bytes) -> dict[str, Any]:
    """A report as a mapping with a text "class".

    Parameters
    ----------
    line
        What gpsd sent.

    Raises
    ------
    ValueError
        Where it is none.

    Examples
    --------
    >>> read_report(b'{"class":"VERSION","release":"3.22"}')["release"]
    '3.22'
    """
    value: object = parse_json(line.decode("utf-8"))
    if not isinstance(value, dict) or not isinstance(cast("dict[str, Any]", value).get("class"), str):
        raise ValueError("a report is an object with a text 'class'")  # noqa: TRY004 - text of a peer, no argument
    return cast("dict[str, Any]", value)


def read_tpv(report: Mapping[str, Any], *, received_s: float, measured_s: float) -> GnssFix | None:
    """The fix of a TPV report, None where it has none.

    Parameters
    ----------
    report
        The report.
    received_s, measured_s
        When it came, and when it was measured [s].

    Raises
    ------
    ValueError
        Where an attribute is not what it should be.

    Examples
    --------
    >>> report = {"class": "TPV", "mode": 3, "lat": 42.0, "lon": -83.0, "epx": 9.8, "epy": 19.6}
    >>> fix = read_tpv(report, received_s=1.0, measured_s=0.9)
    >>> round(fix.semi_major_m, 1), round(fix.semi_minor_m, 1), fix.ellipse_orientation_rad
    (10.0, 5.0, 0.0)
    >>> read_tpv(report | {"mode": 1}, received_s=1.0, measured_s=0.9) is None
    True
    """
    mode = report.get("mode", 0)
    if type(mode) is not int:
        raise ValueError(f"mode must be a whole number, got {mode!r}")
    latitude, longitude = _number(report, "lat"), _number(report, "lon")
    if mode < 2 or not math.isfinite(latitude + longitude):
        return None
    major_m, minor_m, orientation_rad = _ellipse(report)
    speed_mps = _number(report, "speed")
    return GnssFix(
        received_s=received_s,
        measured_s=measured_s,
        latitude_deg=latitude,
        longitude_deg=longitude,
        utc_s=_utc_s(report),
        altitude_m=_number(report, "altHAE"),
        speed_mps=speed_mps if 0.0 <= speed_mps <= 1000.0 else math.nan,
        heading_rad=math.radians(_number(report, "track")),
        semi_major_m=major_m,
        semi_minor_m=minor_m,
        ellipse_orientation_rad=orientation_rad,
    )


def _ellipse(report: Mapping[str, Any]) -> tuple[float, float, float]:
    """Longer and shorter axis [m] and orientation [rad] of one standard deviation, NaN where not stated."""
    east_m, north_m = _number(report, "epx") / _AXIS_95, _number(report, "epy") / _AXIS_95
    if 0.0 < east_m < _LARGEST_M and 0.0 < north_m < _LARGEST_M:
        return (north_m, east_m, 0.0) if north_m >= east_m else (east_m, north_m, math.pi / 2.0)
    round_m = _number(report, "eph") / _PLANE_95
    return (round_m, round_m, 0.0) if 0.0 < round_m < _LARGEST_M else (math.nan, math.nan, math.nan)


def _number(report: Mapping[str, Any], name: str) -> float:
    """A number, NaN where there is none."""
    value = report.get(name, math.nan)
    if type(value) not in {int, float}:
        raise ValueError(f"{name} must be a number, got {value!r}")
    return float(value)


def _utc_s(report: Mapping[str, Any]) -> float:
    """UTC of a report, NaN where it says none or nothing that is a time [s]."""
    text = report.get("time")
    try:
        at = datetime.fromisoformat(text) if isinstance(text, str) else None
        return at.timestamp() if at is not None and at.tzinfo is not None else math.nan
    except (ValueError, OverflowError):
        return math.nan

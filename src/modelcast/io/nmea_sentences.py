"""NMEA 0183 sentences: the checksum, and what GGA and RMC say.

References
----------
NMEA 0183, sentence formatters GGA and RMC.
"""

from dataclasses import dataclass, replace
from datetime import date
from functools import reduce

import numpy as np

from modelcast.io.rows import LARGEST

__all__ = ["Fix", "checksum", "parse_fix", "sentence_body"]

_KNOT_MPS = 1852.0 / 3600.0


@dataclass(frozen=True, slots=True)
class Fix:
    """What the sentences of one instant say; NaN where they do not.

    Parameters
    ----------
    kind
        ``GGA``, ``RMC``, or both joined.
    valid
        Whether no sentence says that there is no fix.
    time_of_day_s
        UTC [s].
    latitude_deg, longitude_deg, altitude_m
        Position; height above the ellipsoid where the geoid separation is given.
    speed_mps, course_deg
        Over ground; course clockwise from true north.
    day
        UTC date.
    """

    kind: str
    valid: bool
    time_of_day_s: float
    latitude_deg: float
    longitude_deg: float
    altitude_m: float = np.nan
    speed_mps: float = np.nan
    course_deg: float = np.nan
    day: date | None = None

    def joined(self, other: "Fix") -> "Fix":
        """Return both together; position and height are GGA's."""
        gga, rmc = (self, other) if self.kind == "GGA" else (other, self)
        return replace(
            gga if np.isfinite(gga.latitude_deg) else replace(rmc, altitude_m=gga.altitude_m),
            kind="GGA+RMC",
            valid=gga.valid and rmc.valid,
            speed_mps=rmc.speed_mps,
            course_deg=rmc.course_deg,
            day=rmc.day,
        )


def checksum(body: str) -> int:
    """Return the exclusive or of the characters between ``$`` and ``*``.

    Examples
    --------
    >>> hex(checksum("GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,"))
    '0x76'
    """
    return reduce(lambda total, character: total ^ ord(character), body, 0)


def sentence_body(line: str) -> str | None:
    """Return a sentence without ``$`` and checksum, or None where the checksum is wrong or missing.

    Examples
    --------
    >>> sentence_body("$GPTXT,01*2A") is None
    True
    """
    _, dollar, rest = line.rstrip().rpartition("$")
    body, star, given = rest.rpartition("*")
    if not (dollar and star and len(given) == 2):
        return None
    try:
        expected = int(given, 16)
    except ValueError:
        return None
    return body if checksum(body) == expected else None


def parse_fix(body: str) -> Fix | None:
    """Return what a GGA or RMC sentence says, None for other sentences and those without a time.

    Raises
    ------
    ValueError
        Where a field is not what the sentence says it is.
    """
    fields = body.split(",")
    kind = fields[0][-3:]
    needed = {"GGA": 12, "RMC": 10}.get(kind)
    if needed is None or len(fields[0]) not in {5, 6}:
        return None
    if len(fields) < needed:
        raise ValueError(f"{len(fields)} fields where {kind} has {needed}")
    if not fields[1]:
        return None
    time_of_day_s = _time_of_day_s(fields[1])
    if kind == "GGA":
        return Fix(
            kind,
            fields[6] not in {"", "0"},
            time_of_day_s,
            _angle_deg(fields[2], fields[3], "NS", 90.0),
            _angle_deg(fields[4], fields[5], "EW", 180.0),
            altitude_m=_number(fields[9]) + (_number(fields[11]) if fields[11] else 0.0),
        )
    return Fix(
        kind,
        fields[2] == "A",
        time_of_day_s,
        _angle_deg(fields[3], fields[4], "NS", 90.0),
        _angle_deg(fields[5], fields[6], "EW", 180.0),
        speed_mps=_number(fields[7]) * _KNOT_MPS,
        course_deg=_number(fields[8]),
        day=_day(fields[9]),
    )


def _number(text: str) -> float:
    """Return a number, NaN for a blank field."""
    if not text:
        return float("nan")
    value = float(text)
    if not abs(value) <= LARGEST:
        raise ValueError(f"{text!r} is not a number that a sentence can hold")
    return value


def _time_of_day_s(text: str) -> float:
    if not text[:6].isdecimal() or len(text) < 6:
        raise ValueError(f"{text!r} is not a time hhmmss")
    hours, minutes, seconds = int(text[:2]), int(text[2:4]), _number(text[4:])
    if not (hours < 24 and minutes < 60 and 0.0 <= seconds < 61.0):
        raise ValueError(f"{text!r} is not a time hhmmss")
    # Whole milliseconds, so that 59.9 after minutes compares equal in both sentences.
    return round((hours * 3600 + minutes * 60 + seconds) * 1000.0) / 1000.0


def _angle_deg(text: str, side: str, sides: str, bound: float) -> float:
    """Return an angle given as degrees and minutes, dddmm.mmmm; NaN where blank."""
    if not text:
        return float("nan")
    value = _number(text)
    degrees, minutes = divmod(value, 100.0)
    angle = degrees + minutes / 60.0
    if value < 0 or minutes >= 60.0 or angle > bound or side not in sides or not side:
        raise ValueError(f"{text!r} {side!r} is not an angle with one of {sides}")
    return angle if side == sides[0] else -angle


def _day(text: str) -> date | None:
    if not text:
        return None
    if len(text) != 6 or not text.isdecimal():
        raise ValueError(f"{text!r} is not a date ddmmyy")
    year = int(text[4:])
    return date((1900 if year >= 80 else 2000) + year, int(text[2:4]), int(text[:2]))

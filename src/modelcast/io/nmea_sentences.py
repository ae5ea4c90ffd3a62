"""NMEA 0183 sentences: where they are in a line, the checksum, and what GGA and RMC say.

References
----------
NMEA 0183, sentence formatters GGA and RMC.
"""

import re
from dataclasses import dataclass, replace
from datetime import date
from functools import lru_cache, reduce
from sys import intern

import numpy as np

from modelcast.io.rows import LARGEST

__all__ = ["Fix", "checksum", "parse_fix", "sentence_body", "sentences", "talker_of"]

_KNOT_MPS = 1852.0 / 3600.0
_CHECKSUM = re.compile(r"[0-9A-Fa-f]{2}")
_UNSET_YEAR = 80
"""A receiver that does not know the date yet says January 1980, where GPS time begins."""


@dataclass(frozen=True, slots=True)
class Fix:
    """What the sentences of one instant say; NaN where they do not.

    Parameters
    ----------
    kind
        ``GGA``, ``RMC``, or both joined, ``GGA+RMC``.
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
    latitude_deg: float = np.nan
    longitude_deg: float = np.nan
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


def sentences(line: str) -> list[str]:
    """Return the parts of a line that begin with ``$``, each up to the next.

    Examples
    --------
    >>> sentences("NMEA,$GPGGA,1$GPTXT,2*00")
    ['$GPGGA,1', '$GPTXT,2*00']
    """
    return [f"${part}" for part in line.split("$")[1:]]


def sentence_body(sentence: str) -> str | None:
    """Return a sentence without ``$`` and checksum, or None where the checksum is wrong or missing.

    What follows the two digits of the checksum is no part of the sentence: some loggers write a time there.

    Examples
    --------
    >>> sentence_body("$GPTXT,01*2A") is None
    True
    >>> sentence_body("$GPTXT*4F,1710496800000")
    'GPTXT'
    """
    _, dollar, rest = sentence.rpartition("$")
    body, _, given = rest.partition("*")
    digits = _CHECKSUM.match(given)
    if not dollar or digits is None:
        return None
    return body if checksum(body) == int(digits[0], 16) else None


def talker_of(body: str) -> str:
    """Return who sent a sentence.

    Examples
    --------
    >>> talker_of("GNRMC,,V")
    'GN'
    """
    return intern(body.partition(",")[0][:-3])


def parse_fix(body: str) -> Fix | None:
    """Return what a GGA or RMC sentence says, None for other sentences.

    Of a sentence that says that there is no fix only the time is read, NaN where it is none.

    Raises
    ------
    ValueError
        Where a field is not what the sentence says it is.
    """
    fields = body.split(",")
    kind = intern(fields[0][-3:])
    needed = {"GGA": 12, "RMC": 10}.get(kind)
    if needed is None or len(fields[0]) not in {5, 6}:
        return None
    if len(fields) < needed:
        raise ValueError(f"{len(fields)} fields where {kind} has {needed}")
    if not _has_fix(kind, fields):
        return Fix(kind, valid=False, time_of_day_s=_time_or_nan(fields[1]))
    time_of_day_s = _time_of_day_s(fields[1])
    if kind == "GGA":
        return Fix(
            kind,
            valid=True,
            time_of_day_s=time_of_day_s,
            latitude_deg=_angle_deg(fields[2], fields[3], "NS", 90.0),
            longitude_deg=_angle_deg(fields[4], fields[5], "EW", 180.0),
            altitude_m=_number(fields[9]) + (_number(fields[11]) if fields[11] else 0.0),
        )
    return Fix(
        kind,
        valid=True,
        time_of_day_s=time_of_day_s,
        latitude_deg=_angle_deg(fields[3], fields[4], "NS", 90.0),
        longitude_deg=_angle_deg(fields[5], fields[6], "EW", 180.0),
        speed_mps=_number(fields[7]) * _KNOT_MPS,
        course_deg=_number(fields[8]),
        day=_day(fields[9]),
    )


def _has_fix(kind: str, fields: list[str]) -> bool:
    """Return whether a sentence says that its position is one."""
    if kind == "GGA":
        return fields[6] not in {"", "0"}
    return fields[2] == "A" and fields[12:13] != ["N"]


def _time_or_nan(text: str) -> float:
    try:
        return _time_of_day_s(text)
    except ValueError:
        return float("nan")


def _number(text: str) -> float:
    """Return a number, NaN for a blank field."""
    if not text:
        return float("nan")
    value = float(text)
    if not abs(value) <= LARGEST:
        raise ValueError(f"{text!r} is not a number that a sentence can hold")
    return value


def _time_of_day_s(text: str) -> float:
    """Return a time hhmmss.sss, NaN for a blank field."""
    if not text:
        return float("nan")
    if not text[:6].isdecimal() or len(text) < 6:
        raise ValueError(f"{text!r} is not a time hhmmss")
    hours, minutes, seconds = int(text[:2]), int(text[2:4]), _number(text[4:])
    if not (hours < 24 and minutes < 60 and 0.0 <= seconds < 61.0):
        raise ValueError(f"{text!r} is not a time hhmmss")
    # Whole milliseconds, so that 59.9 after minutes compares equal in both sentences.
    return round((hours * 3600 + minutes * 60 + seconds) * 1000.0) / 1000.0


def _angle_deg(text: str, side: str, sides: str, bound: float) -> float:
    """Return an angle given as degrees and minutes, dddmm.mmmm; NaN where blank.

    Sixty minutes are a degree: 59.999996 printed with five decimals.
    """
    if not text:
        return float("nan")
    value = _number(text)
    degrees, minutes = divmod(value, 100.0)
    angle = degrees + minutes / 60.0
    if value < 0 or minutes > 60.0 or angle > bound or side not in sides or not side:
        raise ValueError(f"{text!r} {side!r} is not an angle with one of {sides}")
    return angle if side == sides[0] else -angle


@lru_cache(maxsize=64)
def _day(text: str) -> date | None:
    """Return a date ddmmyy, None where it is blank or not set yet; sentences of a day share one."""
    if not text:
        return None
    if len(text) != 6 or not text.isdecimal():
        raise ValueError(f"{text!r} is not a date ddmmyy")
    year = int(text[4:])
    day = date((1900 if year >= _UNSET_YEAR else 2000) + year, int(text[2:4]), int(text[:2]))
    return None if year == _UNSET_YEAR else day

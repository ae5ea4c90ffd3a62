"""Dates with a time of day as loggers of messages write them, each in a cell or text of its own.

===============================================  ===========================================================
``2017-08-10T20:08:54.300Z[UTC]``                the operational data environment, early
``2021-07-21T18:03:16.462Z``                     the same, later
``2017-12-05 14:18:28.114 [ET]``                 Tampa; a zone by name is not known: local time
``2018-11-20T12:13:36.398``                      tables of data.transportation.gov; no zone: local time
``07/31/2019 12:41:59.000 PM``                   the same, as Socrata exports them: month first
===============================================  ===========================================================
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone

__all__ = ["LogClock", "read_stamp"]

_YEAR_FIRST = re.compile(
    r"(?P<year>\d{4})[-/](?P<month>\d\d?)[-/](?P<day>\d\d?)[T ]+(?P<hour>\d\d?):(?P<minute>\d\d)"
    r"(?::(?P<second>\d\d)(?:[.,](?P<fraction>\d{1,9}))?)? ?(?P<zone>Z|[+-]\d\d:?\d\d)? ?"
    r"(?:\[[\w/+-]{1,40}\])?",
    re.ASCII,
)
_MONTH_FIRST = re.compile(
    r"(?P<month>\d\d?)/(?P<day>\d\d?)/(?P<year>\d{4}) (?P<hour>\d\d?):(?P<minute>\d\d)"
    r"(?::(?P<second>\d\d)(?:[.](?P<fraction>\d{1,9}))?)? ?(?P<half>[AaPp][Mm])?(?P<zone>)",
    re.ASCII,
)
_NOON = 12


def read_stamp(text: str) -> tuple[float, bool]:
    """Return milliseconds since 1970 and whether they are of UTC rather than of an unknown zone.

    Parameters
    ----------
    text
        As a logger wrote it.

    Raises
    ------
    ValueError
        Where it is no such date and time.

    Examples
    --------
    >>> read_stamp("2017-08-10T20:08:54.300Z[UTC]")
    (1502395734300.0, True)
    >>> read_stamp("12/05/2017 02:18:28.114 PM") == read_stamp("2017-12-05 14:18:28.114 [ET]")
    True
    """
    found = _YEAR_FIRST.fullmatch(text.strip()) or _MONTH_FIRST.fullmatch(text.strip())
    if found is None:
        raise ValueError("it is no date with a time of day")
    part = found.groupdict()
    hour = int(part["hour"])
    if part.get("half"):
        if not 1 <= hour <= _NOON:
            raise ValueError(f"there is no hour {hour} with {part['half']}")
        hour = hour % _NOON + _NOON * (part["half"].lower() == "pm")
    zone = part["zone"]
    when = datetime(
        int(part["year"]), int(part["month"]), int(part["day"]), hour, int(part["minute"]),
        tzinfo=_zone(zone) if zone else UTC,
    )  # fmt: skip
    seconds = int(part["second"] or 0)
    if seconds > 60:
        raise ValueError(f"there is no second {seconds}")
    fraction_ms = int((part["fraction"] or "").ljust(9, "0")) / 1e6
    return when.timestamp() * 1000.0 + seconds * 1000.0 + fraction_ms, bool(zone)


def _zone(text: str) -> timezone:
    if text == "Z":
        return UTC
    hours, minutes = int(text[1:3]), int(text[-2:])
    away = timedelta(hours=hours, minutes=minutes)
    return timezone(-away if text[0] == "-" else away)


@dataclass(slots=True)
class LogClock:
    """The one clock of a file's stamps: the first tells whether all are of UTC or all of an unknown zone.

    Parameters
    ----------
    utc
        Which of the two, once it is known.
    """

    utc: bool | None = None

    def first_of(self, texts: Iterable[str | None]) -> float:
        """Return the first stamp that is one, NaN where all are blank [ms since 1970].

        Parameters
        ----------
        texts
            Stamps of one message, the best first.

        Raises
        ------
        ValueError
            Where one is no date and time, or in UTC where others are not.
        """
        for text in texts:
            if text is None or not text.strip():
                continue
            try:
                stamp_ms, utc = read_stamp(text)
            except (ValueError, OverflowError) as error:
                raise ValueError(f"{text[:60]!r}: {error}") from error
            if self.utc is None:
                self.utc = utc
            elif self.utc != utc:
                have = "a zone that is known" if utc else "no zone that is known"
                raise ValueError(f"{text[:60]!r} has {have}, unlike the first of the file")
            return stamp_ms
        return float("nan")

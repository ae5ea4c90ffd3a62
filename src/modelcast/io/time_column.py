"""The time column of a table: numbers in a unit, or text as ISO 8601 writes it; never a factor of 1000 off.

The first known value decides, and every other value has to agree with it.

- A unit that the column's name or the map states (``t_s``, ``t_ms``, ``t_us``, ``t_ns``) holds. A time of
  over `LONGEST_S` in it is an error: nobody records for 3,000 years, so the unit is another one.
- Where none is stated (``t``, ``time``) numbers are seconds, except those that as seconds would be over
  `LONGEST_S`: these are Unix times in ms, µs or ns, by their size, and the trip's counts say so.
- Text is a date and a time of day, ``2024-03-15T10:00:00.100Z``: ``T`` or a blank between them, ``-`` or
  ``/`` in the date, up to nine decimals, a zone (``Z``, ``UTC``, ``+01:00``) in every row or in none. Without
  a zone the trip has no absolute time. The date may be left out in every row: such times are counted from
  the first, and do not run over midnight.

Whole numbers are taken from the first before they become float64, so that nanoseconds keep their digits.
"""

import re
from dataclasses import dataclass

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError

__all__ = ["LONGEST_S", "TimeColumn", "TimeUnit", "holds_dates", "holds_times"]

LONGEST_S = 1e11
"""No time of any recording is longer [s]; Unix milliseconds of any year after 1973 are."""

_UNSHIFTED = 1e8
"""Times in seconds below are kept as they stand; others are counted from the first."""

_LARGEST_WHOLE = 2**62
"""Whole numbers beyond are damage, and differences of them could overflow."""

_UNIX_UNITS = ((1e17, 1e-9, "nanoseconds"), (1e14, 1e-6, "microseconds"), (0.0, 1e-3, "milliseconds"))
_WORDS = {1e-3: "t_ms", 1e-6: "t_us", 1e-9: "t_ns"}
_ISO = (
    r"^(?:(\d{4})[-/](\d\d)[-/](\d\d)[Tt ]+)?(\d\d?):(\d\d):(\d\d)(?:[.,](\d{1,9}))?"
    r" ?(?:([Zz]|UTC)|([+-])(\d\d):?(\d\d)?)?$"
)
_NANO = 10**9
_CLOCK, _DATED, _ZONED = range(3)
_KINDS = ("a time of day without a date", "a date and time without a zone", "a date and time with a zone")
_AS_ISO = "Write it as seconds, or as 2024-03-15T10:00:00.100Z."
_DAY_FIRST = re.compile(r"(\d\d?)([./-])(\d\d?)\2(\d{4})\b.*")


@dataclass(frozen=True, slots=True)
class TimeUnit:
    """What the numbers of a time column mean.

    Parameters
    ----------
    unit_s
        Seconds a unit.
    start
        What was taken from every value, in units.
    unix
        Whether `start` is a Unix time for certain.
    told
        What the trip's counts say about it; empty where the file states the unit itself.
    assumed
        The column's name where nothing states that it holds seconds, else empty.
    """

    unit_s: float
    start: float = 0.0
    unix: bool = False
    told: str = ""
    assumed: str = ""


class TimeColumn:
    """Reads the time column of one table, part by part.

    Parameters
    ----------
    path, name
        The file and the column, for errors.
    unit_s
        The unit of numbers [s].
    stated
        Whether the name or the map states that unit.
    decimal
        The mark of decimals.
    """

    def __init__(self, path: str, name: str, unit_s: float, *, stated: bool, decimal: str = ".") -> None:
        self._path, self._name, self._stated, self._decimal = path, name, stated, decimal
        self.unit = TimeUnit(unit_s)
        self._begun = False
        self._text = False
        self._kind = 0
        self._start = 0

    def read(self, text: pl.Series, line: IntArray) -> FloatArray:
        """Return cells of text as times from `unit.start`, in units, NaN where blank, (R,).

        Raises
        ------
        DataFormatError
            Where a cell is no time, or not in the unit that the first one told.
        """
        if not self._begun:
            self._text = holds_times(text)
        if self._text:
            return self._dated(text, line)
        plain = text
        if self._decimal != ".":
            plain = text.str.replace_all(".", "?", literal=True).str.replace(self._decimal, ".", literal=True)
        return self.numbers(
            plain.cast(pl.Int64, strict=False), plain.cast(pl.Float64, strict=False), text, line
        )

    def numbers(self, whole: pl.Series, values: pl.Series, shown: pl.Series, line: IntArray) -> FloatArray:
        """Return numbers as times from `unit.start`, in units, NaN where they are null, (R,).

        Parameters
        ----------
        whole
            The values as whole numbers, null where they are not.
        values
            The values as float64.
        shown
            The cells as the file has them.
        line
            Their lines.
        """
        whole = whole.set(whole.abs() > _LARGEST_WHOLE, None)
        numbers = values.fill_null(np.nan).to_numpy()
        at = int(np.argmax(np.isfinite(numbers))) if numbers.size else 0
        if not self._begun and numbers.size and np.isfinite(numbers[at]):
            self._begin(float(numbers[at]), whole[at], shown[at], int(line[at]))
        relative = numbers - float(self._start)
        exact = whole.is_not_null().to_numpy()
        steps = (whole - self._start).fill_null(0).cast(pl.Float64).to_numpy()
        times = np.where(exact, steps, relative)
        bad = shown.is_not_null().to_numpy() & ~(np.abs(times) * self.unit.unit_s < LONGEST_S)
        if bad.any():
            self._refuse(shown, line, bad)
        return times

    def _begin(self, first: float, whole: int | None, shown: object, line: int) -> None:
        """Settle the unit by the first value."""
        self._begun = True
        unit_s, told = self.unit.unit_s, ""
        if abs(first) * unit_s >= LONGEST_S:
            by_size = next(entry for entry in _UNIX_UNITS if abs(first) >= entry[0])
            if self._stated or first < 0 or first >= 1e20:
                raise DataFormatError(
                    self._path,
                    f"{self._name} is {shown}, which in units of {unit_s:g} s is over 3,000 years",
                    row=line,
                    remedy=f"Map the column by its unit: {_WORDS[by_size[1]]}={self._name}.",
                )
            unit_s, told = by_size[1], f"{self._name} taken as Unix {by_size[2]}"
        if abs(first) * unit_s >= _UNSHIFTED or unit_s != 1.0:
            self._start = whole if whole is not None else int(first)
        assumed = "" if self._stated or told else self._name
        self.unit = TimeUnit(unit_s, float(self._start), unix=bool(told), told=told, assumed=assumed)

    def _dated(self, text: pl.Series, line: IntArray) -> FloatArray:
        """Return dates and times of day as times from the first."""
        parts = _iso(text)
        kind = parts.get_column("kind")
        nanos = parts.get_column("nanos")
        if not self._begun:
            at = int(text.is_not_null().arg_max() or 0)
            self._begun, self._kind = True, int(kind[at] or 0)
            if nanos[at] is None:
                self._refuse(text, line, text.is_not_null().to_numpy())
            self._start = int(nanos[at])
            self.unit = TimeUnit(1e-9, float(self._start), unix=self._kind == _ZONED)
        wrong = text.is_not_null() & (nanos.is_null() | (kind != self._kind).fill_null(value=True))
        if wrong.any():
            self._refuse(text, line, wrong.to_numpy())
        return (nanos - self._start).cast(pl.Float64).fill_null(np.nan).to_numpy()

    def _refuse(self, shown: pl.Series, line: IntArray, bad: np.ndarray) -> None:
        at = int(np.argmax(bad))
        remedy = "Correct the value, or leave the cell blank where it is not known."
        if self._text:
            expected = f"{_KINDS[self._kind]}, as in the first row"
        else:
            expected = "a finite number in the unit of the first row"
            if not self._begun:
                expected, remedy = "a number, a date and time or a time of day", _as_iso(str(shown[at]))
        raise DataFormatError(
            self._path,
            f"{self._name} is {shown[at]!r}, not {expected}",
            row=int(line[at]),
            remedy=remedy,
        )


def _as_iso(shown: str) -> str:
    """Return how to write a time that is none; where it is a date with its year last, that date."""
    date = _DAY_FIRST.fullmatch(shown.strip())
    if date is None:
        return _AS_ISO
    day, mark, month, year = date.groups()
    if mark != ".":
        return f"The year comes first, so that day and month are certain. {_AS_ISO}"
    return f"Write the date as {year}-{month:0>2}-{day:0>2}, the year first. {_AS_ISO}"


def holds_dates(text: pl.Series) -> bool:
    """Return whether the first known cell is a date and a time of day."""
    return bool((_first(text) > _CLOCK).any())


def holds_times(text: pl.Series) -> bool:
    """Return whether the first known cell is a time of day, with a date or without."""
    return _first(text).is_not_null().any()


def _first(text: pl.Series) -> pl.Series:
    return _iso(text.drop_nulls().head(1)).get_column("kind")


def _iso(text: pl.Series) -> pl.DataFrame:
    """Return Unix nanoseconds (without a date of the day) and the kind of time, null where it is none."""
    groups = text.str.extract_groups(_ISO).struct.unnest()
    year, month, day, hour, minute, second, fraction, utc, sign, hours, minutes = groups.get_columns()
    date = (year + "-" + month + "-" + day).str.to_date("%Y-%m-%d", strict=False).cast(pl.Int64)
    date = date.set(year.is_null(), 0)
    clock = hour.cast(pl.Int64) * 3600 + minute.cast(pl.Int64) * 60 + second.cast(pl.Int64)
    inside = (hour.cast(pl.Int64) < 24) & (minute.cast(pl.Int64) < 60) & (second.cast(pl.Int64) <= 60)
    east = hours.cast(pl.Int64).fill_null(0) * 3600 + minutes.cast(pl.Int64).fill_null(0) * 60
    east = east * (sign == "-").fill_null(value=False).cast(pl.Int64) * -2 + east
    seconds = (date * 86400 + clock - east) * _NANO
    nanos = seconds + fraction.fill_null("").str.pad_end(9, "0").cast(pl.Int64)
    nanos = nanos.set(~inside.fill_null(value=False), None)
    zoned = utc.is_not_null() | sign.is_not_null()
    kind = (zoned.cast(pl.Int64) + _DATED).set(year.is_null(), _CLOCK).set(hour.is_null(), None)
    return pl.DataFrame({"nanos": nanos, "kind": kind})

"""The time column of a table: numbers in a unit, or text as ISO 8601 writes it; never a factor of 1000 off.

The first known value decides, and every other value has to agree with it.

- A unit that the column's name or the map states (``t_s``, ``t_ms``, ``t_us``, ``t_ns``) holds. A time of
  over `LONGEST_S` in it is an error: nobody records for 3,000 years, so the unit is another one.
- Where none is stated (``t``, ``time``) numbers are seconds, except those that as seconds would be over
  `LONGEST_S`: these are Unix times in ms, µs or ns, by their size, and the trip's counts say so.
- Text is a date and a time of day, ``2024-03-15T10:00:00.100Z``: ``T`` or a blank between them, ``-`` or
  ``/`` in the date, up to nine decimals, ``AM`` or ``PM``, a zone (``Z``, ``UTC``, ``+01:00``) in every row
  or in none. Without a zone the trip has no absolute time. ``15.03.2024`` has the day first wherever it is
  written; ``3/4/2024`` has to be mapped, as ``t_dmy`` or ``t_mdy``. The date may be left out in every row:
  such times are counted from the first, and `over_midnight` takes them into the next day.

Whole numbers are taken from the first before they become float64, so that nanoseconds keep their digits.
"""

import re
from dataclasses import dataclass

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError

__all__ = ["LONGEST_S", "TimeColumn", "TimeUnit", "holds_dates", "holds_times", "over_midnight"]

LONGEST_S = 1e11
"""No time of any recording is longer [s]; Unix milliseconds of any year after 1973 are."""

_UNSHIFTED = 1e8
"""Times in seconds below are kept as they stand; others are counted from the first."""

_LARGEST_WHOLE = 2**62
"""Whole numbers beyond are damage, and differences of them could overflow."""

_UNIX_UNITS = ((1e17, 1e-9, "nanoseconds"), (1e14, 1e-6, "microseconds"), (0.0, 1e-3, "milliseconds"))
_WORDS = {1e-3: "t_ms", 1e-6: "t_us", 1e-9: "t_ns"}
_ISO = (
    r"^(?:(\d{4})[-/](\d\d?)[-/](\d\d?)[Tt, ]+)?(\d\d?):(\d\d):(\d\d)(?:[.,](\d{1,9}))?"
    r"(?: ?([AaPp])[Mm])? ?(?:([Zz]|UTC)|([+-])(\d\d):?(\d\d)?)?$"
)
_DOTTED = (r"^(\d\d?)\.(\d\d?)\.(\d{4})[Tt, ]", "$3-$2-$1 ")
_YEAR_LAST = r"^(\d\d?)[/-](\d\d?)[/-](\d{4})[Tt, ]"
_YEAR_FIRST = {True: "$3-$2-$1 ", False: "$3-$1-$2 "}
"""The same date with its year first, by whether the day comes first."""
_NANO = 10**9
_DAY_S = 86400
_CLOCK, _DATED, _ZONED = range(3)
_KINDS = ("a time of day without a date", "a date and time without a zone", "a date and time with a zone")
_ORDERS = {None: "", True: ", the day first", False: ", the month first"}
_AS_ISO = "Write it as seconds, or as 2024-03-15T10:00:00.100Z."


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
    text
        What the cells are in words, where they are no numbers.
    clock
        Whether they are times of day, which begin anew at midnight.
    """

    unit_s: float
    start: float = 0.0
    unix: bool = False
    told: str = ""
    assumed: str = ""
    text: str = ""
    clock: bool = False


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
    day_first
        Whether dates with their year last begin with the day, or with the month; None where nobody says.
    """

    def __init__(
        self,
        path: str,
        name: str,
        unit_s: float,
        *,
        stated: bool,
        decimal: str = ".",
        day_first: bool | None = None,
    ) -> None:
        self._path, self._name, self._stated, self._decimal = path, name, stated, decimal
        self._day_first = day_first
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
            self._text = self._day_first is not None or holds_times(text)
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
                word = _WORDS[by_size[1]] if abs(first) >= LONGEST_S else "t_s"
                raise DataFormatError(
                    self._path,
                    f"{self._name} is {shown}, which in units of {unit_s:g} s is over 3,000 years",
                    row=line,
                    remedy=f"Map the column by its unit: {word}={self._name}.",
                )
            unit_s, told = by_size[1], f"{self._name} taken as Unix {by_size[2]}"
        if abs(first) * unit_s >= _UNSHIFTED or unit_s != 1.0:
            self._start = whole if whole is not None else int(first)
        assumed = "" if self._stated or told else self._name
        self.unit = TimeUnit(unit_s, float(self._start), unix=bool(told), told=told, assumed=assumed)

    def _dated(self, text: pl.Series, line: IntArray) -> FloatArray:
        """Return dates and times of day as times from the first."""
        parts = _iso(text, self._day_first)
        kind = parts.get_column("kind")
        nanos = parts.get_column("nanos")
        if not self._begun:
            at = int(text.is_not_null().arg_max() or 0)
            self._begun, self._kind = True, int(kind[at] or 0)
            if nanos[at] is None:
                self._refuse(text, line, text.is_not_null().to_numpy())
            self._start = int(nanos[at])
            self.unit = TimeUnit(
                1e-9, float(self._start), unix=self._kind == _ZONED, clock=self._kind == _CLOCK,
                text=_KINDS[self._kind] + _ORDERS[self._day_first],
            )  # fmt: skip
        wrong = text.is_not_null() & (nanos.is_null() | (kind != self._kind).fill_null(value=True))
        if wrong.any():
            self._refuse(text, line, wrong.to_numpy())
        return (nanos - self._start).cast(pl.Float64).fill_null(np.nan).to_numpy()

    def _refuse(self, shown: pl.Series, line: IntArray, bad: np.ndarray) -> None:
        at = int(np.argmax(bad))
        remedy = "Correct the value, or leave the cell blank where it is not known."
        if self._text and self._day_first is not None and not self.unit.text:
            expected, remedy = f"a date and time{_ORDERS[self._day_first]}, with its year last", _AS_ISO
        elif self._text:
            expected = f"{_KINDS[self._kind]}, as in the first row"
        else:
            expected = "a finite number in the unit of the first row"
            if not self._begun:
                expected = "a number, a date and time or a time of day"
                remedy = _as_iso(str(shown[at]), self._name)
        raise DataFormatError(
            self._path,
            f"{self._name} is {shown[at]!r}, not {expected}",
            row=int(line[at]),
            remedy=remedy,
        )


def _as_iso(shown: str, name: str) -> str:
    """Return how to write a time that is none; where it is a date with its year last, how to map it."""
    if re.match(_YEAR_LAST, shown.strip() + " ") is None:
        return _AS_ISO
    return f"Say what comes first: --columns t_dmy={name} (the day) or --columns t_mdy={name} (the month)."


def over_midnight(times: FloatArray, unit: TimeUnit) -> FloatArray:
    """Return one vehicle's times of day, (R,), with a day more behind every midnight; others as they are.

    Parameters
    ----------
    times
        In the order of the file, in units, none of them missing.
    unit
        What they mean.

    Examples
    --------
    >>> import numpy as np
    >>> over_midnight(np.array([86399.0, 0.0, 1.0]), TimeUnit(1.0, clock=True))
    array([86399., 86400., 86401.])
    """
    day = _DAY_S / unit.unit_s
    later = np.diff(times) < -0.5 * day
    if not unit.clock or not later.any():
        return times
    return times + day * np.concatenate([[0], np.cumsum(later)])


def holds_dates(text: pl.Series) -> bool:
    """Return whether the first known cell is a date and a time of day."""
    return bool((_first(text) > _CLOCK).any())


def holds_times(text: pl.Series) -> bool:
    """Return whether the first known cell is a time of day, with a date or without."""
    return _first(text).is_not_null().any()


def _first(text: pl.Series) -> pl.Series:
    return _iso(text.drop_nulls().head(1)).get_column("kind")


def _iso(text: pl.Series, day_first: bool | None = None) -> pl.DataFrame:
    """Return Unix nanoseconds (without a date of the day) and the kind of time, null where it is none."""
    text = text.str.replace(*_DOTTED)
    if day_first is not None:
        text = text.str.replace(_YEAR_LAST, _YEAR_FIRST[day_first])
    groups = text.str.extract_groups(_ISO).struct.unnest()
    year, month, day, hour, minute, second, fraction, half, utc, sign, hours, minutes = groups.get_columns()
    date = (
        (year + "-" + month.str.zfill(2) + "-" + day.str.zfill(2))
        .str.to_date("%Y-%m-%d", strict=False)
        .cast(pl.Int64)
    )
    date = date.set(year.is_null(), 0)
    hour = _of_24(hour, half)
    clock = hour * 3600 + minute.cast(pl.Int64) * 60 + second.cast(pl.Int64)
    inside = (hour < 24) & (minute.cast(pl.Int64) < 60) & (second.cast(pl.Int64) <= 60)
    east = hours.cast(pl.Int64).fill_null(0) * 3600 + minutes.cast(pl.Int64).fill_null(0) * 60
    east = east * (sign == "-").fill_null(value=False).cast(pl.Int64) * -2 + east
    seconds = (date * 86400 + clock - east) * _NANO
    nanos = seconds + fraction.fill_null("").str.pad_end(9, "0").cast(pl.Int64)
    nanos = nanos.set(~inside.fill_null(value=False), None)
    zoned = utc.is_not_null() | sign.is_not_null()
    kind = (zoned.cast(pl.Int64) + _DATED).set(year.is_null(), _CLOCK).set(hour.is_null(), None)
    return pl.DataFrame({"nanos": nanos, "kind": kind})


def _of_24(hour: pl.Series, half: pl.Series) -> pl.Series:
    """Return hours of the day; those of a half of it by its letter, those beyond 12 of one as 24."""
    number = hour.cast(pl.Int64)
    halves = half.is_not_null()
    afternoon = half.str.to_lowercase().eq("p").fill_null(value=False)
    of_day = (number % 12 + 12 * afternoon.cast(pl.Int64)).set((number > 12).fill_null(value=False), 24)
    return number.zip_with(~halves, of_day)

"""What the core data of basic safety messages means, as codes of the standard or in its units.

Programs write Part I of a message either as it is on the air, whole numbers of steps, or in the units that
the steps are of; what is not available then stays in the file as its code or as its code times the step. Both
are brought to SI units here, NaN where a value is not available or none that a message could carry.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.io.rows import with_missing
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Field

__all__ = ["CORE_COLUMNS", "available", "core_in_si", "first_wrong_code", "instants_ms"]

_FIELDS: Mapping[str, Field] = MappingProxyType({field.name: field for field in CORE_FIELDS})

CORE_COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "latitude_deg": "latitude_deg",
        "longitude_deg": "longitude_deg",
        "altitude_m": "elevation_m",
        "speed_mps": "speed_mps",
        "heading_rad": "heading_rad",
        "acceleration_mps2": "acceleration_forward_mps2",
        "yaw_rate_radps": "yaw_rate_radps",
    }
)
"""Columns of a trip, and the field of Part I that each is."""

_MINUTE_MS = 60_000.0
_LAST_MARK_MS = 60_999.0
"""The last millisecond of a leap second; what is beyond says that there is no mark."""


def core_in_si(raw: Mapping[str, FloatArray], *, codes: BoolArray) -> dict[str, FloatArray]:
    """Return the columns of a trip in SI units, NaN where a message did not say them.

    Parameters
    ----------
    raw
        Numbers by the names of `CORE_COLUMNS`, (R,) each, NaN where the file has none: codes, or values in
        the standard's units (deg, m, m/s, m/s², deg/s).
    codes
        Whether a row's numbers are codes, (R,).

    Examples
    --------
    >>> import numpy as np
    >>> raw = {name: np.array([0.0, 0.0, 0.0]) for name in CORE_COLUMNS} | {
    ...     "speed_mps": np.array([500.0, 10.0, 163.82])
    ... }
    >>> core_in_si(raw, codes=np.array([True, False, False]))["speed_mps"]
    array([10., 10., nan])
    """
    found: dict[str, FloatArray] = {}
    for column, name in CORE_COLUMNS.items():
        field, given = _FIELDS[name], raw[column]
        step = field.step[0] / field.step[1]
        units = np.where(codes, given * step, given)
        code = np.round(units / step)
        low, high = field.known_codes
        missing = ~((code >= low) & (code <= high))
        if field.unavailable is not None:
            missing |= (code == field.unavailable) | (given == field.unavailable)
        found[column] = with_missing(units * field.si_per_unit, missing)
    return found


def available(column: str, values: FloatArray) -> FloatArray:
    """Return values with NaN where they are that of the code for what is not available, or beyond it.

    A yaw rate has no such code; what recorders write for it is the end of its range.

    Parameters
    ----------
    column
        One of `CORE_COLUMNS`.
    values
        In the standard's units (m/s, deg, m/s², deg/s), (R,); rounded by a quarter of a step at most.

    Examples
    --------
    >>> import numpy as np
    >>> available("speed_mps", np.array([10.0, 163.8, 163.82]))
    array([ 10. , 163.8,   nan])
    """
    field = _FIELDS[CORE_COLUMNS[column]]
    code = field.high if field.unavailable is None else field.unavailable
    return with_missing(values, np.abs(values) >= (code - 0.25) * field.step[0] / field.step[1])


def first_wrong_code(raw: Mapping[str, FloatArray]) -> tuple[str, int] | None:
    """Return the column and row of the first number that is no code, None where all are.

    Parameters
    ----------
    raw
        As for `core_in_si`, codes in all rows.
    """
    for column in CORE_COLUMNS:
        wrong = np.isfinite(raw[column]) & (raw[column] != np.round(raw[column]))
        if wrong.any():
            return column, int(np.argmax(wrong))
    return None


def instants_ms(stamp_ms: FloatArray, mark_ms: FloatArray) -> FloatArray:
    """Return when messages are of, NaN where the stamp or the mark is missing, (R,) [ms].

    Parameters
    ----------
    stamp_ms
        When each was logged, (R,) [ms].
    mark_ms
        Its ``secMark``, milliseconds in the minute, (R,).

    Notes
    -----
    The instant next to the stamp that has this place in the minute: right where a message was logged within
    half a minute of its making.

    Examples
    --------
    >>> import numpy as np
    >>> instants_ms(np.array([120_500.0, 120_500.0]), np.array([59_900.0, 65_535.0]))
    array([119900.,     nan])
    """
    mark = with_missing(mark_ms, ~((mark_ms >= 0.0) & (mark_ms <= _LAST_MARK_MS)))
    return mark + _MINUTE_MS * np.round((stamp_ms - mark) / _MINUTE_MS)

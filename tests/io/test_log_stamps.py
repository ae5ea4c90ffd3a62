"""Stamps of loggers: every way to write one gives the same instant."""

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.io.log_stamps import LogClock, read_stamp

instants = st.datetimes(datetime(2000, 1, 1), datetime(2030, 1, 1)).map(  # noqa: DTZ001 - the zone is drawn
    lambda when: when.replace(microsecond=when.microsecond // 1000 * 1000)
)


@given(when=instants, offset=st.integers(-14 * 60, 14 * 60))
def test_the_instant_is_the_same_however_it_is_written(when, offset):
    expected = when.replace(tzinfo=UTC).timestamp() * 1000.0
    millis = f"{when.microsecond // 1000:03d}"
    plain = f"{when:%Y-%m-%dT%H:%M:%S}.{millis}"
    assert read_stamp(plain) == (expected, False)
    assert read_stamp(plain + "Z[UTC]") == (expected, True)
    assert read_stamp(plain.replace("T", " ") + " [ET]") == (expected, False)
    assert read_stamp(f"{when:%m/%d/%Y %I:%M:%S}.{millis} {when:%p}") == (expected, False)
    away = when.replace(tzinfo=UTC).astimezone(timezone(timedelta(minutes=offset)))
    written = f"{away:%Y-%m-%dT%H:%M:%S}.{millis}{away:%z}"
    assert read_stamp(written) == (expected, True)


@pytest.mark.parametrize(
    "text",
    [
        "now", "2017-13-01T00:00:00Z", "2017-01-01T25:00:00Z", "13/01/2017 01:00:00 PM",
        "1/1/2017 13:00:00 PM", "2017-01-01", "2017-01-01T00:00:61Z", "2017-01-01T00:00:00+99:00",
    ],
)  # fmt: skip
def test_what_is_no_stamp_is_refused(text):
    with pytest.raises(ValueError, match=r".+"):
        LogClock().first_of([text])


def test_blank_stamps_are_passed_over():
    assert LogClock().first_of([None, " ", "1970-01-01T00:00:01Z"]) == 1000.0
    assert LogClock().first_of([None, ""]) != LogClock().first_of([None, ""]), "NaN"

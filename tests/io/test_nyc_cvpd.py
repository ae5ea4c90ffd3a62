"""NYC pilot events: messages lost, repeated and out of order; stuck values are data."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips


def test_values_are_si_in_the_event_s_frame(made):
    messages = [made.nyc_message(at, vehicle) for at in range(5) for vehicle in ("A", "B")]
    first, second = read_trips(made.write("e.json", made.nyc(messages)))
    assert (first.trip_id, second.trip_id) == ("e/A", "e/B")
    assert first.position_m[4].tolist() == [4.0, 0.0]
    assert first.heading_rad[0] == pytest.approx(np.pi / 2)
    assert first.yaw_rate_radps[0] == pytest.approx(np.radians(2.0))
    assert first.acceleration_mps2[0] == 0.5
    assert first.origin is None


def test_disorder_repeats_and_losses(made):
    messages = [made.nyc_message(at) for at in (0, 1, 3, 2, 3, 4, 9, 10)]
    (trip,) = read_trips(made.write("e.json", made.nyc(messages)))
    assert trip.position_m[:, 0].tolist() == [0, 1, 2, 3, 4, 9, 10]
    assert trip.segments.tolist() == [0, 5, 7]
    assert dict(trip.reading.skipped) == {"duplicate time": 1}
    assert dict(trip.reading.repaired) == {"out of time order": 1}


def test_stuck_speed_is_kept(made):
    messages = [made.nyc_message(at, speed_mps=5.68) for at in range(8)]
    (trip,) = read_trips(made.write("e.json", made.nyc(messages)))
    assert trip.speed_mps.tolist() == [5.68] * 8
    assert not trip.reading.repaired


@pytest.mark.parametrize(
    ("changed", "reason"), [({"T_s": None}, "time missing"), ({"X_m": None}, "position missing")]
)
def test_message_without_time_or_position_is_skipped(made, changed, reason):
    messages = [made.nyc_message(0, **changed), *(made.nyc_message(at) for at in range(1, 5))]
    (trip,) = read_trips(made.write("e.json", made.nyc(messages)))
    assert dict(trip.reading.skipped) == {reason: 1}


def test_unavailable_heading_is_held(made):
    messages = [made.nyc_message(at, heading_deg=360.0 if at == 7 else 90.0) for at in range(12)]
    (trip,) = read_trips(made.write("e.json", made.nyc(messages)))
    assert trip.heading_rad[7] == trip.heading_rad[6]
    assert dict(trip.reading.repaired) == {"heading missing, last value held": 1}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'{"bsmList": [', "is not JSON"),
        (b'{"bsmList": []}', "no bsmList with messages"),
        (b'{"bsmList": [{"bsmRecord": {}}]}', "row 1: the message has no bsmMsg"),
        (b'{"bsmList": [{"bsmRecord": {"bsmMsg": {"coreData": {"id": 5}}}}]}', "id is 5, not a name"),
        (b'{"bsmList": [{"bsmRecord": {"bsmMsg": {"coreData": {"id": "A", "T_s": NaN}}}}]}', "T_s is nan"),
        (b'{"bsmList": [{"bsmRecord": {"bsmMsg": {"coreData": {"id": "A", "T_s": "1"}}}}]}', "T_s is '1'"),
    ],
)
def test_what_is_no_event_is_an_error(made, content, message):
    with pytest.raises(DataFormatError, match=message):
        list(read_trips(made.write("e.json", content)))

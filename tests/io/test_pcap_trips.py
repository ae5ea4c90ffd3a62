"""Claims about trips in captures."""

from modelcast.io.trips import read_trips


def test_a_trip_holds_what_its_messages_said(made) -> None:
    """Time is the messages' own, not the capture's, which is 1 ms late; a minute ends within it or not."""
    (trip,) = read_trips(made.valid("pcap"))
    assert trip.trip_id == "heard/a1b2c3d4"
    assert trip.start_unix_s == 1_700_000_030.0
    assert abs(trip.t_s[-1] - (len(trip) - 1) / 10) < 1e-6
    assert abs(float(trip.columns()["speed_mps"][0]) - 11.1) < 0.011

"""Limits of the formats that are held whole: each ends in an error that says what to do."""

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io import comma2k19, nmea, nyc_cvpd, openacc, smartloc
from modelcast.io.registry import get_reader

HELD_WHOLE = {
    case[0]: case[1:]
    for case in (
        ("nmea", nmea, "MOST_BYTES", 5000, r"the trip log/receiver has over 4 rows, which take more than"),
        ("smartloc", smartloc, "HELD_BYTES", 200, r"the trip Drive_GT/car has over 5 rows"),
        ("openacc", openacc, "HELD_BYTES", 500, r"the trip platoon has over \d rows"),
        ("nyc-cvpd", nyc_cvpd, "MOST_BYTES", 1000, r"has [\d,]+ octets: an event is held whole, up to 1,000"),
        ("comma2k19", comma2k19, "MOST_BYTES", 100, r"has over 100 octets: a segment is a minute long"),
    )
}


@pytest.mark.parametrize("name", HELD_WHOLE)
def test_a_recording_that_is_held_whole_has_a_limit(made, monkeypatch, name):
    module, limit, value, problem = HELD_WHOLE[name]
    path = str(made.valid(name))
    assert list(get_reader(name).read(path))
    monkeypatch.setattr(module, limit, value)
    with pytest.raises(DataFormatError, match=problem):
        list(get_reader(name).read(path))


@pytest.mark.parametrize("name", ["spmd-bsm", "spmd-wsu", "spmd-hv", "csv", "parquet", "pcap"])
def test_a_trip_over_the_limit_of_a_gathering_reader_is_named(made, name):
    path = str(made.valid(name))
    (trip,) = get_reader(name).read(path)
    with pytest.raises(DataFormatError, match=rf"the trip {trip.trip_id} has over \d rows") as refused:
        list(get_reader(name).within(150).read(path))
    assert "Give each drive of this vehicle a name of its own" in str(refused.value)


def test_a_line_that_never_ends_is_refused(made, monkeypatch):
    from modelcast.io import text_blocks  # noqa: PLC0415 - its limit is changed here alone

    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", 1000)
    monkeypatch.setattr(text_blocks, "_MOST_LINE_BYTES", 5000)
    path = made.write("a.csv", "t,x,y\n0,0,0\n" + "1" * 20_000)
    with pytest.raises(DataFormatError, match="has a line of over 5,000 octets"):
        list(get_reader("csv").read(str(path)))

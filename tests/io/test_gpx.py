"""GPX: what a track point may hold, what a segment is, and what hostile XML meets."""

import tracemalloc

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.gpx_points import CELLS, GpxPoints
from modelcast.io.registry import get_reader
from modelcast.io.trips import read_trips

GARMIN = (
    "<extensions><ns3:TrackPointExtension><ns3:hr>90</ns3:hr><ns3:speed>12.5</ns3:speed>"
    "<ns3:course>45</ns3:course></ns3:TrackPointExtension></extensions>"
)
COUNT = 8


def one_trip(made, points):
    (trip,) = read_trips(made.write("a.gpx", made.gpx(points)))
    return trip


def refusal(made, content):
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(made.write("a.gpx", content), "gpx"))
    return str(caught.value)


@pytest.mark.parametrize(
    "inside",
    [
        "<speed>12.5</speed><course>45</course>",
        "<speed>12.5</speed><cog>45</cog>",
        GARMIN,
        "<extensions><speed>12.5</speed><course>45</course></extensions>",
        "<extensions><speed>3</speed><course>5</course></extensions><speed>12.5</speed><course>45</course>",
    ],
)
@pytest.mark.parametrize("version", ["1.0", "1.1"])
def test_speed_and_course_are_read_wherever_loggers_put_them(made, inside, version):
    points = [made.gpx_point(at, inside=inside) for at in range(COUNT)]
    content = made.gpx(points, version=version).replace(b"<gpx ", b'<gpx xmlns:ns3="made" ')
    (trip,) = read_trips(made.write("a.gpx", content))
    assert (trip.speed_mps == 12.5).all()
    assert trip.heading_rad == pytest.approx(np.pi / 4)


def test_a_track_without_speed_has_positions_and_absolute_time(made):
    trip = one_trip(made, [made.gpx_point(at) for at in range(COUNT)])
    assert trip.trip_id == "a/track-1"
    assert trip.speed_mps is None
    assert trip.heading_rad is None
    assert trip.position_m[:, 1] == pytest.approx(np.arange(COUNT), rel=0.01)
    assert trip.start_unix_s == trip.clock_s == 1710496800.0


def test_a_zone_moves_the_start_only(made):
    times = [f"2024-03-15T11:30:00.{at}+01:30" for at in range(COUNT)]
    trip = one_trip(made, [made.gpx_point(at, time=time) for at, time in enumerate(times)])
    assert trip.start_unix_s == 1710496800.0
    assert trip.t_s == pytest.approx(np.arange(COUNT) / 10, abs=1e-12)


def test_times_without_a_zone_are_utc_and_counted(made):
    times = [f"2024-03-15T10:00:00.{at}" for at in range(COUNT)]
    trip = one_trip(made, [made.gpx_point(at, time=time) for at, time in enumerate(times)])
    assert trip.start_unix_s == 1710496800.0
    assert trip.reading.repaired["no time zone, UTC taken"] == COUNT


def test_a_segment_begins_a_part_even_without_a_gap_in_time(made):
    points = [made.gpx_point(at) for at in range(COUNT)]
    points.insert(5, "</trkseg><trkseg>")
    trip = one_trip(made, points)
    assert trip.segments.tolist() == [0, 5, 8]
    assert trip.gaps_s.size == 0


def test_a_segment_stays_apart_where_points_beside_it_are_left_out(made):
    points = [made.gpx_point(at) for at in range(COUNT)]
    points[5] = made.gpx_point(5, time="")
    points.insert(5, "</trkseg><trkseg>")
    trip = one_trip(made, points)
    assert trip.segments.tolist() == [0, 5, 7]
    assert dict(trip.reading.skipped) == {"time missing": 1}


def test_tracks_share_the_frame_of_the_first_fix(made):
    points = [made.gpx_point(0, latitude=0.0).replace('"-83.5"', '"0"')]
    points += [made.gpx_point(at) for at in range(1, COUNT)]
    points += ["</trkseg></trk><trk><trkseg>", *(made.gpx_point(at) for at in range(COUNT))]
    first, second = read_trips(made.write("a.gpx", made.gpx(points)))
    assert [first.trip_id, second.trip_id] == ["a/track-1", "a/track-2"]
    assert first.origin == second.origin
    assert dict(first.reading.skipped) == {"no fix": 1}
    assert second.position_m[1] == pytest.approx(first.position_m[0], abs=1e-6)


def test_points_without_a_fix_are_skipped_and_late_ones_sorted(made):
    points = [made.gpx_point(at, inside="<fix>none</fix>" if at == 3 else "") for at in range(COUNT)]
    points[0], points[1] = points[1], points[0]
    points.append(points[-1])
    trip = one_trip(made, points)
    assert dict(trip.reading.skipped) == {"no fix": 1, "duplicate time": 1}
    assert dict(trip.reading.repaired) == {"out of time order": 1}


def test_way_points_and_a_track_without_times_are_reported(made):
    points = [made.gpx_point(at) for at in range(COUNT)]
    points += ["</trkseg></trk><trk><trkseg>", *(made.gpx_point(at, time="") for at in range(3))]
    content = made.gpx(points).replace(
        b"<trk>", b'<wpt lat="1" lon="2"/><rte><rtept lat="1" lon="2"/></rte><trk>', 1
    )
    told = {}
    assert len(list(read_trips(made.write("a.gpx", content), on_skipped=told.__setitem__))) == 1
    assert told == {
        "a/track-2": "no usable row: 3 time missing",
        "a/points": "2 way points and points of routes are no recording",
    }


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ('<trkpt lat="91" lon="0"/>', "row 4: lat is '91', not within 90 degrees"),
        ('<trkpt lat="1"/>', "row 4: lon is None, not within 180 degrees"),
        ('<trkpt lat="x" lon="0"/>', "row 4: lat is 'x', not a finite number"),
        ('<trkpt lat="1" lon="0"><ele>nan</ele></trkpt>', "row 4: ele is 'nan', not a finite number"),
        ('<trkpt lat="1" lon="0"><time>12</time></trkpt>', "row 4: time is '12', not a date and time as"),
        (
            """<trkpt lat="1" lon="0"><time>2024-03-15T10:00:00Z</time></trkpt>
            <trkpt lat="1" lon="0"><time>2024-03-15T10:00:01</time></trkpt>""",
            "row 5: time is '2024-03-15T10:00:01', not a date and time with a zone",
        ),
        ('<trkpt lat="1" lon="0"/>', "no track point has a time. Export the track as recorded"),
        ("", "no track point has a time"),
        ("<trkpt", "is not well-formed XML"),
        ("<x>" * 70, "row 4: elements are nested deeper than 64"),
        (f'<trkpt lat="1" lon="0"><time>{"1" * 300}</time></trkpt>', "row 4: time holds over 200 characters"),
    ],
)
def test_what_is_wrong_is_named_by_line_and_value(made, point, message):
    assert message in refusal(made, made.gpx([point]))


def test_other_xml_points_outside_tracks_and_routes_alone_are_refused(made):
    assert "the root is 'kml', not gpx" in refusal(made, b"<kml/>")
    assert "row 1: a track point (trkpt) outside a track" in refusal(
        made, b'<gpx><trkpt lat="1" lon="1"/></gpx>'
    )
    told = refusal(made, b'<gpx><rte><rtept lat="1" lon="1"/></rte></gpx>')
    assert "no track (trk) beside 1 way points and points of routes" in told


def test_entities_are_refused_before_any_is_expanded(made):
    bomb = b'<!DOCTYPE gpx [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><gpx><trk>&b;</trk></gpx>'
    assert "declares the entity 'a'" in refusal(made, bomb)


def test_an_endless_tag_ends_in_an_error_and_not_in_memory(made):
    content = made.gpx(["<!--" + "x" * (8 * 2**20) + "-->"])
    assert "a tag or comment of over 4194304 octets" in refusal(made, content)


@pytest.mark.slow
def test_points_are_held_a_few_at_a_time(made):
    path = made.write("a.gpx", made.gpx([made.gpx_point(0)] * 20_000))
    tracemalloc.start()
    count = sum(len(point.cells) == len(CELLS) for point in GpxPoints(str(path)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count == 20_000
    assert peak < 2 * 2**20


@pytest.mark.slow
def test_a_track_over_the_limit_is_an_error_that_names_it(made):
    path = made.write("a.gpx", made.gpx([made.gpx_point(0)] * (2**16 + 1)))
    with pytest.raises(DataFormatError, match="the trip a/track-1 has over"):
        list(get_reader("gpx").within(2**20).read(str(path)))

"""NMEA: checksums, epochs of two sentences, midnight, missing fixes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io.nmea_sentences import checksum, parse_fix, sentence_body
from modelcast.io.trips import read_trips

MIDNIGHT_2024_11_24_S = 1732406400.0


def one(path):
    (trip,) = read_trips(path, "nmea")
    return trip


def test_published_sentences_have_a_good_checksum():
    assert sentence_body("$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76")
    assert sentence_body("$GPRMC,092750.000,A,5321.6802,N,00630.3372,W,0.02,31.66,280511,,,A*43")


@given(
    st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="$*"), min_size=1),
    st.data(),
)
def test_one_changed_character_fails_the_checksum(body, data):
    line = f"${body}*{checksum(body):02X}"
    assert sentence_body(line) == body
    at = data.draw(st.integers(1, len(body)))
    other = chr(33 + (ord(line[at]) - 32) % 90).replace("$", "~").replace("*", "}")
    if other != line[at]:
        assert sentence_body(line[:at] + other + line[at + 1 :]) is None


def test_gga_and_rmc_of_one_epoch_are_one_sample(made):
    lines = [text(36000 + at / 10, at) for at in range(5) for text in (made.gga, made.rmc)]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert trip.trip_id == "l/receiver"
    assert (len(trip), trip.reading.rows) == (5, 5)
    assert trip.speed_mps == pytest.approx(10.0, abs=1e-4)
    assert trip.heading_rad == pytest.approx(np.pi / 2)
    assert trip.position_m[4] == pytest.approx([0, 4.44], abs=0.02)
    assert trip.origin.altitude_m == 166.0
    assert trip.origin.longitude_deg == -83.5
    assert trip.start_unix_s == pytest.approx(MIDNIGHT_2024_11_24_S - 86400 + 36000)


@pytest.mark.parametrize("talker", ["GP", "GN", "GL", "GA"])
def test_any_talker_is_read(made, talker):
    lines = [text(at / 10, at, talker=talker) for at in range(4) for text in (made.rmc, made.gga)]
    assert len(one(made.write("l.nmea", made.nmea(lines)))) == 4


def test_bad_checksum_is_skipped_and_counted(made):
    lines = [made.rmc(at / 10, at) for at in range(5)]
    lines[2] = lines[2].replace("83", "84")
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (trip.reading.rows, trip.resampled, len(trip)) == (5, True, 5)
    assert dict(trip.reading.skipped) == {"bad checksum": 1}


@pytest.mark.parametrize("dated", [True, False])
def test_time_runs_on_over_midnight(made, dated):
    lines = []
    for at in range(10):
        lines.append(made.gga(86399.5 + at / 10, at))
        if dated:
            lines.append(made.rmc(86399.5 + at / 10, at, day="231124" if at < 5 else "241124"))
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert trip.duration_s == pytest.approx(1.0)
    assert (trip.start_unix_s is not None) == dated
    if dated:
        assert trip.start_unix_s == pytest.approx(MIDNIGHT_2024_11_24_S - 0.5)


def test_date_that_comes_after_midnight_dates_the_epochs_before(made):
    lines = [*(made.gga(86399.8 + at / 10, at) for at in range(4)), made.rmc(0.2, 4, day="241124")]
    assert one(made.write("l.nmea", made.nmea(lines))).start_unix_s == pytest.approx(
        MIDNIGHT_2024_11_24_S - 0.2
    )


def test_no_fix_is_skipped(made):
    lines = [
        made.gga(0.0, quality=0),
        *(made.gga(at / 10, at) for at in range(1, 5)),
        made.rmc(0.5, status="V"),
    ]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert dict(trip.reading.skipped) == {"no fix": 2}
    assert trip.speed_mps is None


def test_cut_last_sentence_is_skipped(made):
    content = made.nmea([made.rmc(at / 10, at) for at in range(5)])[:-20]
    assert dict(one(made.write("l.nmea", content)).reading.skipped) == {"partial last line": 1}


def test_tag_block_and_other_sentences_are_passed_over(made):
    lines = [r"\s:r1*00\ ".strip() + made.rmc(at / 10, at) for at in range(4)] + [
        made.sentence("GPTXT,hello")
    ]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (len(trip), dict(trip.reading.skipped)) == (4, {})


@pytest.mark.parametrize(
    "body",
    [
        "GPRMC,256000.0,A,4200.0,N,08330.0,W,1,1,231124,,",
        "GPRMC,000000.0,A,4270.0,N,08330.0,W,1,1,231124,,",
        "GPRMC,000000.0,A,4200.0,X,08330.0,W,1,1,231124,,",
        "GPRMC,000000.0,A,4200.0,N,08330.0,W,1,1,321324,,",
        "GPRMC,000000.0,A,4200.0,N,08330.0,W,fast,1,231124,,",
        "GPRMC,000000.0,A",
    ],
)
def test_bad_field_under_a_good_checksum_is_an_error(made, body):
    with pytest.raises(ValueError, match=r"."):
        parse_fix(body)
    path = made.write("l.nmea", made.nmea([made.sentence(body)]))
    with pytest.raises(DataFormatError, match=r"row 1: .* in a sentence with a good checksum"):
        list(read_trips(path))


def test_log_without_positions_is_an_error(made):
    path = made.write("l.nmea", made.nmea([made.sentence("GPTXT,hello")]))
    with pytest.raises(DataFormatError, match="no GGA or RMC sentence"):
        list(read_trips(path))

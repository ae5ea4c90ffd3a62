"""NMEA: line ends, checksums, epochs of two sentences, talkers and receivers, midnight, missing fixes."""

import re

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


def drive(made, count=30, talkers=("GP",)):
    """Return sentences of a drive, each epoch sent by every talker."""
    return [
        text(at / 10, at, talker=talker)
        for at in range(count)
        for talker in talkers
        for text in (made.gga, made.rmc)
    ]


def elsewhere(made, talker, at, degrees=43):
    """Return the epoch of another car, a degree further north."""
    return [
        made.sentence(text(at / 10, at, talker=talker)[1:].partition("*")[0].replace(",42", f",{degrees}"))
        for text in (made.gga, made.rmc)
    ]


@pytest.mark.parametrize("behind", [",1710496800000", "\t10:00:00.000", " ok", "1710496800000", ";a*b"])
def test_text_around_a_sentence_is_passed_over(made, behind):
    lines = [f"NMEA,{line}{behind}" for line in drive(made)]
    trip = one(made.write("l.txt", made.nmea(lines)))
    assert (len(trip), trip.reading.rows, dict(trip.reading.skipped)) == (30, 30, {})


def test_glued_sentences_are_read(made):
    trip = one(made.write("l.nmea", "".join(drive(made)).encode()))
    assert (len(trip), trip.reading.rows, dict(trip.reading.skipped)) == (30, 30, {})


def test_a_sentence_cut_by_the_next_is_counted(made):
    lines = drive(made)
    lines[8:10] = [lines[8][:25] + lines[9]]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (len(trip), trip.reading.rows, dict(trip.reading.skipped)) == (30, 31, {"no checksum": 1})


def test_whole_second_stamps_keep_the_first_epoch_of_each_second(made):
    lines = [
        made.sentence(re.sub(r"(,\d{6})\.\d", r"\1", line[1:].partition("*")[0], count=1))
        for line in drive(made)
    ]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (len(trip), trip.reading.rows) == (3, 30)
    assert dict(trip.reading.skipped) == {"duplicate time": 27}
    assert trip.up_m is not None
    assert trip.position_m[1] == pytest.approx([0, 11.1], abs=0.05), "the first of the second, not the last"


def test_sixty_minutes_are_a_degree():
    assert parse_fix("GPRMC,000000.0,A,0960.00000,N,17960.0,E,1,1,231124,,").latitude_deg == 10.0
    with pytest.raises(ValueError, match="not an angle"):
        parse_fix("GPRMC,000000.0,A,0960.00001,N,02000.0,E,1,1,231124,,")


def test_one_bad_field_does_not_cost_the_drive(made):
    lines = [*drive(made), made.sentence("GPGGA,000003.0,4260.1,N,08330.0,W,1,8,1.0,200.0,M,-34.0,M,,")]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (len(trip), dict(trip.reading.skipped)) == (30, {"bad field": 1})


def test_gga_of_one_talker_and_rmc_of_another_are_one_receiver(made):
    lines = [line for at in range(20) for line in (made.gga(at / 10, at), made.rmc(at / 10, at, talker="GN"))]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert (trip.trip_id, len(trip), trip.reading.rows) == ("l/receiver", 20, 20)
    assert trip.speed_mps is not None


def test_every_epoch_by_two_talkers_is_one_receiver_with_duplicates(made):
    trip = one(made.write("l.nmea", made.nmea(drive(made, talkers=("GP", "GN")))))
    assert (len(trip), trip.reading.rows, dict(trip.reading.skipped)) == (30, 60, {"duplicate time": 30})


def test_a_receiver_may_change_its_talker(made):
    lines = [
        text(at / 10, at, talker="GP" if at < 12 else "GN")
        for at in range(30)
        for text in (made.gga, made.rmc)
    ]
    assert len(one(made.write("l.nmea", made.nmea(lines)))) == 30


def test_two_receivers_are_two_trips(made):
    lines = [line for at in range(20) for line in (*drive(made, at + 1)[-2:], *elsewhere(made, "GN", at))]
    lines[4] = lines[4].replace("42", "41", 1)
    first, second = read_trips(made.write("l.nmea", made.nmea(lines)))
    assert (first.trip_id, second.trip_id) == ("l/receiver-GP", "l/receiver-GN")
    assert (len(first), len(second)) == (20, 20)
    assert sum(trip.reading.rows for trip in (first, second)) == 41, "a faulty sentence counts once"
    assert second.origin.latitude_deg - first.origin.latitude_deg == pytest.approx(1.0)
    assert np.abs(np.diff(second.position_m, axis=0)).max() < 2.0


def test_receivers_that_take_turns_are_two_trips(made):
    lines = [
        line
        for at in range(20)
        for line in (made.rmc(at / 5, 2 * at), made.rmc(at / 5 + 0.1, 2 * at + 1, talker="GN"))
    ]
    assert [len(trip) for trip in read_trips(made.write("l.nmea", made.nmea(lines)))] == [20, 20]


def test_two_receivers_with_one_talker_are_refused(made):
    lines = [line for at in range(20) for line in (*drive(made, at + 1)[-2:], *elsewhere(made, "GP", at))]
    with pytest.raises(DataFormatError, match="row 3: two receivers with one talker"):
        list(read_trips(made.write("l.nmea", made.nmea(lines))))


def test_a_receiver_before_its_first_fix_dates_nothing(made):
    cold = ["GPGGA,,,,,,0,,,,,,,", "GPRMC,,V,,,,,,,,,,N", "GPRMC,235959.0,V,,,,,,,060180,,,N"]
    unset = made.rmc(0.0, 0, day="060180")
    lines = [*map(made.sentence, cold), unset, *(made.rmc(at / 10, at) for at in range(1, 20))]
    trip = one(made.write("l.nmea", made.nmea(lines)))
    assert dict(trip.reading.skipped) == {"no fix": 2}
    assert (len(trip), trip.duration_s) == (20, pytest.approx(2.0))
    assert trip.start_unix_s == pytest.approx(MIDNIGHT_2024_11_24_S - 86400.0)


def test_a_log_without_checksums_says_so(made):
    lines = [line.partition("*")[0] for line in drive(made)]
    with pytest.raises(DataFormatError, match=r"with a good checksum \(60 with no checksum\)"):
        list(read_trips(made.write("l.nmea", made.nmea(lines))))


def test_utf16_is_an_error_with_a_remedy(made):
    path = made.write("l.nmea", "\r\n".join(drive(made)).encode("utf-16"))
    for format_name in (None, "nmea"):
        with pytest.raises(DataFormatError, match=r"is UTF-16 text.*Save it as UTF-8"):
            list(read_trips(path, format_name))

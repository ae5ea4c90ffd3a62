"""Every row that a file holds is a sample or counted as skipped, whatever happened to the file.

The identity is ``rows == samples + sum(skipped)``; what is repaired stays a sample. A reader checks it itself
(`Tally.reading`); here the rows are counted a second time, from the text of the file, for every format.
"""

import json
import re
from collections.abc import Callable
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import Tally
from modelcast.io.nmea_sentences import parse_fix, sentence_body
from modelcast.io.registry import FORMATS
from modelcast.io.trips import read_trips

TEXT = (
    *("spmd-bsm", "spmd-wsu", "spmd-hv", "openacc", "nyc-cvpd", "nmea", "smartloc", "kitti-poses"),
    *("highd", "ind", "sumo-fcd", "gpx", "interaction", "ngsim", "ode-bsm", "cv-pilot", "csv"),
)
ENDS = (b"\n", b"\r\n", b"\r", b"\r\r\n", b"\n\n")

place = st.floats(0, 1, exclude_max=True)
mutation = st.one_of(
    st.tuples(st.just("delete"), place, st.integers(1, 12)),
    st.tuples(st.just("double line"), place, st.just(0)),
    st.tuples(st.just("swap lines"), place, st.just(0)),
    st.tuples(st.just("drop line"), place, st.just(0)),
    st.tuples(st.just("digit"), place, st.integers(0, 9)),
    st.tuples(st.just("truncate"), place, st.just(0)),
    st.tuples(st.just("ends"), place, st.integers(0, len(ENDS) - 1)),
    st.tuples(st.just("join lines"), place, st.just(0)),
)


def mutated(content: bytes, kind: str, where: float, what: int) -> bytes:
    """Return the content after one accident."""
    at = int(where * len(content))
    lines = content.splitlines(keepends=True)
    line = int(where * len(lines))
    if kind == "delete":
        return content[:at] + content[at + what :]
    if kind == "truncate":
        return content[:at]
    if kind == "digit":
        digits = [m.start() for m in re.finditer(rb"\d", content)]
        if digits:
            at = digits[int(where * len(digits))]
            return content[:at] + str(what).encode() + content[at + 1 :]
    elif kind == "ends":
        return b"".join(one.rstrip(b"\r\n") + ENDS[what] for one in lines)
    elif kind == "join lines" and lines:
        lines[line] = lines[line].rstrip(b"\r\n")
    elif kind == "double line":
        lines[line:line] = lines[line : line + 1]
    elif kind == "drop line":
        del lines[line : line + 1]
    elif kind == "swap lines" and len(lines) > 1:
        other = (line + 1) % len(lines)
        lines[line], lines[other] = lines[other], lines[line]
    return b"".join(lines)


def filled_lines(content: bytes) -> list[str]:
    text = content.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")
    return [line for line in re.split(r"\r\n|\r|\n", text) if line.strip("\0 \t")]


def table_rows(content: bytes) -> int:
    return len(filled_lines(content)) - 1


def spmd_rows(content: bytes) -> int:
    lines = filled_lines(content)
    return len(lines) - (re.fullmatch(r"[-0-9.eE+ ]*|NULL", lines[0].split(",")[0].strip(' "')) is None)


def openacc_rows(content: bytes) -> int:
    """Rows of one car; every car that has columns holds as many."""
    lines = filled_lines(content)
    return len(lines) - 1 - next(at for at, line in enumerate(lines) if line.split(",")[0].strip() == "Time")


def nyc_rows(content: bytes) -> int:
    return len(json.loads(content)["bsmList"])


def ode_rows(content: bytes) -> int:
    """Objects: one a line, or more where a line end was lost."""
    return len(filled_lines(content)) + len(re.findall(rb'\}\{"metadata"', content))


def all_rows(content: bytes) -> int:
    return len(filled_lines(content))


def gpx_rows(content: bytes) -> int:
    return len(re.findall(rb"<trkpt\b", content))


def fcd_rows(content: bytes) -> int:
    steps = [step for step in ET.fromstring(content) if step.tag == "timestep"]  # noqa: S314 - ours
    return sum(max(len(step), 1) for step in steps if step.get("time") is not None)


def nmea_rows(content: bytes) -> tuple[int, int]:
    """Fewest and most rows: each epoch holds one sentence or two, a faulty sentence is a row."""
    parts = [
        "$" + part
        for part in re.split(r"[\r\n]", content.decode("ascii", "replace"))
        for part in part.split("$")[1:]
    ]
    faulty, kinds = 0, {"GGA": 0, "RMC": 0}
    for part in parts:
        body = sentence_body(part)
        try:
            fix = None if body is None else parse_fix(body)
        except ValueError:
            body, fix = None, None
        faulty += body is None
        if fix is not None:
            kinds[fix.kind] += 1
    return faulty + max(kinds.values()), faulty + sum(kinds.values())


ROWS: dict[str, Callable[[bytes], int]] = {
    "spmd-bsm": spmd_rows, "spmd-wsu": spmd_rows, "spmd-hv": spmd_rows, "nyc-cvpd": nyc_rows,
    "smartloc": all_rows, "kitti-poses": all_rows, "gpx": gpx_rows, "highd": table_rows,
    "ind": table_rows, "sumo-fcd": fcd_rows, "csv": table_rows, "interaction": table_rows,
    "ngsim": table_rows, "ode-bsm": ode_rows, "cv-pilot": table_rows,
}  # fmt: skip


def counted(path, name):
    """Return a file's trips, and the rows it is said to have held: of trips, and of vehicles without one."""
    told: list[str] = []
    trips = list(read_trips(path, name, on_skipped=lambda _, reason: told.append(reason)))
    for trip in trips:
        assert trip.reading.rows == trip.reading.samples + sum(trip.reading.skipped.values())
        assert trip.resampled or len(trip) == trip.reading.samples
        assert all(count > 0 for count in (*trip.reading.skipped.values(), *trip.reading.repaired.values()))
        assert all(np.isfinite(column).all() for column in trip.columns().values())
    empty = [
        sum(int(number) for number in re.findall(r"(\d+) \w", reason.partition("row: ")[2]))
        for reason in told
    ]
    return trips, sum(trip.reading.rows for trip in trips) + sum(empty)


mutations = given(steps=st.lists(mutation, min_size=1, max_size=4))


def account(session_made, name, steps):
    """Whether every row of a mutated file is among those counted, or the file is refused by its name."""
    path = session_made.valid(name)
    content = path.read_bytes()
    for step in steps:
        content = mutated(content, *step)
    path.write_bytes(content)
    try:
        trips, rows = counted(path, name)
    except DataFormatError as error:
        assert str(path) in str(error)  # noqa: PT017 - both outcomes are right
        return
    if name == "nmea":
        fewest, most = nmea_rows(content)
        assert fewest <= rows <= most
    elif name == "openacc":
        assert all(trip.reading.rows == openacc_rows(content) for trip in trips)
    else:
        assert rows == ROWS[name](content)


@pytest.mark.parametrize("name", TEXT)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@example(steps=[("ends", 0.0, 2)])
@example(steps=[("ends", 0.0, 3)])
@mutations
def test_every_row_of_a_mutated_file_is_accounted_for_or_it_is_refused(session_made, name, steps):
    account(session_made, name, steps)


@pytest.mark.slow
@pytest.mark.parametrize("name", TEXT)
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@mutations
def test_every_row_is_accounted_for_whatever_the_mutation(session_made, name, steps):
    account(session_made, name, steps)


BINARY = ("parquet", "comma2k19", "kitti-oxts", "pcap", "ros2-mcap", "ros2-db3")


@pytest.mark.parametrize("name", BINARY)
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(steps=st.lists(mutation, min_size=1, max_size=3), pick=st.integers(0, 5))
def test_every_row_of_a_mutated_binary_file_is_accounted_for_or_it_is_refused(
    session_made, name, steps, pick
):
    path = session_made.valid(name)
    files = [path] if path.is_file() else sorted(one for one in path.rglob("*") if one.is_file())
    victim = files[-1 - pick % len(files)]
    content = victim.read_bytes()
    for step in steps:
        content = mutated(content, *step)
    victim.write_bytes(content)
    try:
        counted(path, name)
    except DataFormatError as error:
        assert str(session_made.folder) in str(error)  # noqa: PT017 - both outcomes are right


def test_the_properties_run_over_all_built_in_readers():
    assert {*TEXT, *BINARY} == set(FORMATS)


@pytest.mark.parametrize("ending", ENDS[:4], ids=repr)
@pytest.mark.parametrize("name", TEXT)
def test_line_ends_change_nothing(made, name, ending):
    path = made.valid(name)
    before = list(read_trips(path, name))
    path.write_bytes(b"".join(line.rstrip(b"\r\n") + ending for line in path.read_bytes().splitlines()))
    after = list(read_trips(path))
    assert [trip.reading for trip in before] == [trip.reading for trip in after]
    for one, other in zip(before, after, strict=True):
        assert one.position_m.tobytes() == other.position_m.tobytes()
        assert one.t_s.tobytes() == other.t_s.tobytes()


def test_a_tally_that_does_not_add_up_is_an_error_of_the_reader():
    tally = Tally()
    tally.skip("no fix", 2)
    with pytest.raises(ValueError, match="5 rows read are not 4 samples and 2 skipped"):
        tally.reading(rows=5, samples=4)

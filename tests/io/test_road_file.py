"""Claims about road files."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.road import read_roads, write_roads
from modelcast.station.context.survey import RoadSurvey, survey_roads
from modelcast.trips.trajectory import build_trajectory


def survey(origin: Origin | None) -> RoadSurvey:
    """A bend of some 600 m."""
    t_s = np.arange(0.0, 60.0, 0.1)
    position = 100.0 * np.stack([np.sin(0.1 * t_s), np.cos(0.1 * t_s)], axis=1)
    return survey_roads([build_trajectory("made/1", t_s, position, origin=origin)])


@pytest.fixture
def roads(tmp_path: Path) -> Path:
    """A road file on Earth."""
    path = tmp_path / "roads.parquet"
    with path.open("wb") as file:
        write_roads(survey(Origin(48.0, 11.0)), file)
    return path


@pytest.mark.parametrize("origin", [None, Origin(48.0, 11.0)])
def test_a_survey_comes_back_as_it_was_written(origin: Origin | None, tmp_path: Path) -> None:
    path, written = tmp_path / "roads.parquet", survey(origin)
    with path.open("wb") as file:
        write_roads(written, file)
    read = read_roads(path)
    np.testing.assert_array_equal(read.places, written.places)
    np.testing.assert_allclose(read.heading_rad, written.heading_rad, atol=1e-6)
    assert read.passes.tolist() == written.passes.tolist()
    assert (read.fingerprints, read.geodetic) == (written.fingerprints, origin is not None)


def changed(path: Path, name: str, values: Any) -> None:
    """Replace one column."""
    table: Any = pq.read_table(path)
    place = table.schema.get_field_index(name)
    pq.write_table(table.set_column(place, name, values), path)


HOSTILE = {
    "heading_rad": (np.float32(np.nan), pa.float32(), "finite"),
    "latitude_deg": (91.0, pa.float64(), "beyond 90"),
    "longitude_deg": (np.inf, pa.float64(), "finite"),
    "trip": (1, pa.int32(), "trips must be of 1"),
    "pass": (7, pa.int32(), "follow each other"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_wrong_value_is_refused(name: str, roads: Path) -> None:
    value, kind, said = HOSTILE[name]
    column = pq.read_table(roads).column(name).to_pylist()
    column[3] = value
    changed(roads, name, pa.array(column, kind))
    with pytest.raises(DataFormatError, match=said):
        read_roads(roads)


@pytest.mark.parametrize(
    ("name", "kind", "said"),
    [
        ("pass", pa.int64(), "32-bit"),
        ("trip", pa.string(), "32-bit"),
        ("heading_rad", pa.string(), "numbers"),
    ],
)
def test_a_column_of_another_type_is_refused(name: str, kind: Any, said: str, roads: Path) -> None:
    column: Any = pq.read_table(roads).column(name)
    changed(roads, name, column.cast(kind))
    with pytest.raises(DataFormatError, match=said):
        read_roads(roads)


def test_blanks_are_refused(roads: Path) -> None:
    for name in ("pass", "heading_rad"):
        column: Any = pq.read_table(roads).column(name)
        changed(roads, name, pa.array([None, *column.to_pylist()[1:]], column.type))
        with pytest.raises(DataFormatError, match=r"blanks|finite"):
            read_roads(roads)


def test_a_missing_column_is_named(roads: Path) -> None:
    table: Any = pq.read_table(roads)
    pq.write_table(table.drop_columns(["heading_rad"]), roads)
    with pytest.raises(DataFormatError, match="lacks heading_rad"):
        read_roads(roads)


def test_a_forged_fingerprint_is_refused(roads: Path) -> None:
    table: Any = pq.read_table(roads)
    metadata = {**table.schema.metadata, b"fingerprints": b"not/one"}
    pq.write_table(table.replace_schema_metadata(metadata), roads)
    with pytest.raises(DataFormatError, match="fingerprints"):
        read_roads(roads)


def test_what_is_no_road_file_is_refused(tmp_path: Path, roads: Path) -> None:
    text = tmp_path / "text.parquet"
    text.write_bytes(b"PAR1 not really PAR1")
    with pytest.raises(DataFormatError, match="no Parquet file"):
        read_roads(text)
    table: Any = pq.read_table(roads)
    pq.write_table(table.replace_schema_metadata({}), text)
    with pytest.raises(DataFormatError, match="no road file"):
        read_roads(text)


def test_no_damaged_byte_is_read_as_another_road(roads: Path) -> None:
    whole = roads.read_bytes()
    written = survey(Origin(48.0, 11.0))
    rng = np.random.default_rng(3)
    for at in rng.integers(0, len(whole), 60).tolist():
        damaged = bytearray(whole)
        damaged[at] ^= 0xFF
        roads.write_bytes(damaged)
        try:
            read = read_roads(roads)
        except DataFormatError:
            continue
        np.testing.assert_array_equal(read.places, written.places)

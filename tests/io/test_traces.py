"""Traces on disk: all formats say the same, read back by small parsers of the tests' own."""

import gzip
import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.io.fcd import read_fcd
from modelcast.io.trace_vectors import vector_columns
from modelcast.io.traces import TRACE_FORMATS, read_trace, trace_writer
from modelcast.study.network.trace import TRACE

KINDS = np.array(["vehicle", "pedestrian"], dtype=object)
Ways = dict[int, list[tuple[float, float, float]]]


def moving(t_s: float) -> dict[str, np.ndarray]:
    """Three stations at a time: one on a circle, one that stands and comes late, one that leaves."""
    here = [0] + [1] * (t_s > 0.45) + [2] * (t_s < 0.95)
    east = {0: 50.0 * np.sin(0.3 * t_s) - 20.0, 1: -8.5, 2: 3.0 + 12.0 * t_s}
    north = {0: 50.0 * np.cos(0.3 * t_s), 1: 7.25, 2: -60.0}
    return {
        "t_s": np.full(len(here), t_s),
        "vehicle": np.array([100 + 7 * one for one in here]),
        "kind": KINDS[[int(one == 1) for one in here]],
        "east_m": np.array([east[one] for one in here]),
        "north_m": np.array([north[one] for one in here]),
        "speed_mps": np.array([{0: 15.0, 1: 0.0, 2: 12.0}[one] for one in here]),
        "heading_rad": np.array([{0: 0.3 * t_s + np.pi / 2, 1: 0.0, 2: np.pi / 2}[one] for one in here]),
        "acceleration_mps2": np.zeros(len(here)),
        "length_m": np.full(len(here), 4.5),
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A trace of two seconds in all formats."""
    place = tmp_path_factory.mktemp("trace") / "t"
    with trace_writer(place, TRACE_FORMATS) as take:
        for step in range(21):
            t_s = round(0.1 * step, 6)
            take("positions", moving(t_s))
            one = {"sender": np.array([100]), "origin": np.array([100]), "message": np.array([step])}
            take(
                "transmissions",
                {
                    "t_s": np.array([t_s + 0.01]), **one, "size_bytes": np.array([200 + step]),
                    "power_dbm": np.array([20.0]), "priority": np.array([5]),
                    "kind": np.array(["update"], dtype=object), "model": np.array(["cv"], dtype=object),
                },
            )  # fmt: skip
            take(
                "receptions",
                {
                    "t_s": np.array([t_s + 0.011]), **one, "receiver": np.array([114]),
                    "distance_m": np.array([30.0 + t_s]), "age_s": np.array([0.011]),
                    "rssi_dbm": np.array([np.nan if step % 2 else -70.5]),
                },
            )  # fmt: skip
    return place


def true_ways(folder: Path) -> Ways:
    """What the table of positions says, by station."""
    found: Ways = defaultdict(list)
    for vehicle, *row in (
        pl.read_parquet(folder / "positions.parquet")
        .select("vehicle", "t_s", "east_m", "north_m")
        .iter_rows()
    ):
        found[vehicle].append((row[0], row[1], row[2]))
    return found


def nodes(folder: Path) -> dict[int, int]:
    """Which station is which node."""
    table = pl.read_csv(folder / "nodes.csv")
    return dict(zip(table["node"], table["vehicle"], strict=True))


def test_columns_carry_units_and_meanings_and_unknown_numbers_are_empty(folder: Path) -> None:
    for name, columns in TRACE.items():
        schema = pq.read_schema(folder / f"{name}.parquet")
        told = [
            (one.name, one.metadata[b"unit"].decode(), one.metadata[b"meaning"].decode()) for one in schema
        ]
        assert told == [(one.name, one.unit, one.description) for one in columns]
    received = read_trace(folder)["receptions"].collect()
    assert received["rssi_dbm"].null_count() == 10
    assert received.height == 21


def test_text_says_what_parquet_says(folder: Path) -> None:
    for name, table in read_trace(folder).items():
        found = table.collect()
        assert pl.read_csv(folder / f"{name}.csv", schema=found.schema).equals(found), name


def test_movements_of_ns2_go_where_stations_went(folder: Path) -> None:
    """The semantics of setdest: from where it is, straight on at a speed, until it is there."""
    first: dict[int, dict[str, float]] = defaultdict(dict)
    orders: dict[int, list[tuple[float, float, float, float]]] = defaultdict(list)
    text = (folder / "positions.ns_movements").read_text(encoding="utf-8")
    shift = re.search(r"shifted by (\S+) m, (\S+) m", text)
    assert shift is not None
    for line in text.splitlines():
        if line.startswith("#"):
            continue
        order = re.fullmatch(r'\$ns_ at (\S+) "\$node_\((\d+)\) setdest (\S+) (\S+) (\S+)"', line)
        if order is None:
            placed = re.fullmatch(r"\$node_\((\d+)\) set ([XYZ])_ (\S+)", line)
            assert placed is not None, line
            first[int(placed[1])][placed[2]] = float(placed[3])
        else:
            orders[int(order[2])].append((float(order[1]), float(order[3]), float(order[4]), float(order[5])))
    ways, named = true_ways(folder), nodes(folder)
    assert len(first) == len(ways) == 3
    for node, vehicle in named.items():
        place = np.array([first[node]["X"], first[node]["Y"]])
        pending, towards, speed, now = list(orders[node]), place, 0.0, 0.0
        for t_s, east, north in ways[vehicle]:
            while pending and pending[0][0] <= t_s + 1e-9:
                at_s, x, y, faster = pending.pop(0)
                place = moved(place, towards, speed * (at_s - now))
                now, towards, speed = at_s, np.array([x, y]), faster
            place = moved(place, towards, speed * (t_s - now))
            now = t_s
            expected = np.array([east + float(shift[1]), north + float(shift[2])])
            np.testing.assert_allclose(place, expected, atol=2e-4)
            assert (place >= 0.0).all()


def moved(place: np.ndarray, towards: np.ndarray, way_m: float) -> np.ndarray:
    """A place after a way towards another, where it ends."""
    left_m = float(np.hypot(*(towards - place)))
    return towards if left_m <= way_m or left_m == 0.0 else place + (towards - place) * (way_m / left_m)


def test_movements_of_bonnmotion_are_times_and_places(folder: Path) -> None:
    with gzip.open(folder / "positions.movements.gz", "rt", encoding="ascii") as file:
        lines = file.read().splitlines()
    rules = dict(line.split("=") for line in (folder / "positions.params").read_text().splitlines())
    assert rules["nn"] == str(len(lines)) == "3"
    assert float(rules["duration"]) == 2.0
    head = (folder / "positions.ns_movements").read_text().splitlines()[1]
    shift = [float(word) for word in re.findall(r"by (\S+) m, (\S+) m", head)[0]]
    ways, named = true_ways(folder), nodes(folder)
    for node, line in enumerate(lines):
        numbers = np.array(line.split(), dtype=float).reshape(-1, 3)
        expected = np.add(ways[named[node]], (0.0, *shift))
        np.testing.assert_allclose(numbers, expected, atol=1e-4)
        assert (numbers[:, 1:] <= [float(rules["x"]), float(rules["y"])]).all()


def test_vectors_of_omnetpp_are_the_columns_by_station(folder: Path) -> None:
    lines = (folder / "trace.vec").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "version 2"
    declared: dict[int, tuple[int, str, str]] = {}
    data: dict[int, list[tuple[float, float]]] = defaultdict(list)
    units: dict[int, str] = {}
    for line in lines:
        if line.startswith("vector "):
            _, number, module, name, spec = line.split()
            station = re.fullmatch(r"modelcast\.station\[(\d+)\]", module)
            assert station is not None
            assert spec == "TV"
            table, column = name.split(":")
            declared[int(number)] = (int(station[1]), table, column)
        elif line.startswith("attr unit "):
            units[max(declared)] = line.removeprefix("attr unit ").strip('"')
        elif line[:1].isdigit():
            number, t_s, value = line.split("\t")
            data[int(number)].append((float(t_s), float(value)))
    who = {"positions": "vehicle", "transmissions": "sender", "receptions": "receiver"}
    expected: dict[tuple[int, str, str], list[tuple[float, float]]] = {}
    for table, station in who.items():
        for column in vector_columns(table):
            rows = pl.read_parquet(folder / f"{table}.parquet").drop_nulls(column.name)
            for (one,), part in rows.group_by(station, maintain_order=True):
                expected[int(str(one)), table, column.name] = list(
                    zip(part["t_s"], part[column.name], strict=True)
                )
    assert {declared[number] for number in data} == set(expected)
    for number, series in data.items():
        np.testing.assert_allclose(series, expected[declared[number]], rtol=1e-8)
        assert np.diff([t_s for t_s, _ in series]).min() >= 0.0
        unit = {one.name: one.unit for one in TRACE[declared[number][1]]}[declared[number][2]]
        assert units[number] == unit


def test_positions_are_traffic_again(folder: Path) -> None:
    frames = list(read_fcd(folder / "positions.parquet"))
    assert [int(frame.active.sum()) for frame in frames] == [len(moving(f.t_s)["vehicle"]) for f in frames]
    expected = moving(1.0)
    found = frames[10]
    assert found.t_s == 1.0
    assert sorted(found.position_m[found.active, 0]) == pytest.approx(sorted(expected["east_m"]))
    assert sorted(found.heading_rad[found.active]) == pytest.approx(sorted(expected["heading_rad"]))


def test_rows_are_written_as_they_come(tmp_path: Path) -> None:
    rows = 130_000
    part = {name: np.arange(rows) for name in ("origin", "message")}
    with trace_writer(tmp_path / "t") as take:
        for number in range(5):
            take("expired", {"t_s": np.full(rows, float(number)), **part})
    file = pq.ParquetFile(tmp_path / "t" / "expired.parquet")
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == [
        260_000,
        260_000,
        rows,
    ]


def test_a_trace_that_breaks_off_leaves_nothing_and_formats_are_known(tmp_path: Path) -> None:
    with pytest.raises(KeyError), trace_writer(tmp_path / "t") as take:
        take("velocities", moving(0.0))
    assert not (tmp_path / "t").exists()
    for formats in (["pcap"], []):
        with pytest.raises(ConfigError, match="parquet, csv"), trace_writer(tmp_path / "t", formats):
            pass
    with pytest.raises(ConfigError, match=r"positions\.parquet is missing"):
        read_trace(tmp_path)


@pytest.mark.parametrize("formats", [("csv",), ("omnetpp", "ns2")])
def test_only_what_was_asked_for_stays(formats: tuple[str, ...], tmp_path: Path) -> None:
    with trace_writer(tmp_path / "t", formats) as take:
        take("positions", moving(0.0))
    files = {path.name for path in (tmp_path / "t").iterdir()} - {"MANIFEST.txt"}
    tables = {f"{name}.csv" for name in TRACE}
    assert files == (tables if formats == ("csv",) else {"trace.vec", "positions.ns_movements", "nodes.csv"})

"""A corpus holds its sources' trips as the readers give them, whatever the way it was made."""

import hashlib
import os
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import polars as pl
import pytest
from filelock import FileLock

from modelcast.cli.reading import TripSource
from modelcast.core.exceptions import ConfigError
from modelcast.corpora import ingestion
from modelcast.corpora.claim import claimed
from modelcast.corpora.executors.base import AbstractCrew, AbstractExecutor
from modelcast.corpora.executors.here import HereCrew
from modelcast.corpora.executors.processes import ProcessExecutor
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.layout import FORMAT, Partition, open_corpus
from modelcast.corpora.packing import Packing, pack
from modelcast.corpora.sources import find_sources
from modelcast.corpora.staging import Staged, Staging, stage
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.parquet import ParquetReader
from modelcast.io.trips import read_trips
from modelcast.trips.inspection import inspect
from modelcast.trips.judgement import judge
from modelcast.trips.trajectory import Trajectory

Sources = Callable[[], Path]


def differing(one: Trajectory, other: Trajectory) -> list[str]:
    """Fields in which two trips differ, to the bit."""
    pairs = ((item.name, getattr(one, item.name), getattr(other, item.name)) for item in fields(one))
    return [
        name
        for name, a, b in pairs
        if type(a) is not type(b)
        or (not np.array_equal(a, b) or a.dtype != b.dtype if isinstance(a, np.ndarray) else a != b)
    ]


def contents(folder: Path) -> dict[str, str]:
    """Every file below a folder with the hash of its octets."""
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def good(folder: Path) -> list[Path]:
    """The sources that can be read, in order of name."""
    return sorted(file for file in folder.iterdir() if file.stem in {"april", "may", "odd"})


def test_trips_come_back_equal_in_every_field(sources: Sources, tmp_path: Path):
    files = good(sources())
    corpus = ingest(find_sources(files), tmp_path / "c", partitions=3).corpus
    found = [trip for one in corpus.partitions for trip in corpus.trips(one)]
    wanted = {trip.trip_id: trip for trip in read_trips(files)}
    assert len(found) == len(wanted) == 21
    assert [differing(trip, wanted[trip.trip_id]) for trip in found] == [[]] * 21
    assert wanted["april/10100-1"].vehicle == "10100"
    assert any(trip.resampled for trip in found)


def test_trips_are_in_order_and_a_vehicles_together(sources: Sources, tmp_path: Path):
    corpus = ingest(find_sources(good(sources())), tmp_path / "c", partitions=5).corpus
    homes: dict[str, set[str]] = {}
    for one in corpus.partitions:
        trips = list(corpus.trips(one))
        assert [trip.trip_id for trip in trips] == sorted(trip.trip_id for trip in trips)
        assert (one.trips, one.rows) == (len(trips), sum(map(len, trips)))
        for trip in trips:
            homes.setdefault(trip.vehicle or trip.trip_id, set()).add(one.name)
    assert len(homes) == 9
    assert all(len(names) == 1 for names in homes.values())
    assert len(corpus.partitions) > 1


def test_what_failed_and_what_was_skipped_is_told(sources: Sources, tmp_path: Path):
    made = ingest(find_sources([sources()]), tmp_path / "c")
    assert list(made.failures) == ["data/broken.csv"]
    assert "row 301: 3 fields where the format has 27" in made.failures["data/broken.csv"]
    assert list(made.skipped) == ["data/notes.txt"]
    assert made.skipped_rows == {"no fix": 18, "position unavailable": 2}
    assert made.rows == pl.read_parquet(tmp_path / "c/catalogue.parquet")["rows"].sum()
    table = pl.read_parquet(tmp_path / "c/skipped.parquet")
    assert table.filter(kind="skipped")["rows"].sum() == 20
    assert table.filter(kind="no trip").rows() == [
        ("data/notes.txt", "", "no reader knows this file", "no trip", None)
    ]


class KilledError(Exception):
    """A run that ends in the middle."""


@dataclass(frozen=True)
class Order(AbstractExecutor):
    """Does pieces of work in this process, of all of them so many, then ends; or the last one first."""

    pieces: int = 1000
    backwards: bool = False

    @contextmanager
    def start(self) -> Iterator[AbstractCrew]:
        """In this process."""
        yield OrderCrew(self.pieces, backwards=self.backwards)


class OrderCrew(HereCrew):
    """Work in the calling process."""

    def __init__(self, pieces: int, *, backwards: bool) -> None:
        self.left, self.backwards = pieces, backwards

    def as_done(self, function: Callable, work: Iterable) -> Iterator[tuple]:
        """In order, or against it."""
        for one in reversed(list(work)) if self.backwards else work:
            if self.left == 0:
                raise KilledError
            self.left -= 1
            yield one, function(one)


@pytest.mark.parametrize(("pieces", "kept"), [(0, 0), (2, 1), (5, 4), (7, 4)])
def test_a_killed_run_goes_on_and_gives_the_same_octets(
    sources: Sources, tmp_path: Path, pieces: int, kept: int
):
    """What was read to its end is kept; the second source fails, and is tried again."""
    found = find_sources([sources()])
    ingest(found, tmp_path / "whole", partitions=4, executor=Order(backwards=True))
    with pytest.raises(KilledError):
        ingest(found, tmp_path / "c", partitions=4, executor=Order(pieces))
    made = ingest(found, tmp_path / "c", partitions=4)
    assert made.kept == kept
    assert contents(tmp_path / "c") == contents(tmp_path / "whole")


def test_a_partition_that_cannot_be_written_is_named_and_stops_no_other(
    sources: Sources, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    found = find_sources(good(sources()))
    whole = ingest(found, tmp_path / "whole", partitions=4).corpus
    name = whole.partitions[0].name

    def fail(work: Packing) -> Partition:
        if work.name == name:
            raise MemoryError("too little")
        return pack(work)

    with monkeypatch.context() as patch:
        patch.setattr(ingestion, "pack", fail)
        with pytest.raises(ConfigError, match=f"partition {name}: .*too little: run again with more"):
            ingest(found, tmp_path / "c", partitions=4)
    assert len(list((tmp_path / "c" / "rows").iterdir())) == len(whole.partitions) - 1
    ingest(found, tmp_path / "c", partitions=4)
    assert contents(tmp_path / "c") == contents(tmp_path / "whole")


def test_a_source_whose_trip_cannot_be_held_fails_alone(
    sources: Sources, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def fail(work: Staging) -> Staged:
        if work.source.label == "may.csv":
            raise MemoryError
        return stage(work)

    monkeypatch.setattr(ingestion, "stage", fail)
    made = ingest(find_sources(good(sources())), tmp_path / "c")
    assert list(made.failures) == ["may.csv"]
    assert "MemoryError" in made.failures["may.csv"]


@pytest.mark.skipif(os.name != "posix", reason="synced on POSIX alone")
def test_samples_are_on_disk_before_they_count(
    sources: Sources, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Else a crash of the machine could leave the marks of a source or a partition, and not its samples."""
    sync, rename = os.fsync, Path.rename
    synced: set[int] = set()
    renamed: list[str] = []

    def note(descriptor: int) -> None:
        synced.add(os.fstat(descriptor).st_ino)
        sync(descriptor)

    def require_synced(folder: Path, target: Path) -> Path:
        assert all(one.stat().st_ino in synced for one in (folder, *folder.rglob("*")))
        renamed.append(target.name)
        return rename(folder, target)

    monkeypatch.setattr(os, "fsync", note)
    monkeypatch.setattr(Path, "rename", require_synced)
    ingest(find_sources(good(sources())[:2]), tmp_path / "c", partitions=1)
    assert renamed == ["source-000000", "source-000001", "partition=0000"]


def test_processes_give_the_same_octets(sources: Sources, tmp_path: Path):
    found = find_sources([sources()])
    ingest(found, tmp_path / "one", partitions=4)
    ingest(found, tmp_path / "two", partitions=4, executor=ProcessExecutor(2))
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


def test_a_source_that_changed_meanwhile_is_read_again(sources: Sources, tmp_path: Path):
    folder = sources()
    with pytest.raises(KilledError):
        ingest(find_sources([folder]), tmp_path / "c", executor=Order(5))
    text = (folder / "may.csv").read_text()
    (folder / "may.csv").write_text(text.replace(",3,", ",4,"))
    made = ingest(find_sources([folder]), tmp_path / "c")
    assert made.kept == 3  # neither this one nor the broken one
    ingest(find_sources([folder]), tmp_path / "whole")
    assert contents(tmp_path / "c") == contents(tmp_path / "whole")


def test_a_source_that_failed_is_read_again(sources: Sources, tmp_path: Path):
    """With more memory, say: its file is the same, and what is held at a time another."""
    files = good(sources())
    few, many = (find_sources(files, memory_bytes=size) for size in (1, 2**30))
    held = [one.reader.within(1000) if one.label == "may.csv" else one.reader for one in few.sources]
    short = [replace(one, reader=reader) for one, reader in zip(few.sources, held, strict=True)]
    with pytest.raises(KilledError):
        ingest(replace(few, sources=tuple(short)), tmp_path / "c", executor=Order(3))
    made = ingest(many, tmp_path / "c")
    assert (made.kept, dict(made.failures), made.trips) == (2, {}, 21)


@dataclass(frozen=True)
class _Told(AbstractTripReader):
    """Runs out of memory, or skips in an order that a test gives."""

    skips: tuple[tuple[str, str], ...] = ()

    name: ClassVar[str] = "told"

    def matches(self, path: Path, head: bytes) -> bool:
        """Every file."""
        del path, head
        return True

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """None, or one."""
        if not self.skips:
            raise MemoryError
        for what, reason in self.skips:
            on_skipped(what, reason)
        yield from read_trips([path])


def test_who_bounds_the_memory_is_named(sources: Sources, tmp_path: Path):
    """What a process may gather of a file leaves room for making trips of it."""
    found = find_sources(good(sources()), memory_bytes=1200 * 2**20)
    held = [one.reader.held_bytes for one in found.sources if isinstance(one.reader, ParquetReader)]
    assert held == [850 * 2**20 // 8]
    hungry = replace(found, sources=tuple(replace(one, reader=_Told()) for one in found.sources))
    with pytest.raises(ConfigError, match="more than the 1,200 MiB that --memory gives a process"):
        ingest(hungry, tmp_path / "c")


def test_what_was_skipped_does_not_depend_on_the_order_of_reading(sources: Sources, tmp_path: Path):
    """Which depends on the memory there is; two skipped vehicles may share a name."""
    skips = (("b", "no fix"), ("a", "too short"), ("a", "no fix"))
    made = []
    for at, order in enumerate((skips, skips[::-1])):
        found = find_sources(good(sources())[:1])
        found = replace(found, sources=(replace(found.sources[0], reader=_Told(order)),))
        made.append(ingest(found, tmp_path / str(at)))
    assert list(made[0].skipped.items()) == [("a", "no fix"), ("a#2", "too short"), ("b", "no fix")]
    assert contents(tmp_path / "0") == contents(tmp_path / "1")


def test_rows_of_vehicles_without_a_trip_are_counted(sources: Sources, tmp_path: Path):
    file = sources() / "may.csv"
    text = file.read_text()
    rows = [row for row in text.splitlines(keepends=True) if row.startswith("10100,3,")][:5]
    invalid = [row.replace("10100,3,", "10300,1,").replace(",1,1349", ",0,1349") for row in rows]
    file.write_text(text + "".join(invalid))
    made = ingest(find_sources([file]), tmp_path / "c")
    assert (made.rows, made.skipped_rows, made.rows_without_trip) == (240, {"no fix": 6}, 5)
    table = pl.read_parquet(tmp_path / "c/skipped.parquet")
    assert table.filter(kind="no trip").rows() == [
        ("may.csv", "may/10300-1", "no usable row: 5 no fix", "no trip", 5)
    ]


def test_trips_that_share_a_name_are_told_apart_in_order_of_the_sources(sources: Sources, tmp_path: Path):
    corpus = ingest(find_sources(good(sources())), tmp_path / "c", partitions=3).corpus
    found = {trip.trip_id: trip.source for one in corpus.partitions for trip in corpus.trips(one)}
    assert (found["april/10100-1"], found["april/10100-1#2"]) == ("spmd-wsu", "parquet")


def test_a_name_with_a_number_is_no_name_of_another_trip(tmp_path: Path):
    """Recorders that number on themselves: ``d/a`` twice, and ``d/a#2``; every reading names them alike."""
    paths = [tmp_path / one / "d.csv" for one in "123"]
    for path, vehicle in zip(paths, ("a", "a#2", "a"), strict=True):
        path.parent.mkdir()
        rows = "".join(f"{at / 10},{at},0,{vehicle}\n" for at in range(30))
        path.write_text(f"t_s,east_m,north_m,vehicle\n{rows}")
    corpus = ingest(find_sources(paths), tmp_path / "c").corpus
    found = [trip.trip_id for one in corpus.partitions for trip in corpus.trips(one)]
    assert found == ["d/a", "d/a#2", "d/a#3"]
    assert [trip.trip_id for trip in read_trips(paths)] == found
    assert [trip.trip_id for trip in TripSource(paths)] == found


def test_a_table_that_names_vehicles_tells_them_and_one_of_whole_identifiers_does_not(tmp_path: Path):
    named: dict[str, str] = {}
    for column in ("vehicle", "trip", "other"):
        file = tmp_path / f"{column}.csv"
        file.write_text(
            f"t_s,east_m,north_m,{column}\n" + "".join(f"{at / 10},{at},0,7\n" for at in range(30))
        )
        named |= {trip.trip_id: trip.vehicle for trip in read_trips(file)}
    assert named == {"vehicle/7": "7", "7": "", "other/vehicle": ""}
    corpus = ingest(find_sources([tmp_path / "vehicle.csv"]), tmp_path / "c").corpus
    assert corpus.catalogue(corpus.partitions[0])["vehicle"].to_pylist() == ["7"]


def test_only_trips_of_the_pattern_are_taken(sources: Sources, tmp_path: Path):
    made = ingest(find_sources(good(sources()), pattern="*/10103-*"), tmp_path / "c")
    assert made.trips == 3


def test_a_folder_that_is_no_corpus_is_left_alone(sources: Sources, tmp_path: Path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("all of it")
    with pytest.raises(ConfigError, match="not empty and no corpus"):
        ingest(find_sources(good(sources())), mine)
    assert contents(mine).keys() == {"thesis.tex"}
    with pytest.raises(ConfigError, match="is a file"):
        ingest(find_sources(good(sources())), mine / "thesis.tex")


def test_what_a_run_leaves_that_is_killed_at_once_is_gone_on_with(sources: Sources, tmp_path: Path):
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "ingest.lock").touch()
    (tmp_path / "c" / ".ingest.json.partial-0123456789abcdef").touch()
    assert ingest(find_sources(good(sources())[:1]), tmp_path / "c").trips == 12


def test_only_one_ingest_writes_to_a_corpus(sources: Sources, tmp_path: Path):
    (tmp_path / "c").mkdir()
    with (
        FileLock(tmp_path / "c" / "ingest.lock"),
        pytest.raises(ConfigError, match="another ingest is writing"),
    ):
        ingest(find_sources(good(sources())[:1]), tmp_path / "c")


def test_a_run_that_takes_over_at_once_is_the_only_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """One that takes the lock the moment it is released holds that which others look at."""
    plan = {"format": FORMAT}
    release = FileLock.release
    others: list[FileLock] = []

    def release_and_let_another_take_it(lock: FileLock, force: bool = False) -> None:
        release(lock, force)
        if not others:
            others.append(FileLock(tmp_path / "c" / "ingest.lock"))
            others[0].acquire(timeout=0)

    with monkeypatch.context() as patch:
        patch.setattr(FileLock, "release", release_and_let_another_take_it)
        with claimed(tmp_path / "c", plan, shown="c"):
            pass
    with (
        pytest.raises(ConfigError, match="another ingest is writing"),
        claimed(tmp_path / "c", plan, shown="c"),
    ):
        pass
    others[0].release()


def test_a_finished_corpus_is_never_changed(sources: Sources, tmp_path: Path):
    files = good(sources())
    ingest(find_sources(files), tmp_path / "c")
    before = contents(tmp_path / "c")
    with pytest.raises(ConfigError, match="finished corpus"):
        ingest(find_sources(files[:1]), tmp_path / "c")
    assert contents(tmp_path / "c") == before
    (tmp_path / "c" / "staging").mkdir()  # of a run killed at its very end
    with pytest.raises(ConfigError, match="finished corpus"):
        ingest(find_sources(files), tmp_path / "c")
    assert not (tmp_path / "c" / "staging").exists()


def test_an_unfinished_corpus_goes_on_with_its_own_sources_only(sources: Sources, tmp_path: Path):
    files = good(sources())
    with pytest.raises(KilledError):
        ingest(find_sources(files), tmp_path / "c", executor=Order(1))
    for other in (find_sources(files[:1]), find_sources(files, pattern="a*")):
        with pytest.raises(ConfigError, match="other sources or settings"):
            ingest(other, tmp_path / "c")
    assert ingest(find_sources(files), tmp_path / "c").kept == 1


def test_sources_and_corpus_lie_apart(sources: Sources):
    folder = sources()
    with pytest.raises(ConfigError, match="lie in one another"):
        ingest(find_sources(good(folder)), folder)


@dataclass(frozen=True)
class Blind(AbstractExecutor):
    """Workers that do not see a folder."""

    folder: Path

    @contextmanager
    def start(self) -> Iterator[AbstractCrew]:
        """In this process."""
        yield BlindCrew(self.folder)


class BlindCrew(HereCrew):
    """Work in the calling process."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def require_shared(self, folders: Sequence[Path]) -> None:
        """All folders but one are."""
        assert all(one.is_dir() for one in folders)
        if self.folder in folders:
            raise ConfigError(f"worker 1 does not see {self.folder}")


def test_every_folder_with_a_source_must_be_seen_by_the_workers(sources: Sources, tmp_path: Path):
    april, may, odd = good(sources())
    (tmp_path / "more").mkdir()
    (tmp_path / "packed").mkdir()
    may.rename(tmp_path / "more" / "may.csv")
    with zipfile.ZipFile(tmp_path / "packed" / "odd.zip", "w") as archive:
        archive.write(odd, "odd.parquet")
    found = find_sources([april, tmp_path / "more", tmp_path / "packed"])
    for folder in (april.parent, tmp_path / "more", tmp_path / "packed", tmp_path / "c"):
        with pytest.raises(ConfigError, match=f"does not see {folder}"):
            ingest(found, tmp_path / "c", executor=Blind(folder))
    assert ingest(found, tmp_path / "c", executor=Blind(tmp_path)).trips == 21


def test_without_a_usable_trip_nothing_is_left(sources: Sources, tmp_path: Path):
    with pytest.raises(ConfigError, match=r"no usable trip: .*broken.csv: row 301"):
        ingest(find_sources([sources() / "broken.csv"]), tmp_path / "c")
    assert not (tmp_path / "c").exists()


def test_a_corpus_opens_where_it_was_moved_to(sources: Sources, tmp_path: Path):
    ingest(find_sources(good(sources())), tmp_path / "c")
    (tmp_path / "c").rename(tmp_path / "d")
    corpus = open_corpus(tmp_path / "d")
    assert sum(1 for one in corpus.partitions for _ in corpus.trips(one)) == 21


def test_quality_is_what_trips_tells_where_it_is_asked_for(sources: Sources, tmp_path: Path):
    files = good(sources())
    ingest(find_sources(files), tmp_path / "plain")
    assert pl.read_parquet(tmp_path / "plain/catalogue.parquet")["warnings"].is_null().all()
    ingest(find_sources(files), tmp_path / "c", thresholds_m=(0.1, 0.2, 0.3, 0.5))
    told = {row["trip"]: row for row in pl.read_parquet(tmp_path / "c/catalogue.parquet").to_dicts()}
    for trip in read_trips(files):
        found = inspect(trip)
        row = told[trip.trip_id]
        assert row["grid_m"] == found.grid_m
        assert row["warnings"] == list(judge(found, (0.1, 0.2, 0.3, 0.5), smoothed=not found.is_clean))
    assert "jump" not in told["odd/gap"]["warnings"]


def test_an_ingest_that_inspects_does_not_go_on_with_one_that_does_not(sources: Sources, tmp_path: Path):
    files = good(sources())
    with pytest.raises(KilledError):
        ingest(find_sources(files), tmp_path / "c", executor=Order(1))
    with pytest.raises(ConfigError, match="other sources or settings"):
        ingest(find_sources(files), tmp_path / "c", thresholds_m=(0.1, 0.2, 0.3, 0.5))

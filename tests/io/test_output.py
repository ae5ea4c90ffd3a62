"""Outputs come whole or not at all: two writers at a time, killed ones, links, inputs."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow.parquet as pq
import pytest

from file_room import room
from modelcast.core.exceptions import ConfigError
from modelcast.io.manifest import MANIFEST
from modelcast.io.output import atomic_file, atomic_folder, require_apart, written_into

WRITER = """
import os, signal, sys
from modelcast.io.output import atomic_file, atomic_folder
kind, target, text, end = sys.argv[1:]
def wait():
    print("ready", flush=True)
    if end == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    sys.stdin.readline()
if kind == "file":
    with atomic_file(target) as file:
        file.write(text.encode() * 1000)
        wait()
else:
    with atomic_folder(target) as folder:
        (folder / "a").write_text(text * 1000)
        wait()
"""


def writer(kind: str, target: Path, text: str, end: str = "well") -> subprocess.Popen[str]:
    """A real process that has written half of its output when it says so."""
    started = subprocess.Popen(  # noqa: S603 - our own interpreter and text
        [sys.executable, "-c", WRITER, kind, str(target), text, end],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert started.stdout is not None
    assert started.stdout.readline() == "ready\n"
    return started


def content(kind: str, target: Path) -> str:
    return (target if kind == "file" else target / "a").read_text()


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_of_two_writers_at_a_time_the_last_to_end_wins_whole(kind: str, tmp_path: Path) -> None:
    target = tmp_path / "out"
    first, second = writer(kind, target, "1"), writer(kind, target, "2")
    assert len(list(tmp_path.iterdir())) == 2  # neither has cleaned up the other's
    for process, text in ((second, "2"), (first, "1")):
        process.communicate("go\n")
        assert process.returncode == 0
        assert content(kind, target) == text * 1000
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_what_a_killed_writer_left_is_removed_by_the_next_and_the_old_output_stays(
    kind: str, tmp_path: Path
) -> None:
    target = tmp_path / "out"
    writer(kind, target, "1").communicate("go\n")
    killed = writer(kind, target, "2", "kill")
    killed.communicate()
    assert killed.returncode == -signal.SIGKILL
    assert content(kind, target) == "1" * 1000
    assert len(list(tmp_path.iterdir())) == 2
    writer(kind, target, "3").communicate("go\n")
    assert content(kind, target) == "3" * 1000
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_an_old_folder_that_a_killed_run_had_moved_away_is_put_back(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with atomic_folder(target) as folder:
        (folder / "a").write_text("old")
    target.rename(tmp_path / ".out.old-0123456789abcdef")
    with pytest.raises(RuntimeError), atomic_folder(target):  # noqa: PT012
        assert (target / "a").read_text() == "old"
        raise RuntimeError
    assert (target / "a").read_text() == "old"


@pytest.mark.parametrize(
    "name", [".out.partial", ".out.partial-1-0", ".out.partial-0123", "x.out.partial-0123456789abcdef"]
)
def test_what_is_not_certainly_a_leftover_stays(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    with atomic_file(tmp_path / "out") as file:
        file.write(b"a")
    assert (tmp_path / name).read_text() == "mine"


def test_a_link_named_as_a_leftover_is_neither_followed_nor_removed(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("mine")
    link = tmp_path / ".out.partial-0123456789abcdef"
    link.symlink_to(precious)
    with atomic_file(tmp_path / "out") as file:
        file.write(b"a")
    assert link.is_symlink()
    assert precious.read_text() == "mine"


def test_an_error_in_the_block_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "out"
    target.write_text("old")
    with pytest.raises(KeyboardInterrupt), atomic_file(target) as file:  # noqa: PT012
        file.write(b"new")
        raise KeyboardInterrupt
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_replaced_file_keeps_its_permissions_and_a_link_its_target(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "real").chmod(0o600)
    (tmp_path / "link").symlink_to("real")
    with atomic_file(tmp_path / "link") as file:
        file.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"
    assert (tmp_path / "real").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("how", ["itself", "spelling", "link", "hard link", "in a folder"])
def test_an_input_is_no_output_by_whatever_name(how: str, tmp_path: Path) -> None:
    given = tmp_path / "given.csv"
    given.write_text("mine")
    out = tmp_path / "out.csv"
    if how == "link":
        out.symlink_to(given)
    elif how == "hard link":
        out.hardlink_to(given)
    else:
        out = tmp_path / ("../" + tmp_path.name if how == "spelling" else "") / "given.csv"
    inputs = [tmp_path if how == "in a folder" else given]
    with pytest.raises(ConfigError, match="which is never replaced"), atomic_file(out, inputs=inputs):
        pytest.fail("the block must not run")
    assert given.read_text() == "mine"


def test_another_file_is_an_output(tmp_path: Path) -> None:
    (tmp_path / "given").write_text("same text")
    (tmp_path / "out").write_text("same text")
    require_apart(tmp_path / "out", [tmp_path / "given", tmp_path / "missing"])


@pytest.mark.parametrize(
    ("name", "said"),
    [("folder", "is a folder"), ("pipe", "pipe"), ("no/x", "does not exist"), ("loop", "loop")],
)
def test_a_place_that_takes_no_file_is_named(name: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    with (
        pytest.raises(ConfigError, match=said) as caught,
        atomic_file(tmp_path / name, shown=f"--out {name}"),
    ):
        pytest.fail("the block must not run")
    assert str(caught.value).startswith(f"--out {name}")


def test_a_failed_run_removes_the_parents_it_made(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), atomic_folder(tmp_path / "a" / "b" / "out"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_a_parent_that_is_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(ConfigError, match="file is a file, not a folder"),
        atomic_folder(tmp_path / "file/out"),
    ):
        pytest.fail("the block must not run")


def test_the_result_of_another_command_is_not_replaced(tmp_path: Path) -> None:
    target = tmp_path / "out"
    for _ in range(2):
        with atomic_folder(target, command="compare") as folder:
            (folder / "a").touch()
    assert (target / MANIFEST).read_text() == "# modelcast compare\na\n"
    with pytest.raises(ConfigError, match="modelcast compare"), atomic_folder(target, command="evaluate"):
        pytest.fail("the block must not run")
    assert (target / "a").exists()


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs Linux's /proc")
@pytest.mark.skipif(os.name == "nt", reason="limits as POSIX has them")
@pytest.mark.parametrize("write", ["python", "polars", "arrow"])
def test_where_there_is_no_room_the_output_is_named_and_not_what_was_begun(
    write: str, tmp_path: Path
) -> None:
    frame = pl.DataFrame({"a": np.arange(4096)})
    writers: dict[str, Callable[[Path], object]] = {
        "python": lambda path: path.write_bytes(bytes(4096)),
        "polars": frame.write_csv,
        "arrow": lambda path: pq.write_table(frame.to_arrow(), path),
    }

    def run() -> None:
        with room(1024), atomic_folder(tmp_path / "out", shown="--out") as folder:
            writers[write](folder / "a")

    with pytest.raises(ConfigError, match=r"^--out cannot be written: File too large\. Make room there"):
        run()
    assert list(tmp_path.iterdir()) == []


def test_files_that_are_written_into_a_folder_take_their_places_together(tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    for name in ("a", "other", "figures/b"):
        (tmp_path / name).write_text("old")

    def write(place: Path, *, ends_well: bool) -> list[Path]:
        (place / "figures").mkdir()
        (place / "a").write_text("new")
        if not ends_well:
            raise KeyboardInterrupt
        (place / "figures" / "b").write_text("new")
        return [place / "a", place / "figures" / "b"]

    with pytest.raises(KeyboardInterrupt):
        written_into(tmp_path, partial(write, ends_well=False))
    assert contents(tmp_path) == {"a": "old", "other": "old", "figures/b": "old"}
    assert written_into(tmp_path, partial(write, ends_well=True)) == [
        tmp_path / "a",
        tmp_path / "figures" / "b",
    ]
    assert contents(tmp_path) == {"a": "new", "other": "old", "figures/b": "new"}


@pytest.mark.skipif(os.name != "posix", reason="folders are not synced elsewhere")
def test_files_are_on_the_disk_before_they_take_their_places_and_so_are_these(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[tuple[int, bool]] = []
    sync = os.fsync

    def noted(descriptor: int) -> None:
        synced.append((os.fstat(descriptor).st_ino, (tmp_path / "a").exists()))
        sync(descriptor)

    def write(place: Path) -> list[Path]:
        (place / "a").write_text("new")
        return [place / "a"]

    monkeypatch.setattr(os, "fsync", noted)
    written_into(tmp_path, write)
    file, folder = (tmp_path / "a").stat().st_ino, tmp_path.stat().st_ino
    assert (file, False) in synced
    assert (folder, True) in synced


def contents(folder: Path) -> dict[str, str]:
    """Texts of all files of a folder."""
    found = [path for path in folder.rglob("*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_text() for path in found}


def test_a_folder_that_takes_no_new_one_is_named_and_nobody_waits() -> None:
    with pytest.raises(ConfigError, match="/proc/out cannot be written: "), atomic_folder("/proc/out"):
        pass


@pytest.mark.parametrize("old", [True, False])
def test_an_interrupt_after_a_folder_took_its_place_says_that_it_is_written(
    old: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out"
    if old:
        with atomic_folder(target) as folder:
            (folder / "a.txt").write_text("old")
    press_at_sync_of(tmp_path, monkeypatch)
    with pytest.raises(KeyboardInterrupt) as caught, atomic_folder(target, shown="--out out") as folder:
        (folder / "a.txt").write_text("new")
    assert (target / "a.txt").read_text() == "new"
    assert caught.value.__notes__ == ["--out out is written"]


def test_an_interrupt_while_the_old_folder_is_removed_says_that_the_new_one_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out"
    with atomic_folder(target) as folder:
        (folder / "a.txt").write_text("old")

    def press(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(shutil, "rmtree", press)
    with pytest.raises(KeyboardInterrupt) as caught, atomic_folder(target, shown="--out out") as folder:
        (folder / "a.txt").write_text("new")
    assert caught.value.__notes__[-1] == "--out out is written"


def test_an_interrupt_before_a_folder_takes_its_place_says_that_it_is_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "out"
    target.mkdir()
    with pytest.raises(KeyboardInterrupt) as caught, atomic_folder(target, shown="--out out"):
        raise KeyboardInterrupt
    assert caught.value.__notes__ == ["--out out is as it was"]


def test_an_interrupt_after_a_file_took_its_place_says_that_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "a.txt"
    press_at_sync_of(tmp_path, monkeypatch)
    with pytest.raises(KeyboardInterrupt) as caught, atomic_file(target, shown="--out a") as file:
        file.write(b"new")
    assert caught.value.__notes__ == ["--out a is written"]


def press_at_sync_of(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have Ctrl-C come when the operating system is asked to write a folder out."""
    sync = os.fsync

    def press(descriptor: int) -> None:
        if os.path.samestat(os.fstat(descriptor), folder.stat()):
            raise KeyboardInterrupt
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", press)

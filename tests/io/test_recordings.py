"""Files and folders as they are found: what is read, what is reported, what is refused."""

import os
import socket
from pathlib import Path

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.places import readable_kind
from modelcast.io.recordings import Recordings
from modelcast.io.registry import detect_format

TABLE = "t_s,east_m,north_m\n" + "".join(f"{i / 10},{i},0\n" for i in range(20))


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    (tmp_path / "sub").mkdir()
    for name in ("a.csv", "sub/s.csv", "z.csv", ".hidden.csv"):
        (tmp_path / name).write_text(TABLE)
    (tmp_path / "notes.txt").write_text("nothing")
    (tmp_path / "link").symlink_to("sub")
    os.mkfifo(tmp_path / "fifo.csv")
    return tmp_path


def test_a_folder_leaves_out_only_what_it_reports(folder: Path) -> None:
    told: dict[str, str] = {}
    found = [Path(one.path).name for one in Recordings(folder, on_skipped=told.__setitem__)]
    assert found == ["a.csv", "s.csv", "z.csv"]
    assert {Path(name).name for name in told} == {".hidden.csv", "fifo.csv", "link", "notes.txt"}


def test_a_file_named_twice_or_below_a_folder_named_is_read_once(folder: Path) -> None:
    again = folder / "sub" / ".." / "a.csv"
    assert len(list(Recordings([folder / "a.csv", again, folder]))) == 3


def test_after_an_error_the_next_recording_can_be_had(folder: Path) -> None:
    (folder / "b.csv").symlink_to("nowhere")
    recordings = Recordings([folder / "missing.csv", folder])
    failed: list[str] = []
    found: list[str] = []
    while True:
        try:
            one = next(recordings, None)
        except DataFormatError as error:
            failed.append(f"{Path(recordings.at).name}: {error.problem}")
            continue
        if one is None:
            break
        found.append(recordings.label(one.path))
    assert failed == ["missing.csv: does not exist", "b.csv: is a broken link, to nowhere"]
    assert found == [f"{folder.name}/{name}" for name in ("a.csv", "sub/s.csv", "z.csv")]


def test_text_that_is_no_utf8_is_an_error_of_its_file(tmp_path: Path) -> None:
    class Reader:
        def read(self, path: str, _report: object) -> object:
            yield Path(path).read_text(encoding="utf-8")

    (tmp_path / "a").write_bytes(b"caf\xe9")
    from modelcast.io.recordings import Recording  # noqa: PLC0415

    with pytest.raises(DataFormatError, match=r"0xe9 at 3.*UTF-8"):
        list(Recording(str(tmp_path / "a"), Reader()).trips())  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["pipe", "socket", "device"])
def test_what_is_no_file_is_named_and_never_opened(kind: str, tmp_path: Path) -> None:
    path = Path("/dev/zero") if kind == "device" else tmp_path / "x"
    if kind == "pipe":
        os.mkfifo(path)
    with socket.socket(socket.AF_UNIX) as server:
        if kind == "socket":
            server.bind(str(path))
        for look in (readable_kind, detect_format):
            with pytest.raises(DataFormatError, match=f"is a {kind}, not a file"):
                look(path)


def test_the_standard_input_is_refused_with_a_remedy() -> None:
    with pytest.raises(DataFormatError, match="standard input is not read here"):
        readable_kind("-")

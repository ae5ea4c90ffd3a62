"""The first five minutes: bad files, default folders, interrupts, pipes, help, doctor, progress."""

import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from modelcast.cli import diagnosis, installation, kernel_cache
from modelcast.cli.app import BROKEN_PIPE, run
from modelcast.cli.command_list import COMMANDS
from modelcast.cli.signals import INTERRUPTED
from modelcast.core.exceptions import MissingExtraError
from modelcast.core.extras import EXTRAS
from modelcast.core.version import package_version
from modelcast.io.csv import CsvReader
from modelcast.trips.trajectory import Trajectory

TABLE = "t_s,east_m,north_m\n" + "".join(f"{i / 10},{i},0\n" for i in range(40))


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    folder = tmp_path / "trips"
    folder.mkdir()
    for name in ("a", "b", "c"):
        (folder / f"{name}.csv").write_text(TABLE)
    return folder


@pytest.mark.parametrize(
    "error", [ValueError("odd"), MemoryError(), OSError(5, "Input/output error"), KeyError("x")]
)
def test_whatever_fails_in_a_file_costs_that_file_alone(
    error: Exception, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A reader that fails on b.csv, with any error."""
    read = CsvReader.read

    def failing(self: CsvReader, path: str, *rest: object) -> Iterator[Trajectory]:
        if path.endswith("b.csv"):
            raise error
        yield from read(self, path, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(CsvReader, "read", failing)
    assert run(["trips", str(folder), "--json"]) == 3
    shown = capsys.readouterr()
    document = json.loads(shown.out)
    assert [trip["trip_id"] for trip in document["trips"]] == ["a/vehicle", "c/vehicle"]
    assert list(document["failures"]) == ["trips/b.csv"]
    assert "b.csv" in shown.err
    assert shown.err.count("\n") == 1
    if not isinstance(error, OSError):
        assert type(error).__name__ in document["failures"]["trips/b.csv"]


def test_names_that_are_no_text_and_control_characters_are_written_out(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / os.fsdecode(b"\xff\x1b[2J.csv")).write_text(TABLE.replace("0.3", "oops"))
    assert run(["trips", str(folder)]) == 3
    shown = capsys.readouterr()
    assert "\x1b" not in shown.err + shown.out
    assert "\\x1b[2J.csv" in shown.err


def test_a_missing_file_costs_an_evaluation_nothing_else(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    paths = [str(folder / "a.csv"), str(tmp_path / "missing.csv")]
    small = ["--bank", "cv", "--per", "0", "--seeds", "1", "--threshold", "0.3", "--no-references", "--quiet"]
    assert run(["evaluate", *paths, "--out", str(out), *small]) == 3
    assert list(json.loads((out / "summary.json").read_text())["failures"]) == ["missing.csv"]
    assert list(json.loads((out / "run.json").read_text())["inputs"]) == [paths[0]]


@pytest.mark.slow
def test_evaluate_works_after_the_demo_and_compare_after_evaluate(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All with their default folders, and each again over its own result."""
    monkeypatch.chdir(tmp_path)
    small = ["--bank", "cv", "--per", "0", "--seeds", "1", "--threshold", "0.3", "--no-references", "--quiet"]
    trip = str(folder / "a.csv")
    assert run(["demo", "--duration", "90", "--quiet"]) == 0
    for _ in range(2):
        assert run(["evaluate", trip, *small]) == 0
        assert run(["compare", trip, *small, "--protocol", "recorded", "--resamples", "20"]) == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["compare", "demo", "evaluate"]
    assert run(["evaluate", trip, *small, "--out", "out/compare"]) == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that Linux has")
@pytest.mark.parametrize("words", ["", "--help", "trips a.csv"])
def test_what_is_printed_where_there_is_no_room_costs_one_line(words: str, folder: Path) -> None:
    with Path("/dev/full").open("w") as full:
        found = subprocess.run(  # noqa: S603 - our own interpreter
            [sys.executable, "-m", "modelcast", *words.split()],
            cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    line = "modelcast: No space left on device. Make room there, or name another place.\n"
    assert (found.returncode, found.stderr) == (2, line)


@pytest.mark.parametrize("command", ["evaluate", "compare", "coverage"])
@pytest.mark.parametrize("option", [("--format", "avi"), ("--threshold", "-1"), ("--columns", "t")])
def test_a_wrong_option_is_told_before_any_folder_is_looked_at(
    command: str, option: tuple[str, str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = folder / "mine"
    mine.mkdir()
    (mine / "notes.txt").touch()
    assert run([command, str(folder), *option, "--out", str(mine)]) == 2
    assert "notes.txt" not in capsys.readouterr().err
    assert run([command, str(folder), *option, "--out", str(folder / "new" / "out")]) == 2
    assert not (folder / "new").exists()


def test_convert_and_trace_refuse_to_replace_an_input(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = folder / "a.csv"
    assert run(["convert", str(given), "--out", str(given)]) == 2
    assert run(["convert", str(folder), "--out", str(given)]) == 2
    assert run(["evaluate", str(given), "--trace", str(given), "--out", str(folder / "out")]) == 2
    assert given.read_text() == TABLE
    assert capsys.readouterr().err.count("is the input") == 3
    assert sorted(path.name for path in folder.iterdir()) == ["a.csv", "b.csv", "c.csv"]


def test_an_interrupt_ends_with_130_and_one_line(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(CsvReader, "read", interrupted)
    for command in ("trips", "convert", "evaluate", "compare", "coverage"):
        out = [] if command == "trips" else ["--out", str(tmp_path / "out.csv")]
        assert run([command, str(folder), *out]) == INTERRUPTED
        left = "" if command in {"trips", "compare"} else f"; {' '.join(out)} is not written"
        assert capsys.readouterr().err == f"modelcast: interrupted{left}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["trips"]


def test_a_signal_ends_a_real_process_the_same_way(folder: Path) -> None:
    """The signal comes while a trip is read, from the operating system and not as an exception of ours."""
    script = (
        "import os, signal, sys\nfrom modelcast.io.csv import CsvReader\n"
        "def read(*_):\n    os.kill(os.getpid(), signal.SIGINT)\n    signal.pause()\n"
        "CsvReader.read = read\nsys.argv[1:] = ['trips', sys.argv[1]]\n"
        "from modelcast.__main__ import main\nmain()"
    )
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-c", script, str(folder)], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "", "modelcast: interrupted\n")


@pytest.mark.parametrize("arguments", [["trips", "{}"], ["trips", "{}", "--json"], ["--help"]])
def test_nobody_reading_the_output_ends_in_silence(arguments: list[str], folder: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "modelcast", *(one.format(folder) for one in arguments)]
    ended = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, check=False)  # noqa: S603
    os.close(writing)
    assert (ended.returncode, ended.stderr) == (BROKEN_PIPE, b"")


def test_help_imports_no_heavy_library() -> None:
    """One command after another in one process, which keeps what it has imported."""
    script = (
        "import sys\nfrom modelcast.cli.app import run\n"
        "for command in sys.argv[1:]:\n"
        "    assert run([*command.split(), '--help']) == 0, command\n"
        "    heavy = {'numpy', 'numba', 'polars', 'matplotlib', 'scipy', 'pyarrow'} & set(sys.modules)\n"
        "    assert not heavy, (command, heavy)"
    )
    subprocess.run([sys.executable, "-c", script, "", *COMMANDS], check=True, capture_output=True)  # noqa: S603


@pytest.mark.slow
def test_doctor_finds_this_installation_well(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("MODELCAST_DATA", raising=False)
    monkeypatch.delenv("MODELCAST_REFERENCE", raising=False)
    # A checkout may have a newer version than what was installed of it: that is for the next test.
    monkeypatch.setattr(diagnosis, "checkout", lambda: None)
    assert run(["doctor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["problems"] == []
    assert {"numpy", "numba", "llvmlite"} <= set(found["packages"])
    assert set(found["extras"]) == set(EXTRAS)
    assert run(["doctor"]) == 0
    shown = capsys.readouterr().out
    for word in ("Python", "numba", "cores", "cache", "extra sumo", "all is well"):
        assert word in shown


def test_a_checkout_newer_than_what_was_installed_of_it_is_told_with_what_to_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By doctor and by --version; a package that is in no checkout has but the installed version."""
    package = tmp_path / "src" / "modelcast"
    package.mkdir(parents=True)
    assert installation.checkout(package) is None
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "modelcast"\nversion = "7.1"\n')
    assert installation.checkout(package) == tmp_path
    assert installation.source_version(tmp_path) == "7.1"
    monkeypatch.setattr(installation, "checkout", lambda: tmp_path)
    assert run(["--version"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith(f"7.1, installed as {package_version()}; install it anew: ")
    assert said.endswith(f"install -e '{tmp_path}'")
    (problem,) = diagnosis._stale_problems(package_version(), tmp_path)
    assert problem.what == f"modelcast is installed as {package_version()}, its source is 7.1"
    assert problem.remedy in said
    (tmp_path / "pyproject.toml").write_text(f'[project]\nversion = "{package_version()}"\n')
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip() == package_version()


def test_doctor_names_what_is_broken_and_its_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A data folder that is gone, a cache that is a file, and a package that is not there."""
    (tmp_path / "cache").touch()
    monkeypatch.setenv("MODELCAST_DATA", str(tmp_path / "gone"))
    monkeypatch.setenv("MODELCAST_CACHE_DIR", str(tmp_path / "cache"))
    version = installation.version

    def without(name: str) -> str:
        if name == "pymap3d":
            raise PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(installation, "version", without)
    assert run(["doctor"]) == 1
    shown = capsys.readouterr().out
    for word in ("MODELCAST_DATA", "MODELCAST_CACHE_DIR to a folder", "pip install --upgrade 'pymap3d>=3.1'"):
        assert word in shown
    assert not kernel_cache.kernel_cache().writable


WANING = """
from dataclasses import dataclass
from tests.models.numpy_models import Coasting

@dataclass(frozen=True, slots=True)
class Waning(Coasting):
    name = "waning"

    def predict_batch(self, parameters, horizons_s, *, dt_s):
        raise KeyError("moon")
"""


@pytest.mark.slow
def test_doctor_tells_what_other_packages_bring_and_whether_it_can_be_had(
    other_package: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A radio under another name, one that is none, and two packages with one reader."""
    monkeypatch.delenv("MODELCAST_DATA", raising=False)
    reader = {"modelcast.readers": {"table": "modelcast.io.csv:CsvReader"}}
    radios = {"silence": "modelcast.channel.erasure_radio:ErasureRadio", "noise": "builtins:list"}
    models = {"waning": "waning_model:Waning"}
    other_package(
        "first",
        {"modelcast.radios": radios, "modelcast.sub_models": models, **reader},
        {"waning_model": WANING},
    )
    other_package("second", reader, version="7.1")
    assert run(["doctor", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    told = {(one["name"], one["package"], one["version"]): one["problem"] for one in found["brought"]}
    assert told["silence", "first", "1.2"] == ""
    assert "sub-model waning failed in predict_batch: KeyError" in told["waning", "first", "1.2"]
    assert "is no AbstractRadio" in told["noise", "first", "1.2"]
    for key in (("table", "first", "1.2"), ("table", "second", "7.1")):
        assert "registered by" in told[key]
    assert run(["doctor"]) == 1
    shown = capsys.readouterr().out
    assert "radios silence, by first 1.2" in shown
    assert "mend or uninstall second" in shown


def test_a_module_that_takes_the_interpreter_down_is_named_and_the_others_are_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "deadly.py").write_text("import os; os._exit(9)")
    (tmp_path / "faulty.py").write_text("raise RuntimeError('no luck')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (tmp_path / "talkative.py").write_text("print('Warning! talkative speaks')")
    faults = installation._import_faults(["json", "talkative", "deadly", "faulty"])
    assert faults == {"deadly": "the interpreter ended with code 9", "faulty": "RuntimeError: no luck"}


def test_the_table_of_extras_is_that_of_the_package() -> None:
    path = Path(__file__).parents[2] / "pyproject.toml"
    stated = tomllib.loads(path.read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    assert {name: [one.partition(">=")[0] for one in wanted] for name, wanted in stated.items()} == {
        name: list(extra.packages) for name, extra in EXTRAS.items()
    }
    told = str(MissingExtraError("It", "sumo"))
    assert told.startswith("It needs eclipse-sumo and libsumo: ")
    assert told.endswith(" install eclipse-sumo libsumo")


def test_the_demo_writes_drives_that_other_commands_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Again over its own, with other seeds; never over what it did not write."""
    folder = tmp_path / "trips"
    assert run(["demo", "--trips", str(folder), "--duration", "90", "--quiet"]) == 0
    first = (folder / "drive-2.csv").read_bytes()
    assert run(["demo", "--trips", str(folder), "--duration", "90", "--seed", "1"]) == 0
    assert (folder / "drive-1.csv").read_bytes() == first.replace(b"drive-2", b"drive-1")
    assert run(["trips", str(folder), "--json", "--quiet"]) == 0
    shown = capsys.readouterr().out
    assert "6 generated drives of 90 s" in shown
    found = json.loads(shown.partition("drive-6.csv\n")[2])
    assert [one["trip_id"] for one in found["trips"]] == [f"drive-{number}" for number in range(1, 7)]
    assert not found["skipped"]
    (folder / "mine.csv").write_text("t,x,y\n")
    assert run(["demo", "--trips", str(folder), "--duration", "90"]) == 2
    assert (folder / "mine.csv").exists()

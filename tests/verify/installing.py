"""What the tests of installations share: our own commands, and sdist and wheel as `uv build` makes them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

__all__ = ["ROOT", "built", "ended", "interpreters", "run", "uv"]

ROOT = Path(__file__).parents[2]
SUPPORTED = ("3.11", "3.12", "3.13")
"""Of the classifiers of `pyproject.toml`."""

_OURS = ("PYTHON", "VIRTUAL_ENV", "MODELCAST")


def ended(*words: str | Path, **known: str | Path) -> subprocess.CompletedProcess[str]:
    """How one of our own commands ends, with none of this process's Python in its environment.

    pip's settings stay: they may name the index that packages come from.
    """
    variables = {name: value for name, value in os.environ.items() if not name.startswith(_OURS)}
    variables |= {name: str(value) for name, value in known.items()}
    return subprocess.run(  # noqa: S603 - our own words
        [str(word) for word in words], env=variables, capture_output=True, text=True, check=False
    )


def run(*words: str | Path, **known: str | Path) -> str:
    """What one of our own commands prints; it must end well."""
    found = ended(*words, **known)
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


def uv(*words: str | Path, **known: str | Path) -> str:
    """What uv prints, with this machine's certificates; skipped where it reaches no package index.

    uv reads none of pip's files, so an index that pip knows from them it may not know.
    """
    found = ended(sys.executable, "-m", "uv", *words, UV_SYSTEM_CERTS="1", **known)
    if found.returncode and "Failed to fetch" in found.stderr:
        pytest.skip(f"uv reaches no package index: {found.stderr.strip().splitlines()[0]}")
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


def built(folder: Path) -> tuple[Path, Path]:
    """An sdist of this checkout, and a wheel of that sdist."""
    # In the order of `uv build`: the checkout gives the sdist, and the sdist alone the wheel.
    uv("build", "--quiet", "--no-build-isolation", "--python", sys.executable, "-o", folder, ROOT)
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return sdist, wheel


def interpreters() -> dict[str, str]:
    """Every supported version of Python that this machine has, with its interpreter."""
    found: dict[str, str] = {}
    for version in SUPPORTED:
        named = [shutil.which(f"python{version}"), *_of_pyenv(version)]
        for program in filter(None, named):
            if ended(program, "-c", "import venv").returncode == 0:
                found[version] = program
                break
    return found


def _of_pyenv(version: str) -> list[str]:
    """Interpreters that pyenv keeps; its shims answer for one version alone."""
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    return [str(place) for place in sorted(versions.glob(f"{version}.*/bin/python"))]

"""Builds C++ programs of tests, with the sanitizers of addresses and undefined behaviour if there are any."""

import functools
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

__all__ = ["CPP", "TRIED", "built", "needs_compiler", "needs_sanitizers", "output", "ran"]

CPP = Path(__file__).parents[2] / "contrib" / "cpp"
TRIED = Path(__file__).parent / "cpp"

_COMPILER = shutil.which("g++")
_FLAGS = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
_SANITIZED = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")

needs_compiler = [
    pytest.mark.slow,
    pytest.mark.skipif(_COMPILER is None, reason="needs g++, the GNU compiler of C++"),
    pytest.mark.skipif(sys.platform == "win32", reason="the header uses POSIX sockets"),
]


@functools.cache
def _sanitizers() -> bool:
    """Whether the compiler has them, and what it builds runs."""
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "empty.cpp", Path(folder) / "empty"
        source.write_text("int main() {}\n", encoding="utf-8")
        words = [str(_COMPILER), *_SANITIZED, str(source), "-o", str(program)]
        made = subprocess.run(words, capture_output=True, check=False)  # noqa: S603 - our own source
        return made.returncode == 0 and ran(program).returncode == 0


@pytest.fixture(name="needs_sanitizers", scope="session")
def needs_sanitizers() -> None:
    """Skips what proves nothing without them."""
    if not _sanitizers():
        pytest.skip("needs a g++ with the sanitizers of addresses and of undefined behaviour")


def built(out: Path, *sources: Path, include: tuple[Path, ...] = (CPP,)) -> Path:
    """Compile without a warning; returns the program."""
    flags = (*_FLAGS, *(_SANITIZED if _sanitizers() else ()))
    words = [str(_COMPILER), *flags, *(f"-I{one}" for one in include), *map(str, sources), "-o", str(out)]
    made = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603 - our own sources
    assert made.returncode == 0, made.stderr
    return out


def ran(*words: object, given: str = "") -> subprocess.CompletedProcess[str]:
    """Run what was built."""
    return subprocess.run(  # noqa: S603 - what was built above
        [str(one) for one in words], capture_output=True, text=True, check=False, input=given, timeout=120.0
    )


def output(*words: object, given: str = "") -> str:
    """What it prints, where it ends well."""
    done = ran(*words, given=given)
    assert done.returncode == 0, done.stderr
    return done.stdout

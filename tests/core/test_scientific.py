"""Claims about SciPy: an evaluation does without it, and what needs it says which extra brings it."""

import ast
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import modelcast

WITHOUT = """
import sys
from importlib.abc import MetaPathFinder

class NoScipy(MetaPathFinder):
    def __init__(self, finder):
        self.finder = finder

    def find_spec(self, name, path=None, target=None):
        return None if name.partition(".")[0] == "scipy" else self.finder.find_spec(name, path, target)

sys.meta_path[:] = map(NoScipy, sys.meta_path)
from modelcast.cli.app import run
"""


def ended(program: str, *, folder: Path) -> subprocess.CompletedProcess[str]:
    """How a program ends on a machine without SciPy."""
    return subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", WITHOUT + textwrap.dedent(program)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_an_evaluation_and_its_report_need_no_scipy(tmp_path: Path) -> None:
    found = ended("sys.exit(run(['demo', '--duration', '90', '--out', 'out', '--quiet']))", folder=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert (tmp_path / "out" / "report.html").is_file()


def test_no_module_imports_scipy_and_only_one_names_it() -> None:
    """So whatever asks for nothing of it does without it."""
    root = Path(modelcast.__file__).parent
    naming = [
        str(path.relative_to(root))
        for path in sorted(root.rglob("*.py"))
        if "scipy" in path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if (isinstance(node, ast.Import) and any(_is_scipy(one.name) for one in node.names))
        or (isinstance(node, ast.ImportFrom) and not node.level and _is_scipy(node.module or ""))
        or (isinstance(node, ast.Call) and any(map(_names_scipy, node.args)))
    ]
    assert naming == ["core/scientific.py"]


def _is_scipy(name: str) -> bool:
    return name.partition(".")[0] == "scipy"


def _names_scipy(node: ast.expr) -> bool:
    """Whether a text, or the beginning of one, is a module of SciPy."""
    first = node.values[0] if isinstance(node, ast.JoinedStr) and node.values else node
    return isinstance(first, ast.Constant) and isinstance(first.value, str) and _is_scipy(first.value)


ASKED = {
    "modelcast network": "network --density 25",
    "modelcast mixed": "mixed --density 25",
    "modelcast capacity": "capacity",
    "modelcast safety": "safety --streams 1",
    "modelcast reproduce --traffic": "reproduce paper trips --traffic",
}


@pytest.mark.slow
def test_what_needs_scipy_says_so_in_one_line_before_it_does_anything(tmp_path: Path) -> None:
    (tmp_path / "trips").mkdir()
    calls = "".join(f"print(run({words.split()}))\n" for words in ASKED.values())
    found = ended(calls, folder=tmp_path)
    lines = found.stderr.splitlines()
    assert found.stdout.split() == ["2"] * len(ASKED)
    assert [line.partition(" needs scipy: ")[0] for line in lines] == [f"modelcast: {one}" for one in ASKED]
    assert all(line.endswith("install scipy") for line in lines)
    assert [one.name for one in tmp_path.iterdir()] == ["trips"]

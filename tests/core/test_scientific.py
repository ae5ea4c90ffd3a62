"""Claims about SciPy: an evaluation does without it, and what needs it says which extra brings it."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

WITHOUT = """
import sys
from importlib.abc import MetaPathFinder

class NoScipy(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "scipy":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NoScipy())
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


def test_a_fleet_without_scipy_is_told_in_one_line_which_extra_brings_it(tmp_path: Path) -> None:
    found = ended("sys.exit(run(['network', '--density', '25', '--quiet']))", folder=tmp_path)
    (line,) = found.stderr.splitlines()
    assert found.returncode == 2
    assert "needs scipy" in line
    assert line.endswith("install scipy")

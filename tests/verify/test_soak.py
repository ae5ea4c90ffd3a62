"""What nodes do when things go wrong keeps its bounds, in the short form of ``make soak``."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent

pytestmark = pytest.mark.slow


@pytest.mark.skipif(sys.platform != "linux", reason="what a process weighs is read as Linux tells it")
def test_the_short_soak_breaks_no_bound() -> None:
    pytest.importorskip("can", reason="the extra `node` brings the bus that nodes measure by")
    words = [sys.executable, str(ROOT / "validation" / "soak.py"), "--short"]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: S603 - our own interpreter
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_page_has_a_row_of_every_fault() -> None:
    words = [sys.executable, str(ROOT / "validation" / "soak.py"), "--check"]
    assert subprocess.run(words, cwd=ROOT, check=False).returncode == 0  # noqa: S603 - our own interpreter

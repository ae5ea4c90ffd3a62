"""What docs/paper.md says of a source is what the command finds there."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_folder")]


def test_the_document_says_what_is_found_on_safety_pilot_and_boreas() -> None:
    script = ROOT / "validation" / "paper.py"
    words = [sys.executable, str(script), "--check", "--only", "Safety Pilot", "Boreas"]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: S603 - our own interpreter
    assert found.returncode == 0, found.stdout + found.stderr

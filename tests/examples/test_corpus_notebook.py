"""Claims about the notebook on whole data sets: its cells run in order, and keep no output."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

NOTEBOOK = Path(__file__).parents[2] / "examples" / "corpus.ipynb"


def code_cells() -> list[dict[str, Any]]:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.slow
def test_its_cells_run_and_its_sums_are_those_of_the_report(tmp_path: Path) -> None:
    """The last cell compares them."""
    pytest.importorskip("duckdb", reason="the notebook asks DuckDB, of the group dev")
    script = tmp_path / "cells.py"
    script.write_text("\n\n".join("".join(cell["source"]) for cell in code_cells()), encoding="utf-8")
    done = subprocess.run(  # noqa: S603
        [sys.executable, str(script)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "messages a second" in done.stdout


def test_it_is_kept_without_what_it_printed() -> None:
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code_cells())

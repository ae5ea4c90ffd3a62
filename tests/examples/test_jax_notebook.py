"""Claims about the notebook with a sub-model in JAX: its cells run in order, and it saves messages."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parents[2] / "examples" / "jax_sub_model.ipynb"


@pytest.mark.slow
def test_its_cells_run_and_the_model_sends_fewer_messages(tmp_path: Path) -> None:
    pytest.importorskip("jax", reason="the notebook needs JAX, of the extra train")
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    judged = 'own, plain = rates["total_rate_hz"].to_list()[:2]\nassert 0.0 < own < 0.8 * plain, (own, plain)'
    script = tmp_path / "cells.py"
    script.write_text("\n\n".join([*code, judged]), encoding="utf-8")
    done = subprocess.run(  # noqa: S603
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"JAX_PLATFORMS": "cpu"},
    )
    assert done.returncode == 0, done.stderr
    assert "jax-accelerating+cv" in done.stdout


def test_it_is_kept_without_what_it_printed() -> None:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)

"""Claims about the notebooks that are kept with what they show: they show it again."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def tool() -> ModuleType:
    wanted = importlib.util.spec_from_file_location("notebooks", ROOT / "tools" / "notebooks.py")
    assert wanted is not None
    assert wanted.loader is not None
    module = importlib.util.module_from_spec(wanted)
    sys.modules["notebooks"] = module
    wanted.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("name", ["trips", "own_sub_model", "network", "safety", "live_map"])
def test_it_shows_what_is_kept(name: str) -> None:
    nbformat = pytest.importorskip("nbformat")
    notebooks = tool()
    kept = nbformat.read(ROOT / "examples" / f"{name}.ipynb", as_version=4)
    assert notebooks.printed(notebooks.execute(name)) == notebooks.printed(kept)
    assert any("figure" in cell for cell in notebooks.printed(kept))


@pytest.mark.slow
def test_every_notebook_has_its_test() -> None:
    kept = {path.stem for path in (ROOT / "examples").glob("*.ipynb")}
    assert kept == {*tool().NOTEBOOKS, "corpus", "jax_sub_model"}

"""Claims about the notebooks that are kept with what they show: they show it again."""

import importlib.util
import sys
from io import BytesIO
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
MOST_BYTES = 150_000
"""Of a notebook: it is read on a page, and every version of it stays in the history."""


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


@pytest.mark.parametrize("name", ["trips", "own_sub_model", "network", "safety", "live_map"])
def test_what_is_kept_is_small(name: str) -> None:
    assert (ROOT / "examples" / f"{name}.ipynb").stat().st_size < MOST_BYTES


def test_a_drawing_in_few_colours_keeps_those_of_its_areas_and_stays_as_it_is_the_second_time() -> None:
    notebooks, image = tool(), pytest.importorskip("PIL.Image")
    pixels = np.full((40, 90, 3), 255, dtype=np.uint8)
    pixels[10:20, :50] = (0, 114, 178)
    pixels[30, :, :] = np.arange(90, dtype=np.uint8)[:, None] * 2  # 90 shades, of which not all are kept
    written = BytesIO()
    image.fromarray(pixels).save(written, "PNG")
    small = notebooks.in_few_colours(written.getvalue())
    shown = np.asarray(image.open(BytesIO(small)).convert("RGB"))
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) == notebooks.COLOURS
    assert np.array_equal(shown[:30], pixels[:30])
    assert notebooks.in_few_colours(small) == small

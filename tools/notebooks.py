"""Execute the notebooks of `examples`, and keep what they print and draw, or hold it against what is kept.

``python tools/notebooks.py`` writes; ``--check`` compares the printed text and the number of figures, and
ends with 1 where they differ. Pictures are kept in few colours: a third of the octets, the same lines.
Notebooks that are kept without outputs (`corpus`, `jax_sub_model`) have tests of their own.
"""

import argparse
import base64
import os
import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
import numpy as np
from nbclient import NotebookClient
from PIL import Image

__all__ = ["NOTEBOOKS", "execute", "in_few_colours", "main", "printed"]

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS = ("trips", "own_sub_model", "network", "safety", "live_map")
"""Those that are kept with what they show."""

SECONDS = 900
"""A cell that takes longer is stopped."""

COLOURS = 48
"""Of a drawing: those of lines, areas and letters are kept as they are, the shades at their edges are not."""

MOST_COLOURS = 20_000
"""A picture of more is no drawing, and is kept as it is."""


def execute(name: str) -> nbformat.NotebookNode:
    """Run a notebook in an empty folder, and return it with what it shows.

    Parameters
    ----------
    name
        One of `NOTEBOOKS`.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        Where a cell fails.
    """
    book = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    with TemporaryDirectory() as folder:
        client = NotebookClient(book, timeout=SECONDS, resources={"metadata": {"path": folder}})
        client.execute(env={**os.environ, "PYTHONHASHSEED": "0"})
    for cell in book.cells:
        cell.metadata.pop("execution", None)  # when it ran
        cell.get("outputs", [])[:] = [_kept(one) for one in cell.get("outputs", []) if _is_shown(one)]
    return book


def _is_shown(output: nbformat.NotebookNode) -> bool:
    """Progress is for who waits."""
    return output.get("name") != "stderr"


def _kept(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Of a figure the picture, of anything else all."""
    if "image/png" in output.get("data", {}):
        octets = in_few_colours(base64.b64decode(output["data"]["image/png"]))
        output["data"] = {"image/png": base64.b64encode(octets).decode()}
    return output


def in_few_colours(png: bytes) -> bytes:
    """Return a drawing with its `COLOURS` most frequent colours, the others the nearest of these.

    Parameters
    ----------
    png
        A PNG; where it can be looked through, it is laid on white.
    """
    drawn = Image.open(BytesIO(png)).convert("RGBA")
    white = Image.new("RGBA", drawn.size, "white")
    pixels = np.asarray(Image.alpha_composite(white, drawn).convert("RGB"))
    colours, number, counts = np.unique(
        pixels.reshape(-1, 3), axis=0, return_inverse=True, return_counts=True
    )
    if len(colours) > MOST_COLOURS:
        return png
    kept = colours[np.sort(np.argsort(-counts, kind="stable")[:COLOURS])]
    apart = ((colours[:, None, :].astype(int) - kept[None].astype(int)) ** 2).sum(axis=2)
    nearest = apart.argmin(axis=1).astype(np.uint8)
    small = Image.fromarray(nearest[number.reshape(pixels.shape[:2])])
    small.putpalette(kept.tobytes())
    written = BytesIO()
    small.save(written, "PNG", optimize=True)
    return written.getvalue()


def printed(book: nbformat.NotebookNode) -> list[list[str]]:
    """Return what each cell of code printed; ``figure`` for a picture.

    Parameters
    ----------
    book
        The notebook.
    """
    return [[_text(one) for one in cell.outputs] for cell in book.cells if cell.cell_type == "code"]


def _text(output: nbformat.NotebookNode) -> str:
    data = output.get("data", {})
    return "figure" if "image/png" in data else output.get("text", data.get("text/plain", ""))


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check them; return 1 where a check finds a difference.

    Parameters
    ----------
    arguments
        Those of the command line; None for the process's.
    """
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", default=NOTEBOOKS, metavar="NAME", help=", ".join(NOTEBOOKS))
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    given = parser.parse_args(arguments)
    unknown = sorted(set(given.names) - set(NOTEBOOKS))
    if unknown:
        parser.error(f"no notebook {', '.join(unknown)}: there are {', '.join(NOTEBOOKS)}")
    differing = 0
    for name in given.names:
        print(name, flush=True)
        book, path = execute(name), EXAMPLES / f"{name}.ipynb"
        if not given.check:
            nbformat.write(book, path)
        elif printed(book) != printed(nbformat.read(path, as_version=4)):
            differing += 1
            print(f"{path.name} shows something else now: python tools/notebooks.py {name}")
    return int(differing > 0)


if __name__ == "__main__":
    sys.exit(main())

"""Execute the notebooks of `examples`, and keep what they print and draw, or hold it against what is kept.

``python tools/notebooks.py`` writes; ``--check`` compares the printed text and the number of figures, and
ends with 1 where they differ. Notebooks that are kept without outputs (`corpus`, `jax_sub_model`) have tests
of their own.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
from nbclient import NotebookClient

__all__ = ["NOTEBOOKS", "execute", "main", "printed"]

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS = ("trips", "own_sub_model", "network", "safety", "live_map")
"""Those that are kept with what they show."""

SECONDS = 900
"""A cell that takes longer is stopped."""


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
        output["data"] = {"image/png": output["data"]["image/png"]}
    return output


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

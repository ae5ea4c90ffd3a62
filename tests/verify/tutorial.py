"""The tutorial, followed to the letter: its commands in order, in an empty folder, and what they print.

``python tests/verify/tutorial.py --write`` puts what they print today under the commands of the page.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))
from code_blocks import ROOT, Block, blocks_of

sys.path.pop(0)

__all__ = ["PAGE", "agrees", "followed"]

PAGE = ROOT / "docs" / "tutorial" / "trips-to-figure.md"

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?")
_HASH = re.compile(r"sha256 [0-9a-f.]+")
_FIXED = {"COLUMNS": "100", "LC_ALL": "C.UTF-8"}
"""As wide as the page shows tables."""
_RATIO, _DIFFERENCE = 0.1, 0.03
"""Training sums in another order on another processor: two digits of a ratio may differ."""


def agrees(shown: str, printed: str) -> bool:
    r"""Whether a page shows what a command printed: words alike, numbers nearly, ``...`` for any lines.

    Parameters
    ----------
    shown, printed
        Text of whole lines.

    Examples
    --------
    >>> agrees("p90 0.56 m\n...\n", "p90 0.57 m\nsha256 12ab\n"), agrees("3 trips\n", "6 trips\n")
    (True, False)
    """
    wanted, found = ([line.rstrip() for line in text.splitlines()] for text in (shown, printed))
    while wanted and found and wanted[0] != "...":
        if not _alike(wanted.pop(0), found.pop(0)):
            return False
    while wanted and found and wanted[-1] != "...":
        if not _alike(wanted.pop(), found.pop()):
            return False
    return wanted in (["..."], found)


def _alike(shown: str, printed: str) -> bool:
    shown, printed = (_HASH.sub("sha256", text) for text in (shown, printed))
    if _NUMBER.sub("#", shown) != _NUMBER.sub("#", printed):
        return False
    numbers = (map(float, _NUMBER.findall(text)) for text in (shown, printed))
    return all(abs(a - b) <= max(_DIFFERENCE, _RATIO * abs(a)) for a, b in zip(*numbers, strict=True))


def followed(folder: Path, page: Path = PAGE) -> Iterator[tuple[Block, str, str]]:
    """Run the commands and programs of a page, one after the other.

    Parameters
    ----------
    folder
        Where; empty.
    page
        The page.

    Yields
    ------
    tuple
        The block, what it shows and what it printed.

    Raises
    ------
    RuntimeError
        Where one fails.
    """
    for block in blocks_of(page):
        if block.language == "python":
            yield block, block.result or "", _output([sys.executable, "-c", block.text], folder)
        elif block.language == "console":
            command, _, shown = block.text.removeprefix("$ ").partition("\n")
            program, *words = shlex.split(command)
            if program != "modelcast":
                raise RuntimeError(f"{block.place}: {program} is not modelcast")
            yield block, shown, _output([sys.executable, "-m", "modelcast", *words], folder)


def _output(command: list[str], folder: Path) -> str:
    ended = subprocess.run(  # noqa: S603 - our own page
        command, cwd=folder, env={**os.environ, **_FIXED}, capture_output=True, text=True, check=False
    )
    if ended.returncode:
        raise RuntimeError(
            f"{shlex.join(command)}: exit code {ended.returncode}\n{ended.stdout}{ended.stderr}"
        )
    return ended.stdout


def _write() -> None:
    """Put what is printed today into the page."""
    text = PAGE.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        for block, _, printed in followed(Path(folder)):
            lines = [line.rstrip() for line in printed.splitlines()]
            body = "".join(f"{_HASH.sub('sha256 ...', line)}\n" for line in lines)
            if block.language == "console":
                command = block.text.partition("\n")[0]
                old, new = f"```console\n{block.text}```", f"```console\n{command}\n{body}```"
            else:
                old = f"```python\n{block.text}```"
                new = f"{old}\n\n```text\n{body}```"
                old += "" if block.result is None else f"\n\n```text\n{block.result}```"
            if text.count(old) != 1:
                raise SystemExit(f"{block.place}: not found once")
            text = text.replace(old, new)
            print(block.place, flush=True)  # noqa: T201 - it takes minutes
    PAGE.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--write", action="store_true", required=True, help="put it into the page")
    asked.parse_args()
    _write()

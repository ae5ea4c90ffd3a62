"""What modelcast answers to the wrong uses of the table, and the page that shows it."""

import contextlib
import io
import os
import subprocess
import sys
import warnings
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

from tests.cli.wrong_uses import GROUPS, WrongUse
from tests.file_room import room

from modelcast.cli.app import run
from modelcast.cli.board import PROGRESS_VARIABLE
from modelcast.core.exceptions import ModelcastWarning

__all__ = ["PAGE", "Answer", "answered", "page"]

PAGE = Path(__file__).parents[2] / "docs" / "wrong-uses.md"

_IMPORTED_AT_ONCE = frozenset({"starlette"})
"""Modules that others import at their top, so that only a new process lacks them."""

_NO_PROGRESS = {PROGRESS_VARIABLE: "none"}
"""A slow machine would show some."""

_WITHOUT = """
import sys
sys.modules[sys.argv[1]] = None
from modelcast.cli.app import run
sys.exit(run(sys.argv[2:]))
"""


@dataclass(frozen=True)
class Answer:
    """What a command said.

    Parameters
    ----------
    code
        Its exit code.
    out, err
        What it printed; the interpreter's path is ``python``.
    """

    code: int
    out: str
    err: str


def answered(use: WrongUse, folder: Path) -> Answer:
    """Run a wrong use.

    Parameters
    ----------
    use
        A row.
    folder
        Where its files are.
    """
    if use.absent in _IMPORTED_AT_ONCE:
        ended = subprocess.run(  # noqa: S603 - our own interpreter and text
            [sys.executable, "-c", _WITHOUT, use.absent, *use.words],
            cwd=folder, capture_output=True, text=True, check=False, env={**os.environ, **_NO_PROGRESS},
        )  # fmt: skip
        return _told(ended.returncode, ended.stdout, ended.stderr)
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        patch.dict(os.environ, _NO_PROGRESS),
        _without(use.absent),
        room(use.room_bytes),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("always", ModelcastWarning)  # tests make errors of them
        code = run(use.words)
    return _told(code, out.getvalue(), err.getvalue())


@contextlib.contextmanager
def _without(module: str) -> Generator[None]:
    """Have a module not installed; what else is imported meanwhile stays."""
    if not module:
        yield
        return
    missing = object()
    before: Any = sys.modules.get(module, missing)
    sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        if before is missing:
            del sys.modules[module]
        else:
            sys.modules[module] = before


def _told(code: int, out: str, err: str) -> Answer:
    return Answer(code, out, err.replace(sys.executable, "python"))


_HEAD = """\
# What goes wrong, and what to do

What a newcomer types or has, and what modelcast says to it. Each row is a test: the answer names the cause
and what to do, comes in a few lines on the standard error, and ends with the
[exit code](evaluation.md#exit-codes) 2. Nothing is written then. The table is made of
`tests/cli/wrong_uses.py` by `python -m tests.cli.wrong_uses_page --write`.
"""
_LONGEST = 420


def page(answers: dict[WrongUse, Answer]) -> str:
    """Return the page of all wrong uses, as Markdown.

    Parameters
    ----------
    answers
        What was said to each.
    """
    parts = [_HEAD]
    for title, uses in GROUPS.items():
        rows = [
            f"| {use.what} | `modelcast {' '.join(use.words)}` | {_cell(answers[use].err)} |" for use in uses
        ]
        parts += [
            "\n".join((f"## {title}\n", "| what | typed | modelcast says |", "|---|---|---|", *rows)) + "\n"
        ]
    return "\n".join(parts)


def _cell(told: str) -> str:
    """What was said, as a cell; what is longer than a cell should be is cut where a name ends."""
    lines = [line.removeprefix("modelcast: ") for line in told.splitlines()]
    shown = [
        line if len(line) <= _LONGEST else line[:_LONGEST].rsplit(", ", 1)[0] + ", ..." for line in lines
    ]
    return "<br>".join("`" + line.replace("|", r"\|") + "`" for line in shown)

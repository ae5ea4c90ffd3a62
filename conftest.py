"""What all tests share beside fixtures: which modules have examples, what JAX compiled, Ctrl-C."""

import os
import signal
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from _pytest.doctest import DoctestModule


def pytest_configure(config: pytest.Config) -> None:
    """Let JAX keep what it compiled, and hear Ctrl-C, which the background jobs of a shell do not.

    A network trained a second time is else compiled a second time.
    """
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    kept = getattr(config, "cache", None)  # none where pytest is told to keep nothing
    if kept is not None:
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(kept.mkdir("jax")))
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.05")


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path: Path) -> Generator[None, list[Any], list[Any]]:
    """Leave out of the doctests what has no prompt: three modules in four, each imported and searched."""
    found = yield
    if any(isinstance(one, DoctestModule) for one in found) and ">>>" not in file_path.read_text("utf-8"):
        return [one for one in found if not isinstance(one, DoctestModule)]
    return found

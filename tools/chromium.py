"""The Chromium of this machine, and how it is started: without a screen and without a word to anybody.

Tests, pictures of pages and the benchmark of frames start it alike.
"""

import shutil
from typing import TypedDict

__all__ = ["Start", "chromium"]

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_SILENT = ("--no-sandbox", "--disable-background-networking")
_DRAWN_AS_ON_A_SCREEN = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)


class Start(TypedDict):
    """What playwright's ``launch`` takes."""

    executable_path: str
    args: list[str]


def chromium(*, tall: bool = False) -> Start:
    """Return how Chromium is started.

    Parameters
    ----------
    tall
        For pictures of long pages: textures of a graphics processor, simulated or not, are shorter.

    Raises
    ------
    FileNotFoundError
        Where the machine has none.

    Examples
    --------
    >>> browser = engine.chromium.launch(**chromium())  # doctest: +SKIP
    """
    found = next((place for place in map(shutil.which, _NAMES) if place), None)
    if found is None:
        raise FileNotFoundError("no chromium on this machine")
    return {
        "executable_path": found,
        "args": [*_SILENT, *(("--disable-gpu",) if tall else _DRAWN_AS_ON_A_SCREEN)],
    }

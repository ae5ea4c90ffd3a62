"""Claims: the live page is sound in a browser, of a drive to try it with and of a node, by phone and desk."""

import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

import pytest

from .browser import VIEWS, View, faults

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.slow

LONGEST_S = 180
"""Until the host has heard a remote."""


def _free_port() -> str:
    """A UDP port that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


@contextmanager
def _served(*words: str) -> Iterator[str]:
    """The address that a command of modelcast tells, as long as it is needed."""
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-u", "-m", "modelcast", *words], stdout=subprocess.PIPE, text=True
    ) as serving:
        assert serving.stdout is not None
        yield next(line.strip() for line in serving.stdout if line.startswith("http"))
        serving.terminate()


@pytest.fixture(scope="module", params=["view", "node"])
def address(request: pytest.FixtureRequest) -> Iterator[str]:
    """Of the page, served."""
    pytest.importorskip("uvicorn", reason="the extra `node` brings the server")
    words = {
        "view": ("view", "--demo", "--port", "0"),
        "node": ("demo-live", "--port", "0", "--udp-port", _free_port(), "--duration", "600"),
    }[request.param]
    with _served(*words) as found:
        yield found


def _chosen(page: "Page") -> None:
    """A remote is chosen, the list of keys is open, and the picture stands still where it can."""
    from playwright.sync_api import TimeoutError as NotYet  # noqa: PLC0415 - where there is a browser

    page.locator("#legend li").first.wait_for()
    page.locator("#map").focus()
    for _ in range(LONGEST_S):  # the host may have heard nobody yet
        page.keyboard.press("n")
        with suppress(NotYet):
            page.locator("#chosen").wait_for(timeout=1000.0)
            break
    page.keyboard.press("?")
    page.locator("#keys").wait_for()
    page.keyboard.press("Space")


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_the_page_has_no_fault(browser: "Browser", address: str, view: View) -> None:
    assert faults(browser, address, view, prepare=_chosen) == []

"""The documentation site, built and looked at in a browser: every page, on a phone and on a desk."""

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from filelock import FileLock

import modelcast

from .browser import VIEWS, View, faults, opened_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
KINDS = ("index.html", "404.html", "search.html", "sections/reference.html", "wire.html", "api/fleets.html")
"""One page of every kind: these are gone through by the keyboard too, and in every view."""

PHONE, DESK = VIEWS[0], VIEWS[-1]
SHARES = 4
"""Parts of the pages, so that workers share them."""


def build(folder: Path) -> Path:
    words = [sys.executable, str(ROOT / "tools" / "website" / "build.py"), "--out", str(folder)]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603 - our own script
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return folder


@pytest.fixture(scope="module", name="site")
def _site(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The site; workers build it once for all."""
    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / "site"
    with FileLock(folder.with_suffix(".lock")):
        return folder if (folder / "index.html").exists() else build(folder)


@pytest.fixture(scope="module", name="address")
def _address(site: Path) -> Iterator[str]:
    """Where a server of this machine has the site."""

    class Pages(SimpleHTTPRequestHandler):
        def __init__(self, *arguments: Any, **keywords: Any) -> None:
            super().__init__(*arguments, directory=str(site), **keywords)

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - as the base names it
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Pages) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


def pages_of(site: Path) -> list[str]:
    every = (path.relative_to(site) for path in site.rglob("*.html"))
    return sorted(path.as_posix() for path in every if path.parts[0] != "_static")


def test_every_public_name_is_described(site: Path) -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in (site / "api").glob("*.html"))
    names = [name for name in dir(modelcast) if not name.startswith("_")]
    assert [name for name in names if f'id="modelcast.{name}"' not in text] == []


def test_types_in_signatures_lead_to_where_they_are_described(site: Path) -> None:
    page = (site / "api" / "trips-in-results-out.html").read_text(encoding="utf-8")
    assert 'href="studies.html#modelcast.EvaluationSettings"' in page


@pytest.mark.parametrize("internal", ["_Buffer", "Annotated", "&lt;function", "&lt;class", "Bases: object"])
def test_signatures_hold_nothing_of_the_inside(site: Path, internal: str) -> None:
    pages = {path.name: path.read_text(encoding="utf-8") for path in (site / "api").glob("*.html")}
    words = {name: re.sub(r"<[^>]+>", "", text) for name, text in pages.items()}
    assert [name for name, text in words.items() if internal in text] == []


def test_a_second_build_is_the_same_to_the_octet(site: Path, tmp_path: Path) -> None:
    again = build(tmp_path / "site")
    files = {path.relative_to(site) for path in site.rglob("*") if path.is_file()}
    assert files == {path.relative_to(again) for path in again.rglob("*") if path.is_file()}
    assert [name for name in sorted(files) if (site / name).read_bytes() != (again / name).read_bytes()] == []


@pytest.mark.parametrize("share", range(SHARES))
def test_nothing_is_wrong_with_any_page(browser: "Browser", site: Path, address: str, share: int) -> None:
    found: list[str] = []
    for page in pages_of(site)[share::SHARES]:
        for view in (PHONE, DESK):
            told = faults(browser, f"{address}/{page}", view, keyboard=False)
            found += [f"{page} {view}: {one}" for one in told]
    assert found == []


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_every_kind_of_page_is_gone_through_by_the_keyboard(
    browser: "Browser", address: str, view: View
) -> None:
    found = [f"{page}: {one}" for page in KINDS for one in faults(browser, f"{address}/{page}", view)]
    assert found == []


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("burst losses Gilbert", "channel.html"),
        ("GilbertElliott", "api/channels.html"),
        ("units of a CSV", "formats.html"),
        ("test vectors octets", "wire.html"),
    ],
)
def test_search_finds_the_page(browser: "Browser", address: str, words: str, page: str) -> None:
    told: list[str] = []
    with opened_page(browser, f"{address}/index.html", DESK, told) as opened:
        opened.get_by_role("button", name="Search").first.click()
        opened.get_by_role("searchbox").last.fill(words)
        opened.keyboard.press("Enter")
        # Results come one by one: the search goes through the pages in the browser.
        opened.locator(f'#search-results li a[href*="{page}"]').first.wait_for()
        links = opened.locator("#search-results li a").evaluate_all("all => all.map(one => one.href)")
        assert any(link.partition("#")[0].partition("?")[0].endswith(f"/{page}") for link in links[:10]), (
            links
        )
    assert told == []


@pytest.mark.parametrize("view", [PHONE, DESK], ids=str)
def test_a_picture_opens_large(browser: "Browser", address: str, view: View) -> None:
    def opened(page: "Page") -> None:
        small: Any = page.locator("button.enlarge img").first.bounding_box()
        page.locator("button.enlarge").first.click()
        large: Any = page.locator("dialog.enlarged img").bounding_box()
        assert large["width"] > 1.2 * small["width"]

    assert faults(browser, f"{address}/index.html", view, prepare=opened) == []


def test_options_stay_on_one_line_on_a_phone(browser: "Browser", address: str) -> None:
    told: list[str] = []
    with opened_page(browser, f"{address}/how-to/my-radio.html", PHONE, told) as opened:
        lines = opened.locator("article code span.pre").evaluate_all(
            "all => all.filter(one => /^--/.test(one.textContent)).map(one => one.getClientRects().length)"
        )
        assert len(lines) > 2
        assert set(lines) == {1}
    assert told == []


def test_copying_takes_what_is_typed(browser: "Browser", site: Path, address: str) -> None:
    """Of a console the commands alone, of a program all of it."""
    told: list[str] = []
    page = next(
        one for one in pages_of(site) if "highlight-console" in (site / one).read_text(encoding="utf-8")
    )
    with opened_page(browser, f"{address}/{page}", DESK, told) as opened:
        opened.context.grant_permissions(["clipboard-read", "clipboard-write"])
        block = opened.locator(".highlight-console").first
        block.hover()
        block.get_by_role("button", name="Copy").click()
        block.get_by_role("button", name="Copied").wait_for()
        copied = opened.evaluate("navigator.clipboard.readText()")
        shown = block.locator("pre").inner_text()
        typed = [line.removeprefix("$ ") for line in shown.splitlines() if line.startswith("$ ")]
        assert copied.splitlines() == typed
        assert typed
    assert told == []


def test_night_and_day_are_chosen_and_kept(browser: "Browser", address: str) -> None:
    told: list[str] = []
    with opened_page(browser, f"{address}/index.html", DESK, told) as opened:
        shown = opened.locator("html")
        assert shown.get_attribute("data-theme") == DESK.scheme
        opened.evaluate("localStorage.setItem('mode', 'light'), localStorage.setItem('theme', 'light')")
        opened.goto(f"{address}/channel.html")
        assert shown.get_attribute("data-theme") == "light"
    assert told == []

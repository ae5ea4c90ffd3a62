"""Take pictures of a report, of the site and of the live page, on a phone and on a desk.

    python tools/page_screenshots.py out/screenshots                         all three, made for it
    python tools/page_screenshots.py out/pictures --only report --report out/demo/report.html
    python tools/page_screenshots.py out/pictures --only site --site out/site --every
    python tools/page_screenshots.py out/pictures --only demo-live           nodes, after half a minute
    python tools/page_screenshots.py out/screenshots --write                 and those that pages show

===========  ==========================================================================================
report       that of ``modelcast demo``: its beginning, all of it, its first figure enlarged, its trip
             with losses
site         that of ``make docs``: a page of every kind, or every page
page         the live page, by day and at night: the drive of ``modelcast view --demo`` after 32 seconds,
             the nearest remote chosen, so the same each time
demo-live    the same page of ``modelcast demo-live``, by day and at night
===========  ==========================================================================================

With ``--write`` the pictures that README.md and docs show are made anew, into ``docs/images``.
"""

import argparse
import io
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from chromium import chromium
from modelcast.dashboard.demo import DemoDrive
from modelcast.dashboard.log import SnapshotLogWriter

if TYPE_CHECKING:
    from playwright.sync_api import Browser, FloatRect, Page

__all__ = ["SHOWN", "main"]

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
SHOWN = ("report", "live-page")
"""Pictures that pages show: files of ``docs/images``."""

SIZES = {"desk": (1440, 900), "phone": (390, 844)}
SCHEMES = {"day": "light", "night": "dark"}
SHOWN_SIZE, SHOWN_SCALE = (1080, 720), 1.5
"""What a page shows is a small window at a fine grain: its letters stay legible in a column of text."""

MARGIN_PX = 16
"""Around what is cut out of a page."""

QUALITY = 82
"""Of WebP: below it the letters of tables get halos."""

KINDS = ("index.html", "sections/reference.html", "how-to/my-csv.html", "wire.html", "api/fleets.html")
AT_S = 31.9
"""Of the drive: it is warned of a vehicle ahead."""

BEFORE_S = 15.0
"""Of the drive, seen before: else the remote that is chosen has no past."""

LIVE_S = 30.0


def main() -> None:
    """Make what is shown, and take the pictures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=TAKEN, default=["report", "site", "page"])
    parser.add_argument("--report", type=Path, help="of this report, instead of that of modelcast demo")
    parser.add_argument("--site", type=Path, help="of this built site, instead of one built for it")
    parser.add_argument("--every", action="store_true", help="of every page of the site")
    parser.add_argument("--write", action="store_true", help="make those that pages show, into docs/images")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    for name in asked.only:
        TAKEN[name](asked)


def _of_report(asked: argparse.Namespace) -> None:
    """Take ``report-*``, ``report-whole-*``, ``figure-*`` and ``trip-*``."""
    report: Path | None = asked.report
    if report is None:
        _run("-m", "modelcast", "demo", "--out", str(asked.folder / "demo"), "--quiet")
        report = asked.folder / "demo" / "report.html"
    address = report.resolve().as_uri()
    with _browser(tall=True) as browser:
        for size in SIZES:
            page = _opened(browser, address, size)
            page.screenshot(path=asked.folder / f"report-{size}.png")
            page.screenshot(path=asked.folder / f"report-whole-{size}.png", full_page=True)
            if page.locator("#playback").count():
                _with_losses(page)
                page.locator("#playback").screenshot(path=asked.folder / f"trip-{size}.png")
            page.locator("button.enlarge").first.click()
            page.screenshot(path=asked.folder / f"figure-{size}.png")
        if asked.write:
            page = _small(browser, address)
            _with_losses(page)
            _keep(page.screenshot(clip=_trip_alone(page), full_page=True), "report")


def _with_losses(page: "Page") -> None:
    """Choose the last channel of the played trip."""
    options = page.locator("#playback-channel option").count()
    page.locator("#playback-channel").select_option(index=options - 1)
    _settled(page)


def _trip_alone(page: "Page") -> "FloatRect":
    """Where the played trip is, without the note below it."""
    trip, note = (page.locator(name).bounding_box() for name in ("#playback", "#playback > .note"))
    assert trip is not None
    assert note is not None
    left, top = trip["x"] - MARGIN_PX, trip["y"] - MARGIN_PX
    return {"x": left, "y": top, "width": trip["width"] + 2 * MARGIN_PX, "height": note["y"] - top}


def _of_site(asked: argparse.Namespace) -> None:
    """Take ``site-*``, named by page."""
    site: Path | None = asked.site
    if site is None:
        site = asked.folder / "site"
        _run(str(ROOT / "tools" / "website" / "build.py"), "--out", str(site))
    names = (path.relative_to(site) for path in sorted(site.rglob("*.html")))
    pages = [name.as_posix() for name in names if name.parts[0] != "_static"] if asked.every else KINDS
    with _browser(tall=True) as browser:
        for name in pages:
            for size in SIZES:
                page = _opened(browser, (site / name).resolve().as_uri(), size)
                place = asked.folder / f"site-{name.removesuffix('.html').replace('/', '-')}-{size}.png"
                page.screenshot(path=place, full_page=True)
                page.context.close()


def _of_page(asked: argparse.Namespace) -> None:
    """Take ``page-*`` of a recorded drive, wound to one instant."""
    log = asked.folder / "drive.jsonl"
    with SnapshotLogWriter(log) as writer:
        for one in DemoDrive().snapshots(60.0):
            writer.write(one)
    with _served("view", str(log), "--port", "0") as address, _browser() as browser:
        for size in SIZES:
            for scheme in SCHEMES:
                page = _opened(browser, address, size, scheme)
                _wound(page)
                page.screenshot(path=asked.folder / f"page-{size}-{scheme}.png")
        if asked.write:
            page = _small(browser, address)
            _wound(page)
            _keep(page.screenshot(), "live-page")


def _wound(page: "Page") -> None:
    """Show the instant and all remotes, the nearest chosen."""
    page.locator("#legend li").first.wait_for()
    for back in range(int(BEFORE_S), -1, -1):
        shown = f"{AT_S - back:.1f}"
        page.locator("#scrub").fill(shown)
        page.locator("#time").filter(has_text=f"{shown} s").wait_for()
    page.locator("#scrub").blur()
    page.keyboard.press("0")
    page.keyboard.press("n")
    _settled(page)


def _of_demo_live(asked: argparse.Namespace) -> None:
    """Take ``demo-live-*`` of nodes that run; all windows look on for half a minute first."""
    words = ("demo-live", "--port", "0", "--udp-port", "16795", "--duration", "120")
    with _served(*words) as address, _browser() as browser:
        pages = {
            f"{size}-{scheme}": _opened(browser, address, size, scheme)
            for size in SIZES
            for scheme in SCHEMES
        }
        for page in pages.values():
            page.locator("#legend li").first.wait_for()
            page.keyboard.press("n")
        next(iter(pages.values())).wait_for_timeout(LIVE_S * 1000.0)
        for name, page in pages.items():
            _settled(page)
            page.screenshot(path=asked.folder / f"demo-live-{name}.png")


TAKEN: dict[str, Callable[[argparse.Namespace], None]] = {
    "report": _of_report,
    "site": _of_site,
    "page": _of_page,
    "demo-live": _of_demo_live,
}


def _run(*words: str) -> None:
    """Run a program of ours to its end."""
    subprocess.run([sys.executable, *words], check=True)  # noqa: S603 - our own scripts


@contextmanager
def _served(*words: str) -> Iterator[str]:
    """The address that a command of modelcast tells, as long as it is needed."""
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-u", "-m", "modelcast", *words], stdout=subprocess.PIPE, text=True
    ) as serving:
        assert serving.stdout is not None
        yield next(line.strip() for line in serving.stdout if line.startswith("http"))
        serving.terminate()


@contextmanager
def _browser(*, tall: bool = False) -> Iterator["Browser"]:
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - after the help

    with sync_playwright() as engine:
        browser = engine.chromium.launch(**chromium(tall=tall))
        yield browser
        browser.close()


def _opened(browser: "Browser", address: str, size: str, scheme: str = "day") -> "Page":
    """A page in a window of its own."""
    width, height = SIZES[size]
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme="dark" if SCHEMES[scheme] == "dark" else "light",
    )
    page = context.new_page()
    page.goto(address)
    return page


def _small(browser: "Browser", address: str) -> "Page":
    """A page in the window of pictures that pages show."""
    width, height = SHOWN_SIZE
    context = browser.new_context(
        viewport={"width": width, "height": height}, device_scale_factor=SHOWN_SCALE, color_scheme="light"
    )
    page = context.new_page()
    page.goto(address)
    return page


def _keep(picture: bytes, name: str) -> None:
    """Write a picture into the images of the pages."""
    assert name in SHOWN
    with Image.open(io.BytesIO(picture)) as opened:
        opened.convert("RGB").save(IMAGES / f"{name}.webp", quality=QUALITY, method=6)


def _settled(page: "Page") -> None:
    """Wait until what was changed is drawn."""
    for _ in range(2):
        page.evaluate("new Promise((done) => requestAnimationFrame(() => done(null)))")


if __name__ == "__main__":
    main()

"""Take pictures of the live page or of a report into a folder, wide and narrow.

Of the page they show, by day and at night, the drive of ``modelcast view --demo`` after 46 seconds, with the
remote nearest to the host chosen, or with ``--live`` the page of ``modelcast demo-live`` after half a minute.
Of a report they show all of it, its first figure enlarged and, where it plays a trip, the trip with losses.

    python tools/page_screenshots.py out/page
    python tools/page_screenshots.py --live out/live
    python tools/page_screenshots.py --report out/demo/report.html out/report
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.dashboard.demo import DemoDrive
from modelcast.dashboard.log import SnapshotLogWriter

if TYPE_CHECKING:
    from playwright.sync_api import Page

ARGUMENTS = [
    "--no-sandbox",
    "--disable-background-networking",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]
SIZES = {"wide": (1280, 800), "narrow": (390, 844)}
SHOWN_S = "45.9"
LIVE_S = 30.0


def main() -> None:
    """Serve what is shown, and take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--live", action="store_true", help="of modelcast demo-live, after half a minute")
    parser.add_argument("--report", type=Path, help="of this report")
    arguments = parser.parse_args()
    folder: Path = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    if arguments.report is not None:
        _take_report(arguments.report.resolve().as_uri(), folder)
        return
    words = [sys.executable, "-u", "-m", "modelcast"]
    if arguments.live:
        words += ["demo-live", "--port", "0", "--udp-port", "16795", "--duration", "120"]
    else:
        log = folder / "drive.jsonl"
        with SnapshotLogWriter(log) as writer:
            for one in DemoDrive().snapshots(60.0):
                writer.write(one)
        words += ["view", str(log), "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as serving:  # noqa: S603
        assert serving.stdout is not None
        address = next(line.strip() for line in serving.stdout if line.startswith("http"))
        _take(address, folder, live=arguments.live)
        serving.terminate()


def _take(address: str, folder: Path, *, live: bool) -> None:
    """Take the pictures; of what is live all contexts look on for half a minute first."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - after the help

    with sync_playwright() as engine:
        browser = engine.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        pages: dict[str, Page] = {}
        for name, (width, height) in SIZES.items():
            for scheme in ("light", "dark"):
                context = browser.new_context(
                    viewport={"width": width, "height": height}, color_scheme=scheme
                )
                page = pages[f"{name}-{'day' if scheme == 'light' else 'night'}"] = context.new_page()
                page.goto(address)
                page.locator("#legend li").first.wait_for()
                if not live:
                    page.locator("#scrub").fill(SHOWN_S)
                    page.locator("#time").filter(has_text=f"{SHOWN_S} s").wait_for()
                page.keyboard.press("n")
        if live:
            next(iter(pages.values())).wait_for_timeout(LIVE_S * 1000.0)
        for name, page in pages.items():
            _settled(page)
            page.screenshot(path=folder / f"{name}.png")
        browser.close()


def _take_report(address: str, folder: Path) -> None:
    """Take the pictures of a report: ``report-*``, ``figure-*`` and ``trip-*``."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - after the help

    with sync_playwright() as engine:
        # By software alone: a graphics processor's textures are shorter than a report.
        browser = engine.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        for name, (width, height) in SIZES.items():
            page = browser.new_context(viewport={"width": width, "height": height}).new_page()
            page.goto(address)
            page.screenshot(path=folder / f"report-{name}.png", full_page=True)
            trip = page.locator("#playback")
            if trip.count():
                page.locator("#playback-channel").select_option(
                    index=page.locator("#playback-channel option").count() - 1
                )
                _settled(page)
                trip.screenshot(path=folder / f"trip-{name}.png")
            page.locator("button.enlarge").first.click()
            page.screenshot(path=folder / f"figure-{name}.png")
        browser.close()


def _settled(page: "Page") -> None:
    """Wait until what was changed is drawn."""
    for _ in range(2):
        page.evaluate("new Promise((done) => requestAnimationFrame(() => done(null)))")


if __name__ == "__main__":
    main()

"""Take pictures of the page, wide and narrow, by day and at night, into a folder.

They show the drive of ``modelcast view --demo`` after 46 seconds, with the remote nearest to the host chosen.

    python tools/page_screenshots.py out/page
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from modelcast.dashboard.demo import DemoDrive
from modelcast.dashboard.log import SnapshotLogWriter

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


def main() -> None:
    """Write the log, serve it, and take the pictures."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - after the help

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder: Path = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "drive.jsonl"
    with SnapshotLogWriter(log) as writer:
        for one in DemoDrive().snapshots(60.0):
            writer.write(one)
    words = [sys.executable, "-u", "-m", "modelcast", "view", str(log), "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as serving:  # noqa: S603
        assert serving.stdout is not None
        address = serving.stdout.readline().strip()
        with sync_playwright() as engine:
            browser = engine.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
            for name, (width, height) in SIZES.items():
                for scheme in ("light", "dark"):
                    context = browser.new_context(
                        viewport={"width": width, "height": height}, color_scheme=scheme
                    )
                    page = context.new_page()
                    page.goto(address)
                    page.locator("#legend li").first.wait_for()
                    page.locator("#scrub").fill(SHOWN_S)
                    page.locator("#time").filter(has_text=f"{SHOWN_S} s").wait_for()
                    page.keyboard.press("n")
                    for _ in range(2):
                        page.evaluate("new Promise((done) => requestAnimationFrame(() => done(null)))")
                    page.screenshot(path=folder / f"{name}-{'day' if scheme == 'light' else 'night'}.png")
                    context.close()
            browser.close()
        serving.terminate()


if __name__ == "__main__":
    main()

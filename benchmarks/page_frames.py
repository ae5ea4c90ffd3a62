"""Find out how many frames a second the page draws with 500 remotes, and what a snapshot's text costs.

Snapshots of 10 Hz come as they do from a node: remotes in lanes, each with ellipse and path, all in sight.
Frames are counted in the page by `requestAnimationFrame`; drawn ones are those on which the map was painted.
Beside it the same page has nothing new to paint (paused): the most that this browser gives on this machine.
The browser draws in software where there is no graphics processor.

    python benchmarks/page_frames.py [--remotes 500] [--seconds 10]
"""

import argparse
import asyncio
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from measured import record
from modelcast import Station
from modelcast.core.chance import child_generator
from modelcast.dashboard.document import read_snapshot, snapshot_text
from modelcast.dashboard.feed import LiveFeed
from modelcast.dashboard.gate import Gate
from modelcast.dashboard.server import listen, page_server
from modelcast.dashboard.snapshot import AHEAD_S, Counters, Host, Remotes, Snapshot, snapshot_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))
from chromium import chromium


def snapshot(t_s: float, count: int) -> Snapshot:
    """Remotes in twenty lanes, 25 m apart, that drive east at 20 to 30 m/s."""
    rng = child_generator(0, "page", "bench")
    vehicle = np.arange(1, count + 1)
    lane, place = vehicle % 20, vehicle // 20
    speed_mps = rng.uniform(20.0, 30.0, count)
    position_m = np.stack([(25.0 * place + speed_mps * t_s) % 700.0, 20.0 * lane], axis=1)
    return Snapshot(
        t_s,
        Host(0, (350.0, 200.0), heading_rad=np.pi / 2, speed_mps=0.0, inputs="none"),
        remotes=Remotes(
            vehicle,
            position_m,
            heading_rad=np.full(count, np.pi / 2),
            speed_mps=speed_mps,
            semi_axes_m=rng.uniform(0.5, 4.0, (count, 1)) * np.array([1.0, 0.5]),
            angle_rad=np.zeros(count),
            ahead_s=AHEAD_S,
            path_m=position_m[:, None]
            + AHEAD_S[:, None] * np.stack([speed_mps, 0.0 * speed_mps], axis=1)[:, None],
            names=("Part I", "learned", "ctra", "gp-vehicle", "cv"),
            model=vehicle % 5,
            age_s=rng.uniform(0.0, 2.0, count),
            silent_s=rng.uniform(0.0, 4.0, count),
            messages=np.full(count, 100.0),
            loss_ratio=np.full(count, 0.3),
            error_m=rng.uniform(0.0, 1.0, count),
        ),
        counters=Counters(1.0, 1000.0),
    )


def text_costs(count: int) -> None:
    """Print what it takes to build, to write and to read a snapshot."""
    shown = snapshot(1.0, count)
    host = Station("baseline", temporary_id=2**31)
    heard = 0
    for one in range(count):
        sender = Station("baseline", temporary_id=one)
        for step in range(3):
            place = (float(one), 10.0 * 0.1 * step)
            for message in sender.sense(0.1 * step, place, speed_mps=10.0, heading_rad=0.0):
                host.hear([message.octets], received_s=[message.send_s])
                heard += 1
    text = snapshot_text(shown)
    assert host.believe(0.3).vehicle.size == count
    here = shown.host
    for name, work in (
        ("build from a station", lambda: snapshot_of(host, 0.3, here, counters=Counters())),
        ("write as text", lambda: snapshot_text(shown)),
        ("read and judge", lambda: read_snapshot(text)),
    ):
        took: list[float] = []
        for _ in range(20):
            begun_s = time.perf_counter()
            work()
            took.append(time.perf_counter() - begun_s)
        middle_ms, most_ms = 1e3 * statistics.median(took), 1e3 * max(took)
        record(name, middle_ms, "ms", sizes={"remotes": count})
        print(f"{count} remotes, {name}: median {middle_ms:.1f} ms, most {most_ms:.1f} ms")
    print(f"{count} remotes, text: {len(text)} bytes")


async def frames(count: int, seconds: float) -> None:
    """Print frames a second while snapshots come at 10 Hz, and with the page paused."""
    from playwright.async_api import async_playwright  # noqa: PLC0415 - the texts need none

    feed, gate = LiveFeed("bench"), Gate()
    texts = [snapshot(0.1 * step, count) for step in range(200)]
    with listen("127.0.0.1", 0, gate) as place:
        place.listen()
        server = page_server(feed, gate)
        serving = asyncio.create_task(server.serve(sockets=[place]))
        publishing = asyncio.create_task(_publish(feed, texts))
        async with async_playwright() as engine:
            browser = await engine.chromium.launch(**chromium())
            page = await browser.new_page(viewport={"width": 1280, "height": 800})
            await page.goto(f"http://127.0.0.1:{place.getsockname()[1]}/")
            await page.locator("#legend li").first.wait_for()
            await page.keyboard.press("0")
            await page.wait_for_timeout(2000)
            for name, key in (("live at 10 Hz", None), ("paused", "Space")):
                if key:
                    await page.keyboard.press(key)
                drawn, seen = await page.evaluate(
                    """(ms) => new Promise((done) => {
                      const of = () => Number(document.documentElement.dataset.frames);
                      const [first, begun] = [of(), performance.now()];
                      let seen = 0;
                      const frame = (now) => {
                        seen += 1;
                        const s = (now - begun) / 1000;
                        if (now - begun >= ms) done([(of() - first) / s, seen / s]);
                        else requestAnimationFrame(frame);
                      };
                      requestAnimationFrame(frame);
                    })""",
                    1000 * seconds,
                )
                record(f"{name}: animation frames", seen, "a second", sizes={"remotes": count})
                print(f"{count} remotes, {name}: {drawn:.1f} frames/s drawn, {seen:.1f} animation frames/s")
            await browser.close()
        publishing.cancel()
        server.should_exit = True
        await serving


async def _publish(feed: LiveFeed, shown: list[Snapshot]) -> None:
    begun_s, number = time.monotonic(), 0
    while True:
        feed.publish(replace(shown[number % len(shown)], t_s=0.1 * number))
        number += 1
        await asyncio.sleep(max(begun_s + 0.1 * number - time.monotonic(), 0.0))


def main() -> None:
    """Run both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--remotes", type=int, default=500)
    parser.add_argument("--no-texts", action="store_true", help="frames alone")
    parser.add_argument("--seconds", type=float, default=10.0)
    asked = parser.parse_args()
    if not asked.no_texts:
        text_costs(1000)
    asyncio.run(frames(asked.remotes, asked.seconds))


if __name__ == "__main__":
    main()

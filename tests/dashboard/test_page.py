"""Claims: in a browser the page shows what a feed gives, by mouse, keys and name, and asks nothing else."""

import asyncio
import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

from modelcast.dashboard.feed import AbstractFeed, LiveFeed
from modelcast.dashboard.gate import Gate
from modelcast.dashboard.log import SnapshotLog, SnapshotLogWriter
from modelcast.dashboard.server import listen, page_server
from modelcast.dashboard.snapshot import Snapshot

from ..verify.browser import opened_browser  # noqa: TID252 - tests are no package

MakeSnapshot = Callable[..., Snapshot]
pytestmark = pytest.mark.slow

NEAR = 4.0
"""Steps of 255 by which a colour on the screen may differ: the browser's own rounding."""

PATIENCE_MS = 10_000
"""After which a page that does not show what it should has failed."""

FIRST_SIGHT_M = 360.0
"""Across the map at first, as `main.js` has it."""


class Served:
    """A feed served by a thread of its own."""

    def __init__(self, feed: AbstractFeed) -> None:
        self._place = listen("127.0.0.1", 0, Gate())
        self._place.listen()
        self.where = f"http://127.0.0.1:{self._place.getsockname()[1]}/"
        self._server = page_server(feed, Gate())
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self.loop.run_until_complete(self._server.serve(sockets=[self._place]))

    def close(self) -> None:
        """Stop, and wait for it."""
        self._server.should_exit = True
        self._thread.join()
        self.loop.close()
        self._place.close()


@dataclass
class Looked:
    """A page, and what went wrong on it."""

    page: Any
    problems: list[str] = field(default_factory=list)

    def open(self, where: str) -> None:
        """Go there and wait for the first figures."""
        self.page.on(
            "console", lambda line: self.problems.append(line.text) if line.type == "error" else None
        )
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("request", lambda one: None if one.url.startswith((where, where.replace("http", "ws")))
                     else self.problems.append(one.url))  # fmt: skip
        self.page.goto(where)
        self.page.locator("#legend li").first.wait_for()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless Chromium, or a skip."""
    with opened_browser() as opened:
        yield opened


@pytest.fixture
def looked(browser: Any) -> Iterator[Looked]:
    """A wide page by day; at the end nothing may have gone wrong on it."""
    context = browser.new_context(viewport={"width": 1200, "height": 800}, color_scheme="light")
    context.set_default_timeout(PATIENCE_MS)
    found = Looked(context.new_page())
    yield found
    context.close()
    assert found.problems == []


@pytest.fixture
def log(tmp_path: Path, make_snapshot: MakeSnapshot) -> Iterator[str]:
    """A served log of 300 snapshots, of which the last hundred warn."""
    path = tmp_path / "drive.jsonl"
    with SnapshotLogWriter(path) as writer:
        for step in range(300):
            writer.write(make_snapshot(0.1 * step, 6, warned=step >= 200))
    with SnapshotLog(path) as feed:
        served = Served(feed)
        yield served.where
        served.close()


def drawn(page: Any) -> None:
    """Wait until what was changed is drawn."""
    for _ in range(2):
        page.evaluate("new Promise((done) => requestAnimationFrame(() => done(null)))")


def paused_at(page: Any, t_s: str) -> None:
    """Wind to a time by the slider."""
    page.locator("#scrub").fill(t_s)
    page.locator("#time").filter(has_text=f"{t_s} s").wait_for()
    drawn(page)


def test_a_log_plays_is_paused_and_is_stepped_by_keys(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    page.locator("#state").filter(has_text="playing").wait_for()
    paused_at(page, "12.5")
    page.locator("#state").filter(has_text="paused").wait_for()
    page.locator("#map").focus()
    page.keyboard.press("]")
    page.locator("#time").filter(has_text="12.6 s").wait_for()
    page.keyboard.press("[")
    page.locator("#time").filter(has_text="12.5 s").wait_for()
    page.keyboard.press("Space")
    page.locator("#time").filter(has_text="13.").wait_for()


def test_keys_choose_the_remotes_by_distance_and_let_go(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "5.0")
    titles = []
    for _ in range(2):
        page.keyboard.press("n")
        titles.append(page.locator("#chosen-title").inner_text())
    page.keyboard.press("p")
    assert [*titles, page.locator("#chosen-title").inner_text()] == ["Remote 1", "Remote 2", "Remote 1"]
    facts = page.locator("#chosen-facts").inner_text()
    for figure in ("ctra", "10.0 m/s", "0.25 m", "25 %", "1.50 \u00d7 0.50 m"):
        assert figure in facts
    assert "Remote 1" in page.locator("#chosen-said").inner_text()
    drawn(page)
    series = page.locator("#series figure:visible b").all_inner_texts()
    assert series == ["0.25 m", "0.4 s", "0.2 s", "1", "25 %", "ctra"]
    page.keyboard.press("Escape")
    assert page.locator("#chosen").is_hidden()


def test_series_leave_out_what_was_not_seen(looked: Looked, log: str) -> None:
    """A log that was wound on shows no line from the beginning to now."""
    looked.open(log)
    page = looked.page
    for t_s in ("24.0", "25.0"):
        paused_at(page, t_s)
    page.keyboard.press("n")
    drawn(page)
    canvas = page.get_by_role("img", name=re.compile("^Error over the last minute"))
    columns = canvas.evaluate(
        """(one) => {
          const [wide, high] = [one.width, one.height - 5];
          const { data } = one.getContext("2d").getImageData(0, 0, wide, high);
          const column = (k) => Array.from({ length: high }, (_, row) => data[4 * (row * wide + k) + 3]);
          return Array.from({ length: wide }, (_, k) => Math.max(...column(k)) > 99);
        }"""
    )
    second = len(columns) / 60.0
    ends = 8.0  # round ends of the line, and the dot of what was seen at first
    assert second <= sum(columns[len(columns) // 3 :]) <= second + ends


def test_a_click_chooses_the_remote_that_is_drawn_there(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "5.0")
    box = page.locator("#map").bounding_box()
    pixels = min(box["width"], box["height"]) / FIRST_SIGHT_M
    # The host is in the middle, at (50, 0) m; remote 2 is at (90, 10) m.
    page.mouse.click(
        box["x"] + box["width"] / 2 + 40.0 * pixels, box["y"] + box["height"] / 2 - 10.0 * pixels
    )
    assert page.locator("#chosen-title").inner_text() == "Remote 2"


def test_a_distance_is_measured_between_two_clicks(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "5.0")
    box = page.locator("#map").bounding_box()
    page.keyboard.press("m")
    for dx in (100, 250):
        page.mouse.click(box["x"] + dx, box["y"] + 300)
    wanted_m = 150.0 * FIRST_SIGHT_M / min(box["width"], box["height"])
    text = page.locator("#measured").inner_text()
    assert float(text.split(" m")[0]) == pytest.approx(wanted_m, abs=wanted_m / 150.0)  # a pixel
    assert "bearing 90°" in text


@pytest.mark.parametrize("night", [False, True])
def test_what_is_on_the_screen_has_the_colours_of_road_host_remotes_and_warning(
    browser: Any, log: str, themes: dict[str, dict[str, str]], *, night: bool
) -> None:
    """Of the picture as it is shown, not of what was drawn: a canvas may be drawn and not shown."""
    context = browser.new_context(
        viewport={"width": 1200, "height": 800}, color_scheme="dark" if night else "light"
    )
    found = Looked(context.new_page())
    found.open(log)
    paused_at(found.page, "25.0")
    picture = 255.0 * imread(BytesIO(found.page.locator("#map").screenshot()))[:, :, :3]
    of = themes["night" if night else "day"]
    for name in ("field", "road", "host", "ink", "alarm", "m1", "m2"):
        colour = [int(of[name][at : at + 2], 16) for at in (1, 3, 5)]
        assert np.abs(picture - colour).max(axis=2).min() < NEAR, name
    context.close()
    assert found.problems == []


def test_a_drag_moves_the_map_and_ends_following(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "5.0")
    assert page.locator("#follow").get_attribute("aria-pressed") == "true"
    box = page.locator("#map").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 260, box["y"] + 240)
    page.mouse.up()
    assert page.locator("#follow").get_attribute("aria-pressed") == "false"
    assert page.locator("#chosen").is_hidden()


def test_a_new_warning_is_announced_and_listed(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "10.0")
    assert page.locator("#warnings").inner_text() == "none"
    assert page.locator("#announce").inner_text() == ""
    paused_at(page, "25.0")
    assert "Forward collision warning: remote 2" in page.locator("#warnings").inner_text()
    assert page.locator("#announce").inner_text() == "Forward collision warning, remote 2"
    assert page.locator("#announce").get_attribute("aria-live") == "assertive"


def test_everything_that_is_used_has_a_name_and_is_reached_by_the_tab_key(looked: Looked, log: str) -> None:
    looked.open(log)
    page = looked.page
    paused_at(page, "5.0")
    for name in ("Play", "Follow", "Measure", "Night", "Keys", "Zoom in", "Zoom out", "Show all"):
        assert page.get_by_role("button", name=name, exact=True).count() == 1, name
    assert page.get_by_role("slider", name="Time").count() == 1
    assert page.get_by_role("application", name="Map of the remotes around the host").count() == 1
    page.locator("#pause").focus()
    order = []
    for _ in range(9):
        page.keyboard.press("Tab")
        order.append(page.evaluate("document.activeElement.id"))
    assert order == ["follow", "measure", "night", "help", "map", "zoom-in", "zoom-out", "fit", "scrub"]
    page.keyboard.press("?")
    assert page.get_by_role("heading", name="Keys", exact=True).is_visible()
    listed = page.locator("#keys dt").all_inner_texts()
    assert {"Space", "N, P", "F", "M", "D", "Escape", "L", "0"} <= set(listed)


def test_counters_stand_beside_the_map(looked: Looked, log: str) -> None:
    looked.open(log)
    paused_at(looked.page, "5.0")
    text = looked.page.locator("#counters").inner_text()
    for figure in ("30.0 /s, 6.0 kB/s", "2.0 /s, 0.4 kB/s", "25 %", "10 %", "GNSS and CAN", "9000, 10.0 m/s"):
        assert figure in text
    assert looked.page.locator("#rejected-sum").inner_text() == "4"


@pytest.mark.parametrize("night", [False, True])
def test_a_phone_shows_all_without_scrolling_sideways(browser: Any, log: str, *, night: bool) -> None:
    context = browser.new_context(
        viewport={"width": 360, "height": 740}, color_scheme="dark" if night else "light", has_touch=True
    )
    found = Looked(context.new_page())
    found.open(log)
    page = found.page
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    assert page.evaluate("document.documentElement.scrollHeight") <= 740
    assert page.evaluate("document.documentElement.dataset.night") == ("true" if night else "false")
    for button in page.locator("header button, .zoom button").all():
        box = button.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 360
        assert box["height"] >= 34
    page.locator("#night").click()
    assert page.evaluate("document.documentElement.dataset.night") == ("false" if night else "true")
    context.close()
    assert found.problems == []


def test_a_live_page_is_paused_wound_back_and_brought_back_to_now(
    looked: Looked, make_snapshot: MakeSnapshot
) -> None:
    feed = LiveFeed("live")
    feed.publish(make_snapshot(0.0))
    served = Served(feed)
    try:
        looked.open(served.where)
        page = looked.page

        def publish(first: int, last: int) -> None:
            """Give snapshots one by one, each when the one before is shown or kept."""
            for step in range(first, last):
                served.loop.call_soon_threadsafe(feed.publish, make_snapshot(float(step)))
                page.locator(f'#scrub[max="{step}"]').wait_for(state="attached")

        publish(1, 6)
        page.locator("#time").filter(has_text="5.0 s").wait_for()
        page.keyboard.press("Space")
        publish(6, 9)
        assert page.locator("#time").inner_text() == "5.0 s"
        paused_at(page, "2.0")
        page.keyboard.press("n")
        assert "Remote 1" in page.locator("#chosen-title").inner_text()
        page.get_by_role("button", name="Live").click()
        page.locator("#time").filter(has_text="8.0 s").wait_for()
    finally:
        served.close()


def test_a_page_says_when_the_connection_is_lost(browser: Any, make_snapshot: MakeSnapshot) -> None:
    feed = LiveFeed("live")
    feed.publish(make_snapshot(0.0))
    served = Served(feed)
    page = browser.new_page()
    page.goto(served.where)
    page.locator("#state").filter(has_text="live").wait_for()
    served.close()
    page.locator("#state").filter(has_text="connection lost").wait_for()
    page.close()


def test_names_from_a_log_are_shown_as_text(
    looked: Looked, tmp_path: Path, make_snapshot: MakeSnapshot
) -> None:
    markup = "<img src=x onerror=alert(1)>"
    shown = make_snapshot(1.0)
    names = (markup, "ctra", "cv")
    with SnapshotLogWriter(tmp_path / "log") as writer:
        writer.write(replace(shown, remotes=replace(shown.remotes, names=names)))
    with SnapshotLog(tmp_path / "log") as feed:
        served = Served(feed)
        looked.open(served.where)
        assert markup in looked.page.locator("#legend").inner_text()
        assert looked.page.locator("#legend img").count() == 0
        served.close()

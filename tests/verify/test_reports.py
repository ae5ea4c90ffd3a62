"""Claims: reports are sound in a browser, by phone and desk; what is played is what was evaluated."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from modelcast.cli.app import run
from modelcast.report.html import write_report
from modelcast.report.playback import MOST_SAMPLES, played_samples
from modelcast.station.banks import bank_from_text
from modelcast.study.case import SensedTrip
from modelcast.study.evaluate import evaluate
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive

from .browser import VIEWS, View, faults, opened_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.slow

PLATOON = "openacc_zalazone/short_setting__dynamic_part12.csv"
COMMANDS = {
    "demo": ["demo", "--duration", "120"],
    "evaluate": ["evaluate", "{data}/" + PLATOON, "--trip", "*TESLA_MODELX", "--threshold", "0.2", "0.5",
                 "--per", "0", "0.4", "--seeds", "2"],
    "network": ["network", "--density", "25", "--duration", "12", "--policy", "j2945", "j2945-mbc"],
    "safety": ["safety", "{data}/" + PLATOON, "--threshold", "0.2", "--seeds", "2"],
}  # fmt: skip
PHONE, DESK = VIEWS[0], VIEWS[2]


@pytest.fixture(scope="module")
def report_of(tmp_path_factory: pytest.TempPathFactory, data_folder: Path) -> Callable[[str], str]:
    """What gives the address of the report that a command writes; each runs once."""
    folder = tmp_path_factory.mktemp("reports")

    @cache
    def written(name: str) -> str:
        given = [word.format(data=data_folder) for word in COMMANDS[name]]
        assert run([*given, "--out", str(folder / name), "--quiet"]) == 0
        return (folder / name / "report.html").as_uri()

    return written


@pytest.fixture(scope="module")
def result() -> EvaluationResult:
    """A generated drive, evaluated."""
    drive = generate_drive(seed=4, duration_s=90.0)
    settings = EvaluationSettings((0.2,), (0.0, 0.4), seeds=1, bank=bank_from_text("ctra+cv"))
    return evaluate([SensedTrip(drive.truth, drive.input)], settings)


@pytest.fixture(scope="module")
def address(result: EvaluationResult, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Of its report."""
    return write_report(result, tmp_path_factory.mktemp("report"))[0].as_uri()


@pytest.fixture
def page(browser: "Browser", address: str) -> Iterator["Page"]:
    """The report on a desk; at the end nothing may have gone wrong on it."""
    problems: list[str] = []
    with opened_page(browser, address, DESK, problems) as opened:
        yield opened
    assert problems == []


@pytest.mark.real
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("view", [VIEWS[0], VIEWS[3]], ids=str)
def test_a_report_has_no_fault(
    browser: "Browser", report_of: Callable[[str], str], name: str, view: View
) -> None:
    """Reports look the same by day and at night, so each size is looked at once."""
    assert faults(browser, report_of(name), view) == []


@pytest.mark.parametrize("view", VIEWS[::2], ids=str)
def test_a_figure_opens_large_and_closes_by_escape(browser: "Browser", address: str, view: View) -> None:
    def opened(page: "Page") -> None:
        button = page.locator("button.enlarge").first
        assert button.locator("span").is_visible() == (view.width_px < 700)
        button.focus()
        page.keyboard.press("Enter")
        figure = page.locator("dialog img")
        figure.wait_for()
        box: Any = figure.bounding_box()
        assert page.locator("dialog p").is_visible() == (view.width_px < 700)
        if view.width_px < 700:
            assert box["width"] >= 1.5 * figure.evaluate("(image) => image.naturalWidth")
        else:
            assert box["y"] >= 0.0
            assert box["y"] + box["height"] <= view.height_px
            assert box["height"] > 0.8 * view.height_px

    assert faults(browser, address, view, prepare=opened) == []
    with opened_page(browser, address, view, []) as page:
        opened(page)
        page.keyboard.press("Escape")
        assert page.locator("dialog[open]").count() == 0
        assert page.evaluate("document.activeElement.className") == "enlarge"
        page.locator("button.enlarge").nth(2).click()
        assert (
            str(page.locator("dialog img").get_attribute("alt"))
            in page.locator("figcaption").nth(2).inner_text()
        )


def _shown_s(page: "Page") -> float:
    return float(page.locator("#playback-now").inner_text().removesuffix(" s"))


def _told(page: "Page") -> list[list[str]]:
    """Rows of the table: error, age, sub-model, sent, lost of every receiver."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return [row.split("\t") for row in page.locator("#playback-figures tbody tr").all_inner_texts()]


def _plays_on(page: "Page", from_s: float) -> None:
    page.locator("#playback-now").filter(has_not_text=f"{from_s:.1f} s").wait_for()
    assert _shown_s(page) > from_s


def test_nothing_moves_before_it_is_asked_to_and_then_by_button_and_space(page: "Page") -> None:
    start_s = _shown_s(page)
    play = page.locator("#playback-play")
    assert play.inner_text() == "Play"
    play.click()
    _plays_on(page, start_s)
    assert play.inner_text() == "Pause"
    play.press("Space")
    assert play.inner_text() == "Play"
    still_s = _shown_s(page)
    for place in ("#playback-map", "#playback-timeline", "#playback-time"):
        page.locator(place).focus()
        page.keyboard.press("Space")
        _plays_on(page, still_s)
        page.keyboard.press("Space")
        assert play.inner_text() == "Play"
        still_s = _shown_s(page)


def test_it_glides_and_stops_at_the_end(browser: "Browser", address: str) -> None:
    """Without a wish for stillness every picture is a new one; the end stops it, and Play begins again."""
    with opened_page(browser, address, DESK, []) as page:
        page.emulate_media(reduced_motion="no-preference")
        slider = page.locator("#playback-time")
        end_s = float(slider.get_attribute("max") or "nan")
        slider.fill(str(end_s - 1.0))
        page.locator("#playback-play").click()
        page.locator("#playback-play", has_text="Play").wait_for()
        _told(page)
        assert _shown_s(page) == pytest.approx(end_s, abs=0.05)
        page.locator("#playback-play").click()
        page.locator("#playback-now").filter(has_text=re.compile(r"^[0-9]\.[0-9] s$")).wait_for()


@pytest.mark.parametrize("channel", [0, 1])
def test_figures_told_are_those_that_were_evaluated(
    page: "Page", result: EvaluationResult, channel: int
) -> None:
    playback = result.playback
    assert playback is not None
    page.locator("#playback-channel").select_option(str(channel))
    runs = playback.runs[3 * channel : 3 * channel + 3]
    for at in (100, 415, 800):
        page.locator("#playback-time").fill(str(playback.t_s[at]))
        for run_, told in zip(runs, _told(page), strict=True):
            sent = run_.sent <= at
            heard = run_.sent[sent & ~run_.lost]
            assert float(told[1].removesuffix(" m")) == pytest.approx(playback.error_m(run_)[at], abs=0.0061)
            age_s = playback.t_s[at] - playback.t_s[heard[-1]]
            assert float(told[2].removesuffix(" s ago")) == pytest.approx(age_s, abs=0.051)
            last = int(np.flatnonzero(run_.sent == heard[-1])[0])
            assert told[3] == run_.members[run_.in_use[last]]
            assert [int(told[4]), int(told[5])] == [sent.sum(), (sent & run_.lost).sum()]
    assert bool(any(run_.lost.any() for run_ in runs)) == (channel == 1)


def test_of_a_thinned_trip_no_error_is_told_where_samples_were_left_out(
    browser: "Browser", result: EvaluationResult, tmp_path: Path
) -> None:
    """The trip drives straight on, so few samples are kept; its errors are 1 m, and told where kept."""
    count = MOST_SAMPLES + 1_000
    assert result.playback is not None
    t_s = 0.1 * np.arange(count)
    truth_m = np.stack([10.0 * t_s, 0.0 * t_s], axis=1)
    runs = tuple(replace(run_, believed_m=truth_m + np.array([0.0, 1.0])) for run_ in result.playback.runs)
    long = replace(
        result.playback, at_s=30.0, t_s=t_s, truth_m=truth_m, parts=np.array([], dtype=np.int64), runs=runs
    )
    kept = played_samples(long)
    left_out = int(np.setdiff1d(np.arange(count), kept)[-1])
    address = write_report(replace(result, playback=long), tmp_path)[0].as_uri()
    problems: list[str] = []
    with opened_page(browser, address, DESK, problems) as page:
        for at, error in ((int(kept[-2]), "1.00 m"), (left_out, "\N{EN DASH}")):
            page.locator("#playback-time").fill(f"{t_s[at]:.1f}")
            assert [told[1] for told in _told(page)] == 3 * [error]
    assert problems == []


def _pointed_s(page: "Page", share: float) -> float:
    """The time told where the pointer is on the errors, so far from the left."""
    box: Any = page.locator("#playback-timeline .u-over").bounding_box()
    page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
    when = page.locator("#playback-when", has_text="Pointed at")
    when.wait_for()
    return float(when.inner_text().removeprefix("Pointed at: ").removesuffix(" s"))


def test_values_are_told_where_the_pointer_is_and_time_zooms(page: "Page") -> None:
    page.locator("#playback-timeline").scroll_into_view_if_needed()
    left_s, right_s = _pointed_s(page, 0.1), _pointed_s(page, 0.9)
    assert right_s - left_s == pytest.approx(24.0, abs=0.3)
    page.locator("#playback-timeline").focus()
    page.keyboard.press("+")
    assert _pointed_s(page, 0.9) - _pointed_s(page, 0.1) == pytest.approx(12.0, abs=0.3)
    page.keyboard.press("0")
    whole_s = float(page.locator("#playback-time").get_attribute("max") or "nan")
    assert _pointed_s(page, 0.9) - _pointed_s(page, 0.1) == pytest.approx(0.8 * whole_s, abs=0.5)


def test_a_click_goes_to_its_time_and_a_drag_chooses_a_span(page: "Page") -> None:
    over = page.locator("#playback-timeline .u-over")
    over.scroll_into_view_if_needed()
    there_s = _pointed_s(page, 0.75)
    page.mouse.down()
    page.mouse.up()
    _told(page)
    assert _shown_s(page) == pytest.approx(there_s, abs=0.11)
    right_s, left_s = _pointed_s(page, 0.6), _pointed_s(page, 0.2)
    page.mouse.down()
    _pointed_s(page, 0.6)
    page.mouse.up()
    margin_s = 0.02 * (right_s - left_s)
    assert _pointed_s(page, 0.02) == pytest.approx(left_s + margin_s, abs=0.15)
    assert _pointed_s(page, 0.98) == pytest.approx(right_s - margin_s, abs=0.15)


def _same_map(page: "Page", before: bytes) -> bool:
    return page.locator("#playback-map").screenshot() == before


def test_the_map_zooms_moves_follows_and_shows_the_whole_trip(page: "Page") -> None:
    canvas = page.locator("#playback-map")
    assert page.locator("#playback-channel").input_value() == "1"  # it opens with losses
    follow = page.locator("#playback-follow")
    _told(page)
    first = canvas.screenshot()
    canvas.focus()
    for key, follows in (("+", "true"), ("ArrowLeft", "false"), ("0", "false")):
        before = canvas.screenshot()
        page.keyboard.press(key)
        _told(page)
        assert not _same_map(page, before), key
        assert follow.get_attribute("aria-pressed") == follows
    follow.click()
    _told(page)
    canvas.focus()
    assert follow.get_attribute("aria-pressed") == "true"
    assert not _same_map(page, first)
    box: Any = canvas.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.locator("#playback-when", has_text="Pointed at").wait_for()  # the path runs through the middle


def test_without_scripts_the_drawn_figures_stand_alone(browser: "Browser", address: str) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(address)
    assert page.locator("#playback").is_hidden()
    assert page.locator("figure img").count() == 6
    assert page.locator("figure img").first.is_visible()
    context.close()

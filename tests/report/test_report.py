"""The HTML report, the console tables and the data frames."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from rich.console import Console

from modelcast.report.console import console_report
from modelcast.report.html import report_document, write_report
from modelcast.report.settings_section import settings_section
from modelcast.report.tables import events_frame, rates_frame, samples_frame, tracking_frame, trips_frame
from modelcast.study.result import RATES, TRACKING, EvaluationResult

Make = Callable[..., EvaluationResult]
ReadPage = Callable[[str], Any]


@pytest.fixture
def page_without_figures(read_page: ReadPage) -> Callable[[EvaluationResult], Any]:
    return lambda result: read_page(report_document(result, ()))


@pytest.mark.slow
def test_report_needs_no_network_and_its_figures_no_script(
    make_result: Make, tmp_path: Path, read_page: ReadPage
) -> None:
    text = write_report(make_result(), tmp_path)[0].read_text(encoding="utf-8")
    page = read_page(text)
    assert not page.open
    assert page.tags.count("figure") == 6
    assert all(address.startswith("data:") for address in page.addresses)
    assert not {"link", "iframe", "object"} & set(page.tags)
    assert "http:" not in text.replace("http://www.w3.org/", "")  # names of what SVG is, no addresses
    assert "https:" not in text
    assert "@import" not in text


def test_names_are_text_not_markup(make_result: Make, page_without_figures: Any) -> None:
    page = page_without_figures(make_result())
    assert not any("alert" in one for one in page.scripts)
    assert "<script>alert(1)</script>/$3" in page.text
    assert "broken/<b>7</b>" in page.text


@pytest.mark.slow
def test_report_says_what_the_labels_mean(make_result: Make, tmp_path: Path, read_page: ReadPage) -> None:
    text = read_page(write_report(make_result(), tmp_path)[0].read_text(encoding="utf-8")).text
    for claim in (
        "the log is both input and truth",
        "a keep-alive after 2 s",
        "after the instant's message",
        "all send as often as MBC (updates and identifications counted)",
        "MBC: a vehicle sends a small model of its motion",
        "At the same rate: the same percentile",
        "protocol: recorded, sensor",
        "no fix: 10",
        "sigma m",
        "0.04",
        "time does not increase",
    ):
        assert claim in text, claim


def heads_of(document: str) -> list[list[str]]:
    """The headings of each table of a page."""
    return [re.findall("<th[^>]*>(.*?)</th>", head) for head in re.findall("<thead>(.*?)</thead>", document)]


def test_the_first_table_is_messages_alone_and_the_loss_tables_say_that_they_keep_alive(
    make_result: Make,
) -> None:
    result = make_result()
    document = report_document(result, [])
    first, costs, loss, equal = heads_of(document)[:4]
    answer = ["threshold [cm]", "MBC [1/s]", "free receiver [1/s]", "baseline [1/s]"]
    answer += ["MBC / free receiver", "MBC / baseline"]
    assert first == [*answer, "MBC identifications [1/s]"]
    rates = RATES.table(row.replaced(identifications=0) for row in result.rates)
    assert heads_of(report_document(replace(result, rates=rates), []))[0] == answer
    assert costs[1:4] == ["MBC [byte/s]", "free receiver [byte/s]", "baseline [byte/s]"]
    assert max(map(len, (first, costs, loss, equal))) <= 8
    assert "<td>20</td>" in document
    assert "20.00" not in document
    assert "<h3>Same threshold, with losses and a message at least every 2 s</h3>" in document
    assert "<h3>Same threshold, without loss: messages</h3>" in document
    silent = report_document(replace(result, settings={**result.settings, "keep_alive_s": None}), [])
    assert "<h3>Same rate, with losses</h3>" in silent
    lossless = report_document(make_result(ratios=(0.0,)), [])
    assert "<h3>Same threshold, with a message at least every 2 s</h3>" in lossless


@pytest.mark.parametrize(
    ("settings", "claim"),
    [
        ({"keep_alive_s": None}, "independent losses and no keep-alive"),
        ({"keep_alive_s": 1.0, "mean_burst_s": 0.5}, "losses in bursts of 0.5 s on average and a keep-alive"),
        ({}, "with independent losses."),
    ],
)
def test_report_claims_only_what_the_settings_say(
    make_result: Make, settings: dict[str, object], claim: str, page_without_figures: Any
) -> None:
    assert claim in page_without_figures(replace(make_result(), settings=settings)).text


@pytest.mark.slow
def test_report_is_the_same_twice_and_names_no_folder(make_result: Make, tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / name).mkdir()
        write_report(make_result(), tmp_path / name)
    first, second = ((tmp_path / name / "report.html").read_bytes() for name in "ab")
    assert first == second
    assert str(tmp_path).encode() not in first


def test_report_of_many_trips_leaves_their_rows_to_the_summary(
    make_result: Make, page_without_figures: Any
) -> None:
    page = page_without_figures(make_result(trips=[f"t/{k}" for k in range(8)]))
    assert "rows of single trips are in summary.json" in page.text


def test_report_of_nothing(make_result: Make, page_without_figures: Any) -> None:
    empty = replace(
        make_result(timeline=False, manoeuvre=False),
        trips=(),
        rates=RATES.table(),
        tracking=TRACKING.table(),
        ecdfs=(),
        settings={},
        failures={},
    )
    assert "Every trip was evaluated." in page_without_figures(empty).text


def printed(result: EvaluationResult) -> str:
    console = Console(width=100, record=True, file=open("/dev/null", "w", encoding="utf-8"))  # noqa: SIM115, PTH123
    with console.capture() as capture:
        console.print(console_report(result))
    console.file.close()
    return capture.get()


def test_console_fits_in_100_columns_and_shows_the_rates(make_result: Make) -> None:
    text = printed(make_result())
    assert max(len(line) for line in text.splitlines()) <= 100
    assert "…" not in text
    for value in (
        "20 cm",
        "1.58",
        "1.60",
        "0.99",
        "40 %",
        "fewer than 11 samples [bold]",
        "in metres",
        "MBC (model-based",
    ):
        assert value in text, value
    titles = " ".join(text.split())
    assert "Same threshold: messages per second without loss, all trips" in titles
    assert "Same threshold, with losses and a message at least every 2 s: messages per second" in titles


def test_console_of_rates_alone(make_result: Make) -> None:
    text = printed(replace(make_result(), tracking=TRACKING.table(), failures={}))
    assert "Same threshold: messages per second" in text
    assert "p90" not in text
    assert "Errors were not measured" in text


def test_frames_have_the_same_types_with_and_without_rows(make_result: Make) -> None:
    result = make_result(seeds=1)
    empty = replace(result, trips=(), rates=result.rates[:0], tracking=result.tracking[:0], samples=())
    for frame in (trips_frame, rates_frame, tracking_frame, samples_frame):
        assert frame(result).schema == frame(empty).schema
        assert frame(result).height > 0
        assert frame(empty).height == 0


def test_frames_hold_the_rows(make_result: Make) -> None:
    result = make_result()
    assert rates_frame(result)["total_rate_hz"].to_list() == [row.total_rate_hz for row in result.rates]
    tracking = tracking_frame(result)
    assert tracking.schema["pte_p90_low_m"] == pl.Float64
    assert tracking.schema["seeds"] == pl.Int64
    assert tracking.schema["rate_basis"] == pl.String
    trips = trips_frame(result)
    assert trips["skipped"].to_list() == [0, 10, 10]
    assert trips["grid_north_m"].to_list() == [0.01] * 3
    assert events_frame(result).schema["trip"] == pl.String


def test_sample_rows_run_over_ratios_seeds_and_instants(make_result: Make) -> None:
    frame = samples_frame(make_result(ratios=(0.0, 0.4), trips=("a/1",)))
    assert frame.height == 2 * 2 * 2 * 5
    assert frame["packet_error_ratio"].to_list()[:20] == [0.0] * 10 + [0.4] * 10
    assert frame["seed"].to_list()[:10] == [0] * 5 + [1] * 5
    assert frame["rate_basis"].to_list() == [None] * 20 + ["total"] * 20
    assert frame["tracking_error_m"].null_count() == 2
    assert frame["tracking_error_m"][19] == pytest.approx(0.19)


def test_warnings_stand_before_any_figure(make_result: Make) -> None:
    result = make_result()
    shown = printed(result)
    assert shown.index("warning: rate") < shown.index("messages per second")
    document = report_document(result, ())
    assert document.index("sampled at &lt;5&gt; Hz") < document.index("<h2>Result</h2>")
    clean = replace(result, trips=tuple(replace(trip, warnings={}) for trip in result.trips))
    assert "Warnings" not in report_document(clean, ())


def test_settings_are_words_with_units_and_what_is_not_given_is_one_line(
    make_result: Make, page_without_figures: Any
) -> None:
    settings = {
        "budget": 4 / 3,
        "sub_models": ["FreeMotion(estimates=(1, 2), label='free')", "ConstantVelocity()"],
        "sub_model_names": ["free", "cv"],
        "sensor": {"heading_noise_rad": 0.0034906585, "speed_noise_mps": 0.1},
        "policy": "Above(limit_m=0.5, table=(1, 2))",
        "costs": None,
        "expiry_s": None,
    }
    text = page_without_figures(replace(make_result(), settings=settings)).text.partition("Settings")[2]
    for said in (
        "budget1.333",
        "sub modelsfree, cv",
        "sensor: heading noise0.2°",
        "sensor: speed noise0.1 m/s",
        "policyabove: limit 0.5 m, whole in summary.json",
        "Not given: costs, expiry.",
    ):
        assert said in text
    assert "None" not in text
    assert "(estimates" not in text


def test_settings_that_are_as_by_default_are_folded() -> None:
    text = settings_section({"seed": 5, "seeds": 3, "cost": None}, {"seed": 0, "seeds": 3})
    shown, _, folded = text.partition("<details>")
    assert "seed</td>" in shown
    assert "seeds</td>" not in shown
    assert "As by default (1)" in folded
    assert "seeds</td>" in folded


def test_sub_models_of_the_same_names_and_other_numbers_are_not_as_by_default() -> None:
    usual = {"sub_models": ["Free(gain=1.0)"], "sub_model_names": ["free"]}
    same = settings_section(usual, usual)
    assert "As by default (1)" in same
    assert "not the shipped numbers" not in same
    own = settings_section({**usual, "sub_models": ["Free(gain=2.0)"]}, usual)
    assert "As by default" not in own
    assert "free (not the shipped numbers)</td>" in own
    other = settings_section({"sub_models": ["ConstantVelocity()"], "sub_model_names": ["cv"]}, usual)
    assert "cv</td>" in other
    assert "not the shipped numbers" not in other


def test_a_long_setting_is_shortened_and_says_where_it_is_whole() -> None:
    long = ", ".join(f"file {at}" for at in range(100))
    text = settings_section({"paths": long})
    assert f"{long[:240]}\u2026 (whole in summary.json)" in text
    assert long not in text

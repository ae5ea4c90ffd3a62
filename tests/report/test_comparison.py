"""The table and figure of a comparison show what they are given, whatever that holds."""

import io
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from modelcast.models.bank import Bank
from modelcast.report.comparison import (
    comparison_console,
    comparison_markdown,
    comparison_page,
    write_comparison_report,
)
from modelcast.report.comparison_findings import comparison_findings
from modelcast.report.figures import plot_comparison
from modelcast.report.figures.files import Drawing, drawn
from modelcast.report.style import style
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.compare.result import (
    COUNTS,
    RATIOS,
    REFERENCE_RATIOS,
    RIVAL_RATIOS,
    ROUTES,
    TRACKING_RATIOS,
    CandidateRow,
    ComparedTrip,
    ComparisonResult,
)
from modelcast.study.table import Row

NAMES = ("cv", "ctra", "gp+cv order/on-failure")


def made(
    names: Sequence[str] = NAMES,
    thresholds: Sequence[float] = (0.2, 0.5),
    ratios: Sequence[float] = (0.0, 0.4),
    protocols: Sequence[str] = ("recorded", "sensor"),
    *,
    limits: bool = True,
    references: bool = True,
) -> ComparisonResult:
    """A made-up comparison of any size."""
    value = {name: 0.5 + 0.2 * at for at, name in enumerate(names)}
    spread = 0.1 if limits else None

    def ends(middle: float) -> tuple[float | None, float | None]:
        return (None, None) if spread is None else (middle - spread, middle + spread)

    return ComparisonResult(
        {"seed": 0, "against": names[0]},
        routes=ROUTES.table(
            ROUTES.row(route=at, name=name, trips=2 - at, duration_s=600.0 - 300.0 * at)
            for at, name in enumerate(("hills|and dales", "<town>"))
        ),
        trips=tuple(
            ComparedTrip(f"t/{at}", "csv", at // 2, duration_s=300.0, samples=3000, dt_s=0.1)
            for at in range(3)
        ),
        candidates=tuple(
            CandidateRow(
                name,
                (f"SubModel({name!r})",),
                start="order",
                identify="on-failure",
                is_trained=False,
                is_hybrid="+" in name,
                update_bytes=48,
            )
            for name in names
        ),
        ratios=RATIOS.table(
            RATIOS.row(
                candidate=name,
                protocol=protocol,
                threshold_m=threshold_m,
                trips=3,
                duration_s=900.0,
                update_rate_hz=0.6,
                identification_rate_hz=0.1,
                baseline_rate_hz=1.4,
                message_ratio=value[name] + threshold_m,
                message_low=ends(value[name] + threshold_m)[0],
                message_high=ends(value[name] + threshold_m)[1],
                difference=value[name] - value[names[0]],
                difference_low=ends(0.0)[0],
                difference_high=ends(0.0)[1],
                bytes_per_s=90.0,
                baseline_bytes_per_s=57.0,
                bytes_ratio=1.6 * value[name],
                bytes_low=ends(1.6 * value[name])[0],
                bytes_high=ends(1.6 * value[name])[1],
                airtime_per_s=0.6e-3,
                baseline_airtime_per_s=0.5e-3,
                airtime_ratio=1.2 * value[name],
                airtime_low=ends(1.2 * value[name])[0],
                airtime_high=ends(1.2 * value[name])[1],
                trips_over=1,
                worst_trip="t/2|$x$",
                worst_excess=4.0 - threshold_m,
                worst_ratio=1.25,
            )
            for name in names
            for protocol in protocols
            for threshold_m in thresholds
        ),
        tracking=TRACKING_RATIOS.table(
            tracking(name, protocol, trip, threshold_m=threshold_m, ratio=ratio, value=value[name])
            for name in names
            for protocol in protocols
            for trip in ("all", "t/0")
            for threshold_m in thresholds
            for ratio in ratios
        ),
        counts=COUNTS.table(
            COUNTS.row(
                candidate=names[0],
                protocol=protocol,
                trip="t/0",
                route=0,
                threshold_m=0.2,
                updates=10,
                identifications=2,
                message_bytes=500,
                baseline_messages=14,
                baseline_bytes=560,
                airtime_s=0.004,
                baseline_airtime_s=0.005,
                duration_s=300.0,
            )
            for protocol in protocols[:1]
        ),
        references=REFERENCE_RATIOS.table(
            REFERENCE_RATIOS.row(
                reference=reference, protocol=protocol, threshold_m=threshold_m, message_ratio=ratio
            )
            for reference, ratio in (("clairvoyant-1", 0.3), ("clairvoyant-2", 0.2), ("cam", 2.5))
            for protocol in protocols
            for threshold_m in thresholds
            if references
        ),
        failures={"bad|one/1": "its longest part has 3 samples"},
    )


def tracking(name: str, protocol: str, trip: str, *, threshold_m: float, ratio: float, value: float) -> Row:
    found = value + threshold_m + ratio + (5.0 if trip != "all" else 0.0)
    return TRACKING_RATIOS.row(
        candidate=name,
        protocol=protocol,
        trip=trip,
        threshold_m=threshold_m,
        packet_error_ratio=ratio,
        rate_basis="total",
        message_rate_hz=0.9,
        matched_rate_hz=0.9,
        periodic_rate_hz=0.9,
        p90_m=found,
        matched_p90_m=1.0,
        periodic_p90_m=1.2,
        baseline_rate_hz=1.5,
        free_rate_hz=1.2,
        free_matched_rate_hz=0.9,
        p90_ratio=found,
        p90_low=found - 0.1,
        p90_high=found + 0.1,
        baseline_p90_m=0.5,
        free_p90_m=0.8,
        free_matched_p90_m=0.9,
        p90_over_free=found / 0.9,
        p90_over_free_low=None,
        p90_over_free_high=None,
        p99_m=2 * found,
        matched_p99_m=4.0,
        periodic_p99_m=5.0,
        p99_ratio=found / 2,
        p99_low=None,
        p99_high=None,
        baseline_p99_m=1.0,
        free_p99_m=1.6,
        free_matched_p99_m=1.8,
        p99_over_free=found / 0.9,
        p99_over_free_low=None,
        p99_over_free_high=None,
    )


def against(*rivals: str, free: str | None = None) -> ComparisonResult:
    """The made-up comparison with figures over some of its candidates, the first the one compared against."""
    result = made()
    return replace(
        result,
        settings={**result.settings, "against": rivals[0], "free": free},
        rivals=RIVAL_RATIOS.table(
            RIVAL_RATIOS.row(
                candidate=row.candidate,
                rival=rival,
                protocol=row.protocol,
                threshold_m=row.threshold_m,
                message_ratio=2.0 * row.message_ratio,
                message_low=1.9 * row.message_ratio,
                message_high=2.1 * row.message_ratio,
                bytes_ratio=3.0 * row.message_ratio,
                bytes_low=None,
                bytes_high=None,
                airtime_ratio=4.0 * row.message_ratio,
                airtime_low=None,
                airtime_high=None,
                trips=3,
                trips_over=2,
                worst_trip="t/1|$y$",
                worst_excess=7.0,
                worst_ratio=1.5,
            )
            for rival in rivals
            for row in result.ratios
        ),
    )


def lines_of(axes: object, label: str) -> np.ndarray:
    (line,) = (one for one in axes.get_lines() if one.get_label() == label)  # type: ignore[attr-defined]
    return np.asarray(line.get_ydata())


def test_lines_lie_at_the_pooled_ratios_and_errors_stand_in_both_readings() -> None:
    figure = plot_comparison(made())
    messages, airtime, same, matched = figure.axes[4:]
    for at, name in enumerate(NAMES):
        value = 0.5 + 0.2 * at
        np.testing.assert_allclose(lines_of(messages, name), [value + 0.2, value + 0.5])
        np.testing.assert_allclose(lines_of(airtime, name), [1.2 * value] * 2)
        worst = np.array([value + 0.5, value + 0.9])
        np.testing.assert_allclose(lines_of(same, name), worst / 0.5, err_msg="worst threshold")
        np.testing.assert_allclose(lines_of(matched, name), worst)
    np.testing.assert_allclose(lines_of(messages, "Known future, degree 2"), [0.2, 0.2])
    assert messages.get_ylabel().startswith("sensor")
    assert [axes.get_title() for axes in (same, matched)] == [
        "p90, same threshold,\nwith losses",
        "p90, same rate,\nwith losses",
    ]


def test_the_free_receiver_has_a_row_of_panels_of_its_own() -> None:
    figure = plot_comparison(against("ctra", free="ctra"))
    messages, airtime, same, matched = figure.axes[4:8]
    np.testing.assert_allclose(lines_of(messages, "cv"), [2.0 * 0.7, 2.0 * 1.0])
    np.testing.assert_allclose(lines_of(airtime, "cv"), [4.0 * 0.7, 4.0 * 1.0])
    np.testing.assert_allclose(lines_of(same, "cv"), [1.0 / 0.8, 1.4 / 0.8])
    np.testing.assert_allclose(lines_of(matched, "cv"), [1.0 / 0.9, 1.4 / 0.9])
    assert messages.get_ylabel() == "recorded\nratio to the free receiver"
    assert len(figure.axes) == 16
    other = plot_comparison(against("gp+cv order/on-failure", "ctra", free="ctra"))
    assert [axes.get_ylabel() for axes in other.axes[:12:4]] == [
        "recorded\nratio to the baseline",
        "recorded\nratio to the free receiver",
        "recorded\nratio to gp+cv order/on-failure",
    ]


def test_intervals_are_drawn_from_end_to_end() -> None:
    messages = plot_comparison(made()).axes[0]
    first = messages.collections[0].get_segments()
    assert [[point[1] for point in segment] for segment in first] == [
        pytest.approx([0.6, 0.8]),
        pytest.approx([0.9, 1.1]),
    ]
    bare = plot_comparison(made(limits=False)).axes[0].collections
    assert all(np.size(segment) == 0 for drawn in bare for segment in drawn.get_segments())


def test_a_reference_far_above_is_named_and_not_drawn() -> None:
    figure = plot_comparison(made())
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [*NAMES, "Baseline (CV)", "Known future, degree 1", "Known future, degree 2"]
    assert [text.get_text() for text in figure.axes[0].texts] == ["ETSI CAM rules: 2.5 and more"]
    low = replace(
        made(),
        references=REFERENCE_RATIOS.table(row.replaced(message_ratio=0.9) for row in made().references),
    )
    names = [text.get_text() for text in plot_comparison(low).legends[0].get_texts()]
    assert names[-1] == "ETSI CAM rules"


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {"names": ("only",)},
        {"names": tuple(f"bank-{at}+cv order/on-failure" for at in range(14))},
        {"thresholds": (0.3,), "ratios": (0.4,)},
        {"ratios": ()},
        {"protocols": ("auto",)},
        {"limits": False, "references": False},
        {"names": ("路$x$", "a" * 200)},
        {"protocols": ()},
    ],
    ids=str,
)
def test_figure_and_tables_are_made_for(options: dict[str, tuple[str, ...]], tmp_path: Path) -> None:
    result = made(**options)
    with style():
        plot_comparison(result).draw_without_rendering()
    paths = write_comparison_report(result, tmp_path)
    assert [path.name for path in paths] == [
        "table.md",
        "report.html",
        "comparison.png",
        "comparison.svg",
        "comparison.pdf",
    ]
    Console(width=100, file=io.StringIO()).print(comparison_console(result))


def test_ratios_that_do_not_exist_leave_holes() -> None:
    result = made()
    nan = float("nan")
    rows = TRACKING_RATIOS.table(
        row.replaced(p90_ratio=nan, p99_ratio=nan, p90_low=None) for row in result.tracking
    )
    holed = replace(result, tracking=rows)
    with style():
        plot_comparison(holed).draw_without_rendering()
    assert "| cv | 40 | - | - |" in comparison_markdown(holed)


def test_tables_are_markdown_with_as_many_cells_in_every_row_and_one_reading_each() -> None:
    text = comparison_markdown(against("ctra", free="ctra"))
    parts = text.split("### ")[1:]
    assert [part.splitlines()[0] for part in parts] == ["recorded", "sensor"]
    for part in parts:
        tables = [
            [line for line in one.splitlines() if line.startswith("|")] for one in part.split("\n**")[1:]
        ]
        assert [len(rows) - 2 for rows in tables] == [3, 3, 6, 6]
        for rows in tables:
            assert len({len(re.split(r"(?<!\\)\|", row)) for row in rows}) == 1
        baseline, free, same, matched = tables
        assert baseline[3].startswith(
            "| ctra | 0.90 [0.80, 1.00] | 1.20 [1.10, 1.30] | +0.20 [-0.10, +0.10]; +0.20"
        )
        assert baseline[3].endswith(
            "| 1.12 / 1.12 | 0.84 [0.74, 0.94] | 0.84 [0.74, 0.94] | 2 of 6 | t/2\\|$x$, 1.25 at 20 cm |"
        )
        assert free[2] == (
            "| cv | 1.40 [1.33, 1.47] | 2.00 [1.90, 2.10] | 2.10 / 3.00 | 2.80 | 4.00 "
            "| 4 of 6 | t/1\\|$y$, 1.50 at 20 cm |"
        )
        assert same[2] == (
            "| cv | 0 | 0.90 / 0.90 | 1.20 / 1.20 | 1.50 / 1.50 | 0.70 / 1.00 | 0.80 / 0.80 | 0.50 / 0.50 |"
        )
        assert matched[3] == "| cv | 40 | 1.56 | 1.40 [1.30, 1.50] | 1.56 | 0.70 |"
    assert "`clairvoyant-2` 0.20 / 0.20; `cam` 2.50 / 2.50" in text
    assert "hills\\|and dales, 2 trips, 600 s" in text
    assert "bad\\|one/1: its longest part" in text


def test_a_third_candidate_compared_against_has_a_table_and_a_row_of_panels_of_its_own() -> None:
    result = against("ctra")
    assert comparison_markdown(result).count("Same threshold, without loss: over ctra") == 2
    messages, octets, airtime, over = plot_comparison(result).axes[4:8]
    for axes, times in ((messages, 2.0), (octets, 3.0), (airtime, 4.0)):
        np.testing.assert_allclose(lines_of(axes, "cv"), [times * 0.7, times * 1.0])
    np.testing.assert_allclose(lines_of(over, "cv"), [200.0 / 3.0] * 2)
    assert messages.get_ylabel() == "recorded\nratio to ctra"


def test_the_caption_tells_of_the_row_over_a_third_candidate_where_there_is_one() -> None:
    told = "The row over ctra: messages, bytes, airtime, and the share of trips beyond either bound."
    drawing = Drawing("comparison", b"", b"<svg/>", b"", 1.0, 1.0)
    for result, is_told in ((against("ctra"), True), (against("ctra", free="ctra"), False), (made(), False)):
        page = comparison_page(result, drawing)
        assert (told in page) == is_told
        assert "row against the harder of both equal-rate baselines." in page


def shown(result: ComparisonResult) -> str:
    file = io.StringIO()
    Console(width=100, file=file).print(comparison_console(result))
    return file.getvalue()


def test_the_terminal_shows_one_reading_a_table() -> None:
    text = shown(against("ctra", free="ctra"))
    for title in (
        "Same threshold, recorded, without loss (20 / 50 cm)",
        "Same threshold, recorded, 40 % lost",
        "Same total rate as the candidate, sensor, 40 % lost",
    ):
        assert title in text
    rows = [
        " ".join(line.replace("│", " ").split())
        for line in text.partition("sensor, without")[0].splitlines()
        if line.startswith("│ cv")
    ]
    assert rows == [
        "cv 0.70 / 1.00 1.40 / 2.00 0.60 / 0.60 2.80 / 4.00 2 of 6",
        "cv 0.90 / 0.90 1.20 / 1.20 1.50 / 1.50 1.10 / 1.40 0.80 / 0.80",
        "cv 0.50 / 0.50",
        "cv 1.40 0.70 1.56 1.56",
    ]


def test_what_was_found_and_what_not_stands_first_and_names_the_data() -> None:
    result = against("ctra", free="ctra")
    titles = [title for title, _ in comparison_findings(result)]
    assert titles == [
        "Found, recorded",
        "Found, sensor",
        "Not found, recorded",
        "Not found, sensor",
        "Data",
        "Words",
    ]
    found, _, missed, _, data, words = (text for _, text in comparison_findings(result))
    assert (
        "cv and gp+cv order/on-failure sent more messages than the free receiver (1.40 to 2.80 times" in found
    )
    assert "with 40 % of the messages lost" in found
    assert "erred more than the free receiver (1.22 to 2.00 times as much)" in found
    assert "cv in all 2 at the same threshold (most at 50 cm, 40 % lost: 1.40 against 0.80 m" in missed
    assert "for 0.75 times the messages) and in all 2 at the same rate" in missed
    assert data.startswith("3 trips, 15.0 min, read from csv; protocol recorded")
    assert "free receiver: plain messages" in words
    page = comparison_page(result, drawn_once(result))
    assert page.index("Not found, sensor") < page.index("<figure>") < page.index("<table>")


def with_ends(result: ComparisonResult, free: str) -> ComparisonResult:
    """The same with intervals of the error over the free receiver's, which hold 1 without loss alone."""

    def ended(row: Row) -> Row:
        low = 0.9 if row.packet_error_ratio == 0.0 or row.candidate == free else 1.05
        return row.replaced(p90_over_free_low=low, p90_over_free_high=1.1)

    return replace(result, tracking=TRACKING_RATIOS.table(map(ended, result.tracking)))


def test_intervals_are_counted_of_the_cases_told_and_of_nobody_beside_itself() -> None:
    missed = dict(comparison_findings(with_ends(against("ctra", free="ctra"), "ctra")))["Not found, recorded"]
    assert (
        "The interval over the trips of the error over the free receiver's at the same rate holds 1 in none "
        "of 4. The interval over the trips of messages over the free receiver's" in missed
    )
    plain = dict(comparison_findings(made()))["Not found, recorded"]
    assert "the error over the better baseline's at the same rate holds 1 in 1 of 6." in plain


def test_messages_have_their_interval_where_errors_have_none() -> None:
    result = against("ctra", free="ctra")
    missed = dict(comparison_findings(result))["Not found, recorded"]
    assert "has no interval that tells this from chance. The interval over the trips of messages" in missed
    unknown = TRACKING_RATIOS.table(
        row.replaced(free_p90_m=None, free_matched_p90_m=None) for row in result.tracking
    )
    missed = dict(comparison_findings(replace(result, tracking=unknown)))["Not found, recorded"]
    assert missed.startswith("Nobody's errors were measured beside the free receiver's. The interval over")


def test_the_free_receiver_alone_is_held_against_the_baseline() -> None:
    alone = made(names=("ctra",), protocols=("recorded",))
    texts = dict(comparison_findings(replace(alone, settings={**alone.settings, "free": "ctra"})))
    assert "ctra sent" in texts["Found"]
    assert (
        "the error was larger than the baseline's: ctra in all 2 at the same threshold" in texts["Not found"]
    )
    assert "the error over the better baseline's at the same rate holds 1 in" in texts["Not found"]
    assert "messages over the baseline's at the same threshold holds 1 in" in texts["Not found"]


def test_the_rate_of_updates_alone_is_not_told_as_the_same_rate() -> None:
    result = with_ends(against("ctra", free="ctra"), "ctra")
    updates = dict(comparison_findings(replace(result, settings={**result.settings, "rate_basis": "update"})))
    assert "At the rate of its updates alone, with 40 %" in updates["Found, recorded"]
    missed = updates["Not found, recorded"]
    assert "m, for 0.75 times the messages) and in all 2 at the rate of its updates alone" in missed
    assert "the error over the free receiver's at the rate of its updates alone holds 1 in" in missed
    assert "at the same rate" not in " ".join(updates.values()).lower()


def drawn_once(result: ComparisonResult) -> Drawing:
    with style():
        return drawn("comparison", plot_comparison(result))


def test_without_the_free_receiver_the_baseline_is_the_measure() -> None:
    texts = dict(comparison_findings(made(protocols=("recorded",))))
    assert "free receiver" not in " ".join(texts.values())
    assert "the error was larger than the baseline's: " in texts["Not found"]
    assert "free" not in shown(made())


def test_errors_that_were_not_measured_are_not_spoken_of() -> None:
    texts = dict(comparison_findings(made(protocols=("recorded",), ratios=())))
    assert "At the same rate" not in texts["Found"]
    assert texts["Not found"].startswith("Errors were not measured")
    assert comparison_findings(made(protocols=())) == []


def with_bank(result: ComparisonResult, name: str, bank: Bank) -> ComparisonResult:
    """The same, one candidate with the sub-models of this bank."""
    members = tuple(repr(member) for member in bank.members)
    every = (replace(one, sub_models=members) if one.name == name else one for one in result.candidates)
    return replace(result, candidates=tuple(every))


def test_the_baseline_has_no_second_table_nor_has_a_candidate_alone() -> None:
    result = against("cv")
    assert result.rival == "cv"
    assert with_bank(result, "cv", BASELINE_BANK).rival is None
    assert replace(result, candidates=result.candidates[:1]).rival is None
    assert made().rival is None


def test_who_sends_as_many_messages_as_the_baseline_need_not_be_it() -> None:
    result = with_bank(against("ctra"), "cv", BASELINE_BANK)
    tie = replace(
        result,
        ratios=RATIOS.table(
            row.replaced(message_ratio=1.0) if row.candidate == "ctra" else row for row in result.ratios
        ),
    )
    assert tie.rival == "ctra"
    assert [tie.is_baseline(name) for name in ("cv", "ctra", "nobody")] == [True, False, False]
    found = comparison_findings(tie)[0][1]
    assert "ctra sent as many messages as the baseline (1.00 times as many)" in found
    assert "cv sent" not in found


@pytest.mark.slow
def test_files_are_the_same_twice(tmp_path: Path) -> None:
    contents = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        contents.append([path.read_bytes() for path in write_comparison_report(made(), tmp_path / name)])
    assert contents[0] == contents[1]

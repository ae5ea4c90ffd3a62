"""The report of a reproduction: it reads alone, names the code's own parts, and says what the tables say."""

import importlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from modelcast.report.figures.diagram import Box, code_name
from modelcast.report.figures.files import Drawing
from modelcast.report.figures.readings import plot_readings
from modelcast.report.figures.system import ALGORITHM_BOXES, SYSTEM_BOXES
from modelcast.report.figures.traffic import TRAFFIC_FIGURES
from modelcast.report.paper import draw_paper, paper_markdown, paper_page
from modelcast.report.paper_texts import TITLES
from modelcast.station.banks import PAPER_BANK
from modelcast.study.paper.choices import CHOICES
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import reproduce_paper
from modelcast.world.drive import generate_drive

BOXES = [*SYSTEM_BOXES.values(), *ALGORITHM_BOXES.values()]


@pytest.fixture(scope="module")
def found() -> PaperResult:
    trip = replace(generate_drive(1, 90.0).truth, trip_id="a<b>|c/1")
    return reproduce_paper([trip], PaperPlan((0.3, 0.5), (0.0, 0.4), seeds=2, resamples=20))


@pytest.fixture(scope="module")
def drawings(found: PaperResult) -> list[Drawing]:
    return draw_paper(found)


@pytest.mark.slow
def test_the_figures_are_those_of_the_titles(drawings: list[Drawing]) -> None:
    assert [drawing.name for drawing in drawings] == list(TITLES)


@pytest.mark.slow
def test_the_page_holds_everything_and_points_nowhere(
    found: PaperResult, drawings: list[Drawing], read_page: Callable[[str], Any]
) -> None:
    page = read_page(paper_page(found, drawings))
    assert not page.open
    assert all(address.startswith("data:image/svg+xml,") for address in page.addresses)
    assert len(page.addresses) == len(TITLES)
    assert page.data == []
    for row in found.claims:
        assert row.name in page.text
        assert row.sentence in page.text
        assert row.figure in page.text
    for choice in CHOICES:
        assert choice.question in page.text
    for one in found.readings:
        assert one.labelled.label in page.text


@pytest.mark.slow
def test_foreign_names_are_text_in_page_and_table(found: PaperResult, drawings: list[Drawing]) -> None:
    left_out = replace(found, failures={"<script>|x": "too <short>"})
    assert "<script>|x" not in paper_page(left_out, drawings)
    assert "&lt;script&gt;|x" in paper_page(left_out, drawings)


@pytest.mark.slow
def test_the_markdown_has_as_many_cells_in_every_row(found: PaperResult) -> None:
    tables = [line for line in paper_markdown(found).splitlines() if line.startswith("|")]
    widths = [line.replace("\\|", "").count("|") for line in tables]
    claims = 2 + len(found.claims)
    assert len(set(widths[:claims])) == 1
    assert len(set(widths[claims:])) == 1
    assert len(tables) == claims + 2 + len(found.readings)


@pytest.mark.slow
def test_every_reading_has_its_row_in_the_figure(found: PaperResult) -> None:
    messages, _ = plot_readings(found).axes
    assert [label.get_text() for label in messages.get_yticklabels()] == [
        one.labelled.label for one in found.readings
    ]
    drawn = [line.get_xdata()[0] for line in messages.get_lines() if line.get_label() == "one threshold"]
    assert drawn == [row.message_ratio for one in found.readings for row in one.rows.messages]


@pytest.mark.slow
def test_readings_stand_beside_the_free_receiver_too(found: PaperResult) -> None:
    panels = plot_readings(found).axes
    hollow = [
        [line.get_xdata()[0] for line in axes.get_lines() if line.get_markerfacecolor() == "none"]
        for axes in panels
    ]
    beside = [one.rows.beside_free_pooled(one.labelled.reading) for one in found.readings]
    assert hollow == [
        [row.message_ratio for one in found.readings for row in one.rows.beside_free],
        [row.p90_ratio for rows in beside for row in rows],
    ]


@pytest.mark.parametrize("box", [box for box in BOXES if box.code], ids=lambda box: box.title)
def test_a_name_in_a_diagram_leads_to_the_part_it_names(box: Box) -> None:
    for thing in box.code:
        name = code_name(thing).split(".")
        qualified = str(getattr(thing, "__qualname__", "")).split(".")
        found: object = importlib.import_module(".".join(["modelcast", *name[: -len(qualified)]]))
        for part in qualified:
            found = getattr(found, part)
        assert found is thing


def test_the_diagrams_show_the_papers_sub_models_and_every_rule_left_open() -> None:
    titles = {box.title for box in BOXES}
    assert {member.name for member in PAPER_BANK.members} <= titles
    lines = [line for box in ALGORITHM_BOXES.values() for line in box.lines]
    for field in ("start", "identify"):
        (choice,) = (one for one in CHOICES if one.field == field)
        assert any(all(option.label in line for option in choice.options) for line in lines)


def test_no_text_of_a_diagram_leaves_its_box() -> None:
    """Estimated from the number of characters: 0.6 of the size in a box as wide as the figure is drawn."""
    points_per_unit = 7.16 * 72.0 / 145.0
    for box in BOXES:
        if box.is_question:
            continue
        for text, size in ((box.title, 7.0), *((line, 5.8) for line in box.lines)):
            assert 0.56 * size * len(text) <= box.width * points_per_unit, text


@pytest.mark.slow
def test_claims_point_at_figures_that_there_are(found: PaperResult) -> None:
    for row in found.claims:
        assert row.shown_in in {*TITLES, *TRAFFIC_FIGURES}, row.name


@pytest.mark.slow
def test_the_page_says_what_each_combination_took(
    found: PaperResult, read_page: Callable[[str], Any]
) -> None:
    text = read_page(paper_page(found, ())).text
    for one in found.readings[-4:]:
        taken = [
            f"{choice.title}: {option.label}"
            for choice in CHOICES
            for option in choice.options[1:]
            if option.value == getattr(one.labelled.reading, choice.field)
        ]
        assert one.labelled.label + ("; ".join(taken) or "none") in text

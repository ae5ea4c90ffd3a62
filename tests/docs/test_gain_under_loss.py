"""What front pages say of the gain under loss, and of the part that is repetition, is what the tables say."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LOSS = (ROOT / "docs" / "loss.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
SHORT = (ROOT / "docs" / "results-in-short.md").read_text(encoding="utf-8")
GAINS = (ROOT / "docs" / "explanation" / "gains.md").read_text(encoding="utf-8")


def row_of(text: str, first: str) -> list[str]:
    """The cells of a table's row, by its first cell, as plain text."""
    (row,) = re.findall(rf"(?m)^\| {re.escape(first)} \|(.*)\|$", text)
    return [cell.strip(" *").replace("/", " and ") for cell in row.split("|")]


def without_breaks(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def test_what_repetition_is_worth_is_what_the_page_on_loss_measured() -> None:
    _, free_sent, free_repeats, _, sent, repeats, *_ = row_of(LOSS, "mean")
    assert row_of(GAINS, "free receiver") == [free_sent, free_repeats]
    assert row_of(GAINS, "the bank that shipped when this was measured") == [sent, repeats]
    baseline = row_of(LOSS, "cv, expected")[0]
    assert row_of(GAINS, "constant velocity (without Tampa)")[1] == baseline
    gained = [f"{100 - 100 * float(one):.0f} %" for one in baseline.split(" and ")]
    assert f"{gained[0]} in p90 and {gained[1]} in p99" in GAINS
    for text in (README, SHORT):
        assert f"was at {sent} so, " in without_breaks(text)
        assert f"at {repeats} with repetition" in without_breaks(text)


@pytest.mark.parametrize(("page", "text"), [("short", SHORT), ("gains", GAINS)])
def test_the_gain_under_loss_is_the_one_of_the_judged_table(page: str, text: str) -> None:
    two = r"(0\.\d\d) and (0\.\d\d)"
    said = rf"are {two} of constant velocity's, with as many messages; `free`'s are {two}"
    p90, p99, free_p90, free_p99 = re.findall(said, without_breaks(README))[0]
    if page == "short":
        assert (
            f"{p90} of constant velocity's at an equal rate, p99 {p99}; `free` {free_p90} and {free_p99}"
            in text
        )
    else:
        assert f"is {p90} of constant velocity's for what ships, and {free_p90} for the free receiver" in text


@pytest.mark.parametrize("page", ["README.md", "docs/results-in-short.md", "docs/explanation/gains.md"])
def test_who_repeats_and_who_does_not_stands_beside_the_gain(page: str) -> None:
    text = without_breaks((ROOT / page).read_text(encoding="utf-8"))
    assert re.search(r"(velocity|baseline) does not( repeat)?[.;]", text)
    assert re.search(r"With `--believe sent` nobody (does|repeats)", text)

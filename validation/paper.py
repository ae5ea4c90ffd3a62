"""Run the paper's evaluation on the four sources it is shown on, and write what it finds into the documents.

Made by it: ``docs/paper.md``, and the blocks between the marks ``<!-- paper -->`` and ``<!-- /paper -->`` of
``README.md`` and ``docs/results.md``. ``--check`` writes nothing and fails where a document says anything
else; with ``--only`` it looks at the named sources' own parts of ``docs/paper.md``. Needs ``MODELCAST_DATA``.
"""

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from modelcast.cli.shared_work import workers
from modelcast.io.trips import read_trips
from modelcast.report.literal import markdown
from modelcast.report.paper import paper_markdown
from modelcast.report.paper_texts import INTRODUCTION, READING_NOTE, WHY_THEY_DIFFER
from modelcast.study.paper.choices import CHOICES, PLAIN
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import figure_of
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import reproduce_paper

SOURCES = {
    "Safety Pilot": "spmd/bsm_p1_dev.csv",
    "OpenACC": "openacc_zalazone",
    "Boreas": "roads/boreas_2021-08-05.parquet",
    "Tampa": "roads/tampa_dev.parquet",
}
MARK, END = "<!-- paper: made by `make paper` -->", "<!-- /paper -->"
_HEADS = (
    "messages: plain",
    "fewest",
    "most",
    "p90: rate of updates",
    "rate of all messages",
    "best",
    "worst",
)
_SHORT = (
    "Geometric means over the four thresholds. Messages over the baseline's at the same threshold; 90th "
    "percentile of the error at a packet error ratio of {ratio:g} % over that of a periodic baseline, which "
    "sends as often as the hybrid sends updates (the paper's basis), or as often as it sends anything. "
    "Protocol of the plain reading: {protocols}."
)
PLACES = ("README.md", "docs/results.md")


def found_on(data: Path, name: str, jobs: int) -> PaperResult:
    """The reproduction on one source."""
    trips = tuple(read_trips(data / SOURCES[name]))
    with workers(jobs) as pool:
        return reproduce_paper(trips, each=pool.each)


def short_table(results: dict[str, PaperResult]) -> str:
    """One row a source: messages and tracking under the plain, the best and the worst reading."""
    lines = [
        f"| trips | {' | '.join(_HEADS)} |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, result in results.items():
        by_label = {one.labelled.label: one for one in result.readings}
        plain = by_label["plain"]
        total = figure_of(plain.rows, replace(PLAIN, rate_basis="total"), "tracking")
        hours = sum(trip.duration_s for trip in result.evaluation.trips) / 3600.0
        cells = [
            f"{name}, {len(result.evaluation.trips)}, {hours:.1f} h",
            *(f"{by_label[label].messages:.2f}" for label in ("plain", "fewest messages", "most messages")),
            f"{plain.tracking:.2f}",
            f"{total:.2f}",
            *(f"{by_label[label].tracking:.2f}" for label in ("best tracking", "worst tracking")),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def choices_table() -> str:
    """Every choice with its options."""
    lines = ["| choice | question | says | options |", "|---|---|---|---|"]
    for choice in CHOICES:
        options = "; ".join(f"**{option.label}**: {option.text}" for option in choice.options)
        stated = "the paper: the first" if choice.stated else "open"
        lines.append(f"| {choice.title} | {markdown(choice.question)} | {stated} | {options} |")
    return "\n".join(lines)


def claims_table(results: dict[str, PaperResult]) -> str:
    """One row a claim: the sentence, the measure, and the plain reading's verdict on every source."""
    first = next(iter(results.values()))
    lines = [
        f"| claim | place | the paper, in our words | holds where | {' | '.join(results)} |",
        "|---|---|---|---|" + "---|" * len(results),
    ]
    for at, claim in enumerate(first.claims):
        verdicts = [result.claims[at].verdicts["plain"] for result in results.values()]
        cells = [claim.name, claim.place, markdown(claim.sentence), markdown(claim.measure), *verdicts]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def section(name: str, result: PaperResult) -> str:
    """What one source found, in full."""
    return f"## {name}\n\n`modelcast reproduce paper {SOURCES[name]}`. {paper_markdown(result)}"


def document(results: dict[str, PaperResult]) -> str:
    """The whole of ``docs/paper.md``."""
    kinds = np.unique([trip.protocol for result in results.values() for trip in result.evaluation.trips])
    return "\n".join(
        [
            "# The paper, claim by claim",
            "",
            "Made by `make paper` from four sources; nothing here is written by hand.",
            "",
            *(text + "\n" for text in INTRODUCTION),
            "```sh",
            "modelcast reproduce paper TRIPS... --out DIR             # report.html, claims, figures",
            "modelcast reproduce paper TRIPS... --pick                # the trip richest in manoeuvres alone",
            "modelcast reproduce paper TRIPS... --traffic             # collisions and load in traffic too",
            "```",
            "",
            "## In short",
            "",
            _SHORT.format(ratio=100 * PaperPlan().headline_ratio, protocols=", ".join(kinds)),
            "",
            short_table(results),
            "",
            WHY_THEY_DIFFER,
            "",
            "## Claims",
            "",
            "Verdicts of the plain reading.",
            "",
            claims_table(results),
            "",
            READING_NOTE,
            "",
            "## What is left open",
            "",
            choices_table(),
            "",
            *(section(name, result) for name, result in results.items()),
        ]
    )


def with_block(text: str, block: str) -> str:
    """A document with what stands between its marks replaced."""
    before, found, rest = text.partition(MARK)
    if not found or END not in rest:
        raise SystemExit(f"no block between {MARK} and {END}")
    return f"{before}{MARK}\n\n{block}\n\n{END}{rest.partition(END)[2]}"


def main() -> int:
    """Run what is asked for; 1 where a document says anything else."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=list(SOURCES), metavar="SOURCE")
    parser.add_argument("--jobs", type=int, default=0)
    asked = parser.parse_args()
    if asked.only and not asked.check:
        parser.error("--only goes with --check: the documents are of all sources")
    data = Path(os.environ["MODELCAST_DATA"])
    root = Path(__file__).resolve().parent.parent
    results = {name: found_on(data, name, asked.jobs) for name in asked.only or SOURCES}
    paper = root / "docs/paper.md"
    if asked.check:
        text = paper.read_text(encoding="utf-8")
        wrong = [name for name, result in results.items() if section(name, result).strip() not in text]
        if not asked.only:
            wrong += [] if text == document(results) else ["docs/paper.md"]
            for place in PLACES:
                written = (root / place).read_text(encoding="utf-8")
                wrong += [] if written == with_block(written, short_table(results)) else [place]
        print(f"differs: {', '.join(wrong)}" if wrong else "the documents say what was found")
        return int(bool(wrong))
    paper.write_text(document(results), encoding="utf-8", newline="\n")
    for place in PLACES:
        path = root / place
        path.write_text(
            with_block(path.read_text(encoding="utf-8"), short_table(results)), encoding="utf-8", newline="\n"
        )
    print(f"wrote {paper.name} and the blocks of {', '.join(PLACES)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Run the paper's evaluation on the four sources it is shown on, and write what it finds into the documents.

Made by it: ``docs/paper.md``, and the blocks between the marks ``<!-- paper -->`` and ``<!-- /paper -->`` of
``README.md`` and ``docs/results.md``. ``--check`` writes nothing and fails where a document says anything
else; with ``--only`` it looks at the named sources' own parts of ``docs/paper.md``. Needs ``MODELCAST_DATA``.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from modelcast.cli.shared_work import workers
from modelcast.core.cells import markdown
from modelcast.io.traffic import read_traffic
from modelcast.io.trips import read_trips
from modelcast.report.paper import paper_markdown
from modelcast.report.paper_texts import INTRODUCTION, READING_NOTE, WHY_THEY_DIFFER
from modelcast.study.paper.choices import CHOICES, PLAIN
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import figure_of
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import reproduce_paper
from modelcast.study.paper.traffic import traffic_claims
from modelcast.study.table import Row

SOURCES = {
    "Safety Pilot": "spmd/bsm_p1_dev.csv",
    "OpenACC": "openacc_zalazone",
    "Boreas": "roads/boreas_2021-08-05.parquet",
    "Tampa": "roads/tampa_dev.parquet",
}
MARK, END = "<!-- paper: made by `make paper` -->", "<!-- /paper -->"
_HEADS = (
    "messages, plain reading",
    "fewest",
    "most",
    "p90 over a baseline of as many messages as MBC has updates",
    "as MBC has messages",
    "best p90",
    "worst p90",
)
_SHORT = (
    "Geometric means over the four thresholds. Messages over the baseline's at the same threshold; 90th "
    "percentile of the error at a packet error ratio of {ratio:g} % over that of a periodic baseline, which "
    "sends as often as the hybrid sends updates (the paper's basis), or as often as it sends anything. "
    "Fewest, most, best and worst are over the readings of what the paper leaves open, at the rate of "
    "updates. Protocol of the plain reading: {protocols}."
)
_TRAFFIC_HEADS = ("claim", "the paper, in our words", "holds where", "verdict", "measured", "worst")
_TRAFFIC = (
    "`modelcast reproduce paper TRIPS... --traffic`, or the command of [traffic-table.md](traffic-table.md), "
    "which has every figure: the paper's bank with identifications against the error-driven baseline, "
    "{seeds} seeds. Those of `sidelink` are from before 2026-11-29, when fading was drawn twice there. What "
    "its bank does beside SAE J2945/1's rate and power control is in [network.md](network.md)."
)
_STATED = {choice.title for choice in CHOICES if choice.stated}
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
        plain = result.readings[0]
        total = figure_of(plain.rows, replace(PLAIN, rate_basis="total"), "tracking")
        hours = sum(trip.duration_s for trip in result.evaluation.trips) / 3600.0
        open_ones = [one for one in result.readings if one.labelled.choice not in _STATED]
        messages = [one.messages for one in open_ones]
        tracking = [one.tracking for one in open_ones]
        figures = (plain.messages, min(messages), max(messages))
        figures += (plain.tracking, total, min(tracking), max(tracking))
        cells = [
            f"{name}, {len(result.evaluation.trips)}, {hours:.1f} h",
            *(f"{value:.2f}" for value in figures),
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
        if claim.command.endswith("--traffic"):
            continue
        verdicts = [result.claims[at].verdicts["plain"] for result in results.values()]
        cells = [claim.name, claim.place, markdown(claim.sentence), markdown(claim.measure), *verdicts]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def section(name: str, result: PaperResult) -> str:
    """What one source found, in full."""
    judged = tuple(claim for claim in result.claims if not claim.command.endswith("--traffic"))
    told = paper_markdown(replace(result, claims=judged))
    return f"## {name}\n\n`modelcast reproduce paper {SOURCES[name]}`. {told}"


def traffic_section(rows: Sequence[Row]) -> list[str]:
    """The claims about traffic, judged once for all sources; nothing where no runs were given."""
    if not rows:
        return []
    lines = [f"| {' | '.join(_TRAFFIC_HEADS)} |", "|" + "---|" * len(_TRAFFIC_HEADS)]
    for claim in traffic_claims(rows):
        texts = (claim.name, claim.sentence, claim.measure, claim.verdicts["plain"])
        cells = [markdown(text) for text in (*texts, claim.figure, claim.worst)]
        lines.append(f"| {' | '.join(cells)} |")
    told = _TRAFFIC.format(seeds=max(row.seeds for row in rows))
    return ["## In traffic", "", told, "", *lines, ""]


def document(results: dict[str, PaperResult], traffic: Sequence[str]) -> str:
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
            *traffic,
            "## What is left open",
            "",
            choices_table(),
            "",
            *(section(name, result) for name, result in results.items()),
        ]
    )


def old_traffic(text: str) -> list[str]:
    """What a document says of traffic: kept where no new runs are given."""
    _, found, rest = text.partition("## In traffic\n")
    return [f"{found}{rest.partition(chr(10) + '## ')[0]}".rstrip(), ""] if found else []


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
    parser.add_argument("--traffic", type=Path, help="traffic.parquet of a run with --traffic")
    asked = parser.parse_args()
    if asked.only and not asked.check:
        parser.error("--only goes with --check: the documents are of all sources")
    data = Path(os.environ["MODELCAST_DATA"])
    root = Path(__file__).resolve().parent.parent
    rows = () if asked.traffic is None else read_traffic(asked.traffic)
    results = {name: found_on(data, name, asked.jobs) for name in asked.only or SOURCES}
    paper = root / "docs/paper.md"
    written = paper.read_text(encoding="utf-8") if paper.exists() else ""
    traffic = traffic_section(rows) if rows else old_traffic(written)
    if asked.check:
        text = paper.read_text(encoding="utf-8")
        wrong = [name for name, result in results.items() if section(name, result).strip() not in text]
        if not asked.only:
            wrong += [] if text == document(results, traffic) else ["docs/paper.md"]
            for place in PLACES:
                written = (root / place).read_text(encoding="utf-8")
                wrong += [] if written == with_block(written, short_table(results)) else [place]
        print(f"differs: {', '.join(wrong)}" if wrong else "the documents say what was found")
        return int(bool(wrong))
    paper.write_text(document(results, traffic), encoding="utf-8", newline="\n")
    for place in PLACES:
        path = root / place
        path.write_text(
            with_block(path.read_text(encoding="utf-8"), short_table(results)), encoding="utf-8", newline="\n"
        )
    print(f"wrote {paper.name} and the blocks of {', '.join(PLACES)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""What a reproduction of the paper leaves on disk, for programs to read.

``summary.json`` (`paper_document`)
    ``schema`` (1), ``modelcast`` (version), ``plan``, ``choices``, ``claims``, ``readings`` (rows of
    `modelcast.study.compare.result` that pool all trips, those beside the free receiver among them),
    ``complement``, ``picked``, ``manoeuvres`` (of every trip), ``evaluation`` (as the ``summary.json`` of
    ``modelcast evaluate``, of the plain reading; of tracking, rows that pool all trips), ``traffic`` (rows of
    `modelcast.study.network.pairs`; empty without ``--traffic``), ``failures``, ``skipped``. A number that
    does not exist is null.
``claims.csv``
    One row for each claim and reading: claim, place, reading, verdict.

The same result gives the same bytes.
"""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from modelcast.core.version import package_version
from modelcast.io.documents import plain_value, row_document
from modelcast.io.result_files import write_result
from modelcast.io.results import summary_document
from modelcast.study.paper.choices import CHOICES
from modelcast.study.paper.readings import RivalKey
from modelcast.study.paper.result import PaperResult, ReadingResult
from modelcast.study.result import POOLED, TRACKING, EvaluationResult
from modelcast.study.table import Row
from modelcast.trips.manoeuvres.base import ManoeuvreCounts

__all__ = ["PAPER_SCHEMA", "paper_document", "write_paper"]

PAPER_SCHEMA = 1
"""Version of the layout of a reproduction's ``summary.json``."""


def paper_document(result: PaperResult) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        The reproduction.
    """
    shared = result.complement
    return {
        "schema": PAPER_SCHEMA,
        "modelcast": package_version(),
        "plan": plain_value(result.plan.as_plain()),
        "choices": [plain_value(asdict(choice)) for choice in CHOICES],
        "claims": [row_document(row) for row in result.claims],
        "readings": [_reading(one) for one in result.readings],
        "complement": {
            "members": list(shared.members),
            "threshold_m": shared.threshold_m,
            "only_s": list(shared.only_s),
            "both_s": shared.both_s,
            "neither_s": shared.neither_s,
        },
        "picked": result.picked,
        "manoeuvres": [_counted(one) for one in result.manoeuvres],
        "evaluation": summary_document(_without_trips(result.evaluation)),
        "traffic": [row.plain() for row in result.traffic],
        "failures": plain_value(result.failures),
        "skipped": plain_value(result.skipped),
    }


def _counted(counts: ManoeuvreCounts) -> dict[str, Any]:
    return {
        "trip": counts.trip_id,
        "duration_s": counts.duration_s,
        "distance_m": counts.distance_m,
        "counts": {kind.value: number for kind, number in counts.by_kind.items()},
    }


def _without_trips(result: EvaluationResult) -> EvaluationResult:
    """The evaluation without its tracking rows of single trips, of which there are too many to read."""
    return replace(result, tracking=TRACKING.table(row for row in result.tracking if row.trip == POOLED))


def _reading(one: ReadingResult) -> dict[str, Any]:
    rows = one.rows
    return {
        "label": one.labelled.label,
        "choice": one.labelled.choice,
        "option": one.labelled.option,
        "reading": plain_value(asdict(one.labelled.reading)),
        "messages": [row.plain() for row in rows.messages],
        "updates": [row.plain() for row in rows.updates],
        "gaussian_process_alone": [row.plain() for row in rows.alone],
        "tracking": _pooled_rows(rows.tracking),
        "beside_free": [row.plain() for row in rows.beside_free],
        "tracking_beside_free": _pooled_rows(rows.tracking_beside_free),
        "survivals": [row_document(one) for one in rows.complement.survivals],
    }


def _pooled_rows(by_rival: Mapping[RivalKey, Sequence[Row]]) -> list[dict[str, Any]]:
    return [
        {"schedule": schedule, **row.plain()}
        for (_, schedule), found in by_rival.items()
        for row in found
        if row.trip == POOLED
    ]


def write_paper(result: PaperResult, folder: str | Path) -> list[Path]:
    """Write ``summary.json`` and ``claims.csv``; return their paths.

    Parameters
    ----------
    result
        The reproduction.
    folder
        An existing folder.
    """
    written, claims = write_result(paper_document(result), {}, folder), Path(folder) / "claims.csv"
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("claim", "place", "reading", "verdict"))
    for row in result.claims:
        for reading, verdict in row.verdicts.items():
            writer.writerow((row.name, row.place, reading, verdict))
    claims.write_text(text.getvalue(), encoding="utf-8", newline="\n")
    return [*written, claims]

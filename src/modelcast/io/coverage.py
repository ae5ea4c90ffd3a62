"""``coverage.json``: what `modelcast.study.coverage` found, for programs to read.

Keys: ``schema`` (1), ``modelcast`` (version), ``protocol``, ``bank``, ``tested`` (trips by group),
``coverage`` and ``times`` (rows of `COVERAGE` and `TIMES`, under the same names), ``calibrations`` (by
group, then by sub-model, as `Calibration.from_plain` takes them), ``failures``, ``training_trips``
(tested trips that the sub-models were trained on).
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from modelcast.core.version import package_version
from modelcast.study.coverage import CoverageResult

__all__ = ["COVERAGE_SCHEMA", "coverage_document", "write_coverage"]

COVERAGE_SCHEMA = 1
"""Version of the layout; it rises when a key changes its meaning or goes away."""


def coverage_document(
    result: CoverageResult,
    *,
    protocol: str,
    bank: str,
    tested: Mapping[str, Sequence[str]],
    failures: Mapping[str, str],
    training_trips: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the content of ``coverage.json`` as plain values.

    Parameters
    ----------
    result
        What was found.
    protocol, bank
        As asked for.
    tested
        Identifiers of the trips of each group.
    failures
        What could not be read, and why.
    training_trips
        Identifiers of the tested trips that the sub-models themselves were trained on.
    """
    return {
        "schema": COVERAGE_SCHEMA,
        "modelcast": package_version(),
        "protocol": protocol,
        "bank": bank,
        "tested": {name: list(trips) for name, trips in tested.items()},
        "failures": dict(failures),
        "training_trips": list(training_trips),
        **result.as_plain(),
    }


def write_coverage(document: Mapping[str, Any], folder: str | Path) -> Path:
    """Write ``coverage.json`` and return its path; the same result gives the same bytes.

    Parameters
    ----------
    document
        What `coverage_document` returned.
    folder
        An existing folder.
    """
    path = Path(folder) / "coverage.json"
    text = json.dumps(document, indent=1, sort_keys=True, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8", newline="\n")
    return path

"""What a study of platoons leaves on disk, for programs to read.

``summary.json``
    ``schema`` (1), ``modelcast`` (version), ``options`` (what was asked for), ``leader``, ``law``,
    ``ranging``, ``platoons``, ``vehicles``, ``failures`` (files that could not be read, and why), ``rows``:
    the columns of `CRUISE`. A number that does not
    exist is null.
``runs.parquet``
    The rows again, a column a key.

The same runs give the same bytes.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modelcast.core.version import package_version
from modelcast.io.result_files import write_result
from modelcast.study.cruise.run import CruiseResult

__all__ = ["CRUISE_SCHEMA", "cruise_document", "write_cruise"]

CRUISE_SCHEMA = 1
"""Version of the layout; it rises when a key changes its meaning or goes away."""


def cruise_document(
    result: CruiseResult, *, options: Mapping[str, Any], failures: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        What was found.
    options
        What was asked for.
    failures
        What could not be read, and why.
    """
    return {
        "schema": CRUISE_SCHEMA,
        "modelcast": package_version(),
        "options": dict(options),
        "leader": result.leader,
        "law": result.law,
        "ranging": result.ranging,
        "platoons": result.platoons,
        "vehicles": result.vehicles,
        "failures": dict(failures or {}),
        "rows": result.rows.plain(),
    }


def write_cruise(
    result: CruiseResult,
    folder: str | Path,
    *,
    options: Mapping[str, Any],
    failures: Mapping[str, str] | None = None,
) -> tuple[Path, Path]:
    """Write ``summary.json`` and ``runs.parquet`` and return their paths.

    Parameters
    ----------
    result, options, failures
        As for `cruise_document`.
    folder
        An existing folder.
    """
    document = cruise_document(result, options=options, failures=failures)
    summary, runs = write_result(document, {"runs": result.rows}, folder)
    return summary, runs

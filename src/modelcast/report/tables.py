"""The rows and columns of a result as Polars data frames; no other module makes data frames.

The frames have the names of `modelcast.study.result`, and the same columns and types also where a
result has no rows.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import polars as pl

from modelcast.io.arrow import columns_table, plain_text, sample_tables
from modelcast.study.result import (
    EvaluationResult,
    HoldsEvaluation,
    RateRow,
    ReferenceRow,
    TrackingRow,
    TripRow,
    result_of,
)

__all__ = [
    "events_frame",
    "rates_frame",
    "references_frame",
    "samples_frame",
    "tracking_frame",
    "trips_frame",
]

_TEXT = {
    "id",
    "source",
    "protocol",
    "velocity_estimator",
    "trip",
    "policy",
    "bank",
    "rate_basis",
    "reference",
    "warnings",
}
_WHOLE = {
    "vehicles",
    "samples",
    "gaps",
    "rows",
    "updates",
    "identifications",
    "seeds",
    "excluded_samples",
    "skipped",
    "repaired",
    "messages",
    "least_messages",
    "undecided",
}
_FLAG = {"resampled", "conditioned"}


def rates_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, policy, bank and threshold of the rate runs."""
    return _frame(result_of(result).rates, RateRow)


def references_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, reference and threshold."""
    return _frame(result_of(result).references, ReferenceRow)


def tracking_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, policy, rate basis, threshold and packet error ratio."""
    return _frame(result_of(result).tracking, TrackingRow)


def trips_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a trip.

    ``skipped`` and ``repaired`` are total counts here, ``warnings`` the kinds alone, and ``grid_m`` is split
    into its two axes; the reasons and the smoother's figures are in ``summary.json``.
    """
    columns: dict[str, list[Any]] = {}
    for item in fields(TripRow):
        values: list[Any] = [getattr(row, item.name) for row in result.trips]
        if item.name in {"skipped", "repaired"}:
            columns[item.name] = [_count(value) for value in values]
        elif item.name == "warnings":
            columns[item.name] = [", ".join(value) for value in values]
        elif item.name == "grid_m":
            columns["grid_east_m"] = [value[0] for value in values]
            columns["grid_north_m"] = [value[1] for value in values]
        elif item.name != "conditioning":
            columns[item.name] = values
    return pl.DataFrame(columns, schema={name: _dtype(name) for name in columns})


def events_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a message of the rate runs."""
    return _from_arrow([columns_table(result.events)])


def samples_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a tracking-error sample kept, with null where the host held nothing."""
    return _from_arrow(sample_tables(result.samples))


def _frame(
    rows: Sequence[RateRow | ReferenceRow | TrackingRow],
    row_type: type[RateRow | ReferenceRow | TrackingRow],
) -> pl.DataFrame:
    names = [item.name for item in fields(row_type)]
    columns: dict[str, list[Any]] = {name: [getattr(row, name) for row in rows] for name in names}
    return pl.DataFrame(columns, schema={name: _dtype(name) for name in names})


def _from_arrow(tables: Iterable[Any]) -> pl.DataFrame:
    # One frame a table: dictionaries that differ between tables are no obstacle once they are strings.
    return pl.concat([pl.DataFrame(pl.from_arrow(plain_text(table))) for table in tables])


def _count(by_reason: Mapping[str, int]) -> int:
    return sum(by_reason.values())


def _dtype(name: str) -> pl.DataType:
    if name in _TEXT:
        return pl.String()
    if name in _WHOLE:
        return pl.Int64()
    return pl.Boolean() if name in _FLAG else pl.Float64()

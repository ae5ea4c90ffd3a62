"""The rows and columns of a result as Polars data frames; no other module makes data frames.

The frames have the names of `modelcast.study.result`, and the same columns and types also where a
result has no rows.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import polars as pl

from modelcast.io.arrow import columns_table, plain_text, sample_tables
from modelcast.study.result import EvaluationResult, HoldsEvaluation, result_of, trips_table
from modelcast.study.table import Kind, Table

__all__ = [
    "events_frame",
    "frame",
    "rates_frame",
    "references_frame",
    "samples_frame",
    "tracking_frame",
    "trips_frame",
]

_TYPES: Mapping[Kind, type[pl.DataType]] = {
    "text": pl.String,
    "count": pl.Int64,
    "flag": pl.Boolean,
    "ratio": pl.Float64,
    "number": pl.Float64,
}


def frame(table: Table) -> pl.DataFrame:
    """Return a table of results as a data frame, with null where a row has no value.

    Parameters
    ----------
    table
        Any.
    """
    types = {column.name: _TYPES[column.kind] for column in table.schema.columns}
    columns = {name: [row.values[place] for row in table] for name, place in table.schema.places.items()}
    return pl.DataFrame(columns, schema=types)


def rates_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, policy, bank and threshold of the rate runs.

    Parameters
    ----------
    result
        What `evaluate` gave, or its `EvaluationResult`.
    """
    return frame(result_of(result).rates)


def references_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, reference and threshold.

    Parameters
    ----------
    result
        What `evaluate` gave, or its `EvaluationResult`.
    """
    return frame(result_of(result).references)


def tracking_frame(result: EvaluationResult | HoldsEvaluation) -> pl.DataFrame:
    """Return one row for each trip, policy, rate basis, threshold and packet error ratio.

    Parameters
    ----------
    result
        What `evaluate` gave, or its `EvaluationResult`.
    """
    return frame(result_of(result).tracking)


def trips_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a trip.

    ``skipped`` and ``repaired`` are total counts here, ``warnings`` the kinds alone, and ``grid_m`` is split
    into its two axes; the reasons and the smoother's figures are in ``summary.json``.
    """
    return frame(trips_table(result))


def events_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a message of the rate runs."""
    return _from_arrow([columns_table(result.events)])


def samples_frame(result: EvaluationResult) -> pl.DataFrame:
    """Return one row a tracking-error sample kept, with null where the host held nothing."""
    return _from_arrow(sample_tables(result.samples))


def _from_arrow(tables: Iterable[Any]) -> pl.DataFrame:
    # One frame a table: dictionaries that differ between tables are no obstacle once they are strings.
    return pl.concat([pl.DataFrame(pl.from_arrow(plain_text(table))) for table in tables])

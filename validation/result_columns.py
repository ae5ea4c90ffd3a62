"""The columns of result files as tables: ``docs/columns.md``, made from their declarations.

Run ``python validation/result_columns.py --write`` after a column has changed; ``--check`` returns 1 where
the page is not what the declarations say, and a test runs it.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

from modelcast.core.cells import Cells
from modelcast.corpora.evaluation_tables import RATE_ROWS, TRIP_ROWS
from modelcast.io.ranking import RANKING
from modelcast.study.compare.result import (
    COUNTS,
    RATIOS,
    REFERENCE_RATIOS,
    RIVAL_RATIOS,
    ROUTES,
    TRACKING_RATIOS,
)
from modelcast.study.coverage import COVERAGE, TIMES
from modelcast.study.cruise.run import CRUISE
from modelcast.study.network.capacity import PROBES
from modelcast.study.network.meeting import FILM
from modelcast.study.network.pairs import PAIRED
from modelcast.study.network.rows import CASE_TABLES, POOLED, RUNS, SENDERS
from modelcast.study.network.warning_rows import POOLED_WARNINGS
from modelcast.study.result import RATES, REFERENCES, TRACKING, TRIPS
from modelcast.study.safety.result import EVENTS, POOLED_SAFETY
from modelcast.study.table import TableSchema
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "columns.md"
TABLES: Mapping[str, tuple[TableSchema, ...]] = {
    "evaluate": (TRIPS, RATES, REFERENCES, TRACKING),
    "evaluate of a corpus": (TRIP_ROWS, RATE_ROWS),
    "compare": (ROUTES, COUNTS, RATIOS, RIVAL_RATIOS, TRACKING_RATIOS, REFERENCE_RATIOS),
    "coverage": (COVERAGE, TIMES),
    "network": (RUNS, *CASE_TABLES.values(), POOLED, POOLED_WARNINGS, SENDERS, PAIRED, FILM),
    "capacity": (PROBES,),
    "safety": (POOLED_SAFETY, EVENTS),
    "cruise": (CRUISE,),
    "ranking": (RANKING,),
}


def described(schema: TableSchema) -> list[str]:
    """Heading, what a row is, and a line a column."""
    rows = [
        [column.name, column.kind, column.unit, column.description, column.missing]
        for column in schema.columns
    ]
    heads = ["column", "kind", "unit", "what it is", "absent where"]
    return [f"### {schema.name}", "", schema.description, "", *Cells(heads, rows).markdown(), ""]


def main() -> int:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    blocks = {
        name: [line for schema in schemas for line in described(schema)][:-1]
        for name, schemas in TABLES.items()
    }
    return put({PAGE: blocks}, check=not given.write)


if __name__ == "__main__":
    raise SystemExit(main())

"""Writing a partition's samples: Parquet files of bounded size, trips whole in them where they fit.

Row groups hold at least `GROUP_ROWS` rows where there are that many, and whole trips; one trip of more than
`MOST_GROUP_ROWS` is parted among several. A file is closed before it could exceed `FILE_BYTES`.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.corpora.catalogue import SAMPLED
from modelcast.io.write_trips import TRIP_COLUMNS

__all__ = ["FILE_BYTES", "GROUP_ROWS", "MOST_GROUP_ROWS", "SAMPLES", "write_rows"]

FILE_BYTES = 64_000_000
"""Most that a file holds."""

GROUP_ROWS = 250_000
"""Rows after which a row group ends with the trip."""

MOST_GROUP_ROWS = 750_000
"""Most that a row group holds."""

SAMPLES: Any = pa.schema([(name, pa.float64()) for name in SAMPLED])
"""A trip's samples between reading and packing; a column that a trip does not have is null."""

_CONSTANT = tuple(name for name in TRIP_COLUMNS if name not in SAMPLED)
_WORDS: Any = pa.dictionary(pa.int32(), pa.string())
_ROWS: Any = pa.schema([(name, _WORDS if name == "trip" else pa.float64()) for name in TRIP_COLUMNS])
"""Names by number while they are held: a long one for every row is more than a column of text can have."""

_OVERHEAD_BYTES = 1_000_000


def write_rows(folder: Path, trips: Iterable[tuple[Mapping[str, Any], Any]]) -> list[str]:
    """Write trips into numbered files and return these files' names.

    Parameters
    ----------
    folder
        An empty folder.
    trips
        Rows of the catalogue with their samples (a `pyarrow.RecordBatch` of `SAMPLES`), in order.
    """
    names: list[str] = []
    groups = _groups(trips)
    table = next(groups, None)
    while table is not None:
        names.append(f"{len(names):04d}.parquet")
        dictionaries: Any = list(_CONSTANT)
        with (
            (folder / names[-1]).open("wb") as file,
            pq.ParquetWriter(
                file,
                _ROWS,
                compression="zstd",
                use_dictionary=dictionaries,
                write_page_checksum=True,
                store_schema=False,  # names are read as text
            ) as writer,
        ):
            first = True
            while table is not None and (first or file.tell() + table.nbytes + _OVERHEAD_BYTES <= FILE_BYTES):
                writer.write_table(table.unify_dictionaries(), row_group_size=table.num_rows)
                first, table = False, next(groups, None)
    return names


def _groups(trips: Iterable[tuple[Mapping[str, Any], Any]]) -> Iterator[Any]:
    """Yield the tables of the row groups."""
    held: list[Any] = []
    count = 0
    for row, samples in trips:
        for start in range(0, samples.num_rows, MOST_GROUP_ROWS):
            part = _table(row, samples.slice(start, MOST_GROUP_ROWS))
            if held and count + part.num_rows > MOST_GROUP_ROWS:
                yield pa.concat_tables(held)
                held, count = [], 0
            held.append(part)
            count += part.num_rows
        if count >= GROUP_ROWS:
            yield pa.concat_tables(held)
            held, count = [], 0
    if held:
        yield pa.concat_tables(held)


def _table(row: Mapping[str, Any], samples: Any) -> Any:
    """Return samples with the columns that are constant in a trip."""
    columns: dict[str, Any] = dict(zip(SAMPLED, samples.columns, strict=True))
    for name in _CONSTANT:
        if name == "trip":
            first = np.zeros(samples.num_rows, dtype=np.int32)
            columns[name] = pa.DictionaryArray.from_arrays(first, [row[name]])
        else:
            columns[name] = pa.repeat(pa.scalar(row[name], pa.float64()), samples.num_rows)
    return pa.table([columns[name] for name in TRIP_COLUMNS], schema=_ROWS)

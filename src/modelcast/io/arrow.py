"""Columns and sample blocks of a result as Arrow tables, and their one way into Parquet.

Names repeat over millions of rows, so they travel as dictionary columns up to the file and are stored as
plain strings: dictionary columns of several files do not unify when they are read together.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright, here and nowhere else.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.study.result import Coded, Columns, SampleBlock

__all__ = [
    "EVENTS_SCHEMA",
    "SAMPLES_SCHEMA",
    "columns_table",
    "plain_text",
    "sample_tables",
    "table_writer",
    "write_tables",
]

_NAME: Any = pa.dictionary(pa.int32(), pa.string())
_NAMES = ("trip", "policy", "bank", "rate_basis")
_ERRORS = (
    "tracking_error_m",
    "tracking_error_before_m",
    "along_track_m",
    "cross_track_m",
    "information_age_s",
)

SAMPLES_SCHEMA: Any = pa.schema(
    [
        *((name, _NAME) for name in _NAMES),
        ("threshold_m", pa.float64()),
        ("packet_error_ratio", pa.float64()),
        ("seed", pa.int32()),
        ("t_s", pa.float64()),
        *((name, pa.float32()) for name in _ERRORS),
    ]
)
"""Columns of ``samples.parquet``."""

EVENTS_SCHEMA: Any = pa.schema(
    [
        *((name, _NAME) for name in ("trip", "policy", "bank", "kind", "sub_model")),
        *((name, pa.float64()) for name in ("threshold_m", "t_s", "airtime_s")),
        ("size_bytes", pa.int32()),
    ]
)
"""Columns of ``events.parquet``."""

_GROUP_ROWS = 500_000
"""Rows gathered before they are written: what bounds the memory on top of the result's own."""


def columns_table(columns: Columns) -> Any:
    """Return the columns as an Arrow table, text as dictionary columns and NaN as null.

    Parameters
    ----------
    columns
        Columns of equal length; text best as `Coded`, else as ``<U``, ``StringDType`` or objects (None is
        null).

    Returns
    -------
    pyarrow.Table
    """
    table: Any = pa.table({name: _column(column) for name, column in columns.items()})
    return table


def sample_tables(blocks: Iterable[SampleBlock]) -> Iterator[Any]:
    """Yield the samples as Arrow tables of `SAMPLES_SCHEMA`, some hundred thousand rows each.

    Rows run over blocks, loss ratios, seeds and instants, in this order.

    Parameters
    ----------
    blocks
        The blocks of a result.
    """
    group: list[SampleBlock] = []
    rows = 0
    for block in blocks:
        group.append(block)
        rows += _error(block, _ERRORS[0]).size
        if rows >= _GROUP_ROWS:
            yield _samples_table(group)
            group, rows = [], 0
    yield _samples_table(group)


def plain_text(table: Any) -> Any:
    """Return the table with its dictionary columns as plain strings.

    Parameters
    ----------
    table
        A ``pyarrow.Table``.
    """
    for place, field in enumerate(table.schema):
        if pa.types.is_dictionary(field.type):
            table = table.set_column(place, field.name, table.column(place).cast(pa.string()))
    return table


def write_tables(tables: Iterable[Any], schema: Any, out: Path | BinaryIO) -> None:
    """Write Arrow tables of one schema as a Parquet file.

    Parameters
    ----------
    tables, schema
        What to write; the schema's metadata go into the file's.
    out
        The file, or one open for writing bytes.
    """
    with table_writer(schema, out) as writer:
        for table in tables:
            if table.num_rows:
                writer.write_table(table)
        if schema.metadata:
            writer.add_key_value_metadata(schema.metadata)


def table_writer(schema: Any, out: Path | BinaryIO) -> Any:
    """Return a `pyarrow.parquet.ParquetWriter` that packs as all Parquet files of results are packed.

    Parameters
    ----------
    schema
        Of the tables to come.
    out
        The file, or one open for writing bytes.
    """
    is_float = {field.name: bool(pa.types.is_floating(field.type)) for field in schema}
    return pq.ParquetWriter(
        str(out) if isinstance(out, Path) else out,
        schema,
        compression="zstd",
        compression_level=1,
        use_dictionary=cast("Any", [name for name, split in is_float.items() if not split]),
        use_byte_stream_split=cast("Any", [name for name, split in is_float.items() if split]),
        # Without Arrow's schema beside the Parquet one, text reads back as plain strings.
        store_schema=False,
    )


def _samples_table(blocks: Sequence[SampleBlock]) -> Any:
    shapes = [_error(block, _ERRORS[0]).shape for block in blocks]
    sizes = [int(np.prod(shape)) for shape in shapes]
    columns: dict[str, Any] = {}
    for name in _NAMES:
        values = np.array([getattr(block, name) for block in blocks], dtype=object)
        columns[name] = _coded_runs(values, np.array(sizes, dtype=np.int64))
    columns["threshold_m"] = np.repeat(
        [block.threshold_m for block in blocks], np.array(sizes, dtype=np.int64)
    )
    columns["packet_error_ratio"] = _joined(
        np.repeat(block.packet_error_ratios, size // max(len(block.packet_error_ratios), 1))
        for block, size in zip(blocks, sizes, strict=True)
    )
    columns["seed"] = _joined(
        np.broadcast_to(np.arange(shape[1], dtype=np.int32)[:, None], shape).reshape(-1) for shape in shapes
    )
    columns["t_s"] = _joined(
        np.broadcast_to(block.t_s, shape).reshape(-1) for block, shape in zip(blocks, shapes, strict=True)
    )
    for name in _ERRORS:
        columns[name] = _joined(_error(block, name).reshape(-1) for block in blocks)
    arrays = [
        column if field.name in _NAMES else pa.array(column, field.type, from_pandas=True)
        for field, column in zip(SAMPLES_SCHEMA, columns.values(), strict=True)
    ]
    table: Any = pa.table(arrays, schema=SAMPLES_SCHEMA)
    return table


def _error(block: SampleBlock, name: str) -> npt.NDArray[np.float32]:
    return block.errors[name]


def _joined(parts: Iterable[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    found = list(parts)
    return np.concatenate(found) if found else np.empty(0)


def _column(column: npt.NDArray[Any] | Coded) -> Any:
    """Return one Arrow column. Text is coded run by run: in a long table a name stays for many rows."""
    if isinstance(column, Coded):
        return _dictionary(column.codes, column.names)
    if column.dtype.kind not in "UTO":
        numbers: Any = pa.array(column, from_pandas=column.dtype.kind == "f")
        return numbers
    changes = np.flatnonzero(column[1:] != column[:-1]) + 1
    starts = np.concatenate([[0], changes]) if column.size else changes
    return _coded_runs(column[starts], np.diff(starts, append=column.size))


def _coded_runs(values: npt.NDArray[Any], lengths: npt.NDArray[np.int64]) -> Any:
    """Return a dictionary column that repeats each value over a run of rows; None is null."""
    listed = cast("list[object]", values.tolist())
    names = tuple(dict.fromkeys(str(value) for value in listed if value is not None))
    code = {name: at for at, name in enumerate(names)}
    codes = np.array([-1 if value is None else code[str(value)] for value in listed], dtype=np.int32)
    return _dictionary(np.repeat(codes, lengths), names)


def _dictionary(codes: npt.NDArray[np.int32], names: tuple[str, ...]) -> Any:
    """Return a dictionary column; a negative code is null."""
    absent = codes < 0
    indices: Any = pa.array(codes, pa.int32(), mask=absent if absent.any() else None)
    found: Any = pa.DictionaryArray.from_arrays(indices, pa.array(names, pa.string()))
    return found

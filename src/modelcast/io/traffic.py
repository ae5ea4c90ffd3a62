"""The hybrid against the baseline in traffic, on disk.

``traffic.parquet``
    One row a figure, density, radio, bank, threshold and distance: the columns
    `modelcast.study.network.pairs.PAIRED`, bounds empty where there was one seed.
"""

from collections.abc import Sequence
from pathlib import Path

from modelcast.io.table_files import read_table, write_table
from modelcast.study.network.pairs import PAIRED
from modelcast.study.table import Row, Table

__all__ = ["read_traffic", "write_traffic"]


def write_traffic(rows: Sequence[Row], folder: str | Path) -> Path:
    """Write ``traffic.parquet``; return its path.

    Parameters
    ----------
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them.
    folder
        An existing folder.
    """
    path = Path(folder) / "traffic.parquet"
    write_table(PAIRED.table(rows), path)
    return path


def read_traffic(path: str | Path) -> Table:
    """Read what `write_traffic` wrote.

    Parameters
    ----------
    path
        ``traffic.parquet``.

    Raises
    ------
    DataFormatError
        Where it is no such file.
    """
    return read_table(PAIRED, path, remedy="Name the file of a run with --traffic.")

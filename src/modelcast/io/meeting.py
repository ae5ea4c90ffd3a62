"""The film of a meeting as a table.

``film.parquet``: a row a run and instant, the columns of `modelcast.study.network.meeting.FILM`.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from modelcast.io.arrow import write_tables
from modelcast.io.table_files import arrow_columns
from modelcast.study.network.meeting import FILM, Seen

__all__ = ["write_meeting"]


def write_meeting(runs: Mapping[str, Seen], path: Path) -> None:
    """Write what was seen.

    Parameters
    ----------
    runs
        By their words.
    path
        The file.
    """
    parts = [
        {
            "run": np.full(seen.t_s.size, words, dtype=object),
            "t_s": seen.t_s,
            "vehicle_east_m": seen.vehicle[:, 0],
            "vehicle_north_m": seen.vehicle[:, 1],
            "person_east_m": seen.person[:, 0],
            "person_north_m": seen.person[:, 1],
            "in_sight": seen.in_sight,
            "distance_m": seen.distance_m,
            "believed_east_m": seen.believed[:, 0],
            "believed_north_m": seen.believed[:, 1],
            "error_m": seen.error_m,
            "age_s": seen.age_s,
        }
        for words, seen in runs.items()
    ]
    film = arrow_columns(FILM, {name: np.concatenate([part[name] for part in parts]) for name in FILM.names})
    write_tables([film], film.schema, path)

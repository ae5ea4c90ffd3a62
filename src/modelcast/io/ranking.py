"""A ranking of trips by their manoeuvres: as one table, and as one JSON document.

Columns of the table, one row a trip, the richest first: ``rank`` (from 1), ``trip``, ``manoeuvres`` (total),
``kinds``, ``per_km``, ``duration_s``, ``distance_m``, and a count of each kind: ``lane_changes``, ``turns``,
``u_turns``, ``roundabouts``, ``stops``, ``hard_brakes``. The document holds the same for each trip, and its
manoeuvres with times, size and side.
"""

from collections.abc import Mapping, Sequence
from typing import Any, BinaryIO, Literal

import polars as pl

from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreCounts, ManoeuvreKind

__all__ = ["KIND_COLUMNS", "ranking_document", "ranking_rows", "write_ranking"]

KIND_COLUMNS = {
    ManoeuvreKind.LANE_CHANGE: "lane_changes",
    ManoeuvreKind.TURN: "turns",
    ManoeuvreKind.U_TURN: "u_turns",
    ManoeuvreKind.ROUNDABOUT: "roundabouts",
    ManoeuvreKind.STOP: "stops",
    ManoeuvreKind.HARD_BRAKE: "hard_brakes",
}
"""Column of each kind."""


def ranking_rows(ranked: Sequence[ManoeuvreCounts]) -> list[dict[str, Any]]:
    """Rows of the table.

    Parameters
    ----------
    ranked
        Trips in order of merit (`modelcast.trips.manoeuvres.rank.rank_trips`).
    """
    return [
        {
            "rank": at,
            "trip": one.trip_id,
            "manoeuvres": one.total,
            "kinds": one.kinds,
            "per_km": one.per_km,
            "duration_s": one.duration_s,
            "distance_m": one.distance_m,
            **{KIND_COLUMNS[kind]: count for kind, count in one.by_kind.items()},
        }
        for at, one in enumerate(ranked, start=1)
    ]


def write_ranking(
    ranked: Sequence[ManoeuvreCounts], file: BinaryIO, *, form: Literal["csv", "parquet"]
) -> None:
    """Write the table.

    Parameters
    ----------
    ranked
        Trips in order of merit.
    file
        Open for writing bytes.
    form
        Comma-separated text or Parquet.
    """
    table = pl.DataFrame(ranking_rows(ranked))
    if form == "csv":
        table.write_csv(file)
    else:
        table.write_parquet(file)


def ranking_document(
    ranked: Sequence[ManoeuvreCounts],
    *,
    counted: int,
    failures: Mapping[str, str],
    skipped: Mapping[str, str],
) -> dict[str, Any]:
    """Everything as plain values.

    Parameters
    ----------
    ranked
        Trips in order of merit, all or the first few.
    counted
        Number of trips that were ranked.
    failures
        Files that could not be read, with the reason.
    skipped
        Vehicles and files that held no trip, with the reason.
    """
    trips = [
        {**row, "found": [_plain(item) for item in one.manoeuvres]}
        for row, one in zip(ranking_rows(ranked), ranked, strict=True)
    ]
    return {"trips": trips, "counted": counted, "failures": dict(failures), "skipped": dict(skipped)}


def _plain(one: FoundManoeuvre) -> dict[str, Any]:
    return {
        "kind": one.kind.value,
        "start_s": one.start_s,
        "end_s": one.end_s,
        "size": one.size,
        "unit": one.kind.unit,
        "side": one.side or None,
    }

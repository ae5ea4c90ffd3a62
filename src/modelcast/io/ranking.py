"""A ranking of trips by their manoeuvres: as one table, and as one JSON document.

The columns are `RANKING`, one row a trip, the richest first. The document holds the same for each trip,
and its manoeuvres with times, size and side.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from modelcast.study.table import Table, TableSchema, count, quantity, text
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreCounts, ManoeuvreKind

__all__ = ["KIND_COLUMNS", "RANKING", "ranking_document", "ranking_table"]

KIND_COLUMNS = {
    ManoeuvreKind.LANE_CHANGE: "lane_changes",
    ManoeuvreKind.TURN: "turns",
    ManoeuvreKind.U_TURN: "u_turns",
    ManoeuvreKind.ROUNDABOUT: "roundabouts",
    ManoeuvreKind.STOP: "stops",
    ManoeuvreKind.HARD_BRAKE: "hard_brakes",
}
"""Column of each kind."""


RANKING = TableSchema(
    "ranking",
    "One trip with its manoeuvres, the richest first.",
    (
        count("rank", "Place, from 1."),
        text("trip", "Trip identifier."),
        count("manoeuvres", "Manoeuvres of all kinds."),
        count("kinds", "Kinds met."),
        quantity("per_km", "1/km", "Manoeuvres a kilometre."),
        quantity("duration_s", "s", "Time observed."),
        quantity("distance_m", "m", "Way travelled."),
        *(count(name, f"Manoeuvres: {name.replace('_', ' ')}.") for name in KIND_COLUMNS.values()),
    ),
)
"""Ranked trips: a row each."""


def ranking_table(ranked: Sequence[ManoeuvreCounts]) -> Table:
    """Return the table of `RANKING`.

    Parameters
    ----------
    ranked
        Trips in order of merit (`modelcast.trips.manoeuvres.rank.rank_trips`).
    """
    return RANKING.table(
        RANKING.row(
            rank=at,
            trip=one.trip_id,
            manoeuvres=one.total,
            kinds=one.kinds,
            per_km=one.per_km,
            duration_s=one.duration_s,
            distance_m=one.distance_m,
            **{KIND_COLUMNS[kind]: number for kind, number in one.by_kind.items()},
        )
        for at, one in enumerate(ranked, start=1)
    )


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
        for row, one in zip(ranking_table(ranked).plain(), ranked, strict=True)
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

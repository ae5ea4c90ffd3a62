"""Trips in order of their manoeuvres, in the terminal."""

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.report.console_table import console_table
from modelcast.report.literal import Prose, literal
from modelcast.trips.manoeuvres.base import KINDS, ManoeuvreCounts, ManoeuvreKind

__all__ = ["ranking_report"]

_HEADINGS = {
    ManoeuvreKind.LANE_CHANGE: "lane",
    ManoeuvreKind.TURN: "turn",
    ManoeuvreKind.U_TURN: "U-turn",
    ManoeuvreKind.ROUNDABOUT: "round",
    ManoeuvreKind.STOP: "stop",
    ManoeuvreKind.HARD_BRAKE: "brake",
}
_NOTE = "Lane changes, turns, U-turns, roundabouts, stops, hard brakes; equal totals by kinds, then by /km."


def ranking_report(
    ranked: Sequence[ManoeuvreCounts],
    *,
    counted: int,
    failures: Mapping[str, str],
    skipped: Mapping[str, str],
) -> RenderableType:
    """Return the table, what it is ranked by, and what gave no trip.

    Parameters
    ----------
    ranked
        Trips in order of merit, all or the first few.
    counted
        Number of trips that were ranked.
    failures, skipped
        What could not be read and what held no trip, with the reason.
    """
    heads = ("", "trip", "total", *_HEADINGS.values(), "/km", "min", "km")
    rows = [
        (
            str(at),
            one.trip_id,
            str(one.total),
            *(str(one.by_kind[kind]) for kind in KINDS),
            f"{one.per_km:.1f}",
            f"{one.duration_s / 60.0:.1f}",
            f"{one.distance_m / 1000.0:.1f}",
        )
        for at, one in enumerate(ranked, start=1)
    ]
    table = console_table(Cells(heads, rows, 2), "Trips by manoeuvres", box=SIMPLE_HEAD, padding=(0, 0, 0, 0))
    summary = _summary(len(ranked), counted, failures, skipped)
    parts: list[RenderableType] = [table, Prose(_NOTE), Prose(summary)]
    parts += [literal(f"no trip from {name}: {reason}") for name, reason in skipped.items()]
    parts += [literal(f"failed: {name}: {reason}", "bold") for name, reason in failures.items()]
    return Group(*parts)


def _summary(shown: int, counted: int, failures: Mapping[str, str], skipped: Mapping[str, str]) -> str:
    first = f"{shown} of {counted} trips shown" if shown < counted else f"{counted} trips"
    return f"{first}; {len(skipped)} skipped, {len(failures)} failed"

"""What ``modelcast trips`` shows: one block a trip, or one JSON document."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

from modelcast.agents.plausibility import Finding
from modelcast.core.inspection import TripInspection
from modelcast.report.literal import literal

__all__ = ["Findings", "inspection_document", "inspection_report"]

Findings = Mapping[Finding, int] | None
"""Samples of a trip by what plausibility found of them; None where it states no speed or heading."""


def inspection_document(
    found: Sequence[tuple[TripInspection, Findings]], failures: Mapping[str, str], skipped: Mapping[str, str]
) -> dict[str, Any]:
    """Everything as plain values; a number that does not exist is None.

    Parameters
    ----------
    found
        One inspection a trip, with what plausibility found.
    failures
        Files that could not be read, with the reason.
    skipped
        Vehicles and files that held no trip, with the reason.
    """
    trips: list[dict[str, Any]] = []
    for one, findings in found:
        plain = {
            item.name: _finite(getattr(one, item.name)) for item in fields(one) if item.name != "reading"
        }
        counts = {
            "rows": one.reading.rows,
            "skipped": dict(one.reading.skipped),
            "repaired": dict(one.reading.repaired),
            "implausible": None if findings is None else _implausible(findings),
        }
        trips.append({**plain, **counts, "recommended_protocol": one.recommended_protocol})
    return {"trips": trips, "failures": dict(failures), "skipped": dict(skipped)}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inspection_report(
    found: Sequence[tuple[TripInspection, Findings]], failures: Mapping[str, str], skipped: Mapping[str, str]
) -> RenderableType:
    """A table a trip, at most 100 columns wide, and what gave no trip.

    Parameters
    ----------
    found, failures, skipped
        As in `inspection_document`.
    """
    parts: list[RenderableType] = [_trip(*one) for one in found]
    parts += [literal(f"no trip from {name}: {reason}") for name, reason in skipped.items()]
    parts += [literal(f"failed: {name}: {reason}", "bold") for name, reason in failures.items()]
    return Group(*parts)


def _trip(one: TripInspection, findings: Findings) -> Table:
    table = Table(
        show_header=False, box=None, title=literal(one.trip_id), title_justify="left", title_style="bold"
    )
    table.add_column(style="dim")
    table.add_column(overflow="fold")
    for name, value in _lines(one):
        table.add_row(name, literal(value))
    if findings is not None:
        implausible = _implausible(findings)
        table.add_row("implausible", literal(_counts("", implausible).lstrip("; ") or "nothing"))
    return table


def _lines(one: TripInspection) -> list[tuple[str, str]]:
    east_m, north_m = one.grid_axis_m
    held = f", held for {one.held_s:.2f} s" if one.values_held else ""
    agreement = "no speed column"
    if not math.isnan(one.speed_ratio):
        stuck = " (the column looks stuck)" if one.speed_is_stuck else ""
        agreement = f"ratio {one.speed_ratio:.3f}, rms difference {one.speed_difference_mps:.2f} m/s{stuck}"
    gaps = f"{one.gaps}, longest {one.longest_gap_s:.1f} s" if one.gaps else "none"
    return [
        ("duration", f"{one.duration_s:.1f} s, {one.samples} samples"),
        ("rate", f"{one.rate_hz:.2f} Hz" + (", resampled to its median step" if one.resampled else "")),
        ("gaps", gaps),
        ("position grid", f"{east_m:.3f} m east, {north_m:.3f} m north" if one.grid_m else "none"),
        ("speed changes", _changes(one.speed_rate_hz) + held),
        ("heading changes", _changes(one.heading_rate_hz)),
        ("noise over 1 s", f"p50 {one.noise_p50_m:.4f} m, p95 {one.noise_p95_m:.4f} m"),
        ("speed, position", agreement),
        ("events", f"{one.stops} stops, {one.turns} turns, {one.hard_brakes} hard brakes"),
        ("rows", f"{one.reading.rows} read{_counts('skipped', one.reading.skipped)}"),
        ("repaired", _counts("", one.reading.repaired).lstrip("; ") or "nothing"),
        ("protocol", f"{one.recommended_protocol} by default"),
    ]


def _implausible(findings: Mapping[Finding, int]) -> dict[str, int]:
    """Samples by reason in words, the plausible left out."""
    return {one.reason: count for one, count in findings.items() if one is not Finding.PLAUSIBLE}


def _changes(rate_hz: float | None) -> str:
    return "no such column" if rate_hz is None else f"{rate_hz:.2f} Hz"


def _counts(word: str, counts: Mapping[str, int]) -> str:
    return "".join(f"; {count} {word} ({reason})".replace("  ", " ") for reason, count in counts.items())

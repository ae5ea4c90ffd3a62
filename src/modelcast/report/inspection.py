"""What ``modelcast trips`` shows: one block a trip, or one JSON document."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from rich.console import RenderableType
from rich.table import Table

from modelcast.report.literal import literal
from modelcast.station.receiver.plausibility import Finding
from modelcast.trips.inspection import TripInspection
from modelcast.trips.judgement import LONGEST_NOISE_SPAN_S, judge
from modelcast.trips.manoeuvres.base import ManoeuvreCounts

_NEVER_MOVED = "not told: never moved"

__all__ = ["Findings", "failed_lines", "trip_document", "trip_table"]

Findings = Mapping[Finding, int] | None
"""Samples of a trip by what plausibility found of them; None where it states no speed or heading."""


def trip_document(
    one: TripInspection,
    findings: Findings,
    manoeuvres: ManoeuvreCounts,
    *,
    thresholds_m: Sequence[float],
) -> dict[str, Any]:
    """What was found of a trip as plain values; a number that does not exist is None.

    Parameters
    ----------
    one
        Its inspection.
    findings
        What plausibility found.
    manoeuvres
        Its manoeuvres.
    thresholds_m
        Tracking-error thresholds that the noise is judged by [m].
    """
    plain = {item.name: _finite(getattr(one, item.name)) for item in fields(one) if item.name != "reading"}
    counts = {
        "rows": one.reading.rows,
        "skipped": dict(one.reading.skipped),
        "repaired": dict(one.reading.repaired),
        "manoeuvres": {kind.value: count for kind, count in manoeuvres.by_kind.items()},
        "implausible": None if findings is None else _implausible(findings),
        "understood": None if one.reading.understood is None else one.reading.understood.document(),
    }
    judged = {
        "warnings": dict(judge(one, thresholds_m, smoothed=_smoothed(one))),
        "recommended_protocol": one.recommended_protocol,
    }
    return {**plain, **counts, **judged}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def failed_lines(failures: Mapping[str, str], skipped: Mapping[str, str]) -> list[RenderableType]:
    """What gave no trip, a line each.

    Parameters
    ----------
    failures
        Files that could not be read, with the reason.
    skipped
        Vehicles and files that held no trip, with the reason.
    """
    return [
        *(literal(f"no trip from {name}: {reason}") for name, reason in skipped.items()),
        *(literal(f"failed: {name}: {reason}", "bold") for name, reason in failures.items()),
    ]


def trip_table(
    one: TripInspection,
    findings: Findings,
    manoeuvres: ManoeuvreCounts,
    *,
    thresholds_m: Sequence[float],
    with_understood: bool = True,
) -> Table:
    """What was found of a trip as a table, at most 100 columns wide.

    Parameters
    ----------
    one, findings, manoeuvres, thresholds_m
        As in `trip_document`.
    with_understood
        Begin with what the file was taken for; it is the same for all trips of a file.
    """
    table = Table(
        show_header=False, box=None, title=literal(one.trip_id), title_justify="left", title_style="bold"
    )
    table.add_column(style="dim")
    table.add_column(overflow="fold")
    for name, value in _understood(one).items() if with_understood else ():
        table.add_row(name, literal(value))
    for kind, text in judge(one, thresholds_m, smoothed=_smoothed(one)).items():
        table.add_row(literal("warning", "bold"), literal(f"{kind}: {text}", "bold"))
    for name, value in _lines(one):
        table.add_row(name, literal(value))
    table.add_row("manoeuvres", literal(_manoeuvres(manoeuvres)))
    if findings is None:
        table.add_row("implausible", literal("not checked: needs speed and heading"))
    else:
        implausible = _implausible(findings)
        table.add_row("implausible", literal(_counts("", implausible).lstrip("; ") or "nothing"))
    return table


def _understood(one: TripInspection) -> dict[str, str]:
    """What the file was taken for, a line a subject."""
    taken = one.reading.understood
    return {"format": one.source, **({} if taken is None else taken.lines())} if one.source else {}


def _manoeuvres(counts: ManoeuvreCounts) -> str:
    met = [f"{count} {kind}{'s' * (count > 1)}" for kind, count in counts.by_kind.items() if count]
    return ", ".join(met) or "none"


def _lines(one: TripInspection) -> list[tuple[str, str]]:
    east_m, north_m = one.grid_axis_m
    held = f", held for {one.held_s:.2f} s" if one.values_held else ""
    gaps = f"{one.gaps}, longest {one.longest_gap_s:.1f} s" if one.gaps else "none"
    return [
        ("duration", f"{one.duration_s:.1f} s, {one.samples} samples"),
        ("rate", f"{one.rate_hz:.2f} Hz" + (", resampled to its median step" if one.resampled else "")),
        ("gaps", gaps),
        ("jumps", f"{one.jumps}, up to {one.largest_jump_m:.4g} m" if one.jumps else "none"),
        ("fixes", _fixes(one)),
        ("position grid", f"{east_m:.3f} m east, {north_m:.3f} m north" if one.grid_m else _no_grid(one)),
        ("position changes", _changes(one.position_rate_hz)),
        ("speed changes", _changes(one.speed_rate_hz) + held),
        ("heading changes", _changes(one.heading_rate_hz)),
        (f"noise over {one.noise_span_s:.2g} s", _noise(one)),
        ("speed, position", _agreement(one)),
        ("rows", f"{one.reading.rows} read{_counts('skipped', one.reading.skipped)}"),
        ("repaired", _counts("", one.reading.repaired).lstrip("; ") or "nothing"),
        ("protocol", f"{one.recommended_protocol} by default"),
    ]


def _implausible(findings: Mapping[Finding, int]) -> dict[str, int]:
    """Samples by reason in words, the plausible left out."""
    return {one.reason: count for one, count in findings.items() if one is not Finding.PLAUSIBLE}


def _changes(rate_hz: float | None) -> str:
    if rate_hz is None:
        return "no such column"
    return _NEVER_MOVED if math.isnan(rate_hz) else f"{rate_hz:.2f} Hz"


def _fixes(one: TripInspection) -> str:
    if one.is_joined:
        return f"about {one.fix_period_s:.2g} s apart, joined by straight lines"
    if math.isnan(one.straight_ratio) and math.isnan(one.curvature_ratio):
        return _hardly_moved(one)
    return "every sample"


def _no_grid(one: TripInspection) -> str:
    return _NEVER_MOVED if one.moving_s == 0.0 else "none"


def _noise(one: TripInspection) -> str:
    if math.isnan(one.noise_p50_m):
        return "not told: no part is as long"
    text = f"p50 {one.noise_p50_m:.4f} m, p95 {one.noise_p95_m:.4f} m"
    return text + (", the motion's own included" if one.noise_span_s > LONGEST_NOISE_SPAN_S else "")


def _agreement(one: TripInspection) -> str:
    """Speed column against positions, or why they are not compared."""
    if one.speed_rate_hz is None:
        return "no speed column"
    if math.isnan(one.speed_ratio):
        return _hardly_moved(one).replace("told", "compared")
    stuck = " (the column looks stuck)" if one.speed_is_stuck else ""
    return f"ratio {one.speed_ratio:.3f}, rms difference {one.speed_difference_mps:.2f} m/s{stuck}"


def _hardly_moved(one: TripInspection) -> str:
    return _NEVER_MOVED if one.moving_s == 0.0 else f"not told: moved for {one.moving_s:.1f} s only"


def _counts(word: str, counts: Mapping[str, int]) -> str:
    return "".join(f"; {count} {word} ({reason})".replace("  ", " ") for reason, count in counts.items())


def _smoothed(one: TripInspection) -> bool:
    """Whether an evaluation would take the smoothed recording for truth."""
    return one.recommended_protocol == "sensor"

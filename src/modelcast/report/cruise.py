"""Platoons in the terminal and in Markdown: what every sender was worth under every loss."""

from collections.abc import Sequence

from rich import box
from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.report.console_table import console_table
from modelcast.report.literal import Prose
from modelcast.study.cruise.run import PERFECT, REFERENCE, CruiseResult
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["cruise_lines", "cruise_report", "sender_label"]

_HEADINGS = (
    "sender",
    "loss",
    "messages/s",
    "fewer",
    "speed change",
    "growth",
    "stable",
    "worst error",
    "least gap",
    "collisions",
    "acc.",
    "jerk",
    "airtime/s",
)

_SHORT = {
    "sender": "sender",
    "loss": "loss\n[%]",
    "messages/s": "sent\n[1/s]",
    "fewer": "fewer\n[%]",
    "speed change": "speed\n[%]",
    "growth": "growth",
    "stable": "stable\n[%]",
    "least gap": "gap\n[m]",
    "collisions": "collided",
}
"""What the terminal has room for, and its headings there."""

_MEANING = (
    f"fewer: messages, speed: change of the followers' speeds, both against {REFERENCE} without loss. "
    "growth: largest spacing error of the second follower and those behind over the first's, mean over "
    "platoons; stable: platoons in which it is at most 1. gap: the least. collided: followers. "
    "table.md says more."
)


def sender_label(row: Row) -> str:
    """Return how a row's sender is called.

    Parameters
    ----------
    row
        Any.
    """
    return row.sender if row.threshold_m is None else f"{row.sender}, {centimetres(row.threshold_m)}"


def _loss(row: Row) -> str:
    if row.sender == PERFECT:
        return "-"
    bursts = f", {row.burst_s:g} s" if row.burst_s else ""
    return f"{100 * row.loss_ratio:.4g} %{bursts}"


def _cells(row: Row) -> tuple[str, ...]:

    sent = row.sender != PERFECT
    return (
        sender_label(row),
        _loss(row),
        f"{row.rate_hz:.2f}" if sent else "-",
        f"{100 * row.fewer_messages_ratio:.1f} %" if sent else "-",
        f"{100 * row.speed_change_ratio:.2f} %",
        f"{row.spacing_amplification:.2f}",
        f"{100 * row.stable_ratio:.0f} %",
        f"{row.spacing_peak_m:.2f} m",
        f"{row.gap_min_m:.2f} m",
        f"{row.collisions}/{row.followers}",
        f"{row.acceleration_rms_mps2:.2f}",
        f"{row.jerk_rms_mps3:.2f}",
        f"{1e3 * row.airtime_per_s:.2f} ms" if sent else "-",
    )


def cruise_report(result: CruiseResult) -> RenderableType:
    """Return the table of a study, and what its columns mean.

    Parameters
    ----------
    result
        What was found.
    """
    sensor = "with a ranging sensor" if result.ranging else "all by radio"
    title = (
        f"{result.platoons} platoons of {result.vehicles} by {result.law}, {sensor}, behind {result.leader}"
    )
    shown = [_HEADINGS.index(heading) for heading in _SHORT]
    rows = [[_cells(row)[at].removesuffix(" %").removesuffix(" m") for at in shown] for row in result.rows]
    table = console_table(Cells(list(_SHORT.values()), rows, 1), title, box=box.SIMPLE_HEAD)
    return Group(table, Prose(_MEANING))


def cruise_lines(rows: Sequence[Row]) -> list[str]:
    """Return the lines of the table in Markdown.

    Parameters
    ----------
    rows
        Any rows of a study.
    """
    return Cells(_HEADINGS, [_cells(row) for row in rows], 1).markdown()

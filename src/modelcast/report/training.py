"""What a training found, for the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

from modelcast.models.profile import Profile

__all__ = ["training_report"]


def training_report(profile: Profile) -> RenderableType:
    """Messages of every sub-model alone over the baseline's, and which search each process comes from.

    Parameters
    ----------
    profile
        As ``modelcast train`` made it.
    """
    record = profile.record
    figures: Mapping[str, Any] = record["figures"]
    messages: Mapping[str, Mapping[str, Sequence[int]]] = figures["messages"]
    thresholds: Sequence[float] = figures["thresholds_m"]
    baseline = messages["baseline"]
    table = Table(
        title=f"Messages over the baseline's, counted on {figures['counted_on']}", title_justify="left"
    )
    table.add_column("sub-model")
    for protocol in baseline:
        for threshold_m in thresholds:
            table.add_column(f"{protocol}\n{100 * threshold_m:g} cm", justify="right")
    for name, rows in messages.items():
        ratios = [
            _ratio(one, base)
            for protocol, own in rows.items()
            for one, base in zip(own, baseline[protocol], strict=True)
        ]
        table.add_row(name, *ratios)
    kept = ", ".join(f"{name} by {found['kept']}" for name, found in record["processes"].items())
    return Group(table, f"bank: {profile.bank.name}", f"hyper-parameters: {kept}")


def _ratio(messages: int, baseline: int) -> str:
    return f"{messages / baseline:.3f}" if baseline else "-"

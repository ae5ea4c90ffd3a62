"""What a training found, for the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells
from modelcast.models.profile import Profile
from modelcast.models.switching import StochasticHybridSystem
from modelcast.report.console_table import console_table
from modelcast.report.literal import literal

__all__ = ["training_report"]


def training_report(profile: Profile) -> RenderableType:
    """Messages of every sub-model alone over the baseline's, and where processes and modes come from.

    Parameters
    ----------
    profile
        As ``modelcast train`` made it.
    """
    parts = _counted(profile) if "figures" in profile.record else []
    return Group(*parts, *_switching(profile))


def _switching(profile: Profile) -> list[RenderableType]:
    """A line for each switching sub-model."""
    record: dict[str, Mapping[str, Any]] = {**profile.record.get("switching", {}), **profile.added_record}
    lines: list[RenderableType] = []
    for name, found in record.items():
        model = profile.sub_model(name)
        if isinstance(model, StochasticHybridSystem):
            steps = f"{found['steps']} steps of {found['step_s']:g} s"
            lines.append(literal(f"{name}: {len(model.modes)} modes, from {steps}"))
    return lines


def _counted(profile: Profile) -> list[RenderableType]:
    """What was counted, and the searches of the processes."""
    record = profile.record
    figures: Mapping[str, Any] = record["figures"]
    messages: Mapping[str, Mapping[str, Sequence[int]]] = figures["messages"]
    thresholds: Sequence[float] = figures["thresholds_m"]
    baseline = messages["baseline"]
    levels = " / ".join(f"{100 * threshold_m:g}" for threshold_m in thresholds)
    rows = [
        [
            name,
            *(
                " / ".join(_ratio(one, base) for one, base in zip(own, baseline[protocol], strict=True))
                for protocol, own in counts.items()
            ),
        ]
        for name, counts in messages.items()
    ]
    heads = ["sub-model", *(f"{protocol}\n{levels} cm" for protocol in baseline)]
    title = f"Messages over the baseline's, counted on {figures['counted_on']}"
    table = console_table(Cells(heads, rows, 1), title)
    kept = ", ".join(f"{name} by {found['kept']}" for name, found in record.get("processes", {}).items())
    return [
        table,
        literal(f"bank: {profile.bank.name}, {profile.start}/{profile.identify}"),
        *([literal(f"hyper-parameters: {kept}")] if kept else []),
    ]


def _ratio(messages: int, baseline: int) -> str:
    return f"{messages / baseline:.2f}" if baseline else "-"

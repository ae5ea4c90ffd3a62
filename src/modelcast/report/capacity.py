"""Capacities in the terminal, as Markdown, and as bars."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import RenderableType
from rich.table import Table

from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.figures.panels import drawable, empty_figure, top_legend
from modelcast.report.literal import literal
from modelcast.report.style import PAGE_IN, model_colours, new_figure, style
from modelcast.study.network.capacity import CapacityFound

__all__ = ["capacity_console", "capacity_markdown", "plot_capacity", "write_capacity_report"]

_TITLE = (
    "Vehicles a kilometre up to which p99 of the tracking error, 50 m to 150 m apart, stays under a limit "
    "and 95 % of the pairs are tracked: the last density that held, to the first that failed"
)


def _limits(found: Sequence[CapacityFound]) -> list[float]:
    return list(dict.fromkeys(one.limit_m for one in found))


def _rows(found: Sequence[CapacityFound]) -> list[list[str]]:
    """A row a radio and policy: name, name, a cell a limit, and how busy the channel was there."""
    groups: dict[tuple[str, str], list[CapacityFound]] = {}
    for one in found:
        groups.setdefault((one.radio, one.policy), []).append(one)
    rows: list[list[str]] = []
    for (radio, policy), own in groups.items():
        last = own[-1].capacity
        busy = [probe.busy_ratio for probe in last.probes if probe.density_per_km == last.holds_per_km]
        rows.append(
            [radio, policy, *(one.capacity.text for one in own), f"{100 * busy[0]:.0f} %" if busy else "-"]
        )
    return rows


def _heads(found: Sequence[CapacityFound]) -> list[str]:
    return ["radio", "policy", *(f"p99 < {limit_m:g} m" for limit_m in _limits(found)), "channel busy there"]


def capacity_console(found: Sequence[CapacityFound]) -> RenderableType:
    """Return the table for the terminal.

    Parameters
    ----------
    found
        The capacities.
    """
    table = Table(title=_TITLE, title_justify="left")
    for number, head in enumerate(_heads(found)):
        table.add_column(head, justify="left" if number < 2 else "right")
    for cells in _rows(found):
        table.add_row(*map(literal, cells))
    return table


def capacity_markdown(found: Sequence[CapacityFound]) -> str:
    """Return the table as Markdown.

    Parameters
    ----------
    found
        The capacities.
    """
    heads = _heads(found)
    lines = [f"{_TITLE}.", "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    lines += [f"| {' | '.join(cells)} |" for cells in _rows(found)]
    return "\n".join(lines) + "\n"


def write_capacity_report(found: Sequence[CapacityFound], folder: str | Path) -> list[Path]:
    """Write ``table.md`` and the figure as PNG and SVG; return their paths.

    Parameters
    ----------
    found
        The capacities.
    folder
        An existing folder.
    """
    folder = Path(folder)
    place = folder / "table.md"
    place.write_text(capacity_markdown(found), encoding="utf-8", newline="\n")
    with style():
        return [place, *write_drawings([drawn("capacity", plot_capacity(found))], folder)]


def plot_capacity(found: Sequence[CapacityFound]) -> Figure:
    """Return bars of the density that held, with a line up to the one that failed, a panel a radio.

    Parameters
    ----------
    found
        The capacities.
    """
    radios = list(dict.fromkeys(one.radio for one in found))
    if not radios:
        return empty_figure("Nothing was sought.")
    limits_m = _limits(found)
    colours = model_colours([f"{limit_m:g} m" for limit_m in limits_m])
    policies = list(dict.fromkeys(one.policy for one in found))
    figure = new_figure(PAGE_IN, 0.9 + 0.28 * len(policies) * len(radios))
    panels = figure.subplots(len(radios), 1, squeeze=False, sharex=True)[:, 0]
    thick = 0.8 / len(limits_m)
    for axes, radio in zip(panels, radios, strict=True):
        for number, limit_m in enumerate(limits_m):
            own = {one.policy: one.capacity for one in found if (one.radio, one.limit_m) == (radio, limit_m)}
            place = np.array([policies.index(policy) for policy in own]) + (number + 0.5) * thick - 0.4
            held = np.array([capacity.holds_per_km or 0.0 for capacity in own.values()])
            name = f"{limit_m:g} m"
            axes.barh(place, held, thick, color=colours[name], label=f"p99 under {name}")
            for at, capacity in zip(place, own.values(), strict=True):
                if capacity.fails_per_km is not None:
                    ends = [capacity.holds_per_km or 0.0, capacity.fails_per_km]
                    axes.plot(ends, [at, at], color=colours[name], linewidth=1.2)
                else:
                    axes.plot(capacity.holds_per_km, at, ">", color=colours[name])
        axes.set_yticks(range(len(policies)), [drawable(policy, 30) for policy in policies])
        axes.invert_yaxis()
        axes.set_title(drawable(radio, 20))
        axes.set_xlim(left=0.0)
        axes.grid(visible=False, axis="y")
    panels[-1].set_xlabel("Vehicles a kilometre; arrow: no limit was found")
    top_legend(figure, panels[0])
    return figure

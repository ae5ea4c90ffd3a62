"""Capacities in the terminal, as Markdown, and as bars."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import RenderableType

from modelcast.core.cells import Cells
from modelcast.report.console_table import placed_table
from modelcast.report.figures.files import drawn, write_report_files
from modelcast.report.figures.panels import drawable, empty_figure, top_legend
from modelcast.report.figures.senders import threshold_text
from modelcast.report.style import PAGE_IN, model_colours, new_figure, style
from modelcast.study.network.capacity import CapacityFound
from modelcast.study.network.capacity_limits import HELD_RATIO, Limit, Probe

__all__ = ["capacity_console", "capacity_markdown", "plot_capacity", "write_capacity_report"]

_TITLE = (
    "Vehicles a kilometre up to which a limit holds: the last density that held, to the first that failed. "
    "Errors are those of pairs 50 m to 150 m apart, of which 95 % must be tracked"
)
_HEADS = (
    "limit", "radio", "policy", "threshold", "vehicles/km", "seeds that held", "at the last", "at the first",
    "channel busy", "warnings",
)  # fmt: skip
_TEXTS = 4
"""Columns of text, on the left."""

_LONGEST = 100
"""Letters of a radio's word over its panel, as many as fit."""


def _value(limit: Limit, probe: Probe | None) -> str:
    """What a limit is on at one density, its spread over the seeds, and where too few pairs are tracked."""
    if probe is None:
        return "-"
    lost = limit.quantity != "missed" and probe.held_ratio < HELD_RATIO
    tracked = f", {100 * probe.held_ratio:.0f} % tracked" if lost else ""
    least, greatest = (limit.value_text(value) for value in probe.spread)
    middle = limit.value_text(probe.value)
    spread = "" if least == greatest else f" ({least.split()[0]}-{greatest.split()[0]})"
    return f"{middle}{spread}{tracked}"


def _seeds(probe: Probe | None) -> str:
    return "-" if probe is None else f"{probe.seeds_held[0]}/{probe.seeds_held[1]}"


def _both(texts: Sequence[str]) -> str:
    return ", ".join(texts)


def _cells(one: CapacityFound) -> list[str]:
    ends = one.capacity.ends
    there = [probe for probe in ends if probe is not None]
    warned = [str(probe.warnings) for probe in there if one.limit.quantity == "missed"]
    return [
        one.limit.text,
        one.radio,
        one.policy,
        threshold_text(one.threshold_m),
        one.capacity.text,
        _both([_seeds(probe) for probe in ends]),
        *(_value(one.limit, probe) for probe in ends),
        _both([f"{100 * probe.busy_ratio:.0f} %" for probe in there]),
        _both(warned) or "-",
    ]


def _table(found: Sequence[CapacityFound]) -> Cells:
    """Heads and rows, a row a capacity, by limit; columns in which no row says anything are left out."""
    limits = list(dict.fromkeys(one.limit for one in found))
    rows = [_cells(one) for one in sorted(found, key=lambda one: limits.index(one.limit))]
    said = [n for n in range(len(_HEADS)) if any(row[n] != "-" for row in rows)]
    texts = sum(n < _TEXTS for n in said)
    return Cells([_HEADS[n] for n in said], [[row[n] for n in said] for row in rows], texts)


def capacity_console(found: Sequence[CapacityFound]) -> RenderableType:
    """Return the table for the terminal.

    Parameters
    ----------
    found
        The capacities.
    """
    every = _table(found)
    numbers = [head for head in every.heads if head not in {*_HEADS[:_TEXTS], "at the first"}]
    places: list[str] = []
    rows: list[list[str]] = []
    for cells in every.rows:
        named = dict(zip(every.heads, cells, strict=True))
        places.append(f"{named['limit']}, {named['radio']}")
        threshold = named.get("threshold", "-").replace("-", "")
        name = ", ".join(part for part in (named["policy"], threshold) if part)
        rows.append([name, *(named[head] for head in numbers)])
    return placed_table(Cells(["policy", *numbers], rows, 1), places, _TITLE, padding=(0, 0, 0, 0))


def capacity_markdown(found: Sequence[CapacityFound]) -> str:
    """Return the table as Markdown.

    Parameters
    ----------
    found
        The capacities.
    """
    return "\n".join([f"{_TITLE}.", "", *_table(found).markdown()]) + "\n"


def write_capacity_report(found: Sequence[CapacityFound], folder: str | Path) -> list[Path]:
    """Write ``table.md`` and the figure as PNG and SVG; return their paths.

    Parameters
    ----------
    found
        The capacities.
    folder
        An existing folder.
    """
    with style():
        drawing = drawn("capacity", plot_capacity(found))
    return write_report_files({"table.md": capacity_markdown(found)}, [drawing], folder)


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
    limits = list(dict.fromkeys(one.limit for one in found))
    colours = model_colours([limit.text for limit in limits])
    senders = list(dict.fromkeys((one.policy, repr(one.threshold_m)) for one in found))
    names = {
        (one.policy, repr(one.threshold_m)): f"{one.policy} {threshold_text(one.threshold_m)}".removesuffix(
            " -"
        )
        for one in found
    }
    figure = new_figure(PAGE_IN, 0.9 + 0.28 * len(senders) * len(radios))
    panels = figure.subplots(len(radios), 1, squeeze=False, sharex=True)[:, 0]
    thick = 0.8 / len(limits)
    for axes, radio in zip(panels, radios, strict=True):
        for number, limit in enumerate(limits):
            own = [one for one in found if (one.radio, one.limit) == (radio, limit)]
            rows = [senders.index((one.policy, repr(one.threshold_m))) for one in own]
            place = np.array(rows) + (number + 0.5) * thick - 0.4
            held = np.array([one.capacity.holds_per_km or 0.0 for one in own])
            axes.barh(place, held, thick, color=colours[limit.text], label=limit.text)
            for at, one in zip(place, own, strict=True):
                capacity = one.capacity
                if capacity.fails_per_km is not None:
                    ends = [capacity.holds_per_km or 0.0, capacity.fails_per_km]
                    axes.plot(ends, [at, at], color=colours[limit.text], linewidth=1.2)
                else:
                    axes.plot(capacity.holds_per_km, at, ">", color=colours[limit.text])
        axes.set_yticks(range(len(senders)), [drawable(names[sender], 30) for sender in senders])
        axes.invert_yaxis()
        axes.set_title(drawable(radio, _LONGEST))
        axes.set_xlim(left=0.0)
        axes.grid(visible=False, axis="y")
    panels[-1].set_xlabel("Vehicles a kilometre; arrow: no limit was found")
    top_legend(figure, panels[0])
    return figure

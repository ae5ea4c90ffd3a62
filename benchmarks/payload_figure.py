"""The figure of both payload benchmarks: bytes of the model against messages, tracking error and airtime."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

from modelcast.report.style import PAGE_IN, new_figure, style


class Judged(Protocol):
    """What the figure needs to know of a way to carry a model."""

    @property
    def octets(self) -> int:
        """Octets of the model."""
        ...

    @property
    def message_ratio(self) -> Sequence[float]:
        """Messages over the baseline's, smallest threshold first."""
        ...

    @property
    def airtime_ratio(self) -> Sequence[float]:
        """Airtime over the baseline's, likewise."""
        ...

    @property
    def p90_m(self) -> float:
        """Tracking error without loss."""
        ...


def draw(groups: Mapping[str, Sequence[Judged]], path: Path, *, joined: bool, columns: int) -> None:
    """Draw the groups, joined by lines or as single points, over a legend of so many columns."""
    panels = (
        ("messages, ratio to the baseline at 20 cm", lambda one: one.message_ratio[0]),
        ("p90 of the tracking error without loss, 20 cm [m]", lambda one: one.p90_m),
        ("airtime, ratio to the baseline at 20 cm", lambda one: one.airtime_ratio[0]),
    )
    with style():
        figure = new_figure(PAGE_IN, 2.6)
        for axes, (title, value) in zip(figure.subplots(1, len(panels)), panels, strict=True):
            for label, choices in groups.items():
                own = sorted(choices, key=lambda one: one.octets)
                places = [one.octets for one in own], [value(one) for one in own]
                axes.plot(*places, marker="o", ms=3, lw=0.9 if joined else 0, label=label)
            axes.set_xlabel("model in the message [bytes]")
            axes.set_title(title, fontsize=7)
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=columns)
        figure.savefig(path, dpi=200)

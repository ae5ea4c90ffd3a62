"""The figure: speeds of all vehicles, a panel a case."""

from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

from modelcast import PlatoonTrace
from sumo_cacc.loop import Case


def draw(traces: Mapping[Case, PlatoonTrace], path: Path) -> None:
    """Draw the speeds.

    Parameters
    ----------
    traces
        What the platoons drove.
    path
        The picture.
    """
    losses = list(dict.fromkeys(case.loss_ratio for case in traces))
    senders = list(dict.fromkeys(case.sender for case in traces))
    figure = Figure(figsize=(3.6 * len(senders), 2.6 * len(losses)), layout="constrained")
    panels = figure.subplots(len(losses), len(senders), sharex=True, sharey=True, squeeze=False)
    for case, trace in traces.items():
        panel = panels[losses.index(case.loss_ratio), senders.index(case.sender)]
        number = trace.speed_mps.shape[2]
        for place in range(number):
            color = str(0.75 * place / number)
            panel.plot(trace.t_s, 3.6 * trace.speed_mps[:, 0, place], color=color, linewidth=0.8)
        panel.set_title(f"{case.sender}, {case.loss_ratio:.0%} lost", fontsize="medium")
    for panel in panels[-1]:
        panel.set_xlabel("time [s]")
    for panel in panels[:, 0]:
        panel.set_ylabel("speed [km/h]")
    figure.suptitle("Speeds in SUMO, the leader black, the last light", fontsize="medium")
    figure.savefig(path, dpi=150)

"""The drawings of the pages: ``docs/images/*.svg``, and ``idea.png`` for who reads no SVG.

``python tools/drawings.py`` makes them anew: the idea from a generated drive that is evaluated, the gains
from the mean row that ``validation/judged.py`` wrote into ``docs/results.md``, and who does what.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

import modelcast
from modelcast.report.style import FAINT, INK, PAGE_IN, POLICY_COLOURS, new_figure, style

__all__ = ["main"]

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
RESULTS = ROOT / "docs" / "results.md"

THRESHOLD_M = 0.5
FROM_S, TO_S = 24.0, 54.0
"""A part of the drive with a stop, a start and a turn."""
SEED = 3

_ROWS = (
    ("baseline", "coasts straight on\n(constant velocity)"),
    ("mbc", "coasts speed-up and turn too\n(free)"),
)


def _idea() -> Figure:
    """Errors that grow until a message resets them, for two receivers, and where on the road that was."""
    drive = modelcast.generate_drive(seed=SEED, duration_s=90.0).truth
    bank = modelcast.bank_from_text("free")
    settings = modelcast.EvaluationSettings(
        (THRESHOLD_M,), (0.0,), bank=bank, seeds=1, references=False, keep_alive_s=None
    )
    result = modelcast.evaluate(drive, settings)
    figure = new_figure(PAGE_IN, 2.9)
    grid = figure.add_gridspec(2, 3)
    road = figure.add_subplot(grid[:, 0])
    errors = [figure.add_subplot(grid[row, 1:]) for row in range(2)]
    shown = (drive.t_s >= FROM_S) & (drive.t_s < TO_S)
    road.plot(*drive.position_m[shown].T, color=FAINT, linewidth=4.0, solid_capstyle="round")
    for axes, (policy, says), marker in zip(errors, _ROWS, ("D", "o"), strict=True):
        colour = POLICY_COLOURS[policy]
        messages = _times(result.events, policy)
        places = drive.position_m[np.searchsorted(drive.t_s, messages - 0.01)]
        apart = np.array([0.0, 0.0]) if policy == "baseline" else np.array([7.0, 0.0])
        road.plot(*(places + apart).T, marker, color=colour, markersize=4.0)
        rows = result.samples.filter(policy=policy, packet_error_ratio=0.0)
        t_s, error_m = rows["t_s"].to_numpy(), rows["tracking_error_before_m"].fill_null(0.0).to_numpy()
        part = (t_s >= FROM_S) & (t_s < TO_S)
        axes.axhline(100.0 * THRESHOLD_M, color=INK, linewidth=0.8, linestyle="--")
        axes.plot(t_s[part] - FROM_S, 100.0 * error_m[part], color=colour)
        axes.plot(messages - FROM_S, np.full(messages.size, -6.0), marker, color=colour, markersize=4.0)
        axes.set_ylim(-14.0, 100.0)
        axes.set_xlim(0.0, TO_S - FROM_S)
        axes.set_ylabel("error [cm]")
        axes.set_title(f"{says.replace(chr(10), ' ')}: {messages.size} messages", fontsize=8, loc="left")
    errors[0].tick_params(labelbottom=False)
    errors[1].set_xlabel("time [s]; a mark is a message, the dashed line the threshold")
    road.set_aspect("equal", adjustable="datalim")
    road.set_title("30 s of a drive, seen from above", fontsize=8, loc="left")
    road.set_xlabel("east [m]")
    road.set_ylabel("north [m]")
    return figure


def _times(events: Any, policy: str) -> np.ndarray:
    """Return when a policy sent within the part that is shown, (M,) [s]."""
    t_s = events.filter(policy=policy)["t_s"].to_numpy()
    return t_s[(t_s >= FROM_S) & (t_s < TO_S)]


def _gains() -> Figure:
    """Messages over constant velocity's, from the mean row of the page of results."""
    text = RESULTS.read_text(encoding="utf-8").partition("<!-- begin halves messages -->")[2]
    rows = [re.split(r"\s*\|\s*", line.strip("| ")) for line in text.splitlines() if line.startswith("| ")]
    head, mean = rows[0], next(row for row in rows if row[0] == "mean")
    found = {
        name: float(cell.split("/")[0]) for name, cell in zip(head[1:], mean[1:], strict=True) if "/" in cell
    }
    bars = {
        "plain message, receiver coasts straight on\n(constant velocity)": 1.0,
        "the paper's bank\n(Gaussian process + constant velocity)": found["paper"],
        "plain message, receiver coasts it well\n(free)": found["free"],
        "free, and the sender chooses the values\n(what ships)": found["default"],
        "a bound: a sender that knows the future": found["parabolas that know the future"],
    }
    figure = new_figure(PAGE_IN, 2.4)
    axes = figure.add_subplot()
    colours = [
        POLICY_COLOURS["baseline"],
        FAINT,
        POLICY_COLOURS["baseline-periodic"],
        POLICY_COLOURS["mbc"],
        FAINT,
    ]
    places = np.arange(len(bars))[::-1]
    axes.barh(places, list(bars.values()), color=colours, height=0.62)
    for place, value in zip(places, bars.values(), strict=True):
        axes.text(value + 0.01, float(place), f"{value:.2f}", va="center", fontsize=8)
    axes.set_yticks(places, list(bars))
    axes.set_xlim(0.0, 1.16)
    axes.set_xlabel("messages over those of constant velocity, threshold 20 cm, mean of nine sources")
    axes.grid(visible=False)
    return figure


def _loop() -> Figure:
    """Draw who does what: sender, air, receiver."""
    figure = Figure(figsize=(PAGE_IN, 2.5))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(0.0, 36.0)
    axes.axis("off")
    _box(axes, (1.0, 1.0), (40.0, 34.0), "sender", fill="#f4f7fa")
    _box(axes, (62.0, 1.0), (37.0, 34.0), "every receiver in range", fill="#f4f7fa")
    _box(axes, (3.0, 19.0), (16.0, 10.0), "its own motion\nGPS and bus, 10 Hz")
    _box(axes, (23.0, 19.0), (16.0, 10.0), "copy of what the\nreceivers believe")
    _box(axes, (11.0, 4.0), (20.0, 9.0), "apart by more than\nthe threshold? speak")
    _box(axes, (45.0, 6.0), (13.0, 9.0), "radio\nmay lose it")
    _box(axes, (65.0, 4.0), (14.0, 12.0), "last message\n+ its age")
    _box(axes, (82.0, 4.0), (14.0, 12.0), "map of others\nat any time")
    _box(axes, (82.0, 21.0), (14.0, 8.0), "warnings")
    arrows = (
        ((11.0, 19.0), (18.0, 13.2)),
        ((31.0, 19.0), (24.0, 13.2)),
        ((31.0, 9.0), (44.8, 10.0)),
        ((58.0, 10.5), (64.8, 10.5)),
        ((79.0, 10.0), (81.8, 10.0)),
        ((89.0, 16.0), (89.0, 20.8)),
    )
    for begin, end in arrows:
        axes.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 0.9})
    back = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "linestyle": "--"}
    axes.annotate("", (34.0, 18.8), (34.0, 9.4), arrowprops=back)
    axes.text(34.6, 13.0, "what\nwas sent", fontsize=6.5, va="center")
    return figure


def _box(
    axes: Axes, corner: tuple[float, float], size: tuple[float, float], text: str, *, fill: str = "white"
) -> None:
    """Draw a box with its text: a frame's at its top, another's in its middle."""
    (left, bottom), (width, height) = corner, size
    frame = fill != "white"
    shape = "round,pad=0,rounding_size=1.2"
    axes.add_patch(FancyBboxPatch(corner, width, height, boxstyle=shape, facecolor=fill, edgecolor="#555555"))
    place = (left + width / 2, bottom + height - 2.5 if frame else bottom + height / 2)
    axes.text(*place, text, ha="center", va="center", fontsize=8 if frame else 7.5, color=INK)


def main() -> None:
    """Make every drawing."""
    IMAGES.mkdir(exist_ok=True)
    for name, draw in (("idea", _idea), ("gains", _gains), ("loop", _loop)):
        with style():
            figure = draw()
            figure.savefig(IMAGES / f"{name}.svg", metadata={"Date": None, "Creator": None})
            if name == "idea":
                figure.savefig(IMAGES / f"{name}.png", dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    main()

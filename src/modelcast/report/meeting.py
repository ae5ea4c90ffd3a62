"""The film of a meeting as files."""

from collections.abc import Mapping
from pathlib import Path

from modelcast.channel.propagation import StreetGrid
from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.figures.meeting import plot_meeting
from modelcast.report.style import style
from modelcast.study.network.meeting import Meeting, Seen

__all__ = ["draw_meeting"]


def draw_meeting(meeting: Meeting, runs: Mapping[str, Seen], streets: StreetGrid, folder: Path) -> None:
    """Write the figure ``film`` as PNG, SVG and PDF.

    Parameters
    ----------
    meeting, runs, streets
        As for `modelcast.report.figures.meeting.plot_meeting`.
    folder
        Where to.
    """
    with style():
        write_drawings([drawn("film", plot_meeting(meeting, runs, streets))], folder)

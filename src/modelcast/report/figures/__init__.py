"""The six figures of an evaluation and the one of a comparison: functions from a result to a figure.

They draw whatever a result holds: one threshold, one packet error ratio, one trip or one seed. Where the
data of a figure is missing altogether, the figure says so.
"""

from modelcast.report.figures.comparison import plot_comparison
from modelcast.report.figures.distribution import plot_distribution
from modelcast.report.figures.files import FIGURES, Drawing, draw_figures, write_drawings, write_figures
from modelcast.report.figures.loss import plot_loss
from modelcast.report.figures.manoeuvre import plot_manoeuvre
from modelcast.report.figures.rates import plot_rates
from modelcast.report.figures.timeline import plot_timeline
from modelcast.report.figures.trips import plot_trips

__all__ = [
    "FIGURES",
    "Drawing",
    "draw_figures",
    "plot_comparison",
    "plot_distribution",
    "plot_loss",
    "plot_manoeuvre",
    "plot_rates",
    "plot_timeline",
    "plot_trips",
    "write_drawings",
    "write_figures",
]

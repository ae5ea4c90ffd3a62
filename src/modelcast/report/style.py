"""How every figure looks: one set of Matplotlib parameters, one colour for each policy and sub-model.

Figures are made for print: 3.5 in (one column) or 7.16 in (two columns) wide, text from 6 to 8 points at
that size. Policies take their colours from Okabe and Ito, sub-models from Tol's muted set, so that both can
be told apart with impaired colour vision; line styles and markers repeat the distinction in grey.

References
----------
M. Okabe, K. Ito, "Color Universal Design", 2008. P. Tol, "Colour Schemes", SRON/EPS/TN/09-002, 2021.
"""

from collections.abc import Generator, Sequence
from contextlib import contextmanager

import matplotlib as mpl
from matplotlib.figure import Figure

__all__ = [
    "COLUMN_IN",
    "FAINT",
    "IDENTIFICATION_COLOUR",
    "INK",
    "PAGE_IN",
    "POLICY_COLOURS",
    "POLICY_LINES",
    "POLICY_MARKERS",
    "model_colours",
    "new_figure",
    "style",
]

COLUMN_IN = 3.5
"""Width of a figure in one column [in]."""

PAGE_IN = 7.16
"""Width of a figure across two columns [in]."""

INK = "#222222"
FAINT = "#c9c9c9"

POLICY_COLOURS = {
    "mbc": "#0072b2",
    "baseline": "#e69f00",
    "baseline-matched": "#d55e00",
    "baseline-periodic": "#009e73",
    "free": "#cc79a7",
    "free-matched": "#cc79a7",
}
IDENTIFICATION_COLOUR = "#56b4e9"
POLICY_LINES = {
    "mbc": "-",
    "baseline": "-.",
    "baseline-matched": "--",
    "baseline-periodic": ":",
    "free": "--",
    "free-matched": "-.",
}
POLICY_MARKERS = {
    "mbc": "o",
    "baseline": "D",
    "baseline-matched": "s",
    "baseline-periodic": "^",
    "free": "v",
    "free-matched": "P",
}

_MODEL_COLOURS = ("#999933", "#882255", "#88ccee", "#332288", "#cc6677", "#117733")

_PARAMETERS = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#555555",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 8.0,
    # No ticks on top, so Matplotlib need not search for a free place at every draw.
    "axes.titley": 1.0,
    "figure.constrained_layout.h_pad": 0.04,
    "figure.constrained_layout.w_pad": 0.04,
    "figure.titlesize": 8.5,
    "figure.dpi": 200,
    "font.family": ["DejaVu Sans"],
    "font.size": 7.5,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.5,
    "hatch.linewidth": 0.5,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "lines.linewidth": 1.3,
    "lines.markersize": 3.5,
    # Whole letters instead of drawings of them: what publishers ask for.
    "pdf.fonttype": 42,
    "savefig.dpi": 200,
    "svg.fonttype": "path",
    "svg.hashsalt": "modelcast",
    # A trip's name may hold a dollar sign.
    "text.parse_math": False,
    "xtick.color": "#444444",
    "xtick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.color": "#444444",
    "ytick.labelsize": 7.0,
    "ytick.major.width": 0.6,
    "ytick.minor.width": 0.4,
}


@contextmanager
def style() -> Generator[None]:
    """Use modelcast's parameters inside the block, whatever the user's own ``matplotlibrc`` says."""
    ours = {**mpl.rcParamsDefault, **_PARAMETERS}
    # The backend is the user's affair: a figure here is saved, never shown.
    ours = {
        key: value for key, value in ours.items() if not key.startswith(("backend", "webagg", "interactive"))
    }
    with mpl.rc_context(ours):
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure with constrained layout, outside pyplot's registry.

    Parameters
    ----------
    width_in, height_in
        Size [in].
    """
    return Figure(figsize=(width_in, height_in), layout="constrained")


def model_colours(names: Sequence[str]) -> dict[str, str]:
    """Return a colour for each sub-model, by its place in the bank; ``free`` has the free receiver's.

    Parameters
    ----------
    names
        The sub-models in the bank's order.
    """
    colours = {name: _MODEL_COLOURS[at % len(_MODEL_COLOURS)] for at, name in enumerate(names)}
    return colours | {name: POLICY_COLOURS["free"] for name in names if name == "free"}

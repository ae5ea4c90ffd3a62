"""Boxes and arrows: what the diagrams of the system are drawn with."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon

from modelcast.report.style import INK

__all__ = ["Box", "code_name", "diagram_axes", "draw_arrow", "draw_box"]

_LINE = 3.1
"""Height of a line of a box's small text, in the diagram's units."""

_SIZES = {"title": 7.0, "line": 5.8, "name": 5.2, "module": 4.3}
_CODE = {"name", "module"}


@dataclass(frozen=True, slots=True)
class Box:
    """A box of a diagram.

    Parameters
    ----------
    title
        Bold, above the rest.
    lines
        Small lines below.
    code
        The code's own parts that do it; their names are written at the bottom.
    x, y, width, height
        Middle and size, in the diagram's units.
    is_question
        Whether it is a question: drawn as a diamond.
    colour
        Of its edge.
    fill
        Of its inside.
    """

    title: str
    lines: tuple[str, ...] = ()
    code: tuple[object, ...] = ()
    _: KW_ONLY
    x: float
    y: float
    width: float
    height: float
    is_question: bool = False
    colour: str = "#555555"
    fill: str = "#ffffff"

    @property
    def left(self) -> tuple[float, float]:
        """Middle of the left edge."""
        return self.x - self.width / 2, self.y

    @property
    def right(self) -> tuple[float, float]:
        """Middle of the right edge."""
        return self.x + self.width / 2, self.y

    @property
    def top(self) -> tuple[float, float]:
        """Middle of the upper edge."""
        return self.x, self.y + self.height / 2

    @property
    def bottom(self) -> tuple[float, float]:
        """Middle of the lower edge."""
        return self.x, self.y - self.height / 2


def code_name(thing: object) -> str:
    """The name by which a part of modelcast is found, without the package's own.

    Parameters
    ----------
    thing
        A class, a method or a function.

    Examples
    --------
    >>> from modelcast.station.policy.error_driven import ErrorDriven
    >>> code_name(ErrorDriven.decide)
    'station.policy.error_driven.ErrorDriven.decide'
    """
    module = str(getattr(thing, "__module__", "")).removeprefix("modelcast.")
    return f"{module}.{getattr(thing, '__qualname__', '')}"


def diagram_axes(figure: Figure, width: float, height: float) -> Axes:
    """Return axes that fill a figure, in units of a diagram and without a frame.

    Parameters
    ----------
    figure
        An empty figure.
    width, height
        Of the diagram.
    """
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    axes.axis("off")
    return axes


def draw_box(axes: Axes, box: Box) -> None:
    """Draw a box with its texts.

    Parameters
    ----------
    axes
        As `diagram_axes` returns them.
    box
        The box.
    """
    if box.is_question:
        corners = (box.left, box.top, box.right, box.bottom)
        axes.add_patch(Polygon(corners, closed=True, facecolor=box.fill, edgecolor=box.colour, linewidth=0.9))
    else:
        corner = (box.x - box.width / 2, box.y - box.height / 2)
        shape = "round,pad=0,rounding_size=1.2"
        axes.add_patch(
            FancyBboxPatch(
                corner,
                box.width,
                box.height,
                boxstyle=shape,
                facecolor=box.fill,
                edgecolor=box.colour,
                linewidth=0.9,
            )
        )
    rows: Sequence[tuple[str, str]] = [
        (box.title, "title"),
        *((line, "line") for line in box.lines),
        *(row for thing in box.code for row in _code_rows(thing)),
    ]
    first = box.y + _LINE * (len(rows) - 1) / 2
    for at, (text, kind) in enumerate(rows):
        axes.text(
            box.x,
            first - at * _LINE,
            text,
            ha="center",
            va="center",
            fontsize=_SIZES[kind],
            fontweight="bold" if kind == "title" else "normal",
            fontfamily="DejaVu Sans Mono" if kind in _CODE else "DejaVu Sans",
            color="#555555" if kind in _CODE else INK,
        )


def _code_rows(thing: object) -> tuple[tuple[str, str], ...]:
    """The name of a part, and below it the module it is in."""
    qualified = str(getattr(thing, "__qualname__", ""))
    module = code_name(thing).removesuffix(f".{qualified}")
    return (qualified, "name"), (module, "module")


def draw_arrow(axes: Axes, path: Sequence[tuple[float, float]], label: str = "") -> None:
    """Draw an arrow along corners, with a label beside its first stretch.

    Parameters
    ----------
    axes
        As `diagram_axes` returns them.
    path
        Two points or more.
    label
        Small text.
    """
    *start, before, end = path
    corners = [*start, before]
    if len(corners) > 1:
        axes.plot(*zip(*corners, strict=True), color=INK, linewidth=0.9, solid_capstyle="butt")
    axes.annotate(
        "",
        xy=end,
        xytext=before,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "shrinkA": 0.0, "shrinkB": 0.0},
    )
    if label:
        (x0, y0), (x1, y1) = path[0], path[1]
        upright = abs(x1 - x0) < abs(y1 - y0)
        axes.text(
            (x0 + x1) / 2 + (0.8 if upright else 0.0),
            (y0 + y1) / 2 + (0.0 if upright else 0.8),
            label,
            ha="left" if upright else "center",
            va="center" if upright else "bottom",
            fontsize=5.8,
            color=INK,
        )

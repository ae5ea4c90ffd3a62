"""The figures as files: each is laid out and drawn once, and saved as PNG, SVG and PDF."""

import io
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from modelcast.core.doing import doing
from modelcast.report.figures.distribution import plot_distribution
from modelcast.report.figures.loss import plot_loss
from modelcast.report.figures.manoeuvre import plot_manoeuvre
from modelcast.report.figures.rates import plot_rates
from modelcast.report.figures.timeline import plot_timeline
from modelcast.report.figures.trips import plot_trips
from modelcast.report.style import style
from modelcast.study.result import EvaluationResult

__all__ = [
    "ENDINGS",
    "FIGURES",
    "Drawing",
    "draw_figures",
    "drawn",
    "write_drawings",
    "write_figures",
    "write_report_files",
]

FIGURES: dict[str, Callable[[EvaluationResult], Figure]] = {
    "message_rate": plot_rates,
    "tracking_distribution": plot_distribution,
    "tracking_loss": plot_loss,
    "sub_models": plot_timeline,
    "manoeuvre": plot_manoeuvre,
    "trips": plot_trips,
}
"""The figures in the order of the report, by the stem of their files."""

ENDINGS = (".png", ".svg", ".pdf")
"""Of the files of each figure: for a screen, a page and a paper."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """One figure, drawn.

    Parameters
    ----------
    name
        Key in `FIGURES`.
    png, svg, pdf
        The files' content.
    width_in, height_in
        Size on paper [in].
    """

    name: str
    png: bytes
    svg: bytes
    pdf: bytes
    width_in: float
    height_in: float

    def content(self, ending: str) -> bytes:
        """Return the content of the file with this ending.

        Parameters
        ----------
        ending
            One of `ENDINGS`.
        """
        return {".png": self.png, ".svg": self.svg, ".pdf": self.pdf}[ending]


def draw_figures(result: EvaluationResult) -> list[Drawing]:
    """Return all figures, drawn.

    Parameters
    ----------
    result
        The evaluation.
    """
    with style():
        return [drawn(name, plot(result)) for name, plot in FIGURES.items()]


def write_drawings(drawings: Iterable[Drawing], folder: str | Path) -> list[Path]:
    """Write each drawing as PNG, SVG and PDF; return the paths.

    Parameters
    ----------
    drawings
        What `draw_figures` returned.
    folder
        Where to; it is created.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths: list[Path] = []
    for drawing in drawings:
        for ending in ENDINGS:
            paths.append(folder / f"{drawing.name}{ending}")
            paths[-1].write_bytes(drawing.content(ending))
    return paths


def write_report_files(
    texts: Mapping[str, str], drawings: Iterable[Drawing], folder: str | Path, *, figures: str = ""
) -> list[Path]:
    """Write the texts of a report and its drawings; return the paths, the texts' first.

    Parameters
    ----------
    texts
        By the names of their files.
    drawings
        As for `write_drawings`.
    folder
        An existing folder.
    figures
        Name of the folder in it for the drawings; empty for none of their own.
    """
    pages = {Path(folder) / name: text for name, text in texts.items()}
    for path, text in pages.items():
        path.write_text(text, encoding="utf-8", newline="\n")
    return [*pages, *write_drawings(drawings, Path(folder) / figures)]


def write_figures(result: EvaluationResult, folder: str | Path) -> list[Path]:
    """Draw all figures and write each as PNG (200 dpi), SVG and PDF; return the paths.

    Parameters
    ----------
    result
        The evaluation.
    folder
        Where to; it is created.
    """
    return write_drawings(draw_figures(result), folder)


def drawn(name: str, figure: Figure) -> Drawing:
    """Return a figure laid out once, as the content of its files; call it inside `style`.

    Parameters
    ----------
    name
        Stem of the files.
    figure
        The figure; it is not to be changed afterwards.
    """
    doing(name)
    png, svg, pdf = io.BytesIO(), io.BytesIO(), io.BytesIO()
    # With a layout engine in place, Matplotlib would lay out and draw each file twice.
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    # No software version and no date: the same result gives the same bytes.
    figure.savefig(png, format="png", metadata={"Software": None}, pil_kwargs={"compress_level": 3})
    figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    figure.savefig(pdf, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    width_in, height_in = (float(size) for size in figure.get_size_inches())
    return Drawing(name, png.getvalue(), svg.getvalue(), pdf.getvalue(), width_in, height_in)

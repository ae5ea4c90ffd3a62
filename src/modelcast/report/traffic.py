"""The hybrid against the error-driven baseline in traffic, for people: verdicts, a page, four figures."""

from collections.abc import Sequence
from pathlib import Path

from modelcast.core.cells import Cells, escape, number
from modelcast.report.figures.files import drawn, write_report_files
from modelcast.report.figures.senders import density_text, threshold_text
from modelcast.report.figures.traffic import TRAFFIC_FIGURES
from modelcast.report.page import CSS, figure, page
from modelcast.report.style import style
from modelcast.study.network.densities import counted_verdicts
from modelcast.study.network.rows import RUNS
from modelcast.study.table import Row, quantity

__all__ = ["traffic_markdown", "traffic_section", "write_traffic_report"]

_SCOPE = (
    "The hybrid (mbc) against the error-driven baseline at the same threshold: mbc / baseline, then the "
    "difference within seeds with half of its 95 % interval (Student-t). A verdict needs an interval that "
    "leaves zero out; where nothing differs, one in twenty has one by chance. Collided: of frames at "
    "vehicles 50 m to 150 m away; a second: collided frames of one such remote."
)
_COLLIDED = quantity("collision_rate_hz", "1/s", "Collided frames of a remote.", heading="collided a second")
_COLUMNS = (
    *(RUNS[name] for name in ("message_rate_hz", "bytes_per_s", "busy_ratio", "collision_ratio")),
    _COLLIDED,
    *(RUNS[name] for name in ("delivery_ratio", "pte_p90_m", "pte_p99_m")),
)
_VERDICTS = (
    ("collision_ratio", "collisions by share"),
    ("collision_rate_hz", "collisions a second"),
    ("busy_ratio", "busy ratio"),
)
_HEADS = (
    "density",
    "radio",
    "bank",
    "threshold",
    "seeds",
    *(column.shown_heading for column in _COLUMNS),
    *(title for _, title in _VERDICTS),
)


def _cell(row: Row, factor: float) -> str:
    text = f"{number(factor * row.hybrid)} / {number(factor * row.baseline)}"
    if row.difference_low is None or row.difference_high is None:
        return text
    half = 0.5 * (row.difference_high - row.difference_low)
    sign = "-" if row.difference < 0.0 else "+"
    return f"{text} ({sign}{number(abs(factor * row.difference), 2)} ± {number(factor * half, 2)})"


def _cells(rows: Sequence[Row]) -> Cells:
    groups: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in rows:
        if not row.by_range:
            density, threshold = density_text(row.density_per_km), threshold_text(row.threshold_m)
            key = (density, row.radio, row.bank, threshold)
            groups.setdefault(key, {})[row.figure] = row
    cells = [
        [
            *key,
            str(own["collision_ratio"].seeds if "collision_ratio" in own else 0),
            *(_cell(own[column.name], column.factor) if column.name in own else "-" for column in _COLUMNS),
            *(own[name].verdict if name in own else "-" for name, _ in _VERDICTS),
        ]
        for key, own in groups.items()
    ]
    return Cells(_HEADS, cells, 4)


def _told(rows: Sequence[Row]) -> list[str]:
    """How often the hybrid has fewer, a line a radio and figure."""
    return [
        f"{radio}, {title}: " + ", ".join(f"{verdict} {count}" for verdict, count in sorted(counts.items()))
        for radio in sorted({row.radio for row in rows})
        for name, title in _VERDICTS
        if (counts := counted_verdicts(rows, name, radio))
    ]


def traffic_markdown(rows: Sequence[Row]) -> str:
    """Return the verdicts and their figures as Markdown.

    Parameters
    ----------
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them.
    """
    lines = [_SCOPE, "", *(f"- {line}" for line in _told(rows)), ""]
    return "\n".join([*lines, *_cells(rows).markdown()]) + "\n"


def traffic_section(rows: Sequence[Row]) -> str:
    """Return verdicts and table as markup, for a page.

    Parameters
    ----------
    rows
        As for `traffic_markdown`.
    """
    return "\n".join(
        [
            "<h2>In traffic</h2>",
            f'<p class="scope">{escape(_SCOPE)}</p>',
            "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in _told(rows)) + "</ul>",
            _cells(rows).html(),
        ]
    )


def write_traffic_report(rows: Sequence[Row], folder: str | Path) -> list[Path]:
    """Write ``traffic.md``, ``traffic.html`` and the figures of the first bank; return their paths.

    Parameters
    ----------
    rows
        As for `traffic_markdown`; at least one.
    folder
        An existing folder.
    """
    bank = rows[0].bank
    own = [row for row in rows if row.bank == bank]
    with style():
        drawings = [drawn(name, plot(own)) for name, (_, plot) in TRAFFIC_FIGURES.items()]
    body = [
        "<h1>The hybrid against the baseline in traffic</h1>",
        traffic_section(rows),
        f'<p class="note">Figures: bank {escape(bank)}.</p>',
    ]
    body += [figure(f"{name}.svg", caption) for name, (caption, _) in TRAFFIC_FIGURES.items()]
    html = page("modelcast: the hybrid in traffic", CSS, body)
    return write_report_files({"traffic.md": traffic_markdown(rows), "traffic.html": html}, drawings, folder)

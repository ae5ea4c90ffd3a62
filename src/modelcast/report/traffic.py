"""The hybrid against the error-driven baseline in traffic, for people: verdicts, a page, four figures."""

from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from modelcast.core.cells import escape, html_table, markdown, number
from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.figures.senders import threshold_text
from modelcast.report.figures.traffic import TRAFFIC_FIGURES
from modelcast.report.page import CSS, page
from modelcast.report.style import style
from modelcast.study.network.densities import counted_verdicts
from modelcast.study.table import Row

__all__ = ["traffic_markdown", "traffic_section", "write_traffic_report"]

_SCOPE = (
    "The hybrid (mbc) against the error-driven baseline at the same threshold: mbc / baseline, then the "
    "difference within seeds with half of its 95 % interval (Student-t). A verdict needs an interval that "
    "leaves zero out; where nothing differs, one in twenty has one by chance. Collided: of frames at "
    "vehicles 50 m to 150 m away; a second: collided frames of one such remote."
)
_COLUMNS = (
    ("message_rate_hz", "messages [1/s]", 1.0),
    ("bytes_per_s", "bytes/s", 1.0),
    ("busy_ratio", "CBR [%]", 100.0),
    ("collision_ratio", "collided [%]", 100.0),
    ("collision_rate_hz", "collided a second", 1.0),
    ("delivery_ratio", "received [%]", 100.0),
    ("pte_p90_m", "PTE p90 [m]", 1.0),
    ("pte_p99_m", "PTE p99 [m]", 1.0),
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
    *(title for _, title, _ in _COLUMNS),
    *(title for _, title in _VERDICTS),
)


def _cell(row: Row, factor: float) -> str:
    text = f"{number(factor * row.hybrid)} / {number(factor * row.baseline)}"
    if row.difference_low is None or row.difference_high is None:
        return text
    half = 0.5 * (row.difference_high - row.difference_low)
    sign = "-" if row.difference < 0.0 else "+"
    return f"{text} ({sign}{number(abs(factor * row.difference), 2)} ± {number(factor * half, 2)})"


def _cells(rows: Sequence[Row]) -> list[list[str]]:
    groups: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in rows:
        if not row.by_range:
            density = f"{row.density_per_km:g}" if isfinite(row.density_per_km) else "-"
            key = (density, row.radio, row.bank, threshold_text(row.threshold_m))
            groups.setdefault(key, {})[row.figure] = row
    return [
        [
            *key,
            str(own["collision_ratio"].seeds if "collision_ratio" in own else 0),
            *(_cell(own[name], factor) if name in own else "-" for name, _, factor in _COLUMNS),
            *(own[name].verdict if name in own else "-" for name, _ in _VERDICTS),
        ]
        for key, own in groups.items()
    ]


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
    lines += [_joined(_HEADS), "|" + "---|" * len(_HEADS)]
    lines += [_joined(cells) for cells in _cells(rows)]
    return "\n".join(lines) + "\n"


def _joined(cells: Sequence[str]) -> str:
    return "| " + " | ".join(map(markdown, cells)) + " |"


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
            html_table(_HEADS, _cells(rows), text_columns=4),
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
    folder = Path(folder)
    bank = rows[0].bank
    own = [row for row in rows if row.bank == bank]
    with style():
        drawings = [drawn(name, plot(own)) for name, (_, plot) in TRAFFIC_FIGURES.items()]
    body = [
        "<h1>The hybrid against the baseline in traffic</h1>",
        traffic_section(rows),
        f'<p class="note">Figures: bank {escape(bank)}.</p>',
    ]
    for drawing, (caption, _) in zip(drawings, TRAFFIC_FIGURES.values(), strict=True):
        body.append(
            f'<figure><img src="{drawing.name}.svg" alt="{escape(caption)}">'
            f"<figcaption>{escape(caption)}</figcaption></figure>"
        )
    text, html = folder / "traffic.md", folder / "traffic.html"
    text.write_text(traffic_markdown(rows), encoding="utf-8", newline="\n")
    html.write_text(page("modelcast: the hybrid in traffic", CSS, body), encoding="utf-8", newline="\n")
    return [text, html, *write_drawings(drawings, folder)]

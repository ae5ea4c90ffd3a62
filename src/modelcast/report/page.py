"""An HTML page, with every string escaped."""

import re
from collections.abc import Iterable, Sequence

from modelcast.core.cells import escape
from modelcast.report.figures.files import Drawing
from modelcast.report.scripts import content_policy, script, static_text
from modelcast.report.svg_address import svg_address

__all__ = ["CSS", "embedded_figure", "figure", "findings_paragraphs", "page"]

_UNIT = re.compile(r"(?<=\d) (?=(?:%|°/s|cm|m|m/s|m/s²|km|s|min|h)(?![\w/]))")  # the blank before a unit

CSS = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; color: #222;
  background: #fff; max-width: 62rem; margin: 2rem auto; padding: 0 1.25rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; margin: 0 0 .25rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid #ddd; padding-bottom: .2rem; }
h3 { font-size: .95rem; margin: 1.4rem 0 .2rem; }
.scope { color: #555; margin: 0 0 .75rem; }
.finding { max-width: 46rem; }
.note { color: #555; font-size: .85rem; }
.wide { overflow-x: auto; }
@media screen and (min-width: 66rem) { .wide { width: fit-content; max-width: calc(50vw + 28rem); } }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; margin: .4rem 0; }
th, td { padding: .22rem .55rem; text-align: right; vertical-align: top; border-bottom: 1px solid #eee; }
th { font-weight: 600; vertical-align: bottom; border-bottom: 1px solid #999; }
th.text, td.text { text-align: left; overflow-wrap: anywhere; min-width: 4.5rem; }
td.text:first-child { min-width: 6rem; }
td:not(.text) { white-space: nowrap; }
.settings td:first-child { white-space: nowrap; }
tbody tr:nth-child(even) { background: #f7f8fa; }
figure { margin: 1.4rem 0 2rem; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .85rem; color: #444; margin-top: .5rem; max-width: 46rem; }
:focus-visible { outline: 3px solid #0072b2; outline-offset: 2px; }
summary { cursor: pointer; font-weight: 600; margin: .4rem 0; }
@media print {
  @page { margin: 15mm; }
  body { max-width: none; margin: 0; padding: 0; font-size: 10pt; }
  figure, tr { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
  thead { display: table-header-group; }
  table { font-size: 6.5pt; }
  th, td { padding: .1rem .25rem; }
  td:not(.text) { white-space: normal; }
  .wide { overflow: visible; }
}
"""


def page(title: str, css: str, body: Iterable[str], scripts: Sequence[str] = ()) -> str:
    """Return a whole document; the parts of the body are markup already.

    Its figures open in a dialog by tap or key, where scripts run.

    Parameters
    ----------
    title
        Plain text.
    css
        The style sheet.
    body
        Parts of the body, in order.
    scripts
        Texts of scripts that run once the body is there.
    """
    run = (script("scrollable.js", "enlarge.js"), *scripts)
    shared = static_text("scrollable.css") + static_text("enlarge.css")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{content_policy(run)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{css}{shared}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(part for part in body if part)
        + "\n</main>\n"
        + "".join(f"<script>{text}</script>\n" for text in run)
        + "</body>\n</html>\n"
    )


def figure(source: str, caption: str) -> str:
    """Return a figure of a page with its caption as markup.

    Parameters
    ----------
    source
        Name of the image's file, beside the page.
    caption
        Plain text.
    """
    return (
        f'<figure><img src="{escape(source)}" alt="{escape(caption)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def findings_paragraphs(findings: Iterable[tuple[str, str]]) -> list[str]:
    """Return what a report says first as markup; at the end of a line no number is parted from its unit.

    Parameters
    ----------
    findings
        A title and its sentences for each paragraph, plain text.

    Examples
    --------
    >>> (line,) = findings_paragraphs([("Found", "Of 3 cars, with 40 % lost.")])
    >>> line.replace(chr(0xA0), "~")
    '<p class="finding"><strong>Found.</strong> Of 3 cars, with 40~% lost.</p>'
    """
    return [
        f'<p class="finding"><strong>{escape(title)}.</strong> {_UNIT.sub(chr(0xA0), escape(text))}</p>'
        for title, text in findings
    ]


def embedded_figure(drawing: Drawing, place: int, title: str, caption: str) -> str:
    """Return a figure that lies in the page itself as markup.

    Parameters
    ----------
    drawing
        The figure.
    place
        Its number, from 1.
    title, caption
        Plain text.
    """
    return (
        f'<figure><img style="width:{drawing.width_in:g}in" alt="{escape(title)}" '
        f'src="{svg_address(drawing.svg)}">'
        f"<figcaption><b>Figure {place}. {escape(title)}.</b> {escape(caption)}</figcaption></figure>"
    )

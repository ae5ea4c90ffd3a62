"""The scripts of pages, and the policy that lets a browser run these and nothing else.

A page holds its scripts itself and needs no network. Its content security policy names each script by its
hash: markup that got into a page by whatever way runs nothing, and nothing is asked of anybody.

The errors of a played trip are drawn by uPlot 1.6.32 (MIT, no dependency), unchanged in ``static``: 51 kB.
Minified, Chart.js 4.6.1 has 210 kB and no zoom, the smallest of ECharts 6.1.0 500 kB, and the smallest of
Plotly 4.1.1 1.2 MB (their npm packages on 2026-11-30). The map is a canvas of our own, as on the live page.
"""

import base64
import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

__all__ = ["PLAYBACK_SCRIPTS", "content_policy", "data_block", "script", "static_text"]

PLAYBACK_SCRIPTS = (
    "uPlot.iife.min.js",
    "playback_trip.js",
    "playback_map.js",
    "playback_timeline.js",
    "playback.js",
)
"""What plays a trip, in the order it is read."""


@cache
def static_text(name: str) -> str:
    """Return the text of a file that pages are made of.

    Parameters
    ----------
    name
        Of the file in ``static``.
    """
    text = (files("modelcast.report") / "static" / name).read_text(encoding="utf-8")
    return text.replace("\r\n", "\n")


def script(*names: str) -> str:
    """Return files as one script whose names no other script sees.

    Parameters
    ----------
    names
        Of the files in ``static``, in order.
    """
    return "(() => {\n" + "\n".join(static_text(name) for name in names) + "})();\n"


def content_policy(scripts: Iterable[str]) -> str:
    """Return the content security policy of a page with these scripts.

    Parameters
    ----------
    scripts
        Their texts, exactly as they stand in the page.
    """
    hashes = (base64.b64encode(hashlib.sha256(one.encode()).digest()).decode() for one in scripts)
    named = " ".join(f"'sha256-{one}'" for one in hashes) or "'none'"
    return (
        f"default-src 'none'; script-src {named}; style-src 'unsafe-inline'; img-src 'self' file: data:; "
        "base-uri 'none'; form-action 'none'"
    )


def data_block(name: str, values: Mapping[str, Any]) -> str:
    r"""Return plain values as a block of data in a page; no text in them ends it or begins another.

    Parameters
    ----------
    name
        Its ``id``.
    values
        Plain values, all of them finite.

    Examples
    --------
    >>> print(data_block("made", {"trip": "</script><b>"}))
    <script type="application/json" id="made">{"trip":"\u003c/script>\u003cb>"}</script>
    """
    text = json.dumps(values, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{text}</script>'

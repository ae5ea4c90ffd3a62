"""How a kept result is written in a table of a page."""

from collections.abc import Mapping
from typing import Any

__all__ = ["PEERS", "Results", "job", "load", "number", "peer_row"]

Results = Mapping[str, Mapping[str, Any]]
"""What ``results.json`` holds: by benchmark, its machine, versions, date, load and records."""

PEERS = ("| job | modelcast | beside it | its cost | times | load |", "|---|--:|---|--:|--:|--:|")
"""Head of a table of `peer_row`."""


def number(value: float) -> str:
    """Three digits, or all before the point."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def load(result: Mapping[str, Any]) -> str:
    """The load average before a benchmark, per core."""
    average = result["load_average"]
    return "unknown" if average is None else f"{average / result['machine']['cores']:.1f}"


def job(record: Mapping[str, Any]) -> str:
    """What was measured, with its sizes."""
    sizes = ", ".join(f"{size:,.10g} {counted}" for counted, size in record.get("sizes", {}).items())
    return f"{record['what']} ({sizes})" if sizes else str(record["what"])


def peer_row(name: str, record: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    """A row: the job, its cost, and where it has a peer that one's cost and how many times ours it is."""
    unit = record["unit"]
    beside = (
        f"{record['peer']} | {number(record['peer_value'])} {unit} | {number(record['ratio'])}"
        if "peer" in record
        else " | | "
    )
    return f"| {name} | {number(record['value'])} {unit} | {beside} | {load(result)} |"

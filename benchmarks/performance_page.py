"""Put what `run_all.py` kept in ``results.json`` into docs/performance.md, and into pages that quote it.

``performance_page.py --write`` writes the pages' blocks, ``--check`` returns 1 where a page has others. A
test compares the two.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from quoted_results import quoted
from registry import BENCHMARKS, PROGRAMS
from result_cells import PEERS, Results, job, load, number, peer_row
from run_all import RESULTS, read_results

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "validation"))

from page_blocks import put  # noqa: E402 - the folder is put on the path above

__all__ = ["LIMIT", "PAGE", "blocks", "main"]

PAGE = ROOT / "docs" / "performance.md"
LIMIT = "arithmetic_limit"
SIZES = 3
"""Sizes that show how a cost grows, at least."""


def blocks(results: Results) -> dict[str, list[str]]:
    """Return the lines of every block of the page."""
    return {
        "machine": _machine(results),
        "programs": _peers(results, programs=True),
        "parts": _peers(results, programs=False),
        "growth": _growth(results),
        "limit": _limit(results),
        "alone": _alone(results),
        "benchmarks": _benchmarks(results),
    }


def _machine(results: Results) -> list[str]:
    """A line for every machine and set of versions."""
    found: dict[str, list[str]] = {}
    for name, result in results.items():
        on = result["machine"]
        packages = {key: value for key, value in result["versions"].items() if key in _SHOWN}
        told = ", ".join(f"{_SHOWN[key]} {value}" for key, value in packages.items())
        memory = "" if on["memory_gib"] is None else f", {on['memory_gib']:g} GiB"
        kind = "virtual machine" if on["virtual"] else "machine"
        where = f"{on['processor']} ({on['architecture']}, {on['system']})"
        line = f"{on['cores']}-core {kind}, {where}{memory}; {told}"
        found.setdefault(line, []).append(f"{name} ({result['date']})")
    return ["| machine | benchmarks |", "|---|---|"] + [
        f"| {line} | {', '.join(names) if len(found) > 1 else _dates(results)} |"
        for line, names in found.items()
    ]


_SHOWN = {"python": "Python", "numpy": "NumPy", "numba": "Numba", "scikit-learn": "scikit-learn"}


def _dates(results: Results) -> str:
    """All benchmarks, on their days."""
    days = sorted({result["date"] for result in results.values()})
    return f"all, {days[0]}" + (f" to {days[-1]}" if len(days) > 1 else "")


def _peers(results: Results, *, programs: bool) -> list[str]:
    """A row for every number with a peer, of others or our own: both costs, and the peer's over ours."""
    return [
        *PEERS,
        *(
            peer_row(f"`{name}`: {job(one)}", one, result)
            for name, result in results.items()
            for one in result["records"]
            if "peer" in one and name != LIMIT and one["peer"].startswith(PROGRAMS) is programs
        ),
    ]


def _sized(records: Sequence[Mapping[str, Any]]) -> dict[tuple[str, str, str], dict[float, float]]:
    """Costs by size, of every job, counted thing and unit that were measured at enough sizes."""
    jobs: dict[tuple[str, str, str], dict[float, float]] = {}
    for one in records:
        if len(one.get("sizes", {})) == 1:
            ((counted, size),) = one["sizes"].items()
            jobs.setdefault((one["what"], counted, one["unit"]), {})[size] = one["value"]
    return {job: costs for job, costs in jobs.items() if len(costs) >= SIZES}


def _growth(results: Results) -> list[str]:
    """A row for every cost that was measured at three sizes or more of one thing."""
    lines = ["| job | unit | cost by size | largest over smallest | load |", "|---|---|---|--:|--:|"]
    for name, result in results.items():
        for (what, counted, unit), costs in _sized(result["records"]).items():
            told = ", ".join(f"{size:,.10g}: {number(costs[size])}" for size in sorted(costs))
            grown = costs[max(costs)] / costs[min(costs)]
            lines.append(
                f"| `{name}`: {what} | {unit} | {counted} {told} | {number(grown)} | {load(result)} |"
            )
    return lines


def _alone(results: Results) -> list[str]:
    """A row for every number that has neither a peer nor other sizes."""
    lines = ["| job | modelcast | load |", "|---|--:|--:|"]
    for name, result in results.items():
        grown = {what for what, _, _ in _sized(result["records"])}
        lines += [
            f"| `{name}`: {job(one)} | {number(one['value'])} {one['unit']} | {load(result)} |"
            for one in result["records"]
            if "peer" not in one and one["what"] not in grown and name != LIMIT
        ]
    return lines


def _limit(results: Results) -> list[str]:
    """A row for every job beside its limit, and what the machine does at most."""
    lines = ["| job | took | the limit | it is | times the limit |", "|---|--:|---|--:|--:|"]
    records = results.get(LIMIT, {}).get("records", [])
    lines += [
        f"| {one['what']} | {number(one['value'])} {one['unit']} | {one['peer']} | "
        f"{number(one['peer_value'])} {one['unit']} | {number(one['value'] / one['peer_value'])} |"
        for one in records
        if "peer" in one
    ]
    lines += [
        f"| the machine: {one['what']} | {number(one['value'])} {one['unit']} | | | |"
        for one in records
        if "peer" not in one
    ]
    return lines


def _benchmarks(results: Results) -> list[str]:
    """A row for every benchmark: what it is, and when it was last run."""
    lines = ["| benchmark | shows | beside it | takes | last run | load |", "|---|---|---|---|---|--:|"]
    for one in BENCHMARKS:
        result = results.get(one.name)
        ran, busy = (
            ("not kept yet", "") if result is None else (f"{result['date']}{_ended(result)}", load(result))
        )
        lines.append(f"| `{one.name}` | {one.shows} | {one.peer} | {one.takes} | {ran} | {busy} |")
    return lines


def _ended(result: Mapping[str, Any]) -> str:
    """What is to be said of how it ended: benchmarks that have an aim end with 1 where they miss it."""
    code = result["exit_code"]
    return "" if code == 0 else f", exit code {code}"


def main() -> int:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--write", action="store_true", help="put the blocks into the pages")
    what.add_argument("--check", action="store_true", help="compare; write nothing")
    given = parser.parse_args()
    results = read_results(RESULTS)
    return put({PAGE: blocks(results), **quoted(results)}, check=given.check)


if __name__ == "__main__":
    sys.exit(main())

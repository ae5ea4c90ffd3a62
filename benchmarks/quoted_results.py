"""Tables of results that other pages than docs/performance.md quote.

A row is there once its benchmark has been kept. `performance_page.py` writes them beside its own page.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from registry import BENCHMARKS
from result_cells import PEERS, Results, job, peer_row

__all__ = ["QUOTED", "SHORT", "quoted"]

ROOT = Path(__file__).resolve().parents[1]

SHORT = {
    "Maximum-likelihood fit to ten samples, one axis": ("gp_fit", "anchored fit, one axis", ""),
    "the same, beside a compiled peer": ("gp_peers", "anchored fit, one axis", "tinygp"),
    "the same with an intercept, both axes": ("gp_fit", "intercept fit, both axes", ""),
    "One prediction of it": ("gp_fit", "predict, intercept", ""),
    "Message rates at four thresholds, default bank": (
        "rate_evaluation",
        "message rates at four thresholds, default bank",
        "",
    ),
    "`modelcast evaluate`, 9 cars, 320 s, warm cache": (
        "evaluate_command",
        "modelcast evaluate, 9 cars, 320 s, warm cache",
        "",
    ),
    "`modelcast --help`": ("evaluate_command", "modelcast --help", ""),
    "Basic safety messages, encode and decode, in batches": ("bsm_codec", "encode and decode, batch", ""),
    "the same singly": ("bsm_codec", "encode and decode, single", ""),
    "Radio of 200 nodes at 10 Hz": ("dsrc_channel", "200 nodes at 10 Hz", ""),
}
"""Rows of the read me: the words there, the benchmark, what it measured, and how its peer begins."""

QUOTED: Mapping[str, Mapping[str, Sequence[str]]] = {
    "docs/channel.md": {"speed": ("dsrc_channel",)},
    "docs/congestion.md": {"costs": ("congestion",)},
    "docs/evaluation.md": {"cost": ("evaluate_memory", "free_receiver")},
    "docs/messages.md": {"speed": ("bsm_codec", "psm_codec", "mbc_codec")},
    "docs/models.md": {"numpy": ("numpy_sub_model",)},
    "docs/node-page.md": {"frames": ("page_frames",)},
    "docs/node.md": {"tick": ("node_tick",), "latency": ("node_latency",)},
    "docs/people-cost.md": {"simulated": ("people_loop",)},
    "docs/policy.md": {"in numpy": ("numpy_policy",)},
    "docs/receiver.md": {"checks": ("plausibility",)},
    "docs/results.md": {"speed": ("gp_fit", "gp_peers", "gp_expressions", "evaluate_command")},
    "docs/scenarios.md": {"traffic": ("traffic", "safety_traffic")},
    "docs/security.md": {"speed": ("signing",)},
    "docs/serve.md": {"cost": ("serve_step",)},
    "docs/training.md": {"switching": ("switching",)},
}
"""Blocks of other pages, and the benchmarks whose records they hold."""


def quoted(results: Results) -> dict[Path, dict[str, list[str]]]:
    """Return the lines of every such block, by page and name."""
    pages = {
        ROOT / page: {name: _of(results, benchmarks) for name, benchmarks in blocks.items()}
        for page, blocks in QUOTED.items()
    }
    return {ROOT / "README.md": {"speed": _short(results)}, **pages}


def _short(results: Results) -> list[str]:
    rows = [
        peer_row(words, record, results[name])
        for words, (name, what, peer) in SHORT.items()
        for record in results.get(name, {}).get("records", ())
        if record["what"] == what and str(record.get("peer", "")).startswith(peer)
    ]
    return [*PEERS, *rows, "", _made(results, [name for name, _, _ in SHORT.values()])]


def _of(results: Results, benchmarks: Sequence[str]) -> list[str]:
    unknown = set(benchmarks) - {one.name for one in BENCHMARKS}
    if unknown:
        raise ValueError(f"no benchmark {min(unknown)}")
    kept = [name for name in benchmarks if name in results]
    rows = [
        peer_row(f"`{name}`: {job(record)}", record, results[name])
        for name in kept
        for record in results[name]["records"]
    ]
    without = [f'`make bench BENCH_ARGUMENTS="--only {name}"`' for name in benchmarks if name not in results]
    told = [f"Not kept yet: what {' and '.join(without)} measures."] if without else []
    return [
        *([*PEERS, *rows, "", _made(results, kept)] if kept else ()),
        *([""] if kept and told else ()),
        *told,
    ]


def _made(results: Results, names: Sequence[str]) -> str:
    """On which machines and days."""
    found = {_where(results[name]): None for name in names if name in results}
    return f"{'; '.join(found)}. *Load* is the machine's other work over its cores: 0 is an idle machine."


def _where(result: Mapping[str, Any]) -> str:
    on = result["machine"]
    kind = "virtual machine" if on["virtual"] else "machine"
    return f"{on['cores']}-core {kind} ({on['processor']}), {result['date']}"

"""What a benchmark has measured, kept for `run_all.py` beside what it prints.

A benchmark calls `record` for every number that is worth keeping. Where the environment variable that
`VARIABLE` names is unset, as when a script is run by itself, nothing is kept.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path

__all__ = ["VARIABLE", "record"]

VARIABLE = "MODELCAST_BENCHMARK_RECORDS"
"""Names the file to which records are added, a line of JSON each."""


def record(
    what: str,
    value: float,
    unit: str,
    *,
    peer: tuple[str, float] | None = None,
    sizes: Mapping[str, float] | None = None,
) -> None:
    """Keep one measured number.

    Parameters
    ----------
    what
        What was measured; the same words for the same job at other sizes.
    value
        How much it is.
    unit
        Of the value.
    peer
        Another program or way, and what the same job costs there in the same unit, measured in the same run.
        The ratio that is kept is the peer's cost over ours.
    sizes
        How large the job was, by what is counted: vehicles, trips, threads.
    """
    path = os.environ.get(VARIABLE)
    if not path:
        return
    kept: dict[str, object] = {"what": what, "value": _short(value), "unit": unit}
    if sizes:
        kept["sizes"] = dict(sizes)
    if peer is not None:
        name, theirs = peer
        kept |= {"peer": name, "peer_value": _short(theirs), "ratio": _short(theirs / value)}
    with Path(path).open("a", encoding="utf-8") as file:
        file.write(json.dumps(kept, ensure_ascii=False) + "\n")


def _short(value: float) -> float:
    """Four digits; times are never better known."""
    return float(f"{value:.4g}")

"""What a search for capacities leaves on disk: ``summary.json`` and, a row a probe, ``capacity.parquet``.

``summary.json`` has ``schema`` (2), ``modelcast`` (version), ``settings`` and ``found``: radio, policy,
threshold (null where the policy has none), quantity and value of the limit, the greatest density that held
and the least that failed (null where there is none), whether the probes were in order, and the probes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.version import package_version
from modelcast.io.arrow import columns_table, write_tables
from modelcast.io.documents import document_text, plain_value
from modelcast.study.network.capacity import CapacityFound

__all__ = ["CAPACITY_SCHEMA", "capacity_document", "write_capacity"]

CAPACITY_SCHEMA = 2
"""Version of the layout of ``summary.json``; since 2 it holds thresholds, limits of several quantities, and
the spread over seeds."""


def capacity_document(found: Sequence[CapacityFound], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    found
        The capacities.
    settings
        What was asked for.
    """
    return {
        "schema": CAPACITY_SCHEMA,
        "modelcast": package_version(),
        "settings": plain_value(dict(settings)),
        "found": [
            {
                "radio": one.radio,
                "policy": one.policy,
                "threshold_m": plain_value(one.threshold_m),
                "quantity": one.limit.quantity,
                "limit": one.limit.value,
                "holds_per_km": one.capacity.holds_per_km,
                "fails_per_km": one.capacity.fails_per_km,
                "is_monotone": one.capacity.is_monotone,
                "probes": [plain_value(asdict(probe)) for probe in one.capacity.probes],
            }
            for one in found
        ],
    }


def write_capacity(
    found: Sequence[CapacityFound], settings: Mapping[str, Any], folder: str | Path
) -> list[Path]:
    """Write ``summary.json`` and ``capacity.parquet``; return their paths.

    Parameters
    ----------
    found, settings
        As for `capacity_document`.
    folder
        An existing folder.
    """
    folder = Path(folder)
    summary, probes = folder / "summary.json", folder / "capacity.parquet"
    summary.write_text(document_text(capacity_document(found, settings)), encoding="utf-8", newline="\n")
    rows = [(one, probe) for one in found for probe in one.capacity.probes]
    numbers = {
        "threshold_m": [one.threshold_m for one, _ in rows],
        "limit": [one.limit.value for one, _ in rows],
        "density_per_km": [probe.density_per_km for _, probe in rows],
        "value": [probe.value for _, probe in rows],
        "least": [probe.spread[0] for _, probe in rows],
        "greatest": [probe.spread[1] for _, probe in rows],
        "held_ratio": [probe.held_ratio for _, probe in rows],
        "busy_ratio": [probe.busy_ratio for _, probe in rows],
        "seeds_held": [probe.seeds_held[0] for _, probe in rows],
        "seeds": [probe.seeds_held[1] for _, probe in rows],
        "warnings": [probe.warnings for _, probe in rows],
    }
    table = columns_table(
        {
            "radio": np.array([one.radio for one, _ in rows], dtype=object),
            "policy": np.array([one.policy for one, _ in rows], dtype=object),
            "quantity": np.array([one.limit.quantity for one, _ in rows], dtype=object),
            **{name: np.array(values, dtype=np.float64) for name, values in numbers.items()},
        }
    )
    write_tables([table], table.schema, probes)
    return [summary, probes]

"""What a search for capacities leaves on disk: ``summary.json`` and, a row a probe, ``capacity.parquet``.

``summary.json`` has ``schema`` (2), ``modelcast`` (version), ``settings`` and ``found``: radio, policy,
threshold (null where the policy has none), quantity and value of the limit, the greatest density that held
and the least that failed (null where there is none), whether the probes were in order, and the probes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from modelcast.core.version import package_version
from modelcast.io.documents import plain_value
from modelcast.io.result_files import write_result
from modelcast.study.network.capacity import CapacityFound, probes_table

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
    return write_result(capacity_document(found, settings), {"capacity": probes_table(found)}, folder)

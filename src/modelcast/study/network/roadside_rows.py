"""What roadside units of a run held and repeated, as tables."""

from modelcast.study.network.columns import AGE, BUSY, CASE, DELIVERY, GAP, HELD, PTE, SPAN
from modelcast.study.table import TableSchema, count, quantity, ratio

__all__ = ["ROADSIDE", "ROADSIDE_DISTANCES"]

ROADSIDE = TableSchema(
    "roadside",
    "What the units of one run did, and what they held of vehicles 50 m to 150 m away.",
    (
        *CASE,
        count("units", "How many there were."),
        BUSY,
        DELIVERY,
        quantity(
            "repeated_rate_hz", "1/s", "Messages that a unit handed to its radio.", heading="repeated [1/s]"
        ),
        quantity("repeated_bytes_per_s", "byte/s", "Their bytes."),
        ratio(
            "unsent_ratio",
            "Share of these that the next took the place of before they were sent.",
            heading="of these unsent [%]",
        ),
        quantity("by_another_rate_hz", "1/s", "Messages not repeated: another unit did."),
        quantity("replaced_rate_hz", "1/s", "Messages not repeated: a newer one came."),
        quantity("too_old_rate_hz", "1/s", "Messages not repeated: too old."),
        quantity("too_far_rate_hz", "1/s", "Messages not repeated: too far away."),
        HELD,
        *PTE,
        *AGE,
        *GAP,
    ),
)
"""Roadside units: a row a run."""

ROADSIDE_DISTANCES = TableSchema(
    "roadside_distances",
    "What the units of one run held of vehicles at one distance.",
    (
        *CASE,
        *SPAN,
        count("frames", "Pairs of a frame and a unit."),
        count("pairs", "Samples of pairs of a vehicle and a unit, whether tracked or not."),
        DELIVERY,
        HELD,
        *PTE,
        *AGE,
        *GAP,
    ),
)
"""Roadside units by distance: a row a run and bin."""

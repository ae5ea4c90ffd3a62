"""What the paper does not claim: its hybrid beside the strongest rival that costs no byte.

The paper's baseline coasts at constant velocity. A plain message also says acceleration and yaw rate, and a
receiver may coast by them (`modelcast.station.banks.free_bank`).
"""

from modelcast.study.paper.by_reading import (
    ByReading,
    message_estimates,
    tracking_estimates,
    worst_messages,
    worst_tracking,
)

__all__ = ["BESIDE", "beside_free"]

BESIDE = "beside it"
"""Place of what the paper does not claim."""


def beside_free(headline_ratio: float) -> tuple[ByReading, ...]:
    """What is judged beside the claims.

    Parameters
    ----------
    headline_ratio
        The packet error ratio that readings are compared at.
    """
    return (
        ByReading(
            "fewer messages than a free receiver",
            BESIDE,
            "Not a claim of the paper: fewer messages are sent than the strongest free receiver needs.",
            "Updates and identifications over the plain messages, at the same threshold, that receivers "
            "coast by speed, heading, acceleration and yaw rate, below 1.",
            "readings",
            lambda rows, _: message_estimates(rows.beside_free),
            lambda rows, _: worst_messages(rows.beside_free),
        ),
        ByReading(
            "more precise than a free receiver",
            BESIDE,
            "Not a claim of the paper: tracking is more precise than with the strongest free receiver.",
            f"90th percentile of the error at a PER of {100 * headline_ratio:g} % over that of an equal-rate "
            "baseline of the same plain messages, below 1.",
            "readings",
            lambda rows, reading: tracking_estimates(rows.beside_free_pooled(reading), "p90"),
            lambda rows, reading: worst_tracking(rows.beside_free_by_trip(reading), "p90"),
        ),
    )

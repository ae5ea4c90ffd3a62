"""Trips taken at a rate that a command was given; those recorded more slowly are reported and left out."""

from modelcast.core.exceptions import ConfigError
from modelcast.io.base import OnSkipped
from modelcast.trips.rate import at_rate
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_HZ", "read_at", "require_rate"]

MOST_HZ = 1e6
"""No vehicle is recorded faster."""


def require_rate(rate_hz: float | None) -> None:
    """Refuse what is no rate.

    Parameters
    ----------
    rate_hz
        A rate [Hz], or None for that of the recording.

    Raises
    ------
    ConfigError
        Where it is neither.
    """
    if rate_hz is not None and not 0.0 < rate_hz <= MOST_HZ:
        raise ConfigError(f"--rate must be above 0 and at most {MOST_HZ:,.0f} Hz, got {rate_hz:g}")


def read_at(trip: Trajectory, rate_hz: float | None, on_skipped: OnSkipped) -> Trajectory | None:
    """Return a trip as read at a rate, None where it was recorded more slowly, which is reported.

    Parameters
    ----------
    trip
        As recorded.
    rate_hz
        A rate [Hz], or None for that of the recording.
    on_skipped
        Called with its identifier and the reason.
    """
    if rate_hz is None:
        return trip
    try:
        return at_rate(trip, rate_hz)
    except ValueError as error:
        on_skipped(trip.trip_id, str(error))
        return None

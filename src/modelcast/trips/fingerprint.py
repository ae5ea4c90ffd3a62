"""A trip by its samples: a hash that a new name, another file or another format does not change."""

import hashlib
from collections.abc import Collection, Iterable

import numpy as np

from modelcast.trips.trajectory import Trajectory

__all__ = ["FINGERPRINT", "fingerprint", "known_trips"]

FINGERPRINT = r"[0-9a-f]{64}"
"""What a fingerprint looks like, as a regular expression."""

_FORM = b"modelcast trip 1\n"
_PER_SECOND, _PER_METRE = 1000.0, 100.0
_LARGEST = 2.0**62


def fingerprint(trip: Trajectory) -> str:
    """SHA-256 of a trip's samples in a canonical form, in hexadecimal digits.

    Parameters
    ----------
    trip
        As read.

    Notes
    -----
    The canonical form is the line ``modelcast trip 1`` and then three little-endian 64-bit whole numbers a
    sample: time since the first sample [ms], east and north of the first sample [cm]. So it is the same
    whatever the trip, its file and its vehicle are called, where on Earth the local frame has its origin, and
    whether the trip was converted; the number of samples and every one of them count. A part of a trip, a
    trip played faster or one with noise added is another trip. Two vehicles parked for equally long are one.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from modelcast.world.drive import generate_drive
    >>> trip = generate_drive(seed=1, duration_s=90.0).truth
    >>> fingerprint(trip) == fingerprint(replace(trip, trip_id="another/name"))
    True
    """
    columns = [
        (trip.t_s - trip.t_s[0]) * _PER_SECOND,
        (trip.position_m[:, 0] - trip.position_m[0, 0]) * _PER_METRE,
        (trip.position_m[:, 1] - trip.position_m[0, 1]) * _PER_METRE,
    ]
    whole = np.rint(np.clip(np.stack(columns, axis=1), -_LARGEST, _LARGEST)).astype("<i8")
    return hashlib.sha256(_FORM + whole.tobytes()).hexdigest()


def known_trips(trips: Iterable[Trajectory], fingerprints: Collection[str]) -> tuple[str, ...]:
    """Identifiers of the trips whose fingerprint is among these, in order.

    Parameters
    ----------
    trips
        The trips.
    fingerprints
        As `fingerprint` returns them; nothing is hashed where there are none.
    """
    if not fingerprints:
        return ()
    return tuple(trip.trip_id for trip in trips if fingerprint(trip) in fingerprints)

"""A recorded trip as if it were measured now, at the pace it was recorded at or k times as fast.

The same path is driven in 1/k of the time: speeds and yaw rates are k times, accelerations k² times the
recorded ones, so that they still belong to the places. At k = 1 all numbers are the recorded ones, to the
bit.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import final

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import local_to_geodetic
from modelcast.io.trips import read_trips
from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.samples import PLAUSIBLE, SAME_S, BusValue, GnssFix, Sample
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.trips.trajectory import Trajectory

__all__ = ["TripReplay", "file_and_trip", "trip_from"]


@final
class TripReplay(AbstractSource):
    """A trip, driven again.

    Parameters
    ----------
    trip
        Any; without an origin it is laid at `modelcast.station.sensing.sensing.NOWHERE`.
    begin_s
        When its first sample arrives, on the node's clock [s].
    times_as_fast
        k.
    latency_s
        From a sample's time to its arrival [s].
    with_bus
        Whether speed, acceleration and yaw rate are also given as values of a bus.

    Raises
    ------
    ValueError
        Where k is not positive or the latency negative.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> replay = TripReplay(generate_drive(1, 90.0).truth, begin_s=100.0)
    >>> [type(sample).__name__ for sample in replay.take(100.0)]
    ['GnssFix', 'BusValue', 'BusValue', 'BusValue']
    """

    def __init__(
        self,
        trip: Trajectory,
        *,
        begin_s: float = 0.0,
        times_as_fast: float = 1.0,
        latency_s: float = 0.0,
        with_bus: bool = True,
    ) -> None:
        if not (0.0 < times_as_fast < math.inf and 0.0 <= latency_s < math.inf):
            raise ValueError(
                f"times_as_fast must be positive and latency_s not negative, got {times_as_fast}, {latency_s}"
            )
        self.trip = trip
        self.origin = trip.origin or NOWHERE
        self.times_s: FloatArray = begin_s + trip.t_s / times_as_fast
        """When its samples were measured, (T,) [s]; they arrive a latency later."""
        self._latency_s = latency_s
        self._places_deg = local_to_geodetic(trip.position_m, self.origin)
        self._speed_mps = None if trip.speed_mps is None else times_as_fast * trip.speed_mps
        self._bus: dict[str, FloatArray] = {}
        if with_bus:
            columns = {
                "speed_mps": (trip.speed_mps, times_as_fast),
                "acceleration_mps2": (trip.acceleration_mps2, times_as_fast**2),
                "yaw_rate_radps": (trip.yaw_rate_radps, times_as_fast),
            }
            self._bus = {
                name: scale * column for name, (column, scale) in columns.items() if column is not None
            }
        self._next = 0
        self._counts = {"samples": 0, "implausible": 0, "no place": 0}

    async def start(self) -> None:
        """Nothing to open."""

    async def stop(self) -> None:
        """Nothing to close."""

    @property
    def ended(self) -> bool:
        """Whether all was taken."""
        return self._next == len(self.trip)

    def take(self, now_s: float) -> list[Sample]:
        """What arrived since the last call."""
        last = int(np.searchsorted(self.times_s + self._latency_s, now_s + SAME_S, side="right"))
        samples = [sample for at in range(self._next, last) for sample in self._samples(at)]
        self._next = max(last, self._next)
        self._counts["samples"] += len(samples)
        return samples

    def counts(self) -> Mapping[str, int]:
        """Samples, and those left out: "no place" that has a latitude, "implausible" on a bus."""
        return dict(self._counts)

    def _samples(self, at: int) -> list[Sample]:
        measured_s = float(self.times_s[at])
        received_s = measured_s + self._latency_s
        latitude_deg, longitude_deg = self._places_deg[at].tolist()
        samples: list[Sample] = []
        if math.isfinite(latitude_deg + longitude_deg):
            heading_rad = self.trip.heading_rad
            east_m, north_m = self.trip.position_m[at].tolist()
            samples.append(
                GnssFix(
                    received_s=received_s,
                    measured_s=measured_s,
                    latitude_deg=latitude_deg,
                    longitude_deg=longitude_deg,
                    speed_mps=math.nan if self._speed_mps is None else float(self._speed_mps[at]),
                    heading_rad=math.nan if heading_rad is None else float(heading_rad[at]),
                    position_m=(east_m, north_m),
                )
            )
        else:
            self._counts["no place"] += 1
        for name, column in self._bus.items():
            low, high = PLAUSIBLE[name]
            if low <= column[at] <= high:
                samples.append(BusValue(name, float(column[at]), received_s, measured_s))
            else:
                self._counts["implausible"] += 1
        return samples


def file_and_trip(text: str) -> tuple[str, str]:
    """The path of a text, and the trip's id behind its last ``#``, empty where there is none.

    Parameters
    ----------
    text
        As for `trip_from`.

    Examples
    --------
    >>> file_and_trip("drive.csv#drive/7")
    ('drive.csv', 'drive/7')
    """
    if "#" not in text or Path(text).exists():
        return text, ""
    path, _, wanted = text.rpartition("#")
    return path, wanted


def trip_from(text: str, *, format_name: str | None = None) -> Trajectory:
    """The trip that a text names: the first of a file, or the one of ``FILE#ID``.

    Parameters
    ----------
    text
        Path, and a trip's id behind the last ``#``.
    format_name
        Of the file; found from its content where None.

    Raises
    ------
    ConfigError
        Where there is no such trip.
    DataFormatError
        Where the file is not what its format says.
    """
    path, wanted = file_and_trip(text)
    for trip in read_trips(path, format_name):
        if wanted in {"", trip.trip_id}:
            return trip
    raise ConfigError(f"{path} has no trip" + (f" {wanted!r}" if wanted else " that can be driven"))

"""Roads that were driven before, to be shared: cells of many trips, on Earth or on one local plane."""

import hashlib
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import Origin, geodetic_to_local, local_to_geodetic
from modelcast.station.context.road import RoadCells, joined, road_cells, roads
from modelcast.station.context.road_kernels import CELL_M
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory

__all__ = ["MOST_SURVEYED", "RoadSurvey", "survey_roads"]

MOST_SURVEYED = 200_000
"""Cells that a survey keeps where nothing else is said: 1,000 km."""


@dataclass(frozen=True, slots=True, eq=False)
class RoadSurvey:
    """Cells of roads, K of them, in the order in which they were passed.

    Parameters
    ----------
    places
        Latitude and longitude [deg] where the survey is geodetic, else east and north [m], (K, 2).
    heading_rad
        Clockwise from north, unwrapped along each pass, (K,) [rad].
    passes
        The pass that each cell belongs to, (K,).
    trip
        The trip that each was driven on, a place among `fingerprints`, (K,).
    fingerprints
        Of the trips (`modelcast.trips.fingerprint`): a trip does not remember what it is about to drive.
    geodetic
        Whether places are on Earth. Those on a local plane serve only trips on the same plane, which nobody
        can check.

    Raises
    ------
    ValueError
        Where shapes do not agree, a number is not finite or no place, or a pass is on no trip or on two.
    """

    places: FloatArray
    heading_rad: FloatArray
    passes: IntArray
    trip: IntArray
    fingerprints: tuple[str, ...]
    geodetic: bool

    def __post_init__(self) -> None:
        count = self.passes.size
        for name, shape in (("places", (count, 2)), ("heading_rad", (count,)), ("trip", (count,))):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must be {shape}, got {getattr(self, name).shape}")
        RoadCells(np.column_stack([self.places, self.heading_rad]), self.passes)
        if count and not (self.trip.min() >= 0 and self.trip.max() < len(self.fingerprints)):
            raise ValueError(f"trips must be of {len(self.fingerprints)}, got {self.trip.max()}")
        if self.geodetic and count and (np.abs(self.places) > (90.0, 360.0)).any():
            raise ValueError("a place is beyond 90 degrees of latitude or 360 of longitude")
        if (np.diff(self.trip)[np.diff(self.passes) == 0] != 0).any():
            raise ValueError("a pass is driven on one trip")

    def __len__(self) -> int:
        return int(self.passes.size)

    @property
    def length_m(self) -> float:
        """Length of the roads, one driven twice counted twice [m]."""
        return len(self) * CELL_M

    @property
    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal digits."""
        columns = (self.places, self.heading_rad, self.passes, self.trip)
        content = b"".join(np.ascontiguousarray(one).tobytes() for one in columns)
        return hashlib.sha256(" ".join(self.fingerprints).encode() + content).hexdigest()

    @property
    def memory_bytes(self) -> int:
        """Bytes of the memory that a car holds it in."""
        return sum(column.nbytes for column in roads(1, max(len(self), 1)))

    def cells(self, origin: Origin | None, without: Collection[str] = ()) -> RoadCells | None:
        """Cells on a trip's plane, None where the survey does not serve it.

        Parameters
        ----------
        origin
            Of the plane; None for a local one, which is taken for that of the survey.
        without
            Fingerprints of trips whose cells are left out.
        """
        if (origin is not None) != self.geodetic:
            return None
        left_out = np.array([one in without for one in self.fingerprints], dtype=np.bool_)
        kept = ~left_out[self.trip] if len(self) else np.zeros(0, dtype=np.bool_)
        places = self.places[kept]
        if origin is not None:
            places = geodetic_to_local(places, origin)
        known = np.isfinite(places).all(axis=1)  # what is too far off has no place on the plane
        numbers = np.column_stack([places, self.heading_rad[kept]])[known]
        return RoadCells(numbers, self.passes[kept][known])


def survey_roads(trips: Iterable[Trajectory], most: int = MOST_SURVEYED) -> RoadSurvey:
    """The roads that some trips were driven on, in this order.

    Parameters
    ----------
    trips
        As recorded; they are taken one at a time.
    most
        Cells that are kept at most: the first give way.

    Raises
    ------
    ValueError
        Where some trips are on Earth and others on a local plane, or ``most`` is under 1.
    """
    if most < 1:
        raise ValueError(f"most must be at least 1, got {most}")
    parts: list[RoadCells] = []
    counts: list[int] = []
    prints: list[str] = []
    geodetic: bool | None = None
    for trip in trips:
        on_earth = trip.origin is not None
        if geodetic is not None and on_earth != geodetic:
            raise ValueError(
                f"{trip.trip_id} is {'on Earth' if on_earth else 'on a local plane'}, the trips before it "
                "are not: build a file of each"
            )
        geodetic = on_earth
        samples = sample_matrix(trip, velocity_estimator_for(trip))
        cells = road_cells(trip.t_s, samples)
        numbers = cells.numbers
        if trip.origin is not None:
            numbers = np.column_stack([local_to_geodetic(numbers[:, :2], trip.origin), numbers[:, 2]])
        parts.append(RoadCells(numbers, cells.passes))
        counts.append(len(cells))
        prints.append(fingerprint(trip))
    if not parts:
        raise ValueError("name at least one trip")
    whole = joined(parts)
    trip_of = np.repeat(np.arange(len(counts), dtype=np.int64), counts)
    numbers, passes = whole.numbers[-most:], whole.passes[-most:]
    return RoadSurvey(
        numbers[:, :2], numbers[:, 2], passes, trip_of[-most:], tuple(prints), geodetic=bool(geodetic)
    )

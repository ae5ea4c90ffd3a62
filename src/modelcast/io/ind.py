"""inD, and rounD, exiD and uniD in the same layout: road users at crossings from above, 25 Hz.

A recording is ``<number>_tracks.csv`` with ``<number>_tracksMeta.csv`` and ``<number>_recordingMeta.csv``,
any of them given; `modelcast.io.drone_tracks` says what all such recordings share.

========================  ======  =======================================================================
Column of the tracks      Unit    Use
========================  ======  =======================================================================
trackId                   -       the road user
frame                     -       time, by ``frameRate`` of the recording
xCenter, yCenter          m       middle, in the grid (UTM) from the recording's origin
heading                   deg     heading; 0 is the grid's east, anticlockwise
xVelocity, yVelocity      m/s     speed: their part along the heading, so negative in reverse
xAcceleration,            m/s²    acceleration: the part along the heading
yAcceleration
========================  ======  =======================================================================

The recording's ``xUtmOrigin`` and ``yUtmOrigin`` are that origin, and ``lonLocation`` tells the grid's zone:
with them positions are laid out about the recording's origin on Earth, and headings are turned from the
grid's north to true north (2.3 degrees in Aachen, the west of zone 32). Without them, or where they lie over
`FAR_DEG` apart, the frame is local and its north the grid's; repaired "place not known, grid north taken".
Speeds are the grid's, off by up to 0.04 % of the ground's. There is no yaw rate.

References
----------
Bock, Krajewski, Moers, Runde, Vater, Eckstein: The inD Dataset, IV 2020, doi 10.1109/IV47402.2020.9304839;
the tools of its authors (ika-rwth-aachen/drone-dataset-tools: boxes and axes). The data sets' licences are
their own; only their layout is known here.
"""

from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.core.utm import utm_to_geodetic, utm_zone
from modelcast.io.base import Tally
from modelcast.io.drone_files import DroneTables
from modelcast.io.drone_tracks import AbstractDroneReader, Recorded, RoadUser
from modelcast.io.rows import Rows, located

__all__ = ["FAR_DEG", "IndReader"]

FAR_DEG = 0.1
"""How far the origin in the grid may be from the place that the metadata name, which is approximate."""

_PLACE = ("latLocation", "lonLocation", "xUtmOrigin", "yUtmOrigin")


class IndReader(AbstractDroneReader):
    """Reads recordings of the inD family; the module's docstring has the columns."""

    name: ClassVar[str] = "ind"

    @property
    def tables(self) -> DroneTables:
        """As published."""
        return DroneTables(
            tracks=(
                *("trackId", "frame", "xCenter", "yCenter", "heading"),
                *("xVelocity", "yVelocity", "xAcceleration", "yAcceleration"),
            ),
            tracks_meta=("trackId", "class", "initialFrame"),
            recording_meta=("recordingId", "locationId", "frameRate"),
        )

    @property
    def optional(self) -> tuple[str, ...]:
        """Where the recording is."""
        return _PLACE

    def placed(
        self, rows: Rows, user: RoadUser, recorded: Recorded, tally: Tally
    ) -> tuple[Rows, Origin | None]:
        """Return the middles, about the recording's origin."""
        del user
        columns = rows.columns
        yaw_rad = np.radians(columns["heading"])
        cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
        rows = Rows(
            rows.line,
            {
                "t_s": columns["t_s"],
                "east_m": columns["xCenter"],
                "north_m": columns["yCenter"],
                "heading_rad": wrap_angle_rad(0.5 * np.pi - yaw_rad),
                "speed_mps": columns["xVelocity"] * cosine + columns["yVelocity"] * sine,
                "acceleration_mps2": columns["xAcceleration"] * cosine + columns["yAcceleration"] * sine,
            },
        )
        grid = _Grid.of(recorded)
        if grid is None:
            tally.repair("place not known, grid north taken", len(rows))
            return rows, None
        return grid.placed(rows)


class _Grid:
    """The grid of one recording: its zone, and where the recording's origin is in it."""

    def __init__(self, zone: int, east_m: float, north_m: float, *, southern: bool) -> None:
        self._zone, self._southern = zone, southern
        self._east_m, self._north_m = east_m, north_m
        latitude, longitude, _ = self._geodetic(np.zeros(1), np.zeros(1))
        self.origin = Origin(float(latitude[0]), float(longitude[0]))

    @classmethod
    def of(cls, recorded: Recorded) -> "_Grid | None":
        """Return it where the metadata tell it and agree with themselves."""
        if not all(name in recorded.row for name in _PLACE):
            return None
        latitude, longitude, east_m, north_m = (recorded.number(name) for name in _PLACE)
        if not (
            abs(latitude) < 85.0
            and abs(longitude) <= 180.0
            and abs(east_m - 5e5) < 5e5
            and abs(north_m) < 1e7
        ):
            return None
        grid = cls(utm_zone(longitude), east_m, north_m, southern=latitude < 0.0)
        apart = max(abs(grid.origin.latitude_deg - latitude), abs(grid.origin.longitude_deg - longitude))
        return grid if apart <= FAR_DEG else None

    def _geodetic(self, east_m: np.ndarray, north_m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return utm_to_geodetic(
            self._east_m + east_m, self._north_m + north_m, zone=self._zone, southern=self._southern
        )

    def placed(self, rows: Rows) -> tuple[Rows, Origin]:
        """Return rows in metres of the ground about the origin, headings from true north."""
        columns = rows.columns
        latitude, longitude, turn = self._geodetic(columns["east_m"], columns["north_m"])
        rows = rows.having(
            latitude_deg=latitude,
            longitude_deg=longitude,
            heading_rad=wrap_angle_rad(columns["heading_rad"] + turn),
        )
        return located(rows, self.origin), self.origin

"""highD: vehicles on motorways from above, 25 Hz.

A recording is ``<number>_tracks.csv`` with ``<number>_tracksMeta.csv`` and ``<number>_recordingMeta.csv``,
any of them given; `modelcast.io.drone_tracks` says what all such recordings share.

=======================  ======  ========================================================================
Column of the tracks     Unit    Use
=======================  ======  ========================================================================
frame                    -       time, by ``frameRate`` of the recording
id                       -       the vehicle
x, y                     m       upper left corner of the vehicle's box in the picture; y points down
width, height            m       extent along x and along y: the vehicle's length and width
xVelocity, yVelocity     m/s     speed and heading
xAcceleration,           m/s²    acceleration, along the heading
yAcceleration
=======================  ======  ========================================================================

Positions are the middles of the boxes. East is the picture's x, north its upper side: the frame is local, the
road's place and direction on Earth are not in the files. Below `SLOW_MPS` the heading is that of
``drivingDirection``: 1 is leftward (the upper lanes), 2 rightward. There is no yaw rate.

References
----------
Krajewski, Bock, Kloeker, Eckstein: The highD Dataset, ITSC 2018, doi 10.1109/ITSC.2018.8569552; the tools of
its authors (RobertKrajewski/highD-dataset: box and directions as drawn by ``plotTracks.m``). The data set's
licence is its own; only its layout is known here.
"""

from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import Tally
from modelcast.io.drone_files import DroneTables
from modelcast.io.drone_tracks import AbstractDroneReader, Recorded, RoadUser
from modelcast.io.rows import Rows

__all__ = ["SLOW_MPS", "HighDReader"]

SLOW_MPS = 1.0
"""Below, a velocity says more of the tracking's noise than of where the vehicle points."""

_LEFTWARD_RAD, _RIGHTWARD_RAD = -0.5 * np.pi, 0.5 * np.pi
_DIRECTIONS = {"1": _LEFTWARD_RAD, "2": _RIGHTWARD_RAD}


class HighDReader(AbstractDroneReader):
    """Reads highD recordings; the module's docstring has the columns."""

    name: ClassVar[str] = "highd"

    @property
    def tables(self) -> DroneTables:
        """As published."""
        return DroneTables(
            tracks=(
                *("id", "frame", "x", "y", "width", "height"),
                *("xVelocity", "yVelocity", "xAcceleration", "yAcceleration"),
            ),
            tracks_meta=("id", "class", "drivingDirection"),
            recording_meta=("id", "frameRate", "upperLaneMarkings"),
        )

    @property
    def optional(self) -> tuple[str, ...]:
        """None."""
        return ()

    def placed(
        self, rows: Rows, user: RoadUser, recorded: Recorded, tally: Tally
    ) -> tuple[Rows, Origin | None]:
        """Return the middles of the boxes, in the picture's frame."""
        del tally
        direction = _DIRECTIONS.get(user.cells["drivingDirection"] or "")
        if direction is None:
            raise DataFormatError(
                str(recorded.files.path("tracksMeta")),
                f"drivingDirection is {user.cells['drivingDirection']!r}, not 1 or 2", row=user.line,
                remedy="Correct the value.",
            )  # fmt: skip
        columns = rows.columns
        east_mps, north_mps = columns["xVelocity"], -columns["yVelocity"]
        speed_mps = np.hypot(east_mps, north_mps)
        heading_rad = np.where(speed_mps < SLOW_MPS, direction, np.arctan2(east_mps, north_mps))
        along = columns["xAcceleration"] * np.sin(heading_rad) - columns["yAcceleration"] * np.cos(
            heading_rad
        )
        return Rows(
            rows.line,
            {
                "t_s": columns["t_s"],
                "east_m": columns["x"] + 0.5 * columns["width"],
                "north_m": -(columns["y"] + 0.5 * columns["height"]),
                "speed_mps": speed_mps,
                "heading_rad": heading_rad,
                "acceleration_mps2": along,
            },
        ), None

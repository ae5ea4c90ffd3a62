"""Safety Pilot ``HV_Primary`` (DAS2): a vehicle's own GPS and CAN, 10 Hz.

A trip is (DeviceID, Trip), ``<stem>/<DeviceID>-<Trip>``.

============================  =======  ====  =======================================================
Column                        Unit     No.   Use
============================  =======  ====  =======================================================
DeviceID, Trip                -        0-1   the trip
Time                          ms       2     not used, so that a repeated fix is not taken for a new
GPS_Elevation                 m        3     height
GPS_Heading                   deg      6     heading, clockwise from north
GPS_Latitude, GPS_Longitude   deg      7-8   position
GPS_UTC_Time                  Unix ms  12    time, absolute
GPS_Valid                     -        13    rows other than 1 are skipped
InVehicle_Longitudinal_Accel  m/s²     19    acceleration
InVehicle_Longitudinal_Speed  m/s      20    speed
InVehicle_Yaw_Rate            deg/s    29    yaw rate, clockwise positive
all others                    -              not used
============================  =======  ====  =======================================================

With or without a header row, a byte order mark, CRLF; blank or blank-padded cells or the word ``NULL``;
E notation. The two-month file's rows have 45 fields and its first, empty one 53; both lengths are read.

Skipped and counted: "no fix" (an all-empty first row too), "no GPS time", "position unavailable", "repeated
fix", "partial last line", "no first value yet". Repaired and counted: "out of time order" (sorted); missing
values of optional columns, held or left out as `rows` says.
"""

from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.base import Tally
from modelcast.io.rows import Rows
from modelcast.io.spmd import AbstractSpmdReader, SpmdLayout, valid_position

__all__ = ["SpmdHvReader"]


_TIME_UNIT_S = 1e-3


def _usable(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with a fix of their own, in SI units."""
    rows = rows.without(rows.columns["GPS_Valid"] != 1.0, "no fix", tally)
    rows = rows.without(np.isnan(rows.columns["GPS_UTC_Time"]), "no GPS time", tally)
    placed = valid_position(rows.columns["GPS_Latitude"], rows.columns["GPS_Longitude"])
    rows = rows.without(~placed, "position unavailable", tally)
    raw = rows.columns
    return Rows(
        rows.line,
        {
            "t_s": raw["GPS_UTC_Time"] * _TIME_UNIT_S,
            "latitude_deg": raw["GPS_Latitude"],
            "longitude_deg": raw["GPS_Longitude"],
            "altitude_m": raw["GPS_Elevation"],
            "speed_mps": raw["InVehicle_Longitudinal_Speed"],
            "heading_rad": wrap_angle_rad(np.radians(raw["GPS_Heading"])),
            "acceleration_mps2": raw["InVehicle_Longitudinal_Accel"],
            "yaw_rate_radps": np.radians(raw["InVehicle_Yaw_Rate"]),
        },
    )


_LAYOUT = SpmdLayout(
    source="spmd-hv",
    header=(
        "DeviceID", "Trip", "Time", "GPS_Elevation", "GPS_Fix_Quality", "GPS_Hdop", "GPS_Heading",
        "GPS_Latitude", "GPS_Longitude", "GPS_Number_Satellites", "GPS_Pdop", "GPS_Speed", "GPS_UTC_Time",
        "GPS_Valid", "DAS_Roll_Rate", "DAS_Pitch_Rate", "InVehicle_ABS_State", "InVehicle_Brake_Status",
        "InVehicle_Headlight_Status", "InVehicle_Longitudinal_Accel", "InVehicle_Longitudinal_Speed",
        "InVehicle_PRNDL", "InVehicle_Stability_Control_Status", "InVehicle_Steering_Position",
        "InVehicle_Throttle_Position", "InVehicle_Traction_Control_Status", "InVehicle_Turn_Signal_Left",
        "InVehicle_Turn_Signal_Right", "InVehicle_Wiper_Status", "InVehicle_Yaw_Rate",
    ),
    counts=frozenset({45, 53}),
    keys=("DeviceID", "Trip"),
    numbers=(
        "GPS_Elevation", "GPS_Heading", "GPS_Latitude", "GPS_Longitude", "GPS_UTC_Time", "GPS_Valid",
        "InVehicle_Longitudinal_Accel", "InVehicle_Longitudinal_Speed", "InVehicle_Yaw_Rate",
    ),
    time="GPS_UTC_Time",
    time_unit_s=_TIME_UNIT_S,
    trip_name="-".join,
    usable=_usable,
    duplicate="repeated fix",
    start_unix=True,
)  # fmt: skip


class SpmdHvReader(AbstractSpmdReader):
    """Reads HV_Primary files; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = _LAYOUT.source

    @property
    def layout(self) -> SpmdLayout:
        """HV_Primary."""
        return _LAYOUT

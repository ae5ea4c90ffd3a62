"""Small made files of every format, as a writer fixture: no real data is copied into the project."""

import json
import sqlite3
import struct
from collections.abc import Callable, Iterable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from modelcast.io.pcap import pcap_octets
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.wsmp import encode_wsm

COUNT = 12
SPEED_MPS = 10.0
LATITUDE_STEP_DEG = SPEED_MPS * 0.1 / 111_000.0


def bsm_row(at: int, **changed: object) -> str:
    values: dict[str, object] = {
        "RxDevice": 7, "FileId": 70, "TxDevice": 7, "GenTime": 291864241884364 + 100_000 * at,
        "TxRandom": -9018, "MsgCount": at, "DSecond": 35800, "Latitude": 42.0 + at * LATITUDE_STEP_DEG,
        "Longitude": -83.5, "Elevation": 200.0 + at, "Speed": SPEED_MPS, "Heading": 0.0, "Ax": "9.9999998E-3",
        "Ay": 20.01, "Az": 0, "Yawrate": 1.5, "PathCount": 9, "RadiusOfCurve": 3276.7, "Confidence": 95,
    }  # fmt: skip
    return ",".join(str(value) for value in (values | changed).values())


def bsm_file(rows: list[str], *, header: str | None = None, end: str = "\r\n") -> bytes:
    lines = rows if header is None else [header, *rows]
    return (end.join(lines) + end).encode()


BSM_HEADER = (
    "RxDevice,FileId,TxDevice,GenTime,TxRandom,MsgCount,DSecond,Latitude,Longitude,Elevation,Speed,Heading,"
    "Ax,Ay,Az,Yawrate,PathCount,RadiusOfCurve,Confidence"
)


def wsu_row(at: int, **changed: object) -> str:
    values: dict[str, object] = {
        "Device": 8, "Trip": 80, "Time": 10 * at, "GpsValidWsu": 1, "GpsTimeWsu": 1349093298700 + 100 * at,
        "LatitudeWsu": 42.0 + at * LATITUDE_STEP_DEG, "LongitudeWsu": -83.5, "AltitudeWsu": 180.0,
        "GpsHeadingWsu": 90.0, "GpsSpeedWsu": 9.9, "HdopWsu": 1, "PdopWsu": 1, "FixQualityWsu": 1,
        "GpsCoastingWsu": 0, "ValidCanWsu": 1, "YawRateWsu": 3.0, "SpeedWsu": 36.0, "TurnSngRWsu": 0,
        "TurnSngLWsu": 0, "BrakeAbsTcsWsu": 0, "AxWsu": 0.5, "PrndlWsu": 5, "VsaActiveWsu": 0,
        "HeadlampWsu": 0, "WiperWsu": 0, "ThrottleWsu": 0, "SteerWsu": 0,
    }  # fmt: skip
    return ",".join(str(value) for value in (values | changed).values())


def hv_row(at: int, *, fields: int = 45, **changed: object) -> str:
    values: dict[str, object] = {
        "DeviceID": 9, "Trip": 90, "Time": 100 * at, "GPS_Elevation": 207.0, "GPS_Fix_Quality": 1,
        "GPS_Hdop": 0.8, "GPS_Heading": 180.0, "GPS_Latitude": 42.0 - at * LATITUDE_STEP_DEG,
        "GPS_Longitude": -83.5, "GPS_Number_Satellites": 9, "GPS_Pdop": 1.5, "GPS_Speed": 10.0,
        "GPS_UTC_Time": 1350150235300 + 100 * at, "GPS_Valid": 1, "Roll": 0, "Pitch": 0, "ABS": "2         ",
        "Brake": "0         ", "Headlight": 0, "Accel": -0.3, "Speed": 10.0, "PRNDL": 2, "Stability": 1,
        "Steering": -2.7, "Throttle": 0, "Traction": "2         ", "Left": 0, "Right": 0, "Wiper": 0,
        "Yaw": 2.0,
    }  # fmt: skip
    return ",".join([*(str(value) for value in (values | changed).values()), *["0"] * (fields - 30)])


def openacc_file(rows: list[str] | None = None, *, order: str = "GHOST,FIRST,SECOND,") -> bytes:
    head = [
        "Date,9,10,2019", f"Vehicle_order,{order}", "Number_of_vehicles,3", "ACC,0", "Distance_setting,",
        "Time,Speed2,E2,N2,Lon2,Lat2,Alt2,Speed3,E3,N3,Lon3,Lat3,Alt3,IVS2",
    ]  # fmt: skip
    made = [
        f"{5370 + at / 10},10.0,{100 + at},50,16.8,46.9,229,10.0,{90 + at},50,16.8,46.9,230,5.5"
        for at in range(COUNT)
    ]
    return ("\r\n".join([*head, *(made if rows is None else rows)]) + "\r\n").encode()


def nyc_message(at: int, vehicle: str = "AB12", **changed: object) -> dict[str, Any]:
    core = {
        "id": vehicle, "X_m": 1.0 * at, "Y_m": 0.0, "Z_m": 1.0, "T_s": -6.0 + 0.1 * at, "speed_mps": 10.0,
        "heading_deg": 90.0, "accelSet": {"long_mpss": 0.5, "yaw_dps": 2.0},
    }  # fmt: skip
    return {"bsmRecord": {"bsmMsg": {"coreData": core | changed}}}


def nyc_file(messages: list[dict[str, Any]], **header: str) -> bytes:
    return json.dumps({"eventHeader": header, "bsmList": messages}).encode()


def sentence(body: str) -> str:
    total = 0
    for character in body:
        total ^= ord(character)
    return f"${body}*{total:02X}"


def gga(seconds: float, at: int = 0, talker: str = "GP", quality: int = 1) -> str:
    return sentence(
        f"{talker}GGA,{clock(seconds)},42{at * 0.0006:07.4f},N,08330.0000,W,{quality},8,1.0,200.0,M,-34.0,M,,"
    )


def rmc(seconds: float, at: int = 0, day: str = "231124", talker: str = "GP", status: str = "A") -> str:
    return sentence(
        f"{talker}RMC,{clock(seconds)},{status},42{at * 0.0006:07.4f},N,08330.0000,W,19.4384,90.0,{day},,,A"
    )


def clock(seconds: float) -> str:
    tenths = round(seconds * 10) % 864000
    return f"{tenths // 36000:02d}{tenths // 600 % 60:02d}{tenths % 600 / 10:04.1f}"


def nmea_file(sentences: list[str]) -> bytes:
    return ("\r\n".join(sentences) + "\r\n").encode()


def smartloc_lines(word: str) -> list[str]:
    numbers = "3785108.{at} 899901.5 5037234.5 0 0 0 0 0 0 0 0 0" if word == "point3" else (
        "5.{at} 0 0 0 0 -0.1 0 0 0 0 0 0"
    )  # fmt: skip
    return [f"{word} {at / 5} " + numbers.format(at=at) + "  " for at in range(10)]


def table_rows() -> dict[str, list[float]]:
    times = [at / 10 for at in range(COUNT)]
    return {"t": times, "x": [10 * t for t in times], "y": [0.0] * COUNT, "speed": [10.0] * COUNT}


def csv_file() -> bytes:
    return pl.DataFrame(table_rows()).write_csv().encode()


def parquet_file() -> bytes:
    buffer = BytesIO()
    pl.DataFrame(table_rows()).write_parquet(buffer)
    return buffer.getvalue()


def comma_arrays() -> dict[str, np.ndarray]:
    epoch = np.arange(COUNT)
    gnss = np.stack(
        [42 + epoch * LATITUDE_STEP_DEG, np.full(COUNT, -83.5), np.full(COUNT, 10.0),
         1.53e12 + 100 * epoch, np.full(COUNT, 30.0), np.full(COUNT, 90.0)],
        axis=1,
    )  # fmt: skip
    can_s = 999.99 + 0.012 * np.arange(150)
    gyro_s = 999.99 + 0.01 * np.arange(180)
    return {
        "GNSS/live_gnss_ublox/t": 1000 + 0.1 * epoch + 0.02 * (epoch % 2),
        "GNSS/live_gnss_ublox/value": gnss,
        "CAN/speed/t": can_s,
        "CAN/speed/value": can_s[:, None] - 990.0,
        "IMU/gyro/t": gyro_s,
        "IMU/gyro/value": np.tile([0.5, 0.6, 0.25], (180, 1)),
    }


def write_comma(folder: Path, arrays: dict[str, np.ndarray] | None = None) -> Path:
    for name, array in (comma_arrays() if arrays is None else arrays).items():
        path = folder / "processed_log" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            np.save(file, array)
    return folder


def pcap_file() -> bytes:
    def message(at: int) -> bytes:
        core = BsmCore.from_values(
            {
                "message_count": at % 128, "temporary_id": 0xA1B2C3D4,
                "second_of_minute_s": (50 + at / 10) % 60, "speed_mps": 11.1,
                "latitude_deg": 42.0 + 1e-5 * at, "longitude_deg": -83.0, "elevation_m": 250.0,
                "heading_rad": 0.0, "acceleration_forward_mps2": 0.0, "yaw_rate_radps": 0.0,
            }
        )  # fmt: skip
        return encode_wsm(encode_unsecured(encode_bsm(core)))

    start_ns = 1_700_000_030 * 10**9  # 50 s past a minute
    return b"".join(pcap_octets((start_ns + 10**8 * at + 10**6, message(at)) for at in range(COUNT)))


def gpx_point(at: int, *, latitude: float | None = None, inside: str = "", time: str | None = None) -> str:
    where = 42.0 + at * LATITUDE_STEP_DEG if latitude is None else latitude
    when = f"2024-03-15T10:00:{at / 10:04.1f}Z" if time is None else time
    return f'<trkpt lat="{where}" lon="-83.5"><ele>200</ele><time>{when}</time>{inside}</trkpt>'


def gpx_file(points: list[str], *, version: str = "1.1") -> bytes:
    head = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<gpx version="{version}" creator="made" xmlns="http://www.topografix.com/GPX/{version}">',
        "<trk><trkseg>",
    ]
    return "\n".join([*head, *points, "</trkseg></trk>", "</gpx>", ""]).encode()


def kitti_pose(forward_m: float, heading_rad: float = 0.0) -> str:
    """Row by row, of a camera that moved along its first axis of sight and looks to the right of it."""
    sine, cosine = np.sin(heading_rad), np.cos(heading_rad)
    rows = [[cosine, 0, sine, 0.0], [0, 1, 0, -0.5], [-sine, 0, cosine, forward_m]]
    return " ".join(f"{value:.6e}" for row in rows for value in row)


def write_kitti_poses(folder: Path, poses: list[str] | None = None, times: list[str] | None = None) -> Path:
    poses = [kitti_pose(0.1 * SPEED_MPS * at) for at in range(COUNT)] if poses is None else poses
    times = [f"{at / 10:.6e}" for at in range(COUNT)] if times is None else times
    path = folder / "poses" / "00.txt"
    times_path = folder / "sequences" / "00" / "times.txt"
    for made, lines in ((path, poses), (times_path, times)):
        made.parent.mkdir(parents=True, exist_ok=True)
        made.write_bytes("".join(f"{line}\n" for line in lines).encode())
    return path


def oxts_packet(at: int, **changed: float) -> str:
    values: dict[str, float] = {
        "lat": 49.0 + at * LATITUDE_STEP_DEG, "lon": 8.4, "alt": 110.0, "roll": 0.03, "pitch": 0.01,
        "yaw": np.pi / 2, "vn": SPEED_MPS, "ve": 0.0, "vf": SPEED_MPS, "vl": 0.0, "vu": 0.0, "ax": 9.0,
        "ay": 9.0, "az": 9.8, "af": 0.5, "al": 0.0, "au": 9.8, "wx": 7.0, "wy": 7.0, "wz": 7.0, "wf": 7.0,
        "wl": 7.0, "wu": 0.25,
    }  # fmt: skip
    return " ".join(str(value) for value in [*(values | changed).values(), 0.1, 0.03, 4, 9, 5, 5, 5])


def oxts_time(at: int) -> str:
    return f"2011-09-26 13:02:{25 + at // 10:02d}.{at % 10}64389445"


def write_oxts(folder: Path, packets: dict[int, str] | None = None, times: list[str] | None = None) -> Path:
    data = folder / "oxts" / "data"
    data.mkdir(parents=True, exist_ok=True)
    packets = {at: oxts_packet(at) for at in range(COUNT)} if packets is None else packets
    for number, packet in packets.items():
        (data / f"{number:010d}.txt").write_text(packet + "\n")
    times = [oxts_time(at) for at in range(COUNT)] if times is None else times
    (folder / "oxts" / "timestamps.txt").write_text("\n".join(times) + "\n")
    return folder


HIGHD_NAMES = "frame,id,x,y,width,height,xVelocity,yVelocity,xAcceleration,yAcceleration,dhw,laneId"
IND_NAMES = (
    "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,"
    "xAcceleration,yAcceleration,lonVelocity,latVelocity,lonAcceleration,latAcceleration"
)


def highd_row(at: int, vehicle: int = 1, **changed: float) -> str:
    """Of a truck that drives leftwards, its middle 0.4 m further every frame."""
    values: dict[str, float] = {
        "frame": at, "id": vehicle, "x": 300.0 - 0.4 * at, "y": 20.0, "width": 12.0, "height": 2.5,
        "xVelocity": -SPEED_MPS, "yVelocity": 0.0, "xAcceleration": -0.5, "yAcceleration": 0.0, "dhw": 0.0,
        "laneId": 2,
    }  # fmt: skip
    return ",".join(str(value) for value in (values | changed).values())


def ind_row(at: int, user: int = 0, **changed: float) -> str:
    """Of a car that drives along the grid's north."""
    values: dict[str, float] = {
        "recordingId": 7, "trackId": user, "frame": at, "trackLifetime": at, "xCenter": 50.0,
        "yCenter": -40.0 + 0.4 * at, "heading": 90.0, "width": 1.8, "length": 4.5, "xVelocity": 0.0,
        "yVelocity": SPEED_MPS, "xAcceleration": 0.0, "yAcceleration": 0.5, "lonVelocity": SPEED_MPS,
        "latVelocity": 0.0, "lonAcceleration": 0.5, "latAcceleration": 0.0,
    }  # fmt: skip
    return ",".join(str(value) for value in (values | changed).values())


def write_drone(folder: Path, recording: str, tables: dict[str, list[str]]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for table, lines in tables.items():
        (folder / f"{recording}_{table}.csv").write_bytes(("\n".join(lines) + "\n").encode())
    return folder / f"{recording}_tracks.csv"


def write_highd(folder: Path, **changed: list[str]) -> Path:
    tables = {
        "tracks": [HIGHD_NAMES, *(highd_row(at, user) for user in (1, 2) for at in range(1, COUNT + 1))],
        "tracksMeta": [
            "id,width,height,initialFrame,finalFrame,numFrames,class,drivingDirection",
            *(f"{user},12.0,2.5,1,12,12,Truck,1" for user in (1, 2)),
        ],
        "recordingMeta": [
            "id,frameRate,locationId,startTime,upperLaneMarkings,lowerLaneMarkings",
            "1,25,2,08:38,8.51;12.59;16.43,21.00;24.96;28.80",
        ],
    }
    return write_drone(folder, "01", tables | changed)


def write_ind(folder: Path, **changed: list[str]) -> Path:
    tables = {
        "tracks": [IND_NAMES, *(ind_row(at, user) for user in (0, 1, 2) for at in range(COUNT))],
        "tracksMeta": [
            "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class",
            *(f"7,{user},0,11,12,0,0,{kind}" for user, kind in enumerate(("car", "bicycle", "pedestrian"))),
        ],
        "recordingMeta": [
            "recordingId,locationId,frameRate,latLocation,lonLocation,xUtmOrigin,yUtmOrigin",
            "7,1,25.0,50.78,6.07,293487.1224,5629711.58",
        ],
    }
    return write_drone(folder, "07", tables | changed)


def fcd_file() -> bytes:
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<fcd-export>"]
    for at in range(COUNT):
        east = 12.0 * at / 10
        lines += [
            f'<timestep time="{at / 10}">',
            f'<vehicle id="a" x="{east}" y="3" angle="90" type="car" speed="12" pos="{east}" lane="e_0"/>',
            f'<vehicle id="b" x="{east}" y="6" angle="90" type="bike" speed="12" pos="{east}" lane="e_1"/>',
            f'<person id="p" x="1" y="{at / 10}" angle="0" speed="1" pos="1" edge="w"/>',
            "</timestep>",
        ]
    return "\n".join([*lines, "</fcd-export>", ""]).encode()


def interaction_file(rows: Iterable[str] | None = None, *, header: str = "") -> bytes:
    names = header or "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy,psi_rad,length,width"
    made = [
        f"{track},{at + 1},{100 * at + 100},car,{950 + at},{1000 - 2 * at},10.0,-20.0,-1.1071487,4.5,1.8"
        for track in (1, 2)
        for at in range(COUNT)
    ]
    return ("\n".join([names, *(made if rows is None else rows)]) + "\n").encode()


NGSIM_HEADER = (
    "Vehicle_ID,Frame_ID,Total_Frames,Global_Time,Local_X,Local_Y,Global_X,Global_Y,v_Length,v_Width,v_Class,"
    "v_Vel,v_Acc,Lane_ID,Preceding,Following,Space_Hdwy,Time_Hdwy"
)


def ngsim_row(at: int, *, separator: str = ",", vehicle: int = 2, total: int = 437, start: int = 0) -> str:
    cells = (
        vehicle, 13 + at, total, 1118846980200 + start + 100 * at, 16.4, 35.4 + 4 * at, 6451137.6, 1873344.9,
        14.5, 4.9, 2, 40.0, 0.0, 2, 0, 0, 0.0, 0.0,
    )  # fmt: skip
    return separator.join(str(cell) for cell in cells)


def ode_record(at: int, *, core: dict[str, Any] | None = None, **metadata: Any) -> dict[str, Any]:
    """A message in the converted form, 0.1 s after another, from 20:08:54.300 on."""
    t_ms = 54_300 + 100 * at
    stamp = f"2017-08-10T20:{8 + t_ms // 60_000:02d}:{t_ms % 60_000 / 1000:06.3f}Z[UTC]"
    said = {
        "msgCnt": at % 128, "id": "24EF0000", "secMark": t_ms % 60_000,
        "position": {"latitude": 40.4 + at * LATITUDE_STEP_DEG, "longitude": -104.9, "elevation": 1494.5},
        "accelSet": {"accelLong": -0.15, "accelYaw": 1.5}, "speed": 10.0, "heading": 0.0,
    }  # fmt: skip
    return {
        "metadata": {"recordGeneratedAt": stamp, "odeReceivedAt": "2017-11-09T12:58:27.755Z[UTC]"} | metadata,
        "payload": {
            "dataType": "us.dot.its.jpo.ode.plugin.j2735.J2735Bsm",
            "data": {"coreData": said | (core or {})},
        },
    }


def ode_codes(at: int) -> dict[str, Any]:
    """Core data of the same motion as on the air, numbers as texts."""
    return {
        "id": "FE95E8G3", "secMark": str(54_300 + 100 * at), "lat": str(round(4e8 + 900 * at)),
        "long": "-824576935", "elev": "-152", "speed": "500", "heading": "28800",
        "accelSet": {"long": "-15", "lat": "2001", "vert": "-127", "yaw": "150"},
    }  # fmt: skip


def ode_file(records: Iterable[dict[str, Any]] | None = None) -> bytes:
    made = [ode_record(at) for at in range(COUNT)] if records is None else records
    return "".join(json.dumps(one) + "\n" for one in made).encode()


PILOT_HEADER = (
    "metadata_generatedAt,metadata_receivedAt,coreData_id,coreData_secMark,coreData_position_lat,"
    "coreData_position_long,coreData_elevation,coreData_accelset_accelYaw,coreData_speed,coreData_heading,"
    "coreData_size"
)


def pilot_row(at: int, **changed: object) -> str:
    t_ms = 36_400 + 100 * at
    values: dict[str, object] = {
        "generated": f"2018-11-20T12:13:{t_ms // 1000:02d}.{t_ms % 1000:03d}", "received": "",
        "id": "3DEF0000",
        "mark": t_ms, "lat": f"{41.1 + at * LATITUDE_STEP_DEG:.7f}", "long": -104.85, "elev": 1856.8,
        "yaw": 0.5, "speed": 10.0, "heading": 0.0, "size": '"{""width"": 490, ""length"": 1190}"',
    }  # fmt: skip
    return ",".join(str(value) for value in (values | changed).values())


def pilot_file(rows: Iterable[str] | None = None) -> bytes:
    made = [pilot_row(at) for at in range(COUNT)] if rows is None else rows
    return ("\n".join([PILOT_HEADER, *made]) + "\n").encode()


BAG_START_NS = 1_700_000_000_250_000_000


def cdr(parts: Iterable[tuple[str, Any]], order: str = "<") -> bytes:
    """Fields in CDR: a struct letter and its value, or ``text``."""
    data = bytearray()
    for letter, value in parts:
        form, given = ("I", len(value) + 1) if letter == "text" else (letter, value)
        size = struct.calcsize(form)
        data += bytes(-len(data) % size) + struct.pack(order + form, given)
        data += value.encode() + b"\0" if letter == "text" else b""
    return bytes([0, order == "<", 0, 0]) + data


def bag_stamp(at: int, stamp_ns: int | None = None) -> list[tuple[str, Any]]:
    t_ns = BAG_START_NS + 10**8 * at if stamp_ns is None else stamp_ns
    return [("i", t_ns // 10**9), ("I", t_ns % 10**9), ("text", "gps")]


def fix_message(at: int, *, order: str = "<", status: int = 0, stamp_ns: int | None = None) -> bytes:
    place = [("d", 42.0 + at * LATITUDE_STEP_DEG), ("d", -83.5), ("d", 200.0)]
    rest = [*place, *[("d", 0.0)] * 9, ("B", 0)]
    return cdr([*bag_stamp(at, stamp_ns), ("b", status), ("H", 1), *rest], order)


def odometry_message(at: int, *, order: str = "<", twist: bool = True, yaw_rad: float = 0.5) -> bytes:
    pose = [at * 1.0, 2.0 * at, 0.5, 0.0, 0.0, float(np.sin(yaw_rad / 2)), float(np.cos(yaw_rad / 2))]
    moved = [8.0, 6.0, 0.0, 0.0, 0.0, 0.25] if twist else [0.0] * 6
    numbers = [*pose, *[0.0] * 36, *moved, *[0.0] * 36]
    return cdr([*bag_stamp(at), ("text", "base_link"), *[("d", one) for one in numbers]], order)


BagRow = tuple[str, str, int, bytes]
"""Topic, type, storage time [ns] and octets of a message."""

FIX, ODOMETRY = "sensor_msgs/msg/NavSatFix", "nav_msgs/msg/Odometry"


def bag_rows() -> list[BagRow]:
    return [
        row
        for at in range(COUNT)
        for row in (
            ("/gps/fix", FIX, BAG_START_NS + 10**8 * at + 10**6, fix_message(at)),
            ("/odom", ODOMETRY, BAG_START_NS + 10**8 * at + 2 * 10**6, odometry_message(at)),
        )
    ]


def mcap_record(kind: int, content: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(content)) + content


def mcap_text(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode()


def mcap_file(
    rows: Iterable[BagRow],
    *,
    encoding: str = "cdr",
    pack: Callable[[bytes], bytes] | None = None,
    word: str = "",
) -> bytes:
    """An MCAP of one chunk, without an index."""
    inside, channels = b"", {}
    for topic, kind, t_ns, data in rows:
        if topic not in channels:
            number = channels[topic] = len(channels) + 1
            inside += mcap_record(
                3, struct.pack("<H", number) + mcap_text(kind) + mcap_text("ros2msg") + bytes(4)
            )
            names = mcap_text(topic) + mcap_text(encoding) + bytes(4)
            inside += mcap_record(4, struct.pack("<HH", number, number) + names)
        inside += mcap_record(5, struct.pack("<HIQQ", channels[topic], 0, t_ns, t_ns) + data)
    packed = inside if pack is None else pack(inside)
    chunk = (
        struct.pack("<QQQI", 0, 0, len(inside), 0) + mcap_text(word) + struct.pack("<Q", len(packed)) + packed
    )
    head = mcap_record(1, mcap_text("ros2") + mcap_text("made"))
    return b"\x89MCAP0\r\n" + head + mcap_record(6, chunk) + mcap_record(15, bytes(4))


def write_db3(path: Path, rows: Iterable[BagRow], *, encoding: str = "cdr") -> Path:
    path.unlink(missing_ok=True)
    base = sqlite3.connect(path)
    base.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)"
    )
    base.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
    )
    topics: dict[str, int] = {}
    for topic, kind, t_ns, data in rows:
        if topic not in topics:
            topics[topic] = len(topics) + 1
            named = (topics[topic], topic, kind, encoding)
            base.execute("INSERT INTO topics VALUES (?, ?, ?, ?, '')", named)
        base.execute("INSERT INTO messages VALUES (NULL, ?, ?, ?)", (topics[topic], t_ns, data))
    base.commit()
    base.close()
    return path


VALID: dict[str, tuple[str, Callable[[], bytes]]] = {
    "spmd-bsm": ("bsm.csv", lambda: bsm_file([bsm_row(at) for at in range(COUNT)], header=BSM_HEADER)),
    "spmd-wsu": ("wsu.csv", lambda: bsm_file([wsu_row(at) for at in range(COUNT)])),
    "spmd-hv": ("hv.csv", lambda: bsm_file([hv_row(at) for at in range(COUNT)])),
    "openacc": ("platoon.csv", openacc_file),
    "nyc-cvpd": ("event.json", lambda: nyc_file([nyc_message(at) for at in range(COUNT)])),
    "nmea": (
        "log.nmea",
        lambda: nmea_file([text(at / 10, at) for at in range(COUNT) for text in (gga, rmc)]),
    ),
    "smartloc": ("Drive_GT.txt", lambda: "\n".join([*smartloc_lines("point3"), ""]).encode()),
    "gpx": (
        "drive.gpx",
        lambda: gpx_file([gpx_point(at, inside="<speed>10</speed>") for at in range(COUNT)]),
    ),
    "sumo-fcd": ("fcd.xml", fcd_file),
    "pcap": ("heard.pcap", pcap_file),
    "interaction": ("vehicle_tracks_000.csv", interaction_file),
    "ngsim": (
        "trajectories.csv",
        lambda: bsm_file([ngsim_row(at) for at in range(COUNT)], header=NGSIM_HEADER, end="\n"),
    ),
    "ode-bsm": ("messages.json", ode_file),
    "cv-pilot": ("pilot.csv", pilot_file),
    "ros2-mcap": ("bag_0.mcap", lambda: mcap_file(bag_rows())),
    "csv": ("table.csv", csv_file),
    "parquet": ("table.parquet", parquet_file),
}


FOLDERS: dict[str, tuple[str, Callable[[Path], Path]]] = {
    "comma2k19": ("drive/40", write_comma),
    "kitti-oxts": ("2011_09_26_drive_0001_sync", write_oxts),
    "kitti-poses": ("dataset", write_kitti_poses),
    "highd": ("highd", write_highd),
    "ind": ("ind", write_ind),
}
"""Formats whose recordings are several files."""


class Made:
    """Writes made files into one folder."""

    bsm_row = staticmethod(bsm_row)
    bsm_header = BSM_HEADER
    wsu_row = staticmethod(wsu_row)
    hv_row = staticmethod(hv_row)
    lines = staticmethod(bsm_file)
    openacc = staticmethod(openacc_file)
    nyc_message = staticmethod(nyc_message)
    nyc = staticmethod(nyc_file)
    gga = staticmethod(gga)
    rmc = staticmethod(rmc)
    sentence = staticmethod(sentence)
    nmea = staticmethod(nmea_file)
    highd_names = HIGHD_NAMES
    highd_row = staticmethod(highd_row)
    highd = staticmethod(write_highd)
    ind_names = IND_NAMES
    ind_row = staticmethod(ind_row)
    ind = staticmethod(write_ind)
    kitti_pose = staticmethod(kitti_pose)
    kitti_poses = staticmethod(write_kitti_poses)
    oxts_packet = staticmethod(oxts_packet)
    oxts_time = staticmethod(oxts_time)
    oxts = staticmethod(write_oxts)
    gpx_point = staticmethod(gpx_point)
    gpx = staticmethod(gpx_file)
    smartloc_lines = staticmethod(smartloc_lines)
    comma_arrays = staticmethod(comma_arrays)
    comma = staticmethod(write_comma)
    interaction = staticmethod(interaction_file)
    ngsim_header = NGSIM_HEADER
    ngsim_row = staticmethod(ngsim_row)
    ode_record = staticmethod(ode_record)
    ode_codes = staticmethod(ode_codes)
    ode = staticmethod(ode_file)
    pilot_header = PILOT_HEADER
    pilot_row = staticmethod(pilot_row)
    pilot = staticmethod(pilot_file)
    bag_start_ns = BAG_START_NS
    bag_rows = staticmethod(bag_rows)
    fix = staticmethod(fix_message)
    odometry = staticmethod(odometry_message)
    mcap = staticmethod(mcap_file)
    fix_type, odometry_type = FIX, ODOMETRY

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, name: str, content: bytes | str) -> Path:
        """Write a file and return its path."""
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def db3(self, name: str, rows: Iterable[BagRow], **changed: str) -> Path:
        """Write a bag of SQLite and return its path."""
        return write_db3(self.folder / name, rows, **changed)

    def valid(self, format_name: str) -> Path:
        """Write a small faultless recording of a format and return its path."""
        if format_name in FOLDERS:
            folder, write = FOLDERS[format_name]
            return write(self.folder / folder)
        if format_name == "ros2-db3":
            return write_db3(self.folder / "bag_0.db3", bag_rows())
        name, content = VALID[format_name]
        return self.write(name, content())


@pytest.fixture
def made(tmp_path: Path) -> Made:
    """Writer of made files."""
    return Made(tmp_path)


@pytest.fixture(scope="session")
def session_made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Writer of made files that live through all examples of a property."""
    return Made(tmp_path_factory.mktemp("made"))

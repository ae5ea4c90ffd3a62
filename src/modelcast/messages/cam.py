"""The cooperative awareness message of a vehicle, ETSI EN 302 637-2: values to octets and back.

The octets are made by pycrate (extra ``etsi``), which has the standard's modules. What is read is
`CAM_FIELDS` and the path behind; what else a message may hold is read over and not kept.

A model may go along, in octets that the message does not look into: it is the first extension addition of
``CamParameters``. A receiver of this release reads over it. No standard says what is in it, and a later
release of the message (TS 103 900) may use the same place for extension containers of its own.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from threading import Lock
from typing import Any, Final

from modelcast.core.argument_types import require_type
from modelcast.core.exceptions import CodecError, MissingExtraError
from modelcast.messages.bits import MAX_OCTETS
from modelcast.messages.cam_fields import CAM_FIELDS, CAM_INDEX, CAM_ROLES, MAX_PATH_POINTS, PATH_FIELDS
from modelcast.messages.field_table import FieldTable

__all__ = ["CamLowFrequency", "CooperativeAwarenessMessage", "decode_cam", "encode_cam", "path_point"]

_TABLE: Final = FieldTable(CAM_FIELDS)
_PATH: Final = FieldTable(PATH_FIELDS)
_MESSAGE_ID: Final = 2
_VERSIONS: Final = (1, 2)
_VEHICLE_HIGH: Final = "basicVehicleContainerHighFrequency"
_VEHICLE_LOW: Final = "basicVehicleContainerLowFrequency"
_LIGHTS_BITS: Final = 8
_WRITTEN, _READ = "_ext_1", "_ext_0"
"""pycrate 0.8 counts unknown additions from 1 where it writes them, and from 0 where it reads them."""

_ONE_AT_A_TIME: Final = Lock()
"""pycrate's types hold the value that they encode."""


@dataclass(frozen=True, slots=True)
class CamLowFrequency:
    """The low-frequency container of a vehicle, which goes along every half second at most.

    Parameters
    ----------
    role
        One of `CAM_ROLES`.
    exterior_lights
        Bits from the first on the wire: low beam, high beam, left, right, daytime, reverse, fog, parking.
    path
        Points behind, newest first, as codes in the order of `PATH_FIELDS`; `path_point` makes one.

    Raises
    ------
    ValueError
        Where a value is out of its range.
    """

    role: str = "default"
    exterior_lights: int = 0
    path: tuple[tuple[int, ...], ...] = ()

    def __post_init__(self) -> None:
        if self.role not in CAM_ROLES:
            raise ValueError(f"role must be one of {', '.join(CAM_ROLES)}, got {self.role!r}")
        if not 0 <= self.exterior_lights < 1 << _LIGHTS_BITS:
            raise ValueError(f"exterior_lights must lie within 0..255, got {self.exterior_lights}")
        if len(self.path) > MAX_PATH_POINTS:
            raise ValueError(f"path must have {MAX_PATH_POINTS} points at most, got {len(self.path)}")
        for point in self.path:
            _PATH.checked("path", point)


@dataclass(frozen=True, slots=True)
class CooperativeAwarenessMessage:
    """A cooperative awareness message of a vehicle, as the codes on the wire.

    Parameters
    ----------
    codes
        One whole number a field, in the order of `CAM_FIELDS`.
    low_frequency
        None where the container is left out.
    model
        Octets of a model, which no standard describes; None for none.
    version
        Of the protocol, 1 or 2.

    Raises
    ------
    ValueError
        Where a code is out of its range, the octets of the model are none or too many, or the version is
        another.

    Examples
    --------
    >>> values = {"station_id": 7, "generation_s": 100.25, "station_type": 5, "speed_mps": 12.345}
    >>> message = CooperativeAwarenessMessage.from_values(values)
    >>> message.value("speed_mps"), message.value("latitude_deg"), message.value("generation_s")
    (12.34, None, 34.714)
    """

    codes: tuple[int, ...]
    _: KW_ONLY
    low_frequency: CamLowFrequency | None = None
    model: bytes | None = None
    version: int = 2

    def __post_init__(self) -> None:
        object.__setattr__(self, "codes", _TABLE.checked("codes", self.codes))
        if self.model is not None and not 0 < len(self.model) <= MAX_OCTETS:
            raise ValueError(f"model must have 1 to {MAX_OCTETS} octets, got {len(self.model)}")
        if self.version not in _VERSIONS:
            raise ValueError(f"version must be 1 or 2, got {self.version}")

    @classmethod
    def from_values(
        cls,
        values: Mapping[str, float | None],
        *,
        low_frequency: CamLowFrequency | None = None,
        model: bytes | None = None,
    ) -> "CooperativeAwarenessMessage":
        """Message of the nearest codes of values in SI units.

        Parameters
        ----------
        values
            By the names of `CAM_FIELDS`. A field that is left out, None, or not a number is unavailable.
        low_frequency, model
            As in the class.

        Raises
        ------
        ValueError
            Where a name is unknown, or ``station_id``, ``generation_s`` or ``station_type`` is left out.
        """
        return cls(_TABLE.codes_of(values), low_frequency=low_frequency, model=model)

    def value(self, name: str) -> float | None:
        """Value of one field in SI units, None where unavailable.

        Parameters
        ----------
        name
            Our name of the field.

        Raises
        ------
        KeyError
            Where there is no such field.
        """
        return _TABLE.value_of(self.codes, name)


def path_point(values: Mapping[str, float | None]) -> tuple[int, ...]:
    """Codes of a point of the path behind.

    Parameters
    ----------
    values
        By the names of `PATH_FIELDS`, in SI units.

    Examples
    --------
    >>> path_point({"delta_latitude_deg": 1e-4, "delta_longitude_deg": 0.0, "age_s": 1.0})
    (1000, 0, 12800, 100)
    """
    return _PATH.codes_of(values)


def encode_cam(message: CooperativeAwarenessMessage) -> bytes:
    """Octets of a message, in unaligned packed encoding rules.

    Parameters
    ----------
    message
        The message.

    Raises
    ------
    MissingExtraError
        Where pycrate is not installed.
    TypeError
        Where it is no such message.
    """
    require_type("message", message, CooperativeAwarenessMessage)
    codec, _ = _library()
    with _ONE_AT_A_TIME:
        codec.set_val(_value(message))
        return bytes(codec.to_uper())


def decode_cam(data: bytes) -> CooperativeAwarenessMessage:
    """Message in octets.

    Parameters
    ----------
    data
        Octets of one message.

    Raises
    ------
    CodecError
        Where they are no message, it is not of a vehicle, or octets are left.
    MissingExtraError
        Where pycrate is not installed.
    TypeError
        Where they are no bytes.
    """
    require_type("data", data, bytes, remedy="give the octets, as bytes.fromhex makes them of a text")
    codec, reader = _library()
    bits = reader(data)
    with _ONE_AT_A_TIME:
        try:
            codec.from_uper(bits)
            value = codec.get_val()
        except Exception as error:
            raise CodecError(f"no cooperative awareness message: {error}", 0) from error
    left = int(bits.len_bit())
    if left:
        raise CodecError(f"{left} bits are left behind the message", 8 * len(data) - left)
    return _message(value)


@cache
def _library() -> tuple[Any, Any]:
    """Return pycrate's type of the message, and its reader of bits."""
    try:
        from pycrate_asn1dir.ITS_CAM_2 import CAM_PDU_Descriptions  # noqa: PLC0415 - an extra
        from pycrate_core.charpy import Charpy  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise MissingExtraError("Encoding cooperative awareness messages", "etsi") from error
    return CAM_PDU_Descriptions.CAM, Charpy


def _value(message: CooperativeAwarenessMessage) -> dict[str, Any]:
    """Value of the standard's type as pycrate takes it."""
    code = dict(zip(CAM_INDEX, message.codes, strict=True))
    parameters: dict[str, Any] = {
        "basicContainer": {
            "stationType": code["station_type"],
            "referencePosition": {
                "latitude": code["latitude_deg"],
                "longitude": code["longitude_deg"],
                "positionConfidenceEllipse": {
                    "semiMajorConfidence": 4095,
                    "semiMinorConfidence": 4095,
                    "semiMajorOrientation": 3601,
                },
                "altitude": {"altitudeValue": code["altitude_m"], "altitudeConfidence": "unavailable"},
            },
        },
        "highFrequencyContainer": (
            _VEHICLE_HIGH,
            {
                "heading": {"headingValue": code["heading_rad"], "headingConfidence": 127},
                "speed": {"speedValue": code["speed_mps"], "speedConfidence": 127},
                "driveDirection": "forward",
                "vehicleLength": {
                    "vehicleLengthValue": code["length_m"],
                    "vehicleLengthConfidenceIndication": "unavailable",
                },
                "vehicleWidth": code["width_m"],
                "longitudinalAcceleration": {
                    "longitudinalAccelerationValue": code["acceleration_forward_mps2"],
                    "longitudinalAccelerationConfidence": 102,
                },
                "curvature": {"curvatureValue": 1023, "curvatureConfidence": "unavailable"},
                "curvatureCalculationMode": "unavailable",
                "yawRate": {"yawRateValue": code["yaw_rate_radps"], "yawRateConfidence": "unavailable"},
            },
        ),
    }
    if message.low_frequency is not None:
        parameters["lowFrequencyContainer"] = (_VEHICLE_LOW, _low_value(message.low_frequency))
    if message.model is not None:
        parameters[_WRITTEN] = message.model
    return {
        "header": {
            "protocolVersion": message.version,
            "messageID": _MESSAGE_ID,
            "stationID": code["station_id"],
        },
        "cam": {"generationDeltaTime": code["generation_s"], "camParameters": parameters},
    }


def _low_value(container: CamLowFrequency) -> dict[str, Any]:
    points = [
        {
            "pathPosition": {"deltaLatitude": north, "deltaLongitude": east, "deltaAltitude": up},
            **({"pathDeltaTime": age} if age else {}),
        }
        for north, east, up, age in container.path
    ]
    lights = container.exterior_lights, _LIGHTS_BITS
    return {"vehicleRole": container.role, "exteriorLights": lights, "pathHistory": points}


def _message(value: Mapping[str, Any]) -> CooperativeAwarenessMessage:
    """Message of a value of the standard's type as pycrate gives it."""
    header, body = value["header"], value["cam"]
    parameters = body["camParameters"]
    high, container = parameters["highFrequencyContainer"]
    if (header["protocolVersion"], header["messageID"]) not in {(one, _MESSAGE_ID) for one in _VERSIONS}:
        raise CodecError(
            f"protocol version {header['protocolVersion']} and message id {header['messageID']} are none of "
            "a cooperative awareness message",
            0,
        )
    if high != _VEHICLE_HIGH:
        raise CodecError(f"{high} is not the container of a vehicle", 0)
    basic = parameters["basicContainer"]
    place = basic["referencePosition"]
    codes = {
        "station_id": header["stationID"],
        "generation_s": body["generationDeltaTime"],
        "station_type": basic["stationType"],
        "latitude_deg": place["latitude"],
        "longitude_deg": place["longitude"],
        "altitude_m": place["altitude"]["altitudeValue"],
        "heading_rad": container["heading"]["headingValue"],
        "speed_mps": container["speed"]["speedValue"],
        "length_m": container["vehicleLength"]["vehicleLengthValue"],
        "width_m": container["vehicleWidth"],
        "acceleration_forward_mps2": container["longitudinalAcceleration"]["longitudinalAccelerationValue"],
        "yaw_rate_radps": container["yawRate"]["yawRateValue"],
    }
    low = parameters.get("lowFrequencyContainer")
    return CooperativeAwarenessMessage(
        tuple(codes[name] for name in CAM_INDEX),
        low_frequency=_low_frequency(low[1]) if low is not None and low[0] == _VEHICLE_LOW else None,
        model=parameters.get(_READ) or None,
        version=header["protocolVersion"],
    )


def _low_frequency(container: Mapping[str, Any]) -> CamLowFrequency:
    path = tuple(
        (
            point["pathPosition"]["deltaLatitude"],
            point["pathPosition"]["deltaLongitude"],
            point["pathPosition"]["deltaAltitude"],
            point.get("pathDeltaTime", 0),
        )
        for point in container["pathHistory"]
    )
    return CamLowFrequency(container["vehicleRole"], container["exteriorLights"][0], path)

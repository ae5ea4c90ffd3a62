"""What signals of a bus mean: which one is the speed, in what unit, which way round.

A map in words, as in a configuration: ``speed_mps=SPEED.SPEED[km/h],
yaw_rate_radps=KINEMATICS.YAW_RATE[-deg/s]``. The unit in brackets is that of the value as the DBC gives it;
a minus turns it round, a number before it scales it. Without brackets the DBC's own unit holds, which must
be one of `UNITS`. ``~NAME`` before the brackets is a signal of the same message that makes the value
negative where it is 1.

Headings and turns are clockwise here: a bus that counts to the left is turned round.

Presets (`PRESETS`) name the signals of public DBC files of the opendbc project (MIT), read in release 0.3.1:

===================== ============================================== =====================================
Preset                Signals                                        What to check before driving
===================== ============================================== =====================================
toyota_prius_2010_pt  SPEED.SPEED [mph], KINEMATICS.YAW_RATE,        that file gives the yaw rate no unit and
                      ACCELEROMETER.ACCEL_X [m/s2],                  says "verify"; 0.244 deg/s a step is
                      STEER_ANGLE_SENSOR.STEER_ANGLE [deg],          from _toyota_2017.dbc, the same frame.
                      BRAKE_MODULE.BRAKE_PRESSED                     Direction: taken as leftwards
vw_mqb                ESP_21.ESP_v_Signal [km/h],                    signs are bits of their own, taken as
                      ESP_02.ESP_Gierrate [deg/s],                   1 to the right
                      ESP_02.ESP_Laengsbeschl [m/s2],
                      LWI_01.LWI_Lenkradwinkel [deg],
                      ESP_05.ESP_Fahrer_bremst
===================== ============================================== =====================================
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from modelcast.core.exceptions import ConfigError
from modelcast.node.inputs.samples import PLAUSIBLE

__all__ = ["PRESETS", "UNITS", "Signal", "read_signals", "unit_scale"]

_DEGREE = math.pi / 180.0

UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "m/s": ("speed", 1.0),
        "km/h": ("speed", 1.0 / 3.6),
        "kph": ("speed", 1.0 / 3.6),
        "Unit_KiloMeterPerHour": ("speed", 1.0 / 3.6),
        "mph": ("speed", 1609.344 / 3600.0),
        "rad/s": ("turn", 1.0),
        "deg/s": ("turn", _DEGREE),
        "deg/sec": ("turn", _DEGREE),
        "Unit_DegreOfArcPerSecon": ("turn", _DEGREE),
        "m/s2": ("acceleration", 1.0),
        "m/s^2": ("acceleration", 1.0),
        "Unit_MeterPerSeconSquar": ("acceleration", 1.0),
        "g": ("acceleration", 9.80665),
        "rad": ("angle", 1.0),
        "deg": ("angle", _DEGREE),
        "Deg": ("angle", _DEGREE),
        "Unit_DegreOfArc": ("angle", _DEGREE),
        "flag": ("flag", 1.0),
    }
)
"""Units by name: what they measure, and what one is in SI."""

_MEASURES = {
    "speed_mps": "speed",
    "yaw_rate_radps": "turn",
    "acceleration_mps2": "acceleration",
    "steering_rad": "angle",
    "brake": "flag",
}

PRESETS: Mapping[str, str] = MappingProxyType(
    {
        "toyota_prius_2010_pt": (
            "speed_mps=SPEED.SPEED[mph], yaw_rate_radps=KINEMATICS.YAW_RATE[-0.244 deg/s], "
            "acceleration_mps2=ACCELEROMETER.ACCEL_X[m/s2], "
            "steering_rad=STEER_ANGLE_SENSOR.STEER_ANGLE[-deg], brake=BRAKE_MODULE.BRAKE_PRESSED[flag]"
        ),
        "vw_mqb": (
            "speed_mps=ESP_21.ESP_v_Signal[km/h], "
            "yaw_rate_radps=ESP_02.ESP_Gierrate~ESP_VZ_Gierrate[-deg/s], "
            "acceleration_mps2=ESP_02.ESP_Laengsbeschl[m/s2], "
            "steering_rad=LWI_01.LWI_Lenkradwinkel~LWI_VZ_Lenkradwinkel[-deg], "
            "brake=ESP_05.ESP_Fahrer_bremst[flag]"
        ),
    }
)
"""Maps by the name of a public DBC file."""

_ENTRY = re.compile(r"(\w+)=(\w+)\.(\w+)(?:~(\w+))?(?:\[(-?)\s*([0-9.]*)\s*([^\]\s]+)\])?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """Where a quantity is found.

    Parameters
    ----------
    quantity
        A key of `modelcast.node.inputs.samples.PLAUSIBLE`.
    message, signal
        Names in the DBC.
    sign
        Signal of the same message that is 1 where the value is negative; none where empty.
    scale
        What the DBC's value is multiplied by for SI and our direction; NaN for what its unit says.
    """

    quantity: str
    message: str
    signal: str
    sign: str = ""
    scale: float = math.nan


def unit_scale(quantity: str, unit: str) -> float:
    """What a value in a unit is multiplied by for the quantity's own.

    Parameters
    ----------
    quantity
        A key of `modelcast.node.inputs.samples.PLAUSIBLE`.
    unit
        A key of `UNITS`.

    Raises
    ------
    ConfigError
        Where the unit is unknown or measures something else.

    Examples
    --------
    >>> unit_scale("speed_mps", "km/h") * 36.0
    10.0
    """
    measure, scale = UNITS.get(unit, ("", math.nan))
    if measure != _MEASURES[quantity]:
        fitting = ", ".join(name for name, (what, _) in UNITS.items() if what == _MEASURES[quantity])
        raise ConfigError(
            f"{quantity} cannot be in {unit!r}: write one of {fitting} in brackets behind the signal"
        )
    return scale


def read_signals(text: str) -> tuple[Signal, ...]:
    """The map that a text describes, or the preset it names.

    Parameters
    ----------
    text
        See the module.

    Raises
    ------
    ConfigError
        Where it is neither, or names a quantity twice.

    Examples
    --------
    >>> found = read_signals("speed_mps=A.B[km/h], yaw_rate_radps=A.C[-0.1 deg/s]")
    >>> [round(signal.scale, 4) for signal in found]
    [0.2778, -0.0017]
    """
    found: dict[str, Signal] = {}
    for entry in PRESETS.get(text.strip(), text).split(","):
        match = _ENTRY.fullmatch(entry.strip())
        if match is None:
            raise ConfigError(
                f"{entry.strip()!r} is no signal: write quantity=Message.Signal[unit], or one of the presets "
                f"{', '.join(PRESETS)}"
            )
        quantity, message, signal, sign, minus, factor, unit = match.groups(default="")
        if quantity not in PLAUSIBLE or quantity in found:
            raise ConfigError(f"each of {', '.join(PLAUSIBLE)} may stand once, got {quantity!r}")
        scale = math.nan
        if unit:
            try:
                scale = unit_scale(quantity, unit) * float(factor or "1") * (-1.0 if minus else 1.0)
            except ValueError as error:
                raise ConfigError(f"{factor!r} in {entry.strip()!r} is no number") from error
        found[quantity] = Signal(quantity=quantity, message=message, signal=signal, sign=sign, scale=scale)
    return tuple(found.values())

"""Sensors that have a name, with the source of their figures.

A figure that a source states as half of the errors being below it counts as 0.67 standard deviations (speed,
heading), or 1.18 of an axis (position). Data sheets state sizes; how fast an error wanders, and how late a
sample comes, they seldom do. `NamedSensor.certainty` says what is measured, stated or assumed.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from math import pi
from types import MappingProxyType

from modelcast.core.near_names import near
from modelcast.world.sensors import IDEAL, SensorModel

__all__ = ["SENSORS", "NamedSensor", "named_sensor", "sensor_table"]

_DEGREE = pi / 180.0


@dataclass(frozen=True, slots=True)
class NamedSensor:
    """A sensor, and where its figures come from.

    Parameters
    ----------
    model
        The errors.
    what
        What it stands for.
    source
        Where the figures come from.
    certainty
        Which of them are measured, stated or assumed.
    """

    model: SensorModel
    what: str
    _: KW_ONLY
    source: str
    certainty: str


SENSORS: Mapping[str, NamedSensor] = MappingProxyType(
    {
        "default": NamedSensor(
            SensorModel(),
            "the measured protocol: carrier-phase corrections, speed of the wheels",
            source="this project's results; no device",
            certainty="assumed",
        ),
        "ideal": NamedSensor(IDEAL, "no errors", source="none", certainty="exact"),
        "gnss": NamedSensor(
            SensorModel(
                position_noise_m=0.0024,
                slow_position_noise_m=0.5,
                slow_correlation_s=300.0,
                speed_noise_mps=0.074,
                heading_noise_rad=0.44 * _DEGREE,
                latency_s=0.1,
            ),
            "a plain receiver in a car",
            source="position: a plain receiver beside an RTK one, 19 minutes in Beijing "
            "(Spratm-Asleaf/DRSE-Jump), without its mean error: 0.5 m an axis, 2.4 mm white, correlation "
            "0.96 at 10 s and 0.84 at 60 s; speed and heading: u-blox F9 data sheets, 0.05 m/s and 0.3° for "
            "half of the errors at 30 m/s",
            certainty="position measured on one drive; speed and heading stated; rates and latency assumed",
        ),
        "gnss-rtk": NamedSensor(
            SensorModel(
                position_noise_m=0.005,
                slow_position_noise_m=0.016,
                slow_correlation_s=100.0,
                speed_noise_mps=0.074,
                heading_noise_rad=0.44 * _DEGREE,
                latency_s=0.1,
            ),
            "a receiver with real-time kinematic corrections, fixed, base 10 km away",
            source="size, speed and heading: u-blox ZED-F9P data sheet, 1 cm + 1 ppm (circle of half of the "
            "errors), 0.05 m/s, 0.3°; white part: RTK records of Tampa and Beijing, 3 to 6.5 mm; correlation "
            "time: middle of the 10 to 900 s that bound carrier multipath in NAVIGATION, after Joerger and "
            "Pervan (2020)",
            certainty="sizes stated; white part measured; correlation time within wide bounds; rates and "
            "latency assumed",
        ),
        "ins": NamedSensor(
            SensorModel(
                position_noise_m=0.003,
                slow_position_noise_m=0.0095,
                slow_correlation_s=100.0,
                speed_noise_mps=0.014,
                heading_noise_rad=0.1 * _DEGREE,
                acceleration_noise_mps2=0.01,
                yaw_rate_noise_radps=0.01 * _DEGREE,
                latency_s=0.0035,
            ),
            "an inertial system with RTK, as used for reference",
            source="OxTS RT3000 manual: 1 cm (one sigma, taken as that of an axis), 3.5 ms, 0.05 km/h, "
            "0.1°, 0.01 m/s², 0.01°/s; white part: the Applanix system of Boreas, 3 mm",
            certainty="position and latency stated; the other sizes quoted from memory; white part measured "
            "after the drive, not during it; correlation time as for gnss-rtk",
        ),
        "phone": NamedSensor(
            SensorModel(
                position_noise_m=0.01,
                slow_position_noise_m=4.1,
                slow_correlation_s=1800.0,
                multipath_noise_m=0.5,
                multipath_correlation_s=60.0,
                speed_noise_mps=0.3,
                heading_noise_rad=2.0 * _DEGREE,
                acceleration_noise_mps2=0.2,
                yaw_rate_noise_radps=0.5 * _DEGREE,
                latency_s=0.2,
            ),
            "a smartphone under open sky",
            source="size: GPS.gov, 4.9 m after van Diggelen and Enge (ION GNSS+ 2015), taken as the circle "
            "of half of the errors; correlation times: so slow that noise over a second is that of cyclists' "
            "cameras in London, 2 to 4 cm, and within the bounds for troposphere (900 to 2,700 s) and code "
            "multipath (10 to 900 s) in NAVIGATION, after Joerger and Pervan (2020)",
            certainty="size stated, its meaning assumed; jitter measured on other devices; all else assumed",
        ),
    }
)
"""All named sensors, by name."""


def named_sensor(name: str) -> SensorModel:
    """The errors of a sensor that has a name.

    Parameters
    ----------
    name
        One of `SENSORS`.

    Raises
    ------
    ValueError
        Where no sensor has that name.

    Examples
    --------
    >>> named_sensor("gnss").slow_position_noise_m
    0.5
    """
    if name not in SENSORS:
        raise ValueError(f"sensor must be one of {', '.join(SENSORS)}, got {name!r}{near(name, SENSORS)}")
    return SENSORS[name].model


def sensor_table() -> str:
    """The named sensors as the two tables of docs/protocols.md: their figures, then their sources."""
    columns = (
        "white, cm",
        "slow, m (s)",
        "multipath, m (s)",
        "speed, m/s",
        "heading, °",
        "acceleration, m/s²",
        "yaw rate, °/s",
        "latency, s",
    )
    figures = [f"| sensor | {' | '.join(columns)} |", "|---" * (1 + len(columns)) + "|"]
    sources = ["| sensor | what | source | how sure |", "|---|---|---|---|"]
    for name, sensor in SENSORS.items():
        m = sensor.model
        cells = (
            f"{100.0 * m.position_noise_m:.3g}",
            _process(m.slow_position_noise_m, m.slow_correlation_s),
            _process(m.multipath_noise_m, m.multipath_correlation_s),
            f"{m.speed_noise_mps:.3g}",
            f"{m.heading_noise_rad / _DEGREE:.3g}",
            f"{m.acceleration_noise_mps2:.3g}",
            f"{m.yaw_rate_noise_radps / _DEGREE:.3g}",
            f"{m.latency_s:.3g}",
        )
        figures.append(f"| `{name}` | {' | '.join(cells)} |")
        sources.append(f"| `{name}` | {sensor.what} | {sensor.source} | {sensor.certainty} |")
    return "\n".join([*figures, "", *sources])


def _process(size_m: float, correlation_s: float) -> str:
    return f"{size_m:.3g} ({correlation_s:g})" if size_m > 0.0 else "0"

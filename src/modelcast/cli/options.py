"""Options that several commands share."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import CoercionError, Parameter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cyclopts import Token

    from modelcast.study.compare.settings import Protocol
    from modelcast.world.sensors import SensorModel

__all__ = [
    "Columns",
    "Count",
    "Format",
    "Numbers",
    "Paths",
    "Rate",
    "SensorOptions",
    "Source",
    "Words",
    "parse_columns",
]


def _whole(kind: type, tokens: "Sequence[Token]") -> int:
    """The whole number that a word is; cyclopts would round others."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise CoercionError(token=tokens[0], target_type=kind) from None


Count = Annotated[int, Parameter(converter=_whole)]
"""A whole number."""

Numbers = Annotated[tuple[float, ...], Parameter(consume_multiple=True, negative="")]
"""Several numbers after one another."""

Words = Annotated[tuple[str, ...], Parameter(consume_multiple=True, negative="")]
"""Several words after one another."""

Paths = Annotated[tuple[Path, ...], Parameter(consume_multiple=True, negative="")]
"""Several files or folders after one another."""

Source = Annotated[str, Parameter(allow_leading_hyphen=True)]
"""A file, or - for the standard input, or the content itself."""

Format = Annotated[
    str | None,
    Parameter(help="Name of the files' format; found from their content where not given."),
]

Columns = Annotated[
    str | None,
    Parameter(
        help="Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v' or "
        "'t=time,lat=latitude,lon=longitude', optionally 'vehicle=id'."
    ),
]


Rate = Annotated[
    float | None,
    Parameter(
        help="Take trips as read so many times a second, each sample the last one recorded at or before its "
        "reading [Hz]; as recorded where not given. Trips recorded more slowly are left out. Samples of "
        "uneven recordings are interpolated before, from the row behind too."
    ),
]


@Parameter(name="*")
@dataclass(frozen=True)
class SensorOptions:
    """What the sender measures in the sensor protocol, and a vehicle of a fleet of itself.

    Parameters
    ----------
    sensor
        Sensor by name: default, ideal, gnss, gnss-rtk, ins, phone. Where not given: default.
        The options below, where given, replace what it has. For recorded trips a name asks for the sensor
        protocol: the log, smoothed where it needs it, is the truth, and the sender gets the sensor's view of
        it.
    position_noise
        White position noise [m].
    slow_noise
        Slowly varying position noise [m].
    speed_noise
        Speed noise [m/s].
    heading_noise
        Heading noise [deg].
    latency
        Age of what the sender sees [s].
    shared_bias
        Share of the variance of the slowly varying position noise, 0..1, that all vehicles of a fleet have in
        common (orbits, atmosphere); the rest is each one's own (multipath).
    """

    sensor: str | None = None
    position_noise: float | None = None
    slow_noise: float | None = None
    speed_noise: float | None = None
    heading_noise: float | None = None
    latency: float | None = None
    shared_bias: float | None = None

    def model(self) -> "SensorModel":
        """The sensor model they mean.

        Raises
        ------
        ConfigError
            Where no sensor has that name, or a value is out of its range.
        """
        from dataclasses import replace
        from math import radians

        from modelcast.core.exceptions import ConfigError
        from modelcast.world.named_sensors import named_sensor

        given = {
            "position_noise_m": self.position_noise,
            "slow_position_noise_m": self.slow_noise,
            "speed_noise_mps": self.speed_noise,
            "heading_noise_rad": None if self.heading_noise is None else radians(self.heading_noise),
            "latency_s": self.latency,
            "shared_slow_ratio": self.shared_bias,
        }
        found = {name: value for name, value in given.items() if value is not None}
        try:
            return replace(named_sensor(self.sensor or "default"), **found)
        except ValueError as error:
            raise ConfigError(str(error)) from error

    def protocols(self, asked: "Sequence[Protocol]") -> "tuple[Protocol, ...]":
        """What is meant by protocols where a sensor may be named: auto is sensor then.

        Parameters
        ----------
        asked
            As the user names them.

        Raises
        ------
        ConfigError
            Where a sensor is named, and every protocol shows the sender the log instead.
        """
        from modelcast.core.exceptions import ConfigError

        if self.sensor is None:
            return tuple(asked)
        found: dict[Protocol, None] = dict.fromkeys("sensor" if one == "auto" else one for one in asked)
        if "sensor" not in found:
            raise ConfigError(
                f"--sensor {self.sensor}: with --protocol recorded the sender sees the log itself, through "
                "no sensor: leave one of the two out, or take --protocol sensor"
            )
        return tuple(found)


def parse_columns(text: str | None) -> dict[str, str] | None:
    """A column map from ``meaning=name`` pairs.

    Parameters
    ----------
    text
        Pairs separated by commas; None for no map.

    Raises
    ------
    ConfigError
        Where a pair has no equals sign.

    Examples
    --------
    >>> parse_columns("t=time,east=x")
    {'t': 'time', 'east': 'x'}
    """
    from modelcast.core.exceptions import ConfigError

    if text is None:
        return None
    pairs: dict[str, str] = {}
    for part in text.split(","):
        meaning, equals, name = part.partition("=")
        if not (equals and meaning.strip() and name.strip()):
            raise ConfigError(f"--columns: '{part}' is not meaning=name, as in t=time,east=x,north=y")
        pairs[meaning.strip()] = name.strip()
    return pairs

"""How a sender estimates the four values of Part I: a polynomial each, chosen by the vehicle's own noise."""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import AbstractRule, FieldError, Fixed, Number, Text, Whole, check_fields
from modelcast.models.learned.features import FeatureMap

__all__ = ["COLUMNS", "Estimates", "Window", "derivative_of", "levels_of", "map_of"]

Window = tuple[str, int, int]
"""What a polynomial is fitted to (`COLUMNS`), its length in tenths of a second, and its degree."""

COLUMNS = ("newest", "position", "velocity", "speed")
"""``newest``: no polynomial, the newest sample's own value."""

_WINDOW: AbstractRule = Fixed((Text(16), Whole(0, 100), Whole(0, 4)))


@dataclass(frozen=True, slots=True)
class Estimates:
    """Estimates of one range of noise.

    Parameters
    ----------
    up_to_noise_m
        It serves vehicles whose positions are at most so noisy; infinite for any [m].
    reports
        And that report all of this: the sum of 1 for speed, 2 for heading, 4 for acceleration and 8 for yaw
        rate. A velocity made from positions wants other windows than one of a wheel sensor.
    speed
        Speed along the course: the slope of positions, or the value of velocities or of reported speeds.
    course
        Velocity to the left of the newest one, from positions or velocities.
    acceleration
        Along the course: the second derivative of positions, or the slope of velocities or reported speeds.
    yaw_rate
        By the acceleration to the left, from positions or velocities, over the speed.

    Raises
    ------
    ValueError
        Where a window cannot give its value.

    Examples
    --------
    >>> short = Estimates(0.01, speed=("speed", 3, 1), course=("position", 8, 2))
    >>> short.places(map_of((short,), 12))
    (9, 6, -1, -1)
    """

    up_to_noise_m: Annotated[float, Number(0.0, 1000.0, over=True, infinite=True)]
    _: KW_ONLY
    reports: Annotated[int, Whole(0, 15)] = 0
    speed: Annotated[Window, _WINDOW] = ("newest", 0, 0)
    course: Annotated[Window, _WINDOW] = ("newest", 0, 0)
    acceleration: Annotated[Window, _WINDOW] = ("newest", 0, 0)
    yaw_rate: Annotated[Window, _WINDOW] = ("newest", 0, 0)

    def __post_init__(self) -> None:
        check_fields(self)
        for name, (column, length, degree) in self.windows.items():
            if column not in COLUMNS:
                raise FieldError(name, column, f"one of {', '.join(COLUMNS)}")
            if column == "newest":
                continue
            if column == "speed" and name in ("course", "yaw_rate"):
                raise FieldError(name, column, "position, velocity or newest: a speed has no direction")
            needed = derivative_of(name, column)
            if not needed <= degree <= length:
                raise FieldError(name, (column, length, degree), f"a degree from {needed} to the length")

    @property
    def windows(self) -> dict[str, Window]:
        """The four windows by what they estimate."""
        return {
            "speed": self.speed,
            "course": self.course,
            "acceleration": self.acceleration,
            "yaw_rate": self.yaw_rate,
        }

    def places(self, features: FeatureMap) -> tuple[int, ...]:
        """Index of each estimate among the inputs, -1 for the newest sample's own.

        Parameters
        ----------
        features
            A map that has these polynomials.

        Raises
        ------
        ValueError
            Where it lacks one.
        """
        found: list[int] = []
        for name, (column, length, degree) in self.windows.items():
            if column == "newest":
                found.append(-1)
                continue
            place = features.place_of(column, (length, degree), derivative_of(name, column))
            found.append(place + (name in ("course", "yaw_rate")))
        return tuple(found)


def derivative_of(name: str, column: str) -> int:
    """Which derivative of a column an estimate is.

    Parameters
    ----------
    name, column
        One of `Estimates.windows`, and what its polynomial is fitted to.
    """
    return (1 if column == "position" else 0) + (name in ("acceleration", "yaw_rate"))


def levels_of(estimates: tuple[Estimates, ...], features: FeatureMap) -> FloatArray:
    """Ranges of noise, reports and places among the inputs, as the compiled estimates take them, (L x 6,).

    Parameters
    ----------
    estimates
        L of them.
    features
        A map that has their polynomials.
    """
    rows = [[one.up_to_noise_m, one.reports, *one.places(features)] for one in estimates]
    return np.array(rows, dtype=np.float64).ravel()


def map_of(estimates: tuple[Estimates, ...], lags: int, beside: FeatureMap | None = None) -> FeatureMap:
    """Map of inputs with the polynomials of some estimates.

    Parameters
    ----------
    estimates
        Of all ranges of noise.
    lags
        How many tenths of a second a window reaches back.
    beside
        A map whose inputs are wanted too.
    """
    wanted = FeatureMap(lags, (), ()) if beside is None else beside
    fits = {column: list(known) for column, known in wanted.fits.items()}
    for one in estimates:
        for column, length, degree in one.windows.values():
            if column != "newest" and (length, degree) not in fits[column]:
                fits[column].append((length, degree))
    return FeatureMap(
        lags,
        tuple(fits["position"]),
        tuple(fits["velocity"]),
        tuple(fits["speed"]),
        wanted.context,
    )

"""How road users move, as safety applications take it: a row each, believed or true."""

from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.kinds import SIZES_M, Kind

__all__ = ["LENGTH_M", "WIDTH_M", "Motions"]

LENGTH_M, WIDTH_M = SIZES_M[Kind.VEHICLE]
"""Of a vehicle that states no size [m]: a mid-size car."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """N vehicles at one instant, or one at N instants; applications take two of them row by row.

    Positions are those of the vehicles' middles. A row that is not known is NaN, and what an application says
    of it is nothing.

    Parameters
    ----------
    position_m
        East and north, (N, 2) [m].
    speed_mps
        Along the course, not negative, (N,) [m/s].
    heading_rad
        Course, clockwise from north, (N,) [rad].
    acceleration_mps2
        Along the course, (N,) [m/s²].
    yaw_rate_radps
        Of the course, clockwise, (N,) [rad/s].
    length_m, width_m
        (N,) [m].
    covariance_m2
        Of the position, (N, 2, 2) [m²]; None where it counts as exact.
    kind
        Of road user, values of `modelcast.core.kinds.Kind`, (N,); None where all are vehicles.

    Raises
    ------
    ValueError
        Where shapes differ.

    Examples
    --------
    >>> Motions.of([[0.0, 0.0]], speed_mps=[20.0], heading_rad=[0.0]).velocity_mps
    array([[ 0., 20.]])
    """

    position_m: FloatArray
    _: KW_ONLY
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    length_m: FloatArray
    width_m: FloatArray
    covariance_m2: FloatArray | None = None
    kind: IntArray | None = None

    def __post_init__(self) -> None:
        if self.position_m.ndim != 2 or self.position_m.shape[1] != 2:
            raise ValueError(f"position_m must have shape (N, 2), got {self.position_m.shape}")
        count = len(self)
        for name in (
            "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps", "length_m", "width_m",
        ):  # fmt: skip
            shape = getattr(self, name).shape
            if shape != (count,):
                raise ValueError(f"{name} must have shape {(count,)}, got {shape}")
        if self.covariance_m2 is not None and self.covariance_m2.shape != (count, 2, 2):
            raise ValueError(f"covariance_m2 must have shape {(count, 2, 2)}, got {self.covariance_m2.shape}")
        if self.kind is not None and self.kind.shape != (count,):
            raise ValueError(f"kind must have shape {(count,)}, got {self.kind.shape}")

    @classmethod
    def of(
        cls,
        position_m: npt.ArrayLike,
        *,
        speed_mps: npt.ArrayLike,
        heading_rad: npt.ArrayLike,
        acceleration_mps2: npt.ArrayLike = 0.0,
        yaw_rate_radps: npt.ArrayLike = 0.0,
        length_m: npt.ArrayLike = LENGTH_M,
        width_m: npt.ArrayLike = WIDTH_M,
        covariance_m2: npt.ArrayLike | None = None,
        kind: npt.ArrayLike | None = None,
    ) -> "Motions":
        """Motions from anything like arrays; one number counts for all rows.

        Parameters
        ----------
        position_m, speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
            As in `Motions`.
        length_m, width_m, covariance_m2, kind
            As in `Motions`; sizes that are not known (NaN) are `LENGTH_M` and `WIDTH_M`.
        """
        place = np.asarray(position_m, dtype=np.float64).reshape(-1, 2)

        def column(values: npt.ArrayLike) -> FloatArray:
            given = np.asarray(values, dtype=np.float64)
            return given if given.ndim else np.full(len(place), float(given))

        length, width = column(length_m), column(width_m)
        return cls(
            place,
            speed_mps=column(speed_mps),
            heading_rad=column(heading_rad),
            acceleration_mps2=column(acceleration_mps2),
            yaw_rate_radps=column(yaw_rate_radps),
            length_m=np.where(np.isnan(length), LENGTH_M, length),
            width_m=np.where(np.isnan(width), WIDTH_M, width),
            covariance_m2=None if covariance_m2 is None else np.asarray(covariance_m2, dtype=np.float64),
            kind=None if kind is None else np.broadcast_to(np.asarray(kind, dtype=np.int64), len(place)),
        )

    def __len__(self) -> int:
        return int(self.position_m.shape[0])

    @property
    def velocity_mps(self) -> FloatArray:
        """East and north, (N, 2) [m/s]."""
        course = np.stack([np.sin(self.heading_rad), np.cos(self.heading_rad)], axis=1)
        return self.speed_mps[:, None] * course

"""Frames that no honest station sends: many names at once, and octets without sense."""

import math
from typing import final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.bsm_batch import codes_of_values, encode_cores
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.wsmp import encode_wsm
from modelcast.node.trials.drive import Driven

__all__ = ["InventedVehicles", "random_frames"]

_AROUND_M = 300.0
_DEGREE_M = 111_000.0
_FASTEST_MPS = 30.0
_IDS = 2**32


@final
class InventedVehicles:
    """Vehicles that are not there; each keeps its name, and drives straight on at one speed.

    Parameters
    ----------
    count
        How many.
    near
        They begin within some hundred metres of it.
    from_utc_s
        When they begin, since 1970 [s].
    rng
        Draws names, places and motions.

    Examples
    --------
    >>> here = Driven(
    ...     latitude_deg=48.0,
    ...     longitude_deg=11.0,
    ...     speed_mps=0.0,
    ...     heading_rad=0.0,
    ...     acceleration_mps2=0.0,
    ...     yaw_rate_radps=0.0,
    ... )
    >>> crowd = InventedVehicles(5, near=here, from_utc_s=0.0, rng=np.random.default_rng(1))
    >>> len(crowd.frames(range(2), utc_s=0.5)), np.unique(crowd.names).size
    (2, 5)
    """

    def __init__(self, count: int, *, near: Driven, from_utc_s: float, rng: np.random.Generator) -> None:
        self.names: IntArray = rng.choice(_IDS, size=count, replace=False).astype(np.int64)
        """Temporary ids, (N,)."""
        self._from_s, self._near = from_utc_s, near
        self._start_m: FloatArray = rng.uniform(-_AROUND_M, _AROUND_M, (count, 2))
        self._speed_mps: FloatArray = rng.uniform(0.0, _FASTEST_MPS, count)
        self._heading_rad: FloatArray = rng.uniform(0.0, 2.0 * math.pi - 1e-3, count)

    def frames(self, which: range, *, utc_s: float) -> list[bytes]:
        """What some of them say: basic safety messages in which every field is right.

        Parameters
        ----------
        which
            Rows of `names`.
        utc_s
            When [s].
        """
        rows = np.arange(which.start, which.stop, which.step)
        speed, heading = self._speed_mps[rows], self._heading_rad[rows]
        course = np.stack([np.sin(heading), np.cos(heading)], axis=1)
        place_m = self._start_m[rows] + (utc_s - self._from_s) * speed[:, None] * course
        east_degree_m = _DEGREE_M * math.cos(math.radians(self._near.latitude_deg))
        values = np.full((rows.size, len(CORE_FIELDS)), np.nan)
        filled: dict[str, FloatArray | float] = {
            "message_count": math.floor(utc_s * 10.0) % 128,
            "temporary_id": self.names[rows].astype(np.float64),
            "second_of_minute_s": math.floor(utc_s * 1000.0) % 60_000 / 1000.0,
            "latitude_deg": self._near.latitude_deg + place_m[:, 1] / _DEGREE_M,
            "longitude_deg": self._near.longitude_deg + place_m[:, 0] / east_degree_m,
            "speed_mps": speed,
            "heading_rad": heading,
            "yaw_rate_radps": 0.0,
        }
        for name, column in filled.items():
            values[:, CORE_INDEX[name]] = column
        octets, lengths = encode_cores(codes_of_values(values))
        return [
            encode_wsm(encode_unsecured(frame[:length].tobytes()))
            for frame, length in zip(octets, lengths.tolist(), strict=True)
        ]


def random_frames(count: int, rng: np.random.Generator, *, longest: int = 300) -> list[bytes]:
    """Frames of evenly drawn octets, 1 to ``longest`` of them each.

    Parameters
    ----------
    count
        How many.
    rng
        Draws.
    longest
        Octets of the longest.

    Examples
    --------
    >>> len(random_frames(3, np.random.default_rng(1)))
    3
    """
    return [rng.bytes(int(rng.integers(1, longest + 1))) for _ in range(count)]

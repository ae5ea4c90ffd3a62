"""Pairs of motions for the tests of the applications, and what changes nothing about them."""

import numpy as np
import pytest

from modelcast.apps.motions import Motions
from modelcast.core.arrays import FloatArray


def _pair(
    offset_m: tuple[float, float] = (0.0, 0.0),
    *,
    host: tuple[float, float, float] = (20.0, 0.0, 0.0),
    remote: tuple[float, float, float] = (20.0, 0.0, 0.0),
    turn_rad: float = 0.0,
    covariance_m2: FloatArray | None = None,
) -> tuple[Motions, Motions]:
    """One pair: the host at the origin heads north; a motion is speed, acceleration, yaw rate."""
    covariance = None if covariance_m2 is None else covariance_m2[None]
    return (
        Motions.of([[0.0, 0.0]], speed_mps=host[0], heading_rad=0.0, acceleration_mps2=host[1],
                   yaw_rate_radps=host[2]),
        Motions.of([offset_m], speed_mps=remote[0], heading_rad=turn_rad, acceleration_mps2=remote[1],
                   yaw_rate_radps=remote[2], covariance_m2=covariance),
    )  # fmt: skip


def _random_pairs(rng: np.random.Generator, rows: int, *, known: bool = True) -> tuple[Motions, Motions]:
    """Pairs within some 80 m in all directions; every tenth remote unknown if told so."""

    def one(place: FloatArray, heading: FloatArray) -> Motions:
        spread = rng.normal(0.0, 1.0, (rows, 2, 2))
        return Motions.of(
            place,
            speed_mps=rng.uniform(0.0, 35.0, rows) * (rng.random(rows) > 0.1),
            heading_rad=heading,
            acceleration_mps2=rng.uniform(-7.0, 3.0, rows),
            yaw_rate_radps=rng.normal(0.0, 0.05, rows),
            length_m=rng.uniform(3.0, 12.0, rows),
            width_m=rng.uniform(1.5, 2.5, rows),
            covariance_m2=spread @ spread.transpose(0, 2, 1),
            kind=rng.permutation(np.arange(rows) % 4),
        )

    heading = rng.uniform(-np.pi, np.pi, rows)
    way, aside = rng.uniform(-20.0, 80.0, rows), rng.normal(0.0, 4.0, rows)
    forth = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    right = np.stack([forth[:, 1], -forth[:, 0]], axis=1)
    place = rng.uniform(-1e3, 1e3, (rows, 2))
    remote_place = place + way[:, None] * forth + aside[:, None] * right
    if not known:
        remote_place[::10] = np.nan
    turn = rng.choice([0.0, 0.3, np.pi / 2, -np.pi / 2, np.pi], rows) + rng.normal(0.0, 0.1, rows)
    return one(place, heading), one(remote_place, heading + turn)


def _moved(motions: Motions, turn_rad: float, by_m: tuple[float, float]) -> Motions:
    """Turned clockwise about the origin, then shifted."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, s], [-s, c]])
    covariance = motions.covariance_m2
    return Motions.of(
        motions.position_m @ turn.T + np.array(by_m),
        speed_mps=motions.speed_mps,
        heading_rad=motions.heading_rad + turn_rad,
        acceleration_mps2=motions.acceleration_mps2,
        yaw_rate_radps=motions.yaw_rate_radps,
        length_m=motions.length_m,
        width_m=motions.width_m,
        covariance_m2=None if covariance is None else turn @ covariance @ turn.T,
        kind=motions.kind,
    )


@pytest.fixture(scope="session")
def pair():
    """One pair of motions."""
    return _pair


@pytest.fixture(scope="session")
def random_pairs():
    """Many pairs of motions."""
    return _random_pairs


@pytest.fixture(scope="session")
def moved():
    """The same motions elsewhere."""
    return _moved

"""Sizes of cooperative awareness messages as cars sent them on roads, and other sizes that follow a chain."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel_types import FloatMatrix, IntVector
from modelcast.core.markov import MarkovChain

__all__ = ["FrameSizeNumbers", "FrameSizes", "measured_cam_sizes", "no_sizes"]


class FrameSizeNumbers(NamedTuple):
    """Sizes as kernels take them.

    ``size_bytes`` (K,) by state, empty where frames are as long as what they hold; ``up_to`` (K + 1, K) as
    `MarkovChain.up_to` has it; ``mean_bytes`` is the mean.
    """

    size_bytes: IntVector
    up_to: FloatMatrix
    mean_bytes: int


@dataclass(frozen=True, slots=True)
class FrameSizes:
    """Whole frames whose size follows a Markov chain, whatever they hold.

    Parameters
    ----------
    size_bytes
        By state, (K,).
    chain
        K states.

    Raises
    ------
    ValueError
        Where there is not one positive size a state.

    Examples
    --------
    >>> round(measured_cam_sizes().mean_bytes)
    312
    """

    size_bytes: tuple[int, ...]
    chain: MarkovChain

    def __post_init__(self) -> None:
        if len(self.size_bytes) != len(self.chain.steps) or min(self.size_bytes) < 1:
            raise ValueError(f"size_bytes must be one positive number a state, got {self.size_bytes}")

    @property
    def mean_bytes(self) -> float:
        """Mean size in the long run."""
        return float(self.chain.stationary @ np.array(self.size_bytes))

    @property
    def numbers(self) -> FrameSizeNumbers:
        """The sizes as kernels take them."""
        return FrameSizeNumbers(
            np.array(self.size_bytes, dtype=np.int64), self.chain.up_to(), round(self.mean_bytes)
        )


def no_sizes() -> FrameSizeNumbers:
    """Return what kernels take where frames are as long as what they hold."""
    return FrameSizeNumbers(np.empty(0, dtype=np.int64), np.ones((1, 1)), 0)


def measured_cam_sizes() -> FrameSizes:
    """Frames of Volkswagen's test cars on all roads: 200, 300, 360 or 455 bytes, in four states.

    The first-order chain of sizes alone that was fitted to recorded messages, with signature and certificate
    as they came; security and headers are within. TR 2052 of the Car 2 Car Communication Consortium has a
    mean of 357 bytes over both manufacturers [second-hand].

    References
    ----------
    R. Molina-Masegosa, M. Sepulcre, J. Gozalvez, F. Berens, V. Martinez, "Empirical models for the realistic
    generation of cooperative awareness messages in vehicular networks", IEEE Transactions on Vehicular
    Technology 2020, DOI 10.1109/TVT.2020.2979232; figures as in its published models.
    """
    chain = MarkovChain(
        (
            (0.15321, 0.44801, 0.072477, 0.3263),
            (0.50228, 0.017199, 0.34679, 0.13373),
            (0.15774, 0.71592, 0.099215, 0.027123),
            (0.47776, 0.142, 0.015825, 0.36441),
        )
    )
    return FrameSizes((200, 300, 360, 455), chain)

"""Linear kernel: a line through the window's last sample."""

from dataclasses import dataclass
from typing import ClassVar

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernel_codes import LINEAR
from modelcast.models.gp.kernels.base import AbstractLeaf, Hyperparameter

__all__ = ["Linear"]


@dataclass(frozen=True, slots=True)
class Linear(AbstractLeaf):
    """``s²·t·u`` with times as multiples of a second: the variance is that of the way gone in one.

    Parameters
    ----------
    variance
        s² [m²].
    """

    name: ClassVar[str] = "linear"
    code: ClassVar[int] = LINEAR
    shape: ClassVar[tuple[Hyperparameter, ...]] = ()
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:  # noqa: ARG004
        """Product of the times."""
        return t_s * u_s

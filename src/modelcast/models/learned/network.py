"""A small network as plain arrays: squashed inputs, two layers of rectifiers, linear outputs."""

import hashlib
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["Network"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Network:
    """Weights of one network: ``asinh((x - centre) / width)``, two hidden layers, a linear output.

    Parameters
    ----------
    up_to_noise_m
        It serves windows whose position noise is at most this; infinite for any [m].
    centre, width
        Of every input, (I,).
    weights_1, weights_2, weights_3
        (I, H1), (H1, H2) and (H2, O).
    bias_1, bias_2, bias_3
        (H1,), (H2,) and (O,).

    Raises
    ------
    ValueError
        Where shapes do not fit, a value is not finite, or a width is not positive.
    """

    up_to_noise_m: float
    _: KW_ONLY
    centre: FloatArray
    width: FloatArray
    weights_1: FloatArray
    bias_1: FloatArray
    weights_2: FloatArray
    bias_2: FloatArray
    weights_3: FloatArray
    bias_3: FloatArray

    def __post_init__(self) -> None:
        if not self.up_to_noise_m > 0.0:
            raise ValueError(f"up_to_noise_m must be positive, got {self.up_to_noise_m}")
        for name, wanted in self._shapes().items():
            array: FloatArray = getattr(self, name)
            if array.shape != wanted:
                raise ValueError(f"{name} must be {wanted}, got {array.shape}")
            if not np.isfinite(array).all():
                raise ValueError(f"{name} must be finite")
        if not (self.width > 0.0).all():
            raise ValueError("width must be positive")

    def _shapes(self) -> dict[str, tuple[int, ...]]:
        inputs = self.centre.size
        first, second = self.bias_1.size, self.bias_2.size
        outputs = self.bias_3.size
        return {
            "centre": (inputs,),
            "width": (inputs,),
            "weights_1": (inputs, first),
            "bias_1": (first,),
            "weights_2": (first, second),
            "bias_2": (second,),
            "weights_3": (second, outputs),
            "bias_3": (outputs,),
        }

    @property
    def inputs(self) -> int:
        """Length I of the input."""
        return self.centre.size

    @property
    def outputs(self) -> int:
        """Length O of the output."""
        return self.bias_3.size

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Network):
            return NotImplemented
        same = all(np.array_equal(getattr(self, name), getattr(other, name)) for name in self._shapes())
        return same and self.up_to_noise_m == other.up_to_noise_m

    def __repr__(self) -> str:
        digest = hashlib.sha256(self.packed().tobytes()).hexdigest()[:12]
        sizes = f"{self.inputs}-{self.bias_1.size}-{self.bias_2.size}-{self.outputs}"
        return f"Network({self.up_to_noise_m!r}, layers={sizes}, sha256={digest})"

    def __hash__(self) -> int:
        return hash((self.up_to_noise_m, self.weights_1.tobytes(), self.weights_3.tobytes()))

    def packed(self) -> FloatArray:
        """All numbers in one vector, as the compiled network reads them.

        Layer sizes first; weights output by output, so that each dot product runs along memory.
        """
        sizes = np.array([self.up_to_noise_m, self.bias_1.size, self.bias_2.size])
        parts = (
            sizes,
            self.centre,
            1.0 / self.width,
            self.weights_1.T.ravel(),
            self.bias_1,
            self.weights_2.T.ravel(),
            self.bias_2,
            self.weights_3.T.ravel(),
            self.bias_3,
        )
        return np.concatenate(parts)

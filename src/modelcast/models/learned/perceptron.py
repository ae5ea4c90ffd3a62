"""A small network as plain arrays: squashed inputs, two layers of rectifiers, linear outputs."""

import hashlib
from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import FieldError, Number, Numbers, check_fields

__all__ = ["MOST_UNITS", "Perceptron"]

MOST_UNITS = 1024
"""Inputs, units of a layer or outputs at most: ten times the shipped networks."""

_ANY = Number(-1e6, 1e6)
_VECTOR, _MATRIX = Numbers(1, _ANY, MOST_UNITS), Numbers(2, _ANY, MOST_UNITS)
_WIDTH = Numbers(1, Number(1e-6, 1e6), MOST_UNITS)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Perceptron:
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
        Where shapes do not fit, or a value is out of its range.
    """

    up_to_noise_m: Annotated[float, Number(0.0, 1000.0, over=True, infinite=True)]
    _: KW_ONLY
    centre: Annotated[FloatArray, _VECTOR]
    width: Annotated[FloatArray, _WIDTH]
    weights_1: Annotated[FloatArray, _MATRIX]
    bias_1: Annotated[FloatArray, _VECTOR]
    weights_2: Annotated[FloatArray, _MATRIX]
    bias_2: Annotated[FloatArray, _VECTOR]
    weights_3: Annotated[FloatArray, _MATRIX]
    bias_3: Annotated[FloatArray, _VECTOR]

    def __post_init__(self) -> None:
        check_fields(self)
        for name, wanted in self._shapes().items():
            array: FloatArray = getattr(self, name)
            if array.shape != wanted:
                raise FieldError(name, array, f"of shape {wanted}, as the other layers say")

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
        if not isinstance(other, Perceptron):
            return NotImplemented
        same = all(np.array_equal(getattr(self, name), getattr(other, name)) for name in self._shapes())
        return same and self.up_to_noise_m == other.up_to_noise_m

    def __repr__(self) -> str:
        digest = hashlib.sha256(self.packed().tobytes()).hexdigest()[:12]
        sizes = f"{self.inputs}-{self.bias_1.size}-{self.bias_2.size}-{self.outputs}"
        return f"Perceptron({self.up_to_noise_m!r}, layers={sizes}, sha256={digest})"

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

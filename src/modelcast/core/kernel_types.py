"""Types of a kernel's arguments: the same annotation is read by the type checker and by the compiler.

Plain ``float``, ``int`` and ``bool`` are 64-bit numbers and truth values; ``tuple[...]`` and named tuples are
made of what they hold; an array is one of the names below, contiguous unless it says otherwise.
"""

import typing
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from numba import from_dtype, types

__all__ = [
    "BoolMatrix",
    "BoolVector",
    "Float32Cube",
    "Float32Matrix",
    "Float32Vector",
    "FloatBlock",
    "FloatCube",
    "FloatMatrix",
    "FloatVector",
    "Int16Matrix",
    "Int32Matrix",
    "Int32Vector",
    "IntCube",
    "IntMatrix",
    "IntVector",
    "Layout",
    "StridedFloatMatrix",
    "StridedFloatVector",
    "UInt8Matrix",
    "UInt8Vector",
    "UInt64Vector",
    "numba_type",
]

_numba: Any = types  # Numba's type objects have no useful types themselves
_from_dtype: Any = from_dtype


@dataclass(frozen=True, slots=True)
class Layout:
    """How an array lies in memory.

    Parameters
    ----------
    dtype
        Its element type, or the name of it; a structured one is aligned.
    dimensions
        Number of its axes; 0 for one record of an array.
    order
        ``C`` for contiguous, ``A`` for any strides.
    """

    dtype: Any
    dimensions: int
    order: str = "C"


FloatVector = Annotated[npt.NDArray[np.float64], Layout("float64", 1)]
FloatMatrix = Annotated[npt.NDArray[np.float64], Layout("float64", 2)]
FloatCube = Annotated[npt.NDArray[np.float64], Layout("float64", 3)]
FloatBlock = Annotated[npt.NDArray[np.float64], Layout("float64", 4)]
StridedFloatVector = Annotated[npt.NDArray[np.float64], Layout("float64", 1, "A")]
StridedFloatMatrix = Annotated[npt.NDArray[np.float64], Layout("float64", 2, "A")]
IntVector = Annotated[npt.NDArray[np.int64], Layout("int64", 1)]
IntMatrix = Annotated[npt.NDArray[np.int64], Layout("int64", 2)]
IntCube = Annotated[npt.NDArray[np.int64], Layout("int64", 3)]
BoolVector = Annotated[npt.NDArray[np.bool_], Layout("bool", 1)]
Float32Vector = Annotated[npt.NDArray[np.float32], Layout("float32", 1)]
Float32Matrix = Annotated[npt.NDArray[np.float32], Layout("float32", 2)]
Float32Cube = Annotated[npt.NDArray[np.float32], Layout("float32", 3)]
Int16Matrix = Annotated[npt.NDArray[np.int16], Layout("int16", 2)]
Int32Matrix = Annotated[npt.NDArray[np.int32], Layout("int32", 2)]
Int32Vector = Annotated[npt.NDArray[np.int32], Layout("int32", 1)]

UInt8Vector = Annotated[npt.NDArray[np.uint8], Layout("uint8", 1)]
UInt8Matrix = Annotated[npt.NDArray[np.uint8], Layout("uint8", 2)]
UInt64Vector = Annotated[npt.NDArray[np.uint64], Layout("uint64", 1)]
BoolMatrix = Annotated[npt.NDArray[np.bool_], Layout("bool", 2)]

_SCALARS: dict[Any, Any] = {
    float: types.float64,
    int: types.int64,
    bool: types.boolean,
    None: types.void,
    type(None): types.void,
}


def numba_type(annotation: Any) -> Any:
    """Return the compiler's type for an annotation.

    Parameters
    ----------
    annotation
        As a kernel states it for an argument or for what it returns.

    Raises
    ------
    TypeError
        Where it is none of those that this module describes.

    Examples
    --------
    >>> numba_type(FloatMatrix), numba_type(float), numba_type(tuple[int, bool])
    (Array(float64, 2, 'C', False, aligned=True), float64, Tuple((int64, bool)))
    """
    if annotation in _SCALARS:
        return _SCALARS[annotation]
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is Annotated:
        layout = next((one for one in arguments[1:] if isinstance(one, Layout)), None)
        if layout is not None:
            element = _element(layout.dtype)
            return _numba.Array(element, layout.dimensions, layout.order) if layout.dimensions else element
    if origin is tuple and arguments and arguments[-1] is not Ellipsis:
        return _numba.BaseTuple.from_types(tuple(numba_type(one) for one in arguments))
    if hasattr(annotation, "_fields"):
        hints = typing.get_type_hints(annotation, include_extras=True)
        return _numba.BaseTuple.from_types(tuple(numba_type(one) for one in hints.values()), annotation)
    if isinstance(annotation, type) and issubclass(annotation, np.generic):
        return _element(annotation)
    raise TypeError(
        f"a kernel takes and returns numbers, tuples and the arrays of kernel_types, not {annotation!r}"
    )


def _element(dtype: Any) -> Any:
    """Return the compiler's type of an element."""
    chosen: Any = np.dtype
    return _from_dtype(chosen(dtype))

"""Names for the array types that every layer uses, and arrays as kernels take them."""

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["BoolArray", "FloatArray", "IntArray", "SingleArray", "owned"]

FloatArray = npt.NDArray[np.float64]
SingleArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def owned(values: Any, dtype: Any = np.float64) -> Any:
    """Return an array as a kernel takes it: of a type, contiguous, writeable; itself where it is all that.

    Parameters
    ----------
    values
        Any array; one that is read-only or has other strides is copied.
    dtype
        Element type.

    Examples
    --------
    >>> every_other = np.arange(4.0)[::2]
    >>> owned(every_other).flags.c_contiguous, owned(every_other.copy()) is every_other
    (True, False)
    """
    given: Any = values
    if isinstance(values, np.ndarray) and given.dtype == dtype and given.flags.carray:
        return given
    return np.require(given, dtype, ["C", "W"])

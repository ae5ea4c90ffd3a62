"""Sub-models as plain values and back: what a profile writes down.

A frozen dataclass becomes a mapping of its fields with its class's name under ``is``; an array becomes its
shape and the base64 text of its little-endian 32-bit floats; a tuple becomes a list; an infinite number
becomes the text ``inf`` or ``-inf``. Only the classes of `PLAIN_CLASSES` are made from a text that came from
elsewhere, and each checks its own fields.
"""

import base64
import binascii
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, cast

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.gaussian_process import Hyperparameters
from modelcast.models.gp.vehicle import VehicleProcess
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.learned import LearnedTrajectory, Network, Selector
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.regimes import Regimes
from modelcast.models.trusted import Trusted

__all__ = ["PLAIN_CLASSES", "from_plain", "to_plain"]

PLAIN_CLASSES: dict[str, type] = {
    cls.__name__: cls
    for cls in (
        AxisKernel,
        ConstantAcceleration,
        ConstantTurnRateAcceleration,
        ConstantTurnRateVelocity,
        ConstantVelocity,
        GaussianProcess,
        Hyperparameters,
        LearnedTrajectory,
        Network,
        PredictedPath,
        Regimes,
        Selector,
        Trusted,
        VehicleProcess,
    )
}
"""Classes that a profile may name."""


def to_plain(value: Any) -> Any:
    """Return a value in terms of JSON.

    Parameters
    ----------
    value
        Numbers, text, None, arrays, sequences and mappings of these, and dataclasses of `PLAIN_CLASSES`.

    Raises
    ------
    TypeError
        Where it is anything else.
    ValueError
        Where a number is none (NaN).

    Examples
    --------
    >>> to_plain(ConstantVelocity())
    {'is': 'ConstantVelocity', 'acceleration_spread_mps2': 1.0}
    >>> from_plain(to_plain(Trusted(ConstantVelocity(), 1.0, np.inf)))
    Trusted(model=ConstantVelocity(acceleration_spread_mps2=1.0), horizon_s=1.0, turn_s=inf)
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        if value != value:  # noqa: PLR0124 - NaN
            raise ValueError("a profile holds no NaN")
        return value if np.isfinite(value) else ("inf" if value > 0.0 else "-inf")
    if isinstance(value, np.ndarray):
        array = cast("FloatArray", value)
        text = base64.b64encode(array.astype("<f4").tobytes()).decode("ascii")
        return {"float32": text, "shape": list(array.shape)}
    if isinstance(value, Mapping):
        items = cast("Mapping[object, object]", value).items()
        return {str(key): to_plain(item) for key, item in items}
    if isinstance(value, Sequence):
        return [to_plain(item) for item in cast("Sequence[object]", value)]
    name = type(value).__name__
    if is_dataclass(value) and PLAIN_CLASSES.get(name) is type(value):
        return {
            "is": name,
            **{item.name: to_plain(getattr(value, item.name)) for item in fields(value) if item.init},
        }
    raise TypeError(f"a profile holds no {name}: {value!r}")


def from_plain(plain: Any) -> Any:
    """Return the value that `to_plain` described; lists come back as tuples.

    Parameters
    ----------
    plain
        As read from JSON.

    Raises
    ------
    ValueError
        Where a class is unknown, a field is missing or foreign, an array is damaged, or a class refuses its
        fields.
    """
    if isinstance(plain, list):
        return tuple(from_plain(item) for item in cast("list[Any]", plain))
    if isinstance(plain, str) and plain in ("inf", "-inf"):
        return float(plain)
    if not isinstance(plain, dict):
        return plain
    mapping = cast("dict[str, Any]", plain)
    if "float32" in mapping:
        return _array(mapping)
    if "is" not in mapping:
        return {key: from_plain(item) for key, item in mapping.items()}
    name = mapping["is"]
    cls = PLAIN_CLASSES.get(name) if isinstance(name, str) else None
    if cls is None:
        raise ValueError(f"no class {name!r} may stand in a profile; there are {', '.join(PLAIN_CLASSES)}")
    found = {key: from_plain(item) for key, item in mapping.items() if key != "is"}
    try:
        return cls(**found)
    except (TypeError, AttributeError) as error:
        raise ValueError(f"{name}: {error}") from error


def _array(mapping: Mapping[str, Any]) -> FloatArray:
    if set(mapping) != {"float32", "shape"}:
        raise ValueError(f"an array has float32 and shape, got {', '.join(sorted(mapping))}")
    try:
        raw = base64.b64decode(mapping["float32"], validate=True)
        shape = tuple(int(size) for size in mapping["shape"])
        array = np.frombuffer(raw, dtype="<f4").astype(np.float64).reshape(shape)
    except (binascii.Error, TypeError, ValueError) as error:
        raise ValueError(f"damaged array: {error}") from error
    return array

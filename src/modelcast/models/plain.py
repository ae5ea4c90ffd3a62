"""Sub-models as plain values and back: what a profile writes down.

A frozen dataclass becomes a mapping of its fields with its class's name under ``is``; an array becomes its
shape and the base64 text of its little-endian 32-bit floats; a tuple becomes a list; an infinite number
becomes the text ``inf`` or ``-inf``. Only the classes of `PLAIN_CLASSES` are made from a text that came from
elsewhere, and each checks its own fields; what is refused is named by its path, ``$.members[0].samples``.

A sub-model of another package is written down by the name it is registered by, with its package, the version
of that, and its fields. A text can only name what an installed package registers.
"""

import base64
import math
import warnings
from collections.abc import Mapping, Sequence, Sized
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError, ModelcastWarning
from modelcast.core.open_group import Origin
from modelcast.core.printable import printable
from modelcast.core.rules import (
    AbstractRule,
    Anything,
    Each,
    FieldError,
    Keys,
    Table,
    Text,
    Whole,
    check,
    shown,
)
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.free import Estimates, FreeMotion, Limits
from modelcast.models.gp import GaussianProcess
from modelcast.models.gp.conditional import AxisKernel
from modelcast.models.gp.expression import KernelProcess
from modelcast.models.gp.gaussian_process import Hyperparameters
from modelcast.models.gp.vehicle import VehicleProcess
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.learned import FeatureMap, LearnedTrajectory, Perceptron, Selector
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.regimes import Regimes
from modelcast.models.stop_and_go import StopAndGo
from modelcast.models.sub_models import SUB_MODELS, registered_model, registered_name
from modelcast.models.switching import LinearMode, StochasticHybridSystem
from modelcast.models.trusted import Trusted

__all__ = ["PLAIN_CLASSES", "REGISTERED", "from_plain", "to_plain"]

PLAIN_CLASSES: dict[str, type] = {
    "Network" if cls is Perceptron else cls.__name__: cls
    for cls in (
        AxisKernel,
        ConstantAcceleration,
        ConstantTurnRateAcceleration,
        ConstantTurnRateVelocity,
        ConstantVelocity,
        Estimates,
        FeatureMap,
        FreeMotion,
        GaussianProcess,
        Hyperparameters,
        InteractingMultipleModel,
        KernelProcess,
        LearnedTrajectory,
        Limits,
        LinearMode,
        Perceptron,
        PredictedPath,
        Regimes,
        Selector,
        StochasticHybridSystem,
        StopAndGo,
        Trusted,
        VehicleProcess,
    )
}
"""Classes that a profile may name, by the names it uses; those of an old class stay what they were."""

REGISTERED = "registered"
"""What stands for the class of a sub-model that another package registers."""

_REGISTERED: AbstractRule = Keys(
    {
        "is": Anything(),
        "name": Text(64),
        "package": Text(200),
        "version": Text(200),
        "fields": Table(Anything(), 100),
    }
)

_KEPT = (
    "fields hold Python's own numbers and text, tuples, tables by text other than 'is' and 'float32', arrays "
    "of float64 with 1 to 3 axes, none of them empty, whose numbers fit in 32 bits, sub-models, and "
    "dataclasses of modelcast that profiles name: write one of your own as a tuple or a table"
)
"""What the fields of a registered sub-model may be."""

_NAMES: dict[type[object], str] = {cls: name for name, cls in PLAIN_CLASSES.items()}


def to_plain(value: Any) -> Any:
    """Return a value in terms of JSON.

    Parameters
    ----------
    value
        Numbers, text, None, arrays, sequences and mappings of these, dataclasses of `PLAIN_CLASSES`, and
        sub-models that other packages register.

    Raises
    ------
    TypeError
        Where it is anything else.
    ValueError
        Where a number is none (NaN), or a field of a registered sub-model would not come back as it is.

    Examples
    --------
    >>> to_plain(ConstantVelocity())
    {'is': 'ConstantVelocity', 'acceleration_spread_mps2': 1.0}
    >>> from_plain(to_plain(Trusted(ConstantVelocity(), 1.0, np.inf)))
    Trusted(model=ConstantVelocity(acceleration_spread_mps2=1.0), horizon_s=1.0, turn_s=inf)
    """
    if value is None or isinstance(value, bool | int | float | str):
        return _scalar(value)
    if isinstance(value, np.ndarray):
        array = cast("FloatArray", value)
        text = base64.b64encode(array.astype("<f4").tobytes()).decode("ascii")
        return {"float32": text, "shape": list(array.shape)}
    if isinstance(value, Mapping):
        items = cast("Mapping[object, object]", value).items()
        return {str(key): to_plain(item) for key, item in items}
    if isinstance(value, Sequence):
        return [to_plain(item) for item in cast("Sequence[object]", value)]
    return _instance_plain(value)


def _scalar(value: bool | float | str | None) -> bool | int | float | str | None:
    """A number or text as Python's own class of it, as JSON gives it back."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return str.__str__(value)
    if isinstance(value, int):
        return int(value)
    if value != value:  # noqa: PLR0124 - NaN
        raise ValueError("a profile holds no NaN")
    return float(value) if np.isfinite(value) else ("inf" if value > 0.0 else "-inf")


def _instance_plain(value: Any) -> dict[str, Any]:
    """What is no number, text, array or container, in terms of JSON."""
    kind = cast("type[object]", type(value))
    if kind in _NAMES:
        own = {item.name: to_plain(getattr(value, item.name)) for item in fields(value) if item.init}
        return {"is": _NAMES[kind], **own}
    name = registered_name(kind)
    if name:
        return _registered_plain(value, name)
    remedy = f"; register it in {SUB_MODELS.name!r}" if isinstance(value, AbstractSubModel) else ""
    raise TypeError(f"a profile holds no {kind.__name__}: {shown(value)}{remedy}")


def _registered_plain(value: Any, name: str) -> dict[str, Any]:
    """A sub-model of another package in terms of JSON."""
    origin = SUB_MODELS.origin(name) or Origin("", "")
    plain: dict[str, Any] = {}
    for item in fields(value):
        if item.init:
            plain[item.name], unkept = _written(getattr(value, item.name), item.name)
            if unkept:
                raise ValueError(
                    f"the sub-model {name} would not come back from a profile as it is: {unkept}; {_KEPT}"
                )
    return {
        "is": REGISTERED,
        "name": name,
        "package": origin.package,
        "version": origin.version,
        "fields": plain,
    }


def _written(one: Any, path: str) -> tuple[Any, str]:
    """A value in terms of JSON, and what of it does not come back, in words; empty where all does."""
    try:
        plain = to_plain(one)
    except (TypeError, ValueError) as error:
        return None, _unkept_part(one, path) or f"{path}: {error}"
    try:
        other = from_plain(plain, path)
    except ValueError as error:  # its text begins with the place
        return None, _unkept_part(one, path) or _unreadable(one, path) or str(error)
    return plain, _changed(one, other, path)


def _unreadable(one: Any, path: str) -> str:
    """What of an array or a table cannot be read again, in words; empty where it is something else."""
    if isinstance(one, np.ndarray):
        return f"{path} is an array of shape {cast('NDArray[Any]', one).shape}"
    if isinstance(one, Mapping):
        own = [key for key in ("is", "float32") if key in one]
        return f"the key {own[0]!r} of {path} has a meaning of its own in profiles" if own else ""
    return ""


def _unkept_part(one: Any, path: str) -> str:
    """What `_written` says of the first part that does not come back."""
    return next(filter(None, (_written(part, where)[1] for where, part in _parts(one, path))), "")


def _parts(one: Any, path: str) -> list[tuple[str, Any]]:
    """What a value is made of, with the place of each; nothing where it is one thing."""
    if isinstance(one, list | tuple):
        return [(f"{path}[{at}]", part) for at, part in enumerate(cast("Sequence[Any]", one))]
    if isinstance(one, Mapping):
        return [(f"{path}[{key!r}]", part) for key, part in cast("Mapping[Any, Any]", one).items()]
    if is_dataclass(one) and (type(one) in _NAMES or isinstance(one, AbstractSubModel)):
        return [(f"{path}.{item.name}", getattr(one, item.name)) for item in fields(one) if item.init]
    return []


def _changed(one: Any, other: Any, path: str) -> str:
    """What of a value comes back as another, in words; empty where nothing does."""
    if type(one) is not type(other):
        return f"{path} is {shown(one)} ({type(one).__name__}) and would come back as {type(other).__name__}"
    if isinstance(one, np.ndarray):
        return _changed_array(cast("NDArray[Any]", one), other, path)
    parts = _parts(one, path)
    if isinstance(one, tuple | Mapping) and len(parts) != len(cast("Sized", other)):
        return f"{path} would come back with {len(other)} parts, not {len(parts)}"
    if isinstance(one, Mapping):
        missing = [key for key in cast("Mapping[Any, Any]", one) if key not in other]
        if missing:
            return f"the key {shown(missing[0])} of {path} would come back as text"
    elif not parts and one != other:
        text = shown(cast("object", one))
        return f"{path} is {text} and would come back as {shown(other)}"
    pairs = zip(parts, _parts(other, path), strict=True)
    return next(filter(None, (_changed(own, back, where) for (where, own), (_, back) in pairs)), "")


def _changed_array(one: NDArray[Any], other: FloatArray, path: str) -> str:
    """What of an array comes back as another, in words."""
    if one.dtype != other.dtype:
        return f"{path} is an array of {one.dtype} and would come back as {other.dtype}"
    if not np.array_equal(one, other):
        return f"{path} would come back with other numbers: a profile keeps 32 bits of each, and no NaN"
    return ""


def _registered(mapping: Mapping[str, Any], path: str) -> AbstractSubModel:
    """The sub-model of another package that a text names."""
    check(mapping, _REGISTERED, path)
    name: str = mapping["name"]
    wanted = Origin(mapping["package"], mapping["version"])
    if name not in SUB_MODELS.foreign_names():
        raise ValueError(
            f"{path}: the sub-model {shown(name)} is of the package {shown(wanted.package)}, version "
            f"{shown(wanted.version)}, and no installed package registers it"
        )
    given = {key: from_plain(one, f"{path}.fields.{key}") for key, one in mapping["fields"].items()}
    try:
        found = SUB_MODELS.origin(name) or wanted
        if found.package != wanted.package:
            raise FieldError(f"{path}.package", wanted.package, f"{found.package}, which registers {name}")
        member = registered_model(name, **given)
    except ConfigError as error:
        raise ValueError(f"{path}: {error}") from error
    if found.version != wanted.version:
        warnings.warn(
            f"The sub-model {name} of a profile is of {printable(str(wanted))}; {found} is installed, which "
            "may compute other numbers. Messages name the profile by the installed version.",
            ModelcastWarning,
            stacklevel=2,
        )
    return member


def from_plain(plain: Any, path: str = "$") -> Any:
    """Return the value that `to_plain` described; lists come back as tuples.

    Parameters
    ----------
    plain
        As read from JSON.
    path
        Where it stands, for errors.

    Raises
    ------
    ValueError
        Where a class is unknown, a field is missing or foreign, an array is damaged, or a class refuses its
        fields; the text begins with the path of what is wrong.
    """
    if isinstance(plain, list):
        return tuple(from_plain(item, f"{path}[{at}]") for at, item in enumerate(cast("list[Any]", plain)))
    if isinstance(plain, str) and plain in ("inf", "-inf"):
        return float(plain)
    if not isinstance(plain, dict):
        return plain
    mapping = cast("dict[str, Any]", plain)
    if "float32" in mapping:
        return _array(mapping, path)
    if "is" not in mapping:
        return {key: from_plain(item, f"{path}.{key}") for key, item in mapping.items()}
    return _instance(mapping, path)


def _instance(mapping: Mapping[str, Any], path: str) -> Any:
    name = mapping["is"]
    if name == REGISTERED:
        return _registered(mapping, path)
    cls = PLAIN_CLASSES.get(name) if isinstance(name, str) else None
    if cls is None:
        raise FieldError(f"{path}.is", name, f"one of {', '.join(PLAIN_CLASSES)}")
    known = {item.name: item for item in fields(cls) if item.init}
    for key in mapping:
        if key != "is" and key not in known:
            raise ValueError(f"{path}: {name} has no field {shown(key)}; it has {', '.join(known)}")
    for key, item in known.items():
        if key not in mapping and item.default is MISSING and item.default_factory is MISSING:
            raise ValueError(f"{path}: {name} needs the field {key}")
    found = {key: from_plain(item, f"{path}.{key}") for key, item in mapping.items() if key != "is"}
    try:
        return cls(**found)
    except FieldError as error:
        raise error.below(path) from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


_MOST_ARRAY = 1 << 22
_ARRAY: AbstractRule = Keys({"float32": Text(4 * _MOST_ARRAY), "shape": Each(Whole(1, _MOST_ARRAY), 1, 3)})


def _array(mapping: Mapping[str, Any], path: str) -> FloatArray:
    check(mapping, _ARRAY, path)
    shape: list[int] = mapping["shape"]
    try:
        raw = base64.b64decode(mapping["float32"], validate=True)
    except ValueError as error:
        raise FieldError(f"{path}.float32", mapping["float32"], f"an array as base64 ({error})") from error
    if len(raw) != 4 * math.prod(shape):
        raise FieldError(path, shape, f"an array whose shape fits its {len(raw)} octets, four a number")
    return np.frombuffer(raw, dtype="<f4").astype(np.float64).reshape(shape)

"""Rows of a policy's state: those of some vehicles taken out, and put back.

A state is None, an array whose first axis is the vehicles, or a tuple, named tuple or dataclass of such.
"""

from dataclasses import fields, is_dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import PolicyError

__all__ = ["check_state", "put_rows", "take_rows"]


def check_state(state: Any, vehicles: int, name: str) -> None:
    """Refuse a state whose rows are not the vehicles.

    Parameters
    ----------
    state
        What a policy's ``init`` gave.
    vehicles
        For how many.
    name
        Of the policy, for errors.

    Raises
    ------
    PolicyError
        Where it is none of the kinds that this module knows, or an array has other rows.
    """
    if state is None:
        return
    if isinstance(state, np.ndarray):
        if not state.shape or state.shape[0] != vehicles:
            raise PolicyError(
                f"{name}: an array of the state must have {vehicles} rows, got shape {state.shape}"
            )
        return
    for part in _parts(state, name):
        check_state(part, vehicles, name)


def take_rows(state: Any, rows: IntArray) -> Any:
    """Return the state of some vehicles.

    Parameters
    ----------
    state
        Of all vehicles.
    rows
        Which, (B,).

    Examples
    --------
    >>> take_rows((np.arange(4.0), None), np.array([3, 1]))
    (array([3., 1.]), None)
    """

    def take(part: Any, _place: str) -> Any:
        return part[rows]

    return _joined([state], take)


def put_rows(state: Any, rows: IntArray, some: Any, name: str) -> Any:
    """Return the state with that of some vehicles put in; the given ones are left alone.

    Parameters
    ----------
    state
        Of all vehicles.
    rows
        Which, (B,).
    some
        Their state: of the same parts, with as many columns, and of numbers that the given ones can hold:
        finite ones stay finite and whole ones stay the same, fractions may be rounded (float64 to float32).
    name
        Of the policy, for errors.

    Raises
    ------
    PolicyError
        Where it is none of that; it names the part, what was given and what was expected.

    Examples
    --------
    >>> put_rows(np.zeros(4), np.array([3, 1]), np.array([7.0, 8.0]), "It")
    array([0., 8., 0., 7.])
    >>> put_rows((np.zeros(4, dtype=int),), np.array([3]), (np.array([0.5]),), "It")
    Traceback (most recent call last):
    modelcast.core.exceptions.PolicyError: It: state[0] began as int64 and cannot hold float64: let init \
give an array of float64
    """

    def put(part: Any, own: Any, place: str) -> Any:
        after = part.copy()
        after[rows] = _fitting(own, part, rows.size, f"{name}: {place}")
        return after

    return _joined([state, some], put, name)


def _fitting(own: Any, part: Any, count: int, what: str) -> Any:
    """Some rows as an array of a state holds them; refused where that would cut them.

    Numbers with fractions are rounded to those of the array: a float32 keeps some 7 digits of a float64. What
    is finite stays finite, and all else stays what it is: whole numbers and truth values to the last digit,
    as fractions too, and texts to their last letter.
    """
    wanted = (count, *part.shape[1:])
    if own.shape != wanted:
        raise PolicyError(f"{what} must have shape {wanted}, as init gave it, got {own.shape}")
    if own.dtype == part.dtype:
        return own
    remedy = f"let init give an array of {own.dtype}"
    if not np.can_cast(own.dtype, part.dtype, "same_kind"):
        raise PolicyError(f"{what} began as {part.dtype} and cannot hold {own.dtype}: {remedy}")
    with np.errstate(over="ignore", under="ignore"):
        held = own.astype(part.dtype)
    cut = _cut(own, held)
    if cut.any():
        raise PolicyError(
            f"{what} began as {part.dtype} and cannot hold {own.dtype} ({own[cut][0]}): {remedy}"
        )
    return held


def _cut(own: NDArray[Any], held: NDArray[Any]) -> NDArray[np.bool_]:
    """Which values another type of the same kind does not hold; rounded fractions are held."""
    if np.issubdtype(own.dtype, np.inexact):
        return np.isfinite(own) & ~np.isfinite(held)
    if np.issubdtype(held.dtype, np.inexact):  # Python compares a whole number with a fraction exactly
        return held.astype(object) != own.astype(object)
    return held != own


def _parts(state: Any, name: str = "policy") -> list[Any]:
    if is_dataclass(state) and not isinstance(state, type):
        return [getattr(state, one.name) for one in fields(state)]
    if isinstance(state, tuple):
        return list(cast("tuple[Any, ...]", state))
    raise PolicyError(
        f"{name}: a state is None, an array, or a tuple or dataclass of arrays with a row a vehicle, "
        f"got {type(state).__name__}"
    )


def _named_parts(state: Any, place: str) -> list[str]:
    """Where the parts of a state stand in it."""
    if is_dataclass(state):
        return [f"{place}.{one.name}" for one in fields(state)]
    if hasattr(state, "_fields"):
        return [f"{place}.{name}" for name in state._fields]
    return [f"{place}[{at}]" for at in range(len(state))]


def _kind(state: Any) -> str:
    """What a state or a part of one is."""
    if state is None:
        return "nothing"
    return "an array" if isinstance(state, np.ndarray) else "parts"


def _joined(states: list[Any], make: Any, name: str = "policy", place: str = "state") -> Any:
    """Apply a function to the arrays that stand at the same place."""
    first = states[0]
    for other in states[1:]:
        if _kind(other) != _kind(first):
            raise PolicyError(
                f"{name}: {place} must be {_kind(first)}, as init gave it, got {type(other).__name__}"
            )
    if first is None:
        return None
    if isinstance(first, np.ndarray):
        return make(*states, place)
    parts = [_parts(state, name) for state in states]
    for other in parts[1:]:
        if len(other) != len(parts[0]):
            raise PolicyError(
                f"{name}: {place} must have {len(parts[0])} parts, as init gave it, got {len(other)}"
            )
    found = [
        _joined(list(own), make, name, where)
        for *own, where in zip(*parts, _named_parts(first, place), strict=True)
    ]
    if isinstance(first, tuple):
        return first._make(found) if hasattr(first, "_make") else tuple(found)  # type: ignore[attr-defined]
    return replace(first, **{one.name: part for one, part in zip(fields(first), found, strict=True)})

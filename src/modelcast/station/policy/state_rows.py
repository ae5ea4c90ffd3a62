"""Rows of a policy's state: those of some vehicles taken out, and put back.

A state is None, an array whose first axis is the vehicles, or a tuple, named tuple or dataclass of such.
"""

from dataclasses import fields, is_dataclass, replace
from typing import Any, cast

import numpy as np

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

    def take(part: Any) -> Any:
        return part[rows]

    return _joined([state], take)


def put_rows(state: Any, rows: IntArray, some: Any) -> Any:
    """Return the state with that of some vehicles put in; the given ones are left alone.

    Parameters
    ----------
    state
        Of all vehicles.
    rows
        Which, (B,).
    some
        Their state.

    Examples
    --------
    >>> put_rows(np.zeros(4), np.array([3, 1]), np.array([7.0, 8.0]))
    array([0., 8., 0., 7.])
    """

    def put(part: Any, own: Any) -> Any:
        after = part.copy()
        after[rows] = own
        return after

    return _joined([state, some], put)


def _parts(state: Any, name: str = "policy") -> list[Any]:
    if is_dataclass(state) and not isinstance(state, type):
        return [getattr(state, one.name) for one in fields(state)]
    if isinstance(state, tuple):
        return list(cast("tuple[Any, ...]", state))
    raise PolicyError(
        f"{name}: a state is None, an array, or a tuple or dataclass of arrays with a row a vehicle, "
        f"got {type(state).__name__}"
    )


def _joined(states: list[Any], make: Any) -> Any:
    """Apply a function to the arrays that stand at the same place."""
    first = states[0]
    if first is None:
        return None
    if isinstance(first, np.ndarray):
        return make(*states)
    found = [_joined(list(parts), make) for parts in zip(*map(_parts, states), strict=True)]
    if isinstance(first, tuple):
        return first._make(found) if hasattr(first, "_make") else tuple(found)  # type: ignore[attr-defined]
    return replace(first, **{one.name: part for one, part in zip(fields(first), found, strict=True)})

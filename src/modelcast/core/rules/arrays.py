"""Rules of lists and of rows and grids of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from modelcast.core.rules.base import AbstractRule, FieldError
from modelcast.core.rules.scalars import Number

__all__ = ["Each", "Grid", "Numbers"]


@dataclass(frozen=True, slots=True)
class Each(AbstractRule):
    """A list of `least` to `most` items, each as a rule says.

    Parameters
    ----------
    of
        The rule.
    least, most
        Bounds of the length.
    """

    of: AbstractRule
    least: int
    most: int

    @property
    def expected(self) -> str:
        """The length."""
        return f"a list of {self.least} to {self.most} items"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and lengths, then the first item that is wrong."""
        if not isinstance(value, tuple | list):
            return self._refused(value)
        items = cast("Sequence[object]", value)
        if not self.least <= len(items) <= self.most:
            return FieldError("", items, f"{self.expected} (here {len(items)})")
        for at, item in enumerate(items):
            found = self.of.fault(item)
            if found is not None:
                return found.below(f"[{at}]")
        return None


@dataclass(frozen=True, slots=True)
class Numbers(AbstractRule):
    """An array of floats, every one in a range.

    Parameters
    ----------
    dimensions
        How many.
    of
        The range.
    most
        Largest size of any dimension; the least is 1.
    least
        Smallest size of any dimension.
    """

    dimensions: int
    of: Number
    most: int
    least: int = 1

    @property
    def expected(self) -> str:
        """Dimensions and sizes."""
        return f"an array of {self.dimensions} dimensions with {self.least} to {self.most} items each"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and shapes, then the first number that is wrong."""
        if not isinstance(value, np.ndarray):
            return self._refused(value)
        array = cast("np.ndarray[Any, Any]", value)
        if array.dtype != np.float64 or array.ndim != self.dimensions:
            return self._refused(array)
        if not all(self.least <= size <= self.most for size in array.shape):
            return self._refused(array)
        above = array > self.of.low if self.of.over else array >= self.of.low
        good = above & (array <= self.of.high)
        if good.all():
            return None
        at = tuple(int(place) for place in np.argwhere(~good)[0])
        return FieldError("".join(f"[{place}]" for place in at), float(array[at]), self.of.expected)


@dataclass(frozen=True, slots=True)
class Grid(AbstractRule):
    """Lists in lists, all of one length at each level: what becomes an array.

    Parameters
    ----------
    dimensions
        How many.
    of
        What every number must be.
    most
        Largest length at any level; the least is 1.
    """

    dimensions: int
    of: Number
    most: int

    @property
    def expected(self) -> str:
        """Dimensions and sizes."""
        return f"lists {self.dimensions} deep, 1 to {self.most} items each, of one length at each level"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and lengths, then the first number that is wrong."""
        return self._fault(value, self._lengths(value))

    def _lengths(self, value: object) -> list[int]:
        """Lengths along the first items: those that all others must have."""
        found: list[int] = []
        while isinstance(value, list) and value and len(found) < self.dimensions:
            items = cast("list[object]", value)
            found.append(len(items))
            value = items[0]
        return found

    def _fault(self, value: object, lengths: list[int], level: int = 0) -> FieldError | None:
        if level == self.dimensions:
            return self.of.fault(value)
        items = cast("list[object]", value if isinstance(value, list) else [])
        if not items or level >= len(lengths) or len(items) != lengths[level] or len(items) > self.most:
            return self._refused(cast("object", value))
        for at, item in enumerate(items):
            found = self._fault(item, lengths, level + 1)
            if found is not None:
                return found.below(f"[{at}]")
        return None

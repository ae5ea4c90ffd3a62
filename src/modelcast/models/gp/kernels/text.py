"""Kernels as short expressions, ``linear+rbf`` or ``matern32*(linear+periodic)``, and back.

``*`` binds closer than ``+``; spaces count for nothing. An expression says which kernels and how they are
joined, not their hyper-parameters. `str` of a kernel is its canonical text: no spaces, no needless
parentheses.
"""

import re

from modelcast.models.gp.kernels.base import AbstractKernel, AbstractLeaf, Product, Sum
from modelcast.models.gp.kernels.linear import Linear
from modelcast.models.gp.kernels.matern import Matern12, Matern32, Matern52
from modelcast.models.gp.kernels.periodic import Periodic
from modelcast.models.gp.kernels.rational_quadratic import RationalQuadratic
from modelcast.models.gp.kernels.rbf import Rbf

__all__ = ["LEAVES", "MOST_CHARACTERS", "MOST_DEPTH", "MOST_LEAVES", "kernel_from_text"]

LEAVES: dict[str, type[AbstractLeaf]] = {
    cls.name: cls for cls in (Linear, Rbf, Matern12, Matern32, Matern52, RationalQuadratic, Periodic)
}
"""Kernels by the names that expressions use."""

MOST_CHARACTERS, MOST_DEPTH, MOST_LEAVES = 120, 8, 6
"""Bounds of an expression: its length, parentheses inside each other, and kernels. Six leaves are nine
products at most when multiplied out."""

_TOKEN = re.compile(r"\s*([A-Za-z_0-9]+|[^\sA-Za-z_0-9])")


def kernel_from_text(text: str) -> AbstractKernel:
    """Return the kernel of an expression; its hyper-parameters are 1.

    Parameters
    ----------
    text
        Names of `LEAVES` with ``+``, ``*`` and parentheses.

    Raises
    ------
    ValueError
        Where it is none, with the place, or larger than the bounds.

    Examples
    --------
    >>> str(kernel_from_text(" (linear + rbf) * (matern32)"))
    '(linear+rbf)*matern32'
    >>> kernel_from_text("linear+rfb")
    Traceback (most recent call last):
    ValueError: character 8 of 'linear+rfb': no kernel is named 'rfb'; there are linear, rbf, matern12, \
matern32, matern52, rq and periodic
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"a kernel's expression has at most {MOST_CHARACTERS} characters, got {len(text)}")
    reader = _Reader(text)
    kernel = reader.total(0)
    if reader.ahead():
        raise reader.error(f"expected + or * or the end, got {reader.ahead()!r}")
    return kernel


class _Reader:
    """Recursive descent over the tokens of one text."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = [(found.group(1), found.start(1)) for found in _TOKEN.finditer(text)]
        self._next = 0
        self._leaves = 0

    def ahead(self) -> str:
        """The next one; empty at the end."""
        return self._tokens[self._next][0] if self._next < len(self._tokens) else ""

    def error(self, what: str) -> ValueError:
        """Return what is wrong at the next token."""
        at = self._tokens[self._next][1] if self._next < len(self._tokens) else len(self._text)
        return ValueError(f"character {at + 1} of {self._text!r}: {what}")

    def total(self, depth: int) -> AbstractKernel:
        """Read a sum."""
        parts = [self._product(depth)]
        while self.ahead() == "+":
            self._next += 1
            parts.append(self._product(depth))
        return parts[0] if len(parts) == 1 else Sum(tuple(parts))

    def _product(self, depth: int) -> AbstractKernel:
        parts = [self._factor(depth)]
        while self.ahead() == "*":
            self._next += 1
            parts.append(self._factor(depth))
        return parts[0] if len(parts) == 1 else Product(tuple(parts))

    def _factor(self, depth: int) -> AbstractKernel:
        if self.ahead() == "(":
            if depth == MOST_DEPTH:
                raise self.error(f"parentheses inside each other at most {MOST_DEPTH} deep")
            self._next += 1
            inner = self.total(depth + 1)
            if self.ahead() != ")":
                got = self.ahead()
                raise self.error(f"expected ), got {got!r}" if got else "a ) is missing")
            self._next += 1
            return inner
        return self._leaf()

    def _leaf(self) -> AbstractKernel:
        names = list(LEAVES)
        known = f"there are {', '.join(names[:-1])} and {names[-1]}"
        if not self.ahead():
            raise self.error(f"a kernel is missing; {known}")
        if self.ahead() not in LEAVES:
            if not self.ahead()[0].isalnum():
                raise self.error(f"expected a kernel or (, got {self.ahead()!r}; {known}")
            raise self.error(f"no kernel is named {self.ahead()!r}; {known}")
        if self._leaves == MOST_LEAVES:
            raise self.error(f"an expression has at most {MOST_LEAVES} kernels")
        self._leaves += 1
        leaf = LEAVES[self.ahead()]()
        self._next += 1
        return leaf

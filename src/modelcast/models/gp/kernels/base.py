"""What a kernel is: a frozen value with one point-wise method; sums and products of kernels are kernels.

A kernel is a tree of *leaves*. Each leaf has shape hyper-parameters (a lengthscale, a period) and a variance.
Not all variances are free: a product of two kernels has one scale, not two. The rule, from the root down: all
parts of a free sum are free, of a bound one all but the first; the first factor of a free product is free, no
other factor is. So ``linear*rbf`` has one variance and ``linear+rbf`` two.
"""

import abc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = [
    "RATIO",
    "VARIANCE",
    "AbstractKernel",
    "AbstractLeaf",
    "Hyperparameter",
    "Place",
    "Product",
    "Sum",
]


@dataclass(frozen=True, slots=True)
class Hyperparameter:
    """One number of a kernel that a search may choose.

    Parameters
    ----------
    name
        With its unit at the end; none where it is a ratio.
    low, high
        Its bounds, 0 < low < high.
    """

    name: str
    low: float
    high: float


VARIANCE = Hyperparameter("variance_m2", 1e-8, 1e4)
"""Variance of a leaf that sets a scale. A deviation of 100 m, or of 100 m/s, is all that a vehicle needs;
more would leave a noise floor of 1 mm to the rounding of doubles."""

RATIO = Hyperparameter("variance_ratio", 1e-6, 1e6)
"""Variance of a leaf relative to the first part of its sum, where that sum is a factor."""


@dataclass(frozen=True, slots=True)
class Place:
    """A leaf and what its place in the tree makes of its variance.

    Parameters
    ----------
    leaf
        The leaf.
    free
        Whether its variance is a hyper-parameter.
    scales
        Whether its variance is a variance of positions, in m²; else it is a ratio.
    """

    leaf: "AbstractLeaf"
    free: bool
    scales: bool

    @property
    def hyperparameters(self) -> tuple[Hyperparameter, ...]:
        """Its variance where it is free, then its shape."""
        own = (VARIANCE if self.scales else RATIO,) if self.free else ()
        return (*own, *self.leaf.shape)

    @property
    def values(self) -> tuple[float, ...]:
        """Their values."""
        own = (self.leaf.variance,) if self.free else ()
        return (*own, *(float(getattr(self.leaf, one.name)) for one in self.leaf.shape))


class AbstractKernel(abc.ABC):
    """A covariance of positions at two times, with hyper-parameters; ``+`` and ``*`` make others."""

    def __add__(self, other: "AbstractKernel") -> "Sum":
        return Sum((self, other))

    def __mul__(self, other: "AbstractKernel") -> "Product":
        return Product((self, other))

    def __call__(self, t_s: FloatArray, u_s: FloatArray) -> FloatArray:
        """Covariance of the positions at times t and u, which are broadcast [m²].

        Parameters
        ----------
        t_s, u_s
            Times after the window's last sample [s].
        """
        return self.at(np.array(self.values), t_s, u_s)

    def at(self, values: FloatArray, t_s: FloatArray, u_s: FloatArray) -> FloatArray:
        """Covariance by given hyper-parameters, in the order of `hyperparameters` [m²].

        Parameters
        ----------
        values
            (..., P); what comes before P is broadcast with the times.
        t_s, u_s
            Times after the window's last sample [s].

        Raises
        ------
        ValueError
            Where P is another number.
        """
        wanted = len(self.hyperparameters)
        if values.shape[-1:] != (wanted,):
            raise ValueError(f"{self} has {wanted} hyper-parameters, got an array {values.shape}")
        return self.covariance(iter(np.moveaxis(values, -1, 0)), t_s, u_s, free=True)

    @property
    def hyperparameters(self) -> tuple[Hyperparameter, ...]:
        """All, leaf by leaf: ``rbf_2_lengthscale_s`` is that of the second leaf, an RBF."""
        return tuple(
            replace(one, name=f"{place.leaf.name}_{number}_{one.name}")
            for number, place in enumerate(self.places(), 1)
            for one in place.hyperparameters
        )

    @property
    def values(self) -> tuple[float, ...]:
        """Own values of them."""
        return tuple(value for place in self.places() for value in place.values)

    def with_values(self, values: Sequence[float]) -> "AbstractKernel":
        """The same kernel with other hyper-parameters.

        Parameters
        ----------
        values
            In the order of `hyperparameters`, P of them.

        Raises
        ------
        ValueError
            Where there are more or fewer.
        """
        if len(values) != len(self.hyperparameters):
            raise ValueError(f"{self} has {len(self.hyperparameters)} hyper-parameters, got {len(values)}")
        return self.rebuilt(iter([float(value) for value in values]), free=True)

    @abc.abstractmethod
    def places(self, *, free: bool = True, scales: bool = True) -> Iterator[Place]:
        """Leaves from left to right.

        Parameters
        ----------
        free, scales
            What holds at this kernel's own place.
        """

    @abc.abstractmethod
    def terms(self, first: int = 0) -> tuple[tuple[int, ...], ...]:
        """The sum of products that it is when multiplied out: indices of the leaves of each product.

        Parameters
        ----------
        first
            Index of its first leaf.
        """

    @abc.abstractmethod
    def covariance(
        self, values: Iterator[FloatArray], t_s: FloatArray, u_s: FloatArray, *, free: bool
    ) -> FloatArray:
        """Covariance, taking hyper-parameters in order [m²].

        Parameters
        ----------
        values
            The next are this kernel's.
        t_s, u_s
            Times after the window's last sample [s].
        free
            What holds at its place.
        """

    @abc.abstractmethod
    def rebuilt(self, values: Iterator[float], *, free: bool) -> "AbstractKernel":
        """The same kernel, taking hyper-parameters in order.

        Parameters
        ----------
        values
            The next are this kernel's.
        free
            What holds at its place.
        """


class AbstractLeaf(AbstractKernel):
    """A kernel that is no sum or product: frozen dataclasses with their shape and ``variance`` as fields."""

    name: ClassVar[str]
    """As in expressions."""
    code: ClassVar[int]
    """By which compiled code knows it (`modelcast.models.gp.kernel_codes`)."""
    shape: ClassVar[tuple[Hyperparameter, ...]]
    """Hyper-parameters beside the variance, named as its fields."""
    variance: float

    def __str__(self) -> str:
        return self.name

    @staticmethod
    @abc.abstractmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Covariance at variance 1.

        Parameters
        ----------
        t_s, u_s
            Times after the window's last sample [s].
        shape
            Values of `shape`, broadcast with the times.
        """

    def places(self, *, free: bool = True, scales: bool = True) -> Iterator[Place]:
        """Itself."""
        yield Place(self, free, scales)

    def terms(self, first: int = 0) -> tuple[tuple[int, ...], ...]:
        """One product of one leaf."""
        return ((first,),)

    def covariance(
        self, values: Iterator[FloatArray], t_s: FloatArray, u_s: FloatArray, *, free: bool
    ) -> FloatArray:
        """Variance times correlation."""
        variance = next(values) if free else self.variance
        return variance * self.correlation(t_s, u_s, *(next(values) for _ in self.shape))

    def rebuilt(self, values: Iterator[float], *, free: bool) -> AbstractKernel:
        """A leaf of the same class."""
        variance = next(values) if free else self.variance
        shape = {one.name: next(values) for one in self.shape}
        return type(self)(**{**shape, "variance": variance})


@dataclass(frozen=True, slots=True)
class Sum(AbstractKernel):
    """Sum of kernels; a sum inside it is spread out.

    Parameters
    ----------
    parts
        Two kernels or more.
    """

    parts: tuple[AbstractKernel, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", _spread(self.parts, Sum))

    def __str__(self) -> str:
        return "+".join(str(part) for part in self.parts)

    def places(self, *, free: bool = True, scales: bool = True) -> Iterator[Place]:
        """Leaves of all parts."""
        for index, part in enumerate(self.parts):
            yield from part.places(free=free or index > 0, scales=scales)

    def terms(self, first: int = 0) -> tuple[tuple[int, ...], ...]:
        """Products of all parts."""
        found: list[tuple[int, ...]] = []
        for part in self.parts:
            found += part.terms(first)
            first += sum(1 for _ in part.places())
        return tuple(found)

    def covariance(
        self, values: Iterator[FloatArray], t_s: FloatArray, u_s: FloatArray, *, free: bool
    ) -> FloatArray:
        """Sum of the parts'."""
        total = np.zeros(())
        for index, part in enumerate(self.parts):
            total = total + part.covariance(values, t_s, u_s, free=free or index > 0)
        return total

    def rebuilt(self, values: Iterator[float], *, free: bool) -> AbstractKernel:
        """Sum of the parts, rebuilt."""
        return Sum(
            tuple(part.rebuilt(values, free=free or index > 0) for index, part in enumerate(self.parts))
        )


@dataclass(frozen=True, slots=True)
class Product(AbstractKernel):
    """Product of kernels; a product inside it is spread out.

    Parameters
    ----------
    parts
        Two kernels or more.
    """

    parts: tuple[AbstractKernel, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", _spread(self.parts, Product))

    def __str__(self) -> str:
        return "*".join(f"({part})" if isinstance(part, Sum) else str(part) for part in self.parts)

    def places(self, *, free: bool = True, scales: bool = True) -> Iterator[Place]:
        """Leaves of all factors."""
        for index, part in enumerate(self.parts):
            yield from part.places(free=free and index == 0, scales=scales and index == 0)

    def terms(self, first: int = 0) -> tuple[tuple[int, ...], ...]:
        """Every product of one term of each factor."""
        found: tuple[tuple[int, ...], ...] = ((),)
        for part in self.parts:
            found = tuple((*left, *right) for left in found for right in part.terms(first))
            first += sum(1 for _ in part.places())
        return found

    def covariance(
        self, values: Iterator[FloatArray], t_s: FloatArray, u_s: FloatArray, *, free: bool
    ) -> FloatArray:
        """Product of the factors'."""
        total = np.ones(())
        for index, part in enumerate(self.parts):
            total = total * part.covariance(values, t_s, u_s, free=free and index == 0)
        return total

    def rebuilt(self, values: Iterator[float], *, free: bool) -> AbstractKernel:
        """Product of the factors, rebuilt."""
        return Product(
            tuple(part.rebuilt(values, free=free and index == 0) for index, part in enumerate(self.parts))
        )


def _spread(parts: tuple[AbstractKernel, ...], kind: type[Sum] | type[Product]) -> tuple[AbstractKernel, ...]:
    """Parts with those of the same kind replaced by their parts."""
    return tuple(one for part in parts for one in (part.parts if isinstance(part, kind) else (part,)))

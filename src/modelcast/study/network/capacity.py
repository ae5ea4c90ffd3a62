"""The greatest density at which tracking holds, found by bisection on density.

A density *holds* where, over its seeds, at least 95 % of the pairs 50 m to 150 m apart have a live track,
and the 99th percentile of the tracking error of these stays under a limit. Halving the logarithm of a
bracket ends with two densities that are at most a given ratio apart: the last that held and the first that
failed.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.study.network.rows import RunRow

__all__ = ["HELD_RATIO", "Capacity", "CapacityFound", "Probe", "bisected", "probe_of"]

HELD_RATIO = 0.95
"""Share of the pairs that must have a live track."""


@dataclass(frozen=True, slots=True)
class Probe:
    """One density, run with several seeds; means over them.

    Parameters
    ----------
    density_per_km
        Vehicles a kilometre [1/km].
    pte_p99_m
        99th percentile of the tracking error, 50 m to 150 m apart [m].
    held_ratio
        Share of pairs with a live track.
    busy_ratio
        Channel busy ratio.
    seeds_held
        In how many of the seeds the limit held, and of how many.
    """

    density_per_km: float
    pte_p99_m: float
    held_ratio: float
    busy_ratio: float
    seeds_held: tuple[int, int]

    def holds(self, limit_m: float) -> bool:
        """Whether the means hold.

        Parameters
        ----------
        limit_m
            Tracking error [m].
        """
        return self.held_ratio >= HELD_RATIO and self.pte_p99_m < limit_m


@dataclass(frozen=True, slots=True)
class Capacity:
    """What a bisection found.

    Parameters
    ----------
    holds_per_km
        Greatest density tried that held; None where none did [1/km].
    fails_per_km
        Least density tried that failed; None where none did [1/km].
    probes
        All that were run, by rising density.
    is_monotone
        Whether every density below one that held held too, and every one above one that failed failed.
    """

    holds_per_km: float | None
    fails_per_km: float | None
    _: KW_ONLY
    probes: Sequence[Probe]
    is_monotone: bool

    @property
    def text(self) -> str:
        """In words, for tables."""
        if self.holds_per_km is None:
            return f"fails at {self.fails_per_km:.0f}"
        if self.fails_per_km is None:
            return f"holds at {self.holds_per_km:.0f}"
        return f"{self.holds_per_km:.0f} to {self.fails_per_km:.0f}" + ("" if self.is_monotone else " ?")


@dataclass(frozen=True, slots=True)
class CapacityFound:
    """The capacity of one radio and policy at one limit.

    Parameters
    ----------
    radio, policy
        Names.
    limit_m
        Tracking error that p99 stays under [m].
    capacity
        What was found.
    """

    radio: str
    policy: str
    limit_m: float
    capacity: Capacity


def probe_of(runs: Sequence[RunRow], limit_m: float) -> Probe:
    """Several seeds of one density as one.

    Parameters
    ----------
    runs
        Their rows.
    limit_m
        Tracking error [m].
    """
    each = [run.held_ratio >= HELD_RATIO and run.pte_p99_m < limit_m for run in runs]
    return Probe(
        runs[0].density_per_km,
        float(np.mean([run.pte_p99_m for run in runs])),
        float(np.mean([run.held_ratio for run in runs])),
        float(np.mean([run.busy_ratio for run in runs])),
        (sum(each), len(each)),
    )


def bisected(
    probe: Callable[[float], Probe],
    bounds_per_km: tuple[float, float],
    limit_m: float,
    *,
    ratio: float = 1.1,
    known: Sequence[float] = (),
) -> Capacity:
    """Find the density at which tracking begins to fail.

    Parameters
    ----------
    probe
        Runs a density; asked for each once.
    bounds_per_km
        Lowest and highest density [1/km].
    limit_m
        Tracking error that p99 must stay under [m].
    ratio
        How far apart, as a ratio, the two densities may be between which it lies.
    known
        Densities that cost nothing to ask for: they narrow the bracket first [1/km].

    Raises
    ------
    ValueError
        Where bounds are not in order, or the ratio is not above 1.

    Examples
    --------
    >>> def tracked(density):
    ...     return Probe(density, density / 800.0, 1.0, 0.5, (1, 1))
    >>> found = bisected(tracked, (25.0, 3200.0), 0.5)
    >>> found.holds_per_km < 400.0 <= found.fails_per_km < 1.1 * found.holds_per_km
    True
    """
    low, high = bounds_per_km
    if not 0.0 < low < high:
        raise ValueError(f"bounds_per_km must be positive and rise, got {bounds_per_km}")
    if not ratio > 1.0:
        raise ValueError(f"ratio must be above 1, got {ratio}")
    done: dict[float, Probe] = {}

    def holds(density: float) -> bool:
        if density not in done:
            done[density] = probe(density)
        return done[density].holds(limit_m)

    for density in sorted(known):
        if low <= density <= high:
            _ = holds(density)
    if holds(low) and not holds(high):
        held = [density for density in done if done[density].holds(limit_m)]
        failed = [density for density in done if not done[density].holds(limit_m)]
        upper = min(failed)
        lower = max(density for density in held if density < upper)
        while upper > ratio * lower:
            middle = float(np.sqrt(lower * upper))
            if holds(middle):
                lower = middle
            else:
                upper = middle
    held = [density for density in done if done[density].holds(limit_m)]
    failed = [density for density in done if not done[density].holds(limit_m)]
    first = min(failed, default=None)
    below = [density for density in held if first is None or density < first]
    return Capacity(
        max(below, default=None),
        first,
        probes=[done[density] for density in sorted(done)],
        is_monotone=len(below) == len(held),
    )

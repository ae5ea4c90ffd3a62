"""The greatest density at which a limit holds, found by bisection on density.

Densities are doubled from the lowest until one fails, and the logarithm of the bracket is halved until the
last that held and the first that failed are at most a given ratio apart. So no density far above the one
sought is run: what a run costs grows with its square.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.study.network.capacity_limits import Limit, Probe
from modelcast.study.table import Table, TableSchema, quantity, ratio, text

__all__ = ["PROBES", "Capacity", "CapacityFound", "bisected", "probes_table"]

_STEP = 2.0
"""Ratio of the densities on the way up."""


@dataclass(frozen=True, slots=True)
class Capacity:
    """What a bisection found.

    Parameters
    ----------
    holds_per_km
        Greatest density tried that held and below which all held; None where there is none [1/km].
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

    @property
    def ends(self) -> tuple[Probe | None, Probe | None]:
        """The last that held and the first that failed."""
        known = {probe.density_per_km: probe for probe in self.probes}
        held = None if self.holds_per_km is None else known[self.holds_per_km]
        return held, None if self.fails_per_km is None else known[self.fails_per_km]


@dataclass(frozen=True, slots=True)
class CapacityFound:
    """The capacity of one radio and sender at one limit.

    Parameters
    ----------
    radio, policy
        Names.
    threshold_m
        Of an error-driven policy; `modelcast.study.network.rows.NO_THRESHOLD` for others [m].
    limit
        What had to hold.
    capacity
        What was found.
    """

    radio: str
    policy: str
    _: KW_ONLY
    threshold_m: float
    limit: Limit
    capacity: Capacity


PROBES = TableSchema(
    "capacity",
    "One density tried for one limit, radio and sender.",
    (
        text("radio", "Name of the radio."),
        text("policy", "Name of the policy."),
        text("quantity", "What the limit is on."),
        quantity("threshold_m", "m", "Error that calls for a message; NaN where the policy has none."),
        quantity("limit", "", "The limit, in the unit of its quantity."),
        quantity("density_per_km", "1/km", "Vehicles a kilometre."),
        quantity("value", "", "What the limit is on, mean over seeds."),
        quantity("least", "", "The least over seeds."),
        quantity("greatest", "", "The greatest over seeds."),
        ratio("held_ratio", "Share of the samples of pairs in which the host held a live track."),
        ratio("busy_ratio", "Mean channel busy ratio."),
        quantity("seeds_held", "1", "Seeds in which the limit held."),
        quantity("seeds", "1", "Seeds run."),
        quantity("warnings", "1", "True warnings."),
    ),
)
"""Probes: a row a limit, radio, sender and density."""


def probes_table(found: Sequence[CapacityFound]) -> Table:
    """Return all that was tried as a table of `PROBES`.

    Parameters
    ----------
    found
        The capacities.
    """
    return PROBES.table(
        PROBES.row(
            radio=one.radio,
            policy=one.policy,
            quantity=one.limit.quantity,
            threshold_m=one.threshold_m,
            limit=one.limit.value,
            density_per_km=probe.density_per_km,
            value=probe.value,
            least=probe.spread[0],
            greatest=probe.spread[1],
            held_ratio=probe.held_ratio,
            busy_ratio=probe.busy_ratio,
            seeds_held=probe.seeds_held[0],
            seeds=probe.seeds_held[1],
            warnings=probe.warnings,
        )
        for one in found
        for probe in one.capacity.probes
    )


def bisected(
    probe: Callable[[float], Probe],
    bounds_per_km: tuple[float, float],
    *,
    ratio: float = 1.1,
    known: Sequence[float] = (),
) -> Capacity:
    """Find the density at which a limit begins to fail.

    Parameters
    ----------
    probe
        Runs a density and says whether it holds; asked for each once.
    bounds_per_km
        Lowest and highest density [1/km].
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
    ...     error_m, held = density / 800.0, density < 400.0
    ...     return Probe(
    ...         density, error_m, spread=(error_m, error_m), held_ratio=1.0, busy_ratio=0.5,
    ...         seeds_held=(int(held), 1), holds=held,
    ...     )
    >>> found = bisected(tracked, (25.0, 3200.0))
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
        return done[density].holds

    for density in sorted(known):
        if low <= density <= high:
            _ = holds(density)
    if holds(low):
        lower, upper = _bracket(done)
        while upper is None and lower < high:
            _ = holds(min(_STEP * lower, high))
            lower, upper = _bracket(done)
        while upper is not None and upper > ratio * lower:
            _ = holds(float(np.sqrt(lower * upper)))
            lower, upper = _bracket(done)
    failed = [density for density in done if not done[density].holds]
    first = min(failed, default=None)
    held = [density for density in done if done[density].holds]
    below = [density for density in held if first is None or density < first]
    return Capacity(
        max(below, default=None),
        first,
        probes=[done[density] for density in sorted(done)],
        is_monotone=len(below) == len(held),
    )


def _bracket(done: dict[float, Probe]) -> tuple[float, float | None]:
    """The last density that held below the first that failed, where the lowest held; and that one."""
    upper = min((density for density, probe in done.items() if not probe.holds), default=None)
    held = [density for density, probe in done.items() if probe.holds]
    return max(density for density in held if upper is None or density < upper), upper

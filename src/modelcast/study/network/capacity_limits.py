"""What must hold at a density: limits on errors of places or on missed warnings, and runs set against them.

Errors are those of pairs 50 m to 150 m apart, of absolute places (against the truth), or relative to where
the host takes itself to be. A limit on them holds only where 95 % of these pairs have a live track. Missed
warnings are those of the forward collision warning, against the same application with perfect knowledge.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.study.network.rows import CaseResult

__all__ = ["HELD_RATIO", "WARNS", "Limit", "Probe", "Quantity", "probe_of"]

HELD_RATIO = 0.95
"""Share of the pairs that must have a live track."""

WARNS = "fcw"
"""The application whose misses a limit of `missed` is on."""

Quantity = Literal["absolute", "relative", "missed"]


@dataclass(frozen=True, slots=True)
class Limit:
    """What a density must stay under.

    Parameters
    ----------
    quantity
        ``absolute`` or ``relative``: 99th percentile of that error [m]. ``missed``: share of the instants of
        true warnings at which hosts do not warn.
    value
        The limit; what equals it fails.

    Raises
    ------
    ValueError
        Where it is not positive, or a share is not below 1.

    Examples
    --------
    >>> [Limit(name, 0.5).text for name in ("absolute", "relative", "missed")]
    ['p99 < 0.5 m', 'relative p99 < 0.5 m', 'missed < 50 %']
    """

    quantity: Quantity
    value: float

    def __post_init__(self) -> None:
        if not 0.0 < self.value < (1.0 if self.quantity == "missed" else np.inf):
            bound = "between 0 and 1" if self.quantity == "missed" else "positive"
            raise ValueError(f"a limit of {self.quantity} must be {bound}, got {self.value}")

    @property
    def text(self) -> str:
        """In words, for tables."""
        if self.quantity == "missed":
            return f"missed < {100.0 * self.value:g} %"
        return f"{'' if self.quantity == 'absolute' else 'relative '}p99 < {self.value:g} m"

    def value_text(self, value: float) -> str:
        """Return a value of its quantity, in its unit.

        Parameters
        ----------
        value
            In metres, or a share.
        """
        return f"{100.0 * value:.2f} %" if self.quantity == "missed" else f"{value:.2f} m"


@dataclass(frozen=True, slots=True)
class Probe:
    """One density, run with several seeds, as a limit sees it.

    Parameters
    ----------
    density_per_km
        Vehicles a kilometre [1/km].
    value
        What the limit is on: mean of the seeds' 99th percentiles [m], or the share missed over all seeds.
    spread
        The least and the greatest of the seeds.
    held_ratio
        Share of pairs with a live track, mean over the seeds.
    busy_ratio
        Channel busy ratio, mean over the seeds.
    seeds_held
        In how many of the seeds the limit held, and of how many that had something to count.
    holds
        Whether it holds over the seeds.
    warnings
        True warnings of all seeds, for a limit on missed ones; else 0.
    """

    density_per_km: float
    value: float
    _: KW_ONLY
    spread: tuple[float, float]
    held_ratio: float
    busy_ratio: float
    seeds_held: tuple[int, int]
    holds: bool
    warnings: int = 0


def probe_of(runs: Sequence[CaseResult], limit: Limit) -> Probe:
    """Several seeds of one density as one.

    Parameters
    ----------
    runs
        Of one density and sender.
    limit
        What is asked of them.

    Raises
    ------
    ValueError
        Where a limit is on missed warnings and there was nothing to miss.
    """
    held = np.array([one.run.held_ratio for one in runs])
    if limit.quantity == "missed":
        each, value, warnings = _missed(runs)
        each_holds, holds = each < limit.value, value < limit.value
    else:
        name = "pte_p99_m" if limit.quantity == "absolute" else "relative_p99_m"
        each, warnings = np.array([getattr(one.run, name) for one in runs]), 0
        value = float(each.mean())
        each_holds = (each < limit.value) & (held >= HELD_RATIO)
        holds = value < limit.value and float(held.mean()) >= HELD_RATIO
    return Probe(
        runs[0].run.density_per_km,
        value,
        spread=(float(each.min()), float(each.max())),
        held_ratio=float(held.mean()),
        busy_ratio=float(np.mean([one.run.busy_ratio for one in runs])),
        seeds_held=(int(each_holds.sum()), each.size),
        holds=bool(holds),
        warnings=warnings,
    )


def _missed(runs: Sequence[CaseResult]) -> tuple[FloatArray, float, int]:
    """Shares missed of the seeds that had something to miss, the share over all, and how many warnings."""
    rows = [[row for row in one.warnings if row.application == WARNS] for one in runs]
    positives = np.array([sum(row.positives for row in own) for own in rows])
    missed = np.array([sum(row.missed for row in own) for own in rows])
    there = positives > 0
    if not there.any():
        density = runs[0].run.density_per_km
        raise ValueError(
            f"no true warning of {WARNS} at {density:g} vehicles/km, so none can be missed: raise the lowest "
            "density, the time or the seeds, or take the scenario braking"
        )
    warnings = sum(row.events for own in rows for row in own)
    return missed[there] / positives[there], float(missed.sum() / positives.sum()), warnings

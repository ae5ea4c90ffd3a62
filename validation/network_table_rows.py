"""Runs of the published network table by setting and seed: means, ratios on the same traffic, their words."""

from collections.abc import Callable, Iterable, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.study.metrics import confidence_limits
from network_table_cells import Cell, Kept, row_order

__all__ = [
    "Found",
    "Mean",
    "Rows",
    "Setting",
    "compared",
    "density_said",
    "listed",
    "mean_of",
    "spans",
    "verdict",
]

Found = dict[Cell, Kept]
"""What was kept, by run."""


class Setting(NamedTuple):
    """What the seeds of a row have in common."""

    scenario: str
    radio: str
    density_per_km: float
    receiver: str
    policy: str

    def cell(self, seed: int) -> Cell:
        """Its run of a seed."""
        return Cell(self.scenario, self.density_per_km, self.radio, self.policy, self.receiver, seed)


class Mean(NamedTuple):
    """Mean over seeds, and half of its 95 % interval; NaN with fewer than two runs."""

    value: float
    half: float

    def said(self, form: str, scale: float = 1.0) -> str:
        """As a table has it."""
        value = format(scale * self.value, form)
        return f"{value} ± {scale * self.half:{form}}" if isfinite(self.half) else value


def mean_of(values: FloatArray) -> Mean:
    """Mean and half of Student's 95 % interval of one figure, a value a run, (N,)."""
    low, high = confidence_limits(values)
    there = values[np.isfinite(values)]
    if low is None or high is None:
        return Mean(float(there.mean()) if there.size else np.nan, np.nan)
    return Mean(float(there.mean()), 0.5 * (high - low))


class Rows:
    """Runs by setting and seed."""

    def __init__(self, found: Found) -> None:
        self.by: dict[Setting, dict[int, Kept]] = {}
        for cell in sorted(found, key=row_order):
            key = Setting(cell.scenario, cell.radio, cell.density_per_km, cell.receiver, cell.policy)
            self.by.setdefault(key, {})[cell.seed] = found[cell]

    def settings(
        self, scenario: str, radios: Callable[[str], bool], receivers: Sequence[str]
    ) -> list[Setting]:
        """Of a scenario, in order."""
        own = [one for one in self.by if one.scenario == scenario and one.receiver in receivers]
        return [one for one in own if radios(one.radio)]

    def values(self, setting: Setting, figure: str) -> FloatArray:
        """One figure of all runs of a setting, (N,)."""
        return np.array([self.by[setting][seed].figures[figure] for seed in sorted(self.by[setting])])

    def ratios(self, setting: Setting, figure: str, against: str) -> FloatArray:
        """A figure over that of another sender on the same traffic, for each seed that both have, (N,)."""
        ours, theirs = self.by[setting], self.by.get(setting._replace(policy=against), {})
        pairs = [(ours[seed], theirs[seed]) for seed in sorted(ours.keys() & theirs.keys())]
        values = np.array([[one.figures[figure] for one in pair] for pair in pairs]).reshape(-1, 2)
        return compared(values[:, 0], values[:, 1])

    def ratio(self, setting: Setting, figure: str, against: str) -> Mean | None:
        """Their mean and half of its interval; None with fewer than two seeds."""
        found = self.ratios(setting, figure, against)
        return mean_of(found) if found.size > 1 else None


def compared(ours: FloatArray, theirs: FloatArray) -> FloatArray:
    """Ratios seed by seed, (N,); 1 where neither has any, NaN where only the other has none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = ours / theirs
    found[(ours == 0.0) & (theirs == 0.0)] = 1.0
    found[~np.isfinite(found)] = np.nan
    return found


def verdict(ratio: Mean) -> str:
    """``lower`` or ``higher`` where the interval leaves 1 out and the mean does by 0.5 %, else ``same``."""
    if not isfinite(ratio.half) or abs(ratio.value - 1.0) < max(ratio.half, 0.005):
        return "same"
    return "lower" if ratio.value < 1.0 else "higher"


def spans(values: Sequence[float] | Sequence[int], form: str = ".2f") -> str:
    """``0.39 to 0.57``, or one number where both are the same as printed."""
    low, high = format(min(values), form), format(max(values), form)
    return low if low == high else f"{low} to {high}"


def listed(words: Iterable[str]) -> str:
    """``a, b and c``."""
    held = list(words)
    return held[0] if len(held) == 1 else f"{', '.join(held[:-1])} and {held[-1]}" if held else ""


def density_said(value: float) -> str:
    """A density as tables have it."""
    return f"{value:,.0f}"

"""The plan of the paper's claim on traffic: fewer collisions and less load at every density.

The hybrid with identifications against the error-driven baseline at equal thresholds, on a straight highway
with both directions, over two radios. What comes out are rows of `modelcast.study.network.pairs`.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from modelcast.station.policy.rules import IdentifyRule, StartRule
from modelcast.study.network.pairs import BASELINE, HYBRID, Verdict
from modelcast.study.table import Row

__all__ = ["TrafficPlan", "counted_verdicts"]

_RUN_S = 1.0
_VEHICLE_SECOND_S = 3.3e-4
"""Processor time that a vehicle costs in a second of traffic, the mean of both radios at 1,200/km [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficPlan:
    """What is run; the defaults are what the paper leaves to be measured.

    Parameters
    ----------
    banks
        Sub-models of the hybrid, each as users name it.
    start, identify
        Rules of the hybrid; None for those of each bank. The paper's bank starts in order, and identifies
        where the sub-model in use has failed.
    thresholds_m
        Tracking errors that call for a message [m].
    densities_per_km
        Vehicles a kilometre of road [1/km].
    radios
        Names.
    seeds
        Runs of each combination.
    duration_s, warm_up_s
        Time simulated, and how much of it is not counted [s].
    length_m
        Length of the road [m]. Vehicles near its ends have fewer neighbours, and are counted: the longer the
        road, the fewer.

    Examples
    --------
    >>> plan = TrafficPlan(seeds=10)
    >>> plan.runs
    1120
    """

    banks: tuple[str, ...] = ("paper",)
    start: StartRule | None = None
    identify: IdentifyRule | None = None
    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    densities_per_km: tuple[float, ...] = (25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1200.0)
    radios: tuple[str, ...] = ("dsrc", "sidelink")
    seeds: int = 10
    duration_s: float = 40.0
    warm_up_s: float = 10.0
    length_m: float = 2000.0

    @property
    def policies(self) -> tuple[str, ...]:
        """Who sends."""
        return (BASELINE, HYBRID)

    @property
    def runs(self) -> int:
        """How many runs that is."""
        senders = 1 + len(self.banks)
        return len(self.thresholds_m) * len(self.densities_per_km) * len(self.radios) * self.seeds * senders

    def expected_s(self, jobs: int) -> float:
        """Time that all runs take, so many at a time, on a processor of 2026: a figure to plan with [s].

        Parameters
        ----------
        jobs
            Runs at a time.
        """
        vehicle_s = sum(self.densities_per_km) * self.length_m / 1000.0 * self.duration_s
        mean_s = _RUN_S + _VEHICLE_SECOND_S * vehicle_s / max(len(self.densities_per_km), 1)
        return self.runs * mean_s / jobs


def counted_verdicts(rows: Iterable[Row], figure: str, radio: str | None = None) -> dict[Verdict, int]:
    """Count the verdicts on one figure of whole runs: at how many densities and thresholds there are fewer.

    Parameters
    ----------
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them.
    figure
        A name of `modelcast.study.network.pairs.FIGURES`.
    radio
        The radio to count; None for all.
    """
    counts: dict[Verdict, int] = {}
    for row in rows:
        if row.figure == figure and not row.by_range and radio in {None, row.radio}:
            counts[row.verdict] = counts.get(row.verdict, 0) + 1
    return counts

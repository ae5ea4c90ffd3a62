"""Training of the cost-aware rule: how long held sub-models hold on, and how long an update lasts."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.policy.rules import StartRule
from modelcast.study.case import TripCase
from modelcast.study.training import selection_kernels

__all__ = ["CostSettings", "train_costs"]


@dataclass(frozen=True, slots=True)
class CostSettings:
    """How the tables are counted.

    Parameters
    ----------
    thresholds_m
        Thresholds, rising [m].
    age_edges_s, share_edges
        Bounds between the classes of age [s] and of the error's share of the threshold.
    longest_s
        A longer residual life counts as this [s].
    prior
        Instants that the mean over all classes weighs in every class.

    Raises
    ------
    ValueError
        Where the longest life or the prior is not positive.
    """

    thresholds_m: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5)
    _: KW_ONLY
    age_edges_s: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0)
    share_edges: tuple[float, ...] = (0.25, 0.5, 0.75)
    longest_s: float = 20.0
    prior: float = 20.0

    def __post_init__(self) -> None:
        for name in ("longest_s", "prior"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")


def train_costs(
    cases: Sequence[TripCase],
    bank: Bank,
    settings: CostSettings | None = None,
    *,
    start: StartRule = "order",
    selector: Selector | None = None,
    update_cost: float = 1.0,
    identification_cost: float = 1.0,
) -> CostTable:
    """Count the tables of the cost-aware rule along walks that never identify.

    Parameters
    ----------
    cases
        Training trips made ready.
    bank
        The sub-models; completed as in an evaluation.
    settings
        Classes and bounds.
    start, selector
        The start rule, and the selector where it needs one: the mean life of an update depends on it.
    update_cost, identification_cost
        In one unit; `CostTable.priced` changes them.

    Raises
    ------
    ValueError
        Where no case has a second update.
    """
    settings = CostSettings() if settings is None else settings
    ready = [TripRuntime(case.seen, bank, case.estimator, selector) for case in cases]
    lives: list[float] = []
    tables: list[FloatArray] = []
    for threshold_m in settings.thresholds_m:
        life_s, table_s = _count(ready, ErrorDriven(threshold_m, start, "never"), settings)
        lives.append(life_s)
        tables.append(table_s)
    return CostTable(
        update_cost,
        identification_cost,
        thresholds_m=np.array(settings.thresholds_m),
        update_life_s=np.array(lives),
        age_edges_s=np.array(settings.age_edges_s),
        share_edges=np.array(settings.share_edges),
        residual_life_s=np.stack(tables),
    )


def _count(
    ready: Sequence[TripRuntime], policy: ErrorDriven, settings: CostSettings
) -> tuple[float, FloatArray]:
    """Mean life of an update, and the table of one threshold (M, ages, shares) [s]."""
    members = len(ready[0].bank.members) if ready else 0
    shape = (members, len(settings.age_edges_s) + 1, len(settings.share_edges) + 1)
    total_s, count = np.zeros(shape), np.zeros(shape)
    duration_s, updates = 0.0, 0
    for one in ready:
        walk = one.run(policy)
        duration_s += one.trip.duration_s
        updates += walk.updates
        selection_kernels.count_residual(
            one.own.ready.members,
            one.parameters,
            one.trip.t_s,
            one.samples,
            walk.update_index,
            one.tracking_error_m(walk),
            policy.threshold_m,
            settings.longest_s,
            np.array(settings.age_edges_s),
            np.array(settings.share_edges),
            total_s,
            count,
        )
    if not count.any():
        raise ValueError(f"no sub-model outlives the one in use at {policy.threshold_m} m: nothing to weigh")
    mean_s = total_s.sum() / count.sum()
    table_s = (total_s + settings.prior * mean_s) / (count + settings.prior)
    # Six digits: a profile is a text.
    return round(duration_s / updates, 6), table_s.round(6)

"""From what roadside units of one run counted to its rows."""

from dataclasses import replace
from typing import Any

from modelcast.runtime.fleet.roadside import RoadsideRun
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.study.network.measure import held_figures, ratio, span
from modelcast.study.network.roadside_rows import ROADSIDE, ROADSIDE_DISTANCES
from modelcast.study.network.rows import CASE_KEYS, HEADLINE_M, CaseResult

__all__ = ["measure_roadside"]


def measure_roadside(
    result: CaseResult, run: RoadsideRun, units: int, settings: NetworkSettings
) -> CaseResult:
    """Add the rows of roadside units to those of a run.

    Parameters
    ----------
    result
        Rows of the run.
    run
        What the units counted.
    units
        How many they are.
    settings
        With what it was run.
    """
    case = result.run.picked(CASE_KEYS)
    width_m, middle = settings.distance_bin_m, span(*HEADLINE_M, settings.distance_bin_m)
    middle_held: dict[str, Any] = {**held_figures(run.tally, middle)}
    by_distance: list[dict[str, Any]] = [
        {**held_figures(run.tally, slice(number, number + 1))} for number in range(settings.distances)
    ]
    total = ROADSIDE.row(
        **case,
        units=units,
        busy_ratio=run.busy_ratio,
        delivery_ratio=ratio(float(run.delivered[middle].sum()), float(run.sent[middle].sum())),
        repeated_rate_hz=ratio(run.repeated, run.unit_s),
        repeated_bytes_per_s=ratio(run.repeated_bytes, run.unit_s),
        unsent_ratio=ratio(run.unsent, run.repeated),
        by_another_rate_hz=ratio(run.by_another, run.unit_s),
        replaced_rate_hz=ratio(run.replaced, run.unit_s),
        too_old_rate_hz=ratio(run.too_old, run.unit_s),
        too_far_rate_hz=ratio(run.too_far, run.unit_s),
        **middle_held,
    )
    distances = tuple(
        ROADSIDE_DISTANCES.row(
            **case,
            low_m=number * width_m,
            high_m=(number + 1) * width_m,
            frames=int(run.sent[number]),
            pairs=int(run.tally.pairs[number]),
            delivery_ratio=ratio(float(run.delivered[number]), float(run.sent[number])),
            **held,
        )
        for number, held in enumerate(by_distance)
    )
    return replace(result, roadside=(total,), roadside_distances=distances)

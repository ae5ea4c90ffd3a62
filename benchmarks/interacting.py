"""Which numbers should the interacting multiple model have? Messages over those of constant velocity.

Prints a row a setting and a column a source: messages of all trips over those of constant velocity, mean of
20 and 50 cm and of both protocols, and the mean over sources. The first row is constant turn rate and
acceleration, the second the settings that ship, then the best of the settings drawn at random: persistence,
noise, the three spreads and the four chances at a start.
"""

import os
from pathlib import Path

import numpy as np

from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.runtime.trip.runtime import TripRuntime, sense_trip
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import make_case
from modelcast.study.settings import EvaluationSettings

POLICIES = [ErrorDriven(threshold_m, identify="never") for threshold_m in (0.2, 0.5)]
SOURCES = {
    "tracks": ("openacc_zalazone", 30),
    "boreas": ("roads/boreas_2021-08-05.parquet", 12),
    "beijing": ("roads/beijing_gps_and_rtk.parquet", 12),
    "comma2k19": ("comma2k19", 1),
}
"""Files of a source, and how many of its trips are taken, evenly over all."""

SPANS = {
    "persistence_s": (1.0, 30.0),
    "noise_m": (0.02, 0.4),
    "acceleration_spread_mps2": (0.2, 2.0),
    "jerk_spread_mps3": (0.5, 3.0),
    "yaw_acceleration_spread_radps2": (0.05, 0.4),
}
"""Of each number, least and most that are drawn, evenly in its logarithm."""

DRAWS, SHOWN = 160, 10
SHIPPED = InteractingMultipleModel()


def candidates() -> dict[str, AbstractSubModel]:
    """Sub-models by what the table calls them: the rival's, the shipped one, and draws."""
    rng = np.random.default_rng(0)
    found: dict[str, AbstractSubModel] = {"ctra": ConstantTurnRateAcceleration(), "imm as shipped": SHIPPED}
    for _ in range(DRAWS):
        start = np.maximum(rng.dirichlet([1.0, 1.0, 1.0, 6.0]), 0.005)
        numbers = [round(float(np.exp(rng.uniform(*np.log(span)))), 3) for span in SPANS.values()]
        one = InteractingMultipleModel(
            **dict(zip(SPANS, numbers, strict=True)), start=tuple((start / start.sum()).tolist())
        )
        told = "/".join(f"{value:.2f}" for value in (*numbers, *one.start))
        found[told] = one
    return found


def messages(members: dict[str, AbstractSubModel], files: list[Path], most: int) -> dict[str, float]:
    """Messages over constant velocity's, mean over thresholds and protocols, of the trips of some files."""
    trips = [trip for trip in read_trips(files) if len(trip) > 100]
    trips = trips[:: max(len(trips) // most, 1)]
    counts = {name: np.zeros((2, len(POLICIES))) for name in ("cv", *members)}
    for row, protocol in enumerate(("recorded", "sensor")):
        settings = EvaluationSettings(protocol=protocol)
        for trip in trips:
            case = make_case(trip, settings)
            sensed = sense_trip(case.seen, case.estimator, quantised=True)
            for name, found in counts.items():
                bank = BASELINE_BANK if name == "cv" else Bank((members[name],))
                own = TripRuntime(case.seen, bank, case.estimator, quantised=True, sensed=sensed)
                found[row] += [one.updates for one in own.run_each(POLICIES)]
    return {name: float((counts[name] / counts["cv"]).mean()) for name in members}


def main() -> None:
    """Print the table."""
    members, data = candidates(), Path(os.environ["MODELCAST_DATA"])
    found = {source: messages(members, [data / place], most) for source, (place, most) in SOURCES.items()}
    means = {name: float(np.mean([found[source][name] for source in found])) for name in members}
    first, second, *drawn = members
    print(f"{'':50s}" + "".join(f"{source:>11s}" for source in (*found, "mean")))
    for name in (first, second, *sorted(drawn, key=means.__getitem__)[:SHOWN]):
        own = (*(found[source][name] for source in found), means[name])
        print(f"{name:50s}" + "".join(f"{value:11.3f}" for value in own))


if __name__ == "__main__":
    main()

"""How many coefficients, and how many bits each? Bytes against rate, tracking error and airtime.

Learned sub-models with one to five coefficients an axis are trained on one route of OpenACC and judged on the
other, and back; each is carried with several steps. Prints one line a choice and draws ``payload.png`` into
the folder that is named. Needs scikit-learn; takes some minutes.
"""

import argparse
import os
import sys
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path

import numpy as np

from modelcast.io.trips import read_trips
from modelcast.messages.airtime import Stack
from modelcast.messages.mbc_update import extension_octets
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import LearnedTrajectory
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.study.case import TripCase, make_case
from modelcast.study.metrics import quantiles
from modelcast.study.pooling import sorted_errors
from modelcast.study.rate import count_rates
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import run_tracking
from modelcast.study.training.descent import Descent
from modelcast.study.training.learned import DEFAULT_STAGES, LearnedSettings, NoiseStage, train_learned
from modelcast.trips.trajectory import Trajectory
from payload_figure import draw

THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
COEFFICIENTS = (1, 2, 3, 4, 5)
ROUTES = ("dynamic", "handling")
CARRIED = (
    ((0.02, 8), (0.1, 10)),
    ((0.05, 6), (0.2, 9)),
    ((0.05, 6), (0.4, 8)),
    ((0.1, 5), (0.4, 8)),
    ((0.1, 5), (0.8, 7)),
    ((0.2, 4), (1.6, 6)),
)
"""Step [m] and bits of power 0, and of all higher ones: about ±1.6 m and ±50 m in each."""

STAGES = (NoiseStage((0.0, np.inf), DEFAULT_STAGES[0].views[:1]),)
"""One network, on the trips as they were recorded: all positions here are good to millimetres."""


@dataclass(frozen=True)
class Choice:
    """Figures of one choice, over both routes."""

    name: str
    coefficients: int
    _: KW_ONLY
    octets: int
    message_ratio: tuple[float, ...]
    airtime_ratio: tuple[float, ...]
    digest_ratio: float
    p90_m: float
    lossy_p90_m: float


def judged(
    name: str, members: dict[str, AbstractSubModel], cases: dict[str, list[TripCase]], *, sent: bool
) -> Choice:
    """Walk both routes with the sub-model that was trained on the other."""
    both = np.zeros((2, 3, len(THRESHOLDS_M)))
    errors: dict[float, list[np.ndarray]] = {0.0: [], 0.4: []}
    for own, other in (ROUTES, ROUTES[::-1]):
        member = members[other]
        kinematic = ConstantTurnRateAcceleration()
        bank = Bank((member,) if member == kinematic else (member, kinematic))
        settings = EvaluationSettings(
            THRESHOLDS_M, tuple(errors), seeds=1, bank=bank, start="order", identify="never", quantised=sent
        )
        for case in cases[own]:
            ready, base = (
                TripRuntime(case.seen, one, case.estimator)
                for one in (settings.sent_bank, settings.baseline_bank)
            )
            for stack, place in ((Stack(), 1), (Stack("digest"), 2)):
                counts = [
                    count for count, _ in count_rates(case, ready, base, replace(settings, stack=stack))
                ]
                for whose in (0, 1):
                    both[whose, place] += [count.airtime_s for count in counts[whose::2]]
                    if place == 1:
                        both[whose, 0] += [
                            count.updates + count.identifications for count in counts[whose::2]
                        ]
            run = next(iter(run_tracking(case, ready, base, replace(settings, thresholds_m=(0.2,)))))
            for row, ratio in enumerate(errors):
                errors[ratio] += sorted_errors(run, row)
    ratio = both[0] / both[1]
    layout = members[ROUTES[0]].payload_layout
    p90 = [float(quantiles(rows, [1.0] * len(rows), (0.9,))[0]) for rows in errors.values()]
    return Choice(
        name,
        getattr(members[ROUTES[0]], "coefficients", 0),
        octets=0 if layout is None else extension_octets(layout.bits),
        message_ratio=tuple(ratio[0].tolist()),
        airtime_ratio=tuple(ratio[1].tolist()),
        digest_ratio=float(ratio[2, 0]),
        p90_m=p90[0],
        lossy_p90_m=p90[1],
    )


def trained(
    trips: dict[str, list[Trajectory]], coefficients: int, steps: int
) -> dict[str, LearnedTrajectory]:
    """One sub-model a route."""
    settings = LearnedSettings(STAGES, coefficients=coefficients, descent=Descent(steps=steps))
    return {route: train_learned(trips[route], settings) for route in ROUTES}


def shown(choice: Choice) -> str:
    """One line of the table."""
    messages = " ".join(f"{value:.3f}" for value in choice.message_ratio)
    airtime = " ".join(f"{value:.3f}" for value in choice.airtime_ratio)
    return (
        f"{choice.coefficients} {choice.name:24} {choice.octets:3d} octets  messages {messages}  "
        f"airtime {airtime}  "
        f"digest {choice.digest_ratio:.3f}  p90 {choice.p90_m:.4f} m, PER 40 % {choice.lossy_p90_m:.3f} m"
    )


def main() -> int:
    """Train, judge, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--steps", type=int, default=1000)
    given = parser.parse_args()
    data = os.environ.get("MODELCAST_DATA")
    if not data:
        print("MODELCAST_DATA is not set: the folder of real trips")
        return 2
    given.folder.mkdir(parents=True, exist_ok=True)
    trips: dict[str, list[Trajectory]] = {route: [] for route in ROUTES}
    for path in sorted((Path(data) / "openacc_zalazone").glob("*.csv")):
        trips["handling" if "handling" in path.name else "dynamic"] += list(read_trips(path))
    recorded = EvaluationSettings(protocol="recorded")
    cases = {route: [make_case(trip, recorded) for trip in some] for route, some in trips.items()}
    kinematic = ConstantTurnRateAcceleration()
    choices = [judged("ctra", dict.fromkeys(ROUTES, kinematic), cases, sent=True)]
    print(shown(choices[0]), flush=True)
    for coefficients in COEFFICIENTS:
        members = trained(trips, coefficients, given.steps)
        print("unquantised:", shown(judged("exact", dict(members), cases, sent=False)), flush=True)
        for first, higher in CARRIED:
            name = f"{first[0]:g} m/{first[1]}, {higher[0]:g} m/{higher[1]}"
            own = {route: replace(member, carried=(first, higher)) for route, member in members.items()}
            choices.append(judged(name, dict(own), cases, sent=True))
            print(shown(choices[-1]), flush=True)
    counts = sorted({one.coefficients for one in choices})
    groups = {
        f"{count} an axis" if count else "ctra alone": [one for one in choices if one.coefficients == count]
        for count in counts
    }
    draw(groups, given.folder / "payload.png", joined=True, columns=6)
    best = min(choices, key=lambda one: one.airtime_ratio[0])
    print("smallest airtime at 20 cm:", shown(best))
    return 0


if __name__ == "__main__":
    sys.exit(main())

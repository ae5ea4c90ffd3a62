"""How many coefficients, and how many bits, carry a Gaussian process? Bytes against rate, error and airtime.

Processes that are sent as their predicted path (`modelcast.models.predicted_path`), on the OpenACC trips with
the recorded protocol. First how well powers and eigenvectors of the trained kernel follow the paths at equal
bits; then one line for every number of coefficients and span, and for every choice of steps. Draws those of
the default span into ``payload_processes.png`` in the folder that is named. Takes two minutes.
"""

import argparse
import os
import sys
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path

import numpy as np

from modelcast.io.trips import read_trips
from modelcast.messages.mbc_update import extension_octets
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.predicted_path import DEFAULT_CARRIED, DEFAULT_SPAN_S, PredictedPath, carried_layout
from modelcast.models.profile import default_profile
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import PAPER_BANK
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.study.case import TripCase, make_case
from modelcast.study.metrics import quantiles
from modelcast.study.pooling import sorted_errors
from modelcast.study.rate import count_rates
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import run_tracking
from payload_figure import draw

TRAINED = default_profile().sub_model("gp-trained")

THRESHOLDS_M = (0.2, 0.3, 0.4, 0.5)
PROCESSES: dict[str, AbstractSubModel] = {
    "paper": PAPER_BANK.members[1],
    "gp-intercept": GaussianProcess(form="intercept"),
    "gp-trained": TRAINED,
}
"""The paper's bank with its rules; the other two before constant velocity, with the rule ``never``."""

SPANS_S = (2.0, 3.0, 4.0, 5.0)
FINE = ((0.02, 8), *5 * [(0.1, 10)])
"""Step [m] and bits of each power where steps are not the question; as many of them as there are powers."""

POWERS = (3, 4, 5, 6)
CARRIED = (
    FINE[:4],
    DEFAULT_CARRIED,
    ((0.05, 5), (0.1, 8), (0.4, 9), (0.4, 8)),
    ((0.05, 5), (0.4, 8), (0.4, 8), (0.4, 8)),
    ((0.1, 4), (0.2, 7), (0.4, 8), (0.8, 7)),
    ((0.2, 3), (0.4, 6), (0.8, 7), (1.6, 6)),
)
"""Steps and bits of four powers, from fine to coarse."""


@dataclass(frozen=True)
class Choice:
    """Figures of one choice."""

    process: str
    name: str
    _: KW_ONLY
    drawn: bool
    octets: int
    message_ratio: tuple[float, ...]
    airtime_ratio: tuple[float, ...]
    p90_m: float
    lossy_p90_m: float


def judged(process: str, name: str, member: AbstractSubModel, cases: list[TripCase], *, sent: bool) -> Choice:
    """Walk all trips with the process as it is given."""
    paper = process == "paper"
    members = (ConstantVelocity(), member) if paper else (member, ConstantVelocity())
    settings = EvaluationSettings(
        THRESHOLDS_M,
        (0.0, 0.4),
        seeds=1,
        bank=Bank(members),
        start="order",
        identify="on-failure" if paper else "never",
        quantised=sent,
    )
    totals = np.zeros((2, 2, len(THRESHOLDS_M)))
    errors: list[list[np.ndarray]] = [[], []]
    for case in cases:
        ready, base = (
            TripRuntime(case.seen, one, case.estimator)
            for one in (settings.sent_bank, settings.baseline_bank)
        )
        counts = [count for count, _ in count_rates(case, ready, base, settings)]
        for whose in (0, 1):
            some = counts[whose::2]
            totals[whose, 0] += [count.updates + count.identifications for count in some]
            totals[whose, 1] += [count.airtime_s for count in some]
        run = next(iter(run_tracking(case, ready, base, replace(settings, thresholds_m=(0.2,)))))
        for row, own in enumerate(errors):
            own.extend(sorted_errors(run, row))
    ratio = totals[0] / totals[1]
    p90 = [float(quantiles(rows, [1.0] * len(rows), (0.9,))[0]) for rows in errors]
    return Choice(
        process,
        name,
        drawn=sent and isinstance(member, PredictedPath) and member.span_s == DEFAULT_SPAN_S,
        octets=extension_octets(carried_layout(member).bits),
        message_ratio=tuple(ratio[0].tolist()),
        airtime_ratio=tuple(ratio[1].tolist()),
        p90_m=p90[0],
        lossy_p90_m=p90[1],
    )


def shown(choice: Choice) -> str:
    """One line of the table."""
    messages, airtime = (
        " ".join(f"{value:.3f}" for value in values)
        for values in (choice.message_ratio, choice.airtime_ratio)
    )
    return (
        f"{choice.process:12} {choice.name:28} {choice.octets:3d} octets  messages {messages}  "
        f"airtime {airtime}  p90 {choice.p90_m:.4f} m, PER 40 % {choice.lossy_p90_m:.3f} m"
    )


def bases(cases: list[TripCase], span_s: float = DEFAULT_SPAN_S, stride: int = 20) -> None:
    """Compare powers with the leading eigenvectors of the trained kernel over the span, at equal bits.

    Steps of the eigenvectors are those that spread the same number of codes over the same range.
    """
    process = TRAINED
    share = np.linspace(0.0, 1.0, 21)
    fixed = process.hyperparameters
    lengthscale_s = 1.0 if fixed is None else fixed.lengthscale_s
    apart = (share[:, None] - share) * span_s / lengthscale_s
    _, vectors = np.linalg.eigh(np.exp(-0.5 * apart**2))
    paths: list[np.ndarray] = []
    for case in cases:
        ready = TripRuntime(case.seen, Bank((process,)), case.estimator)
        at = np.arange(30, len(case.seen) - 1, stride)
        ready.fit_at(at)
        own = np.ascontiguousarray(ready.parameters[at, : len(process.parameter_names)])
        moved = process.predict(own, span_s * share, dt_s=case.seen.dt_s)
        velocity = sample_matrix(case.seen, case.estimator)[:, 2:4][at]
        paths.append(
            (moved - velocity[:, None] * (span_s * share)[:, None]).transpose(0, 2, 1).reshape(-1, 21)
        )
    beyond = np.concatenate(paths)
    for count in (2, 3, 4, 5):
        for name, basis in (
            ("powers", np.vander(share, count, increasing=True)),
            ("eigenvectors", vectors[:, ::-1][:, :count]),
        ):
            found = beyond @ np.linalg.pinv(basis).T
            for bits in (6, 8, 10):
                step = 2.0 * np.quantile(np.abs(found), 0.999, axis=0) / 2**bits
                off = np.rint(found / step) * step @ basis.T - beyond
                rms = np.sqrt(np.mean(off**2, axis=0))[[0, 2, 5, 20]]
                print(
                    f"{count} {name:12} {bits:2d} bits  rms at 0, 0.4, 1, 4 s: {np.round(rms, 4)} m",
                    flush=True,
                )


def main() -> int:
    """Judge, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    data = os.environ.get("MODELCAST_DATA")
    if not data:
        print("MODELCAST_DATA is not set: the folder of real trips")
        return 2
    given.folder.mkdir(parents=True, exist_ok=True)
    recorded = EvaluationSettings(protocol="recorded")
    paths = sorted((Path(data) / "openacc_zalazone").glob("*.csv"))
    cases = [make_case(trip, recorded) for path in paths for trip in read_trips(path)]
    choices: list[Choice] = []

    def judge(process: str, name: str, member: AbstractSubModel, *, sent: bool = True) -> None:
        choices.append(judged(process, name, member, cases, sent=sent))
        print(shown(choices[-1]), flush=True)

    bases(cases)
    for process, member in PROCESSES.items():
        judge(process, "as fitted", member, sent=False)
        for span_s in SPANS_S:
            for powers in POWERS:
                path = PredictedPath(member, span_s=span_s, carried=FINE[:powers])
                judge(process, f"{powers} an axis, {span_s:g} s", path)
        judge(process, "4 an axis, not rounded", PredictedPath(member), sent=False)
        for carried in CARRIED:
            name = " ".join(f"{step:g}/{bits}" for step, bits in carried)
            judge(process, name, PredictedPath(member, carried=carried))
    groups = {
        process: [one for one in choices if one.process == process and one.drawn] for process in PROCESSES
    }
    draw(groups, given.folder / "payload_processes.png", joined=False, columns=3)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""What a legacy receiver sees of a sender that chooses what Part I says: errors of constant velocity.

A network at the sender (``free-predictive``) moves speed, heading, acceleration and yaw rate of Part I within
limits, for receivers that coast by all four. A legacy receiver coasts by speed and heading alone. It is given
the same messages three times: with what ``free-predictive`` states, with what ``free`` states (the estimates
alone), and with the newest sample's own speed and heading; all three as octets carry them.

``legacy.py [--profile FILE | --folder FOLDER]`` judges the shipped profile, that one, or ``a.json`` and
``b.json`` as ``judged.py train`` made them, each on the trips of `judged.SOURCES` that it was not trained on.
Messages are sent when the profile's bank sends at 20 and 50 cm, with a keep-alive (``--keep-alive``; ``inf``
for none), none lost; and at every 0.1 s. ``--write`` puts the tables into
``docs/decisions/029-free-model.md``, ``--check`` tells by its exit code whether that page has them.
"""

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np

from judged import PROTOCOLS, SOURCES, unseen
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.io.profile import read_profile
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.free import FreeMotion
from modelcast.models.profile import Profile, default_profile
from modelcast.runtime.trip.runtime import TripRuntime, sense_trip
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.case import TripCase, make_case
from modelcast.study.metrics import quantiles
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "decisions" / "029-free-model.md"
BLOCK = "legacy"
PREDICTIVE, ESTIMATES, NEWEST = "free-predictive", "free", "newest"
SAYS = (NEWEST, ESTIMATES, PREDICTIVE)
THRESHOLDS_M = (0.2, 0.5)
AGES_S = (0.1, 0.5, 1.0, 2.0)
_STEP_S = 0.1
_NEAR_RATIO = 0.1
"""How far from an age at 10 Hz a log's own samples may lie, over that age: some logs are of 9.6 Hz."""

_ROUNDING = 1e-3


@dataclass
class Pool:
    """Values of many trips, and the time that one of each trip stands for."""

    values: list[FloatArray] = field(default_factory=list)
    weights_s: list[float] = field(default_factory=list)

    def add(self, values: FloatArray, weight_s: float) -> None:
        """Add one trip's."""
        self.values.append(np.sort(values))
        self.weights_s.append(weight_s)

    def quantiles(self, *probabilities: float) -> list[float]:
        """Quantiles over time; 1 for the greatest."""
        return quantiles(self.values, self.weights_s, probabilities).tolist()

    @property
    def figures(self) -> FloatArray:
        """Mean, 90th and 99th percentile over time, (3,); NaN where there is nothing."""
        if not self.values:
            return np.full(3, np.nan)
        each = zip(self.values, self.weights_s, strict=True)
        sums = [(one.sum() * weight_s, one.size * weight_s) for one, weight_s in each]
        total, time_s = np.sum(sums, axis=0)
        return np.array([total / time_s, *self.quantiles(0.9, 0.99)])


@dataclass
class Found:
    """What was found over one source in one protocol.

    ``errors`` [m] are by what messages say and when they are sent: a threshold, or an age at 10 Hz.
    ``moved`` are the differences of the stated speed [m/s] and heading [degrees] from the estimates.
    """

    source: str
    protocol: str
    errors: dict[tuple[str, str, float], Pool]
    moved: dict[str, Pool]
    trips: int = 0


def predictive_of(profile: Profile) -> FreeMotion:
    """The sub-model that is judged.

    Raises
    ------
    SystemExit
        Where the profile has none.
    """
    found = profile.sub_model(PREDICTIVE)
    if not isinstance(found, FreeMotion):
        raise SystemExit(f"the profile has no sub-model {PREDICTIVE}: train one with 'modelcast train'")
    return found


def _errors(
    case: TripCase, ready: TripRuntime, velocity_mps: FloatArray, sent: IntArray, at: IntArray
) -> FloatArray:
    """Errors at samples ``at`` of a receiver that coasts what was sent at samples ``sent``, (N,) [m]."""
    age_s = case.truth.t_s[at] - ready.stated_s[sent]
    believed_m = ready.stated_m[sent] + velocity_mps[sent] * age_s[:, None]
    return np.hypot(*(case.truth.position_m[at] - believed_m).T)


def _stated(ready: TripRuntime) -> dict[str, FloatArray]:
    """Velocity stated at every sample by who chooses it, (T, 2) [m/s]; who lacks a window says the next."""
    samples = np.arange(len(ready.trip))
    ready.fit_at(samples)
    found: dict[str, FloatArray] = {}
    said: FloatArray = np.zeros((samples.size, 2))
    for member, name in reversed([*enumerate((PREDICTIVE, ESTIMATES, NEWEST))]):
        first = int(ready.bank.offsets[member])
        fitted = ready.fits.number[0, samples, member] == samples
        said = np.where(fitted[:, None], ready.parameters[:, first : first + 2], said)
        found[name] = said
    return found


def _moves(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Differences of speed [m/s] and of heading [degrees] where both move."""
    speeds = np.hypot(*one.T), np.hypot(*other.T)
    moving = (speeds[0] > 0.0) & (speeds[1] > 0.0)
    cross = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    turned = np.arctan2(cross, (one * other).sum(axis=1))
    return np.abs(speeds[0] - speeds[1]), np.abs(np.degrees(turned[moving]))


def add_trip(found: Found, trip: Trajectory, profile: Profile, keep_alive_s: float | None) -> None:
    """Judge one trip, its sender silent for so long at most."""
    case = make_case(trip, EvaluationSettings(protocol=found.protocol))
    sensed = sense_trip(case.seen, case.estimator, quantised=True)
    model = predictive_of(profile)
    estimates = replace(model, networks=(), label=ESTIMATES)
    ready = TripRuntime(
        case.seen,
        Bank((model, estimates, ConstantVelocity())),
        case.estimator,
        quantised=True,
        sensed=sensed,
    )
    stated, dt_s = _stated(ready), case.truth.dt_s
    for pool, values in zip(found.moved.values(), _moves(stated[PREDICTIVE], stated[ESTIMATES]), strict=True):
        pool.add(values, dt_s)
    bank = named_bank("default", profile=profile)
    sender = TripRuntime(case.seen, bank.bank, case.estimator, quantised=True, sensed=sensed)
    policies = [
        ErrorDriven(threshold_m, bank.start, bank.identify, keep_alive_s) for threshold_m in THRESHOLDS_M
    ]
    each = np.arange(len(trip))
    for messages in sender.run_each(policies):
        last = np.maximum.accumulate(np.where(messages.transmits, each, 0))
        for says, velocity_mps in stated.items():
            errors_m = _errors(case, ready, velocity_mps, last, each)
            found.errors[says, "threshold", messages.policy.threshold_m].add(errors_m, dt_s)
    step = max(1, round(_STEP_S / dt_s))
    for age_s in AGES_S:
        lag = round(age_s / dt_s)
        if abs(lag * dt_s - age_s) > _NEAR_RATIO * age_s:
            continue  # this log has no sample so long after another
        sent = each[::step]
        at = sent + lag
        kept = at < each.size
        sent, at = sent[kept], at[kept]
        kept = np.abs(case.truth.t_s[at] - case.truth.t_s[sent] - lag * dt_s) < dt_s / 2.0
        for says, velocity_mps in stated.items():
            errors_m = _errors(case, ready, velocity_mps, sent[kept], at[kept])
            found.errors[says, "age", age_s].add(errors_m, step * dt_s)
    found.trips += 1


def _nothing(source: str, protocol: str) -> Found:
    times = [("threshold", one) for one in THRESHOLDS_M] + [("age", one) for one in AGES_S]
    errors = {(says, kind, one): Pool() for says in SAYS for kind, one in times}
    return Found(source, protocol, errors, {"speed": Pool(), "heading": Pool()})


def judge(profile: Profile, data: Path, sources: Sequence[str], keep_alive_s: float | None) -> list[Found]:
    """Judge a profile on all trips of some sources that it was not trained on."""
    results: list[Found] = []
    for source, pairs in groupby(unseen(profile, data, sources), key=lambda pair: pair[0]):
        own = [_nothing(source, protocol) for protocol in PROTOCOLS]
        for _, trip in pairs:
            for found in own:
                add_trip(found, trip, profile, keep_alive_s)
        print(f"{source}: {own[0].trips} trips", file=sys.stderr, flush=True)
        results += own
    return results


def merged(parts: Iterable[list[Found]]) -> list[Found]:
    """Sources by their order, those that two profiles were judged on together."""
    by_key: dict[tuple[str, str], Found] = {}
    for found in (one for part in parts for one in part):
        whole = by_key.setdefault((found.source, found.protocol), _nothing(found.source, found.protocol))
        whole.trips += found.trips
        for own, other in ((whole.errors, found.errors), (whole.moved, found.moved)):
            for key, pool in other.items():
                own[key].values += pool.values
                own[key].weights_s += pool.weights_s
    return [by_key[key] for key in ((s, p) for s in SOURCES for p in PROTOCOLS) if key in by_key]


def _pairs(found: Found, says: str, kind: str, times: Sequence[float]) -> FloatArray:
    """Mean, p90 and p99 at every time, over the newest sample's where not its own, (N, 3)."""
    own = np.array([found.errors[says, kind, one].figures for one in times])
    if says == NEWEST:
        return own
    return own / _pairs(found, NEWEST, kind, times)


def _cells(values: FloatArray) -> str:
    """A cell a figure, in it a number a time; a dash where there is none."""
    return " | ".join(
        " / ".join("-" if np.isnan(one) else f"{one:.2f}" for one in column) for column in values.T
    )


def errors_table(results: Sequence[Found], kind: str, times: Sequence[float]) -> list[str]:
    """Errors with the newest sample's values [m], and those of the others over them."""
    heads = [f"newest: {what} [m]" for what in ("mean", "p90", "p99")]
    heads += [f"{says}: {what}" for says in SAYS[1:] for what in ("mean", "p90", "p99")]
    lines = ["| source | as seen | " + " | ".join(heads) + " |", "|---|---|" + "---|" * len(heads)]
    logs: list[FloatArray] = []
    for found in results:
        own, *over = (_pairs(found, says, kind, times) for says in SAYS)
        logs.append(np.log(np.concatenate(over, axis=1)))
        cells = " | ".join((_cells(own), *map(_cells, over)))
        lines.append(f"| {found.source} | {found.protocol} | {cells} |")
    mean = np.exp(np.nanmean(logs, axis=0))
    lines.append(f"| geometric mean | | | | | {_cells(mean)} |")
    return lines


def moves_table(results: Sequence[Found]) -> list[str]:
    """Differences of what is stated from the estimates."""
    heads = [f"{what}: {one}" for what in ("speed [m/s]", "heading [°]") for one in ("p50", "p99", "max")]
    lines = ["| source | as seen | " + " | ".join(heads) + " |", "|---|---|" + "---|" * len(heads)]
    for found in results:
        cells = [f"{one:.3f}" for pool in found.moved.values() for one in pool.quantiles(0.5, 0.99, 1.0)]
        lines.append(f"| {found.source} | {found.protocol} | " + " | ".join(cells) + " |")
    return lines


def check_limits(results: Sequence[Found], profiles: Sequence[Profile]) -> None:
    """Refuse differences beyond the limits and the two roundings to the steps of the wire."""
    limits = [predictive_of(profile).limits for profile in profiles]
    speed_step, heading_step = (
        CORE_FIELDS[CORE_INDEX[name]].resolution for name in ("speed_mps", "heading_rad")
    )
    most = {
        "speed": max(one.speed_mps for one in limits) + speed_step,
        "heading": np.degrees(max(one.heading_rad for one in limits) + heading_step),
    }
    for found in results:
        for name, pool in found.moved.items():
            (greatest,) = pool.quantiles(1.0)
            if greatest > most[name] * (1.0 + _ROUNDING):
                raise SystemExit(f"{found.source}: {name} moved by {greatest}, more than {most[name]}")


def tables(results: Sequence[Found], keep_alive_s: float | None) -> list[str]:
    """All that the page shows."""
    silence = (
        "no keep-alive" if keep_alive_s is None else f"after {keep_alive_s:g} s of silence at the latest"
    )
    thresholds = " / ".join(f"{100 * one:g}" for one in THRESHOLDS_M)
    ages = " / ".join(f"{one:g}" for one in AGES_S)
    return [
        f"Sent when the bank sends, at {thresholds} cm, {silence}:",
        "",
        *errors_table(results, "threshold", THRESHOLDS_M),
        "",
        f"Sent at 10 Hz, {ages} s later:",
        "",
        *errors_table(results, "age", AGES_S),
        "",
        "What is stated against the estimates, as messages round both:",
        "",
        *moves_table(results),
    ]


def main() -> int:
    """Judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--profile", type=Path)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--sources", nargs="+", choices=tuple(SOURCES), default=tuple(SOURCES))
    parser.add_argument("--keep-alive", type=float, default=2.0, help="longest silence [s]")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.profile and given.folder:
        parser.error("--profile or --folder, not both")
    paths = [given.folder / f"{which}.json" for which in "ab"] if given.folder else [given.profile]
    profiles = [default_profile() if path is None else read_profile(path) for path in paths]
    for profile in profiles:
        predictive_of(profile)
    data = Path(os.environ.get("MODELCAST_DATA", ""))
    keep_alive_s = given.keep_alive if np.isfinite(given.keep_alive) else None
    own = partial(judge, data=data, sources=given.sources, keep_alive_s=keep_alive_s)
    if given.jobs > 1 and len(profiles) > 1:
        with ProcessPoolExecutor(given.jobs) as pool:
            parts = list(pool.map(own, profiles))
    else:
        parts = [own(profile) for profile in profiles]
    results = merged(parts)
    check_limits(results, profiles)
    lines = tables(results, keep_alive_s)
    print("\n".join(lines))
    if given.write or given.check:
        return put({PAGE: {BLOCK: lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Fixtures that several test modules share."""

import importlib
import inspect
import os
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import modelcast
from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.learned import FeatureMap, Perceptron, Selector
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

settings.register_profile("ci", derandomize=True, deadline=None)
settings.load_profile("ci")


@pytest.fixture(scope="session")
def concrete_classes() -> Callable[[type[Any]], set[type[Any]]]:
    """All classes below a base that modules of `modelcast` define and that can be instantiated."""
    names = [module.name for module in pkgutil.walk_packages(modelcast.__path__, "modelcast.")]
    defined = [
        one
        for module in map(importlib.import_module, [name for name in names if "__main__" not in name])
        for _, one in inspect.getmembers(module, inspect.isclass)
        if one.__module__ == module.__name__
    ]
    return lambda base: {one for one in defined if issubclass(one, base) and not inspect.isabstract(one)}


@pytest.fixture(scope="session")
def constant_selector() -> Callable[..., Selector]:
    """Make a selector that says the same of every window: a score a sub-model."""

    def made(names: tuple[str, ...], scores: FloatArray, threshold_m: float, lags: int = 20) -> Selector:
        inputs = FeatureMap(lags).inputs
        network = Perceptron(
            np.inf,
            centre=np.zeros(inputs),
            width=np.ones(inputs),
            weights_1=np.zeros((inputs, 1)),
            bias_1=np.zeros(1),
            weights_2=np.zeros((1, 1)),
            bias_2=np.zeros(1),
            weights_3=np.zeros((1, scores.size)),
            bias_3=scores,
        )
        return Selector(names, (threshold_m,), (network,), lags=lags)

    return made


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder of the real trips, from MODELCAST_DATA; MODELCAST_REQUIRE_DATA=1 makes its absence a failure."""
    folder = os.environ.get("MODELCAST_DATA", "")
    if not folder:
        reason = "MODELCAST_DATA is not set: tests on real trips need the folder it names"
        if os.environ.get("MODELCAST_REQUIRE_DATA") == "1":
            pytest.fail(reason)
        pytest.skip(reason)
    return Path(folder)


@pytest.fixture(scope="session")
def dynamic_trips(data_folder: Path) -> dict[str, Trajectory]:
    """Ten cars on a test track at 10 Hz, by name; some with gaps, some resampled, none with a heading."""
    path = data_folder / "openacc_zalazone" / "short_setting__dynamic_part12.csv"
    return {trip.trip_id.partition("/")[2]: trip for trip in read_trips(path)}


@pytest.fixture(scope="session")
def spmd_trip(data_folder: Path) -> Trajectory:
    """A car of the Safety Pilot log, with speed and heading, on a coarse position grid."""
    (trip,) = read_trips(data_folder / "spmd" / "bsm_p1_dev.csv")
    return trip


class Replica:
    """A plain, slow sender: it fits and predicts through the public batch interface, one window at a time."""

    def __init__(self, trip: Trajectory, bank: Bank) -> None:
        self.trip = trip
        self.bank = bank
        self.samples = sample_matrix(trip, velocity_estimator_for(trip))
        self._errors: dict[tuple[int, int, int], FloatArray] = {}

    def has_window(self, now: int, member: int) -> bool:
        """Whether the sub-model has a full window at this sample."""
        return now - self.trip.segment_start[now] + 1 >= self.bank.members[member].window

    def tracking_error_m(self, origin: int, now: int, member: int) -> float:
        """Error at a sample of the sub-model fitted at an earlier one, infinite without a full window."""
        if not self.has_window(origin, member):
            return np.inf
        block, at = divmod(now - origin, 128)
        key = (origin, member, block)
        if key not in self._errors:
            self._errors[key] = self._block(origin, member, slice(origin + 128 * block, None))
        return float(self._errors[key][at])

    def _block(self, origin: int, member: int, ahead: slice) -> FloatArray:
        model = self.bank.members[member]
        window = self.samples[None, origin - model.window + 1 : origin + 1]
        parameters = model.fit(Windows(window, dt_s=self.trip.dt_s))
        horizons_s = self.trip.t_s[ahead][:128] - self.trip.t_s[origin]
        moved = model.predict(parameters, horizons_s, dt_s=self.trip.dt_s)[0]
        off = self.trip.position_m[origin] + moved - self.trip.position_m[ahead][:128]
        return np.hypot(off[:, 0], off[:, 1])


@pytest.fixture(scope="session")
def replica() -> Callable[[Trajectory, Bank], Replica]:
    """Makes a plain sender for a trip and a bank."""
    return Replica


Events = list[tuple[int, str, int]]


def looked_back(sender: Replica, now: int, ready: list[int]) -> list[int]:
    """Samples ago at which every sub-model that is ready now had a window in the same part of the trip."""
    backs = sorted({max(int(lag_s / sender.trip.dt_s + 0.5), 1) for lag_s in (0.3, 0.5, 0.8, 1.0, 1.5, 2.0)})
    first = sender.trip.segment_start[now]
    return [
        back for back in backs if now - back >= first and all(sender.has_window(now - back, m) for m in ready)
    ]


def lives_in_hindsight(sender: Replica, now: int, ready: list[int], threshold_m: float) -> dict[int, float]:
    """Mean logarithm of the life that recent predictions would have had; empty where there are none."""
    backs = looked_back(sender, now, ready)
    t_s = sender.trip.t_s
    found: dict[int, float] = {}
    for m in ready if backs else []:
        lives = [
            np.clip(
                (t_s[now] - t_s[now - back])
                * np.sqrt(threshold_m / max(sender.tracking_error_m(now - back, now, m), 1e-4)),
                0.05,
                8.0,
            )
            for back in backs
        ]
        found[m] = float(np.mean(np.log(lives))) + (0.2 if m == 0 else 0.0)
    return found


def serving(
    identify: str, used: int, errors: dict[int, float], lasted_s: dict[int, float], threshold_m: float
) -> dict[int, float]:
    """Errors of the sub-models that may go on or be named."""
    if identify == "never" and errors[used] >= threshold_m:
        return {}
    failed = lasted_s if identify == "final" else {}
    return {m: error for m, error in errors.items() if error < threshold_m and m not in failed}


def named(
    identify: str, used: int, errors: dict[int, float], holding: dict[int, float], threshold_m: float
) -> int:
    """Sub-model that an identification would name; the one in use where there is none to send."""
    best = min(holding, key=lambda m: holding[m], default=used)
    return best if identify == "best" or errors[used] >= threshold_m else used


@dataclass(frozen=True)
class VirtualSenders:
    """Samples at which the bank without a guard, and constant velocity alone, would have sent."""

    free: list[int]
    alone: list[int]
    place: int

    def serves(self, sent: int, now: int) -> bool:
        """Whether constant velocity serves a sender that has sent so many messages by now."""
        if self.place < 0:
            return False
        alone = sum(at <= now for at in self.alone)
        behind = sent - alone
        return behind >= 2 and alone - sum(at <= now for at in self.free) < 2**behind

    def calls(self, sent: int, now: int, used: int) -> bool:
        """Whether a sender that uses constant velocity sends to keep in step."""
        return now in self.alone and used == self.place and self.serves(sent, now - 1)


def virtual_senders(
    sender: Replica, *, threshold_m: float, identify: str, longest_s: float
) -> tuple[VirtualSenders, float]:
    """The virtual senders of a guarded bank, and the least margin of either."""
    place = [member.name for member in sender.bank.members].index("cv")
    lone = Replica(sender.trip, Bank((sender.bank.members[place],)))

    def sends(one: Replica, start: str) -> tuple[Events, float]:
        return algorithm_1(one, threshold_m=threshold_m, start=start, identify=identify, longest_s=longest_s)

    free, margin = sends(sender, "hindsight")
    alone, other = sends(lone, "order")
    return VirtualSenders([at for at, *_ in free], [at for at, *_ in alone], place), min(margin, other)


def first_choice(
    sender: Replica,
    now: int,
    used: int | None,
    lasted_s: dict[int, float],
    *,
    start: str,
    threshold_m: float,
) -> int:
    """Sub-model that an update starts with."""
    ready = [m for m in range(len(sender.bank.members)) if sender.has_window(now, m)]
    if start == "keep" and used in ready:
        return used
    if start == "survivor":
        return max(ready, key=lambda m: lasted_s.get(m, np.inf))
    if start in ("hindsight", "guarded"):
        lives = lives_in_hindsight(sender, now, ready, threshold_m)
        return max(ready, key=lambda m: lives.get(m, 0.0))
    return ready[0]


def algorithm_1(
    sender: Replica, *, threshold_m: float, start: str, identify: str, longest_s: float
) -> tuple[Events, float]:
    """Algorithm 1 from the paper's text, in dictionaries: (sample, message, sub-model), and the least margin.

    The margin is the smallest distance of any tracking error from the threshold.
    """
    t_s = sender.trip.t_s
    members = range(len(sender.bank.members))
    virtual, margin = VirtualSenders([], [], -1), np.inf
    if start == "guarded":
        virtual, margin = virtual_senders(
            sender, threshold_m=threshold_m, identify=identify, longest_s=longest_s
        )
    events: Events = []

    def starter(now: int, used: int | None, lasted_s: dict[int, float]) -> int:
        if virtual.serves(len(events) + 1, now):
            return virtual.place
        return first_choice(sender, now, used, lasted_s, start=start, threshold_m=threshold_m)

    lasted_s: dict[int, float] = {}
    used = starter(0, None, lasted_s)
    events.append((0, "update", used))
    origin = spoken = 0
    for now in range(1, len(t_s)):
        errors = {m: sender.tracking_error_m(origin, now, m) for m in members}
        margin = min(margin, *(abs(error - threshold_m) for error in errors.values()))
        for m in members:
            if errors[m] >= threshold_m:
                lasted_s.setdefault(m, t_s[now] - t_s[origin])
        holding = serving(identify, used, errors, lasted_s, threshold_m)
        overdue = bool(holding) and t_s[now] - t_s[spoken] >= longest_s - 1e-9
        other = named(identify, used, errors, holding, threshold_m)
        if not holding or overdue or (other == used and virtual.calls(len(events), now, used)):
            used = starter(now, used, lasted_s)
            events.append((now, "keep-alive" if overdue else "update", used))
            origin = spoken = now
            lasted_s = {}
        elif other != used:
            used = other
            spoken = now
            events.append((now, "identification", used))
    return events, margin


@pytest.fixture(scope="session", name="algorithm_1")
def _algorithm_1() -> Callable[..., tuple[Events, float]]:
    """Run the plain reference of the error-driven policy."""
    return algorithm_1

"""Fixtures that several test modules share."""

import importlib
import inspect
import os
import pkgutil
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import modelcast
from modelcast.core.arrays import FloatArray
from modelcast.core.open_group import registered
from modelcast.io.trips import read_trips
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.learned import FeatureMap, Perceptron, Selector
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

os.environ.setdefault(
    "MODELCAST_PROGRESS", "none"
)  # what commands say meanwhile depends on the time they take
settings.register_profile("ci", derandomize=True, deadline=None)
settings.load_profile("ci")


@pytest.fixture(scope="module", autouse=True)
def letters_of_pdfs() -> Generator[None]:
    """Draw letters of PDFs as outlines: to pick those of a font is a third of the time of an evaluation.

    Where the files themselves matter, a folder or module has a fixture of this name that leaves them alone.
    """
    from modelcast.report import style  # noqa: PLC0415 - Matplotlib, when the first test runs

    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style._PARAMETERS, "pdf.fonttype", 3)
        yield


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


@pytest.fixture
def other_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Callable[..., Path]]:
    """Put another package on the path: its name, its entry points by group, and its modules' text."""

    def installed(
        name: str,
        groups: dict[str, dict[str, str]],
        modules: dict[str, str] | None = None,
        *,
        version: str = "1.2",
    ) -> Path:
        site = tmp_path / f"site-{name}"
        about = site / f"{name}-{version}.dist-info"
        about.mkdir(parents=True)
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        lines = [
            line
            for group, points in groups.items()
            for line in (f"[{group}]", *(f"{one} = {value}" for one, value in points.items()))
        ]
        (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
        for module, text in (modules or {}).items():
            (site / f"{module}.py").write_text(text)
        monkeypatch.syspath_prepend(site)
        registered.cache_clear()
        return site

    yield installed
    registered.cache_clear()


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


@dataclass
class Steering:
    """The guard's rule in plain Python: whom a sender is with, a guard's place or None for the bank."""

    guards: dict[int, dict[int, str]]
    """What each guard sends at which samples, constant velocity first."""

    sent: dict[int, int] = field(default_factory=dict[int, int])
    own: int = 0
    lead: int = 0
    granted: float = 0.0
    now_with: int | None = None
    past: list[int | None] = field(default_factory=list[int | None])
    stands_in: int | None = None
    """Guard whose sub-model the bank's next message carries, this sample's too."""

    def take(self, now: int, bank: bool) -> bool:
        """Take in a sample; whether the bank starts anew."""
        says = {place: now in messages for place, messages in self.guards.items()}
        before = {place: self.sent.get(place, 0) for place in self.guards}
        self.sent = {place: before[place] + says[place] for place in self.guards}
        sends = bank if self.now_with is None else says[self.now_with]
        allowed = dict(zip(self.guards, ((2, 0.01), (4, 0.03)), strict=False))
        overrun = max(
            self.own + sends - self.sent[place] - max(least, share * self.sent[place] - 1)
            for place, (least, share) in allowed.items()
        )
        anew = False
        fewest = min(reversed(list(self.guards)), key=lambda place: before[place])
        if self.now_with is None:
            self.granted = min(self.granted, max(overrun + 1, 0))
            if overrun >= self.granted and says[fewest]:
                self.now_with, self.lead, sends = fewest, 0, True
        else:
            own, others = self.now_with, [place for place in self.guards if place != self.now_with]
            self.lead = max(self.lead + says[own] - bank, 0)
            better = [place for place in others if before[own] - before[place] >= 2 and says[place]]
            if better:
                self.now_with, self.lead, sends = better[0], 0, True
            elif says[own] and self.lead >= 4 * 4 ** max(overrun, 0):
                self.now_with, self.granted, anew = None, max(overrun + 1, 0), True
        waits = self.now_with is None and not anew and overrun >= self.granted + 1
        self.stands_in = fewest if waits else None
        self.own += sends
        self.past.append(self.now_with)
        return anew


def guarded(sender: Replica, *, threshold_m: float, identify: str, longest_s: float) -> tuple[Events, float]:
    """What a guarded sender sends, and the least margin of it and its guards."""
    names = [member.name for member in sender.bank.members]
    places = [names.index(name) for name in ("cv", "ctra") if name in names]
    alone: dict[int, Events] = {}
    margins: list[float] = []
    for place in places:
        lone = Replica(sender.trip, Bank((sender.bank.members[place],)))
        alone[place], margin = algorithm_1(
            lone, threshold_m=threshold_m, start="order", identify=identify, longest_s=longest_s
        )
        margins.append(margin)
    steering = Steering({place: {now: kind for now, kind, _ in events} for place, events in alone.items()})
    bank, margin = algorithm_1(
        sender,
        threshold_m=threshold_m,
        start="hindsight",
        identify=identify,
        longest_s=longest_s,
        steering=steering,
    )
    said: dict[int | None, Events] = {None: bank} | {
        place: [(now, kind, place) for now, kind, _ in events] for place, events in alone.items()
    }
    events = [one for whom, own in said.items() for one in own if steering.past[one[0]] == whom]
    return sorted(events), min(margin, *margins)


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
    if start == "hindsight":
        lives = lives_in_hindsight(sender, now, ready, threshold_m)
        return max(ready, key=lambda m: lives.get(m, 0.0))
    return ready[0]


def algorithm_1(
    sender: Replica,
    *,
    threshold_m: float,
    start: str,
    identify: str,
    longest_s: float,
    steering: Steering | None = None,
) -> tuple[Events, float]:
    """Algorithm 1 from the paper's text, in dictionaries: (sample, message, sub-model), and the least margin.

    The margin is the smallest distance of any tracking error from the threshold.
    """
    t_s = sender.trip.t_s
    members = range(len(sender.bank.members))
    if start == "guarded":
        return guarded(sender, threshold_m=threshold_m, identify=identify, longest_s=longest_s)
    events: Events = []
    margin = np.inf

    def starter(now: int, used: int | None, lasted_s: dict[int, float]) -> int:
        return first_choice(sender, now, used, lasted_s, start=start, threshold_m=threshold_m)

    lasted_s: dict[int, float] = {}
    used = starter(0, None, lasted_s)
    events.append((0, "update", used))
    if steering is not None:
        steering.take(0, bank=True)
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
        sends = not holding or overdue or other != used
        anew = steering is not None and steering.take(now, sends)
        if not holding or overdue or anew:
            used = starter(now, used, lasted_s)
            if steering is not None and steering.stands_in is not None:
                used = steering.stands_in
            events.append((now, "keep-alive" if overdue and not anew else "update", used))
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


@pytest.fixture(scope="session")
def steering() -> type[Steering]:
    """The guard's rule in plain Python."""
    return Steering

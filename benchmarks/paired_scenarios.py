"""What `paired.py` times: one scenario in this process, as JSON. Works on old and new checkouts alike.

Modules move, so nothing of the package is imported by a module's path: `found` looks for the name in the
sources, first the names used today, then older ones. A scenario prepares, and returns what is timed and,
where there is something to tell, a function that gives the seconds by stage of the last run.
"""

import contextlib
import importlib
import inspect
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["SCENARIOS", "STAGES", "added_up"]

TRIP = "openacc_zalazone/no_ACC__handling_part22.csv"
VEHICLES, DENSITY_PER_KM = 1000, 200.0
STAGES = ("_sense", "_track", "_send", "_carry", "_hear")
"""Methods of the closed loop that are timed apart, where it has them."""
WALL = "-threads"
"""Scenarios so named are timed by the clock on the wall: several threads share them."""
REPEATS = 5
"""A process reports the least of so many runs; long ones are run less often (`LONG_S`)."""
LONG_S = 2.0

Work = Callable[[], object]
Prepared = Work | tuple[Work, Callable[[], Mapping[str, float]]]


class AbsentError(Exception):
    """Something that a scenario needs is not here."""


def home(name: str, beside: str) -> str:
    """Return the module that defines a name, and ``beside`` too where one is given."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    root = Path(str(modelcast.__file__)).parent
    defines = [
        re.compile(rf"^(?:def|class) {one}\b|^{one}\b[^\n]*=", re.MULTILINE) for one in (name, beside) if one
    ]
    fitting = [
        ".".join(path.relative_to(root.parent).with_suffix("").parts).removesuffix(".__init__")
        for path in sorted(root.rglob("*.py"))
        if all(one.search(path.read_text(encoding="utf-8")) for one in defines)
    ]
    if len(fitting) != 1:
        raise AbsentError(f"{name} is defined in {len(fitting)} modules: {', '.join(fitting)}")
    return fitting[0]


def found(*names: str, beside: str = "") -> Any:
    """Return the first of these names that some module defines."""
    for name in names[:-1]:
        with contextlib.suppress(AbsentError):
            return getattr(importlib.import_module(home(name, beside)), name)
    return getattr(importlib.import_module(home(names[-1], beside)), names[-1])


def trip_file() -> Path:
    """Return a recorded file of nine cars."""
    folder = os.environ.get("MODELCAST_DATA", "")
    if not folder or not (Path(folder) / TRIP).exists():
        raise AbsentError(f"needs {TRIP} in the folder that MODELCAST_DATA names")
    return Path(folder) / TRIP


def rates() -> Prepared:
    """Message rates of hybrid and baseline at four thresholds, default bank, nine recorded cars."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    make_case, bank_of, count_rates = (
        found("make_case"),
        found("TripRuntime", "TripBank"),
        found("count_rates"),
    )
    plain = found("BASELINE_BANK")
    settings = modelcast.EvaluationSettings()
    cases = [make_case(trip, settings) for trip in modelcast.read_trips(trip_file())]

    def work() -> None:
        for _ in range(2):
            for case in cases:
                mbc = bank_of(case.seen, settings.bank, case.estimator)
                list(count_rates(case, mbc, bank_of(case.seen, plain, case.estimator), settings))

    return work


def tracking() -> Prepared:
    """Evaluation of a generated drive of five minutes: rates, and tracking under loss."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    drive = modelcast.generate_drive(seed=0, duration_s=300.0)
    settings = modelcast.EvaluationSettings(packet_error_ratios=(0.0, 0.3), seeds=3)
    return lambda: modelcast.evaluate([drive.truth], settings)


def traffic(vehicles: int, seconds: float) -> list[Any]:
    """Return frames of a highway at the density."""
    road = found("Highway")(1000.0 * vehicles / DENSITY_PER_KM, DENSITY_PER_KM, warm_up_s=10.0)
    return list(found("run_scenario")(road, np.random.default_rng(0), duration_s=seconds))


def loop(policy: str, radio: str, seconds: float, threads: int = 1) -> Prepared:
    """Closed loop of 1,000 vehicles, by several threads where it knows how; its stages where it has them."""
    run_network, named_sender = found("run_network", beside="NetworkRun"), found("named_sender")
    settings, sensor = found("NetworkSettings")(warm_up_s=0.0), found("SensorModel")()
    fleet_sensor, channel = found("FleetSensor"), found(radio)
    frames = traffic(VEHICLES, seconds)
    loops = getattr(sys.modules[run_network.__module__], "FleetLoop", None)
    spent: dict[str, float] = {}
    for name in STAGES:
        if hasattr(loops, name):
            setattr(loops, name, added_up(spent, name, getattr(loops, name)))
    more = {"threads": threads} if "threads" in inspect.signature(run_network).parameters else {}

    def run(some: list[Any]) -> None:
        spent.clear()
        sender, own = named_sender(policy), fleet_sensor(sensor)
        run_network(some, sender, channel(), settings, seed=0, sensor=own, **more)

    run(traffic(40, 2.0))
    return (lambda: run(frames)), (lambda: spent)


def added_up(
    spent: dict[str, float],
    name: str,
    function: Callable[..., Any],
    clock: Callable[[], float] = time.perf_counter,
) -> Callable[..., Any]:
    """Wrap a function so that the time it takes is added up."""

    def wrapped(*given: Any, **more: Any) -> Any:
        begun = clock()
        try:
            return function(*given, **more)
        finally:
            spent[name] = spent.get(name, 0.0) + clock() - begun

    return wrapped


def radio(name: str, seconds: float) -> Prepared:
    """A radio alone: 1,000 vehicles at 5 Hz."""
    channel, sent = found(name)(), found("Transmissions")
    rng = np.random.default_rng(0)
    length_m = 5.0 * VEHICLES
    start_m = np.stack([rng.uniform(0, length_m, VEHICLES), 4.0 * rng.integers(0, 8, VEHICLES)], axis=1)
    speed_mps = np.where(start_m[:, 1] < 16.0, 30.0, -30.0)
    phase_s = rng.uniform(0.0, 0.2, VEHICLES)

    def work() -> None:
        state: Any = channel.init(VEHICLES, np.random.default_rng(1))
        carry = getattr(channel, "carry", channel.step)
        position_m = start_m.copy()
        for k in range(round(10 * seconds)):
            t_s = 0.1 * k
            due_s = phase_s + np.ceil((t_s - phase_s) / 0.2 - 1e-9) * 0.2
            sender = np.flatnonzero((due_s >= t_s) & (due_s < t_s + 0.1 - 1e-9))
            sender = sender[np.argsort(due_s[sender], kind="stable")]
            batch = sent(
                sender,
                np.maximum(due_s[sender], state.t_s),
                size_bytes=np.full(sender.size, 300),
                power_dbm=np.full(sender.size, 20.0),
                message_id=sender + k * VEHICLES,
            )
            _, state = carry(state, batch, position_m, round(t_s + 0.1, 3))
            position_m[:, 0] = (position_m[:, 0] + 0.1 * speed_mps) % length_m

    return work


def gp_fit() -> Prepared:
    """Fits of 20,000 windows, one axis and both jointly."""
    fit_axis, process, windows = found("fit_axis"), found("GaussianProcess"), found("Windows")
    columns = found("SAMPLE_COLUMNS")
    rng = np.random.default_rng(0)
    t_s = 0.1 * np.arange(10)
    curve = rng.normal(0.0, 1.0, (20_000, 1, 2)) * t_s[:, None] ** 2
    places_m = (
        curve + rng.normal(0.0, 10.0, (20_000, 1, 2)) * t_s[:, None] + rng.normal(0, 0.02, (20_000, 10, 2))
    )
    y = np.ascontiguousarray(places_m[:, :, 0] - places_m[:, -1:, 0])
    full = windows(np.concatenate([places_m, np.zeros((20_000, 10, columns - 2))], axis=2), dt_s=0.1)
    model = process(form="intercept")

    def work() -> None:
        fit_axis(y, dt_s=0.1)
        model.fit(full)

    return work


def mbc_codec() -> Prepared:
    """Model updates sized and quantised in batch, encoded and decoded one at a time."""
    fields, outside = found("CORE_FIELDS"), found("Outside")
    codec = found("UpdateCodec")(found("WireProfile").of_profile(found("default_profile")()))
    rng = np.random.default_rng(0)
    core = [
        rng.integers(*field.known_codes, 10_000, endpoint=True).astype(float)
        * (1.0 if field.outside is outside.REFUSE else field.resolution)
        for field in fields
    ]
    layouts = codec.profile.layouts
    in_use = rng.integers(0, len(layouts), 10_000).astype(float)
    each = [field for layout in layouts for field in layout.fields]
    coefficients = [rng.uniform(field.low, field.high, 10_000) * field.step for field in each]
    rows = np.stack([*core, in_use, *coefficients], axis=1)
    some = [codec.message_of(row) for row in rows[:2000].tolist()]

    def work() -> None:
        for _ in range(10):
            codec.quantise(rows)
            codec.sizes(rows)
        for message in some:
            codec.decode(codec.encode(message))

    return work


def bsm_codec() -> Prepared:
    """Basic safety messages, in batch and one at a time."""
    encode, decode, fields = found("encode_cores"), found("decode_cores"), found("CORE_FIELDS")
    encode_one, decode_one = found("encode_bsm"), found("decode_bsm")
    rng = np.random.default_rng(0)
    codes = np.stack([rng.integers(field.low, field.high + 1, 10_000) for field in fields], axis=1)
    frames, lengths = encode(codes)
    some = [decode_one(frame.tobytes()).core for frame in frames[:2000]]

    def work() -> None:
        for _ in range(60):
            encode(codes)
            decode(frames, lengths)
        for core in some:
            decode_one(encode_one(core))

    return work


def plausibility() -> Prepared:
    """Checks of 300 vehicles and 3,000 steps, a batch a step."""
    checks, state, stated = (
        found("Plausibility")(),
        found("PlausibilityState"),
        found("Statements", "Reports"),
    )
    vehicle, speeds = np.arange(300), np.tile([20.0, 0.0], (300, 1))

    def work() -> None:
        at: Any = state()
        for step in range(3000):
            t_s = np.full(300, 0.1 * step)
            place_m = np.stack([20.0 * t_s, 5.0 * vehicle], axis=1)
            one = stated(vehicle, t_s, position_m=place_m, velocity_mps=speeds, received_s=t_s)
            _, at = checks.check(at, one)

    return work


def read_file() -> Prepared:
    """Nine cars read from a file."""
    import modelcast  # noqa: PLC0415 - of the checkout under test

    path = trip_file()

    def work() -> None:
        for _ in range(3):
            list(modelcast.read_trips(path))

    return work


SCENARIOS: dict[str, Callable[[], Prepared]] = {
    "rates": rates,
    "tracking": tracking,
    "loop-mbc-dsrc": lambda: loop("j2945-mbc", "Dsrc", 3.0),
    "loop-j2945-dsrc": lambda: loop("j2945", "Dsrc", 3.0),
    "loop-mbc-dsrc-threads": lambda: loop("j2945-mbc", "Dsrc", 3.0, threads=2),
    "loop-j2945-dsrc-threads": lambda: loop("j2945", "Dsrc", 3.0, threads=2),
    "loop-mbc-sidelink": lambda: loop("j2945-mbc", "Sidelink", 1.0),
    "loop-j2945-sidelink": lambda: loop("j2945", "Sidelink", 1.0),
    "radio-dsrc": lambda: radio("Dsrc", 3.0),
    "radio-sidelink": lambda: radio("Sidelink", 1.0),
    "gp-fit": gp_fit,
    "mbc-codec": mbc_codec,
    "bsm-codec": bsm_codec,
    "plausibility": plausibility,
    "read-file": read_file,
}


def demo_cold_s() -> float:
    """Processor time of ``modelcast demo`` with nothing compiled [s]."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "MODELCAST_CACHE_DIR": str(Path(folder) / "cache")}
        command = [sys.executable, "-m", "modelcast", "demo", "--out", str(Path(folder) / "out")]
        before = os.times()
        subprocess.run(  # noqa: S603 - our own command
            command, check=True, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def nothing() -> Mapping[str, float]:
    """No stages."""
    return {}


def timed(name: str) -> dict[str, Any]:
    """Time one scenario: ``seconds`` and ``stages``, or why it is ``absent``."""
    try:
        if name == "demo-cold":
            return {"seconds": demo_cold_s(), "stages": {}}
        prepared = SCENARIOS[name]()
        work, stages = prepared if isinstance(prepared, tuple) else (prepared, nothing)
        work()  # compiles
        clock = time.perf_counter if name.endswith(WALL) else time.process_time
        least, told, spent = np.inf, dict[str, float](), 0.0
        for turn in range(REPEATS):
            begun = clock()
            work()
            took = clock() - begun
            spent += took
            if took < least:
                least, told = took, dict(stages())
            if turn and spent > LONG_S:
                break
    except AbsentError as error:
        return {"absent": str(error)}
    return {"seconds": float(least), "stages": told}


if __name__ == "__main__":
    print(json.dumps(timed(sys.argv[1])))

"""User code that must type-check under pyright strict and mypy; it is not run."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, assert_type

import numpy as np
import polars as pl
from matplotlib.figure import Figure
from numpy.typing import NDArray

import modelcast
from modelcast import (
    Bank,
    BsmCore,
    CompareSettings,
    ConstantVelocity,
    ErrorDriven,
    Evaluation,
    EvaluationResult,
    EvaluationSettings,
    FixedCandidate,
    GaussianProcess,
    LocalDynamicMap,
    Periodic,
    Profile,
    SensedTrip,
    TrainedCandidate,
    Trajectory,
    build_trajectory,
    compare,
    decode_bsm,
    default_profile,
    encode_bsm,
    evaluate,
    generate_drive,
    read_profile,
    read_trips,
    train_profile,
    write_results,
)
from modelcast.station.policy.error_driven import ErrorDrivenState
from modelcast.study.table import Row, Table


def show(done: int, known: int) -> None:
    """Show progress."""
    del done, known


def evaluate_files(paths: list[Path]) -> list[Path]:
    """Evaluate some files with a bank of one's own."""
    bank = Bank((GaussianProcess(form="intercept"), ConstantVelocity()), "mine")
    settings = EvaluationSettings(
        (0.2, 0.5), (0.0, 0.4), seeds=3, bank=bank, start="survivor", identify="final"
    )
    result = evaluate(read_trips(paths), settings, progress=show)
    assert_type(result, Evaluation)
    assert_type(result.rates, pl.DataFrame)
    assert_type(result.plot.rates(), Figure)
    assert_type(result.result, EvaluationResult)
    assert_type(result.result.rates, Table)
    assert_type(result.result.rates[0], Row)
    assert_type(result.result.rates[1:], Table)
    assert_type(result.result.tracking["pte_p90_m"], NDArray[Any])
    assert_type(result.result.tracking[0].plain(), dict[str, Any])
    return [*write_results(result, Path("out")), *result.report("out")]


def evaluate_frame(frame: pl.DataFrame, path: str) -> list[str]:
    """Evaluate a data frame and a path, and ask for trips by their places."""
    trips = read_trips([path, frame], columns={"t": "clock", "east": "x", "north": "y"})
    assert_type(trips[0], Trajectory)
    assert_type(trips[1:], list[Trajectory])
    results = [evaluate(given) for given in (path, frame, trips, trips[0], [trips[0], frame])]
    return [repr(result) for result in results]


def use_profiles(path: Path, trips: list[Trajectory]) -> str:
    """Take the shipped profile, one of a file, or one of one's own trips."""
    assert_type(default_profile(), Profile)
    mine = train_profile(trips) if trips else read_profile(path)
    assert_type(mine.bank, Bank)
    return mine.identity


def learn(trips: Sequence[Trajectory], settings: EvaluationSettings) -> EvaluationSettings:
    """Learn a window's length from some trips."""
    return replace(settings, bank=Bank((GaussianProcess(5 + len(trips)),)))


def compare_files(paths: list[Path]) -> float | None:
    """Compare a bank with one that is trained."""
    candidates = [FixedCandidate("cv", Bank((ConstantVelocity(),)), "keep"), TrainedCandidate("mine", learn)]
    result = compare(paths, candidates, CompareSettings(against="mine"), progress=show)
    assert_type(result.ratios, pl.DataFrame)
    assert_type(result.result.ratios[0].message_ratio, Any)
    low_m: float | None = result.result.tracking[0].p90_low
    return low_m


def make_trips() -> list[Trajectory | SensedTrip]:
    """Make trips without a file."""
    t_s = np.arange(100) * 0.1
    trip = build_trajectory("made/1", t_s, np.stack([10 * t_s, 0 * t_s], axis=1), source="made")
    assert_type(trip, Trajectory)
    assert_type(trip.duration_s, float)
    drive = generate_drive(seed=1, duration_s=120.0)
    return [trip, SensedTrip(drive.truth, drive.input)]


def policies() -> tuple[ErrorDriven, Periodic, LocalDynamicMap]:
    """Name policies and a host by what they hold."""
    error_driven = ErrorDriven(0.3, "keep", "best", max_inter_transmit_time_s=2.0)
    state = error_driven.init(4, 2)
    assert_type(state, ErrorDrivenState)
    return error_driven, Periodic(2.0), LocalDynamicMap((Bank((ConstantVelocity(),)),), expiry_s=3.0)


def pass_on(octets: bytes, model: bytes) -> bytes:
    """Add a model to a message that was received."""
    message = decode_bsm(octets)
    assert_type(message.core, BsmCore)
    assert_type(message.core.value("speed_mps"), float | None)
    return encode_bsm(message.core, part_ii=message.part_ii, regional=((128, model),))


def version() -> str:
    """The version, as text."""
    return str(modelcast.__version__)

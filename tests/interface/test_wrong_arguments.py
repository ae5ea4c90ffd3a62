"""What a caller gets wrong at the first try is told by the argument, what was given, and a remedy."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import modelcast
from modelcast.core.argument_types import require_several, require_type

T_S = np.arange(0.0, 30.0, 0.1)
FRAME = pl.DataFrame({"t": T_S, "x": 20.0 * T_S, "y": 0.0, "vehicle": "a"})
CV = modelcast.FixedCandidate("cv", modelcast.bank_from_text("cv"))
ROAD = modelcast.Highway(500.0, 20.0)

Call = Callable[[Any], object]

WRONG: dict[str, tuple[Call, Any, str]] = {
    "columns for trips": (modelcast.evaluate, {"t": T_S, "x": T_S}, "not dict: give arrays to build_traj"),
    "an array for trips": (modelcast.evaluate, np.zeros((3, 2)), "not ndarray: give arrays to build_traj"),
    "columns to read": (modelcast.read_trips, {"t": T_S}, "not dict: make a data frame of it"),
    "a number for settings": (
        lambda given: modelcast.evaluate(FRAME, given),
        0.5,
        "settings must be of EvaluationSettings, not float",
    ),
    "a number for training's": (
        lambda given: modelcast.train_profile(FRAME, given),
        0.5,
        "settings must be of ProfileSettings, not float",
    ),
    "a number for a plan": (
        lambda given: modelcast.reproduce_paper(FRAME, given),
        0.5,
        "plan must be of PaperPlan, not float",
    ),
    "settings of another study": (
        lambda given: modelcast.compare(FRAME, [CV], given),
        modelcast.EvaluationSettings(),
        "settings must be of CompareSettings, not EvaluationSettings",
    ),
    "settings of another study, warnings": (
        lambda given: modelcast.evaluate_warnings(FRAME, [CV], given),
        modelcast.EvaluationSettings(),
        "settings must be of SafetySettings, not EvaluationSettings",
    ),
    "names for candidates": (
        lambda given: modelcast.compare(FRAME, given),
        ["cv"],
        r"candidates\[0\] must be of AbstractCandidate, not str: give modelcast.FixedCandidate",
    ),
    "a name for candidates": (
        lambda given: modelcast.evaluate_warnings(FRAME, given),
        "cv",
        "candidates must be of FixedCandidate, not str: give modelcast.FixedCandidate",
    ),
    "a name for a bank": (
        lambda given: modelcast.FixedCandidate("cv", given),
        "cv",
        "bank must be of Bank, not str: give modelcast.bank_from_text",
    ),
    "a name for a bank of settings": (
        lambda given: modelcast.EvaluationSettings(bank=given),
        "cv",
        "bank must be of Bank, not str: give modelcast.bank_from_text",
    ),
    "a threshold for thresholds": (
        modelcast.EvaluationSettings,
        0.5,
        "thresholds_m must be of Sequence, not float: give several numbers",
    ),
    "a name for a scenario": (
        modelcast.simulate_network,
        "highway",
        "scenarios must be of AbstractScenario, not str: give modelcast.Highway",
    ),
    "a number for a sender": (
        lambda given: modelcast.simulate_network(ROAD, given),
        3,
        r"senders\[0\] must be of Sender, not int: give names, or what modelcast.named_sender makes",
    ),
    "radios in a list": (
        lambda given: modelcast.simulate_network(ROAD, "bsm-10hz", given),
        [modelcast.Dsrc()],
        r"radios\[0\] must be of str, not Dsrc: .* a mapping of names to radios",
    ),
    "seconds for runs": (
        lambda given: modelcast.simulate_network(ROAD, "bsm-10hz", "ideal", given),
        5.0,
        "runs must be of FleetRuns, not float: give modelcast.FleetRuns",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_argument_is_told_by_its_name(what: str) -> None:
    call, given, message = WRONG[what]
    with pytest.raises(TypeError, match=message):
        call(given)


def test_one_candidate_may_stand_alone() -> None:
    evaluation = modelcast.EvaluationSettings((0.5,), (0.0,), seeds=1, references=False)
    asked = modelcast.CompareSettings(evaluation, ("recorded",), resamples=10)
    alone, listed = (modelcast.compare(FRAME, given, asked).ratios for given in (CV, [CV]))
    assert alone.equals(listed)


def test_an_iterator_is_several_and_nothing_is_none() -> None:
    assert require_several("seeds", iter((1, 2)), int) == [1, 2]
    assert require_several("seeds", (), int) == []
    require_type("seeds", True, int)


@pytest.mark.parametrize("name", ["thresholds_m", "packet_error_ratios"])
def test_a_text_is_no_sequence_of_numbers(name: str) -> None:
    with pytest.raises(TypeError, match=rf"{name} must be of Sequence, not str: give several numbers"):
        modelcast.EvaluationSettings(**{name: "0.5"})


@pytest.mark.parametrize("write", [modelcast.write_csv, modelcast.write_parquet])
def test_one_trip_is_written_as_a_list_of_one_and_a_frame_is_refused(write: Any, tmp_path: Path) -> None:
    (trip,) = modelcast.read_trips(FRAME)
    write(trip, tmp_path / "one")
    write([trip], tmp_path / "listed")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "listed").read_bytes()
    with pytest.raises(TypeError, match=r"trips must be of Trajectory, not Series: modelcast.read_trips"):
        write(FRAME, tmp_path / "frame")
    assert not (tmp_path / "frame").exists()

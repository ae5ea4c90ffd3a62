"""Whatever form trips come in, the studies see the same trips."""

import dataclasses
import inspect
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import modelcast
import modelcast.study.compare.run
import modelcast.study.evaluate
import modelcast.study.paper.run
import modelcast.study.training.profile
from modelcast import study
from modelcast.interface import training
from modelcast.interface.given_trips import GivenTripList
from modelcast.io.write_trips import write_parquet
from modelcast.study.case import SensedTrip
from modelcast.study.paper.plan import PaperPlan
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

SMALL = modelcast.EvaluationSettings((0.5,), (0.0,), seeds=1, references=False)


@pytest.fixture(name="trip", scope="module")
def _trip() -> Trajectory:
    return generate_drive(seed=3, duration_s=90.0).truth


@pytest.fixture(name="path")
def _path(trip: Trajectory, tmp_path: Path) -> Path:
    write_parquet([trip], tmp_path / "drive.parquet")
    return tmp_path / "drive.parquet"


FORMS: dict[str, Callable[[Path], Any]] = {
    "path": lambda path: path,
    "text": str,
    "folder": lambda path: path.parent,
    "list of paths": lambda path: [path],
    "frame": pl.read_parquet,
    "table": lambda path: pl.read_parquet(path).to_arrow(),
    "trips": modelcast.read_trips,
    "trip": lambda path: modelcast.read_trips(path)[0],
    "tuple of trips": lambda path: tuple(modelcast.read_trips(path)),
    "iterator": lambda path: iter(modelcast.read_trips(path)),
    "list of lists": lambda path: [[modelcast.read_trips(path)]],
}
"""The trip of a file in every form a user may have it in."""


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_same_trip(form: str, path: Path, trip: Trajectory) -> None:
    (found,) = GivenTripList(FORMS[form](path)).recorded()
    assert np.array_equal(found.position_m, trip.position_m)
    assert found.trip_id == trip.trip_id


def test_a_trip_alone_is_not_taken_for_its_samples(trip: Trajectory) -> None:
    assert GivenTripList(trip).recorded() == [trip]


def test_paths_and_frames_in_one_list_may_not_share_a_name(path: Path) -> None:
    frame = pl.read_parquet(path)
    names = [trip.trip_id for trip in GivenTripList([path, frame]).recorded()]
    assert len(set(names)) == 2


@pytest.mark.parametrize("given", [3, None, [3], object()])
def test_what_is_no_trip_is_refused_by_its_type(given: object) -> None:
    with pytest.raises(TypeError, match="trips are paths, data frames, or what read_trips"):
        GivenTripList(given).recorded()


def test_only_evaluate_takes_trips_whose_truth_is_known_apart(trip: Trajectory) -> None:
    sensed = SensedTrip(trip, trip)
    assert list(GivenTripList([sensed])) == [sensed]
    with pytest.raises(TypeError, match="goes with evaluate alone"):
        GivenTripList(sensed).recorded()


def test_trips_of_an_iterator_are_taken_one_at_a_time(trip: Trajectory) -> None:
    taken: list[int] = []

    def trips() -> Iterator[Trajectory]:
        for number in range(3):
            taken.append(number)
            yield trip

    found = iter(GivenTripList(trips()))
    next(found)
    assert taken == [0]


def test_evaluate_and_compare_find_the_same_of_a_path_and_of_its_trip(path: Path) -> None:
    trip = modelcast.read_trips(path)[0]
    one, other = modelcast.evaluate(path, SMALL), modelcast.evaluate([trip], SMALL)
    assert one.rates.equals(other.rates)
    assert one.tracking.equals(other.tracking)
    candidates = [modelcast.FixedCandidate("paper", modelcast.PAPER_BANK)]
    asked = modelcast.CompareSettings(SMALL, ("recorded",), resamples=10)
    ratios = modelcast.compare(path, candidates, asked).ratios
    assert ratios.equals(modelcast.compare(trip, candidates, asked).ratios)


def platoon_frame(name: str = "c", rows: int = 600) -> pl.DataFrame:
    """Two cars after one another, and a third whose only row has no place."""
    t_s = 100.0 + np.arange(rows) / 10
    speed_mps = 15.0 + 2.0 * np.sin(0.3 * t_s)
    east_m = np.cumsum(speed_mps) / 10
    cars = {"a": east_m + 30.0, "b": east_m}
    nowhere = pl.DataFrame(
        {"t": [0.0], "x": [None], "y": [0.0], "vehicle": [name]}, schema_overrides={"x": pl.Float64}
    )
    frames = [pl.DataFrame({"t": t_s, "x": at, "y": 0.0, "vehicle": car}) for car, at in cars.items()]
    return pl.concat([*frames, nowhere])


def evaluated(trips: Any) -> Any:
    return modelcast.evaluate(trips, SMALL)


def compared(trips: Any) -> Any:
    asked = modelcast.CompareSettings(SMALL, ("recorded",), resamples=10)
    return modelcast.compare(trips, [modelcast.FixedCandidate("cv", modelcast.bank_from_text("cv"))], asked)


def warned(trips: Any) -> Any:
    evaluation = dataclasses.replace(SMALL, protocol="sensor")
    candidates = [modelcast.FixedCandidate(name, modelcast.bank_from_text(name)) for name in ("cv", "ca")]
    return modelcast.evaluate_warnings(trips, candidates, modelcast.SafetySettings(evaluation, resamples=10))


def reproduced(trips: Any) -> Any:
    return modelcast.reproduce_paper(trips=trips, plan=PaperPlan((0.5,), (0.4,), seeds=1, resamples=10))


SKIPPING: dict[str, tuple[Callable[[], Any], list[str]]] = {
    "a frame": (platoon_frame, ["frame/c"]),
    "a list of frames": (
        lambda: [platoon_frame(), platoon_frame("d").filter(pl.col("vehicle") == "d")],
        ["frame/c", "frame/d"],
    ),
    "what read_trips gave, twice": (lambda: [modelcast.read_trips(platoon_frame())], ["frame/c"]),
    "two readings": (
        lambda: [modelcast.read_trips(platoon_frame()), modelcast.read_trips(platoon_frame()[-1:])],
        ["frame/c", "frame/c#2"],
    ),
    "a frame in a list of lists": (lambda: ([platoon_frame()], []), ["frame/c"]),
}
"""Forms of trips, and what of them gives none."""


@pytest.mark.parametrize("form", SKIPPING)
def test_an_evaluation_names_what_held_no_trip(form: str) -> None:
    make, expected = SKIPPING[form]
    found = evaluated(make())
    assert list(found.skipped) == expected
    assert all(found.skipped.values())
    assert f"{len(expected)} skipped" in repr(found)


@pytest.mark.slow
@pytest.mark.parametrize("function", [evaluated, compared, warned, reproduced])
def test_what_held_no_trip_reaches_every_result_its_line_and_its_files(
    function: Callable[[Any], Any], tmp_path: Path
) -> None:
    trips = [platoon_frame("a-c"), modelcast.read_trips(platoon_frame("a-d")[-1:])]
    found = function(trips)
    assert list(found.skipped) == ["frame/a-c", "frame/a-d"]
    if function is not reproduced:
        assert "2 skipped" in repr(found)
        found.write(tmp_path)
        assert json.loads((tmp_path / "summary.json").read_text())["skipped"] == found.skipped
        assert any(
            "a-d" in path.read_text(encoding="utf-8")
            for path in found.report(tmp_path / "report")
            if path.suffix in {".html", ".md"}
        )


def test_training_warns_of_what_held_no_trip_and_takes_trips_by_name(
    monkeypatch: pytest.MonkeyPatch, trip: Trajectory
) -> None:
    given: list[Any] = []
    monkeypatch.setattr(training, "train", lambda trips, *_rest, **_options: given.extend(trips))
    with pytest.warns(UserWarning, match="no trip from frame/c: .*") as told:
        modelcast.train_profile(trips=[platoon_frame()], settings=None, beside=None, progress=None)
    assert (len(told), [one.trip_id for one in given]) == (1, ["frame/a", "frame/b"])
    modelcast.train_profile(trip)  # nothing to tell
    assert given[2:] == [trip]


def test_iterating_again_counts_nothing_twice() -> None:
    trips = GivenTripList([platoon_frame(), [platoon_frame("e")[-1:]]])
    assert [one.trip_id for one in trips] == [one.trip_id for one in trips]
    assert list(trips.skipped) == ["frame/c", "frame/e"]


@pytest.mark.parametrize(
    "name", ["evaluate", "compare", "evaluate_warnings", "train_profile", "reproduce_paper"]
)
def test_trips_may_be_given_by_name(name: str) -> None:
    function = getattr(modelcast, name)
    parameters = inspect.signature(function).parameters
    assert parameters["trips"].kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
    assert function.__module__.startswith("modelcast.interface.")
    rest = {"candidates": []} if "candidates" in parameters else {}
    with pytest.raises(TypeError, match="trips are paths, data frames"):
        function(trips=3, **rest)


STUDIES: dict[str, Callable[..., Any]] = {
    "evaluate": study.evaluate.evaluate,
    "compare": study.compare.run.compare,
    "train_profile": study.training.profile.train_profile,
    "reproduce_paper": study.paper.run.reproduce_paper,
}


@pytest.mark.parametrize("name", STUDIES)
def test_what_takes_any_form_has_the_parameters_of_its_study(name: str) -> None:
    ours, theirs = (inspect.signature(one).parameters for one in (getattr(modelcast, name), STUDIES[name]))
    assert [(one.name, one.kind, one.default) for one in ours.values()] == [
        (one.name, one.kind, one.default) for one in theirs.values()
    ]

"""Whatever form trips come in, the studies see the same trips."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import modelcast
from modelcast.interface.given_trips import given_trips, recorded_trips, takes_given_trips
from modelcast.io.write_trips import write_parquet
from modelcast.study.case import SensedTrip
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
    (found,) = recorded_trips(FORMS[form](path))
    assert np.array_equal(found.position_m, trip.position_m)
    assert found.trip_id == trip.trip_id


def test_a_trip_alone_is_not_taken_for_its_samples(trip: Trajectory) -> None:
    assert recorded_trips(trip) == [trip]


def test_paths_and_frames_in_one_list_may_not_share_a_name(path: Path) -> None:
    frame = pl.read_parquet(path)
    names = [trip.trip_id for trip in recorded_trips([path, frame])]
    assert len(set(names)) == 2


@pytest.mark.parametrize("given", [3, None, [3], object()])
def test_what_is_no_trip_is_refused_by_its_type(given: object) -> None:
    with pytest.raises(TypeError, match="trips are paths, data frames, or what read_trips"):
        recorded_trips(given)


def test_only_evaluate_takes_trips_whose_truth_is_known_apart(trip: Trajectory) -> None:
    sensed = SensedTrip(trip, trip)
    assert list(given_trips([sensed])) == [sensed]
    with pytest.raises(TypeError, match="goes with evaluate alone"):
        recorded_trips(sensed)


def test_trips_of_an_iterator_are_taken_one_at_a_time(trip: Trajectory) -> None:
    taken: list[int] = []

    def trips() -> Iterator[Trajectory]:
        for number in range(3):
            taken.append(number)
            yield trip

    found = iter(given_trips(trips()))
    next(iter(found))
    assert taken == [0]


def test_a_function_of_trips_keeps_its_name_and_takes_what_evaluate_takes(path: Path) -> None:
    def count(trips: Any, *, twice: bool = False) -> int:
        """Count."""
        return len(trips) * (2 if twice else 1)

    taking = takes_given_trips(count)
    assert (taking.__name__, taking.__doc__) == ("count", "Count.")
    assert (taking(path), taking(pl.read_parquet(path), twice=True)) == (1, 2)
    assert modelcast.train_profile.__name__ == "train_profile"
    assert modelcast.reproduce_paper.__name__ == "reproduce_paper"


def test_evaluate_and_compare_find_the_same_of_a_path_and_of_its_trip(path: Path) -> None:
    trip = modelcast.read_trips(path)[0]
    one, other = modelcast.evaluate(path, SMALL), modelcast.evaluate([trip], SMALL)
    assert one.rates.equals(other.rates)
    assert one.tracking.equals(other.tracking)
    candidates = [modelcast.FixedCandidate("paper", modelcast.PAPER_BANK)]
    asked = modelcast.CompareSettings(SMALL, ("recorded",), resamples=10)
    ratios = modelcast.compare(path, candidates, asked).ratios
    assert ratios.equals(modelcast.compare(trip, candidates, asked).ratios)


def test_an_evaluation_names_what_held_no_trip(path: Path) -> None:
    (path.parent / "notes.md").write_text("no trip")
    found = modelcast.evaluate(path.parent, SMALL)
    assert list(found.skipped) == [str(path.parent / "notes.md")]

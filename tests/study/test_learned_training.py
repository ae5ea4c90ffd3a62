"""Claims about the training of the learned sub-model and of profiles."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.exceptions import MissingExtraError
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.learned import FeatureMap
from modelcast.models.profile import default_profile, profile_from_text
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.study.training.dates import training_dates
from modelcast.study.training.descent import Descent
from modelcast.study.training.free import FreeSettings
from modelcast.study.training.free_members import FreeMembersSettings
from modelcast.study.training.learned import LearnedSettings, NoiseStage, train_learned
from modelcast.study.training.playback import AS_RECORDED
from modelcast.study.training.processes import ProcessSettings
from modelcast.study.training.profile import ProfileSettings, train_profile
from modelcast.study.training.views import SenderView, played_trips, view_trips
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

SHORT = Descent(hidden=(24, 16), steps=400, batch=512)
CLEAN = LearnedSettings((NoiseStage((0.0, np.inf), (SenderView("positions"),)),), descent=SHORT)

QUICK = ProcessSettings(200, 8, regimes=2, regime_evaluations=4)

FREE = FreeMembersSettings(
    FreeSettings(FeatureMap(10), descent=replace(SHORT, steps=20, batch=128), searched=60),
    views=((SenderView("positions", 0.005), 1.0), (SenderView("motion", 0.01), 1.0)),
    playbacks=(AS_RECORDED,),
    rows=300,
)


def weaving(seed: int) -> Trajectory:
    """A car that weaves and changes its speed, each at a rhythm of its own."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 100.0, 0.1)
    slow, fast = rng.uniform(0.4, 0.6, 2)
    begin = rng.uniform(0.0, 6.0, 2)
    east = 12.0 * t + 8.0 * np.sin(slow * t + begin[0])
    position = np.stack([east, 5.0 * np.sin(fast * t + begin[1])], axis=1)
    return build_trajectory(f"weaving{seed}/1", t, position)


def drive(seed: int) -> Trajectory:
    truth = generate_drive(seed, 120.0).truth
    return replace(truth, trip_id=f"drive{seed}/1")


@pytest.fixture(scope="module")
def trips() -> list[Trajectory]:
    return [drive(seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def learned() -> AbstractSubModel:
    return train_learned([weaving(seed) for seed in range(6)], CLEAN)


def messages(trip: Trajectory, member: AbstractSubModel) -> int:
    bank = Bank((member, ConstantTurnRateAcceleration())) if member.window > 1 else Bank((member,))
    ready = TripRuntime(trip, bank, velocity_estimator_for(trip))
    return ready.run(ErrorDriven(0.2, identify="never")).updates


@pytest.mark.slow
def test_on_cars_it_has_not_seen_it_sends_fewer_messages_than_what_it_corrects(
    learned: AbstractSubModel,
) -> None:
    unseen = [weaving(seed) for seed in (20, 21)]
    corrected = sum(messages(trip, learned) for trip in unseen)
    kinematic = sum(messages(trip, ConstantTurnRateAcceleration()) for trip in unseen)
    assert corrected < 0.85 * kinematic


@pytest.mark.slow
def test_the_same_trips_and_seed_give_the_same_networks() -> None:
    cars = [weaving(seed) for seed in range(2)]
    short = replace(CLEAN, descent=replace(SHORT, steps=20))
    assert train_learned(cars, short) == train_learned(cars, short)
    assert train_learned(cars, replace(short, seed=1)) != train_learned(cars, short)


def test_progress_ends_complete(trips: list[Trajectory]) -> None:
    told: list[tuple[int, int]] = []
    short = replace(CLEAN, descent=replace(SHORT, steps=20, report_every=8))
    train_learned(trips[:1], short, progress=lambda done, to_do: told.append((done, to_do)))
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_without_jax_the_extra_is_named(trips: list[Trajectory], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "optax", None)
    with pytest.raises(MissingExtraError, match="needs jax, optax and scipy: "):
        train_learned(trips[:1], CLEAN)


def test_trips_too_short_to_learn_from_are_refused() -> None:
    with pytest.raises(ValueError, match="no trip has 6 s after a full window"):
        train_learned([build_trajectory("short/1", np.arange(50) * 0.1, np.zeros((50, 2)))], CLEAN)


def test_a_view_changes_what_is_seen_and_never_the_truth(trips: list[Trajectory]) -> None:
    (bare,) = view_trips(played_trips(trips[:1]), SenderView("positions", 0.05), seed=0)
    (moving,) = view_trips(played_trips(trips[:1]), SenderView("motion", 0.05), seed=0)
    (rates,) = view_trips(played_trips(trips[:1]), SenderView("rates", 0.05, every=2), seed=0)
    assert bare.seen.speed_mps is None
    assert moving.seen.acceleration_mps2 is None
    assert rates.seen.yaw_rate_radps is not None
    assert rates.seen.dt_s == pytest.approx(0.2)
    for view in (bare, moving):
        assert np.array_equal(view.truth.position_m, trips[0].position_m)
        off = view.seen.position_m - view.truth.position_m
        assert off.std() == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize("wrong", [{"steps": 0}, {"softness": 0.0}, {"thresholds_m": ()}, {"batch": 0}])
def test_a_descent_out_of_range_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong)).partition("_")[0]):
        replace(SHORT, **wrong)


PROCESSES = {"gp-vehicle", "gp-derivative", "gp-trained", "gp-regime-1", "gp-regime-2"}
NETWORKS = {"free", "free-predictive", "learned"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("steps", "also", "trained"),
    [
        (10, ("learned",), NETWORKS),
        pytest.param(400, ("learned", "processes"), NETWORKS | PROCESSES, marks=pytest.mark.slow),
    ],
)
def test_a_profile_chooses_its_bank_by_messages_and_records_how(
    trips: list[Trajectory], steps: int, also: tuple[str, ...], trained: set[str]
) -> None:
    settings = ProfileSettings(
        replace(CLEAN, descent=replace(SHORT, steps=steps)),
        free=FREE,
        processes=QUICK,
        also=also,
        thresholds_m=(0.2, 0.5),
        validate=True,
    )
    apart = [
        replace(trip, trip_id=f"file{at}/1", origin=None, start_unix_s=None) for at, trip in enumerate(trips)
    ][: 3 if "processes" in also else 2]
    profile = train_profile(apart, settings)
    figures = profile.record["figures"]
    assert "dates" not in profile.record
    totals = {name: sum(sum(row) for row in rows.values()) for name, rows in figures["messages"].items()}
    assert figures["counted_on"] == "routes left out"
    singles = {name: total for name, total in totals.items() if name in figures["steps"][0]}
    first = profile.bank.members[0].name
    assert figures["steps"][0][first] == min(figures["steps"][0].values())
    assert totals["bank"] <= 1.02 * min(singles.values())
    assert totals["baseline"] == totals["cv"]
    assert profile.bank.window == 1
    assert {member.name for member in profile.sub_models} >= trained
    assert set(totals) >= {*trained, "bank", "baseline"}
    assert ("regimes" in totals) == ("processes" in also)
    assert profile.regimes is None if "processes" not in also else profile.regimes.bank.name == "regimes"
    assert set(profile.record.get("processes") or {}) == {name for name in trained if name.startswith("gp-")}
    assert profile_from_text(profile.text) == profile
    assert [one["trip"] for one in profile.record["trips"]] == [trip.trip_id for trip in apart]


@pytest.mark.slow
def test_families_are_trained_that_the_bank_names_and_others_are_taken_over(trips: list[Trajectory]) -> None:
    """The shipped profile lends what is not trained anew, and what was added to it stays added."""
    shipped = default_profile()
    dated = replace(trips[0], start_unix_s=1_334_102_350.0)
    profile = train_profile([dated], ProfileSettings(free=FREE, seed=3), beside=shipped)
    assert [member.name for member in profile.bank.members] == ["free-predictive", "free", "ctra", "cv"]
    assert profile.bank.sent_plain == (True, True, True, False)
    assert profile.sub_model("free") != shipped.sub_model("free")
    for name in ("learned", "gp-vehicle", "gp-derivative", "gp-trained", "gp-regime-1"):
        assert profile.sub_model(name) == shipped.sub_model(name)
    assert (profile.added, profile.added_record) == (shipped.added, shipped.added_record)
    assert profile.record["networks"] == shipped.record["networks"]
    assert profile.record["free"]["seed"] == 3
    assert profile.record["dates"] == training_dates([dated])
    assert profile.training_trips == (fingerprint(trips[0]), *shipped.training_trips)
    assert profile_from_text(profile.text) == profile


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(ValueError, match="families, free, learned, processes, switching, not 'gp'"):
        ProfileSettings(also=("gp",))


@pytest.mark.slow
def test_one_route_alone_cannot_be_left_out(trips: list[Trajectory]) -> None:
    settings = ProfileSettings(CLEAN, free=FREE, processes=QUICK, validate=True)
    together = [replace(trip, trip_id=f"file/{at}") for at, trip in enumerate(trips[:2])]
    with pytest.raises(ValueError, match="one route"):
        train_profile(together, settings)


def test_dates_are_those_of_the_trips_that_have_one(trips: list[Trajectory]) -> None:
    """From the first beginning to the last end; times that no calendar holds are none."""
    day_s = 86_400.0
    starts_s = (3 * day_s, 9.5 * day_s, None, -1.0, 1e300, np.nan)
    given = [replace(trips[0], start_unix_s=start_s) for start_s in starts_s]
    assert training_dates(given) == {"first": "1970-01-04", "last": "1970-01-10", "trips": 2}
    assert training_dates(given[2:]) == {}

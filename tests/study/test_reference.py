"""Claims about the references: the sender that knows the future, and the counts of both references."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from modelcast.io.trips import read_trips
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case
from modelcast.study.clairvoyant import clairvoyant
from modelcast.study.clairvoyant_kernels import decide
from modelcast.study.evaluate import evaluate
from modelcast.study.minimax_kernels import FAILS, HOLDS
from modelcast.study.reference import count_references
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory, build_trajectory

THRESHOLDS_M = (0.2, 0.5)
NEAR_M = 2e-4
"""What the general-purpose solver leaves open; stretches this near the threshold are not compared."""


def track(east: np.ndarray, north: np.ndarray) -> Trajectory:
    return build_trajectory("made/1", 0.1 * np.arange(east.size), np.stack([east, north], axis=1))


def smallest_greatest_error_m(trip: Trajectory, first: int, end: int, degree: int) -> float:
    """Minimise the greatest error by a general-purpose solver: sequential least squares on a bound."""
    t = trip.t_s[first:end] - trip.t_s[first]
    basis = np.polynomial.chebyshev.chebvander(2 * t / max(t[-1], 1e-9) - 1, degree)
    data = trip.position_m[first:end] - trip.position_m[first]
    start = np.linalg.lstsq(basis, data, rcond=None)[0]
    data = data - basis @ start

    def errors(x: np.ndarray) -> np.ndarray:
        return data - basis @ x[:-1].reshape(degree + 1, 2)

    def slope(x: np.ndarray) -> np.ndarray:
        error = errors(x)
        sides = (2.0 * basis[:, :, None] * error[:, None, :]).reshape(t.size, -1)
        return np.hstack([sides, np.ones((t.size, 1))])

    greatest = (data**2).sum(axis=1).max()
    found = minimize(
        lambda x: x[-1],
        np.append(np.zeros(2 * degree + 2), greatest),
        jac=lambda x: np.append(np.zeros(x.size - 1), 1.0),
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda x: x[-1] - (errors(x) ** 2).sum(axis=1), "jac": slope},
        options={"maxiter": 400, "ftol": 1e-12},
    )
    return float(np.sqrt((errors(found.x) ** 2).sum(axis=1).max()))


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_polynomial_of_the_degree_takes_one_message(degree: int) -> None:
    t = 0.1 * np.arange(3000)
    trip = track(
        30.0 * t + 0.01 * t**degree / 10.0 ** (degree - 1), 5.0 - 0.02 * t**degree / 10.0 ** (degree - 1)
    )
    assert clairvoyant(trip, degree, 0.05).starts.tolist() == [0]
    if degree > 1:
        assert clairvoyant(trip, degree - 1, 0.05).starts.size > 1


def test_a_sharp_corner_takes_two_messages_and_the_second_starts_at_it() -> None:
    t = 0.1 * np.arange(400)
    trip = track(20.0 * np.minimum(t, 18.0), 20.0 * np.maximum(t - 18.0, 0.0))
    starts = clairvoyant(trip, 1, 0.2).starts
    assert starts.size == 2
    assert starts[1] == 181


def test_a_parabola_takes_lines_of_the_length_that_chebyshev_gives() -> None:
    """A line misses a t²/2 by a L²/16 over a stretch of length L; times lie on the grid of 1 ms."""
    t = 0.001 * np.arange(20_000)
    trip = build_trajectory("made/1", t, np.stack([0.5 * 2.0 * t**2, 0 * t], axis=1))
    lengths = np.diff(clairvoyant(trip, 1, 0.2).starts) * 0.001
    assert lengths == pytest.approx(np.sqrt(16 * 0.2 / 2.0), abs=0.004)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_each_stretch_holds_and_one_sample_more_does_not(drive: Trajectory, degree: int) -> None:
    """The end of every stretch agrees with a general-purpose solver that knows nothing of the certificate."""
    threshold_m = 0.3
    found = clairvoyant(drive, degree, threshold_m)
    assert found.undecided == 0
    compared = 0
    for first, end in zip(found.starts[:12], found.starts[1:13], strict=False):
        inside = smallest_greatest_error_m(drive, first, end, degree)
        beyond = smallest_greatest_error_m(drive, first, end + 1, degree)
        assert inside < threshold_m + NEAR_M
        assert beyond > threshold_m - NEAR_M
        compared += 1
    assert compared >= 5


def test_decisions_agree_with_a_general_purpose_solver_on_random_tracks() -> None:
    rng = np.random.default_rng(5)
    work, polynomial = np.empty((60, 18)), np.zeros((2, 4))
    compared = 0
    for _ in range(60):
        count, degree = int(rng.integers(5, 60)), int(rng.integers(1, 4))
        trip = track(*np.cumsum(rng.normal(0.0, 0.05, (2, count)), axis=1))
        least = smallest_greatest_error_m(trip, 0, count, degree)
        for threshold_m in (0.5 * least, 0.97 * least, 1.03 * least, 2.0 * least):
            found = decide(trip.t_s, trip.position_m, 0, count, degree, threshold_m, work, polynomial)
            assert found == (HOLDS if threshold_m > least else FAILS)
            compared += 1
    assert compared == 240


def test_more_freedom_never_takes_more_messages(gapped_drive: Trajectory) -> None:
    counts = np.array(
        [[clairvoyant(gapped_drive, d, th).starts.size for th in (0.1, 0.2, 0.3, 0.5)] for d in (1, 2, 3)]
    )
    assert (np.diff(counts, axis=0) <= 0).all()
    assert (np.diff(counts, axis=1) <= 0).all()


def test_every_part_starts_anew(gapped_drive: Trajectory) -> None:
    starts = clairvoyant(gapped_drive, 3, 0.5).starts
    assert set(gapped_drive.segments[:-1]) <= set(starts)


@pytest.mark.parametrize("threshold_m", [0.1, 0.2, 0.5])
def test_the_baseline_never_needs_fewer_than_the_future_known(drive: Trajectory, threshold_m: float) -> None:
    case = make_case(drive, EvaluationSettings(protocol="recorded"))
    policy = EvaluationSettings().policy(threshold_m, keep_alive=False)
    walk = TripRuntime(case.seen, BASELINE_BANK, case.estimator).run(policy)
    assert clairvoyant(drive, 1, threshold_m).least_messages <= walk.updates


@pytest.mark.real
@pytest.mark.parametrize("threshold_m", THRESHOLDS_M)
def test_nor_does_it_on_real_trips(dynamic_trips: dict[str, Trajectory], threshold_m: float) -> None:
    """A model may outlast a gap, at which the reference starts anew."""
    for trip in dynamic_trips.values():
        case = make_case(trip, EvaluationSettings(protocol="recorded"))
        policy = EvaluationSettings().policy(threshold_m, keep_alive=False)
        walk = TripRuntime(case.seen, BASELINE_BANK, case.estimator).run(policy)
        found = clairvoyant(trip, 1, threshold_m)
        assert found.starts.size <= walk.updates + trip.segments.size - 2


@pytest.mark.real
def test_bounds_on_real_trips_meet(data_folder: Path) -> None:
    """Undecided tests are rare enough to leave at most one message open a trip and reference."""
    for trip in read_trips(data_folder / "openacc_zalazone" / "short_setting__handling_part14.csv"):
        for degree in (1, 2, 3):
            found = clairvoyant(trip, degree, 0.2)
            assert found.least_messages <= found.starts.size <= found.least_messages + 1


def test_rows_of_a_trip_and_pooled_rows_are_sums(drive: Trajectory, gapped_drive: Trajectory) -> None:
    settings = EvaluationSettings(THRESHOLDS_M, (), protocol="recorded")
    result = evaluate([drive, gapped_drive], settings)
    rows = [(row.reference, row.threshold_m) for row in result.references if row.trip == "all"]
    degrees = [(f"clairvoyant-{degree}", th) for degree in (1, 2, 3) for th in THRESHOLDS_M]
    assert rows == [*degrees, ("cam", None)]
    for key in rows:
        pooled, *own = (row for row in result.references if (row.reference, row.threshold_m) == key)
        assert pooled.messages == sum(row.messages for row in own)
        assert pooled.rate_hz == pytest.approx(pooled.messages / pooled.duration_s)
        assert len(own) == 2


def test_without_references_there_are_no_rows(drive: Trajectory) -> None:
    settings = EvaluationSettings((0.5,), (), protocol="recorded", references=False)
    assert not evaluate([drive], settings).references


def test_heading_from_positions_is_held_at_standstill() -> None:
    """A standing car without a heading sends once a second, whatever the noise of its positions says."""
    rng = np.random.default_rng(0)
    t = 0.1 * np.arange(600)
    trip = build_trajectory("made/1", t, rng.normal(0.0, 0.001, (t.size, 2)), speed_mps=np.zeros(t.size))
    case: TripCase = make_case(trip, EvaluationSettings(protocol="recorded"))
    cam = count_references(case, ())[-1]
    assert cam.reference == "cam"
    assert cam.rate_hz == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("degree", "threshold_m"), [(0, 0.2), (4, 0.2), (1, 0.0), (1, np.inf)])
def test_what_is_out_of_range_is_refused(drive: Trajectory, degree: int, threshold_m: float) -> None:
    with pytest.raises(ValueError, match="must be"):
        clairvoyant(drive, degree, threshold_m)

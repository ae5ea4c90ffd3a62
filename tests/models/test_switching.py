"""Claims about switching models: the filter, the moments, the path, the state in the stream, refusals."""

from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.members import ReadyBank
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.profile import default_profile
from modelcast.models.switching import MOST_MODES, LinearMode, StochasticHybridSystem
from modelcast.models.switching.hybrid_system import REACH_S
from modelcast.models.switching.mode import advanced
from modelcast.models.switching.moments import mean_tables, second_moments, stationary
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.sensing.sensing import Sensing, sensed_trip
from modelcast.station.sensing.streaming import with_states
from modelcast.station.sensing.velocity import REPORTED
from modelcast.trips.trajectory import Trajectory, build_trajectory

DT_S = 0.1
ROUNDING = 1e-10
"""Products of a few hundred chances round so."""

NOISE = ((0.04, 0.001), (0.001, 0.0004))
CALM = LinearMode(((0.97, 0.1), (0.001, 0.99)), (0.0, 0.001), NOISE)
BRAKING = LinearMode(((0.8, 0.0), (0.0, 0.9)), (-0.5, 0.0), ((0.3, 0.0), (0.0, 0.001)))
TURNING = LinearMode(((0.9, 0.0), (0.0, 0.95)), (0.0, 0.02), ((0.05, -0.002), (-0.002, 0.002)))
CHAIN = ((0.9, 0.06, 0.04), (0.1, 0.9, 0.0), (0.15, 0.05, 0.8))
SYSTEM = StochasticHybridSystem("made", (CALM, BRAKING, TURNING), CHAIN)
HELD = LinearMode(((1.0, 0.0), (0.0, 1.0)), (0.0, 0.0), NOISE)


def drawn(system: StochasticHybridSystem, count: int, seed: int) -> FloatArray:
    """Return acceleration and yaw rate of one path, (T, 2)."""
    rng = np.random.default_rng(seed)
    modes, x, z = system.arrays, np.zeros(2), 0
    out = np.zeros((count, 2))
    for k in range(1, count):
        z = int(rng.choice(len(modes.chain), p=modes.chain[z]))
        x = rng.multivariate_normal(modes.dynamics[z] @ x + modes.offset[z], modes.covariance[z])
        out[k] = x
    return out


def windows_of(x: FloatArray, dt_s: float = DT_S) -> Windows:
    """Return one window of a car at 10 m/s with these rates."""
    samples = np.zeros((1, len(x), 7))
    samples[0, :, 3], samples[0, :, 4:6] = 10.0, x
    return Windows(samples, dt_s=dt_s)


def belief_of(system: StochasticHybridSystem, x: FloatArray, dt_s: float = DT_S) -> FloatArray:
    """Return the chance of each mode after a window, (M,)."""
    first = system.fit(windows_of(x, dt_s))[0, 4:]
    return np.append(first, 1.0 - first.sum())


def filtered(system: StochasticHybridSystem, x: FloatArray) -> FloatArray:
    """Return the same by the textbook: forward in logarithms, densities by scipy."""
    modes = system.arrays
    belief = np.log(stationary(modes.chain))
    with np.errstate(divide="ignore"):
        chain = np.log(modes.chain)
    for before, after in pairwise(x):
        belief = logsumexp(belief[:, None] + chain, axis=0)
        for j in range(len(chain)):
            mean = modes.dynamics[j] @ before + modes.offset[j]
            belief[j] += multivariate_normal(mean, modes.covariance[j]).logpdf(after)
        belief -= logsumexp(belief)
    return np.exp(belief)


def without_memory() -> StochasticHybridSystem:
    """Return a system whose samples depend on the mode alone: a Gaussian hidden Markov model."""
    zero = ((0.0, 0.0), (0.0, 0.0))
    modes = (
        LinearMode(zero, (0.0, 0.0), NOISE),
        LinearMode(zero, (-0.4, 0.1), ((0.2, 0.0), (0.0, 0.01))),
        LinearMode(zero, (0.5, -0.02), ((0.05, -0.002), (-0.002, 0.002))),
    )
    return StochasticHybridSystem("gaussian", modes, CHAIN)


@pytest.mark.parametrize("seed", range(4))
def test_the_filter_is_hmmlearns_at_the_end_of_every_prefix(seed: int) -> None:
    """The last row of `predict_proba` knows no future: of a prefix it is the filter."""
    system = without_memory()
    x, modes = drawn(system, 40, seed), system.arrays
    peer: Any = GaussianHMM(3, covariance_type="full")
    peer.startprob_, peer.transmat_ = stationary(modes.chain), modes.chain
    peer.means_, peer.covars_ = modes.offset, modes.covariance
    for end in range(2, len(x), 3):
        expected = peer.predict_proba(x[1:end])[-1]
        assert belief_of(system, x[:end]) == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_the_filter_is_the_textbooks_for_modes_with_memory(seed: int, count: int) -> None:
    x = drawn(SYSTEM, count, seed)
    assert belief_of(SYSTEM, x) == pytest.approx(filtered(SYSTEM, x), abs=ROUNDING)


def test_a_sample_that_no_mode_explains_leaves_a_belief() -> None:
    x = np.array([[0.0, 0.0], [1e200, 0.0], [1e200, 1e200], [0.0, 0.0]])
    for end in range(1, 5):
        belief = belief_of(SYSTEM, x[:end])
        assert np.isfinite(belief).all()
        assert belief.sum() == pytest.approx(1.0)


def test_at_twice_the_interval_the_filter_takes_two_steps_at_once() -> None:
    modes, twice = SYSTEM.arrays, advanced(SYSTEM.arrays, 2.0)
    assert twice.chain == pytest.approx(modes.chain @ modes.chain)
    for j in range(3):
        a, q = modes.dynamics[j], modes.covariance[j]
        assert twice.dynamics[j] == pytest.approx(a @ a)
        assert twice.offset[j] == pytest.approx(a @ modes.offset[j] + modes.offset[j])
        assert twice.covariance[j] == pytest.approx(a @ q @ a.T + q)
    coarse = StochasticHybridSystem(
        "coarse",
        tuple(
            LinearMode(
                tuple(map(tuple, a.tolist())),
                tuple(b.tolist()),
                tuple(map(tuple, (0.5 * (q + q.T)).tolist())),
            )  # type: ignore[arg-type]
            for a, b, q in zip(twice.dynamics, twice.offset, twice.covariance, strict=True)
        ),
        tuple(tuple(row) for row in twice.chain.tolist()),
        step_s=0.2,
    )
    x = drawn(coarse, 30, 3)
    assert belief_of(SYSTEM, x, 0.2) == pytest.approx(belief_of(coarse, x, 0.2), abs=1e-9)


@pytest.mark.parametrize("steps", [0.2, 0.5, 1.0, 1.3, 2.5])
def test_between_steps_chances_stay_chances_and_modes_stay_stable(steps: float) -> None:
    found = advanced(SYSTEM.arrays, steps)
    assert found.chain.sum(axis=1) == pytest.approx(1.0)
    assert (found.chain >= 0.0).all()
    assert np.abs(np.linalg.eigvals(found.dynamics)).max() <= 1.0
    assert np.linalg.eigvalsh(found.covariance).min() > 0.0


def test_stationary_shares_stay_as_they_are_where_a_chain_alternates_too() -> None:
    shares = stationary(SYSTEM.arrays.chain)
    assert shares @ SYSTEM.arrays.chain == pytest.approx(shares)
    assert stationary(np.array([[0.0, 1.0], [1.0, 0.0]])) == pytest.approx([0.5, 0.5])


def along_paths(start: FloatArray, first: int, steps: int) -> list[tuple[float, FloatArray, FloatArray]]:
    """Chance, mean (K + 1, 2) and covariance ((K + 1) 2, (K + 1) 2) of x along every path of modes."""
    modes, found = SYSTEM.arrays, list[tuple[float, FloatArray, FloatArray]]()
    for path in product(range(3), repeat=steps):
        chance, before = 1.0, first
        mean, spread = [start], np.zeros((2 * (steps + 1), 2 * (steps + 1)))
        for k, z in enumerate(path, start=1):
            chance, before = chance * modes.chain[before, z], z
            mean.append(modes.dynamics[z] @ mean[-1] + modes.offset[z])
            own, last = slice(2 * k, 2 * k + 2), slice(2 * k - 2, 2 * k)
            spread[own, : 2 * k] = modes.dynamics[z] @ spread[last, : 2 * k]
            spread[: 2 * k, own] = spread[own, : 2 * k].T
            spread[own, own] = modes.dynamics[z] @ spread[last, last] @ modes.dynamics[z].T
            spread[own, own] += modes.covariance[z]
        found.append((chance, np.array(mean), spread))
    return found


@pytest.mark.parametrize("first", range(3))
def test_means_are_those_over_all_paths_of_modes(first: int) -> None:
    start, steps = np.array([-1.5, 0.2]), 5
    table = mean_tables(SYSTEM.arrays, steps)
    expected = sum(chance * mean for chance, mean, _ in along_paths(start, first, steps))
    assert table[:, first] @ np.append(1.0, start) == pytest.approx(expected)


def test_second_moments_are_those_over_all_paths_of_modes() -> None:
    """Of what x adds up to by the trapezoid, and of what that adds up to with x linear in between."""
    start, steps = np.array([-1.5, 0.2]), 5
    belief = np.array([[0.5, 0.3, 0.2]])
    held = second_moments(SYSTEM.arrays, belief, start[None], steps=steps, step_s=DT_S)[0, -1]
    t = np.arange(steps + 1) * DT_S
    fine = np.linspace(0.0, t[-1], 100 * steps + 1)
    hats = np.array([np.interp(fine, t, row) for row in np.eye(steps + 1)])
    middle = 0.5 * (hats[:, 1:] + hats[:, :-1]) * np.diff(fine)
    once = middle.sum(axis=1)
    twice = (middle * (fine[-1] - 0.5 * (fine[1:] + fine[:-1]))).sum(axis=1)
    pick = np.concatenate([np.kron(row, np.eye(2)) for row in (np.eye(steps + 1)[-1], once, twice)])
    expected = np.zeros((7, 7))
    for first, share in enumerate(belief[0]):
        for chance, mean, spread in along_paths(start, first, steps):
            y = np.append(1.0, pick @ mean.ravel())
            expected += share * chance * np.outer(y, y)
            expected[1:, 1:] += share * chance * pick @ spread @ pick.T
    assert held == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_a_single_mode_that_holds_everything_is_constant_turn_rate_and_acceleration() -> None:
    one = StochasticHybridSystem("held", (HELD,), ((1.0,),))
    parameters = np.array([[10.0, 3.0, -1.0, 0.3], [0.0, 0.0, 1.0, 0.1], [5.0, 5.0, 0.4, -0.2]])
    horizons_s = np.array([0.0, 0.05, 0.1, 0.77, 3.0, REACH_S])
    other = ConstantTurnRateAcceleration()
    assert one.predict(parameters, horizons_s, dt_s=DT_S) == pytest.approx(
        other.predict(parameters, horizons_s, dt_s=DT_S), abs=1e-9
    )
    assert one.payload_parameters == 0


def test_the_path_integrates_the_mean_and_goes_straight_on_beyond_its_reach() -> None:
    parameters = np.array([[6.0, 12.0, -0.7, 0.15, 0.6, 0.1]])
    t = np.linspace(0.0, REACH_S, 200_001)
    grid = np.arange(len(mean_tables(SYSTEM.arrays, 100))) * DT_S
    mean = np.einsum("kmij,j,m->ki", mean_tables(SYSTEM.arrays, 100), [1.0, -0.7, 0.15], [0.6, 0.1, 0.3])
    along, turn = (np.interp(t, grid, column) for column in mean.T)

    def integral(values: FloatArray) -> FloatArray:
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])

    speed = np.hypot(6.0, 12.0) + integral(along)
    heading = np.arctan2(6.0, 12.0) + integral(turn)
    stops = np.flatnonzero(speed <= 0.0)
    speed[stops[0] if stops.size else len(t) :] = 0.0
    east, north = integral(speed * np.sin(heading)), integral(speed * np.cos(heading))
    for horizon_s in (0.5, 1.234, 4.0, 9.99):
        at = np.searchsorted(t, horizon_s)
        found = SYSTEM.predict(parameters, np.array([horizon_s]), dt_s=DT_S)[0, 0]
        # A step turns at its mean yaw rate: a few millimetres in ten seconds.
        assert found == pytest.approx([east[at], north[at]], abs=0.01)
    later = SYSTEM.predict(parameters, REACH_S + np.array([0.0, 1.0, 3.0]), dt_s=DT_S)[0]
    assert later[2] - later[0] == pytest.approx(3.0 * (later[1] - later[0]))
    assert np.hypot(*(later[1] - later[0])) == pytest.approx(speed[-1], abs=1e-3)


def test_a_car_that_brakes_to_a_stop_stays() -> None:
    parameters = np.array([[3.0, 0.0, -4.0, 0.0, 0.0, 1.0]])
    moved = SYSTEM.predict(parameters, np.array([3.0, 6.0, 20.0]), dt_s=DT_S)[0]
    assert (moved[0] == moved[1]).all()
    assert (moved[0] == moved[2]).all()
    assert 0.0 < moved[0, 0] < 3.0


def test_rounded_chances_that_sum_to_more_than_one_are_shared_out() -> None:
    over = np.array([[10.0, 0.0, -1.0, 0.1, 0.8, 0.4]])
    same = np.array([[10.0, 0.0, -1.0, 0.1, 0.8 / 1.2, 0.4 / 1.2]])
    horizons_s = np.array([0.5, 2.0])
    for found in (SYSTEM.predict, SYSTEM.covariance):
        assert found(over, horizons_s, dt_s=DT_S) == pytest.approx(found(same, horizons_s, dt_s=DT_S))


def test_a_message_carries_the_chances_of_all_modes_but_one_in_equal_steps() -> None:
    layout = SYSTEM.payload_layout
    assert layout.bits == 2 * SYSTEM.belief_bits
    assert layout.quantise(np.array([[0.0, 1.0], [0.49, 2.0]])) == pytest.approx(
        np.array([[0.0, 1.0], [7.0 / 15.0, 1.0]])
    )


def drive(count: int = 120, gap_at: int = 70) -> Trajectory:
    """Return a car that speeds up, brakes and turns, with a gap of a second."""
    x = drawn(SYSTEM, count, 8)
    speed = np.maximum(12.0 + np.cumsum(x[:, 0]) * DT_S, 1.0)
    heading = np.mod(np.cumsum(x[:, 1]) * DT_S, 2.0 * np.pi)
    step = speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1) * DT_S
    t_s = DT_S * np.arange(count)
    t_s[gap_at:] += 1.0
    return build_trajectory(
        "made/1",
        t_s,
        np.cumsum(step, axis=0),
        speed_mps=speed,
        heading_rad=heading,
        acceleration_mps2=x[:, 0],
        yaw_rate_radps=x[:, 1],
    )


def test_state_is_carried_from_the_start_or_the_last_gap_to_every_sample() -> None:
    """The station's belief is that of a filter over all samples of the part, to the last bit."""
    trip, other = drive(), StochasticHybridSystem("other", (TURNING, CALM), ((0.7, 0.3), (0.2, 0.8)))
    bank = Bank((ConstantTurnRateAcceleration(), other, SYSTEM))
    ready = TripRuntime(trip, bank, REPORTED)
    ready.fit_at(np.arange(len(trip)))
    for at in (0, 1, 30, 69, 70, 71, 119):
        first = 0 if at < 70 else 70
        window = Windows(ready.samples[None, first : at + 1], dt_s=trip.dt_s)
        for m, member in enumerate(bank.members):
            own = ready.parameters[at, bank.offsets[m] : bank.offsets[m + 1]]
            assert (own == member.fit(window)[0]).all()
    assert not np.allclose(ready.parameters[69, -2:], ready.parameters[70, -2:])
    assert ready.parameters[70, -2:] == pytest.approx(stationary(SYSTEM.arrays.chain)[:2])


def test_a_bank_without_state_has_the_columns_it_always_had() -> None:
    trip = drive()
    held = sensed_trip(trip, Sensing.of(trip, REPORTED))
    assert with_states(held, ReadyBank.of(Bank((ConstantVelocity(),)), DT_S)) is held
    ready = ReadyBank.of(Bank((ConstantVelocity(), SYSTEM)), DT_S)
    wide = with_states(held, ready)
    assert wide.samples.shape[2] == SAMPLE_COLUMNS + 3
    assert (wide.samples[..., :SAMPLE_COLUMNS] == held.samples).all()
    assert wide.samples[0, : len(trip), SAMPLE_COLUMNS:].sum(axis=1) == pytest.approx(1.0)


def test_state_cannot_begin_where_the_ring_holds_the_newest_samples_only() -> None:
    trip = drive()
    held = sensed_trip(trip, Sensing.of(trip, REPORTED))
    held.taken[0] += 1
    with pytest.raises(ValueError, match="no longer"):
        with_states(held, ReadyBank.of(Bank((SYSTEM,)), DT_S))


@pytest.mark.parametrize("name", ["shs", "hdp-hmm"])
def test_the_shipped_ones_come_back_from_their_text(name: str) -> None:
    found = default_profile().sub_model(name)
    assert isinstance(found, StochasticHybridSystem)
    assert from_plain(to_plain(found)) == found
    assert found.name == name


PLAIN: dict[str, Any] = to_plain(SYSTEM)
MODE: dict[str, Any] = to_plain(CALM)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("transition", [[1.0, 0.0], [0.0, 1.0]], r"\$.transition must be 3 rows of 3 chances"),
        ("transition", [[0.9, 0.1, 0.0], [0.5, 0.5], [0.0, 0.0, 1.0]], "3 rows of 3 chances"),
        ("transition", [[0.9, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], r"transition\[0\].*sum to one"),
        ("transition", [[1.1, -0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], r"transition\[0\]\[0\]"),
        ("transition", [["inf", 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], r"transition\[0\]\[0\]"),
        ("transition", 1.0, "transition"),
        ("modes", [], "a list of 1 to 10 items"),
        ("modes", [MODE] * (MOST_MODES + 1), "a list of 1 to 10 items"),
        ("modes", [{"is": "ConstantVelocity"}] * 3, r"modes\[0\] must be a linear mode"),
        ("step_s", 0.0, "step_s"),
        ("step_s", 0.049, "step_s.*from 0.05 to 1"),
        ("step_s", "inf", "step_s"),
        ("belief_bits", 0, "belief_bits"),
        ("belief_bits", 33, "belief_bits"),
        ("belief_bits", 4.5, "belief_bits"),
        ("label", "a\nb", "label"),
    ],
)
def test_hostile_fields_are_refused_by_name(field: str, value: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        from_plain({**PLAIN, field: value})


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("dynamics", [[1.01, 0.0], [0.0, 0.5]], "eigenvalues are at most 1"),
        ("dynamics", [[0.0, 2.0], [1.0, 0.0]], "eigenvalues are at most 1"),
        ("dynamics", [[0.5, 0.0]], "dynamics"),
        ("dynamics", [[0.5, 1e9], [0.0, 0.5]], r"dynamics\[0\]\[1\]"),
        ("offset", [0.0, 0.0, 0.0], "offset"),
        ("offset", [0.0, "inf"], r"offset\[1\]"),
        ("covariance", [[1.0, 0.1], [0.2, 1.0]], "symmetric and positive definite"),
        ("covariance", [[1.0, 1.0], [1.0, 1.0]], "symmetric and positive definite"),
        ("covariance", [[1.0, 2.0], [2.0, 1.0]], "symmetric and positive definite"),
        ("covariance", [[1.0, 1.0 - 4e-9], [1.0 - 4e-9, 1.0]], "symmetric and positive definite"),
        ("covariance", [[100.0, 0.01 - 4e-11], [0.01 - 4e-11, 1e-6]], "symmetric and positive definite"),
        ("covariance", [[0.0, 0.0], [0.0, 1.0]], "symmetric and positive definite"),
        ("covariance", [[-1.0, 0.0], [0.0, -1.0]], "symmetric and positive definite"),
    ],
)
def test_hostile_modes_are_refused_by_name(field: str, value: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        from_plain({**MODE, field: value}, "$")


def test_lists_are_as_good_as_tuples() -> None:
    modes: Any = [
        LinearMode(*(np.array(getattr(mode, name)).tolist() for name in ("dynamics", "offset", "covariance")))
        for mode in SYSTEM.modes
    ]
    chain: Any = [list(row) for row in CHAIN]
    same = StochasticHybridSystem("made", modes, chain)
    assert same == SYSTEM
    assert hash(same) == hash(SYSTEM)


def test_modes_that_run_away_together_are_refused() -> None:
    """Each is stable; one after the other they grow a hundredfold every two steps."""
    one = LinearMode(((0.5, 20.0), (0.0, 0.5)), (0.0, 0.0), NOISE)
    two = LinearMode(((0.5, 0.0), (20.0, 0.5)), (0.0, 0.0), NOISE)
    with pytest.raises(ValueError, match="run away"):
        StochasticHybridSystem("wild", (one, two), ((0.0, 1.0), (1.0, 0.0)))


@pytest.mark.parametrize("size", [3.0, 30.0, 1000.0])
def test_modes_whose_mean_dies_and_whose_square_runs_away_are_refused(size: float) -> None:
    """The mean of each pair of modes is 0; the squares grow by ``size²/2`` with every step."""
    modes = tuple(
        LinearMode(dynamics, (0.0, 0.0), NOISE)
        for one in (-size, size)
        for dynamics in (((0.0, one), (0.0, 0.0)), ((0.0, 0.0), (one, 0.0)))
    )
    even = ((0.25,) * 4,) * 4
    with pytest.raises(ValueError, match="run away"):
        StochasticHybridSystem("wild", modes, even)


def test_modes_whose_squares_die_are_taken_and_spread_finitely() -> None:
    modes = tuple(
        LinearMode(dynamics, (0.0, 0.0), NOISE)
        for one in (-1.4, 1.4)
        for dynamics in (((0.0, one), (0.0, 0.0)), ((0.0, 0.0), (one, 0.0)))
    )
    calm = StochasticHybridSystem("calm", modes, ((0.25,) * 4,) * 4)
    parameters = np.array([[10.0, 0.0, 1.0, 0.1, 0.25, 0.25, 0.25]])
    spread = calm.covariance(parameters, np.array([1.0, REACH_S]), dt_s=DT_S)
    assert np.isfinite(spread).all()
    assert np.abs(spread).max() < 1e6


@pytest.mark.parametrize("dynamics", [((1.0, 0.0), (0.0, 1.0)), ((0.99, 0.0), (0.0, 0.99))])
@pytest.mark.parametrize("step_s", [0.05, 0.1, 1.0])
def test_the_bound_of_squares_refuses_no_single_mode_of_bounded_mean(dynamics: Any, step_s: float) -> None:
    largest = 1e4 / (REACH_S / step_s + 1.0)
    wide = LinearMode(dynamics, (min(largest, 100.0), -min(largest, 100.0)), ((1e4, 0.0), (0.0, 1e4)))
    assert StochasticHybridSystem("wide", (wide,), ((1.0,),), step_s=step_s).modes == (wide,)


def test_a_mean_beyond_its_bound_is_refused_where_squares_are_within_theirs() -> None:
    steady = LinearMode(((1.0, 0.0), (0.0, 1.0)), (100.0, 0.0), NOISE)
    with pytest.raises(ValueError, match="run away"):
        StochasticHybridSystem("steady", (steady,), ((1.0,),), step_s=0.05)


@pytest.mark.parametrize("step_s", [0.05, 0.1, 1.0])
def test_intervals_from_a_thousandth_of_a_step_to_the_reach_have_a_filter_and_no_others(
    step_s: float,
) -> None:
    system = StochasticHybridSystem("made", SYSTEM.modes, CHAIN, step_s=step_s)
    x = drawn(SYSTEM, 5, 0)
    for dt_s in (0.001 * step_s, REACH_S):
        assert belief_of(system, x, dt_s).sum() == pytest.approx(1.0)
    for dt_s in (0.0009 * step_s, 1e-12, REACH_S + 0.1, 1e9):
        with pytest.raises(ValueError, match=f"made: dt_s must be from {0.001 * step_s:g} to 10 s, got"):
            belief_of(system, x, dt_s)

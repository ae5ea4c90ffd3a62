"""Claims about streams in which leaders brake hard."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity
from modelcast.world.scenario import braking_kernels as kernels
from modelcast.world.scenario import following_kernels as following
from modelcast.world.scenario import highway_kernels as rows
from modelcast.world.scenario.base import STEP_S, FleetFrame
from modelcast.world.scenario.braking import BrakingState, BrakingStreams
from modelcast.world.scenario.drivers import STREAM, UNIFORM

TRAPEZOID_MPS = 0.05
"""A step's mean velocity against that of its ends: jerk dt² / 12 with jerks up to 20 m/s³."""

HARSH = BrakingStreams(
    1500.0,
    80.0,
    brakings_per_minute=60.0,
    stop_ratio=0.6,
    reaction_s=(1.4, 2.0),
    drivers=replace(STREAM, headway_s=(0.5, 0.8)),
)
"""So close and so slow to react that some drive into others."""


def run(streams: BrakingStreams, duration_s: float, seed: int = 1) -> list[BrakingState]:
    states = [streams.init(np.random.default_rng(seed))]
    for _ in range(round(duration_s / STEP_S) - 1):
        states.append(streams.step(states[-1]))
    return states


def row(states: list[BrakingState], number: int) -> FloatArray:
    return np.array([state.road.numbers[number] for state in states])


def whole_row(states: list[BrakingState], number: int) -> IntArray:
    return np.array([state.road.integers[number] for state in states])


def column(frames: list[FleetFrame], name: str) -> FloatArray:
    return np.array([getattr(frame, name) for frame in frames])


def leaders(streams: BrakingStreams, states: list[BrakingState]) -> IntArray:
    """The vehicle ahead of each in its lane, by the first state, (V,); nobody changes lanes."""
    place, lane = states[0].road.place_m, states[0].road.lane
    back = np.arange(streams.slots) >= (streams.slots + 1) // 2
    found = np.full(streams.slots, -1, dtype=np.int64)
    for one in np.unique(lane):
        for way in (False, True):
            who = np.flatnonzero((lane == one) & (back == way))
            who = who[np.argsort(place[who])]
            found[who] = np.roll(who, -1)
    return found


def gaps(streams: BrakingStreams, states: list[BrakingState], ahead: IntArray) -> FloatArray:
    """From front to rear bumper of the vehicle ahead, (T, V): places apart at t = 0, ways driven since."""
    way = row(states, kernels.WAY)
    length = states[0].road.drivers[following.LENGTH]
    place = states[0].road.place_m
    apart = (place[ahead] - place) % streams.length_m
    apart[ahead == np.arange(ahead.size)] = streams.length_m
    driven = way - way[0]
    return apart + driven[:, ahead] - driven - 0.5 * (length + length[ahead])


def touched(states: list[BrakingState]) -> BoolArray:
    """In which steps a vehicle was held back by the one it drives into, (T - 1, V): its way falls short."""
    way, speed, pedal = row(states, kernels.WAY), row(states, rows.V), row(states, rows.A)
    due = STEP_S * (speed[:-1] + STEP_S * (2.0 * pedal[:-1] + pedal[1:]) / 6.0)
    stops = speed[1:] == 0.0
    return (np.abs(np.diff(way, axis=0) - due) > 1e-6) & ~stops


@pytest.fixture(scope="module", name="harsh")
def _harsh() -> list[BrakingState]:
    return run(HARSH, 120.0)


@pytest.fixture(scope="module", name="states")
def _states() -> list[BrakingState]:
    return run(BrakingStreams(brakings_per_minute=30.0), 240.0)


def test_nobody_brakes_or_jerks_beyond_the_bounds(
    harsh: list[BrakingState], states: list[BrakingState]
) -> None:
    """9 m/s² of a dry road and 20 m/s³, also of who drives into somebody."""
    for found in (harsh, states):
        pedal = row(found, rows.A)
        assert -9.0 <= pedal.min() < -8.0
        before_contact = ~touched(found) & (whole_row(found, kernels.TOUCHES)[1:] == 0)
        jerk = np.diff(pedal, axis=0)[before_contact & (row(found, rows.V)[1:] > 0.0)] / STEP_S
        assert -20.0 - 1e-9 <= jerk.min() < -19.0
        assert jerk.max() <= 20.0 + 1e-9


def test_brakings_occur_as_they_were_drawn(states: list[BrakingState]) -> None:
    """Who has nobody to mind reaches the drawn deceleration to the digit, and then the drawn speed."""
    phase, pedal, speed = whole_row(states, kernels.PHASE), row(states, rows.A), row(states, rows.V)
    drawn, ends, hold = (row(states, k) for k in (kernels.BRAKE_MPS2, kernels.BRAKE_TO_MPS, kernels.HOLD_S))
    begins = np.argwhere((phase[1:] > 0) & (phase[:-1] == 0))
    checked = 0
    for n, i in begins:
        after = phase[n + 1 :, i]
        over = np.flatnonzero(after == 0)
        if not over.size:
            continue
        end = n + 1 + over[0]
        assert 3.92 <= drawn[n + 1, i] <= 8.83
        assert whole_row(states, kernels.LEADS)[n, i] == 1
        assert speed[n, i] >= 8.0
        window = pedal[n : end + 1, i]
        if window.min() < -drawn[n + 1, i] - 1e-9 or (phase[n : end + 1, i] == kernels.HOLDS).sum() < 10:
            continue  # it had to brake harder for somebody ahead
        assert window.min() == pytest.approx(-drawn[n + 1, i], abs=1e-9)
        held = speed[n : end + 1, i][phase[n : end + 1, i] == kernels.HOLDS]
        assert held[8] == pytest.approx(ends[n + 1, i], abs=0.3)
        assert 1.0 - STEP_S <= hold[n + 1, i] <= 4.0
        checked += 1
    assert checked >= 0.7 * len(begins)
    assert len(begins) > 70


def test_brakings_come_at_the_asked_rate(states: list[BrakingState]) -> None:
    """A Poisson process of 30 a minute in 4 minutes: 120, give or take four standard deviations."""
    phase = whole_row(states, kernels.PHASE)
    begun = ((phase[1:] > 0) & (phase[:-1] == 0)).sum()
    assert states[-1].brakings == pytest.approx(begun, abs=1)  # one may end and begin between two frames
    assert abs(begun - 120) < 4.0 * np.sqrt(120.0)
    ended = ends_of(states)
    assert 0.1 < np.mean(ended == 0.0) < 0.5


def ends_of(states: list[BrakingState]) -> FloatArray:
    """The speeds that the brakings were drawn to end at."""
    phase, ends = whole_row(states, kernels.PHASE), row(states, kernels.BRAKE_TO_MPS)
    return ends[1:][(phase[1:] > 0) & (phase[:-1] == 0)]


def test_vehicles_never_overlap_also_where_they_touch(
    harsh: list[BrakingState], states: list[BrakingState]
) -> None:
    for streams, found in ((HARSH, harsh), (BrakingStreams(brakings_per_minute=30.0), states)):
        assert gaps(streams, found, leaders(streams, found)).min() >= -1e-6


def test_contacts_are_counted_and_shown_and_the_follower_stays_behind(harsh: list[BrakingState]) -> None:
    ahead = leaders(HARSH, harsh)
    gap, shown = gaps(HARSH, harsh, ahead), whole_row(harsh, kernels.TOUCHES)
    held = touched(harsh)
    new = (shown[1:] == 1) & (shown[:-1] == 0)
    assert harsh[-1].contacts == new.sum() > 5
    speed = row(harsh, rows.V)
    assert (np.abs(gap[1:][new]) < 1e-6).all()
    assert (speed[1:] - speed[1:][:, ahead])[held].max() <= 1e-9
    assert (shown[1:][held] == 1).all()


def test_near_collisions_are_the_times_to_collision_under_one_and_a_half_seconds(
    states: list[BrakingState],
) -> None:
    streams = BrakingStreams(brakings_per_minute=30.0)
    ahead = leaders(streams, states)
    gap, speed = gaps(streams, states, ahead), row(states, rows.V)
    closing = speed - speed[:, ahead]
    near = (closing > 1.0) & (gap < 1.5 * closing)
    rises = (near[1:] & ~near[:-1]).sum()
    assert rises > 5
    assert states[-1].near_collisions == pytest.approx(rises, abs=1 + states[-1].contacts)


def test_without_brakings_nobody_comes_close() -> None:
    for density, lanes in ((60.0, 3), (300.0, 5)):
        last = run(BrakingStreams(1500.0, density, lanes=lanes, brakings_per_minute=0.0), 120.0)[-1]
        assert (last.brakings, last.contacts, last.near_collisions) == (0, 0, 0)


@pytest.mark.parametrize(("pedal", "sees_s"), [(0.0, 1.2), (-0.9, 1.2), (-1.1, 0.7)])
def test_what_a_driver_notices_is_carried_on_at_the_acceleration_seen(pedal: float, sees_s: float) -> None:
    """A leader that brakes evenly is known exactly; one that began since is not; who brakes is alert."""
    steps, now, dt = 16, 3, STEP_S
    ago = (now - np.arange(steps)) % steps
    age = np.arange(steps) * dt
    numbers = np.zeros((kernels.COLUMNS, 2))
    integers = np.zeros((kernels.INTEGERS, 2), dtype=np.int64)
    integers[kernels.DELAY_STEPS, 0] = 12
    numbers[rows.A, 0] = pedal
    numbers[kernels.WAY, 1] = 100.0
    history = np.zeros((3, steps, 2))
    stream = kernels.Stream(
        numbers, integers, np.arange(2), history, np.zeros(kernels.COUNTS, dtype=np.int64)
    )
    history[0, ago, 1] = 100.0 - (20.0 * age + 0.5 * 3.0 * age**2)
    history[1, ago, 1], history[2, ago, 1] = 20.0 + 3.0 * age, -3.0
    assert kernels.noticed(stream, 0, 1, now, dt) == pytest.approx((0.0, 20.0, -3.0), abs=1e-9)
    begun = age <= 0.9  # it braked from then on, and drove steadily before
    history[0, ago, 1] = np.where(begun, history[0, ago, 1], 100.0 - 19.215 - 22.7 * (age - 0.9))
    history[1, ago, 1] = np.where(begun, 20.0 + 3.0 * age, 22.7)
    history[2, ago, 1] = np.where(begun, -3.0, 0.0)
    ahead, speed, acceleration = kernels.noticed(stream, 0, 1, now, dt)
    if sees_s > 0.9:
        assert (ahead, speed, acceleration) == pytest.approx((0.5 * 3.0 * 0.9**2, 22.7, 0.0), abs=1e-9)
    else:
        assert (ahead, speed, acceleration) == pytest.approx((0.0, 20.0, -3.0), abs=1e-9)
    history[1, ago, 1], history[2, ago, 1] = 1.0, -4.0  # stands after 0.25 s, 0.125 m on
    history[0, ago, 1] = 100.0
    ahead, speed, acceleration = kernels.noticed(stream, 0, 1, now, dt)
    assert (ahead, speed, acceleration) == pytest.approx((0.125, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("reaction_s", [0.5, 1.2])
def test_a_follower_begins_to_brake_a_reaction_time_after_its_leader(reaction_s: float) -> None:
    """Without errors of perception its pedal does not move before, and moves at once then."""
    calm = replace(UNIFORM, desired_speed_mps=25.0)
    streams = BrakingStreams(
        4000.0, 2.0, lanes=1, both_directions=False, reaction_s=(reaction_s, reaction_s), stop_ratio=1.0,
        drivers=calm, brakings_per_minute=6.0, warm_up_s=120.0,
    )  # fmt: skip
    states = run(streams, 60.0)
    ahead = leaders(streams, states)
    phase, pedal = whole_row(states, kernels.PHASE), row(states, rows.A)
    n, leader = np.argwhere((phase[1:] == kernels.PRESSES) & (phase[:-1] == 0))[0]
    follower = int(np.flatnonzero(ahead == leader)[0])
    falls = np.flatnonzero(np.diff(pedal[n:, follower]) < -0.02)[0]
    assert falls * STEP_S == pytest.approx(reaction_s + STEP_S, abs=STEP_S + 1e-9)


def test_columns_are_derivatives_of_each_other(states: list[BrakingState]) -> None:
    """But for steps in which somebody is held back by a contact; a stop ends within its step."""
    streams = BrakingStreams(brakings_per_minute=30.0)
    frames = [streams.frame(state) for state in states]
    identity = column(frames, "vehicle_id")
    same = (identity[1:] == identity[:-1]) & (whole_row(states, kernels.TOUCHES)[1:] == 0)
    velocity = heading_to_velocity(column(frames, "speed_mps"), column(frames, "heading_rad"))
    moved = np.diff(column(frames, "position_m"), axis=0) / STEP_S
    assert np.abs(moved - 0.5 * (velocity[1:] + velocity[:-1]))[same].max() < TRAPEZOID_MPS
    mean = 0.5 * (column(frames, "acceleration_mps2")[1:] + column(frames, "acceleration_mps2")[:-1])
    change = np.diff(column(frames, "speed_mps"), axis=0)
    stops = row(states, rows.V)[1:] == 0.0
    assert np.abs(change - mean * STEP_S)[same & ~stops].max() < 0.005
    assert np.abs(change - mean * STEP_S)[same & stops].max() < TRAPEZOID_MPS


def test_one_seed_gives_the_same_bytes_and_another_seed_other_brakings() -> None:
    streams = BrakingStreams(1000.0, 40.0, brakings_per_minute=60.0, warm_up_s=2.0)
    first, again, other = run(streams, 20.0, 3), run(streams, 20.0, 3), run(streams, 20.0, 4)
    assert first[-1].road.numbers.tobytes() == again[-1].road.numbers.tobytes()
    assert first[-1].road.numbers.tobytes() != other[-1].road.numbers.tobytes()


def test_streams_keep_their_time_gaps_and_more_room_between_them() -> None:
    streams = BrakingStreams(3000.0, 20.0, lanes=1, both_directions=False, warm_up_s=0.0, vehicles=10)
    states = run(streams, 0.1)
    gap = gaps(streams, states, leaders(streams, states))[0]
    speed = states[0].road.numbers[rows.V]
    leads = states[0].road.integers[kernels.LEADS] == 1
    assert leads.sum() == 6
    headway = (gap - STREAM.gap_m) / speed
    assert (headway[~leads] >= 0.8 - 1e-9).all()
    assert (headway[~leads] <= 1.6 + 1e-9).all()
    assert headway[leads].min() > 1.6


CUTTING = BrakingStreams(brakings_per_minute=0.0, cut_ins_per_minute=30.0)


@pytest.fixture(scope="module", name="cut")
def _cut() -> list[BrakingState]:
    return run(CUTTING, 180.0)


def cut_in_starts(states: list[BrakingState]) -> IntArray:
    """Step before, and vehicle, of every cut-in, (N, 2)."""
    lane = whole_row(states, rows.LANE)
    return np.argwhere(lane[1:] != lane[:-1])


def test_cut_ins_come_at_the_asked_rate_and_with_the_asked_time_gaps(cut: list[BrakingState]) -> None:
    """30 a minute in 3 minutes: 90, give or take four standard deviations; gaps of 0.3 to 1 s, within 0.1."""
    starts = cut_in_starts(cut)
    assert cut[-1].cut_ins == len(starts)
    assert abs(len(starts) + cut[-1].waiting_s.size - 90) < 4.0 * np.sqrt(90.0)
    half = 0.5 * cut[0].road.drivers[following.LENGTH]
    back = np.arange(CUTTING.slots) >= (CUTTING.slots + 1) // 2
    gaps_s: list[float] = []
    for n, i in starts:
        place, lane = cut[n].road.place_m, cut[n].road.lane
        new = cut[n + 1].road.lane[i]
        assert abs(new - lane[i]) == 1
        there = np.flatnonzero((lane == new) & (back == back[i]))
        behind = (place[i] - place[there]) % CUTTING.length_m
        follower = there[np.argmin(behind)]
        gap_m = behind.min() - half[i] - half[follower]
        gaps_s.append(gap_m / cut[n].road.numbers[rows.V, follower])
    assert 0.2 <= min(gaps_s) < 0.45
    assert 0.85 < max(gaps_s) <= 1.1
    assert np.mean(gaps_s) == pytest.approx(0.65, abs=0.08)


def test_who_cuts_in_moves_smoothly_and_then_brakes_lightly(cut: list[BrakingState]) -> None:
    """The quintic over 3 s: 5.77 w / T² = 2.2 m/s² across; then 1 to 2.5 m/s² and 2 to 5 m/s slower."""
    frames = [CUTTING.frame(state) for state in cut]
    across = column(frames, "speed_mps") * column(frames, "yaw_rate_radps")
    assert 1.8 < np.abs(across).max() < 2.7
    assert np.abs(np.diff(across, axis=0)).max() / STEP_S < 9.0  # jerk 60 w / T³ = 7.8 m/s³
    phase, drawn = whole_row(cut, kernels.PHASE), row(cut, kernels.BRAKE_MPS2)
    begins = np.argwhere((phase[1:] > 0) & (phase[:-1] == 0))
    for n, i in begins:
        assert 1.0 <= drawn[n + 1, i] <= 2.5
        assert 2.0 - 0.3 <= row(cut, rows.V)[n, i] - row(cut, kernels.BRAKE_TO_MPS)[n + 1, i] <= 5.0
        recent = cut_in_starts(cut)
        assert ((recent[:, 1] == i) & (recent[:, 0] < n) & (recent[:, 0] > n - 30)).any()
    assert len(begins) >= 0.9 * (cut[-1].cut_ins - 3)


def test_nobody_is_driven_into_by_a_cut_in(cut: list[BrakingState]) -> None:
    assert cut[-1].contacts == 0
    for state in cut[::5]:
        frame = CUTTING.frame(state)
        apart = np.abs(frame.position_m[:, None] - frame.position_m[None])
        reach = 0.5 * (frame.length_m[:, None] + frame.length_m[None])
        touching = (apart[..., 0] < reach) & (apart[..., 1] < 1.8)
        assert touching.sum() == len(frame), "each vehicle touches itself only"


def test_who_is_cut_in_on_notices_a_reaction_time_later() -> None:
    """With equal drivers, nothing but the newcomer makes a follower brake, and not before it noticed."""
    calm = replace(UNIFORM, desired_speed_mps=25.0, desired_speed_spread_ratio=0.05, headway_s=(1.6, 1.6))
    streams = BrakingStreams(
        2000.0, 30.0, lanes=2, both_directions=False, reaction_s=(1.2, 1.2), brakings_per_minute=0.0,
        cut_ins_per_minute=30.0, cut_in_gap_s=(0.3, 0.6), drivers=calm, warm_up_s=60.0, vehicles=4,
    )  # fmt: skip
    states = run(streams, 60.0)
    pedal, lane = row(states, rows.A), whole_row(states, rows.LANE)
    n, i = cut_in_starts(states)[0]
    place = states[n].road.place_m
    there = np.flatnonzero(lane[n] == lane[n + 1, i])
    follower = there[np.argmin((place[i] - place[there]) % 2000.0)]
    falls = np.flatnonzero(np.diff(pedal[n:, follower]) < -0.1)[0]
    assert falls * STEP_S == pytest.approx(1.2, abs=2.5 * STEP_S)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"deceleration_mps2": (8.0, 4.0)}, "deceleration_mps2"),
        ({"deceleration_mps2": (4.0, 12.0)}, r"1\.0\.\.9\.0"),
        ({"reaction_s": (-0.1, 1.0)}, "reaction_s"),
        ({"hold_s": (2.0, 1.0)}, "hold_s"),
        ({"vehicles": 0}, "vehicles"),
        ({"brakings_per_minute": -1.0}, "brakings_per_minute"),
        ({"stop_ratio": 1.5}, "stop_ratio"),
        ({"cut_ins_per_minute": float("nan")}, "cut_ins_per_minute"),
        ({"cut_ins_per_minute": 1.0, "lanes": 1}, "at least 2 lanes"),
        ({"cut_in_gap_s": (0.0, 1.0)}, "cut_in_gap_s"),
        ({"cut_in_mps2": (2.0, 1.0)}, "cut_in_mps2"),
        ({"lane_change_s": 0.0}, "lane_change_s"),
        ({"length_m": 0.0}, "length_m"),
    ],
)
def test_impossible_streams_are_refused(change: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        BrakingStreams(**change)  # type: ignore[arg-type]


def test_more_vehicles_than_room_are_refused() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        BrakingStreams(1000.0, 400.0).init(np.random.default_rng(0))

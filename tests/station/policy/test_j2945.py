"""Claims about the rules of SAE J2945/1: every one against a table worked by hand."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.station.policy import j2945_kernels as k
from modelcast.station.policy.base import Air, Decisions, Motion, TransmitInputs
from modelcast.station.policy.j2945 import (
    J2945,
    Cause,
    J2945State,
    max_inter_transmit_time,
    transmit_probability,
)
from modelcast.station.policy.j2945_parameters import (
    J2945Parameters,
    j2945_relaxed_parameters,
    j3161_parameters,
)
from modelcast.station.policy.neighbours import Neighbours, neighbour_tables

STANDARD = J2945Parameters()
C = STANDARD.constants()

ROUNDING = 1e-9
"""Of times around ten seconds and ratios of order one, in 64-bit floats."""

PRINTED = 5e-4
"""The tables below print three decimals."""


def row_at(**columns: float) -> FloatArray:
    """State of a vehicle long under way, with nothing due, but for the columns given."""
    row = np.empty(k.STATE_COLUMNS)
    k.start(row, 0.0, 0.0, C)
    row[[k.LAST_S, k.NEXT_S, k.CONTROL_S, k.COUNT_S, k.SURVEY_S]] = 9.95, 10.05, 1e9, 1e9, 1e9
    for name, value in columns.items():
        row[getattr(k, name.upper())] = value
    return row


def test_every_constant_has_its_place_in_the_compiled_rules() -> None:
    assert [getattr(k, field.name.upper()) for field in fields(STANDARD)] == list(range(C.size))
    for field in fields(STANDARD):
        assert C[getattr(k, field.name.upper())] == float(getattr(STANDARD, field.name))


@pytest.mark.parametrize(
    ("weight", "smoothed"),
    # 40 remotes from the start: N_s := w·40 + (1-w)·N_s.
    # w = 0.05: 2; 2 + 0.95·2 = 3.9; 2 + 0.95·3.9 = 5.705.  w = 0.5: 20; 20 + 10 = 30; 20 + 15 = 35.
    [(0.05, [2.0, 3.9, 5.705]), (0.5, [20.0, 30.0, 35.0])],
)
def test_density_is_smoothed_with_either_weight(weight: float, smoothed: list[float]) -> None:
    c = J2945Parameters(density_weight=weight).constants()
    row = row_at(neighbours=40.0)
    for expected in smoothed:
        k.control(row, 10.0, 0.0, 0.0, 0.5, c)
        assert row[k.DENSITY] == pytest.approx(expected, rel=ROUNDING)


def test_the_longest_time_between_messages_follows_the_density() -> None:
    """100 ms up to B = 25; then 4·N_s ms: 26 -> 104, 50 -> 200, 149 -> 596; 600 ms from 6B = 150 on."""
    density = np.array([0.0, 25.0, 26.0, 50.0, 149.0, 150.0, 500.0])
    expected = [0.1, 0.1, 0.104, 0.2, 0.596, 0.6, 0.6]
    assert max_inter_transmit_time(density) == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize(
    ("squared", "error_m", "probability"),
    [
        # 1 - exp(-75·(e - 0.2)²).  (0.05)² = 0.0025: exp(-0.1875) = 0.829.  (0.11)² = 0.0121: exp(-0.9075)
        # = 0.4035.  (0.24)² = 0.0576: exp(-4.32) = 0.0133.
        (True, 0.0, 0.0),
        (True, 0.2, 0.0),
        (True, 0.25, 0.171),
        (True, 0.31, 0.5965),
        (True, 0.44, 0.9867),
        (True, 0.5, 1.0),
        (True, 7.0, 1.0),
        (True, np.inf, 1.0),
        (True, np.nan, 0.0),
        # 1 - exp(-75·(e - 0.2)).  0.01: exp(-0.75) = 0.4724.  0.11: exp(-8.25) = 0.00026.
        (False, 0.2, 0.0),
        (False, 0.21, 0.5276),
        (False, 0.31, 0.9997),
        (False, 0.5, 1.0),
    ],
)
def test_the_transmit_probability_grows_with_the_tracking_error(
    squared: bool, error_m: float, probability: float
) -> None:
    parameters = J2945Parameters(squared_exponent=squared)
    assert transmit_probability(np.array([error_m]), parameters)[0] == pytest.approx(probability, abs=PRINTED)


def test_the_probability_at_the_errors_printed_by_camp() -> None:
    assert transmit_probability(np.array([0.31, 0.44])).round(2).tolist() == [0.6, 0.99]


@pytest.mark.parametrize(
    ("next_s", "longest_s", "error", "rescheduled_s", "cause"),
    # Now 10.000, last message at 9.950. A longest time L asks for 9.950 + L, a tracking error for 10.000;
    # either only moves what is scheduled 25 ms or more after that.
    [
        (10.350, 0.4, (0.10, 0.0), 10.350, Cause.TIME),  # p = 0: not even U = 0 sends
        (10.350, 0.4, (0.31, 0.59), 10.000, Cause.DYNAMICS),  # U < 0.5965
        (10.350, 0.4, (0.31, 0.60), 10.350, Cause.TIME),  # U above it
        (10.350, 0.4, (0.50, 0.9999), 10.000, Cause.DYNAMICS),  # p = 1
        (10.025, 0.4, (0.50, 0.0), 10.000, Cause.DYNAMICS),  # exactly 25 ms ahead
        (10.024, 0.4, (0.50, 0.0), 10.024, Cause.TIME),  # 24 ms ahead: it is on its way
        (10.350, 0.376, (0.0, 0.5), 10.350, Cause.TIME),  # wanted 10.326: 24 ms are not worth it
        (10.350, 0.375, (0.0, 0.5), 10.325, Cause.TIME),  # wanted 10.325: 25 ms are
        (10.350, 0.1, (0.0, 0.5), 10.050, Cause.TIME),
        (10.350, 0.6, (0.0, 0.5), 10.350, Cause.TIME),  # never later
        (10.350, 0.1, (0.5, 0.5), 10.000, Cause.DYNAMICS),  # both: the error wins
    ],
)
def test_rate_control_brings_messages_forward_by_the_threshold_or_not_at_all(
    next_s: float, longest_s: float, error: tuple[float, float], rescheduled_s: float, cause: Cause
) -> None:
    c = J2945Parameters(min_inter_transmit_time_s=longest_s, max_inter_transmit_time_s=longest_s).constants()
    row = row_at(next_s=next_s)
    error_m, uniform = error
    k.control(row, 10.0, error_m, 0.0, uniform, c)
    assert row[k.NEXT_S] == pytest.approx(rescheduled_s, abs=ROUNDING)
    assert row[k.CAUSE] == cause


def test_a_message_wanted_in_the_past_is_scheduled_now() -> None:
    row = row_at(last_s=9.7, next_s=10.3)
    k.control(row, 10.0, 0.0, 0.0, 0.5, C)
    assert row[k.NEXT_S] == pytest.approx(10.0)


def test_a_critical_event_sends_at_once_and_then_every_100_ms() -> None:
    """Asked every 20 ms; last message at 9.95, next at 10.35; event from 10.00 to 10.24."""
    row = row_at(inter_transmit_time_s=0.4, next_s=10.35, channel_quality=0.0)
    sent = []
    for now in np.arange(10.0, 11.0, 0.02).round(2):
        event = bool(now < 10.25)
        cause, at_s, power, _ = k.step(
            row, now, now + 0.02, 0.0, 0.9, 0.0, np.nan, event, np.array([0.5, 0.5, 0.5]), C
        )
        if cause:
            sent.append((Cause(cause).name, round(at_s, 3), power))
    # 10.00, 10.10, 10.20 at full power; then the timer from the last one: 10.20 + 0.4, 15 + (20 - 15)/2 dBm.
    assert sent == [
        ("CRITICAL", 10.0, 20.0),
        ("CRITICAL", 10.1, 20.0),
        ("CRITICAL", 10.2, 20.0),
        ("TIME", 10.6, 17.5),
    ]


def test_braking_beyond_0_4_g_antilock_and_traction_loss_are_critical() -> None:
    acceleration = np.array([-3.92, -3.93, 0.0])  # 0.4 g = 3.9227 m/s²
    assert STANDARD.is_critical(acceleration, antilock=False, traction_loss=False).tolist() == [
        False,
        True,
        False,
    ]
    assert STANDARD.is_critical(acceleration, antilock=np.array([True, False, False]), traction_loss=False)[0]
    assert STANDARD.is_critical(acceleration, antilock=False, traction_loss=True).all()


@pytest.mark.parametrize(
    ("weight", "ratios", "quality"),
    [
        # As it is, capped at 0.3; nobody to count gives 0.
        (1.0, [0.1, 0.8, np.nan, 0.2], [0.1, 0.3, 0.0, 0.2]),
        # 0.9·before + 0.1·new, the new one capped too: 0.02; 0.018 + 0.03 = 0.048; 0.0432.
        (0.1, [0.2, 0.9, 0.0], [0.02, 0.048, 0.0432]),
    ],
)
def test_channel_quality_is_the_capped_mean_ratio_smoothed_or_not(
    weight: float, ratios: list[float], quality: list[float]
) -> None:
    c = J2945Parameters(channel_quality_weight=weight).constants()
    row = row_at()
    for ratio, expected in zip(ratios, quality, strict=True):
        k.survey(row, 10.0, ratio, c)
        assert row[k.CHANNEL_QUALITY] == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize(
    ("longest", "uniforms", "believed"),
    # Lost where U < 0.3; after so many losses in a row the next message counts as received.
    [
        (3, [0.1, 0.2, 0.0, 0.1, 0.1, 0.9], [False, False, False, True, False, True]),
        (3, [0.1, 0.1, 0.5, 0.1, 0.1, 0.1, 0.1], [False, False, True, False, False, False, True]),
        (0, [0.1, 0.1, 0.9], [True, True, True]),
        (1, [0.1, 0.1, 0.3], [False, True, True]),
    ],
)
def test_no_more_than_three_messages_in_a_row_are_believed_lost(
    longest: int, uniforms: list[float], believed: list[bool]
) -> None:
    c = J2945Parameters(max_successive_failures=longest).constants()
    row = row_at(channel_quality=0.3)
    assert [k.assume_received(row, uniform, c) for uniform in uniforms] == believed


def test_power_falls_from_20_to_10_dbm_between_half_and_four_fifths_busy() -> None:
    """10 dB over 0.3: 1 dB for 0.03. At 0.56, 20 - 2 dB; at 0.65, 15 dBm."""
    busy = [0.0, 0.5, 0.53, 0.56, 0.65, 0.8, 1.0]
    assert [k.power_for(ratio, C) for ratio in busy] == pytest.approx([20, 20, 19, 18, 15, 10, 10])


def test_base_power_halves_its_distance_to_what_is_called_for() -> None:
    """From 15 dBm. Calm: 17.5, 18.75. Busy, f = 10: 14.375. By error: 20, base unchanged. Then 12.1875."""
    row = row_at()
    powers = []
    for busy, cause in [(0.0, 1), (0.0, 1), (0.9, 1), (0.9, 2), (0.9, 1)]:
        row[k.BUSY_RATIO], row[k.CAUSE] = busy, cause
        powers.append(k.sent(row, 10.0, 0.5, 0.5, C)[0])
    assert powers == pytest.approx([17.5, 18.75, 14.375, 20.0, 12.1875])


def test_the_busy_ratio_is_smoothed_by_half() -> None:
    row = row_at()
    smoothed = []
    for ratio in (0.8, 0.8, 0.2):  # 0.4; 0.2 + 0.4 = 0.6; 0.3 + 0.1 = 0.4
        k.control(row, 10.0, 0.0, ratio, 0.5, C)
        smoothed.append(row[k.BUSY_RATIO])
    assert smoothed == pytest.approx([0.4, 0.6, 0.4])


@pytest.mark.parametrize(("jitter", "next_s"), [(0.0, 10.395), (0.5, 10.4), (0.75, 10.4025)])
def test_the_next_message_is_shifted_by_up_to_5_ms(jitter: float, next_s: float) -> None:
    row = row_at(inter_transmit_time_s=0.4)
    k.sent(row, 10.0, jitter, 0.5, C)
    assert row[k.LAST_S] == 10.0
    assert row[k.NEXT_S] == pytest.approx(next_s, abs=ROUNDING)


# Whole runs.


def driven(
    policy: J2945,
    *,
    vehicles: int,
    steps: int,
    step_s: float = 0.05,
    seed: int = 0,
    error_m: float | FloatArray = 0.0,
    busy: float = 0.1,
    neighbours: float = 0.0,
    ratio: float = np.nan,
    critical_ratio: float = 0.0,
    start_s: float | FloatArray = 0.0,
) -> tuple[list[TransmitInputs], list[Decisions], list[J2945State]]:
    """Inputs, decisions and the states after them of a fleet asked every step."""
    rng = np.random.default_rng(seed)
    chance = np.random.default_rng(seed + 1)
    state = policy.init(vehicles, 1)
    log: tuple[list[TransmitInputs], list[Decisions], list[J2945State]] = ([], [], [])
    full = np.full
    for step in range(steps):
        now = full(vehicles, step_s * step) + start_s
        errors = error_m if isinstance(error_m, float) else error_m[step]
        inputs = TransmitInputs(
            now,
            now,
            silence_s=now,
            tracking_error_m=np.broadcast_to(errors, (vehicles,)).reshape(-1, 1),
            available=np.ones((vehicles, 1), dtype=np.bool_),
            until_s=full(vehicles, step_s * (step + 1)) + start_s,
            motion=Motion(
                np.zeros((vehicles, 2)),
                np.zeros(vehicles),
                heading_rad=np.zeros(vehicles),
                critical=chance.random(vehicles) < critical_ratio,
            ),
            air=Air(
                full(vehicles, busy),
                full(vehicles, neighbours),
                packet_error_ratio=full(vehicles, ratio),
                airtime_s=full(vehicles, 4e-4),
            ),
        )
        decisions, state = policy.decide(state, inputs, rng)
        for entries, entry in zip(log, (inputs, decisions, state), strict=True):
            entries.append(entry)
    return log


def sent_s(decisions: list[Decisions], vehicle: int) -> FloatArray:
    """Times of a vehicle's messages."""
    times = np.array([decision.send_s[vehicle] for decision in decisions])
    return times[np.isfinite(times)]


@pytest.mark.parametrize(("neighbours", "gap_s"), [(5.0, 0.1), (50.0, 0.2), (100.0, 0.4), (400.0, 0.6)])
def test_an_undisturbed_vehicle_settles_at_the_time_its_density_asks_for(
    neighbours: float, gap_s: float
) -> None:
    _, decisions, _ = driven(J2945(), vehicles=3, steps=600, neighbours=neighbours)
    for vehicle in range(3):
        gaps = np.diff(sent_s(decisions, vehicle)[-20:])
        assert gaps == pytest.approx(gap_s, abs=0.005 + 1e-6)


def test_vehicles_begin_spread_over_one_rate_control_interval() -> None:
    _, decisions, _ = driven(J2945(), vehicles=50, steps=4)
    first = np.array([sent_s(decisions, vehicle)[0] for vehicle in range(50)])
    assert np.abs(np.histogram(first, bins=5, range=(0.0, 0.1))[0] - 10).max() <= 1


def test_a_lasting_error_sends_at_every_rate_control_at_full_power() -> None:
    _, decisions, states = driven(J2945(), vehicles=1, steps=600, neighbours=400.0, error_m=1.0, busy=0.9)
    late = [(d, s) for d, s in zip(decisions, states, strict=True) if d.send_s[0] > 20.0 and d.kind[0]]
    assert {int(state.cause[0]) for _, state in late} == {Cause.DYNAMICS}
    assert {decision.power_dbm[0] for decision, _ in late if decision.kind[0]} == {20.0}
    assert np.diff(sent_s([d for d, _ in late], 0)) == pytest.approx(0.1, abs=ROUNDING)


def test_asked_at_their_phases_vehicles_with_an_error_do_not_send_together() -> None:
    policy = J2945(J2945Parameters(density_weight=1.0))
    phase_s = 0.1 * policy.phases(20)
    _, decisions, states = driven(
        policy, vehicles=20, steps=40, step_s=0.1, error_m=1.0, start_s=phase_s, neighbours=400.0
    )
    assert set(states[-1].cause) == {Cause.DYNAMICS}
    assert np.diff(np.sort(decisions[-1].send_s)).min() > 0.001


def test_lost_messages_are_believed_lost_as_often_as_the_channel_quality_says() -> None:
    _, decisions, _ = driven(J2945(), vehicles=200, steps=400, ratio=0.3)
    late = decisions[100:]
    messages = sum(int((decision.kind > 0).sum()) for decision in late)
    believed = sum(int(decision.believed.sum()) for decision in late)
    # Renewal: a belief comes every 1 + 0.3 + 0.09 + 0.027 = 1.417 messages. Spread: below 0.005 at 30,000.
    assert believed / messages == pytest.approx(1 / 1.417, abs=0.015)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**31),
    error_m=st.floats(0.0, 0.6),
    step_s=st.sampled_from([0.01, 0.05, 0.095, 0.1]),
    critical_ratio=st.sampled_from([0.0, 0.05]),
    air=st.tuples(st.floats(0.0, 300.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_times_powers_and_probabilities_keep_their_bounds(
    seed: int, error_m: float, step_s: float, critical_ratio: float, air: tuple[float, float, float]
) -> None:
    neighbours, busy, ratio = air
    inputs, decisions, states = driven(
        J2945(),
        vehicles=4,
        steps=120,
        step_s=step_s,
        seed=seed,
        neighbours=neighbours,
        busy=busy,
        error_m=error_m,
        ratio=ratio,
        critical_ratio=critical_ratio,
    )
    previous = J2945().init(4, 1)
    for given_now, decision, state in zip(inputs, decisions, states, strict=True):
        sends = decision.kind > 0
        assert given_now.until_s is not None
        assert ((state.max_inter_transmit_time_s >= 0.1) & (state.max_inter_transmit_time_s <= 0.6)).all()
        assert ((state.channel_quality >= 0.0) & (state.channel_quality <= 0.3)).all()
        power = decision.power_dbm[sends]
        assert ((power >= 10.0) & (power <= 20.0)).all()
        assert np.isnan(decision.power_dbm[~sends]).all()
        assert (decision.send_s[sends] >= given_now.t_s[sends]).all()
        assert (decision.send_s[sends] < given_now.until_s[sends]).all()
        assert not decision.believed[~sends].any()
        # A message by error takes the place of one that was 25 ms or more ahead.
        by_error = state.cause == Cause.DYNAMICS
        assert (previous.next_s[by_error] >= given_now.t_s[by_error] + 0.025 - ROUNDING).all()
        previous = state
    for vehicle in range(4):
        gaps = np.diff(sent_s(decisions, vehicle))
        # A step of 100 ms may hold a second message back to its end.
        late_s = step_s if step_s > 0.095 else 0.0
        assert (gaps <= 0.6 + 0.005 + late_s + ROUNDING).all()
        if error_m < 0.2 and critical_ratio == 0.0:
            assert (gaps >= 0.1 - 0.005 - late_s - ROUNDING).all()


def test_the_same_seed_gives_the_same_messages_and_another_seed_others() -> None:
    runs = [
        driven(J2945(), vehicles=5, steps=200, seed=seed, error_m=0.3, neighbours=80.0)[1]
        for seed in (3, 3, 4)
    ]
    times = [np.array([decision.send_s for decision in run]) for run in runs]
    assert np.array_equal(times[0], times[1])
    assert not np.array_equal(times[0], times[2])


@pytest.mark.parametrize(("vehicles", "loss", "gap_s"), [(20, 0.0, 0.1), (51, 0.2, 0.2)])
def test_a_cluster_that_hears_itself_settles_at_the_time_its_size_asks_for(
    vehicles: int, loss: float, gap_s: float
) -> None:
    """All within 100 m: each counts the others, 19 or 50; 50 ask for 100·50/25 = 200 ms."""
    rng = np.random.default_rng(0)
    policy = J2945()
    state = policy.init(vehicles, 1)
    heard = Neighbours(neighbour_tables(vehicles, 64))
    everyone = np.arange(vehicles)
    place = rng.uniform(-30.0, 30.0, (vehicles, 2))
    message_count = np.zeros(vehicles, dtype=np.int64)
    times: list[list[float]] = [[] for _ in everyone]
    none, still = np.zeros(vehicles), np.zeros(vehicles, dtype=np.bool_)
    for step in range(300):
        now = np.full(vehicles, 0.05 * step)
        count, ratio = heard.survey(now, place)
        inputs = TransmitInputs(
            now,
            now,
            silence_s=now,
            tracking_error_m=np.zeros((vehicles, 1)),
            available=np.ones((vehicles, 1), dtype=np.bool_),
            until_s=now + 0.05,
            motion=Motion(place, none, heading_rad=none, critical=still),
            air=Air(none, count.astype(np.float64), packet_error_ratio=ratio, airtime_s=none),
        )
        decisions, state = policy.decide(state, inputs, rng)
        sender = np.flatnonzero(decisions.kind)
        sender = sender[np.argsort(decisions.send_s[sender])]
        message_count[sender] = (message_count[sender] + 1) % 128
        remote = np.repeat(sender, vehicles)
        host = np.tile(everyone, sender.size)
        arrives = (host != remote) & (rng.random(host.size) >= loss)
        remote, host = remote[arrives], host[arrives]
        heard = heard.heard(
            host,
            remote,
            message_count=message_count[remote],
            heard_s=decisions.send_s[remote],
            position_m=place[remote],
        )
        for one in sender:
            times[one].append(float(decisions.send_s[one]))
    assert state.density == pytest.approx(vehicles - 1, abs=0.5)
    assert np.mean([np.diff(each[-10:]).mean() for each in times]) == pytest.approx(gap_s, rel=0.03)
    # A ratio runs from a message received to another: of about 25, two are sure to have arrived.
    assert state.channel_quality.mean() == pytest.approx(loss * 23 / 25, abs=0.02)


# Other sets of constants.


def test_j3161_keeps_the_density_rule_and_switches_power_and_error_off() -> None:
    policy = J2945(j3161_parameters())
    _, decisions, states = driven(policy, vehicles=2, steps=600, neighbours=100.0, error_m=1.0, busy=0.95)
    assert {int(cause) for state in states for cause in state.cause} == {Cause.NOTHING, Cause.TIME}
    assert {float(p) for d in decisions for p in d.power_dbm[d.kind > 0]} == {20.0}
    assert np.diff(sent_s(decisions, 0)[-10:]) == pytest.approx(0.4, abs=0.005 + ROUNDING)
    assert j3161_parameters(power_control=True, tracking_error_trigger=True) == STANDARD


@pytest.mark.parametrize("longest_s", [2.0, 5.0])
def test_relaxed_senders_have_one_longest_time_at_every_density(longest_s: float) -> None:
    parameters = j2945_relaxed_parameters(longest_s)
    assert max_inter_transmit_time(np.array([0.0, 30.0, 900.0]), parameters).tolist() == [longest_s] * 3
    assert parameters.remote_max_age_s == np.inf
    _, decisions, _ = driven(J2945(parameters), vehicles=1, steps=600)
    assert np.diff(sent_s(decisions, 0)) == pytest.approx(longest_s, abs=0.005 + ROUNDING)


def test_a_relaxed_sender_is_certain_to_send_beyond_its_error() -> None:
    relaxed = j2945_relaxed_parameters(error_m=0.02)
    assert transmit_probability(np.array([0.0199, 0.02, np.inf]), relaxed).tolist() == [0.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("density", "growth"),
    # 1 up to B = 25, then N_s / 25, at most 6; the standard's own set never grows.
    [(0.0, 1.0), (25.0, 1.0), (50.0, 2.0), (140.0, 5.6), (150.0, 6.0), (900.0, 6.0)],
)
def test_the_error_that_calls_grows_with_density_as_the_standards_time_does(
    density: float, growth: float
) -> None:
    relaxed = j2945_relaxed_parameters(error_m=0.01).constants()
    assert k.error_growth(density, relaxed) == pytest.approx(growth, rel=ROUNDING)
    assert k.error_growth(density, C) == 1.0
    for share, probability in ((0.99, 0.0), (1.01, 1.0)):
        row = row_at(density=density, neighbours=density)
        k.control(row, 10.0, share * 0.01 * growth, 0.0, 0.5, relaxed)
        assert row[k.PROBABILITY] == probability


@pytest.mark.parametrize(
    ("cause", "follow_up_s", "wait_s"),
    [
        (Cause.DYNAMICS, 0.3, 0.3),
        (Cause.DYNAMICS, 0.0, 2.0),
        (Cause.DYNAMICS, 3.0, 2.0),
        (Cause.TIME, 0.3, 2.0),
        (Cause.CRITICAL, 0.3, 2.0),
    ],
)
def test_a_message_by_error_is_followed_up(cause: Cause, follow_up_s: float, wait_s: float) -> None:
    relaxed = j2945_relaxed_parameters(2.0, follow_up_s=follow_up_s).constants()
    row = row_at(cause=float(cause), inter_transmit_time_s=2.0)
    k.sent(row, 10.0, 0.5, 0.9, relaxed)
    assert row[k.NEXT_S] == pytest.approx(10.0 + wait_s, rel=ROUNDING)
    assert row[k.CAUSE] == Cause.TIME


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"density_weight": 1.5}, "density_weight"),
        ({"per_range_m": 0.0}, "per_range_m"),
        ({"jitter_s": -0.1}, "jitter_s"),
        ({"jitter_s": 0.1}, "jitter_s"),
        ({"max_inter_transmit_time_s": 0.05}, "max_inter_transmit_time_s"),
        ({"max_tracking_error_m": 0.1}, "max_tracking_error_m"),
        ({"start_power_dbm": 25.0}, "start_power_dbm"),
        ({"min_busy_ratio": 0.8}, "max_busy_ratio"),
        ({"max_busy_ratio": 1.2}, "max_busy_ratio"),
        ({"per_interval_s": 4.5}, "per_interval_s"),
        ({"error_sensitivity": np.nan}, "error_sensitivity"),
        ({"max_error_growth": 0.5}, "max_error_growth"),
        ({"follow_up_s": 0.05}, "follow_up_s"),
    ],
)
def test_impossible_constants_are_refused_by_name(wrong: dict[str, float], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        J2945Parameters(**wrong)


def test_phases_are_one_a_vehicle() -> None:
    with pytest.raises(ValueError, match="phase_ratio"):
        J2945(phase_ratio=np.zeros(2)).init(3, 1)


def test_a_bank_of_errors_is_refused() -> None:
    policy = J2945()
    state = policy.init(1, 2)
    one = np.zeros(1)
    inputs = TransmitInputs(
        one,
        one,
        silence_s=one,
        tracking_error_m=np.zeros((1, 2)),
        available=np.ones((1, 2), dtype=np.bool_),
        motion=Motion(np.zeros((1, 2)), one, heading_rad=one, critical=np.zeros(1, dtype=np.bool_)),
        air=Air(one, one, packet_error_ratio=one, airtime_s=one),
    )
    with pytest.raises(ValueError, match="tracking_error_m"):
        policy.decide(state, inputs, np.random.default_rng(0))

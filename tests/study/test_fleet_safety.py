"""Claims about safety applications of hosts of a fleet that hear over the air."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.motions import Motions
from modelcast.apps.registry import get_application
from modelcast.channel.erasure import Ideal, IndependentErasure
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.study.safety.fleet import SafetyObserver
from modelcast.study.safety.fleet_result import PairingScores
from modelcast.study.safety.fleet_score import score_pairings
from modelcast.study.safety.fleet_settings import FleetSafetySettings
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.braking import BrakingStreams

STEP_S, SLACK_S = 0.1, 1e-6
FCW = FleetSafetySettings(applications={"fcw": ForwardCollisionWarning()}, warm_up_s=1.0)
TEN_HZ = named_sender("bsm-10hz")
STREAMS = BrakingStreams(1000.0, 40.0, lanes=2, brakings_per_minute=40.0, warm_up_s=5.0)


def frame(t_s: float, north_m: list[float], speed_mps: list[float], *, ids: list[int]) -> FleetFrame:
    """Vehicles that drive north behind each other at constant speed."""
    count = len(north_m)
    nothing = np.zeros(count)
    return FleetFrame(
        t_s,
        np.column_stack((nothing, north_m)),
        speed_mps=np.array(speed_mps),
        heading_rad=nothing,
        acceleration_mps2=nothing,
        yaw_rate_radps=nothing,
        length_m=np.full(count, 4.5),
        vehicle_id=np.array(ids),
        active=np.ones(count, dtype=np.bool_),
    )


def approach(steps: int = 120, gap_m: float = 110.0) -> Iterator[FleetFrame]:
    """A host at 20 m/s comes up behind a remote at 10 m/s."""
    for step in range(steps):
        t_s = round(STEP_S * step, 6)
        yield frame(t_s, [20.0 * t_s, gap_m + 10.0 * t_s], [20.0, 10.0], ids=[5, 9])


def observed(
    frames: Iterator[FleetFrame],
    sender: Sender | Mix = TEN_HZ,
    settings: FleetSafetySettings = FCW,
    lost: float = 0.0,
) -> SafetyObserver:
    observer = SafetyObserver(settings)
    radio = ErasureRadio(IndependentErasure(lost) if lost else Ideal())
    own = NetworkSettings(warm_up_s=settings.warm_up_s, start_spread_s=0.0)
    _ = run_network(frames, sender, radio, own, seed=3, observer=observer)
    return observer


def scores(
    frames: Iterator[FleetFrame],
    sender: Sender | Mix = TEN_HZ,
    settings: FleetSafetySettings = FCW,
    lost: float = 0.0,
) -> list[PairingScores]:
    groups = len(sender.senders) if isinstance(sender, Mix) else 1
    return score_pairings(observed(frames, sender, settings, lost), groups)


def streams(seconds: float = 12.0) -> Iterator[FleetFrame]:
    return run_scenario(STREAMS, np.random.default_rng(4), duration_s=seconds)


def test_an_approach_is_one_event_of_one_pair_warned_within_a_step():
    (found,) = scores(approach())
    assert found.event_host.tolist() == [5]
    assert found.event_remote.tolist() == [9]
    assert found.delay_s[0] <= STEP_S + SLACK_S
    assert found.missed.sum() <= 1
    assert (found.false.sum(), found.false_warnings.sum()) == (0, 0)


def test_the_event_begins_where_the_application_with_perfect_knowledge_warns_first():
    (found,) = scores(approach())
    application = ForwardCollisionWarning()
    for one in approach():
        motions = [true_motion(one, slot) for slot in (0, 1)]
        if application.assess(*motions).warned[0]:
            assert found.event_s[0] == pytest.approx(one.t_s)
            return
    raise AssertionError("never warned")


def true_motion(one: FleetFrame, slot: int) -> Motions:
    return Motions.of(
        one.position_m[slot : slot + 1],
        speed_mps=one.speed_mps[slot],
        heading_rad=0.0,
        length_m=one.length_m[slot],
    )


def test_who_hears_nothing_warns_of_nothing_and_misses_all():
    (found,) = scores(approach(), lost=1.0)
    assert found.event_s.size == 1
    assert np.isinf(found.delay_s).all()
    assert found.missed.sum() == found.positives.sum() > 0
    assert (found.false.sum(), found.false_warnings.sum()) == (0, 0)


def test_a_remote_out_of_the_radius_is_in_no_pair():
    near, far = (
        observed(approach(gap_m=110.0), settings=replace(FCW, radius_m=radius_m))
        for radius_m in (30.0, 150.0)
    )
    # 110 m apart at first, closing 10 m/s: within 30 m from 8 s on, seen from both sides.
    assert near.pairs == 2 * sum(110.0 - one.t_s * 10.0 <= 30.0 for one in approach())
    assert far.pairs > near.pairs


def test_the_radius_leaves_out_what_is_warned_of_beyond_it():
    (found,) = scores(approach(), settings=replace(FCW, radius_m=40.0))
    (whole,) = scores(approach())
    assert found.event_s[0] > whole.event_s[0]


def test_a_host_believes_nothing_of_a_vehicle_that_took_the_slot_of_another():
    def swapped() -> Iterator[FleetFrame]:
        for one in approach(80):
            later = one.t_s >= 4.0
            place = one.position_m + np.array([[0.0, 0.0], [60.0 if later else 0.0, 0.0]])
            yield replace(one, position_m=place, vehicle_id=np.array([5, 77 if later else 9]))

    # At 5 m less the old one would be warned of; the new one drives 60 m beside.
    observer = observed(swapped())
    assert not (observer.assessed("fcw").remote == 77).any()


def test_instants_without_a_whole_grace_before_the_end_do_not_count():
    # The warning begins in the last second of this run: nobody can tell whether it would still come.
    begins_s = float(scores(approach())[0].event_s[0])
    steps = round((begins_s + 0.5) / STEP_S) + 1
    (found,) = scores(approach(steps))
    assert found.event_s.size == 0


@pytest.mark.parametrize("name", ["fcw", "eebl"])
def test_over_a_perfect_radio_every_warning_that_lasts_comes_within_two_steps(name: str):
    settings = replace(FCW, applications={name: get_application(name)}, merge_s=0.15)
    (found,) = scores(streams(30.0), settings=settings)
    # In braking traffic a step moves the margin by some metres: shorter ones are over before they are seen.
    lasting = found.positives >= 8
    assert lasting.sum() >= 5
    assert found.delay_s[lasting].max() <= 2 * STEP_S + SLACK_S


def test_what_is_true_does_not_depend_on_who_sends_or_what_is_lost():
    mix = Mix((named_sender("baseline"), TEN_HZ), (0.5, 0.5), readings=(0.5, 0.0, 0.5))
    one, few = scores(streams()), scores(streams(), lost=0.8)
    many = scores(streams(), mix)
    assert len(many) == 2
    for wanted in (few, many):
        assert sum(row.counted for row in wanted) == one[0].counted
        assert sum(row.negatives.sum() for row in wanted) == one[0].negatives.sum()
        events = [(row.event_s.tolist(), row.event_host.tolist()) for row in wanted]
        found = sorted((s, h) for times, hosts in events for s, h in zip(times, hosts, strict=True))
        assert found == sorted(zip(one[0].event_s.tolist(), one[0].event_host.tolist(), strict=True))
    assert few[0].missed.sum() > one[0].missed.sum()


def test_no_event_is_counted_twice():
    (found,) = scores(streams())
    keys = list(zip(found.event_host, found.event_remote, found.event_s, strict=True))
    assert len(set(keys)) == len(keys) > 0
    for host, remote in {(host, remote) for host, remote, _ in keys}:
        begins = sorted(s for one, other, s in keys if (one, other) == (host, remote))
        assert all(np.diff(begins) > FCW.merge_s)


def test_hosts_of_a_pairing_read_as_it_says():
    """Whatever they read, the same true warnings are to be met; alone a reading scores as beside another."""
    mix = Mix((named_sender("baseline"), TEN_HZ), (0.5, 0.5), readings=(0.5, 0.0, 0.5))
    readings = (Reading.LEGACY, Reading.MODEL)
    found = scores(streams(), mix, replace(FCW, readings=readings))
    assert [(row.group, row.reading) for row in found] == [
        (group, one) for group in (0, 1) for one in readings
    ]
    for legacy, model in (found[:2], found[2:]):
        for name in ("event_s", "event_host", "event_remote", "positives"):
            assert getattr(legacy, name).tolist() == getattr(model, name).tolist()
        assert legacy.counted == model.counted
    alone = scores(streams(), mix)
    assert [row.delay_s.tolist() for row in alone] == [row.delay_s.tolist() for row in found[1::2]]


def test_readings_differ_where_the_model_says_more_than_part_one():
    """A sender of models is silent for longer than constant velocity lasts."""
    mix = Mix((named_sender("mbc", threshold_m=0.5),))
    readings = (Reading.LEGACY, Reading.MODEL)
    legacy, model = scores(streams(20.0), mix, replace(FCW, readings=readings))
    assert legacy.event_s.tolist() == model.event_s.tolist()
    assert legacy.delay_s.tolist() != model.delay_s.tolist()


def test_sampled_hosts_warn_as_they_do_among_all():
    few, all_of_them = (
        scores(streams(), settings=replace(FCW, hosts_ratio=ratio), lost=0.3)[0] for ratio in (0.4, 1.0)
    )
    chosen = set(few.event_host.tolist())
    own = np.isin(all_of_them.event_host, list(chosen))
    assert 0 < len(chosen) < np.unique(all_of_them.event_host).size
    assert few.delay_s.tolist() == all_of_them.delay_s[own].tolist()
    assert 0.2 < few.host_s / all_of_them.host_s < 0.6


def test_the_same_run_gives_the_same_scores():
    one, other = (scores(streams(6.0), lost=0.5)[0] for _ in range(2))
    for name in ("event_s", "event_host", "event_remote", "missed", "positives", "delay_s"):
        assert getattr(one, name).tolist() == getattr(other, name).tolist()
    assert one.false_warnings.tolist() == other.false_warnings.tolist()


def test_who_looks_on_changes_no_count():
    runs = [
        run_network(streams(4.0), TEN_HZ, ErasureRadio(Ideal()), NetworkSettings(warm_up_s=1.0), seed=3,
                    observer=observer)
        for observer in (None, SafetyObserver(FCW))
    ]  # fmt: skip
    assert np.array_equal(runs[0].series, runs[1].series, equal_nan=True)
    assert np.array_equal(runs[0].tally.error, runs[1].tally.error)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"applications": {}}, "at least one"),
        ({"readings": ()}, "readings must be"),
        ({"readings": (Reading.MODEL, Reading.MODEL)}, "each once"),
        ({"radius_m": 0.0}, "radius_m must be positive"),
        ({"hosts_ratio": 0.0}, "hosts_ratio must lie"),
        ({"hosts_ratio": 1.5}, "hosts_ratio must lie"),
        ({"warm_up_s": -1.0}, "warm_up_s"),
        ({"near_m": float("inf")}, "near_m must be positive"),
    ],
)
def test_settings_out_of_range_are_refused(change: dict[str, object], said: str):
    with pytest.raises(ValueError, match=said):
        replace(FCW, **change)  # type: ignore[arg-type]

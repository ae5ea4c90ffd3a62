"""People's devices beside a fleet: who is tracked by whom, what is passed over, and what stays as it was."""

from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.erasure import Ideal
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.radio import AbstractRadio
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.runtime.fleet.people import Keeps, People
from modelcast.runtime.fleet.roadside import Roadside
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import FleetFrame, run_scenario
from modelcast.world.scenario.grid import Grid
from modelcast.world.scenario.peopled_grid import PeopledGrid

SENDER = named_sender("bsm-10hz")
SETTINGS = NetworkSettings(warm_up_s=0.5)
IDEAL = ErasureRadio(Ideal())
DRIVEN_M = 1.5 * 20.0
"""A track that was taken within reach is still held when its remote has driven on."""
TOWN = PeopledGrid(Grid(3, 3, 25.0, warm_up_s=2.0), 30, 10)
FRAMES = list(run_scenario(TOWN, np.random.default_rng(5), duration_s=1.5))


def on_air(people: People | None, *, radio: AbstractRadio[Any] = IDEAL, **more: Any) -> NetworkRun:
    return run_network(FRAMES, SENDER, radio, SETTINGS, seed=1, people=people, **more)


def counts(run: NetworkRun) -> list[np.ndarray]:
    return [*run.tally, run.sent.causes, run.outcomes]


class Held(AbstractObserver):
    """Whom each kind of host tracks at the end, and how far apart they are."""

    def before(self, loop: Any, frame: FleetFrame) -> None:
        """Nothing is looked at before a step."""

    def after(self, loop: Any, frame: FleetFrame) -> None:
        """Look at all pairs."""
        assert frame.kind is not None
        host, remote = np.nonzero(~np.eye(len(frame), dtype=np.bool_))
        live = np.isfinite(loop.believed(host, remote).motion[:, 0])
        person = np.isin(frame.kind, PEOPLE)
        way_m = np.hypot(*(frame.position_m[remote] - frame.position_m[host]).T)
        self.farthest_m = {
            kinds: way_m[live & (person[host] == kinds[0]) & (person[remote] == kinds[1])].max(initial=0.0)
            for kinds in ((False, False), (False, True), (True, False), (True, True))
        }


def held(keeps: Keeps, reach_m: float) -> dict[tuple[bool, bool], float]:
    seen = Held()
    on_air(People(SENDER, keeps=keeps, reach_m=reach_m), observer=seen)
    return seen.farthest_m


@pytest.mark.parametrize("radio", [IDEAL, Dsrc()], ids=["ideal", "dsrc"])
def test_people_who_do_as_vehicles_change_nothing(radio: AbstractRadio[Any]) -> None:
    """The vehicles' sender, antenna and map: every count is what it is without a word about people."""
    alone, told = on_air(None, radio=radio), on_air(People(SENDER, keeps="all"), radio=radio)
    for one, other in zip(counts(alone), counts(told), strict=True):
        np.testing.assert_array_equal(one, other)
    assert alone.people is None
    assert told.people is not None
    assert (told.people.unread, told.people.far) == (0, 0)
    assert told.people.read == told.people.received > 0
    assert told.people.person_s == pytest.approx(40 * 1.0)


def test_fleets_without_people_do_not_mind_what_people_would_do() -> None:
    frames = list(run_scenario(Grid(3, 3, 25.0, warm_up_s=2.0), np.random.default_rng(5), duration_s=1.5))
    people = People(named_sender("mbc"), gain_db=-20.0, keeps="nobody", reach_m=10.0)
    runs = [run_network(frames, SENDER, Dsrc(), SETTINGS, seed=1, people=one) for one in (None, people)]
    for one, other in zip(counts(runs[0]), counts(runs[1]), strict=True):
        np.testing.assert_array_equal(one, other)


def test_whom_people_keep_is_whom_they_track() -> None:
    """Vehicles track everybody, whatever people do; pairs with a person end at the reach."""
    vehicles, everybody, nobody = (held(keeps, 80.0) for keeps in ("vehicles", "all", "nobody"))
    for found in (vehicles, everybody, nobody):
        assert found[False, False] > 200.0
        assert 60.0 < found[False, True] < 80.0 + DRIVEN_M
    assert 60.0 < vehicles[True, False] < 80.0 + DRIVEN_M
    assert vehicles[True, True] == 0.0
    assert 60.0 < everybody[True, True] < 80.0 + DRIVEN_M
    assert nobody[True, False] == nobody[True, True] == 0.0


@pytest.mark.parametrize("keeps", ["vehicles", "all", "nobody"])
def test_pairs_are_those_that_may_be_tracked(keeps: Keeps) -> None:
    """Counted one by one, in bins of 25 m; with an ideal channel, hosts soon hold every one of them."""
    reach_m = 110.0
    run = on_air(People(SENDER, keeps=keeps, reach_m=reach_m))
    expected = np.zeros(SETTINGS.distances, dtype=np.int64)
    for frame in FRAMES[5:]:
        assert frame.kind is not None
        person = np.isin(frame.kind, PEOPLE)
        way_m = np.hypot(*(frame.position_m[:, None] - frame.position_m[None]).transpose(2, 0, 1))
        kept = ~person[:, None] | np.full(person.size, keeps == "all") | ((keeps == "vehicles") & ~person)
        near = np.where(person[:, None] | person, way_m <= reach_m, way_m < 300.0)
        found = way_m[kept & near & ~np.eye(person.size, dtype=np.bool_)]
        expected += np.bincount((found / 25.0).astype(np.int64), minlength=SETTINGS.distances)
    np.testing.assert_array_equal(run.tally.pairs, expected)
    assert run.tally.held.sum() / expected.sum() > 0.97
    assert (run.tally.held <= expected).all()


def test_what_people_receive_is_read_passed_over_or_too_far() -> None:
    """On an ideal channel everybody hears everybody: of 39 other people nothing is read."""
    run = on_air(People(SENDER, reach_m=100.0)).people
    assert run is not None
    stations, people, steps = len(FRAMES[0]), 40, 10
    assert run.received == people * (stations - 1) * steps
    assert run.unread == people * (people - 1) * steps
    assert 0 < run.far < run.received - run.unread
    assert run.sent.causes.sum() == people * steps


def test_people_send_by_a_rule_of_their_own() -> None:
    """Errors call for people's messages, the clock for vehicles'; power is the device's."""
    run = on_air(People(named_sender("baseline", keep_alive_s=1.0)))
    assert run.people is not None
    people, everybody = int(run.people.sent.causes.sum()), int(run.sent.causes.sum())
    vehicles = sum(1 for kind in FRAMES[0].kind if kind == Kind.VEHICLE)  # type: ignore[union-attr]
    assert everybody - people == vehicles * 10
    assert 0 < people < 40 * 10 / 2
    assert [group.name for group in run.groups] == ["bsm-10hz", "baseline"]


def test_a_weak_antenna_is_heard_less_far_and_hears_less() -> None:
    strong, weak = (on_air(People(SENDER, gain_db=gain_db), radio=Dsrc()) for gain_db in (0.0, -15.0))
    assert strong.people is not None
    assert weak.people is not None
    assert weak.people.received < 0.7 * strong.people.received
    assert weak.tally.heard.sum() < strong.tally.heard.sum()


def test_a_unit_reads_people_whatever_they_keep() -> None:
    units = Roadside(np.array([[200.0, 200.0]]))
    runs = [on_air(People(SENDER, keeps=keeps), roadside=units).roadside for keeps in ("all", "nobody")]
    assert runs[0] is not None
    assert runs[1] is not None
    np.testing.assert_array_equal(runs[0].tally.held, runs[1].tally.held)


def test_people_of_a_mixed_fleet_are_refused() -> None:
    mix = Mix((SENDER, named_sender("baseline")), (0.5, 0.5))
    with pytest.raises(ValueError, match="a mixed fleet has none"):
        run_network(FRAMES, mix, IDEAL, SETTINGS, seed=1, people=People(SENDER))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"gain_db": 1.0}, "gain_db must be finite and not above 0"),
        ({"keeps": "friends"}, "keeps must be one of vehicles, all, nobody, got 'friends'"),
        ({"reach_m": 0.0}, "reach_m must be positive"),
    ],
)
def test_a_device_that_cannot_be_is_refused(given: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        People(SENDER, **given)

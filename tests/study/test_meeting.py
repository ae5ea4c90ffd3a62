"""A meeting at an occluded crossing: found by geometry alone, and filmed as the host believes it."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.erasure import Ideal
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.path_loss import ManhattanNlos
from modelcast.channel.propagation import Propagation, StreetGrid
from modelcast.core.kinds import Kind
from modelcast.report.figures.meeting import FRAMES_S, at_instants, plot_meeting
from modelcast.runtime.fleet.engine import run_network
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.study.network.meeting import Meeting, MeetingObserver, hidden_meeting
from modelcast.world.scenario.base import FleetFrame

STREETS = StreetGrid(200.0, 30.0)
TOWN = Propagation(streets=STREETS, nlos=ManhattanNlos())
MEETS_S, CAR_MPS, CYCLIST_MPS, ASIDE_M = 10.0, 10.0, 4.0, 3.0


def frames(
    kind: Kind = Kind.CYCLIST, car_mps: float = CAR_MPS, cyclist_mps: float = CYCLIST_MPS
) -> list[FleetFrame]:
    """A car from the west and somebody from the south, who pass 3 m apart; another car stands far away."""
    found: list[FleetFrame] = []
    for number in range(120):
        t_s = 0.1 * number
        left_s = MEETS_S - t_s
        found.append(
            FleetFrame(
                t_s,
                np.array([[-car_mps * left_s, ASIDE_M], [0.0, -cyclist_mps * left_s], [400.0, 400.0]]),
                speed_mps=np.array([car_mps, cyclist_mps, 0.0]),
                heading_rad=np.array([np.pi / 2, 0.0, 0.0]),
                acceleration_mps2=np.zeros(3),
                yaw_rate_radps=np.zeros(3),
                length_m=np.array([4.5, 1.9, 4.5]),
                vehicle_id=np.array([7, 8, 9]),
                active=np.ones(3, dtype=np.bool_),
                kind=np.array([Kind.VEHICLE, kind, Kind.VEHICLE]),
                width_m=np.array([1.8, 0.6, 1.8]),
            )
        )
    return found


def test_who_comes_from_behind_a_building_is_found() -> None:
    """Streets are 30 m wide: the cyclist turns into sight 15 m before the crossing, 3.75 s ahead."""
    found = hidden_meeting(frames(), TOWN)
    assert found is not None
    assert (found.vehicle, found.person, found.kind) == (7, 8, Kind.CYCLIST)
    # Nearest on the line between both ways: the car is ASIDE_M to the north of the cyclist's goal.
    late_s = ASIDE_M * CYCLIST_MPS / (CAR_MPS**2 + CYCLIST_MPS**2)
    assert found.nearest_s == pytest.approx(MEETS_S + late_s, abs=0.1)
    assert found.sight_s == pytest.approx(15.0 / CYCLIST_MPS + late_s, abs=0.15)
    assert found.nearest_m == pytest.approx(ASIDE_M * CAR_MPS / np.hypot(CAR_MPS, CYCLIST_MPS), abs=0.3)


@pytest.mark.parametrize(
    ("given", "propagation", "since_s"),
    [
        (frames(Kind.VEHICLE), TOWN, 0.0),
        (frames(car_mps=3.0), TOWN, 0.0),
        (frames(cyclist_mps=0.5), TOWN, 0.0),
        (frames(), Propagation(), 0.0),
        (frames(), TOWN, 5.0),
    ],
    ids=["no person", "the car creeps", "the cyclist stands", "open ground", "too early"],
)
def test_other_passings_are_no_hidden_meetings(
    given: list[FleetFrame], propagation: Propagation, since_s: float
) -> None:
    assert hidden_meeting(given, propagation, since_s=since_s) is None


def test_who_has_left_meets_nobody() -> None:
    """A slot that is empty has a place of zeros, at the crossing."""
    given = [
        replace(
            one,
            active=np.array([True, one.t_s < 5.0, True]),
            position_m=one.position_m * [[1], [one.t_s < 5.0], [1]],
        )
        for one in frames()
    ]
    assert hidden_meeting(given, TOWN) is None


def filmed(meeting: Meeting) -> MeetingObserver:
    observer = MeetingObserver(meeting, TOWN)
    settings = NetworkSettings(warm_up_s=1.0)
    run_network(
        frames(), named_sender("bsm-10hz"), ErasureRadio(Ideal()), settings, seed=1, observer=observer
    )
    return observer


def test_the_film_shows_what_the_host_believes() -> None:
    """Constant velocity on an ideal channel: believed is what is true, from messages not older than 0.2 s."""
    meeting = hidden_meeting(frames(), TOWN)
    assert meeting is not None
    seen = filmed(meeting).seen()
    assert seen.t_s[0] == pytest.approx(-7.0)
    assert seen.t_s[-1] == pytest.approx(1.0)
    assert seen.error_m.max() < 0.05
    assert seen.age_s.max() <= 0.2
    assert seen.in_sight[seen.t_s > -3.8].all()
    assert not seen.in_sight[seen.t_s < -4.1].any()
    assert seen.distance_m.min() == pytest.approx(meeting.nearest_m)
    assert [float(seen.t_s[at]) for at in at_instants(seen)] == pytest.approx(list(FRAMES_S))


def test_a_film_without_its_moment_is_refused() -> None:
    late = Meeting(7, 8, kind=Kind.CYCLIST, nearest_s=99.0, nearest_m=1.0, sight_s=1.0)
    with pytest.raises(ValueError, match="no frame within"):
        filmed(late).seen()


def test_a_strip_has_a_row_a_run_and_a_picture_an_instant() -> None:
    meeting = hidden_meeting(frames(), TOWN)
    assert meeting is not None
    seen = filmed(meeting).seen()
    figure = plot_meeting(meeting, {"no unit": seen, "units relay": seen}, STREETS)
    assert len(figure.axes) == 2 * len(FRAMES_S)
    titles = [axes.get_title() for axes in figure.axes[: len(FRAMES_S)]]
    assert titles[0] == "-6 s, hidden"
    assert titles[-1] == "+0 s, in sight"

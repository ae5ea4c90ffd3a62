"""Claims: what the page shows of a station is what the station believes, in closed forms where there are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast import Station
from modelcast.dashboard.snapshot import AHEAD_S, Counters, Host, WarningShown, ellipses, snapshot_of

MICROMETRE = 1e-6
"""Of places that two ways of computing give."""

HOST = Host(2, (0.0, 0.0), heading_rad=0.0, speed_mps=0.0)


@pytest.fixture(scope="module")
def host() -> Station:
    """A host that has heard a remote driving east at 15 m/s for four seconds."""
    front, back = Station("baseline", temporary_id=7), Station("baseline", temporary_id=2)
    for step in range(41):
        t_s = 0.1 * step
        for message in front.sense(t_s, (15.0 * t_s, 0.0), speed_mps=15.0, heading_rad=np.pi / 2):
            back.hear([message.octets], received_s=[message.send_s])
    return back


@given(st.floats(0.01, 50.0), st.floats(0.0, 1.0), st.floats(-1.5, 1.5))
def test_an_ellipse_is_found_again_from_its_covariance(
    major_m: float, share: float, angle_rad: float
) -> None:
    axes_m = np.array([major_m, 0.9 * share * major_m])
    turned = np.array([[np.cos(angle_rad), -np.sin(angle_rad)], [np.sin(angle_rad), np.cos(angle_rad)]])
    found_m, found_rad = ellipses((turned @ np.diag(axes_m**2) @ turned.T)[None])
    np.testing.assert_allclose(found_m[0], axes_m, atol=1e-5 * major_m, rtol=1e-6)
    assert found_rad[0] == pytest.approx(angle_rad, abs=1e-6)


def test_a_covariance_that_is_none_has_no_negative_axis() -> None:
    axes_m, _ = ellipses(np.array([[[1.0, 2.0], [2.0, 1.0]]]))
    assert axes_m[0].tolist() == [np.sqrt(3.0), 0.0]


def test_a_remote_at_constant_velocity_has_a_straight_path(host: Station) -> None:
    remotes = snapshot_of(host, 4.0, HOST, counters=Counters()).remotes
    ahead_m = remotes.path_m[0] - remotes.position_m[0]
    np.testing.assert_allclose(ahead_m[:, 0], remotes.speed_mps[0] * AHEAD_S, atol=0.05)
    np.testing.assert_allclose(remotes.speed_mps, 15.0, atol=0.05)


def test_a_path_ends_where_the_station_believes_the_remote_then(host: Station) -> None:
    path_m = host.paths(4.0, np.array([0.5, 1.5]))
    for at, later_s in enumerate((4.5, 5.5)):
        np.testing.assert_allclose(path_m[:, at], host.believe(later_s).position_m, atol=MICROMETRE)


def test_a_path_goes_on_beyond_the_time_at_which_its_remote_would_be_dropped(host: Station) -> None:
    t_s = host.believe(4.0).received_s[0] + 4.9
    assert host.believe(t_s).vehicle.size == 1
    assert host.believe(t_s + 2.0).vehicle.size == 0
    assert np.isfinite(host.paths(t_s, AHEAD_S)).all()


def test_what_is_known_of_a_remote_stands_in_its_row_and_the_rest_is_unknown(host: Station) -> None:
    place_m = tuple(host.believe(4.0).position_m[0].tolist())
    shown = snapshot_of(
        host,
        4.0,
        HOST,
        counters=Counters(),
        messages={7: 12},
        truth_m={7: (place_m[0] + 3.0, place_m[1] + 4.0)},
    ).remotes
    assert shown.messages.tolist() == [12.0]
    assert shown.error_m[0] == pytest.approx(5.0)
    assert np.isnan(shown.loss_ratio[0])
    assert shown.silent_s[0] == pytest.approx(4.0 - host.believe(4.0).received_s[0])


def test_the_name_of_a_sub_model_is_that_of_the_profile_in_use(host: Station) -> None:
    beliefs, shown = host.believe(4.0), snapshot_of(host, 4.0, HOST, counters=Counters()).remotes
    names = host.model_names[int(beliefs.profile[0]) + 1]
    wanted = "Part I" if beliefs.profile[0] < 0 else names[int(beliefs.in_use[0])]
    assert shown.names[int(shown.model[0])] == wanted


def test_warnings_stand_by_level_then_by_age(host: Station) -> None:
    said = [WarningShown(1, "fcw", 1, 0.5), WarningShown(2, "ima", 3, 3.0), WarningShown(2, "fcw", 4, 2.0)]
    shown = snapshot_of(host, 4.0, HOST, counters=Counters(), warnings=said).warnings
    assert [one.vehicle for one in shown] == [4, 3, 1]


def test_a_model_that_has_no_name_is_refused(host: Station) -> None:
    remotes = snapshot_of(host, 4.0, HOST, counters=Counters()).remotes
    with pytest.raises(ValueError, match="model must be from 0"):
        replace(remotes, model=remotes.model + len(remotes.names))
    with pytest.raises(ValueError, match="path_m must have shape"):
        replace(remotes, path_m=remotes.path_m[:, :2])

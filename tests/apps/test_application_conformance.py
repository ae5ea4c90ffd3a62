"""What every safety application keeps to."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.apps.motions import Motions
from modelcast.apps.registry import APPLICATIONS, get_application
from modelcast.apps.warnings import Level
from modelcast.core.exceptions import ConfigError
from modelcast.core.kinds import Kind

every = pytest.mark.parametrize("name", APPLICATIONS.own)


def rows(motions: Motions, which) -> Motions:
    """Some rows of motions."""
    return Motions(
        motions.position_m[which],
        speed_mps=motions.speed_mps[which],
        heading_rad=motions.heading_rad[which],
        acceleration_mps2=motions.acceleration_mps2[which],
        yaw_rate_radps=motions.yaw_rate_radps[which],
        length_m=motions.length_m[which],
        width_m=motions.width_m[which],
        covariance_m2=None if motions.covariance_m2 is None else motions.covariance_m2[which],
        kind=None if motions.kind is None else motions.kind[which],
    )


def meant(name: str, pairs: tuple[Motions, Motions]) -> tuple[Motions, Motions]:
    """Pairs of those that an application is made for."""
    if get_application(name).of_people:
        return pairs
    return replace(pairs[0], kind=None), replace(pairs[1], kind=None)


@every
def test_level_margin_and_certainty_agree(random_pairs, name: str):
    host, remote = meant(name, random_pairs(np.random.default_rng(1), 5000))
    found = get_application(name).assess(host, remote)
    np.testing.assert_array_equal(found.warned, found.margin_m <= 0.0)
    assert found.warned.sum() > 50
    np.testing.assert_array_equal(found.certainty >= 0.5, found.warned)
    assert ((found.certainty >= 0.0) & (found.certainty <= 1.0)).all()
    assert (found.time_s >= 0.0).all()
    exact = get_application(name).assess(
        replace(host, covariance_m2=None), replace(remote, covariance_m2=None)
    )
    np.testing.assert_array_equal(exact.certainty, found.warned)
    np.testing.assert_array_equal(exact.margin_m, found.margin_m)


@pytest.mark.parametrize("whose", ["host", "remote"])
@pytest.mark.parametrize("name", [name for name in APPLICATIONS.own if not get_application(name).of_people])
def test_an_application_of_vehicles_says_nothing_of_people(random_pairs, name: str, whose: str):
    pairs = dict(zip(("host", "remote"), random_pairs(np.random.default_rng(4), 5000), strict=True))
    kind = np.arange(5000) % len(Kind)
    pairs[whose] = replace(pairs[whose], kind=kind)
    other = "remote" if whose == "host" else "host"
    pairs[other] = replace(pairs[other], kind=np.zeros(5000, dtype=np.int64))
    found, vehicles = get_application(name).assess(**pairs), kind == Kind.VEHICLE
    assert found.warned[vehicles].any()
    assert not found.level[~vehicles].any()
    assert np.isinf(found.margin_m[~vehicles]).all()
    assert np.isinf(found.time_s[~vehicles]).all()
    assert not found.certainty[~vehicles].any()


@every
def test_rows_stand_for_themselves_whatever_the_layout(random_pairs, name: str):
    host, remote = random_pairs(np.random.default_rng(2), 600, known=False)
    application = get_application(name)
    whole = application.assess(host, remote)
    some = application.assess(rows(host, slice(None, None, 3)), rows(remote, slice(None, None, 3)))
    for column in ("level", "time_s", "margin_m", "certainty"):
        np.testing.assert_array_equal(getattr(some, column), getattr(whole, column)[::3])


@every
def test_of_unknown_remotes_nothing_is_said(random_pairs, name: str):
    host, remote = random_pairs(np.random.default_rng(3), 600, known=False)
    found = get_application(name).assess(host, remote)
    lost = np.isnan(remote.position_m[:, 0])
    assert lost.sum() == 60
    np.testing.assert_array_equal(np.isnan(found.margin_m), lost)
    assert (found.level[lost] == Level.NONE).all()
    assert np.isinf(found.time_s[lost]).all()
    assert not found.certainty[lost].any()


@every
def test_no_pairs_give_no_warnings(name: str):
    none = Motions.of(np.empty((0, 2)), speed_mps=0.0, heading_rad=0.0)
    assert len(get_application(name).assess(none, none)) == 0


def test_an_unknown_application_gets_the_names():
    with pytest.raises(ConfigError, match=r"'aeb'\. Known: fcw, eebl, ima"):
        get_application("aeb")

"""The loaded highway: what its messages, lanes and antennas are, and that the channel feels them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.dsrc_parameters import DsrcParameters
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.radio_words import get_radio
from modelcast.channel.sidelink import Sidelink
from modelcast.channel.tabulated import TabulatedRadio
from modelcast.cli.fleet_options import FleetOptions
from modelcast.cli.network_case import run_case
from modelcast.cli.network_cases import MOST_MORE_BYTES, Varied, network_cases
from modelcast.cli.network_loaded import ANTENNA_GAIN_DB, loaded_radio
from modelcast.cli.network_plan import NetworkPlan
from modelcast.cli.network_senders import sender_rows
from modelcast.cli.options import SensorOptions
from modelcast.core.exceptions import ConfigError
from modelcast.messages.airtime import Stack
from modelcast.study.network.rows import NO_BANK, NetworkCase

PLAIN_BYTES = 40


def plan(scenario: str) -> NetworkPlan:
    """A short run of a scenario."""
    options = FleetOptions(scenario=scenario, length=600.0, duration=3.0, warm_up=1.0, lanes=5)
    return options.plan(SensorOptions(), banks=("default",), thresholds_m=(0.2,))


def test_a_plain_message_with_a_digest_has_250_bytes() -> None:
    sizes = plan("loaded").stack.frame_bytes(np.array([PLAIN_BYTES]), np.array([False]))
    assert sizes.tolist() == [250]
    assert plan("highway").stack == Stack()


def test_other_bytes_stand_beside_the_rest_signed_or_not() -> None:
    for rule in ("gap", "unsigned"):
        bare, full = Stack(rule), Stack(rule, other_bytes=82)
        payloads, certificates = np.array([40, 55]), np.array([True, False])
        more = full.frame_bytes(payloads, certificates) - bare.frame_bytes(payloads, certificates)
        assert more.tolist() == [82, 82]
    with pytest.raises(ValueError, match="other_bytes must not be negative, got -1"):
        Stack(other_bytes=-1)


def test_more_bytes_come_to_those_of_the_scenario_and_are_part_of_what_a_run_depends_on() -> None:
    for scenario in ("highway", "loaded"):
        without, given = plan(scenario), replace(plan(scenario), more_bytes=50)
        assert given.stack.other_bytes == without.stack.other_bytes + 50
        assert given.as_plain()["more_bytes"] == 50
        assert "more_bytes" not in without.as_plain()


def test_fewer_bytes_than_none_are_refused_in_one_line() -> None:
    with pytest.raises(ConfigError, match="other_bytes must not be negative, got -1"):
        sender_rows(replace(plan("highway"), more_bytes=-1), ["cam"])


@pytest.mark.parametrize("more_bytes", [-1, MOST_MORE_BYTES + 1, 10**30])
def test_bytes_out_of_range_are_refused_by_the_option_s_name(more_bytes: int) -> None:
    varied = Varied((25.0,), ("dsrc",), ("cam",), 1)
    assert network_cases(replace(plan("highway"), more_bytes=MOST_MORE_BYTES), varied)
    with pytest.raises(ConfigError, match=f"--more-bytes must lie within 0..1400, got {more_bytes}"):
        network_cases(replace(plan("highway"), more_bytes=more_bytes), varied)


@pytest.mark.parametrize("radio", ["sidelink", "nr"])
def test_a_message_too_long_for_its_radio_says_what_helps(radio: str) -> None:
    case = NetworkCase(25.0, radio, "bsm-10hz", NO_BANK, 0)
    with pytest.raises(
        ConfigError, match=f"--radio {radio}: size_bytes must fit.*; lower --more-bytes, or take"
    ):
        run_case(replace(plan("highway"), more_bytes=MOST_MORE_BYTES), case)


def test_it_has_ten_lanes_unless_told_and_more_where_they_are_full() -> None:
    free = replace(plan("loaded"), lanes=0)
    assert [free.lanes_for(density) for density in (25.0, 700.0, 1000.0, 1001.0)] == [5, 5, 5, 6]
    assert replace(free, lanes=3).lanes_for(700.0) == 3


@pytest.mark.parametrize("radio", [Dsrc(), Sidelink()])
def test_a_radio_with_antennas_gets_its_gain_and_nothing_else(radio: Dsrc | Sidelink) -> None:
    found = loaded_radio(radio, "dsrc")
    assert isinstance(found, Dsrc | Sidelink)
    assert found.parameters.antenna_gain_db == ANTENNA_GAIN_DB
    own = radio.parameters.antenna_gain_db
    assert replace(found, parameters=replace(found.parameters, antenna_gain_db=own)) == radio


def test_a_gain_that_the_word_or_its_preset_sets_holds_and_a_radio_without_antennas_stays() -> None:
    own = Dsrc(DsrcParameters(antenna_gain_db=1.0))
    assert loaded_radio(own, "dsrc:antenna_gain_db=1") is own
    assert loaded_radio(own, "dsrc:preset=deployed-obu") is own
    for word in ("dsrc:preset=ns3-default", "sidelink:preset=j3161"):
        found: Any = loaded_radio(get_radio(word), word)
        assert found.parameters.antenna_gain_db == ANTENNA_GAIN_DB
    abstract = TabulatedRadio()
    assert loaded_radio(abstract, "abstract") == replace(abstract, antenna_gain_db=ANTENNA_GAIN_DB)
    assert loaded_radio(abstract, "abstract:antenna_gain_db=0") is abstract
    ideal = ErasureRadio()
    assert loaded_radio(ideal, "ideal") is ideal


def test_the_same_traffic_loads_the_channel_more() -> None:
    case = NetworkCase(100.0, "dsrc", "bsm-10hz", NO_BANK, 0)
    light, heavy = (run_case(plan(scenario), case).run for scenario in ("highway", "loaded"))
    assert heavy.vehicles == light.vehicles
    assert heavy.message_rate_hz == light.message_rate_hz
    assert heavy.bytes_per_s == pytest.approx(light.bytes_per_s + 82 * light.message_rate_hz)
    assert heavy.busy_ratio > 1.3 * light.busy_ratio

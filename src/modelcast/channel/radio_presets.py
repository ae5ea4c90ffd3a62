"""Named settings of radios: ``--radio dsrc:preset=wilab`` sets all of one at once."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, NamedTuple

from modelcast.channel.nr_parameters import NrParameters, wilab_nr_parameters
from modelcast.channel.sidelink_parameters import (
    SidelinkParameters,
    j3161_sidelink_parameters,
    wilab_sidelink_parameters,
)

__all__ = ["PRESETS", "Preset"]


class Preset(NamedTuple):
    """Settings with a name: what it stands for, and values by key of the radio's form."""

    about: str
    settings: Mapping[str, Any]


_NS3 = Preset(
    "ns-3 3.44 as it comes: its receiver (7 dB, preambles from 4 dB and -82 dBm), its clear channel "
    "assessment (-82 dBm of all power together), its table-based errors, DCF without QoS, log-distance 3 "
    "without fading",
    {
        "aifsn": 2,
        "window": 15,
        "noise_figure_db": 7.0,
        "sensitivity_dbm": -82.0,
        "decodable_dbm": -82.0,
        "energy_dbm": -82.0,
        "preamble_db": 4.0,
        "capture_s": 4e-6,
        "capture_db": 4.0,
        "sensing_s": 4e-6,
        "error_model": "table",
        "path_loss": "log-distance",
        "exponent": 3.0,
        "reference_loss_db": 46.6777,
        "shadowing": "none",
        "fading": "none",
    },
)


def _settings_of(parameters: SidelinkParameters | NrParameters) -> dict[str, Any]:
    """What parameters have other than by default, by key."""
    plain = type(parameters)()
    given = {one.name: getattr(parameters, one.name) for one in fields(parameters) if one.init}
    return {name: value for name, value in given.items() if name != "_" and value != getattr(plain, name)}


_WILAB_DSRC = Preset(
    "WiLabV2Xsim 6.1 at 6 Mb/s, its highway: 3 dB antennas, noise figure 6 dB, a step at 6.5 dB of mean "
    "SINR, capture at any time, frames that begin at once spoil each other, AIFS and 1 to 15 slots before "
    "every message, WINNER+ B1, 3 dB of shadowing",
    {
        "aifsn": 7,
        "window": 14,
        "noise_figure_db": 6.0,
        "antenna_gain_db": 3.0,
        "sensitivity_dbm": -100.0,
        "decodable_dbm": -100.0,
        "preamble_db": 6.5,
        "capture_s": 1.0,
        "capture_db": 6.5,
        "sensing_s": 13e-6,
        "immediate_access": False,
        "aifs_on_arrival": True,
        "ties_spoil": True,
        "margin_db": 20.0,
        "extended_s": 0.0,
        "error_model": "threshold",
        "threshold_db": 6.5,
        "path_loss": "winner-b1",
        "shadowing_db": 3.0,
        "shadowing_nlos_db": 4.0,
        "decorrelation_m": 25.0,
        "fading": "none",
    },
)

_WILAB_SIDELINK = Preset(
    "WiLabV2Xsim 6.1, LTE-V2X mode 4 at MCS 7, its highway: 3 dB antennas, noise figure 6 dB, a step at "
    "8.47 dB of mean SINR, one message of 300 bytes a subframe, keep ratio 0.4, WINNER+ B1, 3 dB of "
    "shadowing",
    {
        **_settings_of(wilab_sidelink_parameters()),
        "error_model": "threshold",
        "threshold_db": 8.47,
        "path_loss": "winner-b1",
        "shadowing_db": 3.0,
        "shadowing_nlos_db": 4.0,
        "decorrelation_m": 25.0,
        "fading": "none",
    },
)

_WILAB_NR = Preset(
    "WiLabV2Xsim 6.2, NR-V2X mode 2 at MCS 11, its highway: 3 dB antennas, noise figure 6 dB, a step at the "
    "mean SINR that the rate needs (9.99 dB), two messages of 300 bytes a slot, keep ratio 0.4, WINNER+ B1, "
    "3 dB of shadowing",
    {
        **_settings_of(wilab_nr_parameters()),
        "error_model": "own",
        "path_loss": "winner-b1",
        "shadowing_db": 3.0,
        "shadowing_nlos_db": 4.0,
        "decorrelation_m": 25.0,
        "fading": "none",
    },
)

_J3161 = Preset(
    "LTE-V2X as deployed in the United States, SAE J3161/1: 20 MHz, every message twice, one-shots between "
    "reservations, intervals that follow the sender; parts are from memory (`j3161_sidelink_parameters`)",
    _settings_of(j3161_sidelink_parameters()),
)

_DEPLOYED = Preset(
    "an on-board unit on an open road: 3 dB antennas 1.5 m high, two rays, errors 5 dB above the NIST model "
    "(as hardware was measured, second-hand), 3.95 dB of shadowing (Abbas et al., highway, second-hand), "
    "Nakagami fading",
    {
        "antenna_gain_db": 3.0,
        "error_model": "nist",
        "implementation_loss_db": 5.0,
        "path_loss": "two-ray",
        "antenna_m": 1.5,
        "shadowing_db": 3.95,
        "fading": "nakagami",
    },
)

PRESETS: Mapping[str, Mapping[str, Preset]] = {
    "dsrc": {"ns3-default": _NS3, "wilab": _WILAB_DSRC, "deployed-obu": _DEPLOYED},
    "sidelink": {"wilab": _WILAB_SIDELINK, "j3161": _J3161},
    "nr": {"wilab": _WILAB_NR},
}
"""Presets by radio and name."""

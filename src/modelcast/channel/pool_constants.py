"""Parameters of a pool of sub-channels as numbers: what the air of modes 4 and 2 needs of both."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.dsrc_parameters import power_ratio, thermal_noise_dbm
from modelcast.channel.frame_radio import has_shadowing
from modelcast.channel.nr_parameters import NrParameters
from modelcast.channel.propagation import Propagation
from modelcast.channel.sidelink_parameters import SidelinkParameters

__all__ = ["PoolConstants", "pool_constants"]

ELEMENT_HZ = 15e3
"""Bandwidth that the thresholds for reservations are for."""


class PoolConstants(NamedTuple):
    """Parameters as numbers. Powers are in mW over one sub-channel, ``window`` is in subframes or slots.

    ``elements`` of 15 kHz in a sub-channel; what is received below ``reserved_mw`` in one of them reserves
    nothing. ``noise_counts`` says whether noise is part of the power sensed.
    """

    sub_channels: int
    elements: float
    noise_mw: float
    noise_counts: bool
    sensitivity_mw: float
    quiet_mw: float
    control_ratio: float
    reserved_mw: float
    load_mw: float
    window: int
    gain_db: float
    range_m: float
    sensing_range_m: float
    bin_m: float
    bins: int
    shadowed: bool


def pool_constants(
    parameters: SidelinkParameters | NrParameters,
    propagation: Propagation,
    *,
    slots_a_ms: int = 1,
    noise_counts: bool = True,
) -> PoolConstants:
    """Numbers of a pool.

    Parameters
    ----------
    parameters
        Of the radio.
    propagation
        What becomes of the power.
    slots_a_ms
        Subframes or slots in a millisecond.
    noise_counts
        Whether noise is part of the power sensed.
    """
    p = parameters
    noise_dbm = thermal_noise_dbm(p.sub_channel_hz) + p.noise_figure_db
    loudest_dbm = p.max_power_dbm + 2.0 * p.antenna_gain_db
    elements = p.sub_channel_hz / ELEMENT_HZ
    reserved_db = loudest_dbm - p.reserved_dbm - 10.0 * float(np.log10(elements))
    return PoolConstants(
        sub_channels=p.sub_channels,
        elements=elements,
        noise_mw=power_ratio(noise_dbm),
        noise_counts=noise_counts,
        sensitivity_mw=power_ratio(p.sensitivity_dbm),
        quiet_mw=power_ratio(noise_dbm - p.margin_db),
        control_ratio=power_ratio(p.control_db),
        reserved_mw=power_ratio(p.reserved_dbm),
        load_mw=power_ratio(p.load_dbm),
        window=p.busy_window_ms * slots_a_ms,
        gain_db=2.0 * p.antenna_gain_db,
        range_m=propagation.range_m(loudest_dbm - noise_dbm + p.margin_db),
        sensing_range_m=propagation.range_m(reserved_db),
        bin_m=p.bin_m,
        bins=p.bins,
        shadowed=has_shadowing(propagation),
    )

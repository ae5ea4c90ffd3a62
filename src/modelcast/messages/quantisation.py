"""Banks whose members predict with what a receiver decodes: the steps of SAE J2735, given to the models."""

from dataclasses import replace
from typing import Final

from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.fields import Field
from modelcast.models.bank import Bank
from modelcast.models.predicted_path import carried_form
from modelcast.models.quantised import CoreSteps, Quantised

__all__ = ["METRES_PER_DEGREE", "carried_bank", "core_steps", "quantised_bank"]

METRES_PER_DEGREE: Final = 111_319.491
"""Of longitude at the equator, on WGS-84: 2π · 6,378,137 m / 360. Nowhere is a degree much longer: one of
latitude is at most 0.4 % longer, at the poles."""


def _field(name: str) -> Field:
    return CORE_FIELDS[CORE_INDEX[name]]


def core_steps(*, position: bool = True) -> CoreSteps:
    """Steps of Part I.

    Parameters
    ----------
    position
        Whether the position is on its grid of 1e-7 degrees. Both axes take the step of the equator; that of
        longitude is smaller elsewhere.

    Examples
    --------
    >>> steps = core_steps()
    >>> steps.speed_mps, round(steps.position_m, 5)
    (0.02, 0.01113)
    """
    speed, heading = _field("speed_mps"), _field("heading_rad")
    acceleration, yaw_rate = _field("acceleration_forward_mps2"), _field("yaw_rate_radps")
    latitude = _field("latitude_deg")
    return CoreSteps(
        speed.resolution,
        acceleration.resolution,
        heading_rad=heading.resolution,
        yaw_rate_radps=yaw_rate.resolution,
        last_speed=speed.known_codes[1],
        last_acceleration=acceleration.known_codes[1],
        last_yaw_rate=yaw_rate.known_codes[1],
        position_m=latitude.step[0] / latitude.step[1] * METRES_PER_DEGREE if position else 0.0,
    )


def carried_bank(bank: Bank) -> Bank:
    """The bank in the forms that messages carry, not rounded: what a receiver predicts with.

    Parameters
    ----------
    bank
        Members that have a layout stay as they are; of the others the predicted path is sent.

    Examples
    --------
    >>> from modelcast.models.gp import GaussianProcess
    >>> carried_bank(Bank((GaussianProcess(),))).parameter_names[3]
    'gp-anchored.east_0_m'
    """
    return replace(bank, members=tuple(carried_form(member) for member in bank.members))


def quantised_bank(bank: Bank) -> Bank:
    """The bank as its receivers hold it.

    Parameters
    ----------
    bank
        Members that are quantised already stay as they are.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> quantised_bank(Bank((ConstantVelocity(),))).parameter_names[-1]
    'cv.remainder_north_m'
    """
    steps = core_steps()
    members = tuple(
        member if isinstance(member, Quantised) else Quantised(carried_form(member), steps)
        for member in bank.members
    )
    return replace(bank, members=members)

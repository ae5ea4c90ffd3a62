"""Model updates between values and wire: what a sender's bank fitted, and what a host can predict with.

Here the local frame of one side meets the latitudes and longitudes of the message, by the bijection of
`modelcast.core.geodesy_kernels`. Sender and host may have frames of their own; in the sender's, a host holds
exactly the position that `geodesy_kernels.stated` says.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modelcast.core.geodesy import Origin, frame_constants
from modelcast.core.geodesy_kernels import (
    CODES_PER_DEGREE,
    FARTHEST_M,
    NO_LATITUDE_CODE,
    place_of,
    state_place,
)
from modelcast.messages.bsm_fields import CORE_INDEX
from modelcast.messages.code_table import code_table
from modelcast.messages.codes_kernels import instant_of
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import ReceivedUpdate, UpdateMessage
from modelcast.messages.mbc_wire import AGE, SEQUENCE, IdentificationMessage
from modelcast.messages.station_codec import StationCodec, UpdateRows, coefficient_codes, further_values
from modelcast.models.bank import Bank

__all__ = [
    "LocalFrame",
    "identification_from_wire",
    "identification_to_wire",
    "update_from_wire",
    "update_to_wire",
]

_NO_PLACE = f"no place within {FARTHEST_M / 1000:.0f} km of the origin, or one at a pole"


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """Where and when the zero of local positions and times is.

    Parameters
    ----------
    origin
        Of local positions.
    minute_s
        Time at which some minute of UTC began [s]: ``secMark`` counts from there, modulo 60 s.
    """

    origin: Origin
    minute_s: float = 0.0


def update_to_wire(
    update: ModelUpdate,
    bank: Bank,
    profile: WireProfile,
    frame: LocalFrame,
    *,
    carries_all: bool,
    core: Mapping[str, float | None] | None = None,
) -> UpdateMessage:
    """Return the message of an update.

    Parameters
    ----------
    update
        What the sender's bank fitted.
    bank
        The sender's, in the forms that messages carry (`Bank.carried`).
    profile
        The bank's.
    frame
        The sender's.
    carries_all
        Whether the coefficients of all sub-models go out, or of the one in use alone.
    core
        More values of Part I, by name: what a message says beside the motion. Acceleration and yaw rate are
        those given here where the bank has none.

    Raises
    ------
    ValueError
        Where bank and profile do not fit, no member has a velocity, the position is too far from the origin,
        or a value cannot be written.
    """
    count = len(bank.members)
    if count != len(profile.layouts):
        raise ValueError(f"bank has {count} sub-models, profile {len(profile.layouts)}")
    latitude_code, longitude_code = state_place(frame_constants(frame.origin), *update.position_m.tolist())
    if latitude_code == NO_LATITUDE_CODE:
        raise ValueError(f"position {update.position_m.tolist()} m: {_NO_PLACE}")
    rows = UpdateRows(
        np.array([update.vehicle]),
        np.array([update.sequence]),
        np.array([update.t_s]),
        place=np.array([[latitude_code, longitude_code]]),
        in_use=np.array([update.in_use]),
        parameters=update.parameters[None],
    )
    codec = StationCodec(profile, code_table(bank), carries_all, (False,) * count, heads=(0,) * count)
    codes = codec.codes(rows, minute_s=frame.minute_s, further=further_values(core or {}))
    return codec.message(codes[0], update.in_use)


def update_from_wire(
    received: ReceivedUpdate, bank: Bank, frame: LocalFrame, *, received_s: float, dt_s: float = 0.1
) -> ModelUpdate:
    """Return the update a host tracks with; a plain message's where it holds no model known here.

    Parameters
    ----------
    received
        As `read_update` gave it.
    bank
        The host's, in the forms that messages carry (`Bank.carried`). Of a model that is not in the message,
        parameters are zero.
    frame
        The host's.
    received_s
        When it arrived [s]: ``secMark`` is taken within half a minute of it.
    dt_s
        Sampling interval [s]. No model that a message can carry predicts by it.

    Raises
    ------
    ValueError
        Where Part I lacks position, instant, speed or heading, the position is too far from the origin, the
        bank holds a model that no message carries, or there is no known model and no member of the bank does
        with Part I.
    """
    for member in bank.members:
        if member.payload_layout is None:
            raise ValueError(f"no message carries {member.name} itself: take the bank's carried form")
    core = received.core
    names = ("second_of_minute_s", "latitude_deg", "longitude_deg", "speed_mps", "heading_rad")
    found = {name: core.value(name) for name in names}
    missing = [name for name, value in found.items() if value is None]
    if missing:
        raise ValueError(f"Part I lacks {', '.join(missing)}: there is nothing to coast from")
    mark, *place = (core.codes[CORE_INDEX[name]] for name in names[:3])
    at_m = place_of(frame_constants(frame.origin), *place)
    if not np.isfinite(at_m).all():
        raise ValueError(f"latitude and longitude {place} / {CODES_PER_DEGREE} deg: {_NO_PLACE}")
    table = code_table(bank)
    codes = np.zeros(len(table.names), np.int64)
    in_use = _coasting(bank) if received.update is None else received.update.sub_model
    if received.update is not None and received.profile is not None:
        codes = coefficient_codes(table, received.profile, received.update)
    return ModelUpdate(
        int(core.value("temporary_id") or 0),
        int(core.value("message_count") or 0),
        instant_of(mark, received_s, frame.minute_s),
        position_m=np.array(at_m),
        in_use=in_use,
        parameters=table.decoded(np.array([core.codes]), codes[None])[0],
        dt_s=dt_s,
    )


def identification_to_wire(
    identification: SubModelIdentification, update: ModelUpdate
) -> IdentificationMessage:
    """Return the message of an identification.

    Parameters
    ----------
    identification
        What the sender decided.
    update
        The update it speaks of.

    Raises
    ------
    ValueError
        Where it is older than that update.
    """
    age_s = identification.t_s - update.t_s
    if age_s < 0:
        raise ValueError(f"an identification follows its update, this one is {-age_s} s older")
    return IdentificationMessage(
        identification.vehicle,
        identification.sequence % (SEQUENCE.high + 1),
        sub_model=identification.in_use,
        age=AGE.code_of(age_s),
    )


def identification_from_wire(message: IdentificationMessage, update: ModelUpdate) -> SubModelIdentification:
    """Return the identification as a host takes it.

    Parameters
    ----------
    message
        As decoded.
    update
        The update that the host holds of this sender; whether it is the one spoken of, the host checks.
    """
    return SubModelIdentification(
        message.temporary_id, message.sequence, update.t_s + message.age_s, in_use=message.sub_model
    )


def _coasting(bank: Bank) -> int:
    """Place of the member that a message without a known model is coasted by."""
    if bank.plain_place < 0:
        raise ValueError(f"{bank.name}: no member does with Part I, as a message without a known model needs")
    return bank.plain_place

"""The model in a basic safety message, read with the profiles held, and as a plain document.

::

    {"profile": "63026a", "held": true, "sub_model": 0, "name": "learned", "carries_all": false,
     "coefficients": {"learned": {"along_0_m": 0.05, ...}}, "predicted_m": {"1": [0.2, 12.3], ...}}

The octets of the coefficients stand in place of the coefficients where the profile is not held. ``held``,
``name`` and ``predicted_m`` say what the message means here; writing takes no notice of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, cast

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin
from modelcast.core.rules import shown
from modelcast.messages.bsm import BsmCore
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.fields import as_float
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import ReceivedUpdate, UpdateMessage, extension_of, read_update
from modelcast.messages.mbc_values import LocalFrame, update_from_wire
from modelcast.messages.mbc_wire import PROFILE_OCTETS, ModelExtension, encode_extension
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.profile import Profile

__all__ = ["HORIZONS_S", "HeldProfile", "ModelReading", "model_document", "octets_of_model", "read_model"]

HORIZONS_S = (1.0, 2.0, 3.0)
"""Ages of the predictions shown [s]."""


@dataclass(frozen=True, slots=True)
class HeldProfile:
    """A profile that is known here.

    Parameters
    ----------
    wire
        Its number and layouts.
    bank
        Its sub-models, in the forms that messages carry.
    """

    wire: WireProfile
    bank: Bank

    @classmethod
    def of(cls, profile: Profile) -> "HeldProfile":
        """What reading needs of a profile.

        Parameters
        ----------
        profile
            The profile.

        Raises
        ------
        ConfigError
            Where messages cannot carry its bank: more than eight sub-models, or too many coefficients.
        """
        try:
            return cls(WireProfile.of_profile(profile), profile.bank.carried())
        except ValueError as error:
            raise ConfigError(f"this profile cannot be used for messages: {error}") from error


@dataclass(frozen=True, slots=True)
class ModelReading:
    """What a receiver makes of the model in a message.

    Parameters
    ----------
    extension
        The model, its coefficients not looked into.
    name
        Name of the sub-model in use, None where the profile is not held.
    coefficients
        Values by sub-model and name; empty where the profile is not held.
    predicted_m
        Displacement east and north at each of `HORIZONS_S`, None where Part I lacks what it takes.
    problem
        Why nothing is predicted.
    """

    extension: ModelExtension
    name: str | None
    _: KW_ONLY
    coefficients: Mapping[str, Mapping[str, float]]
    predicted_m: tuple[tuple[float, float], ...] | None
    problem: str = ""


def read_model(data: bytes, held: Sequence[HeldProfile]) -> ModelReading | None:
    """Read the model in a basic safety message; None where there is none.

    Parameters
    ----------
    data
        The octets of the frame.
    held
        Profiles known here.

    Raises
    ------
    CodecError
        As `read_update`.
    """
    received = read_update(data, {one.wire.number: one.wire for one in held})
    if received.extension is None:
        return None
    name: str | None = None
    coefficients: dict[str, dict[str, float]] = {}
    bank = Bank((ConstantVelocity(),))
    if received.update is not None:
        (found, *_) = [one for one in held if one.wire.number == received.extension.profile]
        bank = found.bank
        name = bank.members[received.update.sub_model].name
        coefficients = _values(received.update, found)
    try:
        predicted_m, problem = _predicted(received, bank), ""
    except ValueError as error:
        predicted_m, problem = None, str(error)
    return ModelReading(
        received.extension, name, coefficients=coefficients, predicted_m=predicted_m, problem=problem
    )


def _values(update: UpdateMessage, held: HeldProfile) -> dict[str, dict[str, float]]:
    members = held.wire.carried(update.sub_model, carries_all=update.carries_all)
    found: dict[str, dict[str, float]] = {}
    for member, codes in zip(members, update.codes, strict=True):
        layout = held.wire.layouts[member]
        values = layout.values_of(np.array([codes], dtype=np.int64).reshape(1, -1))[0].tolist()
        found[held.bank.members[member].name] = dict(zip(layout.names, values, strict=True))
    return found


def _predicted(received: ReceivedUpdate, bank: Bank) -> tuple[tuple[float, float], ...]:
    """Displacements from the position in the message."""
    core = received.core
    place = Origin(core.value("latitude_deg") or 0.0, core.value("longitude_deg") or 0.0, 0.0)
    update = update_from_wire(
        received, bank, LocalFrame(place), received_s=core.value("second_of_minute_s") or 0.0
    )
    parameters = np.array([[update.in_use, *update.parameters]])
    moved = bank.predict(parameters, np.array(HORIZONS_S), dt_s=update.dt_s)[0].tolist()
    if not np.isfinite(moved).all():
        raise ValueError("the model predicts no finite place")
    return tuple((east, north) for east, north in moved)


def model_document(reading: ModelReading) -> dict[str, Any]:
    """Plain values of a model.

    Parameters
    ----------
    reading
        As `read_model` gave it.
    """
    extension = reading.extension
    document: dict[str, Any] = {
        "profile": f"{extension.profile:06x}",
        "held": reading.name is not None,
        "sub_model": extension.sub_model,
        "name": reading.name,
        "carries_all": extension.carries_all,
    }
    if reading.name is None:
        document["octets"] = extension.coefficients.hex()
    else:
        document["coefficients"] = {name: dict(own) for name, own in reading.coefficients.items()}
    predicted = reading.predicted_m
    document["predicted_m"] = predicted and {
        f"{horizon:g}": list(moved) for horizon, moved in zip(HORIZONS_S, predicted, strict=True)
    }
    return document


def octets_of_model(document: object, core: BsmCore, held: Sequence[HeldProfile]) -> bytes:
    """Octets of the extension that a document describes, coefficients rounded to the nearest code.

    Parameters
    ----------
    document
        As `model_document` makes.
    core
        Part I of the message it stands in.
    held
        Profiles known here.

    Raises
    ------
    ValueError
        Where a value is missing or does not fit, or coefficients are of a profile that is not held.
    """
    given = cast("Mapping[str, object]", document if isinstance(document, Mapping) else {})
    profile, sub_model, carries_all = (given.get(name) for name in ("profile", "sub_model", "carries_all"))
    if type(sub_model) is not int or not isinstance(carries_all, bool):
        raise ValueError(
            "a model has profile (6 hexadecimal digits), sub_model (0 to 7) and carries_all (true or false), "
            f"got {shown(profile)}, {shown(sub_model)}, {shown(carries_all)}"
        )
    number = int.from_bytes(octets_of_digits("profile", profile, count=PROFILE_OCTETS), "big")
    octets = given.get("octets")
    if octets is not None:
        if "coefficients" in given:
            raise ValueError("a model has either octets (hexadecimal digits) or coefficients")
        coefficients = octets_of_digits("octets", octets)
        return encode_extension(
            ModelExtension(number, sub_model, carries_all=carries_all, coefficients=coefficients)
        )
    found = next((one for one in held if one.wire.number == number), None)
    if found is None:
        raise ValueError(
            f"profile {profile} is not held, so its coefficients cannot be written: name its file"
        )
    if not 0 <= sub_model < len(found.wire.layouts):
        raise ValueError(f"sub_model must be within 0..{len(found.wire.layouts) - 1}, got {sub_model}")
    members = found.wire.carried(sub_model, carries_all=carries_all)
    codes = _codes(given.get("coefficients"), members, found)
    update = UpdateMessage(core, sub_model, carries_all=carries_all, codes=codes)
    return encode_extension(extension_of(update, found.wire))


def _codes(given: object, members: tuple[int, ...], held: HeldProfile) -> tuple[tuple[int, ...], ...]:
    by_name = cast("Mapping[str, object]", given if isinstance(given, Mapping) else {})
    wanted = [held.bank.members[member].name for member in members]
    if sorted(by_name) != sorted(wanted):
        raise ValueError(f"coefficients are of {', '.join(wanted)}, got {shown(list(by_name))}")
    codes: list[tuple[int, ...]] = []
    for member, name in zip(members, wanted, strict=True):
        layout, own = held.wire.layouts[member], by_name[name]
        values = cast("Mapping[str, object]", own if isinstance(own, Mapping) else {})
        numbers = [
            as_float(value)
            for value in map(values.get, layout.names)
            if isinstance(value, int | float) and not isinstance(value, bool)
        ]
        if set(values) != set(layout.names) or len(numbers) != len(layout.names):
            raise ValueError(
                f"{name} has the numbers {', '.join(layout.names) or 'none'}, got {shown(by_name[name])}"
            )
        row = np.array([numbers], dtype=np.float64).reshape(1, -1)
        codes.append(tuple(layout.codes_of(row)[0].tolist()))
    return tuple(codes)

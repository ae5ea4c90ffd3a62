"""Whether a step can be taken: everything is looked at before anything is done."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.runtime.external.exchange import (
    FOREIGN,
    MOST_FOREIGN_BYTES,
    MOST_RECEPTIONS,
    SessionSettings,
    Step,
)
from modelcast.runtime.external.refusal import FieldError

__all__ = ["MEASURED_BESIDE", "Checked", "checked"]

_IDS = 2**32
_FARTHEST_M = 200_000.0
_LATEST_S = 1e9

_OPTIONAL = {
    "speed_mps": (0.0, 200.0),
    "heading_rad": (-100.0, 100.0),
    "acceleration_mps2": (-200.0, 200.0),
    "yaw_rate_radps": (-100.0, 100.0),
}

MEASURED_BESIDE = tuple(_OPTIONAL)
"""What stations may measure beside their positions."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A step that can be taken, stations by rising id.

    Parameters
    ----------
    t_s, vehicle, position_m, kind, busy_ratio, begins
        As in `Step`, all of them there.
    columns
        What else is measured, by name, (N,) each.
    given
        Names of those; None as long as nobody has measured anything.
    receiver, received_s, message
        As in `Step`.
    is_foreign
        Which messages the session did not send, (K,).
    foreign
        Their octets, in order.
    """

    t_s: float
    vehicle: IntArray
    position_m: FloatArray
    kind: IntArray
    busy_ratio: FloatArray
    begins: BoolArray
    columns: Mapping[str, FloatArray]
    given: tuple[str, ...] | None
    receiver: IntArray
    received_s: FloatArray
    message: IntArray
    is_foreign: BoolArray
    foreign: list[bytes]


def checked(
    step: Step,
    settings: SessionSettings,
    *,
    before: Mapping[int, Kind],
    given: tuple[str, ...] | None,
    last_s: float,
) -> Checked:
    """The step as a session takes it.

    Parameters
    ----------
    step
        As it came.
    settings
        Of the session.
    before
        Who was there at the last step, and of which kind.
    given
        What was measured at the last step; None where there was none.
    last_s
        When that was [s].

    Raises
    ------
    FieldError
        Where a field is not what it must be.
    """
    t_s = step.t_s
    if not (abs(t_s) <= _LATEST_S and t_s > last_s):
        least = f"more than the last, {last_s!r}," if np.isfinite(last_s) else f"from {-_LATEST_S:g}"
        raise FieldError("t_s", t_s, f"{least} and at most {_LATEST_S:g}")
    vehicle = np.asarray(step.vehicle, dtype=np.int64)
    order = np.argsort(vehicle, kind="stable")
    vehicle = vehicle[order]
    _within("vehicle", vehicle, (0, _IDS - 1), vehicle)
    twice = np.flatnonzero(np.diff(vehicle) == 0)
    if twice.size:
        raise FieldError("vehicle", int(vehicle[twice[0]]), "there once, not twice")
    if step.position_m.shape != (vehicle.size, 2):
        raise FieldError("position_m", f"shape {step.position_m.shape}", f"({vehicle.size}, 2)")
    position_m = np.asarray(step.position_m, dtype=np.float64)[order]
    _within("position_m", position_m, (-_FARTHEST_M, _FARTHEST_M), vehicle)
    columns = _columns(step, vehicle, order)
    if not vehicle.size:  # nobody measures anything
        columns = {name: np.empty(0) for name in given or ()}
    elif given is not None and tuple(columns) != given:
        raise FieldError("columns", ", ".join(columns) or "none", f"as before: {', '.join(given) or 'none'}")
    kind = _one_each("kind", step.kind, (0, max(Kind)), vehicle, order).astype(np.int64)
    _check_kinds(vehicle, kind, before, settings)
    return Checked(
        t_s,
        vehicle,
        position_m,
        kind,
        _one_each("busy_ratio", step.busy_ratio, (0.0, 1.0), vehicle, order),
        _one_each("begins", step.begins, (0, 1), vehicle, order) > 0,
        columns,
        tuple(columns) if vehicle.size else given,
        *_receptions(step, before),
    )


def _within(name: str, values: FloatArray | IntArray, least_most: tuple[float, float], who: IntArray) -> None:
    """Refuse a value out of its range, or no number, and name whose it is."""
    least, most = least_most
    wrong = np.argwhere(~((values >= least) & (values <= most)))
    if wrong.size:
        value = values[tuple(wrong[0])]
        raise FieldError(name, f"{value} of {who[wrong[0][0]]}", f"from {least:.10g} to {most:.10g}")


def _columns(step: Step, vehicle: IntArray, order: IntArray) -> dict[str, FloatArray]:
    """What is measured beside positions."""
    return {
        name: _one_each(name, getattr(step, name), least_most, vehicle, order)
        for name, least_most in _OPTIONAL.items()
        if getattr(step, name) is not None
    }


def _one_each(
    name: str,
    given: FloatArray | IntArray | None,
    least_most: tuple[float, float],
    vehicle: IntArray,
    order: IntArray,
) -> FloatArray:
    """A number of each station, in order of ids; zeros where none was given."""
    if given is None:
        return np.zeros(vehicle.size)
    if given.shape != vehicle.shape:
        raise FieldError(name, f"shape {given.shape}", f"({vehicle.size},), one a station")
    values = np.asarray(given, dtype=np.float64)[order]
    _within(name, values, least_most, vehicle)
    return values


def _check_kinds(
    vehicle: IntArray, kind: IntArray, before: Mapping[int, Kind], settings: SessionSettings
) -> None:
    """Refuse stations that become another kind, and more of a kind than there is room for."""
    for one, now in zip(vehicle.tolist(), kind.tolist(), strict=True):
        if before.get(one, now) != now:
            raise FieldError("kind", f"{now} of {one}", f"{int(before[one])}, as before, or an id of its own")
    people = np.isin(kind, PEOPLE)
    most = [("slots", settings.slots, int((~people).sum()))]
    most += [("people_slots", settings.people_slots, int((kind == one).sum())) for one in PEOPLE]
    for name, room, there in most:
        if there > room:
            raise FieldError("vehicle", f"{there} stations", f"at most {room}, the session's {name}")


def _receptions(
    step: Step, before: Mapping[int, Kind]
) -> tuple[IntArray, FloatArray, IntArray, BoolArray, list[bytes]]:
    """Who received what and when, and the octets of foreign messages."""
    receiver = np.asarray(step.receiver, dtype=np.int64)
    received_s = np.asarray(step.received_s, dtype=np.float64)
    message = np.asarray(step.message, dtype=np.int64)
    if receiver.size > MOST_RECEPTIONS:
        raise FieldError("receiver", f"{receiver.size} receptions", f"at most {MOST_RECEPTIONS} in a step")
    for name, column in (("received_s", received_s), ("message", message)):
        if column.shape != receiver.shape:
            raise FieldError(name, f"shape {column.shape}", f"({receiver.size},), one a reception")
    _within("received_s", received_s, (-_LATEST_S, step.t_s), receiver)
    for one in np.unique(receiver).tolist():
        if one not in before:
            raise FieldError("receiver", one, "a station of the last step: it hears from its first step on")
    is_foreign = message == FOREIGN
    length = np.asarray(step.foreign_length, dtype=np.int64)
    if length.shape != (int(is_foreign.sum()),):
        raise FieldError(
            "foreign_length", f"{length.size} lengths", f"{int(is_foreign.sum())}, one a foreign message"
        )
    wrong = length[(length < 1) | (length > MOST_FOREIGN_BYTES)]
    if wrong.size:
        raise FieldError("foreign_length", int(wrong[0]), f"from 1 to {MOST_FOREIGN_BYTES}")
    if length.sum() != len(step.foreign_octets):
        raise FieldError(
            "foreign_octets", f"{len(step.foreign_octets)} octets", f"{int(length.sum())} octets"
        )
    ends = np.cumsum(length).tolist()
    foreign = [step.foreign_octets[end - own : end] for end, own in zip(ends, length.tolist(), strict=True)]
    return receiver, received_s, message, is_foreign, foreign

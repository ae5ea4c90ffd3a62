"""Frames of a bus into quantities, by a DBC file and a map: the one module that imports cantools."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from modelcast.core.exceptions import ConfigError, DataFormatError, MissingExtraError
from modelcast.node.inputs.samples import PLAUSIBLE
from modelcast.node.inputs.signals import Signal, unit_scale

try:
    import cantools
    from cantools.database import Database, Message
except ImportError as error:
    raise MissingExtraError("reading a vehicle's bus", "node") from error

__all__ = ["FrameReader", "Read", "read_frames"]


@dataclass(frozen=True, slots=True)
class Read:
    """What a frame says.

    Parameters
    ----------
    values
        Quantities and their values in SI, clockwise.
    fault
        Why something of it was left out, empty where nothing: "unknown id", "bad frame", "implausible".
    """

    values: tuple[tuple[str, float], ...] = ()
    fault: str = ""


@dataclass(frozen=True, slots=True)
class _Wanted:
    message: Message
    signals: tuple[Signal, ...]


class FrameReader:
    """Reads the frames that hold mapped signals.

    Parameters
    ----------
    database
        Of cantools.
    signals
        What is wanted; scales that are NaN are taken from the DBC's units.

    Raises
    ------
    ConfigError
        Where the DBC lacks a message or signal, or gives a unit that says nothing.
    """

    def __init__(self, database: Database, signals: Sequence[Signal]) -> None:
        self._wanted: dict[tuple[int, bool], _Wanted] = {}
        self._known = {(message.frame_id, message.is_extended_frame) for message in database.messages}
        for signal in signals:
            message = _message(database, signal)
            key = (message.frame_id, message.is_extended_frame)
            others = self._wanted[key].signals if key in self._wanted else ()
            self._wanted[key] = _Wanted(message, (*others, _scaled(message, signal)))

    def read(self, frame_id: int, data: bytes | bytearray, *, extended: bool = False) -> Read:
        """What a frame says.

        Parameters
        ----------
        frame_id
            Its identifier.
        data
            Its octets.
        extended
            Whether the identifier has 29 bits.
        """
        wanted = self._wanted.get((frame_id, extended))
        if wanted is None:
            return Read(fault="" if (frame_id, extended) in self._known else "unknown id")
        try:
            decoded = wanted.message.decode(bytes(data), decode_choices=False)
        except (cantools.Error, ValueError, OverflowError):
            return Read(fault="bad frame")
        if not isinstance(decoded, dict):
            return Read(fault="bad frame")
        return _in_si(wanted.signals, decoded)


def read_frames(dbc: str | Path, signals: Sequence[Signal]) -> FrameReader:
    """A reader for a DBC file.

    Parameters
    ----------
    dbc
        The file. Signals that overlap, as public files have them, are let pass.
    signals
        What is wanted.

    Raises
    ------
    DataFormatError
        Where it is no DBC file.
    ConfigError
        As for `FrameReader`.
    """
    try:
        database = cantools.database.load_file(dbc, database_format="dbc", strict=False)
    except OSError as error:
        raise DataFormatError(str(dbc), f"it cannot be read ({error.strerror})") from error
    except (cantools.Error, ValueError, UnicodeError) as error:
        raise DataFormatError(str(dbc), f"it is no DBC file: {error}") from error
    if not isinstance(database, Database):
        raise DataFormatError(str(dbc), "it describes no frames of a bus")
    return FrameReader(database, signals)


def _message(database: Database, signal: Signal) -> Message:
    """The message that holds a signal."""
    try:
        message = database.get_message_by_name(signal.message)
    except KeyError as error:
        raise ConfigError(
            f"the DBC has no message {signal.message!r}, which {signal.quantity} is read from"
        ) from error
    names = {one.name for one in message.signals}
    for name in (signal.signal, signal.sign):
        if name and name not in names:
            raise ConfigError(
                f"message {signal.message} has no signal {name!r}; it has {', '.join(sorted(names))}"
            )
    return message


def _scaled(message: Message, signal: Signal) -> Signal:
    """A signal whose scale is a number."""
    if not math.isnan(signal.scale):
        return signal
    unit = message.get_signal_by_name(signal.signal).unit or ""
    return Signal(
        quantity=signal.quantity,
        message=signal.message,
        signal=signal.signal,
        sign=signal.sign,
        scale=unit_scale(signal.quantity, unit),
    )


def _in_si(signals: Iterable[Signal], decoded: Mapping[str, object]) -> Read:
    values: list[tuple[str, float]] = []
    fault = ""
    for signal in signals:
        found = decoded.get(signal.signal)
        if not isinstance(found, int | float):  # a multiplexed signal that this frame does not hold
            continue
        value = signal.scale * float(found) * (-1.0 if signal.sign and decoded.get(signal.sign) == 1 else 1.0)
        low, high = PLAUSIBLE[signal.quantity]
        if low <= value <= high:
            values.append((signal.quantity, value))
        else:
            fault = "implausible"
    return Read(tuple(values), fault)

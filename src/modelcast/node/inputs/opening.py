"""Sources from the words of a configuration."""

from collections.abc import Callable

from modelcast.core.exceptions import ConfigError
from modelcast.io.places import readable_kind
from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.gpsd import GpsdSource
from modelcast.node.inputs.line_stream import tcp
from modelcast.node.inputs.nmea import NmeaSource, serial_device
from modelcast.node.inputs.replay import TripReplay, file_and_trip, trip_from
from modelcast.node.inputs.signals import read_signals

__all__ = ["bus_source", "check_gnss_source", "gnss_source"]

_KINDS = frozenset({"gpsd", "nmea", "nmea+tcp", "nmea+file", "trip"})
_FORMS = "gpsd://HOST:PORT, nmea:DEVICE, nmea:DEVICE@BAUD, nmea+tcp://HOST:PORT, nmea+file:FILE or trip:FILE"


def gnss_source(
    text: str, *, now_s: Callable[[], float], utc_at_zero_s: float, times_as_fast: float = 1.0
) -> AbstractSource:
    """The source of fixes that a text names.

    Parameters
    ----------
    text
        ``gpsd://HOST:PORT``, ``nmea:DEVICE`` (``@BAUD`` behind it where it is not 115200), ``nmea+tcp://HOST:PORT``,
        and two that are driven again from now on: ``nmea+file:FILE`` and ``trip:FILE`` (`trip_from`).
    now_s
        The node's clock [s].
    utc_at_zero_s
        UTC at its 0 [s].
    times_as_fast
        Pace of a trip driven again.

    Raises
    ------
    ConfigError
        Where it names none, or no trip.
    DataFormatError
        Where a file is not what its format says.
    MissingExtraError
        Where a device is named and pyserial is not installed.

    Examples
    --------
    >>> type(gnss_source("gpsd://[::1]:2947", now_s=lambda: 0.0, utc_at_zero_s=0.0)).__name__
    'GpsdSource'
    """
    check_gnss_source(text)
    kind, _, rest = text.partition(":")
    if kind == "gpsd":
        return GpsdSource(*_peer(text, rest), now_s=now_s, utc_at_zero_s=utc_at_zero_s)
    if kind == "nmea+tcp":
        return NmeaSource(tcp(*_peer(text, rest)), now_s=now_s, utc_at_zero_s=utc_at_zero_s)
    if kind == "nmea":
        device, _, baud = rest.partition("@")
        connect = serial_device(device, int(baud or 115_200))
        return NmeaSource(connect, now_s=now_s, utc_at_zero_s=utc_at_zero_s)
    trip = trip_from(rest, format_name="nmea" if kind == "nmea+file" else None)
    return TripReplay(trip, begin_s=now_s(), times_as_fast=times_as_fast)


def check_gnss_source(text: str) -> None:
    """Refuse what names no source of fixes; nothing is opened.

    Parameters
    ----------
    text
        As for `gnss_source`.

    Raises
    ------
    ConfigError
        Where it has no such form.
    DataFormatError
        Where it names a file that is none.
    """
    kind, _, rest = text.partition(":")
    if kind not in _KINDS or not (rest or kind == "gpsd"):
        raise ConfigError(f"{text!r} is no source of fixes: write {_FORMS}")
    if kind in {"gpsd", "nmea+tcp"}:
        _peer(text, rest)
    elif kind == "nmea":
        baud = rest.partition("@")[2]
        if baud and not baud.isdecimal():
            raise ConfigError(f"{baud!r} in {text!r} is no speed of a serial line, as 115200 is")
    else:
        readable_kind(file_and_trip(rest)[0])


def bus_source(
    *, interface: str, channel: str, dbc: str, signals: str, now_s: Callable[[], float]
) -> AbstractSource:
    """A vehicle's bus.

    Parameters
    ----------
    interface, channel
        As python-can names them.
    dbc
        File that says what the frames hold.
    signals
        A preset or a map (`modelcast.node.inputs.signals`).
    now_s
        The node's clock [s].

    Raises
    ------
    ConfigError
        Where interface, map or names in it are unknown.
    DataFormatError
        Where the file is no DBC.
    MissingExtraError
        Where python-can or cantools is not installed.
    """
    from modelcast.node.inputs.can_bus import CanSource, bus_by_name  # noqa: PLC0415 - the extra is needed here
    from modelcast.node.inputs.frames import read_frames  # noqa: PLC0415

    opened = bus_by_name(interface, channel)
    return CanSource(opened, read_frames(dbc, read_signals(signals)), now_s=now_s)


def _peer(text: str, rest: str) -> tuple[str, int]:
    """Host and port behind two slashes."""
    host, _, port = rest.removeprefix("//").rpartition(":")
    if not rest.startswith("//") or not host or not port.isdecimal() or not 0 < int(port) < 65_536:
        raise ConfigError(f"{text!r} names no peer: write host and port, as in gpsd://127.0.0.1:2947")
    return host.strip("[]"), int(port)

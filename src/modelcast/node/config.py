"""What a node is asked to be: its configuration file, checked before anything starts."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from modelcast.apps.registry import APPLICATIONS
from modelcast.core.kinds import Kind
from modelcast.core.named_in import NamedIn
from modelcast.core.rules import Each, Flag, Maybe, Number, Text, Whole, check_fields
from modelcast.node.multicast import GROUP, LOOPBACK, PORT
from modelcast.node.toml_file import read_tables
from modelcast.station.sender.names import POLICIES, check_sender

__all__ = [
    "DEFAULT_BANK",
    "PEOPLE_BANK",
    "Air",
    "Applications",
    "Can",
    "Gnss",
    "Metrics",
    "NodeConfig",
    "Page",
    "Pseudonyms",
    "Record",
    "Roadside",
    "Security",
    "Sending",
    "Station",
    "Subscribe",
    "Vehicle",
    "read_config",
]

DEFAULT_BANK = "default"
"""The bank that nobody chose."""

PEOPLE_BANK = "people"
"""What that is for people: the shipped profile of people."""

_KINDS = {
    "vehicle": Kind.VEHICLE,
    "pedestrian": Kind.PEDESTRIAN,
    "cyclist": Kind.CYCLIST,
    "roadworker": Kind.ROAD_WORKER,
}
_Address = Annotated[str, Text(45)]
_Port = Annotated[int, Whole(0, 65535)]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Table:
    """A table of the file: its fields are what their rules say."""

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Station(_Table):
    """What kind of road user is on the air.

    Parameters
    ----------
    kind
        ``vehicle``; or ``pedestrian``, ``cyclist`` or ``roadworker``: a device that a person carries. It
        speaks personal safety messages, and warns of vehicles.
    """

    kind: Annotated[str, Text(choices=tuple(_KINDS))] = "vehicle"

    @property
    def speaks(self) -> Kind:
        """The kind whose messages it speaks."""
        return _KINDS[self.kind]


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle(_Table):
    """Who is on the air.

    Parameters
    ----------
    length_m, width_m
        Of the vehicle; people have the sizes of their kind [m].
    name
        For logs and the page; never sent.
    """

    length_m: Annotated[float, Number(0.0, 40.95, over=True)] = 4.6
    width_m: Annotated[float, Number(0.0, 10.23, over=True)] = 1.8
    name: Annotated[str, Text(60)] = "node"


@dataclass(frozen=True, slots=True, kw_only=True)
class Sending(_Table):
    """What is sent, and when.

    Parameters
    ----------
    policy
        A name of `modelcast.station.sender.names.SENDERS`, or a policy of another package, as ``NAME`` or
        ``NAME:KEY=VALUE,KEY=VALUE``.
    bank, profile
        As for ``modelcast evaluate``; an empty profile for the shipped one, whose sub-models are those of
        vehicles: ``default`` is ``people`` for people.
    threshold_m
        Of error-driven policies [m].
    keep_alive_s
        Their longest silence [s].
    tick_s
        Time between measurements [s].
    """

    policy: Annotated[str, NamedIn(POLICIES, check_sender)] = "mbc"
    bank: Annotated[str, Text(400)] = DEFAULT_BANK
    profile: Annotated[str, Text(400, empty=True)] = ""
    threshold_m: Annotated[float, Number(0.0, 100.0, over=True)] = 0.2
    keep_alive_s: Annotated[float, Number(0.0, 60.0, over=True)] = 1.0
    tick_s: Annotated[float, Number(0.05, 1.0)] = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Gnss(_Table):
    """Where places come from.

    Parameters
    ----------
    source
        ``gpsd://HOST:PORT``, ``nmea:DEVICE``, ``nmea+tcp://HOST:PORT``, ``nmea+file:FILE``, or
        ``trip:FILE`` with a recorded trip.
    speed
        How many times as fast a recorded trip is driven.
    stale_s
        Longest age of a fix that is used, whatever its period [s].
    dead_reckoning_s
        How long a place may be reckoned from the vehicle's bus alone [s]; then the node falls silent.
    latitude_deg, longitude_deg
        Where the map's plane begins, both or none: near where the vehicle is, so that the node hears before
        it knows its own place [deg].
    """

    source: Annotated[str, Text(400)] = "gpsd://127.0.0.1:2947"
    speed: Annotated[float, Number(0.0, 1000.0, over=True)] = 1.0
    stale_s: Annotated[float, Number(0.0, 10.0, over=True)] = 1.0
    dead_reckoning_s: Annotated[float, Number(0.0, 120.0)] = 5.0
    latitude_deg: Annotated[float | None, Maybe(Number(-90.0, 90.0))] = None
    longitude_deg: Annotated[float | None, Maybe(Number(-180.0, 180.0))] = None

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.latitude_deg is None) != (self.longitude_deg is None):
            raise ValueError("latitude_deg and longitude_deg are given both or not at all")


@dataclass(frozen=True, slots=True, kw_only=True)
class Can(_Table):
    """The vehicle's bus; none where no interface is named.

    Parameters
    ----------
    interface, channel
        As python-can names them: ``socketcan`` and ``can0``, ``udp_multicast`` and a group, ``virtual``.
    dbc
        File that says what the frames hold.
    signals
        A preset by name, or pairs ``meaning=Message.Signal`` separated by commas.
    """

    interface: Annotated[str, Text(60, empty=True)] = ""
    channel: Annotated[str, Text(60, empty=True)] = ""
    dbc: Annotated[str, Text(400, empty=True)] = ""
    signals: Annotated[str, Text(400, empty=True)] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Air(_Table):
    """How frames leave.

    Parameters
    ----------
    transport
        ``multicast``, or a name that another package registers in ``modelcast.transports``.
    group, port, interface, hops
        As for `modelcast.node.multicast.MulticastTransport`.
    loss_ratio
        Share of the frames that are thrown away as they arrive, to try losses.
    """

    transport: Annotated[str, Text(60)] = "multicast"
    group: _Address = GROUP
    port: Annotated[int, Whole(1, 65535)] = PORT
    interface: _Address = LOOPBACK
    hops: Annotated[int, Whole(0, 255)] = 1
    loss_ratio: Annotated[float, Number(0.0, 1.0)] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Security(_Table):
    """Whether messages are signed.

    Parameters
    ----------
    mode
        ``none``: nothing is signed or verified. ``signed``: what is sent is signed, what is heard verified.
    folder
        With keys and certificates, as ``modelcast credentials new`` makes it.
    required
        Whether what is not verified is refused.
    """

    mode: Annotated[str, Text(choices=("none", "signed"))] = "none"
    folder: Annotated[str, Text(400, empty=True)] = ""
    required: Annotated[bool, Flag()] = True

    def __post_init__(self) -> None:
        check_fields(self)
        if self.mode == "signed" and not self.folder:
            raise ValueError("folder must name credentials where mode is 'signed': modelcast credentials new")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pseudonyms(_Table):
    """When everything that names the vehicle changes together.

    Parameters
    ----------
    least_s, most_s
        Between two changes, evenly drawn [s]; 0 and 0 for never.
    """

    least_s: Annotated[float, Number(0.0, 86_400.0)] = 300.0
    most_s: Annotated[float, Number(0.0, 86_400.0)] = 900.0

    def __post_init__(self) -> None:
        check_fields(self)
        if self.least_s > self.most_s:
            raise ValueError(f"least_s must not be above most_s, got {self.least_s} and {self.most_s}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Applications(_Table):
    """What the host warns of.

    Parameters
    ----------
    names
        Of `modelcast.apps.registry`, ours and those of other packages, each ``NAME`` or
        ``NAME:KEY=VALUE,KEY=VALUE``. A person's device has those that are made for people, of ours ``vru``
        alone.
    """

    names: Annotated[tuple[str, ...], Each(NamedIn(APPLICATIONS), 0, 32)] = tuple(APPLICATIONS.own)


@dataclass(frozen=True, slots=True, kw_only=True)
class Page(_Table):
    """The live page.

    Parameters
    ----------
    on
        Whether there is one.
    host, port
        Where it listens; port 0 for any that is free.
    token
        What a browser must show; needed wherever the host is not this machine.
    """

    on: Annotated[bool, Flag()] = False
    host: _Address = LOOPBACK
    port: _Port = 8700
    token: Annotated[str, Text(200, empty=True)] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Metrics(_Table):
    """Figures for Prometheus; none where the port is 0.

    Parameters
    ----------
    host, port
        Where it listens.
    """

    host: _Address = LOOPBACK
    port: _Port = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Roadside(_Table):
    """A fixed unit at the roadside instead of a vehicle: it hears, keeps the map, and may relay.

    Parameters
    ----------
    on
        Whether the node is one: it then reads no gnss and no can, and sends nothing of its own.
    latitude_deg, longitude_deg
        Where it stands [deg].
    antenna_m
        Height of its antenna over the road, for the page and whoever asks [m].
    relay
        Repeat unchanged what it heard, once, within its own envelope.
    relay_rate_hz, relay_within_m, relay_age_s
        At most so many a second, of vehicles so near, so young.
    """

    on: Annotated[bool, Flag()] = False
    latitude_deg: Annotated[float, Number(-90.0, 90.0)] = 0.0
    longitude_deg: Annotated[float, Number(-180.0, 180.0)] = 0.0
    antenna_m: Annotated[float, Number(0.0, 100.0)] = 6.0
    relay: Annotated[bool, Flag()] = False
    relay_rate_hz: Annotated[float, Number(0.0, 10_000.0, over=True)] = 200.0
    relay_within_m: Annotated[float, Number(0.0, 10_000.0, over=True)] = 200.0
    relay_age_s: Annotated[float, Number(0.0, 10.0, over=True)] = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscribe(_Table):
    """The map for other programs, as lines of JSON; none where the path is empty.

    Parameters
    ----------
    path
        Of a local socket, which only the user of the node may open.
    """

    path: Annotated[str, Text(100, empty=True)] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Record(_Table):
    """What is written down of all that the node does; nothing where no folder is named.

    Parameters
    ----------
    folder
        Where recordings go, a pair of files each; it is made where it is not there.
    most_mb
        Of all recordings in the folder, those of before included [10^6 octets].
    """

    folder: Annotated[str, Text(400, empty=True)] = ""
    most_mb: Annotated[float, Number(0.0, 1e7, over=True)] = 2000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeConfig:
    """A node's configuration, a table each.

    Examples
    --------
    >>> NodeConfig().air.interface
    '127.0.0.1'
    """

    station: Station = field(default_factory=Station)
    vehicle: Vehicle = field(default_factory=Vehicle)
    sending: Sending = field(default_factory=Sending)
    gnss: Gnss = field(default_factory=Gnss)
    can: Can = field(default_factory=Can)
    air: Air = field(default_factory=Air)
    security: Security = field(default_factory=Security)
    pseudonyms: Pseudonyms = field(default_factory=Pseudonyms)
    applications: Applications = field(default_factory=Applications)
    page: Page = field(default_factory=Page)
    metrics: Metrics = field(default_factory=Metrics)
    roadside: Roadside = field(default_factory=Roadside)
    subscribe: Subscribe = field(default_factory=Subscribe)
    record: Record = field(default_factory=Record)

    def __post_init__(self) -> None:
        if self.roadside.on and self.station.kind != "vehicle":
            raise ValueError(
                f"[roadside] on is a unit that nobody carries, and [station] kind is {self.station.kind!r}"
            )


def read_config(path: str | Path) -> NodeConfig:
    """Read a node's configuration.

    Parameters
    ----------
    path
        A TOML file with the tables of `NodeConfig`; what is left out has its default.

    Raises
    ------
    DataFormatError
        Where it holds what is not known or not allowed; it names line and remedy.
    """
    return read_tables(path, NodeConfig)

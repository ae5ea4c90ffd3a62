"""What another simulator and a session tell one another: requests and answers as arrays, a row each.

Names, units and dtypes are those of the wire (`docs/serve.md`). This module needs nothing but NumPy.
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.runtime.external.refusal import FieldError

__all__ = [
    "FOREIGN",
    "MOST_APPLICATIONS",
    "MOST_FOREIGN_BYTES",
    "MOST_KEPT",
    "MOST_RECEPTIONS",
    "MOST_SLOTS",
    "MOST_TRACKS",
    "HostBeliefs",
    "HostWarnings",
    "Sent",
    "SessionSettings",
    "Step",
]

FOREIGN = -1
"""Number of a message that the session did not send: its octets come along."""

MOST_SLOTS = 10_000
"""Stations of one kind in a session."""

MOST_TRACKS = 2**21
"""Stations of a session times remotes that each has room for: about a gigabyte when all are heard."""

MOST_RECEPTIONS = 2**20
"""Receptions in one step."""

MOST_FOREIGN_BYTES = 4096
"""Octets of one foreign message; no radio of this kind carries as many."""

MOST_KEPT = 2**20
"""Messages that can be named: where 10,000 stations send ten a second those of 10 s, else the newest."""

MOST_APPLICATIONS = 32
"""Safety applications in one request."""

_RANGES: dict[str, tuple[float, float]] = {
    "slots": (1, MOST_SLOTS),
    "people_slots": (0, MOST_SLOTS),
    "dt_s": (0.001, 10.0),
    "latitude_deg": (-89.0, 89.0),
    "longitude_deg": (-180.0, 180.0),
    "altitude_m": (-1000.0, 10_000.0),
    "seed": (0, 2**63 - 1),
    "minute_s": (-1e9, 1e9),
    "spread_s": (0.0, 60.0),
    "capacity": (1, 2**15 - 1),
    "threshold_m": (0.001, 100.0),
    "keep_alive_s": (0.01, 3600.0),
}


def _no_ids() -> IntArray:
    return np.empty(0, dtype=np.int64)


def _no_numbers() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, slots=True)
class SessionSettings:
    """What a session is begun with.

    Parameters
    ----------
    slots
        Most vehicles and roadside units at a time, 1 to 10,000.
    sender
        What every station sends, and when: a name of `modelcast.station.sender.sender.SENDERS`.
    people_slots
        Most people of each kind at a time.
    dt_s
        Time between steps [s].
    latitude_deg, longitude_deg, altitude_m
        Where the plane of positions touches the Earth.
    seed
        Of all random numbers.
    minute_s
        Time at which some minute of UTC began [s].
    spread_s
        New stations of the first step begin to send within this time [s].
    capacity
        Remotes that each station has room for.
    threshold_m, keep_alive_s
        Error that calls for a message, and longest silence, of the senders that know them [m], [s].

    Raises
    ------
    FieldError
        Where a number is out of its range.
    """

    slots: int
    _: KW_ONLY
    sender: str = "mbc"
    people_slots: int = 0
    dt_s: float = 0.1
    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    altitude_m: float = 0.0
    seed: int = 0
    minute_s: float = 0.0
    spread_s: float = 0.0
    capacity: int = 500
    threshold_m: float = 0.2
    keep_alive_s: float = 1.0

    def __post_init__(self) -> None:
        for name, (least, most) in _RANGES.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise FieldError(name, value, f"from {least:g} to {most:g}")
        tracks = (self.slots + 3 * self.people_slots) * self.capacity
        if tracks > MOST_TRACKS:
            raise FieldError(
                "capacity",
                self.capacity,
                f"at most {MOST_TRACKS // (self.slots + 3 * self.people_slots)} for so many slots: "
                f"a session holds {MOST_TRACKS} tracks",
            )


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """All stations at one time, and what was received since the last step.

    Parameters
    ----------
    t_s
        Now, later than at the last step [s].
    vehicle
        Temporary ids of all that are there, each once, (N,); who is missing has left.
    position_m
        East and north, (N, 2) [m].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        (N,) each or None, heading and yaw rate clockwise; the same ones in every step.
    busy_ratio
        Channel busy ratio as each radio measured it, (N,); None for a free channel.
    kind
        Values of `modelcast.core.kinds.Kind`, (N,); None where all are vehicles. Roadside units hear and
        keep a map, and send nothing.
    begins
        Whose measurement does not connect with those before, (N,), as after a jump; None for nobody's.
    receiver
        Who received, (K,).
    received_s
        When, not after now, (K,) [s].
    message
        What: the number that `Sent` gave it, or `FOREIGN`, (K,).
    foreign_length
        Octets of each foreign message, in the order of its rows, (F,).
    foreign_octets
        All of them.
    """

    t_s: float
    vehicle: IntArray
    _: KW_ONLY
    position_m: FloatArray
    speed_mps: FloatArray | None = None
    heading_rad: FloatArray | None = None
    acceleration_mps2: FloatArray | None = None
    yaw_rate_radps: FloatArray | None = None
    busy_ratio: FloatArray | None = None
    kind: IntArray | None = None
    begins: IntArray | None = None
    receiver: IntArray = field(default_factory=_no_ids)
    received_s: FloatArray = field(default_factory=_no_numbers)
    message: IntArray = field(default_factory=_no_ids)
    foreign_length: IntArray = field(default_factory=_no_ids)
    foreign_octets: bytes = b""


@dataclass(frozen=True, slots=True, eq=False)
class Sent:
    """What stations send until the next step, in order of time, and what became of receptions.

    Parameters
    ----------
    t_s
        Of the step [s].
    message
        Number of each message in this session, (M,); receptions name it.
    vehicle
        Who sends it, (M,).
    send_s
        When it is to be handed to the radio, (M,) [s].
    frame_bytes
        On the air, security header and lower layers counted, (M,).
    power_dbm
        Transmit power, (M,) [dBm].
    priority
        0, the most urgent, to 7, as ProSe per-packet priorities count, (M,).
    next_s
        When the sender expects its next message, infinite where it does not know: the hint for a radio that
        reserves resources, (M,) [s].
    grant
        Which `modelcast.channel.radio.Grant` it asks for, (M,).
    kind
        `modelcast.station.policy.base.MessageKind`, (M,).
    length
        Octets of each message, without security header and lower layers, (M,).
    octets
        All of them.
    receipt
        What became of each reception of the step, values of
        `modelcast.station.receiver.local_dynamic_map.Receipt`, (K,).
    left
        Who was there before and is no more, rising, (L,).
    """

    t_s: float
    message: IntArray
    _: KW_ONLY
    vehicle: IntArray
    send_s: FloatArray
    frame_bytes: IntArray
    power_dbm: FloatArray
    priority: IntArray
    next_s: FloatArray
    grant: IntArray
    kind: IntArray
    length: IntArray
    octets: bytes
    receipt: IntArray
    left: IntArray

    def frames(self) -> list[bytes]:
        """The octets of each message, M."""
        ends = np.cumsum(self.length).tolist()
        return [
            self.octets[end - length : end] for end, length in zip(ends, self.length.tolist(), strict=True)
        ]


@dataclass(frozen=True, slots=True, eq=False)
class HostBeliefs:
    """What hosts believe of their remotes at one time, host after host as asked, remotes by rising id.

    Parameters
    ----------
    t_s
        The time [s].
    host
        Whose belief a row is, (B,).
    vehicle
        Temporary id of the remote, (B,).
    position_m, velocity_mps, speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        As in `modelcast.station.receiver.local_dynamic_map.Beliefs`, and so are the others.
    covariance_m2, information_age_s, received_s, kind, length_m, width_m
        (B, 2, 2), and (B,) each.
    """

    t_s: float
    host: IntArray
    _: KW_ONLY
    vehicle: IntArray
    position_m: FloatArray
    velocity_mps: FloatArray
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    covariance_m2: FloatArray
    information_age_s: FloatArray
    received_s: FloatArray
    kind: IntArray
    length_m: FloatArray
    width_m: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class HostWarnings:
    """What safety applications say at the newest step: pairs with a level above none.

    Parameters
    ----------
    t_s
        Of the step [s].
    host, vehicle
        Who is warned, and of which remote, (W,).
    application
        Which of the applications asked for, from 0, (W,).
    level, time_s, margin_m, certainty
        As in `modelcast.apps.warnings.Warnings`, (W,).
    """

    t_s: float
    host: IntArray
    _: KW_ONLY
    vehicle: IntArray
    application: IntArray
    level: IntArray
    time_s: FloatArray
    margin_m: FloatArray
    certainty: FloatArray

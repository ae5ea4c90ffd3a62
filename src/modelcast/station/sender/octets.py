"""What a station puts on the air as octets: of messages that any runtime made, the same bytes."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import Origin, frame_constants
from modelcast.core.geodesy_kernels import state_places
from modelcast.core.kinds import Kind
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.station_codec import IdentificationRows, StationCodec, UpdateRows
from modelcast.models.bank import Bank
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION
from modelcast.station.sender.message_arrays import (
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_KIND,
    CONTENT_MEMBER,
    CONTENT_NAMED_S,
    CONTENT_NORTH_M,
    CONTENT_UPDATE,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    Contents,
)
from modelcast.station.sender.posting_kernels import SendingStations
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS

__all__ = ["SentMessages", "StationOctets", "messages_of"]


@dataclass(frozen=True, slots=True, eq=False)
class SentMessages:
    """N messages of any stations.

    Parameters
    ----------
    kind
        `modelcast.station.policy.base.MessageKind` of each, (N,).
    number
        Its number among its station's messages, (N,).
    vehicle
        Temporary id of its station, (N,).
    t_s
        Instant of the sample it was decided at, (N,) [s].
    sample
        That sample, (N, 9).
    stated_m
        Position that the update states, or the update that is named, (N, 2) [m].
    in_use
        Sub-model in use, (N,).
    parameters
        Of all members in turn as receivers hold them, (N, P); zeros where a member was not fitted.
    update
        Number of the update that it is or names, (N,).
    fit_s
        Instant of that update, (N,) [s].
    """

    kind: IntArray
    number: IntArray
    _: KW_ONLY
    vehicle: IntArray
    t_s: FloatArray
    sample: FloatArray
    stated_m: FloatArray
    in_use: IntArray
    parameters: FloatArray
    update: IntArray
    fit_s: FloatArray


def messages_of(
    stations: SendingStations, contents: Contents, slot: IntArray, number: IntArray
) -> SentMessages:
    """Return messages that stations have just sent, from their rings.

    Parameters
    ----------
    stations, contents
        Of all stations.
    slot, number
        Whose messages, and which, (N,) each.
    """
    rows = contents.rows[slot, number % MESSAGES_KEPT]
    offsets = stations.models.members.offsets
    member = rows[:, CONTENT_MEMBER].astype(np.int64) - stations.numbers.first_member
    count = int(offsets[-1])
    parameters = np.zeros((slot.size, count))
    if stations.numbers.carries_all:
        parameters[:] = rows[:, CONTENT_HEAD : CONTENT_HEAD + count]
    else:
        for m in np.unique(member):
            own, width = member == m, int(offsets[m + 1] - offsets[m])
            parameters[own, offsets[m] : offsets[m + 1]] = rows[own, CONTENT_HEAD : CONTENT_HEAD + width]
    sensed = stations.sensed
    newest = (sensed.taken[slot] - 1) % sensed.stated_m.shape[1]
    return SentMessages(
        rows[:, CONTENT_KIND].astype(np.int64),
        number,
        vehicle=rows[:, CONTENT_VEHICLE].astype(np.int64),
        t_s=rows[:, CONTENT_NAMED_S],
        sample=sensed.samples[slot, newest],
        stated_m=rows[:, [CONTENT_EAST_M, CONTENT_NORTH_M]],
        in_use=member,
        parameters=parameters,
        update=rows[:, CONTENT_UPDATE].astype(np.int64),
        fit_s=rows[:, CONTENT_FIT_S],
    )


@dataclass(frozen=True, slots=True, eq=False)
class StationOctets:
    """Writes the messages of stations that share a bank and rules.

    Parameters
    ----------
    codec
        Of their bank and rules.
    origin
        Of the plane they measure positions on.
    minute_s
        Time at which some minute of UTC began [s].
    """

    codec: StationCodec
    origin: Origin
    minute_s: float = 0.0

    @classmethod
    def of(
        cls,
        bank: Bank,
        number: int,
        identify: str,
        origin: Origin,
        *,
        minute_s: float = 0.0,
        kind: Kind = Kind.VEHICLE,
    ) -> "StationOctets":
        """Return the writer of a bank's messages.

        Parameters
        ----------
        bank
            The stations', completed.
        number
            Number of its profile.
        identify
            The policy's rule.
        origin, minute_s
            As in `StationOctets`.
        kind
            Of the stations.
        """
        return cls(StationCodec.of(bank, number, identify, kind=kind), origin, minute_s)

    def encode(self, messages: SentMessages) -> list[bytes]:
        """Octets of messages, one frame each.

        Parameters
        ----------
        messages
            The messages.

        Raises
        ------
        ValueError
            Where a value cannot be written.
        """
        found = [b""] * messages.kind.size
        named = messages.kind == IDENTIFICATION
        for rows, encode in ((np.flatnonzero(~named), self._updates), (np.flatnonzero(named), self._named)):
            if rows.size:
                for row, octets in zip(rows.tolist(), encode(messages, rows), strict=True):
                    found[row] = octets
        return found

    def _updates(self, messages: SentMessages, rows: IntArray) -> list[bytes]:
        place = np.empty((rows.size, 2), dtype=np.int64)
        state_places(frame_constants(self.origin), np.ascontiguousarray(messages.stated_m[rows]), place)
        frames, lengths = self.codec.encode(
            UpdateRows(
                messages.vehicle[rows],
                messages.number[rows],
                messages.t_s[rows],
                place=place,
                in_use=messages.in_use[rows],
                parameters=messages.parameters[rows],
            ),
            minute_s=self.minute_s,
            further=_motion(messages.sample[rows]),
        )
        return [frame[:length].tobytes() for frame, length in zip(frames, lengths.tolist(), strict=True)]

    def _named(self, messages: SentMessages, rows: IntArray) -> list[bytes]:
        frames = IdentificationRows(
            messages.vehicle[rows],
            messages.update[rows],
            in_use=messages.in_use[rows],
            age_s=messages.t_s[rows] - messages.fit_s[rows],
        ).encode()
        return [frame.tobytes() for frame in frames]


def _motion(samples: FloatArray) -> FloatArray:
    """Part I's motion of samples, in SI units, (N, 25): what no sub-model has stands there all the same."""
    values = np.full((samples.shape[0], len(CORE_FIELDS)), np.nan)
    east, north = samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]
    speed = np.hypot(east, north)
    values[:, CORE_INDEX["speed_mps"]] = speed
    moves = speed >= NO_RATES_BELOW_MPS
    values[:, CORE_INDEX["heading_rad"]] = np.where(moves, np.arctan2(east, north), 0.0)
    values[:, CORE_INDEX["acceleration_forward_mps2"]] = samples[:, ACCELERATION]
    values[:, CORE_INDEX["yaw_rate_radps"]] = samples[:, YAW_RATE]
    return values

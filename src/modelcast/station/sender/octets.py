"""What a station puts on the air as octets: of messages that any runtime made, the same bytes."""

from dataclasses import KW_ONLY, dataclass
from math import hypot

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.geodesy import Origin, frame_constants
from modelcast.core.geodesy_kernels import state_places
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
    MESSAGES_KEPT,
    Contents,
)
from modelcast.station.sender.sending_kernels import SendingStations
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS

__all__ = ["SentMessages", "StationOctets", "message_of"]


@dataclass(frozen=True, slots=True, eq=False)
class SentMessages:
    """N messages of one station, in order.

    Parameters
    ----------
    kind
        `modelcast.station.policy.base.MessageKind` of each, (N,).
    number
        Its number among the station's messages, (N,).
    t_s
        Instant of the sample it was decided at, (N,) [s].
    sample
        That sample, (N, 7).
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
    t_s: FloatArray
    sample: FloatArray
    stated_m: FloatArray
    in_use: IntArray
    parameters: FloatArray
    update: IntArray
    fit_s: FloatArray


def message_of(stations: SendingStations, contents: Contents, slot: int, number: int) -> SentMessages:
    """Return a message of a station that was just sent, from its ring.

    Parameters
    ----------
    stations, contents
        Of all stations.
    slot, number
        Whose message, and which.
    """
    row = contents.rows[slot, number % MESSAGES_KEPT]
    offsets, member = stations.models.members.offsets, int(row[CONTENT_MEMBER])
    parameters = np.zeros(int(offsets[-1]))
    own = slice(int(offsets[member]), int(offsets[member + 1]))
    if stations.numbers.carries_all:
        own = slice(0, parameters.size)
    parameters[own] = row[CONTENT_HEAD : CONTENT_HEAD + own.stop - own.start]
    sensed = stations.sensed
    newest = (int(sensed.taken[slot]) - 1) % sensed.stated_m.shape[1]
    return SentMessages(
        np.array([int(row[CONTENT_KIND])]),
        np.array([number]),
        t_s=row[CONTENT_NAMED_S : CONTENT_NAMED_S + 1].copy(),
        sample=sensed.samples[slot, newest][None].copy(),
        stated_m=row[[CONTENT_EAST_M, CONTENT_NORTH_M]][None],
        in_use=np.array([member]),
        parameters=parameters[None],
        update=np.array([int(row[CONTENT_UPDATE])]),
        fit_s=row[CONTENT_FIT_S : CONTENT_FIT_S + 1].copy(),
    )


@dataclass(frozen=True, slots=True, eq=False)
class StationOctets:
    """Writes the messages of one station.

    Parameters
    ----------
    codec
        Of its bank and rules.
    origin
        Of the plane it measures positions on.
    temporary_id
        Of the station.
    minute_s
        Time at which some minute of UTC began [s].
    """

    codec: StationCodec
    origin: Origin
    temporary_id: int
    minute_s: float = 0.0

    @classmethod
    def of(
        cls,
        bank: Bank,
        number: int,
        identify: str,
        origin: Origin,
        temporary_id: int,
        *,
        minute_s: float = 0.0,
    ) -> "StationOctets":
        """Return the writer of a bank's messages.

        Parameters
        ----------
        bank
            The station's, completed.
        number
            Number of its profile.
        identify
            The policy's rule.
        origin, temporary_id, minute_s
            As in `StationOctets`.
        """
        return cls(StationCodec.of(bank, number, identify), origin, temporary_id, minute_s)

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
                np.full(rows.size, self.temporary_id),
                messages.number[rows],
                messages.t_s[rows],
                place=place,
                in_use=messages.in_use[rows],
                parameters=messages.parameters[rows],
            ),
            minute_s=self.minute_s,
            further=np.stack([_motion(sample) for sample in messages.sample[rows]]),
        )
        return [frame[:length].tobytes() for frame, length in zip(frames, lengths.tolist(), strict=True)]

    def _named(self, messages: SentMessages, rows: IntArray) -> list[bytes]:
        frames = IdentificationRows(
            np.full(rows.size, self.temporary_id),
            messages.update[rows],
            in_use=messages.in_use[rows],
            age_s=messages.t_s[rows] - messages.fit_s[rows],
        ).encode()
        return [frame.tobytes() for frame in frames]


def _motion(sample: FloatArray) -> FloatArray:
    """Part I's motion of a sample, in SI units, (25,): what no sub-model has stands there all the same."""
    values = np.full(len(CORE_FIELDS), np.nan)
    east, north = float(sample[VELOCITY_EAST]), float(sample[VELOCITY_NORTH])
    speed = hypot(east, north)
    values[CORE_INDEX["speed_mps"]] = speed
    values[CORE_INDEX["heading_rad"]] = np.arctan2(east, north) if speed >= NO_RATES_BELOW_MPS else 0.0
    values[CORE_INDEX["acceleration_forward_mps2"]] = sample[ACCELERATION]
    values[CORE_INDEX["yaw_rate_radps"]] = sample[YAW_RATE]
    return values

"""From octets to the local dynamic map: what a station makes of whatever arrives.

Basic safety messages are those of vehicles, personal ones say which kind of person sent them. A plain one of
a person is coasted by the shipped stop-and-go switch, whatever plain messages of vehicles are coasted by.

Nothing in the octets is trusted. What is no message is counted as malformed; a model of a profile that is not
held is left aside, and Part I alone is used.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import CodecError
from modelcast.core.geodesy import Origin, frame_constants
from modelcast.core.geodesy_kernels import places_of
from modelcast.core.kinds import PEOPLE
from modelcast.messages.bsm_batch import values_of_codes
from modelcast.messages.bsm_fields import CORE_INDEX
from modelcast.messages.field_columns import OctetArray
from modelcast.messages.mbc_update import UpdateReading
from modelcast.messages.mbc_wire import IDENTIFICATION_MESSAGE, decode_identification
from modelcast.messages.station_codec import StationCodec
from modelcast.models.bank import Bank
from modelcast.models.calibration import Calibration
from modelcast.models.profile import people_plain_bank
from modelcast.station.banks import BASELINE_BANK, profile_number_of
from modelcast.station.policy.neighbours_kernels import NeighbourTables, hear_each
from modelcast.station.receiver.deliveries import SHORT_ID, SUB_INTERVAL_S
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.station.receiver.plausibility import Plausibility

__all__ = ["Ears"]

_NOTHING = -1
_PLAIN = StationCodec.of(BASELINE_BANK, 0, "never")
"""Of a host that holds no profile."""

_MOTION = ("speed_mps", "heading_rad", "acceleration_forward_mps2", "yaw_rate_radps", "length_m", "width_m")


@dataclass(frozen=True)
class Ears:
    """How a station hears: the profiles it holds, and the map it keeps.

    Parameters
    ----------
    profiles
        Banks whose models it understands.
    expiry_s, plausibility, capacity, dt_s
        As in `LocalDynamicMap`.
    calibrations
        Of the banks' covariances, one mapping each; empty for none.
    """

    profiles: tuple[Bank, ...]
    expiry_s: float = 5.0
    plausibility: Plausibility | None = field(default_factory=Plausibility)
    _: KW_ONLY
    capacity: int = 2000
    dt_s: float = 0.1
    calibrations: tuple[Mapping[str, Calibration], ...] = ()

    @cached_property
    def map(self) -> LocalDynamicMap:
        """The map, for banks in the forms that messages carry; behind them people's plain messages' own."""
        carried = tuple(bank.carried().complete() for bank in self.profiles)
        return LocalDynamicMap(
            (*carried, people_plain_bank()),
            self.expiry_s,
            self.plausibility,
            capacity=self.capacity,
            dt_s=self.dt_s,
            calibrations=(*self.calibrations, {}) if self.calibrations else (),
        )

    @cached_property
    def _codecs(self) -> tuple[StationCodec, ...]:
        return tuple(
            StationCodec.of(carried, profile_number_of(bank), "never")
            for carried, bank in zip(self.map.profiles[:-1], self.profiles, strict=True)
        )

    def init(self) -> MapState:
        """A map that holds nothing."""
        return self.map.init()

    def hear(
        self,
        state: MapState,
        octets: Sequence[bytes],
        received_s: Sequence[float] | FloatArray,
        *,
        origin: Origin,
        minute_s: float = 0.0,
        tables: NeighbourTables | None = None,
        host: int = 0,
        own: Sequence[int] = (),
    ) -> tuple[IntArray, MapState]:
        """Take messages in: the `Receipt` of each, (K,), and the new state. The given one is used up.

        Parameters
        ----------
        state
            What is held.
        octets
            Frames, in order of arrival.
        received_s
            When each arrived, not falling, (K,) [s].
        origin
            Of the host's plane.
        minute_s
            Time at which some minute of UTC began [s].
        tables, host
            Neighbours that J2945/1 counts, and whose row is the host's; None for none.
        own
            Temporary ids of the host itself: what relays repeat of its own messages is `Receipt.REPEATED`.

        Raises
        ------
        ValueError
            Where times fall, or there is not one a frame.
        """
        receipts, states = self.hear_each(
            [state],
            [len(octets)],
            octets,
            received_s,
            origin=origin,
            minute_s=minute_s,
            tables=tables,
            hosts=[host],
            own=[own],
        )
        return receipts, states[0]

    def hear_each(
        self,
        states: Sequence[MapState],
        counts: Sequence[int],
        octets: Sequence[bytes],
        received_s: Sequence[float] | FloatArray,
        *,
        origin: Origin,
        minute_s: float = 0.0,
        tables: NeighbourTables | None = None,
        hosts: Sequence[int],
        own: Sequence[Sequence[int]],
    ) -> tuple[IntArray, list[MapState]]:
        """Let several hosts take messages in, host after host: as `hear` for each, but all are read at once.

        Parameters
        ----------
        states
            What each of H hosts holds; used up.
        counts
            How many of the messages are each host's, H, together K.
        octets
            Frames, those of each host in order of arrival.
        received_s
            When each arrived, not falling within a host's, (K,) [s].
        origin, minute_s, tables
            As for `hear`.
        hosts, own
            As ``host`` and ``own`` of `hear`, H.

        Raises
        ------
        ValueError
            Where times fall, or there is not one a frame.
        """
        arrived_s = np.asarray(received_s, dtype=np.float64)
        if arrived_s.shape != (len(octets),):
            raise ValueError(f"received_s must be ({len(octets)},), one a frame, got {arrived_s.shape}")
        receipts = np.full(len(octets), Receipt.MALFORMED, dtype=np.int64)
        frames, lengths = _side_by_side(octets)
        named = _message_ids(frames, lengths) == IDENTIFICATION_MESSAGE
        updates = np.flatnonzero(~named)
        fine, columns = self._updates(
            frames[updates], lengths[updates], arrived_s[updates], origin=origin, minute_s=minute_s
        )
        fine = updates[fine]
        ends = np.cumsum(counts).tolist()
        after: list[MapState] = []
        for state, count, end, host, mine in zip(states, counts, ends, hosts, own, strict=True):
            start = end - count
            # An identification counts its age from the update before it: what came before is taken in first.
            turns = np.flatnonzero(named[start + 1 : end] != named[start : end - 1]) + start + 1
            held = state
            for first, last in pairwise([start, *turns.tolist(), end]):
                if first == last:
                    continue
                if named[first]:
                    rows, heard = self._identifications(held, octets, arrived_s, range(first, last))
                else:
                    low, high = np.searchsorted(fine, (first, last))
                    rows = fine[low:high]
                    heard = Heard(**{name: column[low:high] for name, column in columns.items()})
                held.receipts[Receipt.MALFORMED] += last - first - rows.size
                is_mine = np.isin(heard.temporary_id, mine)
                if is_mine.any():
                    receipts[rows[is_mine]] = Receipt.REPEATED
                    held.receipts[Receipt.REPEATED] += int(is_mine.sum())
                    rows, heard = rows[~is_mine], heard.taken(np.flatnonzero(~is_mine))
                receipts[rows], held = self.map.hear(held, heard)
                if tables is not None:
                    _count(tables, host, heard, receipts[rows])
            after.append(held)
        return receipts, after

    def _updates(
        self, frames: OctetArray, lengths: IntArray, arrived_s: FloatArray, *, origin: Origin, minute_s: float
    ) -> tuple[IntArray, dict[str, Any]]:
        """Read safety messages, each with the first profile that knows it: rows of some; `Heard`'s fields."""
        profile = np.full(lengths.size, _NOTHING)
        parameters = np.full((lengths.size, self._widest), np.nan)
        in_use = np.zeros(lengths.size, dtype=np.int64)
        readings = [
            codec.decode(frames, lengths, received_s=arrived_s, minute_s=minute_s)
            for codec in self._codecs or (_PLAIN,)
        ]
        for place, read in enumerate(readings[: len(self._codecs)]):
            known = (read.reading == UpdateReading.MODEL) & (profile == _NOTHING)
            profile[known] = place
            parameters[known, : read.rows.parameters.shape[1]] = read.rows.parameters[known]
            in_use[known] = read.rows.in_use[known]
        read = readings[-1]  # of Part I all say the same
        fine = (read.reading != UpdateReading.FAULTY) & (read.reading != UpdateReading.INCOMPLETE)
        position_m = np.empty((lengths.size, 2))
        places_of(frame_constants(origin), np.ascontiguousarray(read.rows.place), position_m)
        plain = np.isin(read.kind, PEOPLE) & (profile == _NOTHING)
        profile[plain] = len(self._codecs)
        values = values_of_codes(read.core)
        stated = values[plain]
        speed = stated[:, CORE_INDEX["speed_mps"]]
        heading = np.nan_to_num(stated[:, CORE_INDEX["heading_rad"]])  # who stands may state none
        parameters[plain, :2] = np.stack([speed * np.sin(heading), speed * np.cos(heading)], axis=1)
        parameters[plain, 2] = np.nan_to_num(stated[:, CORE_INDEX["acceleration_forward_mps2"]])
        motion = {name: values[fine, CORE_INDEX[name]] for name in _MOTION}
        kind = np.where(profile == _NOTHING, HeardKind.PLAIN, HeardKind.UPDATE)
        return np.flatnonzero(fine), {
            "kind": kind[fine].astype(np.int64),
            "temporary_id": read.rows.vehicle[fine],
            "message_count": read.rows.message_count[fine],
            "t_s": read.rows.t_s[fine],
            "received_s": arrived_s[fine],
            "position_m": position_m[fine],
            "speed_mps": motion["speed_mps"],
            "heading_rad": motion["heading_rad"],
            "acceleration_mps2": motion["acceleration_forward_mps2"],
            "yaw_rate_radps": motion["yaw_rate_radps"],
            "profile": profile[fine],
            "in_use": in_use[fine],
            "parameters": parameters[fine],
            "length_m": motion["length_m"],
            "width_m": motion["width_m"],
            "user": read.kind[fine],
        }

    def _identifications(
        self, state: MapState, octets: Sequence[bytes], arrived_s: FloatArray, which: range
    ) -> tuple[IntArray, Heard]:
        """Read identifications; the age that each states counts from the update held of its sender."""
        fine: list[int] = []
        codes: list[tuple[int, int, int, float]] = []
        for row in which:
            try:
                one = decode_identification(octets[row])
            except CodecError:
                continue
            fine.append(row)
            codes.append((one.temporary_id, one.sequence, one.sub_model, one.age_s))
        table = np.array(codes, dtype=np.float64).reshape(-1, 4)
        taken = np.array(fine, dtype=np.int64)
        fit_s = self.map.fit_s(state, table[:, 0].astype(np.int64))
        unknown, nothing = np.full(taken.size, np.nan), np.full(taken.size, _NOTHING)
        return taken, Heard(
            np.full(taken.size, int(HeardKind.IDENTIFICATION)),
            table[:, 0].astype(np.int64),
            table[:, 1].astype(np.int64),
            t_s=np.where(np.isnan(fit_s), arrived_s[taken], fit_s + table[:, 3]),
            received_s=arrived_s[taken],
            position_m=np.full((taken.size, 2), np.nan),
            speed_mps=unknown,
            heading_rad=unknown,
            acceleration_mps2=unknown,
            yaw_rate_radps=unknown,
            profile=nothing,
            in_use=table[:, 2].astype(np.int64),
            parameters=np.full((taken.size, self._widest), np.nan),
            length_m=unknown,
            width_m=unknown,
            user=nothing,
        )

    @cached_property
    def _widest(self) -> int:
        """Most parameters of a bank."""
        return max((int(bank.offsets[-1]) for bank in self.map.profiles), default=0)


def _side_by_side(octets: Sequence[bytes]) -> tuple[OctetArray, IntArray]:
    """Frames as rows, zeros behind each, (K, L), and how many octets of each count, (K,)."""
    lengths = np.array([len(one) for one in octets], dtype=np.int64)
    frames = np.zeros((lengths.size, max(int(lengths.max(initial=0)), 2)), dtype=np.uint8)
    frames[np.arange(frames.shape[1]) < lengths[:, None]] = np.frombuffer(b"".join(octets), dtype=np.uint8)
    return frames, lengths


def _message_ids(frames: OctetArray, lengths: IntArray) -> IntArray:
    """Number of each frame's kind, -1 where there is none."""
    return np.where(lengths >= 2, 256 * frames[:, 0].astype(np.int64) + frames[:, 1], _NOTHING)


def _count(tables: NeighbourTables, host: int, heard: Heard, receipts: IntArray) -> None:
    """Enter the remotes whose messages were believed into the tables that vehicle density is counted from.

    A message of an instant already told is none: a relay's copy would count as a message that was not lost.
    """
    believed = receipts == Receipt.ACCEPTED
    told = np.flatnonzero(believed & (heard.kind != HeardKind.IDENTIFICATION))
    hear_each(
        *tables,
        np.full(told.size, host),
        heard.temporary_id[told] & SHORT_ID,
        heard.message_count[told],
        heard.received_s[told],
        np.ascontiguousarray(heard.position_m[told]),
        SUB_INTERVAL_S,
        np.empty(told.size, dtype=np.int64),
    )

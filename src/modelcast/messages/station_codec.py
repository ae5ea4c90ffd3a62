"""The messages of stations between content and octets, many at once.

They are basic safety messages, or personal ones of stations that are people. The content of a model update is
a row: who, how many messages, when, where as codes of latitude and
longitude, and the parameters of all sub-models with the one in use. What `StationCodec` writes and reads
again has the same bits as what the sender holds (`codes_kernels.quantise_parameters`).
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.core.exceptions import CodecError
from modelcast.core.kinds import Kind
from modelcast.messages import codes_kernels, update_kernels
from modelcast.messages.bsm import BsmCore
from modelcast.messages.bsm_batch import CORE_MEANING, codes_of_values
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX, LOCAL_REGION
from modelcast.messages.code_table import CodeTable, code_table
from modelcast.messages.field_columns import OctetArray
from modelcast.messages.field_kernels import FIRST, LAST
from modelcast.messages.fields import as_float
from modelcast.messages.mbc_codec import IDENTIFICATION_OCTETS
from modelcast.messages.mbc_profile import WireProfile, carries_all, plain_members
from modelcast.messages.mbc_update import UpdateMessage, UpdateReading, read_update, update_octets
from modelcast.messages.mbc_wire import (
    AGE,
    SEQUENCE,
    IdentificationMessage,
    decode_identification,
    encode_identification,
)
from modelcast.messages.message_heads import HEADS, head_table, heads_of_members
from modelcast.models.bank import Bank

__all__ = [
    "HeardUpdates",
    "IdentificationRows",
    "StationCodec",
    "UpdateRows",
    "coefficient_codes",
    "further_values",
]

_ID: Final = CORE_INDEX["temporary_id"]
_COUNT: Final = CORE_INDEX["message_count"]
_MARK: Final = CORE_INDEX["second_of_minute_s"]
_PLACE: Final = [CORE_INDEX["latitude_deg"], CORE_INDEX["longitude_deg"]]
_YAW_RATE: Final = CORE_INDEX["yaw_rate_radps"]
_SPEED: Final = codes_kernels.SPEED_PLACE
_HEADING: Final = codes_kernels.HEADING_PLACE
_NEEDED: Final = [_MARK, *_PLACE, _SPEED]


@dataclass(frozen=True, eq=False, slots=True)
class UpdateRows:
    """The content of model updates.

    Parameters
    ----------
    vehicle
        Temporary ids, (B,).
    message_count
        Messages of the sender so far, (B,); a message holds it modulo 128.
    t_s
        Instants of the fits, (B,) [s].
    place
        Codes of latitude and longitude, (B, 2), as `geodesy_kernels.state_place` gives them.
    in_use
        Index of the sub-model in use, (B,); of one that was heard -1 where it holds no model that is known.
    parameters
        Of all sub-models in turn, (B, P), as `CodeTable` names them.
    """

    vehicle: IntArray
    message_count: IntArray
    t_s: FloatArray
    _: KW_ONLY
    place: IntArray
    in_use: IntArray
    parameters: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class HeardUpdates:
    """Messages as a station understands them.

    Parameters
    ----------
    rows
        Their content; what the message does not carry is 0. Without a model the sub-model in use is the one
        that the bank coasts a plain message by where that may stand for it, else -1.
    core
        Part I as codes, or as much of it as a personal safety message states, (B, 25).
    kind
        `Kind` of road user that sent each, (B,).
    reading
        An `UpdateReading` each, (B,). Rows of those that are incomplete or faulty mean nothing.
    faults
        Row and fault of those that are faulty.
    """

    rows: UpdateRows
    core: IntArray
    kind: IntArray
    reading: IntArray
    faults: tuple[tuple[int, CodecError], ...]


@dataclass(frozen=True, eq=False, slots=True)
class IdentificationRows:
    """The content of identifications.

    Parameters
    ----------
    vehicle
        Temporary ids, (B,).
    message_count
        Count of the update that is spoken of, (B,); a message holds it modulo 128.
    in_use
        Index of the sub-model in use from now on, (B,).
    age_s
        Times since that update, (B,) [s]; in a message hundredths of a second.
    """

    vehicle: IntArray
    message_count: IntArray
    _: KW_ONLY
    in_use: IntArray
    age_s: FloatArray

    def encode(self) -> OctetArray:
        """Octets of frames, (B, 10).

        Raises
        ------
        ValueError
            Where a value has no code, or an identification is older than its update.
        """
        columns = (self.vehicle, self.message_count % (SEQUENCE.high + 1), self.in_use, self.age_s)
        frames = np.zeros((len(self.age_s), IDENTIFICATION_OCTETS), np.uint8)
        for row, (vehicle, count, in_use, age_s) in enumerate(
            zip(*(column.tolist() for column in columns), strict=True)
        ):
            if not age_s >= 0.0:
                raise ValueError(f"row {row}: an identification is no older than its update, got {age_s} s")
            message = IdentificationMessage(vehicle, count, sub_model=in_use, age=AGE.code_of(age_s))
            frames[row] = np.frombuffer(encode_identification(message), np.uint8)
        return frames

    @classmethod
    def decode(cls, frames: OctetArray) -> "IdentificationRows":
        """Content of frames.

        Parameters
        ----------
        frames
            Octets, (B, 10).

        Raises
        ------
        CodecError
            Where one is no identification.
        """
        read = [decode_identification(frame.tobytes()) for frame in frames]
        codes = np.array(
            [(one.temporary_id, one.sequence, one.sub_model, one.age) for one in read], np.int64
        ).reshape(-1, 4)
        return cls(codes[:, 0], codes[:, 1], in_use=codes[:, 2], age_s=codes[:, 3] / AGE.step[1])


@dataclass(frozen=True, eq=False, slots=True)
class StationCodec:
    """Model updates of one bank and profile.

    Parameters
    ----------
    profile
        The profile as messages name it.
    table
        The bank's codes.
    carries_all
        Whether the coefficients of all sub-models go out, or of the one in use alone.
    plain
        Sub-models with which a message is a plain one.
    plain_place
        The sub-model that such a message is coasted by, -1 for none.
    heads
        Place in `message_heads.HEADS` of an update's head, by the sub-model in use.
    kind
        Of the stations that send.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> codec = StationCodec.of(Bank((ConstantTurnRateAcceleration(), ConstantVelocity())), 5, "on-failure")
    >>> rows = UpdateRows(
    ...     np.array([7]),
    ...     np.array([300]),
    ...     np.array([4000.1]),
    ...     place=np.array([[420_000_000, -830_000_000]]),
    ...     in_use=np.array([0]),
    ...     parameters=np.array([[10.001, 0.0, 0.5, 0.0, 10.001, 0.0]]),
    ... )
    >>> frames, lengths = codec.encode(rows)
    >>> heard = codec.decode(frames, lengths, received_s=np.array([4000.3]))
    >>> heard.rows.parameters.round(9).tolist(), heard.rows.t_s.round(9).tolist(), lengths.tolist()
    ([[10.0, 0.0, 0.5, 0.0, 10.0, 0.0]], [4000.1], [47])
    """

    profile: WireProfile
    table: CodeTable
    carries_all: bool
    plain: tuple[bool, ...]
    plain_place: int = -1
    _: KW_ONLY
    heads: tuple[int, ...]
    kind: Kind = Kind.VEHICLE
    _wire: update_kernels.UpdateWire = field(init=False, repr=False)

    def __post_init__(self) -> None:
        table = self.table
        wire = update_kernels.UpdateWire(
            table.rows,
            table.offsets,
            table.wire,
            table.wire_offsets,
            head_table(),
            np.array(self.heads, np.int64),
            int(self.kind),
            np.array(self.plain),
            self.carries_all,
            LOCAL_REGION,
            self.profile.number,
        )
        object.__setattr__(self, "_wire", wire)

    @classmethod
    def of(cls, bank: Bank, number: int, identify: str, *, kind: Kind = Kind.VEHICLE) -> "StationCodec":
        """Codec of a bank.

        Parameters
        ----------
        bank
            Its sub-models, in any form.
        number
            Of its profile, `mbc_wire.profile_number`.
        identify
            The policy's rule, as `modelcast.station.policy.rules` names it.
        kind
            Of the stations that send; whoever hears hears all kinds.

        Raises
        ------
        ValueError
            As for `WireProfile`, `code_table` and `heads_of_members`.
        """
        together = carries_all(bank, identify)
        return cls(
            WireProfile.of(bank, number),
            code_table(bank),
            together,
            plain_members(bank, identify, kind),
            bank.plain_place,
            heads=heads_of_members(bank, kind, carries_all=together),
            kind=kind,
        )

    def codes(
        self, rows: UpdateRows, *, minute_s: float = 0.0, further: FloatArray | None = None
    ) -> IntArray:
        """Part I, then the codes of all parameters, (B, 25 + P).

        Parameters
        ----------
        rows
            The content.
        minute_s
            Time at which some minute of UTC began [s].
        further
            More values of Part I in SI units, (B, 25) or (1, 25) for all, not a number where not known:
            elevation, size, the motion where no sub-model has it. Of a vehicle that stands, the heading.

        Raises
        ------
        ValueError
            Where a value cannot be written, position, speed or heading are not known, or sub-models that are
            sent together disagree about Part I.
        """
        shape = (len(rows.t_s), len(CORE_FIELDS))
        values = np.array(np.broadcast_to(np.nan if further is None else further, shape))
        values[:, _COUNT] = rows.message_count % (SEQUENCE.high + 1)
        values[:, _ID] = rows.vehicle
        values[np.isnan(values[:, _YAW_RATE]), _YAW_RATE] = 0.0
        values[:, [_MARK, *_PLACE]] = np.nan
        core = codes_of_values(values)
        core[:, _MARK] = [codes_kernels.state_instant(t_s, minute_s) for t_s in rows.t_s.tolist()]
        core[:, _PLACE] = rows.place
        _check(core, _PLACE, "position")
        given_heading = core[:, _HEADING].copy()
        codes, _ = self.table.quantise(rows.parameters)
        in_use = owned(rows.in_use, np.int64)
        if in_use.size and not 0 <= in_use.min() <= in_use.max() < len(self.plain):
            raise ValueError(f"in_use must lie within 0..{len(self.plain) - 1}, got {rows.in_use}")
        table = self.table
        row, at = codes_kernels.motion_rows(table.rows, table.offsets, in_use, self.carries_all, codes, core)
        if row >= 0:
            raise ValueError(f"row {row}: {table.names[at]} is not that of Part I, which carries one for all")
        standing = (core[:, _SPEED] == 0) & (given_heading <= CORE_FIELDS[_HEADING].known_codes[1])
        core[standing, _HEADING] = given_heading[standing]
        _check(core, [_SPEED, _HEADING], "velocity")
        return np.concatenate([core, codes], axis=1)

    def encode(
        self, rows: UpdateRows, *, minute_s: float = 0.0, further: FloatArray | None = None
    ) -> tuple[OctetArray, IntArray]:
        """Octets of frames, (B, L), and how many of each count, (B,).

        Parameters
        ----------
        rows, minute_s, further
            As in `codes`.

        Raises
        ------
        ValueError
            As for `codes`.
        """
        codes = self.codes(rows, minute_s=minute_s, further=further)
        bits = sum(layout.bits for layout in self.profile.layouts)
        longest = max(update_octets(bits, HEADS[head]) for head in self.heads)
        frames = np.zeros((len(codes), longest), np.uint8)
        lengths = np.zeros(len(codes), np.int64)
        core, own = (
            owned(codes[:, : len(CORE_FIELDS)], np.int64),
            owned(codes[:, len(CORE_FIELDS) :], np.int64),
        )
        update_kernels.pack_updates(self._wire, owned(rows.in_use, np.int64), core, own, frames, lengths)
        return frames, lengths

    def decode(
        self, frames: OctetArray, lengths: IntArray, *, received_s: FloatArray, minute_s: float = 0.0
    ) -> HeardUpdates:
        """Content of basic and personal safety messages, whoever sent them.

        Parameters
        ----------
        frames
            Octets, one frame a row, (B, L).
        lengths
            How many of each row count, (B,).
        received_s
            When each arrived, (B,) [s]: its instant is taken within half a minute of it.
        minute_s
            Time at which some minute of UTC began [s].
        """
        size = len(lengths)
        core = np.zeros((size, len(CORE_FIELDS)), np.int64)
        codes = np.zeros((size, len(self.table.names)), np.int64)
        reading, in_use, kind = (np.zeros(size, np.int64) for _ in range(3))
        given = owned(frames, np.uint8), owned(lengths, np.int64)
        update_kernels.unpack_updates(self._wire, *given, reading, in_use, kind, core, codes)
        faults: list[tuple[int, CodecError]] = []
        for row in np.flatnonzero(reading == update_kernels.ELSE).tolist():
            core[row], codes[row], in_use[row], kind[row] = 0, 0, -1, Kind.VEHICLE
            try:
                received = read_update(
                    frames[row, : lengths[row]].tobytes(), {self.profile.number: self.profile}
                )
            except CodecError as fault:
                reading[row] = UpdateReading.FAULTY
                faults.append((row, fault))
                continue
            core[row], kind[row] = received.core.codes, received.kind
            reading[row] = received.reading
            if received.update is not None:
                in_use[row] = received.update.sub_model
                codes[row] = coefficient_codes(self.table, self.profile, received.update)
        known = (core >= CORE_MEANING[:, FIRST]) & (core <= CORE_MEANING[:, LAST])
        goes = known[:, _HEADING] | (core[:, _SPEED] == 0)  # who stands needs no heading
        complete = known[:, _NEEDED].all(axis=1) & goes
        reading[(reading != UpdateReading.FAULTY) & ~complete] = UpdateReading.INCOMPLETE
        in_use[in_use < 0] = self.plain_place if any(self.plain) else -1
        instants_s = np.empty(size)
        codes_kernels.instants_of(
            owned(core[:, _MARK], np.int64), owned(received_s), float(minute_s), instants_s
        )
        rows = UpdateRows(
            core[:, _ID],
            core[:, _COUNT],
            instants_s,
            place=core[:, _PLACE],
            in_use=in_use,
            parameters=self.table.decoded(core, codes),
        )
        return HeardUpdates(rows, core, kind, reading, tuple(faults))

    def message(self, codes: IntArray, in_use: int) -> UpdateMessage:
        """One update as codes on the wire.

        Parameters
        ----------
        codes
            A row of `codes`, (25 + P,).
        in_use
            Index of the sub-model in use.
        """
        own = codes[len(CORE_FIELDS) :][self.table.wire].tolist()
        bounds: list[int] = self.table.wire_offsets.tolist()
        carried = self.profile.carried(in_use, carries_all=self.carries_all)
        return UpdateMessage(
            BsmCore(tuple(codes[: len(CORE_FIELDS)].tolist())),
            in_use,
            carries_all=self.carries_all,
            codes=tuple(tuple(own[bounds[m] : bounds[m + 1]]) for m in carried),
        )


def further_values(values: Mapping[str, float | None]) -> FloatArray:
    """More values of Part I, as `StationCodec.codes` takes them, (1, 25).

    Parameters
    ----------
    values
        By the names of `CORE_FIELDS`, in SI units; None where not known.

    Raises
    ------
    ValueError
        Where a name is unknown.

    Examples
    --------
    >>> further_values({"length_m": 4.5})[0, -3:].tolist()
    [nan, nan, 4.5]
    """
    unknown = sorted(values.keys() - CORE_INDEX.keys())
    if unknown:
        raise ValueError(f"no field is called {unknown}; the fields are {list(CORE_INDEX)}")
    row = np.full((1, len(CORE_FIELDS)), np.nan)
    for name, value in values.items():
        row[0, CORE_INDEX[name]] = np.nan if value is None else as_float(value)
    return row


def coefficient_codes(table: CodeTable, profile: WireProfile, update: UpdateMessage) -> IntArray:
    """Codes of the coefficients that an update carries, at their parameters' places, (P,); else 0.

    Parameters
    ----------
    table, profile
        Of one bank.
    update
        As read.
    """
    codes = np.zeros(len(table.names), np.int64)
    carried = profile.carried(update.sub_model, carries_all=update.carries_all)
    for m, own in zip(carried, update.codes, strict=True):
        codes[table.wire[table.wire_offsets[m] : table.wire_offsets[m + 1]]] = own
    return codes


def _check(core: IntArray, columns: list[int], name: str) -> None:
    """Refuse rows in which a field of Part I stands for nothing."""
    known = (core[:, columns] >= CORE_MEANING[columns, FIRST]) & (
        core[:, columns] <= CORE_MEANING[columns, LAST]
    )
    if not known.all():
        raise ValueError(f"row {int(np.argmin(known.all(axis=1)))}: no {name} is known, and Part I needs one")

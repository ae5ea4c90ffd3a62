"""The basic safety message of SAE J2735, one at a time: octets to values and back.

Part I is understood field by field (`bsm_fields`). Part II, regional extensions and extension additions are
kept as octets, so that a message that was read can be written again to the same octets, whatever its sender
put into it. Whoever knows a regional extension encodes and decodes its octets on their own.

For many messages at once see `bsm_batch`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Final

from modelcast.core.argument_types import require_type
from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm_fields import (
    BASIC_SAFETY_MESSAGE,
    CORE_BITS,
    CORE_FIELDS,
    CORE_OCTETS,
    PREAMBLE_BITS,
)
from modelcast.messages.contents import PART_II, REGIONAL, Content
from modelcast.messages.field_table import FieldTable
from modelcast.messages.frame import check_additions, encode_frame, read_header, read_tail

__all__ = ["BasicSafetyMessage", "BsmCore", "decode_bsm", "encode_bsm", "encode_message"]

_TABLE: Final = FieldTable(CORE_FIELDS)
_MASKS: Final = tuple((1 << field.width_bits) - 1 for field in CORE_FIELDS)
_SHIFTS: Final = tuple(
    CORE_BITS - sum(field.width_bits for field in CORE_FIELDS[: i + 1]) for i in range(len(CORE_FIELDS))
)
_LOWS: Final = tuple(field.low for field in CORE_FIELDS)
_PUT: Final = tuple(zip(_LOWS, _SHIFTS, strict=True))
_TAKE: Final = tuple(zip(_SHIFTS, _MASKS, _LOWS, strict=True))
_SPARE_BITS: Final = 8 * CORE_OCTETS - PREAMBLE_BITS - CORE_BITS
_CORE_HEADER: Final = (BASIC_SAFETY_MESSAGE << 8 | CORE_OCTETS) << 8 * CORE_OCTETS
"""Message id and length of a frame that holds Part I alone, in front of it."""


@dataclass(frozen=True, slots=True)
class BsmCore:
    """Part I of a basic safety message, as the codes on the wire.

    Parameters
    ----------
    codes
        One whole number a field, in the order of `CORE_FIELDS`; NumPy's become Python's.

    Raises
    ------
    ValueError
        Where there are not as many codes as fields, or one is out of its range.

    Examples
    --------
    >>> values = {"message_count": 7, "temporary_id": 1, "speed_mps": 12.345, "yaw_rate_radps": 0.0}
    >>> core = BsmCore.from_values(values)
    >>> core.value("speed_mps"), core.value("latitude_deg")
    (12.34, None)
    """

    codes: tuple[int, ...]

    def __post_init__(self) -> None:
        codes = _TABLE.checked("codes", self.codes)
        if codes is not self.codes:
            object.__setattr__(self, "codes", codes)

    @classmethod
    def from_values(cls, values: Mapping[str, float | None]) -> "BsmCore":
        """Nearest codes of values in SI units.

        Parameters
        ----------
        values
            By the names of `CORE_FIELDS`; enumerations and bit strings as their codes. A field that is left
            out, None, or not a number becomes unavailable.

        Raises
        ------
        ValueError
            Where a name is unknown, a value is refused, or a field without a code for unavailable
            (``message_count``, ``temporary_id``, ``yaw_rate_radps``) is left out.
        """
        return cls(_TABLE.codes_of(values))

    def value(self, name: str) -> float | None:
        """Value of one field in SI units, None where unavailable or reserved.

        Parameters
        ----------
        name
            Our name of the field.

        Raises
        ------
        KeyError
            Where there is no such field.
        """
        return _TABLE.value_of(self.codes, name)

    def values(self) -> dict[str, float | None]:
        """Values of all fields in SI units, by name."""
        return _TABLE.values_of(self.codes)


@dataclass(frozen=True, slots=True)
class BasicSafetyMessage:
    """A basic safety message in its frame.

    Parameters
    ----------
    core
        Part I.
    part_ii
        Id (0 to 63) and octets of up to eight entries; empty where Part II is absent.
    regional
        Region id (0 to 255) and octets of up to four extensions; empty where there are none.
    additions
        Octets of extension additions of the message, None where absent: what a later edition may add.
    frame_additions
        The same of the frame.

    Raises
    ------
    ValueError
        Where there are too many entries, or an id or length is out of its range.
    """

    core: BsmCore
    _: KW_ONLY
    part_ii: tuple[Content, ...] = ()
    regional: tuple[Content, ...] = ()
    additions: tuple[bytes | None, ...] = ()
    frame_additions: tuple[bytes | None, ...] = ()

    def __post_init__(self) -> None:
        if not (self.part_ii or self.regional or self.additions or self.frame_additions):
            return
        PART_II.check(self.part_ii)
        REGIONAL.check(self.regional)
        check_additions("additions", self.additions)
        check_additions("frame_additions", self.frame_additions)


def encode_bsm(
    core: BsmCore,
    *,
    part_ii: Sequence[Content] = (),
    regional: Sequence[Content] = (),
    additions: Sequence[bytes | None] = (),
    frame_additions: Sequence[bytes | None] = (),
) -> bytes:
    """Octets of a basic safety message in its frame.

    Parameters
    ----------
    core, part_ii, regional, additions, frame_additions
        As in `BasicSafetyMessage`.

    Raises
    ------
    ValueError
        Where they cannot be written.

    Examples
    --------
    >>> core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0})
    >>> len(encode_bsm(core)), len(encode_bsm(core, regional=((128, bytes(20)),)))
    (40, 62)
    """
    try:
        codes = core.codes
    except AttributeError:
        require_type("core", core, BsmCore, remedy="give modelcast.BsmCore.from_values({...})")
        raise
    whole = sum([code - low << shift for code, (low, shift) in zip(codes, _PUT, strict=True)])
    if not (part_ii or regional or additions or frame_additions):
        # Preamble and padding are zero bits, and the header is always the same.
        return (_CORE_HEADER | whole << _SPARE_BITS).to_bytes(3 + CORE_OCTETS, "big")
    message = BasicSafetyMessage(
        core,
        part_ii=tuple(part_ii),
        regional=tuple(regional),
        additions=tuple(additions),
        frame_additions=tuple(frame_additions),
    )
    writer = BitWriter()
    preamble = bool(message.additions) << 2 | bool(message.part_ii) << 1 | bool(message.regional)
    writer.bits(preamble, PREAMBLE_BITS)
    writer.bits(whole, CORE_BITS)
    if message.part_ii:
        PART_II.write(writer, message.part_ii)
    if message.regional:
        REGIONAL.write(writer, message.regional)
    if message.additions:
        writer.additions(message.additions)
    return encode_frame(BASIC_SAFETY_MESSAGE, writer.octets(), message.frame_additions)


def encode_message(message: BasicSafetyMessage) -> bytes:
    """Octets of a message with all its parts.

    Parameters
    ----------
    message
        Any message; one that was read gives the octets it was read from.

    Raises
    ------
    ValueError
        Where the frame would be longer than `MAX_FRAME_OCTETS`.
    """
    return encode_bsm(
        message.core,
        part_ii=message.part_ii,
        regional=message.regional,
        additions=message.additions,
        frame_additions=message.frame_additions,
    )


def decode_bsm(data: bytes) -> BasicSafetyMessage:
    """Read a basic safety message in its frame.

    Parameters
    ----------
    data
        The octets of the frame, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are not such a message; the first fault in the order of the wire.

    Examples
    --------
    >>> core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0})
    >>> decode_bsm(encode_bsm(core)).core == core
    True
    """
    if isinstance(data, str):
        require_type("data", data, bytes, remedy="bytes.fromhex makes octets of hexadecimal digits")
    header = read_header(data, BASIC_SAFETY_MESSAGE)
    start, stop = header.start, header.stop
    if stop - start < CORE_OCTETS:
        raise _core_fault(data, start, stop)
    padded = int.from_bytes(data[start : start + CORE_OCTETS], "big")
    whole = padded >> _SPARE_BITS
    try:
        core = BsmCore(tuple([(whole >> shift & mask) + low for shift, mask, low in _TAKE]))
    except ValueError:
        raise _core_fault(data, start, stop) from None
    preamble = whole >> CORE_BITS
    part_ii: tuple[Content, ...] = ()
    regional: tuple[Content, ...] = ()
    additions: tuple[bytes | None, ...] = ()
    if preamble or padded != whole << _SPARE_BITS or stop - start != CORE_OCTETS:
        reader = BitReader(data, start, stop)
        reader.position += PREAMBLE_BITS + CORE_BITS
        if preamble & 2:
            part_ii = PART_II.read(reader)
        if preamble & 1:
            regional = REGIONAL.read(reader)
        if preamble & 4:
            additions = reader.additions()
        reader.finish()
    frame_additions = read_tail(data, header)
    return BasicSafetyMessage(
        core,
        part_ii=part_ii,
        regional=regional,
        additions=additions,
        frame_additions=frame_additions,
    )


def _core_fault(data: bytes, start: int, stop: int) -> CodecError:
    """Error that tells the first fault of a Part I that is known to have one."""
    reader = BitReader(data, start, stop)
    try:
        reader.bits(PREAMBLE_BITS)
        _TABLE.read(reader)
    except CodecError as fault:
        return fault
    return CodecError("Part I is cut short", reader.position)

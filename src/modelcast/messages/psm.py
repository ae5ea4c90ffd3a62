"""The personal safety message of SAE J2735, one at a time: octets to values and back.

What every message holds and all its optional parts are understood field by field (`psm_fields`). Regional
extensions and extension additions are kept as octets, as in a basic safety message. Refused by name are
extensions of ``position``, and what a later edition may put into a part: packed encoding rules cannot step
over what they do not know.

For many messages at once see `psm_batch`.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Final, NamedTuple, cast

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.contents import REGIONAL, Content
from modelcast.messages.field_table import FieldTable
from modelcast.messages.frame import check_additions, encode_frame, read_header, read_tail
from modelcast.messages.psm_fields import (
    OPTION_NAMES,
    PART_SHAPES,
    PERSON_FIELDS,
    PERSON_INDEX,
    PERSONAL_SAFETY_MESSAGE,
)
from modelcast.messages.shapes import Value

__all__ = ["PersonalSafetyMessage", "decode_psm", "encode_psm", "person_codes", "regional_bit"]

_TABLE: Final = FieldTable(PERSON_FIELDS)
_OPTIONS: Final = len(OPTION_NAMES)
_EXTENDED: Final = 1 << _OPTIONS
_REGIONAL: Final = 1
_BITS: Final = {shape.name: 1 << _OPTIONS - 1 - place for place, shape in enumerate(PART_SHAPES)}
_SHAPES: Final = {shape.name: shape for shape in PART_SHAPES}
_OWN: Final = ("acceleration", "path_prediction")
"""Parts that have a name of their own in a message; the others stand in its ``parts``."""

_ELEVATION: Final = PERSON_INDEX["elevation_m"]
_LATITUDE: Final = PERSON_INDEX["latitude_deg"]
_NO_ELEVATION: Final = PERSON_FIELDS[_ELEVATION].unavailable
_PREAMBLE_BITS: Final = 1 + _OPTIONS
_TYPE_BITS: Final = 1
"""Extension bit of the type of person."""
_POSITION_BITS: Final = 3
"""Extension bit, elevation present, regional extensions of the position present."""
_WITH_ELEVATION: Final = 2

_WINDOW_BITS: Final = 224
"""Bits of a message without optional parts, its elevation and the padding included."""
_PREAMBLE_AT: Final = _WINDOW_BITS - _PREAMBLE_BITS
_TYPE_AT: Final = _PREAMBLE_AT - _TYPE_BITS
_POSITION_AT: Final = _TYPE_AT - sum(field.width_bits for field in PERSON_FIELDS[:_LATITUDE]) - _POSITION_BITS

_CLOSED: Final = 1 << _TYPE_AT | (5 << _POSITION_AT)
"""What must be zero: extensions of the type of person, extensions and regional extensions of the position."""

_HEAD: Final = FieldTable(PERSON_FIELDS[:_LATITUDE])
_TAIL: Final = FieldTable(PERSON_FIELDS[_LATITUDE:])
_SHORT_TAIL: Final = FieldTable(PERSON_FIELDS[_LATITUDE:_ELEVATION] + PERSON_FIELDS[_ELEVATION + 1 :])


class _Layout(NamedTuple):
    """Where everything lies in the first bits of a message, with or without its elevation."""

    take: tuple[tuple[int, int, int], ...]
    """Shift within `_WINDOW_BITS`, mask and low of every field; the mask is 0 for what is left out."""
    put: tuple[tuple[int, int], ...]
    """Low and shift of the fields that are there."""
    flags: int
    """Bits of the position's preamble, in their place."""
    end_at: int
    """Bits of the window behind the fields."""
    octets: int
    """What a message takes that has no optional part."""


def _layout(*, elevation: bool) -> _Layout:
    rows: list[tuple[int, int, int]] = []
    shift = _TYPE_AT
    for place, field in enumerate(PERSON_FIELDS):
        width = 0 if place == _ELEVATION and not elevation else field.width_bits
        shift -= width + (_POSITION_BITS if place == _LATITUDE else 0)
        rows.append((shift, (1 << width) - 1, field.low))
    flags = (_WITH_ELEVATION if elevation else 0) << _POSITION_AT
    put = tuple((low, shift) for shift, mask, low in rows if mask)
    return _Layout(tuple(rows), put, flags, shift, (_WINDOW_BITS - shift + 7) // 8)


_LAYOUTS: Final = {elevation: _layout(elevation=elevation) for elevation in (True, False)}


@dataclass(frozen=True, slots=True)
class PersonalSafetyMessage:
    """A personal safety message in its frame.

    Parameters
    ----------
    codes
        One whole number a field, in the order of `PERSON_FIELDS`.
    has_elevation
        Whether the elevation is written; where not, its code is the one for unavailable.
    acceleration
        Codes of `ACCELERATION_FIELDS`; empty where absent.
    path_prediction
        Codes of `PATH_PREDICTION_FIELDS`; empty where absent.
    parts
        Our name and value of every other optional part that is there, in the order of `PART_SHAPES`; what a
        value is, `shapes` says.
    regional
        Region id (0 to 255) and octets of up to four extensions; empty where there are none.
    additions
        Octets of extension additions of the message, None where absent.
    frame_additions
        The same of the frame.

    Raises
    ------
    ValueError
        Where a count, a code, a part, an id or a length is out of its range.

    Examples
    --------
    >>> codes = person_codes({"basic_type": 1, "message_count": 7, "temporary_id": 1})
    >>> message = PersonalSafetyMessage(codes, parts=(("cross_state", 1), ("cluster_radius_m", 3)))
    >>> message.part("cross_state"), message.part("sizing"), len(encode_psm(message))
    (1, None, 32)
    """

    codes: tuple[int, ...]
    _: KW_ONLY
    has_elevation: bool = True
    acceleration: tuple[int, ...] = ()
    path_prediction: tuple[int, ...] = ()
    parts: tuple[tuple[str, Value], ...] = ()
    regional: tuple[Content, ...] = ()
    additions: tuple[bytes | None, ...] = ()
    frame_additions: tuple[bytes | None, ...] = ()

    def __post_init__(self) -> None:
        codes = _TABLE.checked("codes", self.codes)
        if codes is not self.codes:
            object.__setattr__(self, "codes", codes)
        if not self.has_elevation and codes[_ELEVATION] != _NO_ELEVATION:
            got = codes[_ELEVATION]
            raise ValueError(f"elevation_m: code must be {_NO_ELEVATION} where it is left out, got {got}")
        if self.acceleration or self.path_prediction or self.parts:
            for name in _OWN:
                given = getattr(self, name)
                if given:
                    object.__setattr__(self, name, _SHAPES[name].checked(given))
            object.__setattr__(self, "parts", _checked_parts(self.parts))
        if self.regional or self.additions or self.frame_additions:
            REGIONAL.check(self.regional)
            check_additions("additions", self.additions)
            check_additions("frame_additions", self.frame_additions)

    def value(self, name: str) -> float | None:
        """Value of a field of `PERSON_FIELDS` in SI units, None where unavailable or reserved.

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

    def part(self, name: str) -> Value | None:
        """Value of an optional part, None where it is absent.

        Parameters
        ----------
        name
            Our name of one of `PART_SHAPES`.

        Raises
        ------
        KeyError
            Where there is no such part.
        """
        if name in _OWN:
            return getattr(self, name) or None
        if name not in _SHAPES:
            raise KeyError(name)
        return dict(self.parts).get(name)


def _checked_parts(parts: tuple[tuple[str, Value], ...]) -> tuple[tuple[str, Value], ...]:
    """Parts with Python's own integers, each known and in its order."""
    names = [name for name, _ in parts]
    known = [name for name in _SHAPES if name not in _OWN]
    if [name for name in known if name in names] != names:
        raise ValueError(
            f"parts must be some of {', '.join(known)}, each once and in this order, got {names}"
        )
    return tuple((name, _SHAPES[name].checked(value)) for name, value in parts)


def person_codes(values: Mapping[str, float | None]) -> tuple[int, ...]:
    """Nearest codes of values in SI units.

    Parameters
    ----------
    values
        By the names of `PERSON_FIELDS`; the type of person as its code. What is left out, None, or not a
        number becomes unavailable.

    Raises
    ------
    ValueError
        Where a name is unknown, a value is refused, or ``message_count`` or ``temporary_id`` is left out.

    Examples
    --------
    >>> codes = person_codes({"basic_type": 2, "message_count": 7, "temporary_id": 1, "speed_mps": 1.4})
    >>> PersonalSafetyMessage(codes).value("speed_mps")
    1.4
    """
    return _TABLE.codes_of(values)


def encode_psm(message: PersonalSafetyMessage) -> bytes:
    """Octets of a personal safety message in its frame.

    Parameters
    ----------
    message
        Any; one that was read gives the octets it was read from.

    Raises
    ------
    ValueError
        Where the frame would be longer than `MAX_FRAME_OCTETS`.

    Examples
    --------
    >>> len(encode_psm(PersonalSafetyMessage(person_codes({"message_count": 7, "temporary_id": 1}))))
    31
    """
    layout = _LAYOUTS[message.has_elevation]
    codes = message.codes
    if not message.has_elevation:
        codes = codes[:_ELEVATION] + codes[_ELEVATION + 1 :]
    whole = layout.flags + sum(
        [code - low << shift for code, (low, shift) in zip(codes, layout.put, strict=True)]
    )
    parts = _present(message)
    if not (parts or message.regional or message.additions or message.frame_additions):
        size = layout.octets
        frame = (PERSONAL_SAFETY_MESSAGE << 8 | size) << 8 * size | whole >> _WINDOW_BITS - 8 * size
        return frame.to_bytes(3 + size, "big")
    preamble = _EXTENDED * bool(message.additions) + _REGIONAL * bool(message.regional)
    preamble += sum(_BITS[name] for name in parts)
    writer = BitWriter()
    writer.bits((whole | preamble << _PREAMBLE_AT) >> layout.end_at, _WINDOW_BITS - layout.end_at)
    _write_parts(writer, parts)
    if message.regional:
        REGIONAL.write(writer, message.regional)
    if message.additions:
        writer.additions(message.additions)
    return encode_frame(PERSONAL_SAFETY_MESSAGE, writer.octets(), message.frame_additions)


def regional_bit(message: PersonalSafetyMessage) -> int:
    """Bits of a message, without its frame, in front of its regional extensions.

    Parameters
    ----------
    message
        The message.

    Examples
    --------
    >>> regional_bit(PersonalSafetyMessage(person_codes({"message_count": 7, "temporary_id": 1})))
    220
    """
    writer = BitWriter()
    _write_parts(writer, _present(message))
    return _WINDOW_BITS - _LAYOUTS[message.has_elevation].end_at + writer.position


def _write_parts(writer: BitWriter, parts: Mapping[str, Value]) -> None:
    """Append optional parts in their order."""
    for shape in PART_SHAPES:
        if shape.name in parts:
            shape.write(writer, parts[shape.name])


def _present(message: PersonalSafetyMessage) -> dict[str, Value]:
    """Optional parts by name."""
    found: dict[str, Value] = dict(message.parts) if message.parts else {}
    if message.acceleration:
        found["acceleration"] = message.acceleration
    if message.path_prediction:
        found["path_prediction"] = message.path_prediction
    return found


def decode_psm(data: bytes) -> PersonalSafetyMessage:
    """Read a personal safety message in its frame.

    Parameters
    ----------
    data
        The octets of the frame, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are not such a message, or a later edition is needed to read it; the first fault in the
        order of the wire.

    Examples
    --------
    >>> message = PersonalSafetyMessage(person_codes({"message_count": 7, "temporary_id": 1}))
    >>> decode_psm(encode_psm(message)) == message
    True
    """
    header = read_header(data, PERSONAL_SAFETY_MESSAGE)
    start, stop = header.start, header.stop
    window = data[start : min(stop, start + _WINDOW_BITS // 8)]
    whole = int.from_bytes(window, "big") << _WINDOW_BITS - 8 * len(window)
    has_elevation = bool(whole >> _POSITION_AT & _WITH_ELEVATION)
    layout = _LAYOUTS[has_elevation]
    codes = tuple([(whole >> shift & mask) + low for shift, mask, low in layout.take])
    if stop - start < layout.octets or whole & _CLOSED or not _TABLE.holds(codes):
        raise _fault(data, start, stop)
    preamble = whole >> _PREAMBLE_AT
    if not preamble and stop - start == layout.octets and not whole & (1 << layout.end_at) - 1:
        additions = read_tail(data, header)
        return PersonalSafetyMessage(codes, has_elevation=has_elevation, frame_additions=additions)
    reader = BitReader(data, start, stop)
    reader.position += _WINDOW_BITS - layout.end_at
    parts = {shape.name: shape.read(reader) for shape in PART_SHAPES if preamble & _BITS[shape.name]}
    own = {name: parts.pop(name) for name in _OWN if name in parts}
    regional = REGIONAL.read(reader) if preamble & _REGIONAL else ()
    additions = reader.additions() if preamble & _EXTENDED else ()
    reader.finish()
    return PersonalSafetyMessage(
        codes,
        has_elevation=has_elevation,
        acceleration=cast("tuple[int, ...]", own.get("acceleration", ())),
        path_prediction=cast("tuple[int, ...]", own.get("path_prediction", ())),
        parts=tuple(parts.items()),
        regional=regional,
        additions=additions,
        frame_additions=read_tail(data, header),
    )


def _fault(data: bytes, start: int, stop: int) -> CodecError:
    """Error that tells the first fault of the fields that every message holds, known to have one."""
    reader = BitReader(data, start, stop)
    try:
        reader.bits(_PREAMBLE_BITS)
        _refuse(reader, "basicType of a later edition")
        _HEAD.read(reader)
        _refuse(reader, "extensions of position are not read")
        has_elevation = reader.bits(1)
        _refuse(reader, "regional extensions of position are not read")
        (_TAIL if has_elevation else _SHORT_TAIL).read(reader)
    except CodecError as fault:
        return fault
    return CodecError("the message is cut short", reader.position)


def _refuse(reader: BitReader, reason: str) -> None:
    begin = reader.position
    if reader.bits(1):
        raise CodecError(reason, begin)

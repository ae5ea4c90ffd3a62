"""The personal safety message of SAE J2735, one at a time: octets to values and back.

What every message holds, accelerations and the predicted path are understood field by field (`psm_fields`).
Regional extensions and extension additions are kept as octets, as in a basic safety message. All else is
refused by name.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from operator import index, le
from typing import Final

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm import Content
from modelcast.messages.bsm_fields import MAX_REGIONAL, REGION_ID
from modelcast.messages.fields import Field
from modelcast.messages.frame import check_additions, check_octets, encode_frame, read_header, read_tail
from modelcast.messages.psm_fields import (
    ACCELERATION_FIELDS,
    OPTION_NAMES,
    PATH_PREDICTION_FIELDS,
    PERSON_FIELDS,
    PERSON_INDEX,
    PERSONAL_SAFETY_MESSAGE,
    READ_OPTIONS,
)

__all__ = ["PersonalSafetyMessage", "decode_psm", "encode_psm", "person_codes"]

_OPTIONS: Final = len(OPTION_NAMES)
_BIT: Final = {name: 1 << _OPTIONS - 1 - place for place, name in enumerate(OPTION_NAMES)}
_EXTENDED: Final = 1 << _OPTIONS
_READ: Final = _EXTENDED | sum(_BIT[name] for name in READ_OPTIONS)
_ELEVATION: Final = PERSON_INDEX["elevation_m"]
_LATITUDE: Final = PERSON_INDEX["latitude_deg"]
_PREAMBLE_BITS: Final = 1 + _OPTIONS
_POSITION_BITS: Final = 3
"""Extension bit, elevation present, regional extensions of the position present."""
_TYPE_BITS: Final = 1
"""Extension bit of the type of person."""
_HEAD_BITS: Final = (
    _PREAMBLE_BITS + _TYPE_BITS + sum(f.width_bits for f in PERSON_FIELDS[:_LATITUDE]) + _POSITION_BITS
)
_WITH_ELEVATION: Final = 2


def _rest_bits(first: int, *, elevation: bool) -> int:
    """Bits of the fields from one on."""
    return sum(
        field.width_bits
        for place, field in enumerate(PERSON_FIELDS)
        if place >= first and (elevation or place != _ELEVATION)
    )


def _places(*, elevation: bool) -> tuple[tuple[int, int, int], ...]:
    """Shift, mask and low of every field; nothing is taken for an elevation that is left out."""
    rows: list[tuple[int, int, int]] = []
    for place, field in enumerate(PERSON_FIELDS):
        shift = _rest_bits(place + 1, elevation=elevation) + (_POSITION_BITS if place < _LATITUDE else 0)
        mask = 0 if place == _ELEVATION and not elevation else (1 << field.width_bits) - 1
        rows.append((shift, mask, field.low))
    return tuple(rows)


_LAYOUTS: Final = {
    elevation: (_places(elevation=elevation), _rest_bits(_LATITUDE, elevation=elevation))
    for elevation in (True, False)
}
_LOWS: Final = tuple(field.low for field in PERSON_FIELDS)
_HIGHS: Final = tuple(field.high for field in PERSON_FIELDS)
_PLAIN: Final = {int}
_NO_ELEVATION: Final = PERSON_FIELDS[_ELEVATION].unavailable


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
    regional
        Region id (0 to 255) and octets of up to four extensions; empty where there are none.
    additions
        Octets of extension additions of the message, None where absent.
    frame_additions
        The same of the frame.

    Raises
    ------
    ValueError
        Where a count, a code, an id or a length is out of its range.
    """

    codes: tuple[int, ...]
    _: KW_ONLY
    has_elevation: bool = True
    acceleration: tuple[int, ...] = ()
    path_prediction: tuple[int, ...] = ()
    regional: tuple[Content, ...] = ()
    additions: tuple[bytes | None, ...] = ()
    frame_additions: tuple[bytes | None, ...] = ()

    def __post_init__(self) -> None:
        codes = self.codes
        if not (
            len(codes) == len(PERSON_FIELDS)
            and set(map(type, codes)) == _PLAIN
            and all(map(le, _LOWS, codes))
            and all(map(le, codes, _HIGHS))
        ):  # NumPy's integers have no room for a message
            object.__setattr__(self, "codes", _checked("codes", PERSON_FIELDS, codes))
        if not self.has_elevation and self.codes[_ELEVATION] != _NO_ELEVATION:
            got = self.codes[_ELEVATION]
            raise ValueError(f"elevation_m: code must be {_NO_ELEVATION} where it is left out, got {got}")
        for name, fields in _GROUPS:
            given = getattr(self, name)
            if given:
                object.__setattr__(self, name, _checked(name, fields, given))
        if len(self.regional) > MAX_REGIONAL:
            raise ValueError(f"regional must have {MAX_REGIONAL} entries at most, got {len(self.regional)}")
        for number, octets in self.regional:
            REGION_ID.checked(number)
            check_octets("each of regional", octets)
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
        place = PERSON_INDEX[name]
        return PERSON_FIELDS[place].value_of(self.codes[place])


_GROUPS: Final = (("acceleration", ACCELERATION_FIELDS), ("path_prediction", PATH_PREDICTION_FIELDS))


def _checked(name: str, fields: tuple[Field, ...], codes: tuple[int, ...]) -> tuple[int, ...]:
    """Codes as Python's integers, each in its range."""
    if len(codes) != len(fields):
        raise ValueError(f"{name} must be {len(fields)}, got {len(codes)}")
    return tuple([field.checked(code) for field, code in zip(fields, codes, strict=True)])


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
    unknown = values.keys() - PERSON_INDEX.keys()
    if unknown:
        raise ValueError(f"no field is called {sorted(unknown)}; the fields are {list(PERSON_INDEX)}")
    return tuple(field.code_of(values.get(field.name)) for field in PERSON_FIELDS)


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
    places, rest_bits = _LAYOUTS[message.has_elevation]
    preamble = (
        (_EXTENDED if message.additions else 0)
        | (_BIT["accelSet"] if message.acceleration else 0)
        | (_BIT["pathPrediction"] if message.path_prediction else 0)
        | (_BIT["regional"] if message.regional else 0)
    )
    whole = preamble << _HEAD_BITS - _PREAMBLE_BITS + rest_bits
    whole |= (_WITH_ELEVATION if message.has_elevation else 0) << rest_bits
    whole += sum(
        [code - low << shift for code, (shift, mask, low) in zip(message.codes, places, strict=True) if mask]
    )
    width = _HEAD_BITS + rest_bits
    if not (preamble or message.frame_additions):
        size = (width + 7) // 8
        frame = (PERSONAL_SAFETY_MESSAGE << 8 | size) << 8 * size | whole << 8 * size - width
        return frame.to_bytes(3 + size, "big")
    writer = BitWriter()
    writer.bits(whole, width)
    if message.acceleration:
        _write(writer, ACCELERATION_FIELDS, message.acceleration)
    if message.path_prediction:
        writer.bits(0, 1)
        _write(writer, PATH_PREDICTION_FIELDS, message.path_prediction)
    if message.regional:
        writer.bits(len(message.regional) - 1, (MAX_REGIONAL - 1).bit_length())
        for number, octets in message.regional:
            writer.bits(index(number), REGION_ID.width_bits)
            writer.open_type(octets)
    if message.additions:
        writer.additions(message.additions)
    return encode_frame(PERSONAL_SAFETY_MESSAGE, writer.octets(), message.frame_additions)


def decode_psm(data: bytes) -> PersonalSafetyMessage:
    """Read a personal safety message in its frame.

    Parameters
    ----------
    data
        The octets of the frame, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are not such a message, or it holds a part that is not read; the error names the part.

    Examples
    --------
    >>> message = PersonalSafetyMessage(person_codes({"message_count": 7, "temporary_id": 1}))
    >>> decode_psm(encode_psm(message)) == message
    True
    """
    header = read_header(data, PERSONAL_SAFETY_MESSAGE)
    reader = BitReader(data, header.start, header.stop)
    begin = reader.position
    head = reader.bits(_HEAD_BITS)
    preamble = head >> _HEAD_BITS - _PREAMBLE_BITS
    if preamble & ~_READ:
        unread = [name for name in OPTION_NAMES if preamble & _BIT[name] and name not in READ_OPTIONS]
        raise CodecError(f"parts that are not read: {', '.join(unread)}", begin)
    if head >> _HEAD_BITS - _PREAMBLE_BITS - _TYPE_BITS & 1:
        raise CodecError("basicType of a later edition", begin + _PREAMBLE_BITS)
    position = head & (1 << _POSITION_BITS) - 1
    if position & ~_WITH_ELEVATION:
        raise CodecError("extensions of position are not read", reader.position - _POSITION_BITS)
    has_elevation = bool(position)
    places, rest_bits = _LAYOUTS[has_elevation]
    whole = head << rest_bits | reader.bits(rest_bits)
    codes = tuple([(whole >> shift & mask) + low for shift, mask, low in places])
    if not all(map(le, codes, _HIGHS)):
        _refuse_beyond(PERSON_FIELDS, codes, begin)
    acceleration = path_prediction = ()
    if preamble & _BIT["accelSet"]:
        acceleration = _read(reader, ACCELERATION_FIELDS)
    if preamble & _BIT["pathPrediction"]:
        if reader.bits(1):
            raise CodecError("extensions of pathPrediction are not read", reader.position - 1)
        path_prediction = _read(reader, PATH_PREDICTION_FIELDS)
    regional: tuple[Content, ...] = ()
    if preamble & _BIT["regional"]:
        count = reader.bits((MAX_REGIONAL - 1).bit_length()) + 1
        regional = tuple([(reader.bits(REGION_ID.width_bits), reader.open_type()) for _ in range(count)])
    additions = reader.additions() if preamble & _EXTENDED else ()
    reader.finish()
    return PersonalSafetyMessage(
        codes,
        has_elevation=has_elevation,
        acceleration=acceleration,
        path_prediction=path_prediction,
        regional=regional,
        additions=additions,
        frame_additions=read_tail(data, header),
    )


def _write(writer: BitWriter, fields: tuple[Field, ...], codes: tuple[int, ...]) -> None:
    for field, code in zip(fields, codes, strict=True):
        writer.bits(code - field.low, field.width_bits)


def _read(reader: BitReader, fields: tuple[Field, ...]) -> tuple[int, ...]:
    begin = reader.position
    codes = tuple([reader.bits(field.width_bits) + field.low for field in fields])
    _refuse_beyond(fields, codes, begin)
    return codes


def _refuse_beyond(fields: tuple[Field, ...], codes: tuple[int, ...], bit: int) -> None:
    for field, code in zip(fields, codes, strict=True):
        if code > field.high:
            raise CodecError(f"{field.standard_name} {code} is beyond {field.high}", bit)

"""What model-based communication adds to the wire: the model in a basic safety message, the identification.

A *model update* is a basic safety message, so that every legacy receiver reads it. Part I is the state, and
with it speed, heading, acceleration and yaw rate of every kinematic sub-model; its ``secMark`` is the
reference time and its ``msgCnt`` the model's sequence number. The rest of the model stands in the regional
extension `LOCAL_REGION` (`ModelExtension`). An *identification* is a frame of its own
(`IdentificationMessage`). ``mbc.asn`` says the same in ASN.1.

The coefficients are octets here: only who knows the profile knows their fields (`mbc_profile`).
"""

import hashlib
from dataclasses import KW_ONLY, dataclass
from typing import Final

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Field, Outside
from modelcast.messages.frame import encode_frame, read_header, read_tail

__all__ = [
    "AGE",
    "IDENTIFICATION_MESSAGE",
    "MAX_COEFFICIENT_OCTETS",
    "PROFILE",
    "PROFILE_OCTETS",
    "SEQUENCE",
    "SUB_MODEL",
    "TEMPORARY_ID",
    "IdentificationMessage",
    "ModelExtension",
    "decode_extension",
    "decode_identification",
    "encode_extension",
    "encode_identification",
    "profile_number",
]

PROFILE_OCTETS: Final = 3
"""Octets of a profile's SHA-256 that a message carries."""

PROFILE = Field(
    "profile", "profile", low=0, high=(1 << 8 * PROFILE_OCTETS) - 1, outside=Outside.REFUSE,
    meaning="first octets of the SHA-256 of the profile",
)  # fmt: skip
SUB_MODEL = Field(
    "sub_model", "subModel", low=0, high=7, outside=Outside.REFUSE,
    meaning="sub-model in use, its place in the profile's bank",
)  # fmt: skip
SEQUENCE = Field(
    "sequence", "sequence", low=0, high=127, outside=Outside.REFUSE,
    meaning="msgCnt of the model update that is spoken of",
)  # fmt: skip
AGE = Field(
    "age_s", "age", low=0, high=16383, step=(1, 100), unit="s",
    meaning="time since that update",
)  # fmt: skip
MAX_COEFFICIENT_OCTETS: Final = 127
"""Most octets of coefficients."""

IDENTIFICATION_MESSAGE: Final = 240
"""Message id of an identification: the first of the sixteen that J2735 leaves to tests (240 to 255)."""

TEMPORARY_ID: Final = CORE_FIELDS[1]
"""Temporary id of the sender, as in Part I."""
_LENGTH_BITS = MAX_COEFFICIENT_OCTETS.bit_length()


def profile_number(canonical: bytes) -> int:
    """Return what a message carries of a profile: the first octets of its SHA-256.

    Parameters
    ----------
    canonical
        The profile as canonical JSON.

    Examples
    --------
    >>> f"{profile_number(b'{}'):06x}"
    '44136f'
    """
    return int.from_bytes(hashlib.sha256(canonical).digest()[:PROFILE_OCTETS], "big")


@dataclass(frozen=True, slots=True)
class ModelExtension:
    """The model in a model update, its coefficients not looked into.

    Parameters
    ----------
    profile
        Number of the profile, `profile_number`.
    sub_model
        Sub-model in use, 0 to 7.
    carries_all
        Whether the coefficients are those of all sub-models in turn, or of the one in use alone.
    coefficients
        Up to `MAX_COEFFICIENT_OCTETS` octets.

    Raises
    ------
    ValueError
        Where a number is out of its range.
    """

    profile: int
    sub_model: int
    _: KW_ONLY
    carries_all: bool = False
    coefficients: bytes = b""

    def __post_init__(self) -> None:
        object.__setattr__(self, "profile", PROFILE.checked(self.profile))
        object.__setattr__(self, "sub_model", SUB_MODEL.checked(self.sub_model))
        if len(self.coefficients) > MAX_COEFFICIENT_OCTETS:
            raise ValueError(
                f"coefficients take {MAX_COEFFICIENT_OCTETS} octets at most, got {len(self.coefficients)}"
            )


@dataclass(frozen=True, slots=True)
class IdentificationMessage:
    """Another sub-model of an update is in use from now on, as codes on the wire.

    Parameters
    ----------
    temporary_id
        Of the sender, as in Part I.
    sequence
        ``msgCnt`` of the update it speaks of.
    sub_model
        Sub-model in use, 0 to 7.
    age
        Time since that update in hundredths of a second, 0 to 16383; the last stands for longer too.

    Raises
    ------
    ValueError
        Where a number is out of its range.
    """

    temporary_id: int
    sequence: int
    _: KW_ONLY
    sub_model: int
    age: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "temporary_id", TEMPORARY_ID.checked(self.temporary_id))
        object.__setattr__(self, "sequence", SEQUENCE.checked(self.sequence))
        object.__setattr__(self, "sub_model", SUB_MODEL.checked(self.sub_model))
        object.__setattr__(self, "age", AGE.checked(self.age))

    @property
    def age_s(self) -> float:
        """Time since the update [s]."""
        return self.age / 100


def encode_extension(extension: ModelExtension) -> bytes:
    """Octets of the extension's value, region id and length not included.

    Parameters
    ----------
    extension
        The model.

    Examples
    --------
    >>> encode_extension(ModelExtension(0x44136F, 2)).hex()
    '44136f4000'
    """
    writer = BitWriter()
    writer.bits(extension.profile, PROFILE.width_bits)
    writer.bits(extension.sub_model, SUB_MODEL.width_bits)
    writer.bits(extension.carries_all, 1)
    writer.bits(len(extension.coefficients), _LENGTH_BITS)
    writer.bits(int.from_bytes(extension.coefficients, "big"), 8 * len(extension.coefficients))
    return writer.octets()


def decode_extension(data: bytes) -> ModelExtension:
    """Read the extension's value.

    Parameters
    ----------
    data
        Its octets.

    Raises
    ------
    CodecError
        Where they are not a model.
    """
    reader = BitReader(data)
    profile = reader.bits(PROFILE.width_bits)
    sub_model = reader.bits(SUB_MODEL.width_bits)
    carries_all = bool(reader.bits(1))
    coefficients = reader.octets(reader.bits(_LENGTH_BITS))
    reader.finish()
    return ModelExtension(profile, sub_model, carries_all=carries_all, coefficients=coefficients)


def encode_identification(message: IdentificationMessage) -> bytes:
    """Octets of an identification in its frame: always ten.

    Parameters
    ----------
    message
        The identification.

    Examples
    --------
    >>> encode_identification(IdentificationMessage(1, 7, sub_model=2, age=130)).hex()
    '00f007000000010e8082'
    """
    writer = BitWriter()
    writer.bits(message.temporary_id, TEMPORARY_ID.width_bits)
    writer.bits(message.sequence, SEQUENCE.width_bits)
    writer.bits(message.sub_model, SUB_MODEL.width_bits)
    writer.bits(message.age, AGE.width_bits)
    return encode_frame(IDENTIFICATION_MESSAGE, writer.octets())


def decode_identification(data: bytes) -> IdentificationMessage:
    """Read an identification in its frame.

    Parameters
    ----------
    data
        The octets of the frame, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are not an identification.
    """
    header = read_header(data, IDENTIFICATION_MESSAGE)
    reader = BitReader(data, header.start, header.stop)
    temporary_id = reader.bits(TEMPORARY_ID.width_bits)
    sequence = reader.bits(SEQUENCE.width_bits)
    sub_model = reader.bits(SUB_MODEL.width_bits)
    age = reader.bits(AGE.width_bits)
    reader.finish()
    if read_tail(data, header):
        raise CodecError("extension additions, and an identification has none", 0)
    return IdentificationMessage(temporary_id, sequence, sub_model=sub_model, age=age)

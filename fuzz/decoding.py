"""What must hold for any octets: they are a message that encodes to the same octets, or a `CodecError`.

The octets are tried as a frame, a basic safety message, an identification, a signed message and an update.
"""

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import decode_bsm, encode_message
from modelcast.messages.frame import decode_frame, encode_frame
from modelcast.messages.mbc_codec import UpdateCodec, UpdateReading, WireProfile, read_update
from modelcast.messages.mbc_wire import (
    decode_extension,
    decode_identification,
    encode_extension,
    encode_identification,
)
from modelcast.messages.security.signed import decode_signed
from modelcast.models.payload import PayloadField, PayloadLayout

__all__ = ["PROFILES", "check"]

_FIELDS = (PayloadField("along_m", 0.1, bits=6), PayloadField("level", 1.0, bits=3, signed=False))
PROFILES = {
    number: WireProfile(number, (PayloadLayout(_FIELDS), PayloadLayout(), PayloadLayout(_FIELDS[:1])))
    for number in (0, 0x44136F)
}
"""Made-up profiles that are known: sub-models with a gap at the end, with nothing, and with one field."""


def check(data: bytes) -> bool:
    """Return whether octets are a basic safety message; fail where neither that nor properly refused.

    Parameters
    ----------
    data
        Any octets.
    """
    try:
        frame = decode_frame(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    else:
        assert encode_frame(frame.message_id, frame.value, frame.additions) == data
    _check_model(data)
    try:
        signed = decode_signed(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    else:
        assert signed.octets == data
    try:
        message = decode_bsm(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
        return False
    assert encode_message(message) == data
    for _, octets in message.regional:
        _check_model(octets)
    _check_update(data)
    return True


def _check_update(data: bytes) -> None:
    """Fail where a message's model neither encodes to the same octets nor is properly refused."""
    try:
        found = read_update(data, PROFILES)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
        return
    assert (found.update is not None) is (found.reading is UpdateReading.MODEL)
    if found.update is not None:
        assert found.profile is not None
        assert found.extension is not None
        again = read_update(UpdateCodec(found.profile).encode(found.update), PROFILES)
        assert (again.update, again.extension) == (found.update, found.extension)


def _check_model(data: bytes) -> None:
    """Fail where octets are neither a model or an identification nor properly refused."""
    try:
        assert encode_extension(decode_extension(data)) == data
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    try:
        assert encode_identification(decode_identification(data)) == data
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)

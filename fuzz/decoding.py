"""What must hold for any octets: they are a message that encodes to the same octets, or a `CodecError`.

The octets are tried as a frame, a basic safety message, an identification and the model in an update.
"""

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import decode_bsm, encode_message
from modelcast.messages.frame import decode_frame, encode_frame
from modelcast.messages.mbc_wire import (
    decode_extension,
    decode_identification,
    encode_extension,
    encode_identification,
)
from modelcast.messages.security.signed import decode_signed

__all__ = ["check"]


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
    return True


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

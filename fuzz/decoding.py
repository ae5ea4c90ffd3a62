"""What must hold for any octets: they are a message that encodes to the same octets, or a `CodecError`."""

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import decode_bsm, encode_message
from modelcast.messages.frame import decode_frame, encode_frame
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
    return True

"""What must hold for any octets: they are a message that encodes to the same octets, or a `CodecError`.

The octets go through every decoder of `modelcast.messages`: as a frame, a basic safety message and a personal
one (by the single codec and by the compiled batch), an update, an identification, the value of a model's
extension, a signed message and a certificate; and they are taken apart as messages one after another. What a
signed message holds goes through the same decoders again.
"""

import numpy as np

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import BasicSafetyMessage, decode_bsm, encode_message
from modelcast.messages.bsm_batch import decode_cores
from modelcast.messages.frame import decode_frame, encode_frame
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import ReceivedUpdate, UpdateReading, extension_of, read_update
from modelcast.messages.mbc_wire import (
    decode_extension,
    decode_identification,
    encode_extension,
    encode_identification,
)
from modelcast.messages.psm import decode_psm, encode_psm
from modelcast.messages.psm_batch import decode_people
from modelcast.messages.psm_document import person_document, person_of
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.sequence import parts_of
from modelcast.models.payload import PayloadField, PayloadLayout

__all__ = ["PROFILES", "check"]

_FIELDS = (PayloadField("along_m", 0.1, bits=6), PayloadField("level", 1.0, bits=3, signed=False))


def _wide(count: int, bits: int) -> PayloadLayout:
    return PayloadLayout(tuple(PayloadField(f"coefficient_{i}_m", 0.1, bits=bits) for i in range(count)))


PROFILES = {
    **{
        number: WireProfile(number, (PayloadLayout(_FIELDS), PayloadLayout(), PayloadLayout(_FIELDS[:1])))
        for number in (0, 0x44136F)
    },
    1: WireProfile(1, (_wide(6, 8), _wide(8, 12), _wide(8, 7), PayloadLayout(_FIELDS))),
}
"""Made-up profiles that are known: sub-models with a gap at the end, with none, with one or many fields."""


def check(data: bytes) -> bool:
    """Return whether octets are a basic safety message; fail where neither that nor properly refused.

    Parameters
    ----------
    data
        Any octets.
    """
    _check_envelope(data)
    assert b"".join(part.octets for part in parts_of(data)) == data
    return _check_payload(data)


def _check_envelope(data: bytes) -> None:
    """Fail where octets are neither a signed message or a certificate nor properly refused."""
    try:
        assert Certificate.from_octets(data).octets == data
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    try:
        signed = decode_signed(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    else:
        assert signed.octets == data
        _check_payload(signed.payload)


def _check_payload(data: bytes) -> bool:
    try:
        frame = decode_frame(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    else:
        assert encode_frame(frame.message_id, frame.value, frame.additions) == data
    _check_model(data)
    _check_person(data)
    message = _read(data)
    part_i = decode_cores(np.frombuffer(data, np.uint8)[None], np.array([len(data)]))
    assert -1 <= part_i.fault_bits[0] <= 8 * len(data)
    if message is None:
        return False
    assert part_i.fault_bits[0] == -1
    assert tuple(part_i.codes[0].tolist()) == message.core.codes
    assert encode_message(message) == data
    for _, octets in message.regional:
        _check_model(octets)
    return True


def _check_person(data: bytes) -> None:
    """Fail where octets are neither a personal safety message nor properly refused, singly and in batch."""
    batch = decode_people(np.frombuffer(data, np.uint8)[None], np.array([len(data)]))
    (fault,), (more,), (codes,) = batch.fault_bits, batch.more, batch.codes
    assert -1 <= fault <= 8 * len(data)
    try:
        message = decode_psm(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
        assert more or fault == refusal.offset_bits
        return
    assert fault == -1
    assert tuple(codes.tolist()) == message.codes
    assert bool(batch.has_elevation[0]) is message.has_elevation
    assert encode_psm(message) == data
    assert person_of(person_document(message)) == message


def _read(data: bytes) -> BasicSafetyMessage | None:
    """Return the message in octets; fail where its model neither encodes again nor is properly refused."""
    try:
        found = read_update(data, PROFILES)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
    else:
        _check_update(found)
        if isinstance(found.message, BasicSafetyMessage):
            return found.message
        assert encode_psm(found.message) == data
        return None
    try:
        return decode_bsm(data)
    except CodecError as refusal:
        assert 0 <= refusal.offset_bits <= 8 * len(data)
        return None


def _check_update(found: ReceivedUpdate) -> None:
    assert (found.update is not None) is (found.reading is UpdateReading.MODEL)
    if found.update is not None:
        assert found.profile is not None
        assert extension_of(found.update, found.profile) == found.extension
        codec = UpdateCodec(found.profile)
        assert codec.decode(codec.encode(found.update)) == found.update


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

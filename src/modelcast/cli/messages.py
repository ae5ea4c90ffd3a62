"""Messages of every kind that `decode` shows and `encode` writes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import RenderableType

    from modelcast.messages.contents import Content
    from modelcast.messages.update_document import HeldProfile, ModelReading

__all__ = ["Profiles", "Shown", "octets_of", "show"]

_SIGNED_HEAD = b"\x03\x81"
"""First octet of a signed message; a frame of so high a message id is none that is read here."""


@dataclass
class Profiles:
    """The profiles held, loaded only where a model asks for them.

    Parameters
    ----------
    path
        A profile's file, held beside those that ship with modelcast.
    """

    path: "Path | None" = None
    _held: "tuple[HeldProfile, ...] | None" = None

    def held(self) -> "tuple[HeldProfile, ...]":
        """Profiles known here.

        Raises
        ------
        ConfigError, DataFormatError
            Where the file is no profile, or not one that messages can carry.
        """
        from modelcast.cli.banks import profile_in_use
        from modelcast.messages.update_document import HeldProfile
        from modelcast.models.profile import shipped_profile
        from modelcast.models.shipped import SHIPPED

        if self._held is None:
            named = () if self.path is None else (HeldProfile.of(profile_in_use(self.path)),)
            shipped = (HeldProfile.of(shipped_profile(name)) for name in SHIPPED)
            self._held = (*named, *shipped)
        return self._held


@dataclass
class Shown:
    """A message as tables and as a document, and what is wrong with its inner parts."""

    tables: "list[RenderableType]"
    document: dict[str, Any]
    faults: list[str] = field(default_factory=list[str])
    fault: dict[str, Any] | None = None


def show(octets: bytes, place: str, profiles: Profiles, *, signed: bool = True) -> Shown:
    """Read a message of any kind.

    Parameters
    ----------
    octets
        The message.
    place
        Where it stands.
    profiles
        The profiles held.
    signed
        Whether it may be a signed message.

    Raises
    ------
    CodecError
        Where nothing of it can be shown.
    """
    from modelcast.core.exceptions import CodecError
    from modelcast.messages.bsm_fields import MESSAGE_ID
    from modelcast.messages.foreign_heads import head_name
    from modelcast.messages.identification_document import identification_document
    from modelcast.messages.ieee1609 import is_ieee1609_data
    from modelcast.messages.mbc_wire import IDENTIFICATION_MESSAGE, decode_identification
    from modelcast.messages.psm_fields import PERSONAL_SAFETY_MESSAGE
    from modelcast.messages.sequence import is_message
    from modelcast.report.model_messages import identification_table

    if signed and is_message(octets) and octets[:2] == _SIGNED_HEAD:
        return _signed(octets, place, profiles)
    if is_ieee1609_data(octets):
        return _unsecured(octets, place, profiles)
    name = head_name(octets)
    if name is not None:
        raise CodecError(f"{name}, and no message in it", 0)
    number = MESSAGE_ID.high & int.from_bytes(octets[:2], "big")
    if number == IDENTIFICATION_MESSAGE:
        message = decode_identification(octets)
        title = f"{place}: sub-model identification, {len(octets)} bytes"
        return Shown([identification_table(message, title)], identification_document(message))
    if number == PERSONAL_SAFETY_MESSAGE:
        return _psm(octets, place, profiles)
    return _bsm(octets, place, profiles)


def _psm(octets: bytes, place: str, profiles: Profiles) -> Shown:
    from modelcast.messages.psm import decode_psm
    from modelcast.messages.psm_document import person_document
    from modelcast.report.messages import person_table

    message = decode_psm(octets)
    title = f"{place}: personal safety message, {len(octets)} bytes"
    shown = Shown([person_table(message, title)], person_document(message))
    _model(shown, octets, message.regional, profiles)
    return shown


def _model(
    shown: Shown, octets: bytes, regional: "Sequence[Content]", profiles: Profiles
) -> "ModelReading | None":
    """Add the table of the model that a message carries, or what is wrong with it."""
    from modelcast.core.exceptions import CodecError
    from modelcast.messages.bsm_fields import LOCAL_REGION

    if LOCAL_REGION not in [region for region, _ in regional]:
        return None

    from modelcast.messages.update_document import read_model
    from modelcast.report.model_messages import model_table

    held = profiles.held()
    try:
        reading = read_model(octets, held)
    except CodecError as error:
        shown.faults.append(str(error))
        shown.fault = {"bit": error.offset_bits, "reason": error.reason}
        return None
    if reading is not None:
        shown.tables.append(model_table(reading))
    return reading


def _bsm(octets: bytes, place: str, profiles: Profiles) -> Shown:
    from modelcast.messages.bsm import decode_bsm
    from modelcast.messages.bsm_document import document_of
    from modelcast.messages.bsm_fields import LOCAL_REGION
    from modelcast.report.messages import message_table

    message = decode_bsm(octets)
    title = f"{place}: basic safety message, {len(octets)} bytes"
    shown = Shown([message_table(message, title)], document_of(message))
    reading = _model(shown, octets, message.regional, profiles)
    if shown.fault is not None:
        shown.document["fault"] = shown.fault
    if reading is not None:
        from modelcast.messages.update_document import model_document

        at = [region for region, _ in message.regional].index(LOCAL_REGION)
        shown.document["regional"][at] = {"id": LOCAL_REGION, "model": model_document(reading)}
    return shown


def _unsecured(octets: bytes, place: str, profiles: Profiles) -> Shown:
    from modelcast.core.exceptions import CodecError
    from modelcast.messages.ieee1609 import (
        content_name,
        read_unsecured_head,
        unsecured_document,
        unsecured_payload,
    )
    from modelcast.report.model_messages import title_line

    payload = unsecured_payload(octets)
    start = len(octets) - len(payload)
    name = content_name(octets)
    try:
        inner = show(payload, f"{place}, payload", profiles)
    except CodecError as error:
        reason = f"{name}, its payload from octet {start} on: {error.reason}"
        raise CodecError(reason, 8 * start + error.offset_bits) from error
    faults = [f"payload: {fault}" for fault in inner.faults]
    head = read_unsecured_head(octets)
    if head is not None and not head.shortest:
        faults.append("the length of the SPDU's payload is longer than it need be")
    title = title_line(f"{place}: {name}, {len(octets)} bytes, payload from octet {start} on")
    return Shown([title, *inner.tables], unsecured_document(inner.document), faults)


def _signed(octets: bytes, place: str, profiles: Profiles) -> Shown:
    from modelcast.core.exceptions import CodecError
    from modelcast.messages.security.document import signed_document
    from modelcast.messages.security.signed import decode_signed
    from modelcast.report.model_messages import envelope_table

    envelope = decode_signed(octets)
    title = f"{place}: signed message, {len(octets)} bytes"
    tables = [envelope_table(envelope, title)]
    try:
        inner = show(envelope.payload, f"{place}, payload", profiles, signed=False)
    except CodecError as error:
        document = {"message": "octets", "octets": envelope.payload.hex()}
        inner = Shown([], document, [str(error)])
    faults = [f"payload: {fault}" for fault in inner.faults]
    return Shown([*tables, *inner.tables], signed_document(envelope, inner.document), faults)


def octets_of(document: object, profiles: Profiles) -> bytes:
    """Octets of the message that a document describes, of any kind.

    Parameters
    ----------
    document
        As `Shown.document`.
    profiles
        The profiles held.

    Raises
    ------
    ValueError
        Where it describes none.
    """
    from modelcast.messages.bsm import encode_message
    from modelcast.messages.bsm_document import message_of
    from modelcast.messages.identification_document import IDENTIFICATION_KIND, identification_of
    from modelcast.messages.ieee1609 import UNSECURED_KIND, encode_unsecured
    from modelcast.messages.mbc_wire import encode_identification
    from modelcast.messages.psm import encode_psm
    from modelcast.messages.psm_document import PERSON_KIND, person_of
    from modelcast.messages.security.document import SIGNED_KIND, signed_of

    given = cast("Mapping[str, object]", document if isinstance(document, Mapping) else {})
    kind = given.get("message")
    if kind == IDENTIFICATION_KIND:
        return encode_identification(identification_of(given))
    if kind == PERSON_KIND:
        return encode_psm(person_of(given))
    if kind == SIGNED_KIND:
        return signed_of(given, _payload_octets(given, kind, profiles)).octets
    if kind == UNSECURED_KIND:
        return encode_unsecured(_payload_octets(given, kind, profiles))
    if not isinstance(document, Mapping):
        return encode_message(message_of(document))
    return encode_message(message_of(_without_models(given, profiles)))


def _payload_octets(given: Mapping[str, object], kind: object, profiles: Profiles) -> bytes:
    """Octets of the payload of a document that wraps another."""
    from modelcast.messages.digits import octets_of_digits
    from modelcast.messages.ieee1609 import UNSECURED_KIND

    found = given.get("payload")
    payload = cast("Mapping[str, object]", found if isinstance(found, Mapping) else {})
    if not payload or payload.get("message") == kind:
        article = "an" if kind == UNSECURED_KIND else "a"
        raise ValueError(f"the payload of {article} {kind} message is the document of another kind")
    if payload.get("message") == "octets":
        return octets_of_digits("octets", payload.get("octets"))
    return octets_of(payload, profiles)


def _without_models(given: Mapping[str, object], profiles: Profiles) -> dict[str, object]:
    """The same document with octets in place of models, without what is only told."""
    from modelcast.messages.bsm_document import message_of

    plain = {name: value for name, value in given.items() if name != "fault"}
    regional = plain.get("regional")
    entries = cast("list[object]", regional if isinstance(regional, list) else [])
    maps = [cast("Mapping[str, object]", entry) for entry in entries if isinstance(entry, Mapping)]
    if not any("model" in entry for entry in maps) or len(maps) != len(entries):
        return plain

    from modelcast.messages.update_document import octets_of_model

    core = message_of({name: value for name, value in plain.items() if name != "regional"}).core
    plain["regional"] = [
        {
            **{name: value for name, value in entry.items() if name != "model"},
            "octets": octets_of_model(entry["model"], core, profiles.held()).hex(),
        }
        if "model" in entry
        else entry
        for entry in maps
    ]
    return plain

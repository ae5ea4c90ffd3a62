"""The ASN.1 modules of the messages, and the second codec that they give.

modelcast encodes and decodes with its own codec. The modules say in the standard's notation what that codec
does, for people and for other tools; `reference_codec` compiles them with asn1tools, against which ours is
checked.
"""

from functools import cache
from importlib import resources
from typing import Any, Protocol, cast

from modelcast.messages.bsm import BasicSafetyMessage, BsmCore
from modelcast.messages.bsm_fields import BASIC_SAFETY_MESSAGE, CORE_FIELDS
from modelcast.messages.fields import Field

__all__ = [
    "ReferenceCodec",
    "code_of_item",
    "message_of_reference_value",
    "module_text",
    "reference_codec",
    "reference_decode",
    "reference_encode",
    "reference_value",
    "standard_item",
]


class ReferenceCodec(Protocol):
    """The two methods of an asn1tools specification that are used here."""

    def encode(self, name: str, data: object) -> bytes:
        """Octets of a value of a named type."""
        ...

    def decode(self, name: str, data: bytes) -> object:
        """Value of a named type in octets."""
        ...


def module_text() -> str:
    """Text of the ASN.1 modules: of the standard's messages, and of what modelcast adds to them."""
    folder = resources.files("modelcast.messages")
    names = ("bsm.asn", "psm.asn", "mbc.asn")
    return "\n".join(folder.joinpath(name).read_text(encoding="ascii") for name in names)


@cache
def reference_codec() -> ReferenceCodec:
    """asn1tools' codec for the module, in unaligned packed encoding rules.

    The one place that needs asn1tools: tests compare with it, and nothing that runs calls it.

    Examples
    --------
    >>> reference_codec().encode("MessageFrame", {"messageId": 20, "value": bytes(3)}).hex()
    '001403000000'
    """
    import asn1tools  # noqa: PLC0415 - a tool of the tests, not of those who run modelcast

    return cast("ReferenceCodec", asn1tools.compile_string(module_text(), "uper"))


def reference_value(message: BasicSafetyMessage) -> dict[str, Any]:
    """Value of the module's type ``BasicSafetyMessage`` as asn1tools takes it, derived from the fields.

    Parameters
    ----------
    message
        One without extension additions: the module has none.

    Raises
    ------
    ValueError
        Where it has some.
    """
    if message.additions or message.frame_additions:
        raise ValueError("the module has no extension additions: encode them with encode_message")
    core: dict[str, Any] = {}
    for field, code in zip(CORE_FIELDS, message.core.codes, strict=True):
        group, _, name = field.standard_name.rpartition(".")
        (core.setdefault(group, {}) if group else core)[name] = standard_item(field, code)
    value: dict[str, Any] = {"coreData": core}
    if message.part_ii:
        value["partII"] = [{"partII-Id": i, "partII-Value": octets} for i, octets in message.part_ii]
    if message.regional:
        value["regional"] = [{"regionId": i, "regExtValue": octets} for i, octets in message.regional]
    return value


def message_of_reference_value(value: Any) -> BasicSafetyMessage:
    """Message of a value of the module's type ``BasicSafetyMessage`` as asn1tools gives it.

    Parameters
    ----------
    value
        As `reference_value` makes it.
    """
    codes: list[int] = []
    for field in CORE_FIELDS:
        item = value["coreData"]
        for name in field.standard_name.split("."):
            item = item[name]
        codes.append(code_of_item(field, item))
    return BasicSafetyMessage(
        BsmCore(tuple(codes)),
        part_ii=tuple((one["partII-Id"], one["partII-Value"]) for one in value.get("partII", ())),
        regional=tuple((one["regionId"], one["regExtValue"]) for one in value.get("regional", ())),
    )


def standard_item(field: Field, code: int) -> Any:
    """A code as asn1tools takes it.

    Parameters
    ----------
    field
        The field.
    code
        Its code.
    """
    if field.choices:
        return field.choices[code]
    if field.flags:
        width = len(field.flags)
        return (code << -width % 8).to_bytes((width + 7) // 8, "big"), width
    return code.to_bytes(4, "big") if field.name == "temporary_id" else code


def code_of_item(field: Field, item: Any) -> int:
    """Code of what asn1tools gives.

    Parameters
    ----------
    field
        The field.
    item
        As `standard_item` makes it.
    """
    if field.choices:
        return field.choices.index(item)
    if field.flags:
        octets, width = item
        return int.from_bytes(octets, "big") >> -width % 8
    return int.from_bytes(item, "big") if field.name == "temporary_id" else item


def reference_encode(message: BasicSafetyMessage) -> bytes:
    """Octets that asn1tools makes of a message.

    Parameters
    ----------
    message
        One without extension additions.
    """
    inner = reference_codec().encode("BasicSafetyMessage", reference_value(message))
    return reference_codec().encode("MessageFrame", {"messageId": BASIC_SAFETY_MESSAGE, "value": inner})


def reference_decode(data: bytes) -> BasicSafetyMessage:
    """Message that asn1tools finds in octets; what it raises on others is its own affair.

    Parameters
    ----------
    data
        Octets of a basic safety message in its frame, without extension additions.
    """
    frame: Any = reference_codec().decode("MessageFrame", data)
    return message_of_reference_value(reference_codec().decode("BasicSafetyMessage", frame["value"]))

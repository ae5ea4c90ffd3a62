"""The ASN.1 module of the messages, and the second codec that it gives.

modelcast encodes and decodes with its own codec. The module says in the standard's notation what that codec
does, for people and for other tools; `reference_codec` compiles it with asn1tools, against which ours is
checked.
"""

from functools import cache
from importlib import resources
from typing import Protocol, cast

import asn1tools  # pyright: ignore[reportMissingImports]

__all__ = ["ReferenceCodec", "module_text", "reference_codec"]


class ReferenceCodec(Protocol):
    """The two methods of an asn1tools specification that are used here."""

    def encode(self, name: str, data: object) -> bytes:
        """Octets of a value of a named type."""
        ...

    def decode(self, name: str, data: bytes) -> object:
        """Value of a named type in octets."""
        ...


def module_text() -> str:
    """Text of the ASN.1 module."""
    return resources.files("modelcast.messages").joinpath("bsm.asn").read_text(encoding="ascii")


@cache
def reference_codec() -> ReferenceCodec:
    """asn1tools' codec for the module, in unaligned packed encoding rules.

    Examples
    --------
    >>> reference_codec().encode("MessageFrame", {"messageId": 20, "value": bytes(3)}).hex()
    '001403000000'
    """
    return cast("ReferenceCodec", asn1tools.compile_string(module_text(), "uper"))

"""What turns messages into octets and back."""

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

from modelcast.core.arrays import FloatArray, IntArray

__all__ = ["AbstractCodec"]

Message = TypeVar("Message")


class AbstractCodec(ABC, Generic[Message]):
    """One kind of message as octets: singly for nodes and people, in batch for simulations.

    A codec has no state. Its batch methods say what `encode` and `decode` would do to many messages, without
    making the octets: `quantise` what a receiver would hold, `sizes` how many octets it takes.
    """

    __slots__ = ()

    @abstractmethod
    def encode(self, message: Message) -> bytes:
        """Octets of a message.

        Parameters
        ----------
        message
            What to write.

        Raises
        ------
        ValueError
            Where a part of it cannot be written.
        """

    @abstractmethod
    def decode(self, data: bytes) -> Message:
        """Message in octets; writing it again gives the same octets.

        Parameters
        ----------
        data
            The octets of one message, no more and no fewer.

        Raises
        ------
        CodecError
            Where they are not such a message. No other error comes out, whatever the octets are.
        """

    @abstractmethod
    def quantise(self, parameters: FloatArray) -> FloatArray:
        """Numbers that a receiver holds after decoding, (B, P) in SI units.

        Parameters
        ----------
        parameters
            Numbers that a sender encodes, (B, P) in SI units; not a number where not known.

        Raises
        ------
        ValueError
            Where a number cannot be written.
        """

    @abstractmethod
    def sizes(self, parameters: FloatArray) -> IntArray:
        """Octets of each message, (B,).

        Parameters
        ----------
        parameters
            As in `quantise`.
        """

"""One client's requests and their answers, octets for octets; no socket in here."""

from typing import Any, final

from modelcast.core.version import package_version
from modelcast.node.serving.schema import FrameError, Schema, named_values, step_protocol
from modelcast.runtime.external.exchange import SessionSettings, Step
from modelcast.runtime.external.refusal import FieldError
from modelcast.runtime.external.senders import MakeSender, sender_of
from modelcast.runtime.external.session import Session

__all__ = ["Conversation"]


@final
class Conversation:
    """Answers requests, each by one message.

    Parameters
    ----------
    make
        Gives what stations of each kind send, and when, from the settings that a client asks for.

    Examples
    --------
    >>> spoken = step_protocol()
    >>> talk = Conversation()
    >>> answer, ends = talk.answer(spoken.pack("hello", {"protocol": 1, "slots": 4}))
    >>> spoken.unpack(answer, "server")[0], ends
    ('welcome', False)
    >>> answer, ends = talk.answer(b"no map")
    >>> spoken.unpack(answer, "server")[1]["field"], ends
    ('frame', True)
    """

    def __init__(self, make: MakeSender = sender_of) -> None:
        self._make = make
        self._spoken: Schema = step_protocol()
        self._session: Session | None = None

    @property
    def begun(self) -> bool:
        """Whether there is a session: hello was welcome."""
        return self._session is not None

    def answer(self, octets: bytes) -> tuple[bytes, bool]:
        """The answer to a request, and whether the conversation ends with it.

        Parameters
        ----------
        octets
            Whatever came; nothing in them is trusted.
        """
        try:
            name, values = self._spoken.unpack(octets, "client")
            answer = self._answered(name, values)
            return self._spoken.pack(self._spoken.messages[name].answer, answer), False
        except FrameError as error:
            return self.refusal(FieldError("frame", error, "a map of MessagePack"), ends=True), True
        except FieldError as error:
            return self.refusal(error, ends=False), False

    def refusal(self, error: FieldError, *, ends: bool) -> bytes:
        """The message that refuses a request.

        Parameters
        ----------
        error
            Why.
        ends
            Whether the session ends with it.
        """
        values = {"field": error.field, "value": error.value, "expected": error.expected}
        return self._spoken.pack("error", {**values, "text": str(error), "ends": ends})

    def _answered(self, name: str, values: dict[str, Any]) -> dict[str, Any]:
        """Fields of the answer."""
        if name == "hello":
            return self._begin(values)
        if self._session is None:
            raise FieldError("type", name, "hello first")
        if name == "step":
            return named_values(self._session.step(Step(**values)))
        if name == "map":
            return named_values(self._session.believe(values["host"], values["t_s"]))
        return named_values(self._session.warnings(values["host"], values["applications"]))

    def _begin(self, values: dict[str, Any]) -> dict[str, Any]:
        if self._session is not None:
            raise FieldError("type", "hello", "another message: the session has begun")
        protocol = values.pop("protocol")
        if protocol != self._spoken.protocol:
            raise FieldError("protocol", protocol, f"{self._spoken.protocol}, the only one spoken here")
        settings = SessionSettings(**values)
        self._session = Session(settings, self._make)
        return {"protocol": protocol, "version": package_version(), "sender": settings.sender}

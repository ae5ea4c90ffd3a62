"""A client of the step protocol: the session of `modelcast serve` as if it were in this process."""

import socket
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self, final

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.node.serving.framing import LENGTH_BYTES, framed, length_of
from modelcast.node.serving.schema import FrameError, named_values, step_protocol
from modelcast.runtime.external.exchange import HostBeliefs, HostWarnings, Sent, SessionSettings, Step
from modelcast.runtime.external.refusal import FieldError

__all__ = ["StepClient"]

_LOOPBACK = "127.0.0.1"


@final
class StepClient:
    """A session of a server; its methods are those of `modelcast.runtime.external.session.Session`.

    The session ends by `close`, by the server, and by any request that was not answered as it must be, as
    after `timeout_s` or an interrupt: the answer may come later, and must not be taken for that to the next
    request. Only a `FieldError` leaves it as it was.

    Parameters
    ----------
    settings
        How the session begins.
    path
        Of the server's socket.
    port
        The server's port on this machine, instead.
    timeout_s
        Longest wait for an answer [s]; None for ever. The first step may wait for compiled code.

    Raises
    ------
    ValueError
        Where there is not exactly one of path and port.
    FieldError
        Where the server refuses a setting.
    OSError
        Where nobody listens there, or the server has no room.
    """

    def __init__(
        self,
        settings: SessionSettings,
        *,
        path: str | None = None,
        port: int | None = None,
        timeout_s: float | None = None,
    ) -> None:
        if (path is None) == (port is None):
            raise ValueError("give path or port, one of the two")
        if path is not None:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            place: Any = path
        else:
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            place = (_LOOPBACK, port)
        self._spoken = step_protocol()
        try:
            self._socket.settimeout(timeout_s)
            self._socket.connect(place)
            hello = {"protocol": self._spoken.protocol, **named_values(settings)}
            self.server_version: str = self._ask("hello", hello, self._is_spoken)["version"]
            """Of modelcast at the other end."""
        except BaseException:
            self.close()
            raise

    def step(self, step: Step) -> Sent:
        """Tell all stations at one time and what was received; returns what they send.

        Parameters
        ----------
        step
            As for `Session.step`.

        Raises
        ------
        FieldError
            Where the server refuses it; the session goes on as if it had not been asked.
        ConnectionError
            Where the session has ended, or ends by this request.
        TimeoutError
            Where no answer came in time; the session has ended.
        """

        def fits(sent: dict[str, Any]) -> None:
            _require("vehicle", np.isin(sent["vehicle"], step.vehicle).all(), "names who is not there")
            _require("length", sent["length"].sum() == len(sent["octets"]), "does not add up to the octets")
            _require("receipt", sent["receipt"].size == received, "is not one for each reception")

        received = step.receiver.size
        return Sent(**self._ask("step", named_values(step), fits))

    def believe(self, hosts: IntArray, t_s: float) -> HostBeliefs:
        """What hosts believe of all their remotes.

        Parameters
        ----------
        hosts, t_s
            As for `Session.believe`.

        Raises
        ------
        FieldError, ConnectionError, TimeoutError
            As for `step`.
        """

        def fits(beliefs: dict[str, Any]) -> None:
            _require("host", np.isin(beliefs["host"], hosts).all(), "names who was not asked for")

        return HostBeliefs(**self._ask("map", {"host": hosts, "t_s": float(t_s)}, fits))

    def warnings(self, hosts: IntArray, applications: Sequence[str]) -> HostWarnings:
        """What safety applications say to hosts at the newest step.

        Parameters
        ----------
        hosts, applications
            As for `Session.warnings`.

        Raises
        ------
        FieldError, ConnectionError, TimeoutError
            As for `step`.
        """

        def fits(warned: dict[str, Any]) -> None:
            _require("host", np.isin(warned["host"], hosts).all(), "names who was not asked for")
            known = warned["application"] < len(applications)
            _require("application", known.all(), "is none that was asked for")

        asked = {"host": hosts, "applications": list(applications)}
        return HostWarnings(**self._ask("warnings", asked, fits))

    def close(self) -> None:
        """End the session."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _is_spoken(self, welcome: dict[str, Any]) -> None:
        _require("protocol", welcome["protocol"] == self._spoken.protocol, f"is not {self._spoken.protocol}")

    def _ask(
        self, name: str, values: dict[str, Any], fits: Callable[[dict[str, Any]], None]
    ) -> dict[str, Any]:
        """The fields of the answer to a request; without one that fits it the session is over."""
        if self._socket.fileno() < 0:
            raise ConnectionAbortedError("the session has ended: begin another by a new StepClient")
        request = framed(self._spoken.pack(name, values))
        try:
            answer, refused = self._answer_to(name, request)
            if not refused:
                fits(answer)
        except BaseException:
            self.close()
            raise
        if refused:
            raise FieldError(answer["field"], answer["value"], answer["expected"])
        return answer

    def _answer_to(self, name: str, request: bytes) -> tuple[dict[str, Any], bool]:
        """The fields of the message after a request, and whether that was refused."""
        self._socket.sendall(request)
        try:
            length = length_of(self._read(LENGTH_BYTES), self._spoken.frame_bytes)
            kind, answer = self._spoken.unpack(self._read(length), "server")
        except (FrameError, FieldError) as error:
            raise ConnectionAbortedError(f"what the server said is no message: {error}") from error
        if kind not in {"error", self._spoken.messages[name].answer}:
            raise ConnectionAbortedError(f"the server answered {name} by {kind}: the session has ended")
        if kind == "error" and answer["ends"]:
            raise ConnectionAbortedError(answer["text"])
        return answer, kind == "error"

    def _read(self, count: int) -> bytes:
        octets, at = bytearray(count), 0
        view = memoryview(octets)
        while at < count:
            got = self._socket.recv_into(view[at:])
            if not got:
                raise ConnectionResetError("the server ended the session")
            at += got
        return bytes(octets)


def _require(field: str, holds: object, what: str) -> None:
    """End the session where an answer is not one to what was asked."""
    if not holds:
        raise ConnectionAbortedError(f"what the server said is no answer: {field} {what}")

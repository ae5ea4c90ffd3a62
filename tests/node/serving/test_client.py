"""Claims about the client: an answer is that to its own request, or the session is over."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")

from modelcast.node.serving.client import StepClient
from modelcast.node.serving.conversation import Conversation
from modelcast.node.serving.framing import framed
from modelcast.node.serving.schema import step_protocol
from modelcast.runtime.external.exchange import SessionSettings, Step
from modelcast.runtime.external.refusal import FieldError

SPOKEN = step_protocol()
SETTINGS = SessionSettings(1)
HERE = Step(0.0, np.array([1]), position_m=np.zeros((1, 2)))
LATER = Step(0.1, np.array([1]), position_m=np.zeros((1, 2)))


@contextmanager
def answered(path: Path, change: Callable[[bytes], bytes]) -> Iterator[str]:
    """A server of one session whose frames after the welcome are changed."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(path))
        listening.listen(1)

        def serve() -> None:
            own, _ = listening.accept()
            with own, own.makefile("rb") as stream:
                talk, changed = Conversation(), framed
                while head := stream.read(4):
                    answer, _ = talk.answer(stream.read(int.from_bytes(head, "little")))
                    with suppress(BrokenPipeError):  # the client has gone
                        own.sendall(changed(answer))
                    changed = change

        thread = threading.Thread(target=serve)
        thread.start()
        yield str(path)
        thread.join(30.0)
        assert not thread.is_alive()


NO_ANSWERS: dict[str, bytes] = {
    "answered step by warned": framed(
        SPOKEN.pack(
            "warned",
            {"t_s": 0.0} | dict.fromkeys(SPOKEN.messages["warned"].fields.keys() - {"t_s"}, np.empty(0)),
        )
    ),
    "no message: a frame of 0 octets": bytes(4),
    "no message: a frame of 4294967295": b"\xff" * 4,
    "no message: no map": framed(b"\xc1"),
    "no message: type must be one of": framed(SPOKEN.pack("map", {"t_s": 0.0, "host": np.empty(0)})),
    "no message: t_s must be there": framed(SPOKEN.pack("sent", {})),
    "all is over": framed(
        SPOKEN.pack("error", {"field": "x", "value": "", "expected": "", "text": "all is over", "ends": True})
    ),
}


@pytest.mark.parametrize("told", NO_ANSWERS)
def test_what_is_no_answer_to_the_request_ends_the_session(told: str, tmp_path: Path) -> None:
    with (
        answered(tmp_path / "s", lambda _: NO_ANSWERS[told]) as path,
        StepClient(SETTINGS, path=path, timeout_s=30.0) as client,
    ):
        with pytest.raises(ConnectionAbortedError, match=told):
            client.step(HERE)
        for call in (lambda: client.step(LATER), lambda: client.believe(np.array([1]), 0.0)):
            with pytest.raises(ConnectionError, match="the session has ended: begin another"):
                call()


def changed(**values: object) -> Callable[[bytes], bytes]:
    """What changes fields of an answer, and leaves it a message."""

    def change(answer: bytes) -> bytes:
        name, told = SPOKEN.unpack(answer, "server")
        return framed(SPOKEN.pack(name, told | values))

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"vehicle": np.array([77])}, "vehicle names who is not there"),
        ({"length": np.array([1])}, "length does not add up"),
        ({"receipt": np.zeros(2)}, "receipt is not one for each reception"),
    ],
)
def test_a_message_that_does_not_fit_the_request_ends_the_session(
    change: dict[str, object], told: str, tmp_path: Path
) -> None:
    with (
        answered(tmp_path / "s", changed(**change)) as path,
        StepClient(SETTINGS, path=path, timeout_s=30.0) as client,
        pytest.raises(ConnectionAbortedError, match=f"no answer: {told}"),
    ):
        client.step(HERE)


def test_no_number_is_wrapped_on_its_way_to_the_server(tmp_path: Path) -> None:
    with (
        answered(tmp_path / "s", framed) as path,
        StepClient(SETTINGS, path=path, timeout_s=30.0) as client,
    ):
        client.step(HERE)
        with pytest.raises(FieldError, match=r"host must be within 0 to 4294967295, got -1"):
            client.believe(np.array([-1]), 0.0)
        assert client.believe(np.array([1]), 0.0).host.size == 0


def test_after_a_time_out_no_late_answer_is_taken_for_another(tmp_path: Path) -> None:
    """A second is enough for a welcome that needs nothing more to be loaded."""
    late = threading.Event()
    Conversation().answer(SPOKEN.pack("hello", {"protocol": 1, "slots": 1}))

    def delayed(answer: bytes) -> bytes:
        assert late.wait(30.0)
        return framed(answer)

    with (
        answered(tmp_path / "s", delayed) as path,
        StepClient(SETTINGS, path=path, timeout_s=1.0) as client,
    ):
        with pytest.raises(TimeoutError):
            client.step(HERE)
        late.set()
        with pytest.raises(ConnectionError, match="the session has ended"):
            client.step(LATER)


def test_a_refused_field_leaves_the_session_as_it_was(tmp_path: Path) -> None:
    with (
        answered(tmp_path / "s", framed) as path,
        StepClient(SETTINGS, path=path, timeout_s=30.0) as client,
    ):
        client.step(HERE)
        with pytest.raises(FieldError, match="t_s must be more than the last"):
            client.step(HERE)
        assert client.step(LATER).t_s == 0.1
    with pytest.raises(ConnectionError, match="the session has ended"):
        client.step(LATER)
